//! From window to window: each in the block that the one before had, and what comes of all of them.

use super::ahead::{Aim, Look, check_keyframes, free_masses};
use super::kept::Kept;
use super::left::Left;
use super::sum::Sum;
use crate::destination::Aside;
use crate::exit::Failure;
use crate::output::{Precision, Sample, Samples};
use crate::plan;
use crate::problem::OwnedProblem;
use crate::progress::Watch;
use crate::report::WindowRecord;
use crate::run::drawn::refuse;
use crate::run::found::Found;
use crate::run::frames::SolverFrames;
use crate::run::inputs::{set_mask, solver_refusal};
use crate::run::job::{Job, iterate};
use crate::run::messages::not_finite;
use crate::run::targets::{Which, set_keyframes};
use crate::windows::Window;
use core::mem::MaybeUninit;
use thurible_core::method::registry::steers;
use thurible_core::{Exec, Method, Params, Progress, Real, Solver, Space, Status};

/// How far the windows have come.
pub(super) struct Walk<'a> {
    job: &'a Job,
    exec: &'a dyn Exec,
    left: Left,
    /// The same of a flow that nothing steers, where keyframes take its mass.
    free: Left,
    pub kept: Kept,
    /// The mass of such a flow at every step.
    masses: Option<Vec<f64>>,
    mass_factors: Vec<f64>,
    sum: Sum,
    over: bool,
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
        let left = |name| Left::new(&scratch, name, dims, Samples::new(precision));
        Ok(Self {
            left: left("left")?,
            free: left("free")?,
            kept: Kept::new(scratch, &job.planned.problem, precision),
            job,
            exec,
            masses: None,
            mass_factors: Vec::new(),
            sum: Sum::default(),
            over: false,
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

    /// The parameters of a window.
    fn params(&self, is_searched: bool) -> Params {
        let params = &self.job.planned.params;
        if is_searched { *params } else { plan::free(params) }
    }

    /// Looks at the whole scene before the first window: whether smoke can come to every keyframe, and which mass it has there.
    pub fn look_ahead<T: Real + Sample, S: Space>(
        &mut self,
        block: &mut [MaybeUninit<u8>],
    ) -> Result<(), Failure> {
        if self.steers() {
            check_keyframes(&self.job.request.scene)?;
            self.masses = free_masses::<T, S>(self.job, self.exec, &mut self.free, block)?;
        }
        Ok(())
    }

    /// Solves a window, and takes what it keeps; how all of them ended so far.
    pub fn through<T: Real + Sample, S: Space>(
        &mut self,
        block: &mut [MaybeUninit<u8>],
        watch: &mut Watch,
        window: &Window,
    ) -> Result<Status, Failure> {
        let begun = (watch.clock.seconds(), watch.history.len());
        let look = Look {
            job: self.job,
            exec: self.exec,
            masses: self.masses.as_deref(),
        };
        let aim = match look.along::<T, S>(&mut self.left, block, watch, window)? {
            Aim::At(density) => Some(density),
            Aim::Nowhere => None,
            Aim::Cancelled if self.left.is_there() => return self.end_before(window, Status::Cancelled),
            Aim::Cancelled => None,
        };
        let mut window = window.clone();
        window.ahead = window.ahead.filter(|_| aim.is_some());
        let problem = window.problem(&self.job.planned.problem);
        let mut solver = Solver::<T, S>::new(&problem.problem(), &self.params(window.is_searched()), block)
            .map_err(|error| solver_refusal(&error))?;
        self.begin(&mut solver, watch, &window, aim)?;
        let continued = self.go_on(&mut solver, &window)?;
        let ended = self.iterate(&mut solver, watch, &window);
        let unfinished = ended == Status::NotReady || solver.finish(self.exec).is_err();
        let useless = unfinished || (ended == Status::Cancelled && !window.is_searched());
        if useless && self.left.is_there() {
            return self.end_before(&window, ended);
        }
        if unfinished {
            watch.display.close();
            return Err(not_finite(&self.job.request.scene));
        }
        if ended == Status::Cancelled {
            (window.is_last, window.keeps) = (true, window.steps);
        }
        self.record(&solver, watch, &window, (ended, continued), begun);
        self.take(&mut solver, &problem, &window)?;
        Ok(self.sum.worst())
    }

    /// Notes how a window went, which began at a second and an iteration.
    fn record<T: Real, S: Space>(
        &mut self,
        solver: &Solver<'_, T, S>,
        watch: &Watch,
        window: &Window,
        (ended, continued): (Status, bool),
        (second, iteration): (f64, usize),
    ) {
        let steps = &self.job.planned.problem.keyframes;
        let step = |number: &usize| steps.get(*number).copied();
        self.sum.windows.push(WindowRecord {
            start: window.start,
            steps: window.steps,
            kept: window.keeps,
            keyframes: window.keyframes.iter().filter_map(step).collect(),
            ahead: window.beyond().and_then(|number| step(&number)),
            continued,
            iterations: watch.history.len() - iteration,
            status: ended.of_result(true),
            objective: solver.objective().into(),
            seconds: watch.clock.seconds() - second,
        });
    }

    /// Hands a solver what its window begins with.
    fn begin<T: Real + Sample, S: Space>(
        &mut self,
        solver: &mut Solver<'_, T, S>,
        watch: &Watch,
        window: &Window,
        aim: Option<Samples>,
    ) -> Result<(), Failure> {
        let request = &self.job.request;
        let (scene, from, is_first) = (&request.scene, request.from.as_ref(), !self.left.is_there());
        let mut notes = Vec::new();
        self.left.begin(scene, from, window, solver, &mut notes)?;
        if window.is_searched() {
            set_mask(scene, solver, &mut notes)?;
            let which = Which {
                masses: self.masses.as_deref(),
                among: Some(&window.keyframes),
            };
            let factors = set_keyframes(scene, solver, which, &mut notes)?;
            if let Some(mut aim) = aim {
                let last = window.keyframes.len();
                solver
                    .set_keyframe(last, T::list(&mut aim))
                    .map_err(refuse(scene, "keyframe"))?;
            }
            let judged = window.keyframes.iter().zip(factors);
            let steps = &self.job.planned.problem.keyframes;
            let own = judged.filter(|(number, _)| {
                steps
                    .get(**number)
                    .is_some_and(|step| window.judges().contains(step))
            });
            self.mass_factors.extend(own.map(|(_, factor)| factor));
        }
        if is_first {
            notes.iter().for_each(|note| watch.display.file_note(note));
            self.job.prepare(solver, self.exec, watch)?;
        }
        Ok(())
    }

    /// Lets the search begin with the rest of the window before, unless the method begins on coarser grids by itself, which leads as far;
    /// whether it does.
    fn go_on<T: Real + Sample, S: Space>(
        &mut self,
        solver: &mut Solver<'_, T, S>,
        window: &Window,
    ) -> Result<bool, Failure> {
        let Params {
            method,
            direct,
            lbfgs,
            ..
        } = self.job.planned.params;
        let continues = match method {
            Method::Direct => !direct.nested,
            Method::Lbfgs => !lbfgs.nested,
            _ => false,
        };
        if !(continues && window.is_searched() && self.left.is_there()) {
            return Ok(false);
        }
        self.left.give(solver, window.steps)?;
        Ok(solver.begin_at_given(self.exec).unwrap_or(false))
    }

    /// Iterates to the end; what is only simulated is no iteration of a search.
    fn iterate<T: Real, S: Space>(
        &self,
        solver: &mut Solver<'_, T, S>,
        watch: &mut Watch,
        window: &Window,
    ) -> Status {
        if window.is_searched() || !self.steers() {
            return iterate(solver, self.exec, watch, None);
        }
        loop {
            let Progress { status, .. } = solver.step(self.exec, watch);
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
        let found = self.sum.found(problem, core::mem::take(errors), *emitted);
        (found, core::mem::take(&mut self.mass_factors))
    }
}
