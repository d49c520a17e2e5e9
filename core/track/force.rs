//! The force that leads from the flow of a pair to that of the next: what a solve calls the force of a step.
//!
//! ```text
//! u_{k-1} = Q (v_k - v_{k-1} + Adv(v_k)),   in cells and frames
//! ```

use super::Tracker;
use super::pair::{Faces, Part, Sink};
use super::predict::LEFT;
use crate::exec::Exec;
use crate::field::{VectorMut, reborrow, view};
use crate::force::{from_velocity, scratch_per_thread};
use crate::grid::Space;
use crate::grid::levels::Levels;
use crate::grid::solids::Solids;
use crate::memory::{Pool, Sharing, pooled};
use crate::method::simulate::step::project;
use crate::observe::Observer;
use crate::operators::self_advection::Fluid;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

/// A force that is computed.
pub(super) struct Acting<'a, T> {
    u: VectorMut<'a, T>,
    scratch: &'a mut [T],
    projection: Projection<'a, T>,
}

impl<'a, T: Real> Acting<'a, T> {
    /// Takes its workspace from a pool.
    pub fn carve(finest: &'a Levels<'_, T>, threads: usize, pool: &mut Pool<'a, T>) -> Self {
        let grid = &finest.finest;
        pool.group("force of a pair", Sharing::Together, |pool| Self {
            u: pool.take_vector("force", grid.dims, grid.cells()),
            scratch: pool.take("rows", pooled(threads * scratch_per_thread(grid, 1))),
            projection: Projection::carve(finest, 0, 1, threads, pool),
        })
    }
}

impl<T: Real, S: Space> Tracker<'_, T, S> {
    /// Keeps v_{k-1}.
    pub(super) fn keep(&mut self) {
        if self.params.forces {
            for (before, v) in self.before.iter_mut().zip(&self.v) {
                before.copy_from_slice(v);
            }
        }
    }

    /// Hands out the force, where one is asked for and the pair before is that of the frames before.
    pub(super) fn force(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        sink: &mut Sink<'_, T>,
    ) -> Result<(), Stop> {
        let follows = self.pairs > 0 && self.pairs + 2 == self.given;
        if !self.params.forces || !follows {
            return Ok(());
        }
        let Self {
            levels,
            v,
            before,
            region,
            sums,
            params,
            unit,
            dt,
            ..
        } = self;
        let (finest, unit) = (&*levels, *unit / *dt);
        let Acting {
            mut u,
            scratch,
            mut projection,
        } = Acting::carve(finest, params.threads, &mut Pool::new(region));
        let fluid = Fluid {
            grid: &finest.finest,
            slots: 1,
            viscosity: 0.0,
            solids: Solids::default(),
        };
        from_velocity::<T, S>(exec, fluid, view(v), view(before), &[], reborrow(&mut u), scratch);
        project(&mut projection, exec, observer, &mut u, LEFT, sums)?;
        let faces = Faces {
            grid: &finest.finest,
            v: view(&u),
            unit,
        };
        sink(Part::Force, faces);
        Ok(())
    }
}
