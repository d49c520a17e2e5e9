//! The way back: a step, and all of them.

use super::fields::{Places, Room};
use super::states::flow;
use super::{Ask, Given, Input, Operator, OperatorError, Phase, Show, View};
use crate::exec::Exec;
use crate::field::slot::{self, Slot};
use crate::field::{reborrow, rows, sums, view};
use crate::force::lift::Lift;
use crate::grid::Space;
use crate::memory::Pool;
use crate::method::simulate::step::Step;
use crate::objective::script::Script;
use crate::objective::script::emitted::OfEmitters;
use crate::objective::script::jets::Jets;
use crate::observe::Observer;
use crate::poisson::Projection;
use crate::real::Real;
use crate::reversal::Move;
use crate::transport::{Stop, TooFast, Transport};

impl<T: Real, S: Space> Operator<'_, T, S> {
    /// The vector-Jacobian product of the last simulation: `cotangent` adds what a scalar function of the trajectory gets by rho_k and v_k for
    /// k = N .. 0, `show` is called with what it gets by the force of each step, the last first, and [`Self::gradient`] and the others have the
    /// rest afterwards. `force` gives the same forces as before. It may be asked for again.
    ///
    /// # Errors
    /// [`OperatorError`].
    pub fn vjp(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: &mut Ask<'_, T>,
        cotangent: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError> {
        let phase = self.phase;
        self.forget();
        match phase {
            Phase::Nothing => return Err(OperatorError::NotSimulated),
            Phase::Simulated => {
                self.phase = Phase::Begun;
                let step = self.setup.steps.saturating_sub(1);
                self.ask(cotangent, step + 1)?;
                self.take_back(exec, observer, show, step)?;
                self.ask(cotangent, step)?;
            }
            Phase::Begun => {
                self.repeated = 0;
                self.restore(0);
                self.reversal.restart(self.setup.steps, true);
                self.ask(cotangent, self.setup.steps)?;
            }
        }
        while let Some(next) = self.reversal.next() {
            match next {
                Move::Advance { from, to } => {
                    for step in from..to {
                        self.run(exec, observer, force, step)?;
                        self.go_on();
                    }
                    self.repeated += to - from;
                }
                Move::Store { slot } => self.store(slot),
                Move::Restore { slot, .. } => self.restore(slot),
                Move::Reverse { step } => {
                    self.run(exec, observer, force, step)?;
                    self.take_back(exec, observer, show, step)?;
                    self.ask(cotangent, step)?;
                }
            }
        }
        self.end(exec, observer)
    }

    /// Sets all gradients to 0.
    fn forget(&mut self) {
        self.mu.fill(T::ZERO);
        self.covector
            .iter_mut()
            .for_each(|component| component.fill(T::ZERO));
        self.of_buoyancy = [0.0; 3];
        self.numbers.fill(0.0);
        self.of_shapes.fill(T::ZERO);
        self.known = 0;
    }

    /// Adds the covectors of step `step`.
    fn ask(&mut self, cotangent: &mut Ask<'_, T>, step: usize) -> Result<(), OperatorError> {
        let (room, covector) = (Room::Faces(&self.levels.finest), reborrow(&mut self.covector));
        let given = Given::new(room, self.mu, covector, self.setup.velocity_unit);
        given.ask(cotangent, step, Input::Cotangent { step })
    }

    /// Takes step `step` back, of which the states before and after are at hand: the covectors of that after become those of that before.
    fn take_back(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        show: &mut Show<'_, T>,
        step: usize,
    ) -> Result<(), OperatorError> {
        let stopped = OperatorError::stopped(step);
        self.adjoin(exec, observer).map_err(&stopped)?;
        show(
            step,
            &View {
                places: Places::Faces(self.grid()),
                density: &[],
                vector: view(&self.z[0]),
                unit: 1.0 / self.setup.force_unit,
            },
        );
        self.push_back(exec, step);
        self.carry_back(exec, observer, step).map_err(&stopped)
    }

    /// z, by the covector of v_{k+1}.
    fn adjoin(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        let [_, _, after] = &self.v;
        let mut step = Step::carve(&self.levels, 0, self.setup.step(), &mut Pool::new(self.region));
        step.give(exec, [(1.0, Slot::only(view(&self.covector)))]);
        step.guess(exec, [(1.0, Slot::only(view(after)))]);
        let [last, earlier] = &mut self.z;
        let [of_last, of_earlier] = match self.known {
            0 => [0.0, 0.0],
            1 => [1.0, 0.0],
            _ => [2.0, -1.0],
        };
        if self.known == 0 {
            slot::clear(exec, &self.levels.finest, &mut step.adjoint, 0);
        } else {
            let terms = [
                (of_last, Slot::only(view(last))),
                (of_earlier, Slot::only(view(earlier))),
            ];
            slot::combine(exec, &self.levels.finest, terms, &mut step.adjoint);
        }
        step.adjoin::<S>(exec, observer, self.sums)?;
        core::mem::swap(last, earlier);
        slot::put(exec, &self.levels.finest, view(&step.adjoint), last, 0);
        self.known += 1;
        Ok(())
    }

    /// What z is for all that pushes: the density after the step, buoyancy, the velocity of emitters.
    fn push_back(&mut self, exec: &dyn Exec, step: usize) {
        let (grid, cells) = (self.levels.finest, self.grid().cells());
        let mut mu = core::mem::take(&mut self.mu);
        let z = view(&self.z[0]);
        self.lift().add_adjoint(exec, 1.0, z, 0, mu);
        for placed in self.placed(step) {
            let amplitude = placed.template.amplitude;
            placed.add_to_density(exec, &|_| amplitude, (1.0, z), 0, mu);
        }
        core::mem::swap(&mut self.mu, &mut mu);
        // The force of the step is of no use any more: its place takes B rho for an acceleration of 1.
        let mut lifted = core::mem::take(&mut self.force);
        slot::clear(exec, &grid, &mut lifted, 0);
        let unit = Lift {
            acceleration: [1.0; 3],
            ..self.lift()
        };
        unit.add_now(exec, rows::part(self.rho, cells..2 * cells), &mut lifted);
        let z = view(&self.z[0]);
        for (axis, gradient) in self.of_buoyancy.iter_mut().enumerate().take(grid.dims) {
            let [of_z, of_rho] = [z, view(&lifted)].map(|field| field.get(axis).copied().unwrap_or_default());
            *gradient += sums::total(exec, &grid, self.sums, |row| {
                rows::dot(sums::row(&grid, 1, of_z, row), sums::row(&grid, 1, of_rho, row))
            });
        }
        self.force = lifted;
        let (jets, [_, v, _]) = (
            Jets {
                grid: &grid,
                solids: self.levels.solids(0),
                script: Script::new(self.lists, self.shapes),
            },
            &self.v,
        );
        let mut out = OfEmitters {
            numbers: self.numbers,
            shapes: self.of_shapes,
            sums: self.sums,
        };
        jets.add_to_emitters(exec, step, [view(&self.z[0]), view(v)], &mut out);
    }

    /// Back through what was emitted and carried: covectors of rho_k and v_k.
    fn carry_back(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, step: usize) -> Result<(), Stop> {
        let Self {
            setup,
            levels,
            lists,
            shapes,
            rho,
            mu,
            v: [_, v, _],
            z: [z, _],
            covector,
            numbers,
            of_shapes,
            sums,
            region,
            largest,
            ..
        } = self;
        let (grid, solids) = (&levels.finest, levels.solids(0));
        let script = Script::new(*lists, shapes);
        let (before, after) = rho.split_at_mut_checked(grid.cells()).unwrap_or_default();
        let mut out = OfEmitters {
            numbers,
            shapes: of_shapes,
            sums,
        };
        script.add_to_emitters(exec, grid, step + 1, [after, mu], true, &mut out);
        script.forget(exec, grid, step + 1, after, mu);
        script.add_to_emitters(exec, grid, step + 1, [after, mu], false, &mut out);
        let pool = &mut Pool::new(region);
        let mut transport = Transport::carve(grid, setup.stepping, *largest, setup.params.threads, pool)
            .among(solids, pool)
            .everywhere();
        transport
            .load(exec, &flow(v), 1, 0, sums)
            .map_err(|TooFast| Stop::TooFast)?;
        transport.backward(exec, before, mu);
        let (z, moved) = (Slot::only(view(z)), Slot::only(transport.gradient()));
        slot::combine(exec, grid, [(1.0, z), (1.0, moved)], covector);
        let jets = Jets { grid, solids, script };
        jets.add(exec, [0.0, -1.0], step, z, (covector, 0));
        Stop::heard(observer)
    }

    /// What is given in solid cells counts for nothing, and v_0 was projected.
    fn end(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), OperatorError> {
        let (n, cells) = (self.grid().n[0], self.grid().cells());
        self.levels.solids(0).clear_cells(n, self.mu);
        for index in 0..self.setup.emitters {
            let shape = rows::part_mut(self.of_shapes, index * cells..(index + 1) * cells);
            self.levels.solids(0).clear_cells(n, shape);
        }
        let threads = self.setup.params.threads;
        let mut projection = Projection::carve(&self.levels, 0, 1, threads, &mut Pool::new(self.region));
        let tolerance = self.setup.projection_tolerance;
        let done = projection.project(exec, observer, &mut self.covector, None, tolerance, self.sums);
        if done.is_break() {
            return Err(OperatorError::Cancelled);
        }
        Ok(())
    }
}
