//! A problem that owns its lists, which the core's [`Problem`] borrows.

use core::ops::RangeInclusive;
use thurible_core::grid::Share;
use thurible_core::{Advection, Boundary, Emitter, Problem, Template};

/// Lengths and times with which single precision holds a flow.
pub const UNITS: RangeInclusive<f64> = 1e-15..=1e15;

/// The owned form of the core's [`Problem`], which borrows its lists.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedProblem {
    /// Cells per axis.
    pub cells: Vec<usize>,
    /// Boundary per axis.
    pub boundary: Vec<Boundary>,
    /// Steps of the keyframes, ascending.
    pub keyframes: Vec<usize>,
    /// What the data term of each keyframe is multiplied by.
    pub keyframe_weights: Vec<f64>,
    /// Whether every keyframe has a region to be matched in.
    pub keyframe_regions: bool,
    /// Smoke that is made on the way.
    pub emitters: Vec<Emitter>,
    /// Whether there are solid cells.
    pub solids: bool,
    /// Acceleration of the flow where the density is 1.
    pub buoyancy: [f64; 3],
    /// Simple fields of which the force is made, where it is.
    pub templates: Vec<Template>,
    /// Step from which no force acts.
    pub release: Option<usize>,
    /// What the force's price is multiplied by at some steps.
    pub schedule: Vec<(usize, f64)>,
    /// Whether force may act only here and there.
    pub mask: bool,
    /// Number of time steps N.
    pub steps: usize,
    /// The longest side of the box.
    pub length: f64,
    /// Length of a step.
    pub dt: f64,
    /// Kinematic viscosity nu.
    pub viscosity: f64,
    /// Whether the flow slips along walls and obstacles.
    pub slip: bool,
    /// Weight r of the force.
    pub force_weight: f64,
    /// Smoothness of the force in cells, or `None` for the default.
    pub smoothness: Option<f64>,
    /// Number m of Gaussian filters, or `None` for the default.
    pub filters: Option<usize>,
    /// Whether keyframes take the mass of the source.
    pub match_mass: bool,
    /// How density is carried.
    pub advection: Advection,
    /// Relative tolerance of the projection.
    pub projection_tolerance: f64,
    /// Which of the ranks this program is, where several share the box.
    pub share: Option<Share>,
}

impl OwnedProblem {
    /// A box of walls with the core's defaults; N is the step of the last keyframe, 0 if there is none.
    pub fn new(cells: Vec<usize>, keyframes: Vec<usize>) -> Self {
        let boundary = vec![Boundary::Wall; cells.len()];
        let Problem {
            length,
            dt,
            steps,
            buoyancy,
            viscosity,
            slip,
            force_weight,
            smoothness,
            filters,
            match_mass,
            advection,
            projection_tolerance,
            ..
        } = Problem::new(&cells, &boundary, &keyframes);
        Self {
            cells,
            boundary,
            keyframes,
            keyframe_weights: Vec::new(),
            keyframe_regions: false,
            emitters: Vec::new(),
            solids: false,
            buoyancy,
            templates: Vec::new(),
            release: None,
            schedule: Vec::new(),
            mask: false,
            steps,
            length,
            dt,
            viscosity,
            slip,
            force_weight,
            smoothness,
            filters,
            match_mass,
            advection,
            projection_tolerance,
            share: None,
        }
    }

    /// The same without anything that steers: its flow is simulated.
    pub fn unsteered(&self) -> Self {
        Self {
            keyframes: Vec::new(),
            keyframe_weights: Vec::new(),
            keyframe_regions: false,
            templates: Vec::new(),
            release: None,
            schedule: Vec::new(),
            mask: false,
            ..self.clone()
        }
    }

    /// The core's view of this problem.
    pub fn problem(&self) -> Problem<'_> {
        Problem {
            cells: &self.cells,
            boundary: &self.boundary,
            length: self.length,
            dt: self.dt,
            steps: self.steps,
            keyframes: &self.keyframes,
            keyframe_weights: &self.keyframe_weights,
            keyframe_regions: self.keyframe_regions,
            emitters: &self.emitters,
            solids: self.solids,
            buoyancy: self.buoyancy,
            templates: &self.templates,
            release: self.release,
            schedule: &self.schedule,
            mask: self.mask,
            viscosity: self.viscosity,
            slip: self.slip,
            force_weight: self.force_weight,
            smoothness: self.smoothness,
            filters: self.filters,
            match_mass: self.match_mass,
            advection: self.advection,
            projection_tolerance: self.projection_tolerance,
            share: self.share,
        }
    }
}
