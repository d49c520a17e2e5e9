//! One implicit step of the flow, v + Adv(v) + nu C^T C v + grad p = a, div v = 0 with a = v_{k-1} + u_{k-1}, and its adjoint.
//!
//! Adv stands for Adv + nu C^T C below, J for its derivative. Both are solved as equations without pressure, v = Q(a - Adv(v)), whose residual also heals what divergence v has:
//! Newton's method, each correction (I + Q J(v)) d = residual by GMRES; the adjoint z = Q(b - J(v)^T z) by GMRES alone.

mod equation;
mod guided;

pub use equation::project;

use super::krylov::{DIRECTIONS, Krylov};
use crate::exec::Exec;
use crate::field::slot::{self, Slot};
use crate::field::trajectory::{Shape, add, dot};
use crate::field::{Vector, VectorMut, sums, view};
use crate::grid::levels::Levels;
use crate::grid::solids::Solids;
use crate::grid::{Grid, Space};
use crate::memory::{Pool, Sharing};
use crate::observe::Observer;
use crate::operators::self_advection::{self, Fluid};
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

/// Corrections of Newton's method, or cycles of the adjoint, at most.
const CORRECTIONS: usize = 30;
/// The smallest part of a correction that is tried.
const SMALLEST: f64 = 1.0 / 16.0;
/// What a cycle may leave of a residual at most.
const LEFT: f64 = 0.1;
/// What a cycle of the adjoint leaves at least: to leave less asks for projections that are dearer than another cycle.
const LEFT_OF_ADJOINT: f64 = 1e-2;
/// What it leaves, in parts of what would be enough.
const SURE: f64 = 0.3;
/// Rounding errors of a residual, in parts of its largest term.
const ROUNDING: f64 = 16.0;
/// Rounding errors of projecting a gradient, in parts of its size.
const OF_GRADIENT: f64 = 4.0;
/// A step whose rounding errors are a larger part of its speed is not solved.
const MOST_ROUNDING: f64 = 1e-3;

/// What does not change from step to step.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// max |residual| at which a step is solved, relative to max |v|.
    pub tolerance: f64,
    /// Threads that scratch was planned for.
    pub threads: usize,
    /// Directions of a cycle of GMRES at most.
    pub directions: usize,
    /// Whether the adjoint is solved too.
    pub adjoint: bool,
}

impl Setup {
    /// Of steps that are taken back as well.
    #[must_use]
    pub fn both_ways(viscosity: f64, tolerance: f64, threads: usize) -> Self {
        Self {
            viscosity,
            tolerance,
            threads,
            directions: DIRECTIONS,
            adjoint: true,
        }
    }
}

/// The workspace of a step.
pub struct Step<'a, T> {
    grid: &'a Grid,
    solids: Solids<'a>,
    setup: Setup,
    projection: Projection<'a, T>,
    /// The right-hand side: a of a step, b of its adjoint.
    pub given: VectorMut<'a, T>,
    /// v, at first a guess.
    pub v: VectorMut<'a, T>,
    /// z, at first a guess.
    pub adjoint: VectorMut<'a, T>,
    residual: VectorMut<'a, T>,
    correction: VectorMut<'a, T>,
    krylov: Krylov<'a, T>,
    scratch: &'a mut [T],
}

impl<'a, T: Real> Step<'a, T> {
    /// Takes its workspace from a pool. The grid is number `level` of the hierarchy.
    pub fn carve(levels: &'a Levels<'_, T>, level: usize, setup: Setup, pool: &mut Pool<'a, T>) -> Self {
        let grid = &levels.grids[level];
        pool.group("implicit step", Sharing::Together, |pool| {
            let projection = Projection::carve(levels, level, 1, setup.threads, pool);
            let cells = grid.cells();
            let of_adjoint = if setup.adjoint { cells } else { 0 };
            let [given, v, adjoint, residual, correction] =
                pool.line("velocities, residual and correction", |pool| {
                    [cells, cells, of_adjoint, cells, cells]
                        .map(|len| pool.take_vector("field", grid.dims, len))
                });
            let krylov = Krylov::carve(grid, setup.directions, pool);
            let rows = setup.threads * self_advection::scratch_per_thread(grid, 1);
            Self {
                grid,
                solids: levels.solids(level),
                setup,
                projection,
                given,
                v,
                adjoint,
                residual,
                correction,
                krylov,
                scratch: pool.take("rows of a block", rows),
            }
        })
    }

    /// `given` = the sum of `s x`.
    pub fn give<const K: usize>(&mut self, exec: &dyn Exec, terms: [(f64, Slot<'_, T>); K]) {
        slot::combine(exec, self.grid, terms, &mut self.given);
    }

    /// v = the sum of `s x`.
    pub fn guess<const K: usize>(&mut self, exec: &dyn Exec, terms: [(f64, Slot<'_, T>); K]) {
        slot::combine(exec, self.grid, terms, &mut self.v);
    }

    fn fluid(&self) -> Fluid<'a> {
        Fluid {
            grid: self.grid,
            slots: 1,
            viscosity: self.setup.viscosity,
            solids: self.solids,
        }
    }

    fn shape(&self) -> Shape<'a> {
        Shape {
            grid: self.grid,
            slots: 1,
        }
    }

    fn speed(&self, exec: &dyn Exec, x: Vector<'_, T>, sums: &mut [f64]) -> f64 {
        sums::max_abs(exec, self.grid, 1, x, sums)
    }

    /// Rounding errors of Adv + nu C^T C and what surrounds it, in parts of the speed.
    fn rounding(&self, speed: f64) -> f64 {
        let h = self.grid.h[0];
        (ROUNDING * T::EPSILON * (1.0 + speed / h + self.setup.viscosity / (h * h))).min(MOST_ROUNDING)
    }

    /// Solves v + Adv(v) + grad p = given, div v = 0, from the guess in v.
    ///
    /// # Errors
    /// [`Stop::TooFast`] when Newton's method does not converge.
    pub fn advance<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let shape = self.shape();
        let (mut before, mut length) = (f64::INFINITY, 1.0);
        for _ in 0..CORRECTIONS {
            self.residual::<S>(exec, observer, Law::Flow, sums)?;
            let size = self.speed(exec, view(&self.residual), sums);
            let speed = self
                .speed(exec, view(&self.given), sums)
                .max(self.speed(exec, view(&self.v), sums));
            let enough = speed * self.setup.tolerance.max(self.rounding(speed));
            if size <= enough {
                return Ok(());
            }
            let norm = dot(exec, shape, view(&self.residual), view(&self.residual), sums);
            if !(norm < before) {
                length *= 0.5;
                if !(length >= SMALLEST) || !speed.is_finite() {
                    return Err(Stop::TooFast);
                }
                add(exec, shape, &mut self.v, 1.0, -length, view(&self.correction));
                continue;
            }
            // What Newton's method leaves by itself is Adv(d), about max |d|^2 / h: to solve for d better than that is no use.
            let left = (size / self.grid.h[0]).max(SURE * enough / size).min(LEFT);
            self.correct::<S>(exec, observer, Law::Flow, left, sums)?;
            add(exec, shape, &mut self.v, 1.0, 1.0, view(&self.correction));
            (before, length) = (norm, 1.0);
        }
        Err(Stop::TooFast)
    }

    /// Solves z + J(v)^T z + grad q = given, div z = 0, from the guess in `adjoint`.
    ///
    /// # Errors
    /// [`Stop::TooFast`] when GMRES does not converge.
    pub fn adjoin<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let shape = self.shape();
        let mut enough = None;
        let speed = self.speed(exec, view(&self.v), sums);
        let known = libm::sqrt(dot(exec, shape, view(&self.adjoint), view(&self.adjoint), sums));
        // What projecting leaves of a covector that is all gradient.
        let given = libm::sqrt(dot(exec, shape, view(&self.given), view(&self.given), sums));
        let noise = OF_GRADIENT * T::EPSILON * given;
        for _ in 0..CORRECTIONS {
            self.residual::<S>(exec, observer, Law::Adjoint, sums)?;
            let size = libm::sqrt(dot(exec, shape, view(&self.residual), view(&self.residual), sums));
            let enough =
                *enough.get_or_insert((known + size) * self.setup.tolerance.max(self.rounding(speed)));
            if size <= enough.max(noise) {
                return Ok(());
            }
            if !size.is_finite() {
                return Err(Stop::TooFast);
            }
            let left = (SURE * enough / size).max(LEFT_OF_ADJOINT);
            self.correct::<S>(exec, observer, Law::Adjoint, left, sums)?;
            add(exec, shape, &mut self.adjoint, 1.0, 1.0, view(&self.correction));
        }
        Err(Stop::TooFast)
    }
}

/// Which equation is solved.
#[derive(Clone, Copy)]
enum Law {
    Flow,
    Adjoint,
}
