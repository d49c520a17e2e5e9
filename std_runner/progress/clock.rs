//! Seconds by phase.

use core::time::Duration;
use std::time::Instant;

/// A phase of an ADMM iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The advection problem.
    Ao,
    /// The Navier-Stokes problem.
    Nso,
}

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

/// A stopwatch for the whole solve and for the phases of ADMM.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    running: Option<(Phase, Instant)>,
    /// The advection problem so far.
    pub ao: Spent,
    /// The Navier-Stokes problem so far.
    pub nso: Spent,
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
        let never = Spent::default();
        Clock {
            start: Instant::now(),
            running: None,
            ao: never,
            nso: never,
            begun: 0.0,
            nested: 0.0,
            solved: 0.0,
            finished: 0.0,
        }
    }

    /// Seconds since the start of the program.
    pub fn total(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
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
    pub fn enter(&mut self, phase: Phase) {
        self.leave();
        self.running = Some((phase, Instant::now()));
    }

    /// Leaves the running phase, if there is one.
    pub fn leave(&mut self) {
        if let Some((phase, since)) = self.running.take() {
            let spent = match phase {
                Phase::Ao => &mut self.ao,
                Phase::Nso => &mut self.nso,
            };
            spent.time += since.elapsed();
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
