//! The gradient of the objective by the flow (mathematics section 6): one sweep back, one projection.

use crate::exec::{Exec, RowBuffers, RowTask, for_rows};
use crate::field::slot::Slot;
use crate::field::{Vector, VectorMut, borders, reborrow, rows, view};
use crate::force;
use crate::force::lift::Lift;
use crate::grid::{Grid, Space};
use crate::memory::Pool;
use crate::objective::flow::Evaluation;
use crate::objective::sweep::{Companion, DensitySweep};
use crate::observe::Observer;
use crate::real::Real;
use crate::simd::{Cache, prefetch};
use crate::transport::{Flow, ROWS_AHEAD, Stop};

impl<T: Real> Evaluation<'_, '_, T> {
    /// The gradient at v, Q[r (z_k - z_{k+1} + (J(v_k)^T + nu C^T C) z_k) - A_v^T mu_k] with z of [`Self::price`], from the densities and
    /// the force of [`Self::value`]; (1 - K_{k+1}) z_{k+1} where emitters push.
    ///
    /// # Errors
    /// [`Stop`]: [`Stop::TooFast`] where it is not finite.
    pub fn gradient<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        w: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
    ) -> Result<(), Stop> {
        self.prepare_gradient(exec, observer)?;
        let (fluid, scratch) = (self.fluid(self.setup.viscosity), self.force_scratch());
        let scratch = rows::part_mut(self.region, scratch);
        let weighs = self.setup.weighs();
        let z = if weighs { view(&self.priced) } else { w };
        force::apply_adjoint::<T, S>(exec, fluid, v, z, reborrow(out), scratch);
        let (jets, slots) = (self.jets(), fluid.slots);
        if !jets.is_none() {
            for slot in 1..slots {
                let after = Slot {
                    field: z,
                    slots,
                    slot,
                };
                jets.add(exec, [0.0, 1.0], slot, after, (out, slot - 1));
            }
        }
        self.subtract_data_gradient(exec, observer, v, w, out)?;
        let divergence = self.project(exec, observer, out, self.setup.projection_tolerance)?;
        if divergence.is_finite() {
            Ok(())
        } else {
            Err(Stop::TooFast)
        }
    }

    /// `out` = r `out` - A_v^T mu, by a sweep back through the flow; with buoyancy mu has r B^T z too, z being what `w` is priced as.
    fn subtract_data_gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        w: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
    ) -> Result<(), Stop> {
        let mut companion = WayBack {
            lift: self.lift(),
            weight: self.setup.force_weight,
            z: if self.setup.weighs() {
                view(&self.priced)
            } else {
                w
            },
            out: reborrow(out),
        };
        let flow = Flow {
            initial: self.initial,
            v,
            along: None,
        };
        let mut sweep = DensitySweep::carve(
            self.levels,
            self.level,
            &self.setup.sweep,
            &mut Pool::new(&mut *self.region),
        );
        sweep.sweep_back(
            exec,
            observer,
            &flow,
            self.rho,
            &self.script,
            self.sums,
            &mut companion,
        )?;
        borders::refresh_faces(exec, self.shape().grid, out);
        Ok(())
    }
}

/// Makes the gradient of a flow out of that of its force.
struct WayBack<'a, T> {
    lift: Lift<'a>,
    /// r.
    weight: f64,
    z: Vector<'a, T>,
    out: VectorMut<'a, T>,
}

impl<T: Real> Companion<T> for WayBack<'_, T> {
    fn at_density(&mut self, exec: &dyn Exec, step: usize, mu: &mut [T]) {
        if step <= self.lift.slots {
            self.lift.add_adjoint(exec, self.weight, self.z, step - 1, mu);
        }
    }

    fn at_flow(&mut self, exec: &dyn Exec, slot: usize, gradient: Vector<'_, T>) {
        let (grid, weight) = (self.lift.grid, T::from_f64(self.weight));
        let buffers = RowBuffers::fields(reborrow(&mut self.out));
        for_rows(exec, grid.rows(), buffers, move |task| {
            subtract_in_row(task, grid, slot, weight, gradient);
        });
    }
}

/// A row of a slot of a trajectory becomes `weight` times itself minus that of a field.
#[inline(always)]
fn subtract_in_row<T: Real>(
    task: RowTask<'_, T, 3>,
    grid: &Grid,
    slot: usize,
    weight: T,
    of_data: Vector<'_, T>,
) {
    let n = grid.n[0];
    for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
        prefetch(Cache::First, out, ROWS_AHEAD * out.len() + slot * n, n);
        let of_data = &of_data[axis][task.row * n..][..n];
        rows::scale_and_sub(&mut out[slot * n..][..n], weight, of_data);
    }
}
