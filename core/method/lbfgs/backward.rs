//! The gradient by the forces: back through the densities and the flow that they were carried by.

use super::evaluate::{Pull, Push, Simulated};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::slot::{self, Slot, put};
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::force::lift::Lift;
use crate::grid::{Grid, Space};
use crate::memory::Pool;
use crate::method::simulate::step::Step;
use crate::objective::flow::Evaluation;
use crate::objective::script::jets::Jets;
use crate::objective::sweep::{Companion, DensitySweep};
use crate::observe::{Observer, Silent};
use crate::real::Real;
use crate::transport::{Flow, Stop};
use core::marker::PhantomData;

impl<T: Real> Simulated<'_, '_, T> {
    /// The gradient by the forces, those included that the densities added, from the flow and the densities of [`Self::value`] or
    /// [`Self::simulate`] and the price of them all.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn gradient<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        Push { u, pull }: Push<'_, T>,
        v: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
    ) -> Result<(), Stop> {
        let step_setup = self.step_setup();
        self.evaluation.prepare_gradient(exec, observer)?;
        let (lift, jets) = (self.evaluation.lift(), self.evaluation.jets());
        let Evaluation {
            levels,
            level,
            setup,
            initial,
            rho,
            script,
            region,
            priced,
            sums,
            ..
        } = &mut self.evaluation;
        let (grid, slots) = (&levels.grids[*level], setup.sweep.slots);
        let flow = Flow {
            initial: *initial,
            v,
            along: None,
        };
        let priced = if setup.weighs() { view(priced) } else { u };
        let pull = pull.map(|pull| Pulled {
            pull,
            priced,
            weight: setup.force_weight,
        });
        let together = setup.lifts() || pull.is_some();
        let mut back = Backward::<T, S> {
            jets,
            pull,
            lift,
            together: None,
            v,
            out: reborrow(out),
            ended: Ok(()),
            space: PhantomData,
        };
        if together {
            let (of_sweep, of_step) = sums
                .split_at_mut_checked(grid.rows())
                .unwrap_or((&mut [], &mut []));
            let mut pool = Pool::new(region);
            let mut sweep = DensitySweep::carve(levels, *level, &setup.sweep, &mut pool);
            back.together = Some((Step::carve(levels, *level, step_setup, &mut pool), of_step));
            back.begin();
            sweep.sweep_back(exec, observer, &flow, rho, script, of_sweep, &mut back)?;
        } else {
            let mut pool = Pool::new(region);
            let mut sweep = DensitySweep::carve(levels, *level, &setup.sweep, &mut pool);
            sweep.sweep_back(exec, observer, &flow, rho, script, sums, &mut back)?;
            drop(sweep);
            let step = Step::carve(levels, *level, step_setup, &mut Pool::new(region));
            back.together = Some((step, &mut **sums));
            back.begin();
            (0..slots)
                .rev()
                .for_each(|slot| back.adjoin(exec, observer, slot));
        }
        let ended = back.ended;
        drop(back);
        ended?;
        trajectory::add(exec, Shape { grid, slots }, out, 1.0, setup.force_weight, priced);
        Ok(())
    }
}

/// What the densities added to the force, and what that is priced as.
#[derive(Clone, Copy)]
struct Pulled<'a, T> {
    pull: &'a dyn Pull<T>,
    priced: Vector<'a, T>,
    /// r.
    weight: f64,
}

/// What goes back through the flow, into the trajectory `out`: at first -A_v^T mu, then z in its place.
struct Backward<'a, T, S> {
    lift: Lift<'a>,
    jets: Jets<'a, T>,
    pull: Option<Pulled<'a, T>>,
    /// Where steps are solved, with sums: beside the sweep where densities push the flow, since then each needs the other; otherwise after it.
    together: Option<(Step<'a, T>, &'a mut [f64])>,
    v: Vector<'a, T>,
    out: VectorMut<'a, T>,
    ended: Result<(), Stop>,
    space: PhantomData<S>,
}

impl<T: Real, S: Space> Backward<'_, T, S> {
    /// Before the last step there is none.
    fn begin(&mut self) {
        if let Some((step, _)) = &mut self.together {
            step.adjoint
                .iter_mut()
                .for_each(|component| component.fill(T::ZERO));
        }
    }

    /// z in `slot`, from that in the slot after and -A_v^T mu.
    fn adjoin(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, slot: usize) {
        let (grid, slots): (&Grid, usize) = (self.lift.grid, self.lift.slots);
        let (Some((step, sums)), Ok(())) = (&mut self.together, self.ended) else {
            return;
        };
        let out = &mut self.out;
        let at = |field, slot| Slot { field, slots, slot };
        let terms = [(1.0, Slot::only(view(&step.adjoint))), (1.0, at(view(out), slot))];
        slot::combine(exec, grid, terms, &mut step.given);
        let after = Slot::only(view(&step.adjoint));
        self.jets
            .add(exec, [0.0, -1.0], slot + 1, after, (&mut step.given, 0));
        if slot + 2 < slots {
            let terms = [(2.0, at(view(out), slot + 1)), (-1.0, at(view(out), slot + 2))];
            slot::combine(exec, grid, terms, &mut step.adjoint);
        }
        step.guess(exec, [(1.0, at(self.v, slot))]);
        self.ended = step.adjoin::<S>(exec, observer, sums);
        put(exec, grid, view(&step.adjoint), out, slot);
    }
}

impl<T: Real, S: Space> Companion<T> for Backward<'_, T, S> {
    fn at_density(&mut self, exec: &dyn Exec, step: usize, mu: &mut [T]) {
        if step <= self.lift.slots {
            self.lift.add_adjoint(exec, -1.0, view(&self.out), step - 1, mu);
            if let Some(Pulled { pull, priced, weight }) = self.pull {
                pull.add_adjoint(exec, -1.0, view(&self.out), step - 1, mu);
                pull.add_adjoint(exec, -weight, priced, step - 1, mu);
            }
        }
    }

    fn at_flow(&mut self, exec: &dyn Exec, slot: usize, gradient: Vector<'_, T>) {
        let grid = self.lift.grid;
        let n = grid.n[0];
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(reborrow(&mut self.out)),
            |task| {
                for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                    let gradient = &gradient[axis][task.row * n..(task.row + 1) * n];
                    rows::scale(&mut out[slot * n..(slot + 1) * n], -T::ONE, gradient);
                }
            },
        );
        // The sweep hears the observer.
        self.adjoin(exec, &mut Silent, slot);
    }
}
