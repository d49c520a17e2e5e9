//! All steps of a simulation, forward, and backward by its tape or by the states that are kept.

use super::cells::Cells;
use super::fields::Flow;
use super::flow::Seen;
use crate::exec::Exec;
use crate::field::{Vector, VectorMut};
use crate::grid::Grid;
use crate::observe::Observer;
use crate::real::Real;
use crate::reversal::{Reversible, reverse_all};
use crate::transport::Stop;

/// What a simulation is given step by step, and who listens to it.
pub trait Script<T> {
    /// Writes the force of a step, without ghosts.
    fn force(
        &mut self,
        exec: &dyn Exec,
        cells: (&Cells, &Grid),
        step: usize,
        force: &mut VectorMut<'_, T>,
        sums: &mut [f64],
    );

    /// Sees the state after `step` steps, going forward.
    fn see(&mut self, exec: &dyn Exec, step: usize, seen: Seen<'_, T>);

    /// Adds what the objective says of the state after `step` steps to its adjoints.
    fn add_adjoint(&mut self, exec: &dyn Exec, step: usize, seen: Seen<'_, T>);

    /// Takes the adjoint of the force of a step, padded, and that force.
    fn take_gradient(
        &mut self,
        exec: &dyn Exec,
        cells: (&Cells, &Grid),
        step: usize,
        adjoint_and_force: [Vector<'_, T>; 2],
        sums: &mut [f64],
    );

    /// Whether it looks at the density after `step` steps in [`Self::add_adjoint`].
    fn looks_at(&self, step: usize) -> bool;
}

/// A simulation under way.
pub struct March<'a, 'm, T> {
    /// The flow, with the state at hand.
    pub flow: &'a mut Flow<'m, T>,
    /// What it is given.
    pub script: &'a mut dyn Script<T>,
    /// Hears of every step.
    pub observer: &'a mut dyn Observer,
}

impl<T: Real> March<'_, '_, T> {
    fn push(&mut self, exec: &dyn Exec, step: usize) {
        let flow = &mut *self.flow;
        let cells = (&flow.cells, &flow.grid);
        self.script.force(exec, cells, step, &mut flow.force, flow.sums);
    }

    fn step(&mut self, exec: &dyn Exec, step: usize) -> Result<(), Stop> {
        Stop::heard(self.observer)?;
        self.push(exec, step);
        self.flow.advance(exec);
        Ok(())
    }

    /// Goes through all steps from the state at hand. Where there is a tape of so many numbers for each, it is written.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn forward(
        &mut self,
        exec: &dyn Exec,
        steps: usize,
        (tape, len): (&mut [T], usize),
    ) -> Result<(), Stop> {
        for step in 0..steps {
            self.step(exec, step)?;
            if let Some(tape) = tape
                .get_mut(step * len..(step + 1) * len)
                .filter(|tape| !tape.is_empty())
            {
                self.flow.record(tape);
            }
            let script = &mut *self.script;
            self.flow.seen(|seen| script.see(exec, step + 1, seen));
        }
        Ok(())
    }

    fn back(&mut self, exec: &dyn Exec, step: usize) {
        let Self { flow, script, .. } = self;
        flow.seen(|seen| script.add_adjoint(exec, step + 1, seen));
        flow.take_back(exec);
        flow.taken_back(|cells, fields, sums| script.take_gradient(exec, cells, step, fields, sums));
    }

    /// Takes all steps back from a tape.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn backward_on_tape(
        &mut self,
        exec: &dyn Exec,
        steps: usize,
        (tape, len): (&[T], usize),
    ) -> Result<(), Stop> {
        self.flow.clear_adjoints();
        for step in (0..steps).rev() {
            Stop::heard(self.observer)?;
            self.flow
                .replay(tape.get(step * len..(step + 1) * len).unwrap_or_default());
            if self.script.looks_at(step + 1) {
                self.flow.carry_density(exec);
            }
            self.push(exec, step);
            self.back(exec, step);
        }
        Ok(())
    }

    /// Takes all steps back from the state at hand, that at the start, by states that are kept in `slots`; steps that were repeated.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn backward(
        &mut self,
        exec: &dyn Exec,
        steps: usize,
        slots: &mut [T],
        kept: &mut [usize],
    ) -> Result<usize, Stop> {
        self.flow.clear_adjoints();
        reverse_all(self, exec, steps, slots, kept)
    }
}

impl<T: Real> Reversible<T> for March<'_, '_, T> {
    type Error = Stop;

    fn advance(&mut self, exec: &dyn Exec, step: usize) -> Result<(), Stop> {
        self.step(exec, step)
    }

    fn reverse(&mut self, exec: &dyn Exec, step: usize) -> Result<(), Stop> {
        self.step(exec, step)?;
        self.back(exec, step);
        Ok(())
    }

    fn store(&self, slot: &mut [T]) {
        self.flow.store(slot);
    }

    fn restore(&mut self, slot: &[T]) {
        self.flow.restore(slot);
    }
}
