//! The way forward: a step, and all of them.

use super::fields::{Places, Room};
use super::states::flow;
use super::{Ask, Given, Input, Operator, OperatorError, Phase, Show, Start, View};
use crate::exec::Exec;
use crate::field::slot::{self, Slot};
use crate::field::{VectorMut, reborrow, rows, sums, view};
use crate::force::template::Placed;
use crate::grid::Space;
use crate::memory::Pool;
use crate::method::simulate::step::Step;
use crate::objective::script::Script;
use crate::objective::script::jets::Jets;
use crate::observe::Observer;
use crate::poisson::Projection;
use crate::problem::Template;
use crate::real::Real;
use crate::reversal::Move;
use crate::solver::{FileLayout, InputError, finite};
use crate::transport::{Stop, Transport};

impl<T: Real, S: Space> Operator<'_, T, S> {
    /// Simulates all steps from `start`, with the force that `force` adds to each, and calls `show` with rho_k and v_k for k = 0 .. N. What
    /// the way back begins with is kept.
    ///
    /// # Errors
    /// [`OperatorError`].
    pub fn simulate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        start: &Start<'_, T>,
        force: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError> {
        self.phase = Phase::Nothing;
        self.repeated = 0;
        self.check_emitters()?;
        self.begin(exec, observer, start)?;
        show(0, &self.state());
        let steps = self.setup.steps;
        self.reversal.restart(steps, false);
        while let Some(next) = self.reversal.next() {
            match next {
                Move::Advance { from, to } => {
                    for step in from..to {
                        self.run(exec, observer, force, step)?;
                        self.go_on();
                        show(step + 1, &self.state());
                    }
                    self.repeated += to - from;
                }
                Move::Store { slot } => self.store(slot),
                // On the way forward nothing is fetched.
                Move::Restore { .. } => {}
                Move::Reverse { step } => {
                    self.run(exec, observer, force, step)?;
                    show(step + 1, &self.after());
                    self.phase = Phase::Simulated;
                    break;
                }
            }
        }
        Ok(())
    }

    fn check_emitters(&self) -> Result<(), OperatorError> {
        let cells = self.grid().cells();
        let unset = |index: &usize| {
            let shape = rows::part(self.shapes, index * cells..(index + 1) * cells);
            shape.iter().all(|&x| x == T::ZERO)
        };
        match (0..self.setup.emitters).find(unset) {
            Some(index) => Err(Input::Emitter { index }.refused()(InputError::NoEmitter {
                index,
            })),
            None => Ok(()),
        }
    }

    /// rho_0, and v_0 projected.
    fn begin(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        start: &Start<'_, T>,
    ) -> Result<(), OperatorError> {
        let grid = self.levels.finest;
        let cells = grid.cells();
        finite(start.density, self.cells()).map_err(Input::Density.refused())?;
        let sizes = start.density.iter().map(|x| x.to_f64().abs());
        let largest = sizes.fold(0.0, f64::max);
        let emitted = (0..self.setup.emitters).map(|index| self.script().most_emitted(index, cells));
        let largest = emitted.fold(largest, f64::max);
        self.largest = if largest > 0.0 { largest } else { 1.0 };
        let rho = rows::part_mut(self.rho, 0..cells);
        FileLayout::of_cells(&grid).write(start.density, T::ONE, rho);
        self.levels.solids(0).clear_cells(grid.n[0], rho);
        let [_, v, _] = &mut self.v;
        for (axis, (component, given)) in v.iter_mut().zip(start.velocity).enumerate().take(grid.dims) {
            if given.is_empty() {
                component.fill(T::ZERO);
                continue;
            }
            let layout = FileLayout::new(&grid, axis);
            let taken = layout.take(given, 1.0 / self.setup.velocity_unit, component, [1, 0]);
            taken.map_err(Input::Velocity.refused())?;
        }
        self.project_start(exec, observer)
    }

    /// v_0 loses its divergence, and stands for the velocity before it too.
    fn project_start(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), OperatorError> {
        let [before, v, _] = &mut self.v;
        let fastest = sums::max_abs(exec, &self.levels.finest, 1, view(v), self.sums);
        if fastest > 0.0 {
            let threads = self.setup.params.threads;
            let mut projection = Projection::carve(&self.levels, 0, 1, threads, &mut Pool::new(self.region));
            let tolerance = self.setup.projection_tolerance;
            let done = projection.project(exec, observer, v, None, tolerance, self.sums);
            if done.is_break() {
                return Err(OperatorError::Cancelled);
            }
        }
        slot::put(exec, &self.levels.finest, view(v), before, 0);
        Ok(())
    }

    /// rho_k and v_k.
    fn state(&self) -> View<'_, T> {
        let [_, v, _] = &self.v;
        self.shown(rows::part(self.rho, 0..self.grid().cells()), v)
    }

    /// rho_{k+1} and v_{k+1}.
    fn after(&self) -> View<'_, T> {
        let ([_, _, after], cells) = (&self.v, self.grid().cells());
        self.shown(rows::part(self.rho, cells..2 * cells), after)
    }

    fn shown<'a>(&'a self, density: &'a [T], v: &'a VectorMut<'_, T>) -> View<'a, T> {
        View {
            places: Places::Faces(self.grid()),
            density,
            vector: view(v),
            unit: self.setup.velocity_unit,
        }
    }

    /// Runs step `step`: rho_{k+1} and v_{k+1} beside rho_k and v_k.
    pub(super) fn run(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: &mut Ask<'_, T>,
        step: usize,
    ) -> Result<(), OperatorError> {
        let stopped = OperatorError::stopped(step);
        self.carry(exec, observer, step).map_err(&stopped)?;
        self.push(exec, force, step)?;
        self.solve(exec, observer).map_err(&stopped)
    }

    /// rho_{k+1}.
    fn carry(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, step: usize) -> Result<(), Stop> {
        let Self {
            setup,
            levels,
            lists,
            shapes,
            rho,
            v: [_, v, _],
            sums,
            region,
            ..
        } = self;
        let grid = &levels.finest;
        let pool = &mut Pool::new(region);
        let mut transport =
            Transport::one_way(grid, setup.stepping, self.largest, setup.params.threads, pool)
                .among(levels.solids(0), pool);
        transport.step(exec, &flow(v), 1, 0, rho, sums)?;
        let script = Script::new(*lists, shapes);
        let cells = grid.cells();
        script.emit(exec, grid, step + 1, rows::part_mut(rho, cells..2 * cells));
        Stop::heard(observer)
    }

    /// What pushes v_k: the force that is given, templates, buoyancy, emitters.
    fn push(&mut self, exec: &dyn Exec, force: &mut Ask<'_, T>, step: usize) -> Result<(), OperatorError> {
        let mut out = core::mem::take(&mut self.force);
        slot::clear(exec, self.grid(), &mut out, 0);
        let room = Room::Faces(self.grid());
        let given = Given::new(room, &mut [], reborrow(&mut out), 1.0 / self.setup.force_unit);
        let asked = given.ask(force, step, Input::Force { step });
        if asked.is_ok() {
            for placed in self.placed(step) {
                let amplitude = placed.template.amplitude;
                placed.add(exec, &|_| amplitude, self.rho, (0..1, 0), &mut out);
            }
            self.lift().add(exec, 1.0, self.rho, 0..1, &mut out);
            let [_, v, _] = &self.v;
            self.jets()
                .add(exec, [1.0, -1.0], step, Slot::only(view(v)), (&mut out, 0));
        }
        self.force = out;
        asked
    }

    /// The templates that act in `step`, in fields of that step alone.
    pub(super) fn placed(&self, step: usize) -> impl Iterator<Item = Placed<'_>> {
        let (grid, solids) = (self.grid(), self.levels.solids(0));
        let acts = move |template: &Template| (template.from..template.to).contains(&step);
        self.script().templates().filter(acts).map(move |template| {
            let now = Template {
                from: 0,
                to: 1,
                interval: 1,
                ..template
            };
            Placed::new(grid, solids, 1, now)
        })
    }

    /// The emitters that push.
    pub(super) fn jets(&self) -> Jets<'_, T> {
        Jets {
            grid: self.grid(),
            solids: self.levels.solids(0),
            script: self.script(),
        }
    }

    /// v_{k+1}.
    fn solve(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        let [before, v, after] = &mut self.v;
        let mut step = Step::carve(&self.levels, 0, self.setup.step(), &mut Pool::new(self.region));
        let (now, earlier) = (Slot::only(view(v)), Slot::only(view(before)));
        step.give(exec, [(1.0, now), (1.0, Slot::only(view(&self.force)))]);
        step.guess(exec, [(2.0, now), (-1.0, earlier)]);
        step.advance::<S>(exec, observer, self.sums)?;
        slot::put(exec, &self.levels.finest, view(&step.v), after, 0);
        Ok(())
    }
}
