//! What a solve or a search does, iteration by iteration.

use crate::keep::Keep;
use crate::place::Number;
use thurible_core::checkpoint::Resumable;
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

/// One whose state is kept.
pub struct Kept<'k, 's, I> {
    /// What goes on.
    pub one: &'s mut I,
    /// What keeps its state, if anything does.
    pub keep: Option<&'k mut Keep>,
}

impl<I: Iterated + Resumable> Iterated for Kept<'_, '_, I> {
    fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        self.one.step(exec, observer)
    }

    fn after(&mut self) {
        if let Some(keep) = &mut self.keep {
            keep.after(self.one);
        }
    }

    fn finish(&mut self, exec: &dyn Exec) -> bool {
        self.one.finish(exec)
    }
}

impl<T: Number, S: Space + Send> Iterated for Solver<'_, T, S> {
    fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        Solver::step(self, exec, observer)
    }

    fn finish(&mut self, exec: &dyn Exec) -> bool {
        Solver::finish(self, exec).is_ok()
    }
}

impl<T: Number, S: Space + Send> Iterated for Fluids<'_, T, S> {
    fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        Fluids::step(self, exec, observer)
    }
}
