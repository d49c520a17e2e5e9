//! The parts of a job that have a solver each, one after the other in the same block: the scene or its windows, and what is looked at before. Where
//! ranks share the scene, the first one says which part comes next, and the others follow its solver.

use super::inputs::solver_refusal;
use super::job::Job;
use crate::checkpoint::unlike_ranks;
use crate::exit::Failure;
use crate::plan::{Planned, free};
use crate::problem::OwnedProblem;
use core::mem::MaybeUninit;
use core::ops::{Deref, DerefMut};
use std::thread;
use thurible_core::exec::ranks::tell;
use thurible_core::{Exec, Params, Real, Solver, Space};

/// A part with a solver of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The scene.
    Whole,
    /// The scene without what steers it.
    Free,
    /// Window `number` of that.
    FreeWindow(usize),
    /// The way ahead of window `number`.
    Way(usize),
    /// Window `number`, and whether it has a target where the way leads.
    Window(usize, bool),
}

impl Part {
    /// The numbers by which it is told; [`OVER`] is none of them.
    fn words(self) -> [usize; 3] {
        match self {
            Self::Whole => [1, 0, 0],
            Self::Free => [2, 0, 0],
            Self::FreeWindow(number) => [3, number, 0],
            Self::Way(number) => [4, number, 0],
            Self::Window(number, aimed) => [5, number, usize::from(aimed)],
        }
    }

    fn told([kind, number, aimed]: [usize; 3]) -> Option<Self> {
        Some(match kind {
            1 => Self::Whole,
            2 => Self::Free,
            3 => Self::FreeWindow(number),
            4 => Self::Way(number),
            5 => Self::Window(number, aimed != 0),
            _ => return None,
        })
    }

    /// Its problem, and what its solver is to do.
    fn of(self, planned: &Planned) -> Option<(OwnedProblem, Params)> {
        let problem = match self {
            Self::Whole => planned.problem.clone(),
            Self::Free => planned.problem.unsteered(),
            Self::FreeWindow(number) => {
                let whole = planned.problem.unsteered();
                planned.windows?.of(&whole).get(number)?.problem(&whole)
            }
            Self::Way(number) => planned.windows().get(number)?.way(&planned.problem)?,
            Self::Window(number, aimed) => {
                let window = planned.windows().get(number)?.with_aim(aimed);
                let problem = window.problem(&planned.problem);
                let simulated = free(&planned.params);
                let params = if window.is_searched() {
                    &planned.params
                } else {
                    &simulated
                };
                let params = planned.choices(&problem, params);
                return Some((problem, params));
            }
        };
        let params = match self {
            Self::Free | Self::FreeWindow(_) => free(&planned.params),
            _ => planned.choices(&problem, &planned.params),
        };
        Some((problem, params))
    }
}

/// What is told when there is no part any more.
const OVER: [usize; 3] = [0; 3];

/// A solver that other ranks follow, if there are any, until it is dropped.
pub(super) struct Led<'m, T: Real, S: Space>(Solver<'m, T, S>);

impl<'m, T: Real, S: Space> Deref for Led<'m, T, S> {
    type Target = Solver<'m, T, S>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<T: Real, S: Space> DerefMut for Led<'_, T, S> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl<T: Real, S: Space> Drop for Led<'_, T, S> {
    fn drop(&mut self) {
        // After a panic they may wait for something else.
        if !thread::panicking() {
            self.0.dismiss();
        }
    }
}

impl Job {
    /// A solver for a part, which the other ranks make too, and follow.
    pub(super) fn lead<'m, T: Real, S: Space>(
        &self,
        part: Part,
        block: &'m mut [MaybeUninit<u8>],
    ) -> Result<Led<'m, T, S>, Failure> {
        self.told(part.words());
        self.solver(part, block).map(Led)
    }

    /// Lets the other ranks go, which followed part after part.
    pub(super) fn dismiss(&self) {
        self.told(OVER);
    }

    /// The words of the first rank.
    fn told(&self, mut words: [usize; 3]) -> [usize; 3] {
        if let Some(ranks) = self.options.ranks {
            tell(ranks, 0, &mut words);
        }
        words
    }

    fn solver<'m, T: Real, S: Space>(
        &self,
        part: Part,
        block: &'m mut [MaybeUninit<u8>],
    ) -> Result<Solver<'m, T, S>, Failure> {
        let (problem, params) = part.of(&self.planned).ok_or_else(unlike_ranks)?;
        let mut solver =
            Solver::new(&problem.problem(), &params, block).map_err(|error| solver_refusal(&error))?;
        if let Some(ranks) = self.options.ranks {
            solver.share(ranks);
        }
        Ok(solver)
    }

    /// Follows the first rank through all parts.
    pub(super) fn follow_through<T: Real, S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
    ) -> Result<(), Failure> {
        loop {
            let words = self.told(OVER);
            if words == OVER {
                return Ok(());
            }
            let part = Part::told(words).ok_or_else(unlike_ranks)?;
            self.solver::<T, S>(part, block)?.follow(exec);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_is_what_is_heard() {
        let parts = [Part::Whole, Part::Free, Part::FreeWindow(3), Part::Way(2)];
        let windows = [Part::Window(4, false), Part::Window(5, true)];
        for part in parts.into_iter().chain(windows) {
            assert_ne!(part.words(), OVER);
            assert_eq!(Part::told(part.words()), Some(part));
        }
        assert_eq!(Part::told(OVER), None);
    }
}
