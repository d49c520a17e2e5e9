//! Into a window: a solver for it, at its start or in the middle of it.

use super::ahead::{Aim, Look};
use super::walk::{Inside, Walk};
use crate::exit::Failure;
use crate::output::{Sample, Samples};
use crate::problem::OwnedProblem;
use crate::progress::Watch;
use crate::run::drawn::refuse;
use crate::run::inputs::set_mask;
use crate::run::saved::Reading;
use crate::run::stages::{Led, Stage};
use crate::run::targets::{Which, set_keyframes};
use crate::windows::Window;
use core::mem::MaybeUninit;
use thurible_core::{Method, Params, Real, Solver, Space};

/// A window that is under way.
type Entered<'m, T, S> = (Led<'m, T, S>, OwnedProblem, Window, Inside);

impl Walk<'_> {
    /// A solver at the start of a window; `None` where the user stopped it on the way.
    pub(super) fn enter<'m, T: Real + Sample, S: Space>(
        &mut self,
        block: &'m mut [MaybeUninit<u8>],
        watch: &mut Watch,
        window: &Window,
    ) -> Result<Option<Entered<'m, T, S>>, Failure> {
        watch.enter_window(self.number);
        let (second, iteration) = (watch.clock.seconds(), watch.history.len());
        let look = Look {
            job: self.job,
            exec: self.exec,
            masses: self.masses.as_deref(),
        };
        let aim = match look.along::<T, S>(&mut self.left, block, watch, (self.number, window))? {
            Aim::At(density) => Some(density),
            Aim::Nowhere => None,
            Aim::Cancelled if self.left.is_there() => return Ok(None),
            Aim::Cancelled => None,
        };
        let mut inside = Inside {
            aimed: aim.is_some(),
            second,
            iteration,
            ..Inside::default()
        };
        let (mut solver, problem) = self.solver::<T, S>(block, inside)?;
        let window = window.with_aim(inside.aimed);
        self.begin(&mut solver, watch, &window, aim)?;
        inside.continued = self.go_on_searching(&mut solver, &window)?;
        Ok(Some((solver, problem, window, inside)))
    }

    /// A solver in the middle of a window.
    pub(super) fn reenter<'m, T: Real + Sample, S: Space>(
        &mut self,
        block: &'m mut [MaybeUninit<u8>],
        window: &Window,
        inside: Inside,
        reading: &mut Reading<'_>,
    ) -> Result<Entered<'m, T, S>, Failure> {
        let (mut solver, problem) = self.solver::<T, S>(block, inside)?;
        let window = window.with_aim(inside.aimed);
        self.job.restore(reading, &mut solver)?;
        Ok((solver, problem, window, inside))
    }

    /// A solver for the next window, and its problem.
    fn solver<'m, T: Real, S: Space>(
        &self,
        block: &'m mut [MaybeUninit<u8>],
        inside: Inside,
    ) -> Result<(Led<'m, T, S>, OwnedProblem), Failure> {
        self.job.lead(Stage::Window(self.number, inside.aimed), block)
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
            // Those that it is not judged by in the end come last.
            self.mass_factors.extend(factors);
        }
        if is_first {
            notes.iter().for_each(|note| watch.display.file_note(note));
            self.job.prepare(solver, self.exec, watch)?;
        }
        Ok(())
    }

    /// Lets the search begin with the rest of the window before, unless the method begins on coarser grids by itself, which leads as far;
    /// whether it does.
    fn go_on_searching<T: Real + Sample, S: Space>(
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
}
