//! From window to window: each in the block that the one before had, and what comes of all of them.

use super::kept::Kept;
use super::left::Left;
use super::sum::Sum;
use crate::checkpoint::Keeper;
use crate::destination::Aside;
use crate::exit::Failure;
use crate::output::{Precision, Sample, Samples};
use crate::problem::OwnedProblem;
use crate::progress::Watch;
use crate::report::WindowRecord;
use crate::run::found::Found;
use crate::run::frames::SolverFrames;
use crate::run::job::{Job, iterate, show};
use crate::run::messages;
use crate::run::saved::{self, Reading};
use crate::windows::Window;
use core::mem::MaybeUninit;
use thurible_core::method::registry::steers;
use thurible_core::{Exec, Progress, Real, Solver, Space, Status};

/// How far the windows have come.
pub(super) struct Walk<'a> {
    pub(super) job: &'a Job,
    pub(super) exec: &'a dyn Exec,
    pub(super) left: Left,
    pub kept: Kept,
    /// The mass at every step of a flow that nothing steers, where keyframes take that.
    pub masses: Option<Vec<f64>>,
    pub(super) mass_factors: Vec<f64>,
    pub(super) sum: Sum,
    pub(super) over: bool,
    /// The number of the next window, and what is remembered of it while it is under way.
    pub(super) number: usize,
    pub(super) inside: Option<Inside>,
    pub(super) ended: Status,
    pub(super) nested: f64,
    /// The steps of a first window that was stopped while it was simulated.
    simulated: Option<usize>,
    /// Where a window began whose flow became too fast to follow.
    too_fast: Option<usize>,
}

/// What is remembered of a window that is under way.
#[derive(Clone, Copy, Default)]
pub(super) struct Inside {
    /// Whether there is a target where the way ahead leads.
    pub(super) aimed: bool,
    /// Whether its search began with what was left of the window before.
    pub(super) continued: bool,
    /// When it began, and at which iteration.
    pub(super) second: f64,
    pub(super) iteration: usize,
}

impl<'a> Walk<'a> {
    /// At the start, with files in `scratch`.
    pub fn new(
        job: &'a Job,
        scratch: Aside,
        exec: &'a dyn Exec,
        precision: Precision,
    ) -> Result<Self, Failure> {
        let dims = job.planned.problem.cells.len();
        Ok(Self {
            left: Left::new(&scratch, "left", dims, Samples::new(precision))?,
            kept: Kept::new(scratch, &job.planned.problem, precision),
            job,
            exec,
            masses: None,
            mass_factors: Vec::new(),
            sum: Sum::default(),
            over: false,
            number: 0,
            inside: None,
            ended: Status::Converged,
            nested: 0.0,
            simulated: None,
            too_fast: None,
        })
    }

    /// Whether there is nothing more to solve.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Whether the scene asks for a force at all.
    fn steers(&self) -> bool {
        steers(&self.job.planned.params)
    }

    /// The number of the next window.
    pub fn number(&self) -> usize {
        self.number
    }

    /// How all windows ended so far.
    pub fn ended(&self) -> Status {
        self.ended
    }

    /// Where a flow became too fast to follow, and the result ends.
    pub fn too_fast(&self) -> Option<usize> {
        self.too_fast
    }

    /// How far the only window came, where it was simulated and stopped on the way.
    pub fn simulated(&self) -> Option<usize> {
        self.simulated
    }

    /// The seconds of their nested starts.
    pub fn nested(&self) -> f64 {
        self.nested
    }

    /// Solves a window, on from the state that is left to read if there is one, and takes what it keeps; how all of them ended so far.
    pub fn through<T: Real + Sample, S: Space>(
        &mut self,
        block: &mut [MaybeUninit<u8>],
        (watch, keeper): (&mut Watch, &mut Keeper),
        window: &Window,
        reading: Option<Reading<'_>>,
    ) -> Result<Status, Failure> {
        let before = self.inside.take().zip(reading);
        let entered = match before {
            Some((inside, mut reading)) => Some(self.reenter::<T, S>(block, window, inside, &mut reading)?),
            None => self.enter::<T, S>(block, watch, window)?,
        };
        let Some((mut solver, problem, mut window, inside)) = entered else {
            self.ended = self.end_before(window, Status::Cancelled)?;
            return Ok(self.ended);
        };
        self.inside = Some(inside);
        watch.search_window();
        let ended = self.iterate(&mut solver, watch, keeper, (&window, &problem));
        self.inside = None;
        self.nested += (watch.clock.nested - inside.second).max(0.0);
        let unfinished = ended == Status::NotReady || solver.finish(self.exec).is_err();
        // Behind where a simulation ended early its flow stands still.
        let is_short = matches!(ended, Status::Cancelled | Status::NotFinite) && !window.is_searched();
        if (unfinished || is_short) && self.left.is_there() {
            if ended != Status::Cancelled {
                self.too_fast = Some(window.start);
            }
            self.ended = self.end_before(&window, ended.of_result(true))?;
            return Ok(self.ended);
        }
        if unfinished {
            watch.display.close();
            return Err(messages::without_flow(&self.job.request.scene, ended, keeper));
        }
        if ended == Status::Cancelled || is_short {
            (window.is_last, window.keeps) = (true, window.steps);
        }
        if is_short && ended == Status::Cancelled && watch.simulated() < window.steps {
            self.simulated = Some(watch.simulated());
        }
        self.note(&solver, watch, &window, (ended, inside));
        self.take(&mut solver, &problem, &window)?;
        self.number += 1;
        self.ended = if is_short { ended } else { self.sum.worst() };
        if !self.over && keeper.is_due(watch) {
            self.keep(watch, keeper, &mut |_| Ok(()));
        }
        Ok(self.ended)
    }

    /// Notes how a window went.
    fn note<T: Real, S: Space>(
        &mut self,
        solver: &Solver<'_, T, S>,
        watch: &Watch,
        window: &Window,
        (ended, inside): (Status, Inside),
    ) {
        let steps = &self.job.planned.problem.keyframes;
        let step = |number: &usize| steps.get(*number).copied();
        self.sum.windows.push(WindowRecord {
            start: window.start,
            steps: window.steps,
            kept: window.keeps,
            keyframes: window.keyframes.iter().filter_map(step).collect(),
            ahead: window.beyond().and_then(|number| step(&number)),
            continued: inside.continued,
            iterations: watch.history.len() - inside.iteration,
            status: ended.of_result(true),
            objective: solver.objective().into(),
            seconds: watch.clock.seconds() - inside.second,
        });
    }

    /// Iterates to the end, and keeps states; what is only simulated is no iteration of a search.
    fn iterate<T: Real + Sample, S: Space>(
        &mut self,
        solver: &mut Solver<'_, T, S>,
        watch: &mut Watch,
        keeper: &mut Keeper,
        (window, problem): (&Window, &OwnedProblem),
    ) -> Status {
        let exec = self.exec;
        if window.is_searched() || !self.steers() {
            let mut each = |solver: &mut Solver<'_, T, S>, watch: &mut Watch| {
                show(solver, exec, problem, watch, window.start);
                if keeper.is_due(watch) {
                    self.keep(watch, keeper, &mut |saving| saved::write_shared(solver, saving));
                }
            };
            return iterate(solver, exec, watch, None, &mut each);
        }
        loop {
            let Progress { status, .. } = solver.step(exec, watch);
            if let Some(status) = status {
                return status;
            }
        }
    }

    /// Takes what a window keeps, and leaves the rest to the next.
    fn take<T: Real + Sample, S: Space>(
        &mut self,
        solver: &mut Solver<'_, T, S>,
        problem: &OwnedProblem,
        window: &Window,
    ) -> Result<(), Failure> {
        let is_free = self.steers() && !window.is_searched();
        self.sum.add(solver, self.exec, window, is_free);
        let factors: Vec<f64> = (0..window.steps - 1)
            .map(|slot| solver.force_factor(slot))
            .collect();
        let outputs = solver.outputs();
        let mut frames = SolverFrames::new(solver, self.exec, problem);
        self.kept
            .take::<T>(&mut frames, outputs, window, factors.into_iter(), is_free)?;
        self.mass_factors.truncate(self.kept.errors.len());
        self.over = window.is_last;
        if self.over {
            return self.kept.end(window.start + window.steps, None);
        }
        self.left.take(&frames, window)
    }

    /// Ends the result where a window that came to nothing would have begun.
    fn end_before(&mut self, window: &Window, ended: Status) -> Result<Status, Failure> {
        self.over = true;
        self.sum.leave_last_out();
        self.kept.end(window.start, Some(self.left.density()?))?;
        Ok(ended)
    }

    /// What all windows came to, and what keyframes were multiplied by.
    pub fn found(&mut self) -> (Found, Vec<f64>) {
        let Kept {
            problem,
            errors,
            emitted,
            ..
        } = &mut self.kept;
        self.mass_factors.truncate(errors.len());
        let found = self.sum.found(problem, core::mem::take(errors), *emitted);
        (found, core::mem::take(&mut self.mass_factors))
    }
}
