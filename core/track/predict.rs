//! P_k: what the flow of a pair is before its frames are looked at.

use super::Tracker;
use super::params::Prediction;
use crate::exec::Exec;
use crate::field::slot::Slot;
use crate::field::{VectorMut, view};
use crate::flow::warp::carry_flow;
use crate::force::lift::Lift;
use crate::grid::solids::Solids;
use crate::grid::{Grid, Space};
use crate::memory::Pool;
use crate::method::simulate::step::{self, Step};
use crate::observe::Observer;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

/// What the implicit step leaves, in parts of the largest velocity.
const TOLERANCE: f64 = 1e-6;
/// Directions of GMRES: as many as fit in the memory of the flow solve.
const DIRECTIONS: usize = 5;
/// How much divergence a projection leaves of what there was.
pub(super) const LEFT: f64 = 1e-6;

/// The implicit step of a prediction.
pub(super) fn step_setup(threads: usize) -> step::Setup {
    step::Setup {
        viscosity: 0.0,
        tolerance: TOLERANCE,
        threads,
        directions: DIRECTIONS,
        adjoint: false,
    }
}

/// The fields of a flow that is carried by itself.
pub(super) struct Carried<'a, T> {
    fields: [VectorMut<'a, T>; 3],
}

impl<'a, T: Real> Carried<'a, T> {
    /// Takes its workspace from a pool.
    pub fn carve(grid: &Grid, pool: &mut Pool<'a, T>) -> Self {
        pool.line("flow carried by itself", |pool| Self {
            fields: [(); 3].map(|()| pool.take_vector("field", grid.dims, grid.cells())),
        })
    }
}

impl<T: Real, S: Space> Tracker<'_, T, S> {
    /// P_k takes the place of v_{k-1}.
    pub(super) fn predict(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        if self.params.independent {
            self.v.iter_mut().for_each(|component| component.fill(T::ZERO));
            return Ok(());
        }
        if self.pairs == 0 {
            return Ok(());
        }
        match self.params.predict {
            Prediction::None => Ok(()),
            Prediction::Implicit => self.step_ahead(exec, observer),
            Prediction::Bfecc => {
                let grid = *self.grid();
                let Carried { fields } = Carried::carve(&grid, &mut Pool::new(&mut *self.region));
                let [mut there, mut back, mut out] = fields;
                carry_flow(exec, &grid, view(&self.v), [&mut there, &mut back], &mut out);
                for (v, out) in self.v.iter_mut().zip(&out) {
                    v.copy_from_slice(out);
                }
                self.project(exec, observer)
            }
        }
    }

    /// The implicit step of a simulation, P + Adv(P) + grad p = v + buoyancy.
    fn step_ahead(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        let Self {
            levels,
            v,
            region,
            sums,
            lift,
            frames,
            params,
            ..
        } = self;
        let finest = &*levels;
        let mut step = Step::carve(finest, 0, step_setup(params.threads), &mut Pool::new(region));
        let before = Slot::only(view(v));
        step.give(exec, [(1.0, before)]);
        step.guess(exec, [(1.0, before)]);
        let push = Lift {
            grid: &finest.finest,
            slots: 1,
            solids: Solids::default(),
            acceleration: *lift,
        };
        push.add_now(exec, frames[0], &mut step.given);
        step.advance::<S>(exec, observer, sums)?;
        for (v, next) in v.iter_mut().zip(&step.v) {
            v.copy_from_slice(next);
        }
        Ok(())
    }

    /// v loses its divergence.
    pub(super) fn project(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        let Self {
            levels,
            v,
            region,
            sums,
            params,
            ..
        } = self;
        let mut projection = Projection::carve(levels, 0, 1, params.threads, &mut Pool::new(region));
        step::project(&mut projection, exec, observer, v, LEFT, sums)
    }
}
