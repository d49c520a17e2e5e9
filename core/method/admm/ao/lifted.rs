//! Buoyancy in AO: what the force of v costs among the densities that v* carries.
//!
//! The momentum equation of v has B rho on its right, and rho is AO's. So with v fixed AO's objective gets, and mu on the way back,
//!
//! ```text
//! r/2 sum |w_k|^2,   w_k = P[v_k - v_{k-1} + Adv(v_k) + nu C^T C v_k - B rho_k]        mu_k += r B^T w_k
//! ```

use super::call::{Fields, Setup};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, reborrow, sums, view};
use crate::force;
use crate::force::lift::Lift;
use crate::grid::Space;
use crate::grid::levels::Levels;
use crate::memory::Pool;
use crate::objective::sweep::Companion;
use crate::observe::Observer;
use crate::operators::self_advection::Fluid;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

/// The force of v by the densities that were carried last.
pub struct Lifted<'a, T> {
    lift: Lift<'a>,
    fluid: Fluid<'a>,
    w: VectorMut<'a, T>,
    projection: Projection<'a, T>,
    rows: &'a mut [T],
    /// r, and the relative tolerance of projections.
    weight: f64,
    tolerance: f64,
}

impl<'a, T: Real> Lifted<'a, T> {
    /// Takes it from a pool where densities push the flow.
    pub fn carve(levels: &'a Levels<'_, T>, setup: &Setup, pool: &mut Pool<'a, T>) -> Option<Self> {
        let (flow, grid) = (&setup.flow, &levels.finest);
        let (slots, threads) = (flow.sweep.slots, flow.sweep.threads);
        flow.lifts().then(|| {
            pool.line("force of v by buoyancy", |pool| Self {
                lift: flow.lift(levels),
                fluid: flow.fluid(levels),
                w: pool.take_vector("force", grid.dims, grid.cells() * slots),
                projection: Projection::carve(levels, 0, slots, threads, pool),
                rows: pool.take(
                    "rows of a block",
                    threads * force::scratch_per_thread(grid, slots),
                ),
                weight: flow.force_weight,
                tolerance: flow.projection_tolerance,
            })
        })
    }

    /// r/2 sum |w_k|^2 by the densities `rho`.
    pub fn price<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        fields: &Fields<'_, T>,
        rho: &[T],
        sums: &mut [f64],
    ) -> Result<f64, Stop> {
        let (grid, slots) = (self.fluid.grid, self.fluid.slots);
        let w = reborrow(&mut self.w);
        force::from_velocity::<T, S>(exec, self.fluid, fields.v, fields.initial, &[], w, self.rows);
        self.lift.add(exec, -1.0, rho, 0..slots, &mut self.w);
        let projected = self
            .projection
            .project(exec, observer, &mut self.w, None, self.tolerance, sums);
        if projected.is_break() {
            return Err(Stop::Cancelled);
        }
        Ok(0.5 * self.weight * sums::sum_squares(exec, grid, slots, view(&self.w), sums))
    }
}

/// Goes back with what the force of v has to say of densities, where there is buoyancy.
pub struct WithLift<'a, 'l, T, F> {
    /// The force of v.
    pub lifted: Option<&'a Lifted<'l, T>>,
    /// What is to be done at flows.
    pub at_flow: F,
}

impl<T: Real, F: FnMut(&dyn Exec, usize, Vector<'_, T>) + Send> Companion<T> for WithLift<'_, '_, T, F> {
    fn at_density(&mut self, exec: &dyn Exec, step: usize, mu: &mut [T]) {
        if let Some(Lifted { lift, weight, w, .. }) = self.lifted.filter(|lifted| step <= lifted.fluid.slots)
        {
            lift.add_adjoint(exec, *weight, view(w), step - 1, mu);
        }
    }

    fn at_flow(&mut self, exec: &dyn Exec, slot: usize, gradient: Vector<'_, T>) {
        (self.at_flow)(exec, slot, gradient);
    }
}
