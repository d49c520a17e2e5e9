//! The stages of a job, which have a solver each, one after the other in the same block: the scene or its windows, and what is looked at before. Where
//! ranks share the scene, the first one says which stage comes next, and the others follow its solver.

use super::inputs::solver_refusal;
use super::job::Job;
use crate::among::agreed;
use crate::checkpoint::{PartFiles, unlike_ranks};
use crate::exit::Failure;
use crate::plan::Planned;
use crate::problem::OwnedProblem;
use core::mem::MaybeUninit;
use core::ops::{Deref, DerefMut};
use std::thread;
use thurible_core::checkpoint::{Mix, Resumable};
use thurible_core::exec::ranks::tell;
use thurible_core::grid::Share;
use thurible_core::{Exec, Params, Real, Solver, SolverError, Space};

/// What has a solver of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
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

impl Stage {
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

    /// That of these numbers.
    fn of_words([kind, number, aimed]: [usize; 3]) -> Option<Self> {
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
        let whole = &planned.problem;
        let (problem, is_searched) = match self {
            Self::Whole => (whole.clone(), true),
            Self::Free => (whole.unsteered(), false),
            Self::FreeWindow(number) => {
                let free = whole.unsteered();
                (planned.windows?.of(&free).get(number)?.problem(&free), false)
            }
            Self::Way(number) => (planned.windows().get(number)?.way(whole)?, true),
            Self::Window(number, aimed) => {
                let window = planned.windows().get(number)?.with_aim(aimed);
                (window.problem(whole), window.is_searched())
            }
        };
        let params = planned.choices(&problem, is_searched);
        Some((problem, params))
    }
}

/// What is told when there is no stage any more.
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
    /// A solver for a stage, which the other ranks make too, and follow; and its problem.
    pub(super) fn lead<'m, T: Real, S: Space>(
        &self,
        stage: Stage,
        block: &'m mut [MaybeUninit<u8>],
    ) -> Result<(Led<'m, T, S>, OwnedProblem), Failure> {
        self.lead_unless(stage, block, solver_refusal)
    }

    /// The same, where `refusal` says what it means that the block does not suit it.
    pub(super) fn lead_unless<'m, T: Real, S: Space>(
        &self,
        stage: Stage,
        block: &'m mut [MaybeUninit<u8>],
        refusal: impl FnOnce(&SolverError) -> Failure,
    ) -> Result<(Led<'m, T, S>, OwnedProblem), Failure> {
        self.said(stage.words());
        let (problem, params) = stage.of(&self.planned).ok_or_else(unlike_ranks)?;
        let solver = Solver::new(&problem.problem(), &params, block);
        let solver = solver.map_err(|error| refusal(&error))?;
        Ok((Led(self.shared(solver, problem.share)?), problem))
    }

    /// A solver that the other ranks share; refuses ranks that were given another scene, other options or another program than the first one, before any
    /// message goes by what these say.
    fn shared<'m, T: Real, S: Space>(
        &self,
        mut solver: Solver<'m, T, S>,
        share: Option<Share>,
    ) -> Result<Solver<'m, T, S>, Failure> {
        let Some(ranks) = self.options.ranks else {
            return Ok(solver);
        };
        let mut mark = Mix::new();
        mark.word(solver.fingerprint());
        for count in share.iter().flat_map(|share| [share.ranks, share.beside]) {
            mark.word(count as u64);
        }
        mark.bytes(env!("CARGO_PKG_VERSION").as_bytes());
        let own = mark.finish();
        let mut first = [own];
        tell(ranks, 0, &mut first);
        let alike = (first == [own]).then_some(()).ok_or_else(|| {
            Failure::Input(
                "its scene, its options or its program is not the first rank's; give all of them the same"
                    .into(),
            )
        });
        agreed(ranks, alike)?;
        solver.share(ranks);
        Ok(solver)
    }

    /// Lets the other ranks go, which followed stage after stage.
    pub(super) fn dismiss(&self) {
        self.said(OVER);
    }

    /// The words of the first rank.
    fn said(&self, mut words: [usize; 3]) -> [usize; 3] {
        if let Some(ranks) = self.options.ranks {
            tell(ranks, 0, &mut words);
        }
        words
    }

    /// Follows the first rank through all stages.
    pub(super) fn follow_through<T: Real, S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
    ) -> Result<(), Failure> {
        let mut states = PartFiles::following(self.options.ranks);
        loop {
            let words = self.said(OVER);
            if words == OVER {
                return Ok(());
            }
            let stage = Stage::of_words(words).and_then(|stage| stage.of(&self.planned));
            let (problem, params) = stage.ok_or_else(unlike_ranks)?;
            let solver = Solver::<T, S>::new(&problem.problem(), &params, block);
            let solver = solver.map_err(|error| solver_refusal(&error))?;
            let mut solver = self.shared(solver, problem.share)?;
            solver.follow(exec, &mut states);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_is_what_is_heard() {
        let stages = [Stage::Whole, Stage::Free, Stage::FreeWindow(3), Stage::Way(2)];
        let windows = [Stage::Window(4, false), Stage::Window(5, true)];
        for stage in stages.into_iter().chain(windows) {
            assert_ne!(stage.words(), OVER);
            assert_eq!(Stage::of_words(stage.words()), Some(stage));
        }
        assert_eq!(Stage::of_words(OVER), None);
    }
}
