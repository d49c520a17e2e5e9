//! Seconds by phase.

use core::time::Duration;
use std::time::Instant;

/// Time and number of calls of one phase.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spent {
    /// Total time.
    pub time: Duration,
    /// How often it was entered.
    pub calls: usize,
}

impl Spent {
    /// Seconds in all.
    pub fn seconds(&self) -> f64 {
        self.time.as_secs_f64()
    }

    /// Seconds per call, 0 before the first.
    pub fn average(&self) -> f64 {
        if self.calls == 0 {
            0.0
        } else {
            self.seconds() / self.calls as f64
        }
    }
}

/// A stopwatch for the whole solve and for the phases of its iterations.
#[derive(Clone, Debug)]
pub struct Clock {
    start: Instant,
    /// Seconds of an earlier run that this one goes on from.
    before: f64,
    running: Option<(&'static str, Instant)>,
    /// The phases that were entered so far, by name.
    phases: Vec<(&'static str, Spent)>,
    /// Seconds from the start of the program to that of the solve.
    pub begun: f64,
    /// Seconds of the nested start: from there to the first iteration on the finest grid.
    pub nested: f64,
    /// Seconds from the start to the end of the last iteration.
    pub solved: f64,
    /// Seconds from the start to the feasible result.
    pub finished: f64,
}

impl Clock {
    /// A clock that starts now, in no phase.
    pub fn start() -> Self {
        Clock {
            start: Instant::now(),
            before: 0.0,
            running: None,
            phases: Vec::new(),
            begun: 0.0,
            nested: 0.0,
            solved: 0.0,
            finished: 0.0,
        }
    }

    /// What was spent in the phase with this name, so far.
    pub fn spent(&self, phase: &str) -> Spent {
        let found = self.phases.iter().find(|(name, _)| *name == phase);
        found.map_or_else(Spent::default, |(_, spent)| *spent)
    }

    /// All phases that were entered so far, by name, and the seconds before this run.
    pub fn state(&mut self) -> (&mut Vec<(&'static str, Spent)>, &mut f64) {
        (&mut self.phases, &mut self.before)
    }

    /// What was spent in all phases, so far.
    pub fn in_phases(&self) -> f64 {
        self.phases.iter().map(|(_, spent)| spent.seconds()).sum()
    }

    /// Seconds since the start of the program.
    pub fn total(&self) -> f64 {
        self.before + self.start.elapsed().as_secs_f64()
    }

    /// Seconds since the solve began.
    pub fn seconds(&self) -> f64 {
        self.total() - self.begun
    }

    /// Notes that the solve begins.
    pub fn begin(&mut self) {
        self.begun = self.total();
    }

    /// Notes that the nested start is over and the first iteration on the finest grid begins.
    pub fn nested(&mut self) {
        self.nested = self.seconds();
    }

    /// Notes that the last iteration is over.
    pub fn solved(&mut self) {
        self.leave();
        self.solved = self.total();
    }

    /// Notes that the result is feasible.
    pub fn finished(&mut self) {
        self.finished = self.total();
    }

    /// Enters `phase`; a phase that is still running is left.
    pub fn enter(&mut self, phase: &'static str) {
        self.leave();
        self.running = Some((phase, Instant::now()));
    }

    /// Leaves the running phase, if there is one.
    pub fn leave(&mut self) {
        if let Some((phase, since)) = self.running.take() {
            let known = self.phases.iter().position(|(name, _)| *name == phase);
            let index = known.unwrap_or_else(|| {
                self.phases.push((phase, Spent::default()));
                self.phases.len() - 1
            });
            let spent = &mut self.phases[index].1;
            spent.time = spent.time.saturating_add(since.elapsed());
            spent.calls += 1;
        }
    }
}

/// A duration as `1:02:03`, `02:03`, or `4.5 s` below a minute.
pub fn in_words(seconds: f64) -> String {
    if seconds < 60.0 {
        return format!("{:.1} s", seconds.max(0.0));
    }
    let whole = seconds.min(1e9) as u64;
    let (hours, minutes, rest) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 {
        format!("{hours}:{minutes:02}:{rest:02}")
    } else {
        format!("{minutes:02}:{rest:02}")
    }
}
