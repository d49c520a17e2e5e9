//! What a solve or a search does, iteration by iteration.

use crate::keep::Keep;
use crate::place::Number;
use thurible_core::{Exec, Fluids, Observer, Progress, Solver, Space};

/// What goes on iteration by iteration.
pub trait Iterated: Send {
    /// One iteration.
    fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress;

    /// After an iteration that is not the last.
    fn after(&mut self) {}

    /// Makes the result feasible; whether there is one.
    fn finish(&mut self, exec: &dyn Exec) -> bool {
        let _ = exec;
        true
    }
}

/// A solver whose state is kept.
pub struct Kept<'k, 's, 'm, T, S> {
    /// The solver.
    pub solver: &'s mut Solver<'m, T, S>,
    /// What keeps its state, if anything does.
    pub keep: Option<&'k mut Keep>,
}

impl<T: Number, S: Space + Send> Iterated for Kept<'_, '_, '_, T, S> {
    fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        self.solver.step(exec, observer)
    }

    fn after(&mut self) {
        if let Some(keep) = &mut self.keep {
            keep.after(self.solver);
        }
    }

    fn finish(&mut self, exec: &dyn Exec) -> bool {
        self.solver.finish(exec).is_ok()
    }
}

impl<T: Number, S: Space + Send> Iterated for Fluids<'_, T, S> {
    fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        Fluids::step(self, exec, observer)
    }
}
