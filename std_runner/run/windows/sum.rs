//! What all windows come to together.

use crate::checkpoint::Words;
use crate::problem::OwnedProblem;
use crate::remarks::{KeyframeError, mass};
use crate::report::WindowRecord;
use crate::run::found::{Found, density_range, leaves};
use crate::run::saved::objective;
use crate::windows::Window;
use thurible_core::checkpoint::Damaged;
use thurible_core::{Exec, Objective, Real, Solver, Space, Status};

/// The windows so far, and sums over what they keep.
pub(super) struct Sum {
    pub windows: Vec<WindowRecord>,
    objective: Objective,
    /// What of it is the price of the last force, and of a keyframe at the step after those that are kept.
    of_last: Objective,
    /// The smallest and the largest density.
    densities: [f64; 2],
    /// The largest density and the mass at the start.
    source: [f64; 2],
    /// The mass at the end.
    mass: f64,
}

impl Default for Sum {
    fn default() -> Self {
        Self {
            windows: Vec::new(),
            objective: Objective::default(),
            of_last: Objective::default(),
            densities: [f64::INFINITY, f64::NEG_INFINITY],
            source: [0.0; 2],
            mass: 0.0,
        }
    }
}

impl Sum {
    /// Adds what a finished `solver` keeps of `window`; what was left to itself has no price.
    pub fn add<T: Real, S: Space>(
        &mut self,
        solver: &mut Solver<'_, T, S>,
        exec: &dyn Exec,
        window: &Window,
        is_free: bool,
    ) {
        self.of_last = Objective::default();
        if !is_free {
            let last = *window.judges().end() - window.start;
            let all = solver.objective_of(exec, last, window.forces());
            let before = solver.objective_of(exec, last - 1, window.forces().saturating_sub(1));
            self.of_last = combined(all, -1.0, before);
            self.objective = combined(self.objective, 1.0, all);
        }
        let kept = 0..window.keeps + usize::from(window.is_last);
        let [least, most] = density_range(solver, kept);
        self.densities = [self.densities[0].min(least), self.densities[1].max(most)];
        if window.start == 0 {
            self.source = [density_range(solver, 0..1)[1], solver.mass_at(0)];
        }
        self.mass = mass(solver, window.keeps);
    }

    /// Passes over all of it.
    pub fn record(&mut self, words: &mut Words) -> Result<(), Damaged> {
        words.list(&mut self.windows, WindowRecord::default(), window)?;
        for sum in [&mut self.objective, &mut self.of_last] {
            let mut record = (*sum).into();
            objective(words, &mut record)?;
            *sum = Objective {
                data: record.data,
                force: record.force,
                plain: record.plain,
                initial: record.initial.unwrap_or(0.0),
            };
        }
        let numbers = self.densities.iter_mut().chain(&mut self.source);
        numbers
            .chain([&mut self.mass])
            .try_for_each(|number| words.real(number))
    }

    /// Takes out what the end of the last window adds, where no window goes on from there.
    pub fn leave_last_out(&mut self) {
        self.objective = combined(self.objective, -1.0, self.of_last);
    }

    /// The status of the window that ended worst.
    pub fn worst(&self) -> Status {
        let rank = |status: &Status| match status {
            Status::Converged => 0,
            Status::MaxIterations => 1,
            Status::Stalled => 2,
            Status::NotFinite | Status::NotReady => 3,
            Status::Cancelled => 4,
        };
        let all = self.windows.iter().map(|window| window.status);
        all.max_by_key(rank).unwrap_or(Status::Converged)
    }

    /// What all windows came to of `problem`, with the keyframes that were judged and the mass that emitters made.
    pub fn found(&mut self, problem: &OwnedProblem, mut errors: Vec<KeyframeError>, emitted: f64) -> Found {
        // With emitters the densest smoke of all steps.
        let there = if problem.emitters.is_empty() {
            self.source[0]
        } else {
            self.densities[1].max(0.0)
        };
        errors.iter_mut().for_each(|error| error.denser /= there);
        Found {
            errors,
            densities: self.densities,
            outflow: leaves(problem).then(|| self.source[1] + emitted - self.mass),
            objective: self.objective,
            templates: Vec::new(),
            windows: core::mem::take(&mut self.windows),
        }
    }
}

/// Passes over what is told of a window.
fn window(words: &mut Words, record: &mut WindowRecord) -> Result<(), Damaged> {
    words.count(&mut record.start)?;
    words.count(&mut record.steps)?;
    words.count(&mut record.kept)?;
    words.counts(&mut record.keyframes)?;
    words.option(&mut record.ahead, Words::count)?;
    words.flag(&mut record.continued)?;
    words.count(&mut record.iterations)?;
    words.named(&mut record.status)?;
    objective(words, &mut record.objective)?;
    words.real(&mut record.seconds)
}

/// The sum of `one` and `s` times `other`.
fn combined(one: Objective, s: f64, other: Objective) -> Objective {
    Objective {
        data: one.data + s * other.data,
        force: one.force + s * other.force,
        plain: one.plain + s * other.plain,
        initial: one.initial + s * other.initial,
    }
}
