//! The objective as a function of the forces: the flow simulated forwards, and the exact discrete adjoint of what was simulated.
//!
//! ```text
//! forward     v_k + Adv(v_k) + grad p_k = v_{k-1} + u_{k-1},  div v_k = 0             for k = 1 .. T
//! backward    z_k + J(v_k)^T z_k + grad q_k = z_{k+1} - A_v^T mu_k,  div z_k = 0      for k = T .. 1, z_{T+1} = 0
//! gradient    r (1 + s^2 C^T C) u_{k-1} + z_k
//! ```

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::slot::{self, Slot, put};
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::grid::Space;
use crate::grid::levels::Levels;
use crate::memory::{Pool, Sharing};
use crate::method::simulate::step::{self, Step};
use crate::objective::flow::{self, Evaluation};
use crate::objective::sweep::{self, DensitySweep};
use crate::observe::Observer;
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::{Flow, Stop};

/// The last trajectory that was accepted, and what the forces have changed by since: where steps begin.
#[derive(Clone, Copy, Debug)]
pub struct Warm<'a, T> {
    /// v_1 .. v_{N-1}.
    pub v: Vector<'a, T>,
    /// A trajectory, and how many times it was added to the forces.
    pub change: (Vector<'a, T>, f64),
}

/// J(u) = 1/2 <e, C e> + r/2 sum <u, (1 + s^2 C^T C) u>.
pub struct Simulated<'a, 'm, T> {
    /// Weights, densities and work; see [`Self::measure`].
    pub evaluation: Evaluation<'a, 'm, T>,
    /// The relative tolerance of steps.
    pub tolerance: f64,
}

impl<T: Real> Simulated<'_, '_, T> {
    /// What evaluations on the finest grid take of a region, for a pool that measures.
    pub fn measure<'l>(levels: &'l Levels<'_, T>, sweep: &sweep::Setup, pool: &mut Pool<'l, T>) {
        pool.group("evaluation or step", Sharing::InTurn, |pool| {
            Evaluation::measure(levels, 0, sweep, pool);
            // A step's tolerance and viscosity take no memory.
            let step = step::Setup {
                viscosity: 0.0,
                tolerance: 0.0,
                threads: sweep.threads,
            };
            Step::carve(levels, 0, step, pool);
        });
    }

    fn step_setup(&self) -> step::Setup {
        let flow::Setup { sweep, viscosity, .. } = self.evaluation.setup;
        step::Setup {
            viscosity,
            tolerance: self.tolerance,
            threads: sweep.threads,
        }
    }

    /// J(u), with the flow in `v` and rho carried by it; the force's part alone where that is above `bound`.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn value<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        u: Vector<'_, T>,
        warm: Warm<'_, T>,
        v: &mut VectorMut<'_, T>,
        bound: f64,
    ) -> Result<Objective, Stop> {
        let force = self.evaluation.price::<S>(exec, u);
        if force.force > bound {
            return Ok(force);
        }
        self.simulate::<S>(exec, observer, u, warm, v)?;
        let Evaluation {
            levels,
            level,
            setup,
            initial,
            rho,
            keyframes,
            region,
            sums,
            ..
        } = &mut self.evaluation;
        let flow = Flow {
            initial: *initial,
            v: view(v),
            along: None,
        };
        let mut sweep = DensitySweep::carve(levels, *level, &setup.sweep, &mut Pool::new(region));
        let data = sweep.carry(exec, observer, &flow, rho, keyframes, sums)?;
        Ok(Objective { data, ..force })
    }

    /// The flow of u.
    fn simulate<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        u: Vector<'_, T>,
        warm: Warm<'_, T>,
        v: &mut VectorMut<'_, T>,
    ) -> Result<(), Stop> {
        let step_setup = self.step_setup();
        let Evaluation {
            levels,
            level,
            setup,
            initial,
            region,
            sums,
            ..
        } = &mut self.evaluation;
        let (grid, slots) = (&levels.grids[*level], setup.sweep.slots);
        let mut step = Step::carve(levels, *level, step_setup, &mut Pool::new(region));
        for k in 1..=slots {
            let slot = |field| Slot {
                field,
                slots,
                slot: k - 1,
            };
            let before = Slot::at(k - 1, *initial, view(v), slots);
            let (change, s) = warm.change;
            let known = Slot::at(k - 1, *initial, warm.v, slots);
            step.give(exec, [(1.0, before), (1.0, slot(u))]);
            step.guess(
                exec,
                [
                    (1.0, slot(warm.v)),
                    (1.0, before),
                    (-1.0, known),
                    (s, slot(change)),
                ],
            );
            step.advance::<S>(exec, observer, sums)?;
            put(exec, grid, view(&step.v), v, k - 1);
        }
        Ok(())
    }

    /// The gradient at u, from the flow and the densities of [`Self::value`].
    ///
    /// # Errors
    /// [`Stop`].
    pub fn gradient<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        u: Vector<'_, T>,
        v: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
    ) -> Result<(), Stop> {
        self.of_data(exec, observer, v, out)?;
        let setup = self.step_setup();
        let Evaluation {
            levels,
            level,
            setup: weights,
            region,
            priced,
            sums,
            ..
        } = &mut self.evaluation;
        let (grid, slots) = (&levels.grids[*level], weights.sweep.slots);
        let mut step = Step::carve(levels, *level, setup, &mut Pool::new(region));
        step.adjoint
            .iter_mut()
            .for_each(|component| component.fill(T::ZERO));
        for at in (0..slots).rev() {
            let z = |slot| Slot {
                field: view(out),
                slots,
                slot,
            };
            slot::combine(
                exec,
                grid,
                [(1.0, Slot::only(view(&step.adjoint))), (1.0, z(at))],
                &mut step.given,
            );
            if at + 2 < slots {
                slot::combine(
                    exec,
                    grid,
                    [(2.0, z(at + 1)), (-1.0, z(at + 2))],
                    &mut step.adjoint,
                );
            }
            step.guess(
                exec,
                [(
                    1.0,
                    Slot {
                        field: v,
                        slots,
                        slot: at,
                    },
                )],
            );
            step.adjoin::<S>(exec, observer, sums)?;
            put(exec, grid, view(&step.adjoint), out, at);
        }
        let priced = if weights.smoothing > 0.0 { view(priced) } else { u };
        trajectory::add(
            exec,
            Shape { grid, slots },
            out,
            1.0,
            weights.force_weight,
            priced,
        );
        Ok(())
    }

    /// `out` = -A_v^T mu, the derivative of the data term by the flow.
    fn of_data(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
    ) -> Result<(), Stop> {
        let Evaluation {
            levels,
            level,
            setup,
            initial,
            rho,
            keyframes,
            region,
            sums,
            ..
        } = &mut self.evaluation;
        let grid = &levels.grids[*level];
        let flow = Flow {
            initial: *initial,
            v,
            along: None,
        };
        let n = grid.n[0];
        let mut sweep = DensitySweep::carve(levels, *level, &setup.sweep, &mut Pool::new(region));
        sweep.sweep_back(
            exec,
            observer,
            &flow,
            rho,
            keyframes,
            sums,
            &mut |exec, slot, of_data| {
                for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
                    for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                        rows::scale(
                            &mut out[slot * n..(slot + 1) * n],
                            -T::ONE,
                            &of_data[axis][task.row * n..(task.row + 1) * n],
                        );
                    }
                });
            },
        )
    }
}
