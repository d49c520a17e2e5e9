//! What is to be solved, in the scene's units; checked once, refused with the name of the field.

mod check;
mod error;
mod feature;
mod share;
mod template;

pub use check::{not_negative, positive};
pub use error::ProblemError;
pub use feature::Feature;
pub use share::ShareError;
pub use template::{PACKED, Template, TemplateError, TemplateKind};

use crate::grid::solids::Surfaces;
use crate::grid::{Boundary, Grid, Share};
use crate::words::named;

/// How density is carried (mathematics section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// Third-order upwind interpolation to faces (Leonard 1979), mass preserving: the paper's.
    Quick,
    /// Central interpolation: keeps the 2-norm too, but ripples at edges.
    Central,
    /// Back-tracing with linear interpolation (Stam 1999), for comparison.
    SemiLagrangian,
    /// Third order where the density is smooth (Koren 1993), monotone: no value leaves 0 .. max. Mass preserving.
    #[default]
    Limited,
}

impl Scheme {
    /// The smoothness of forces that goes with it, in cells: limited transport carries an edge as sharp as it was, so that fine forces
    /// have nothing to gain. The other schemes are the paper's, with the paper's price.
    #[must_use]
    pub const fn smoothness(self) -> f64 {
        match self {
            Self::Limited => 2.5,
            Self::Quick | Self::Central | Self::SemiLagrangian => 0.0,
        }
    }
}

named!(Scheme { Quick = "quick", Central = "central", SemiLagrangian = "semi_lagrangian", Limited = "limited" });

/// The density transport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advection {
    /// The operator.
    pub scheme: Scheme,
    /// The series is cut at the first term below this times max rho_0; earlier while the direct method searches.
    pub tolerance: f64,
}

impl Default for Advection {
    fn default() -> Self {
        Self {
            scheme: Scheme::default(),
            tolerance: 1e-5,
        }
    }
}

/// Smoke that is made on the way from step `from` to step `to`, in a shape that [`Solver`](crate::Solver) takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// The last step without it.
    pub from: usize,
    /// The last step that it adds to.
    pub to: usize,
    /// How much it adds.
    pub supply: Supply,
    /// The velocity that its smoke comes with, in length / time: the flow between its cells is taken to it while it emits.
    pub velocity: Option<[f64; 3]>,
}

/// How much an emitter adds where its shape is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supply {
    /// So much density at every step.
    Rate(f64),
    /// What is missing of this density.
    Target(f64),
}

/// A control problem without its densities, which [`Solver`](crate::Solver) takes one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Problem<'a> {
    /// Cells along each axis: two or three numbers from 4 to 4096.
    pub cells: &'a [usize],
    /// How each axis ends.
    pub boundary: &'a [Boundary],
    /// Longest side of the box.
    pub length: f64,
    /// Time step.
    pub dt: f64,
    /// Steps N, at least 2.
    pub steps: usize,
    /// Steps of the keyframes, ascending, from 2 to N; a free flow needs none.
    pub keyframes: &'a [usize],
    /// What the data term of each keyframe is multiplied by; 1 where there is no number.
    pub keyframe_weights: &'a [f64],
    /// Whether every keyframe has a region to be matched in: a factor of the error from 0 to 1, cell by cell.
    pub keyframe_regions: bool,
    /// Smoke that is made on the way.
    pub emitters: &'a [Emitter],
    /// Whether there are solid cells, which [`Solver::set_solids`](crate::Solver::set_solids) takes.
    pub solids: bool,
    /// Acceleration of the flow where the density is 1, in length / time^2: up, where smoke rises.
    pub buoyancy: [f64; 3],
    /// Simple fields of which the force is made, where it is.
    pub templates: &'a [Template],
    /// Step from which no force acts: the flow is simulated from there on. All keyframes are at it or before.
    pub release: Option<usize>,
    /// What the force's price is multiplied by at some steps, ascending; linear in its logarithm between them.
    pub schedule: &'a [(usize, f64)],
    /// Whether force may act only here and there, by a mask that [`Solver::set_mask`](crate::Solver::set_mask) takes.
    pub mask: bool,
    /// Viscosity nu of the flow, 0 or more, in length^2 / time: a term nu C^T C v of the momentum equation.
    pub viscosity: f64,
    /// Whether the flow slips along walls and obstacles, or sticks to them, by its viscosity.
    pub slip: bool,
    /// Weight r of the force.
    pub force_weight: f64,
    /// Smoothness of the force, in cells, 0 or more: with s this many cell sizes, its price is r/2 sum <u, (1 + s^2 C^T C) u>, so that
    /// forces finer than s are dear. 0 is the paper's price; by default [`Scheme::smoothness`], where the method can price curls.
    pub smoothness: Option<f64>,
    /// Filters m of the metric; by default the largest with 2^(m-1) <= max(n) / 4.
    pub filters: Option<usize>,
    /// Whether keyframes are scaled to the mass of the source.
    pub match_mass: bool,
    /// The density transport.
    pub advection: Advection,
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
    /// Which of the ranks this program is, where several share the box: see [`exec::ranks`](crate::exec::ranks).
    pub share: Option<Share>,
}

/// Cells along an axis.
pub const CELLS: core::ops::RangeInclusive<usize> = 4..=4096;
/// Most steps.
pub const MAX_STEPS: usize = 100_000;
/// Most filters.
pub const MAX_FILTERS: usize = 12;
/// Largest smoothness of the force, in cells: beyond it little is left to steer by.
pub const MAX_SMOOTHNESS: f64 = 64.0;

impl<'a> Problem<'a> {
    /// Everything else by default: a box of side 1, steps of length 1 up to the last keyframe (0 without any), r = 1000, no viscosity.
    #[must_use]
    pub fn new(cells: &'a [usize], boundary: &'a [Boundary], keyframes: &'a [usize]) -> Self {
        Self {
            cells,
            boundary,
            length: 1.0,
            dt: 1.0,
            steps: keyframes.last().copied().unwrap_or(0),
            keyframes,
            keyframe_weights: &[],
            keyframe_regions: false,
            emitters: &[],
            solids: false,
            buoyancy: [0.0; 3],
            templates: &[],
            release: None,
            schedule: &[],
            mask: false,
            viscosity: 0.0,
            slip: true,
            force_weight: 1e3,
            smoothness: None,
            filters: None,
            match_mass: true,
            advection: Advection::default(),
            projection_tolerance: 1e-5,
            share: None,
        }
    }
}

impl Problem<'_> {
    /// The finest grid, in box lengths, or this rank's part of it.
    #[must_use]
    pub fn grid(&self) -> Grid {
        Grid::new(self.cells, self.boundary).shared(self.share)
    }

    /// Whether a side of the box is open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.boundary.iter().any(|end| end.is_open())
    }

    /// What the flow meets.
    #[must_use]
    pub fn surfaces(&self) -> Surfaces {
        Surfaces {
            obstacles: self.solids,
            stick: !self.slip,
        }
    }

    /// Filters m of the metric.
    #[must_use]
    pub fn filters(&self) -> usize {
        let largest = self.cells.iter().copied().max().unwrap_or(1);
        self.filters.unwrap_or(1 + (largest / 4).max(1).ilog2() as usize)
    }

    /// Slots T = N - 1 that the trajectories of v and w have.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.steps - 1
    }

    /// Fields of cells that a solve is given beside the source: keyframes, their regions, shapes of emitters, the mask.
    #[must_use]
    pub fn fields(&self) -> usize {
        self.keyframes.len() * (1 + usize::from(self.keyframe_regions))
            + self.emitters.len()
            + usize::from(self.mask)
    }

    /// The part that is controlled: up to the release, if there is one.
    #[must_use]
    pub fn controlled(&self) -> Self {
        Self {
            steps: self.release.unwrap_or(self.steps),
            release: None,
            ..*self
        }
    }

    /// The templates in scaled numbers, each ending where the force does.
    pub fn scaled_templates(&self) -> impl Iterator<Item = Template> + Clone {
        let (units, slots) = (self.units(), self.controlled().slots());
        self.templates.iter().map(move |template| Template {
            to: template.to.min(slots),
            ..template.scaled(self.length, units.force)
        })
    }

    /// Whether each emitter pushes its smoke, 1 or 0, and its velocity in scaled numbers; nothing where none does.
    pub fn scaled_jets(&self) -> impl Iterator<Item = [f64; 4]> + Clone {
        let (unit, dims) = (self.units().velocity, self.cells.len());
        let any = self.emitters.iter().any(|emitter| emitter.velocity.is_some());
        let emitters = self.emitters.iter().filter(move |_| any);
        emitters.map(move |emitter| match emitter.velocity {
            None => [0.0; 4],
            Some([x, y, z]) => [1.0, x / unit, y / unit, if dims == 2 { 0.0 } else { z / unit }],
        })
    }

    /// The acceleration of buoyancy in scaled numbers, where the density is 1.
    #[must_use]
    pub fn scaled_buoyancy(&self) -> [f64; 3] {
        self.buoyancy.map(|b| b / self.units().force)
    }

    /// From scaled numbers (dt = length = 1) to the scene's.
    #[must_use]
    pub fn units(&self) -> Units {
        Units::of(self.length, self.dt)
    }

    /// The viscosity in scaled numbers, nu dt / length^2.
    #[must_use]
    pub fn scaled_viscosity(&self) -> f64 {
        self.viscosity * self.dt / (self.length * self.length)
    }

    /// s^2 in scaled numbers, with 0 where no smoothness is asked for, in which a cell of the finest grid is as long as the box over its most cells.
    #[must_use]
    pub fn scaled_smoothing(&self) -> f64 {
        let cells = self.cells.iter().copied().max().unwrap_or(1);
        let s = self.smoothness.unwrap_or(0.0) / cells as f64;
        s * s
    }

    /// The weight r in scaled numbers, r length^2 / dt^4.
    #[must_use]
    pub fn scaled_force_weight(&self) -> f64 {
        self.force_weight * self.units().force * self.units().force
    }
}

/// The scene's units, in scaled ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Of velocities: length / dt.
    pub velocity: f64,
    /// Of forces: length / dt^2.
    pub force: f64,
}

impl Units {
    /// Of a box so long, in steps of dt.
    #[must_use]
    pub fn of(length: f64, dt: f64) -> Self {
        Self {
            velocity: length / dt,
            force: length / (dt * dt),
        }
    }

    /// The scene's weight of the force that is r' in scaled numbers: r = r' dt^4 / length^2.
    #[must_use]
    pub fn force_weight(self, scaled: f64) -> f64 {
        scaled / (self.force * self.force)
    }

    /// The scene's penalty of ADMM that is K' in scaled numbers: K = K' dt^2 / length^2.
    #[must_use]
    pub fn penalty(self, scaled: f64) -> f64 {
        scaled / (self.velocity * self.velocity)
    }
}
