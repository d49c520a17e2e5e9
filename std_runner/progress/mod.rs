//! What the user sees while a scene is solved, and how a stop is heard.

mod clock;
mod display;
mod left;

pub use clock::{Clock, Spent, in_words};
pub use display::{Display, Mode};
pub use left::Pace;

use crate::interrupt::Interrupt;
use crate::live::Live;
use crate::report::IterationRecord;
use core::ops::ControlFlow;
use thurible_core::method::simulate::MARCH;
use thurible_core::{Event, Observer, Progress};

/// Iterations that the history reserves room for, so that it does not grow while the solve runs.
const ROWS: usize = 1024;

/// Bytes that the facts of an iteration take beside its row, at most: their names, and the residuals of its cycles.
const FACTS: usize = 768;

/// Bytes that the history reserves for a solve of at most `limit` iterations.
pub fn history_bytes(limit: usize) -> usize {
    limit.min(ROWS) * (size_of::<IterationRecord>() + FACTS)
}

/// The runner's [`Observer`]: times phases, moves the bar, keeps the history, passes on Ctrl-C.
pub struct Watch {
    /// Seconds by phase.
    pub clock: Clock,
    /// What the user sees.
    pub display: Display,
    /// All iterations so far.
    pub history: Vec<IterationRecord>,
    /// The window that is solved, where there are windows, and the iterations of those before.
    window: Option<(usize, usize)>,
    interrupt: Interrupt,
    /// How fast it comes on.
    pace: Pace,
    /// How many windows there are up to the last one that is searched.
    pub windows: usize,
    /// Seconds of all windows, if the rest of them takes as long as those before.
    whole: Option<f64>,
    /// Whether it is the search of the window that is heard of, not that of the way ahead.
    is_inside: bool,
    /// The page on which it can be watched, if there is one.
    pub live: Option<Live>,
    /// Whether the user has heard that the solve stops.
    told: bool,
    /// The steps that were simulated one after the other, where that is what is done.
    march: Option<March>,
}

/// How far a simulation has come.
#[derive(Clone, Copy)]
struct March {
    /// Velocities that are known behind the first one.
    step: usize,
    /// Seconds when the first of them was begun.
    begun: f64,
}

impl Watch {
    /// Watches a solve of at most `limit` iterations, coarser grids' included; `clock` has run since the program began.
    pub fn new(clock: Clock, display: Display, limit: usize, interrupt: Interrupt) -> Self {
        Watch {
            clock,
            pace: Pace::new(display.limit()),
            windows: 0,
            whole: None,
            is_inside: false,
            live: None,
            display,
            history: Vec::with_capacity(limit.min(ROWS)),
            window: None,
            interrupt,
            told: false,
            march: None,
        }
    }

    /// How many steps have a density that was simulated; that of the first one comes of the flow that is given.
    pub fn simulated(&self) -> usize {
        self.march.map_or(1, |march| march.step + 1)
    }

    /// Another step is simulated: says how many of all, and how long the others take if they take as long.
    fn marched(&mut self, step: usize, steps: usize) {
        let seconds = self.clock.seconds();
        let begun = self
            .march
            .filter(|_| step > 0)
            .map_or(seconds, |march| march.begun);
        self.march = Some(March { step, begun });
        let left = if step > 0 {
            let left = (seconds - begun) / step as f64 * (steps - step) as f64;
            format!(", {} left", in_words(left))
        } else {
            String::new()
        };
        self.display
            .detail(format_args!("step {} of {}{left}", step + 1, steps + 1));
    }

    /// The window that is solved, where there are windows, and the iterations of those before.
    pub fn window(&mut self) -> &mut Option<(usize, usize)> {
        &mut self.window
    }

    /// What follows is of window `number`; its iterations are counted on.
    pub fn enter_window(&mut self, number: usize) {
        self.window = Some((number, self.history.len()));
        self.is_inside = false;
        self.whole = self.whole_of(self.clock.seconds(), number);
    }

    /// What follows is the search of that window.
    pub fn search_window(&mut self) {
        self.is_inside = true;
    }

    /// Seconds of all windows, if `number` of them took so many.
    fn whole_of(&self, seconds: f64, number: usize) -> Option<f64> {
        (number > 0).then(|| seconds * self.windows.max(number) as f64 / number as f64)
    }

    /// Records an outer iteration that is over.
    pub fn iteration(&mut self, progress: &Progress) {
        self.clock.leave();
        let seconds = self.clock.seconds();
        if progress.level > 0 {
            self.clock.nested();
        }
        self.pace.note(progress, seconds);
        let left = self.left(seconds);
        self.display.iteration(progress, seconds, left);
        let mut record = IterationRecord::new(seconds, left, progress);
        if let Some((number, before)) = self.window {
            record.window = Some(number);
            record.iteration += before;
        }
        if let Some(live) = &mut self.live {
            live.iteration(&record, self.pace.done());
        }
        self.history.push(record);
    }

    /// The page, where there is something new to draw on it.
    pub fn page(&mut self) -> Option<&mut Live> {
        let is_there = self.pace.done() > 0;
        self.live.as_mut().filter(|live| is_there && live.wants_frames())
    }

    /// Seconds that all searches still take, about, so many after the start; `None` where nothing tells yet.
    pub fn left(&self, seconds: f64) -> Option<f64> {
        let Some((number, _)) = self.window else {
            return self.pace.left();
        };
        // Once its own end is foretold the window counts as those before.
        let window = self.pace.left().filter(|_| self.is_inside);
        let whole = match window {
            Some(left) => self.whole_of(seconds + left, number + 1),
            // Those after it take as long as those before, however long it takes itself.
            None => self.whole.map(|whole| {
                let after = self.windows.saturating_sub(number + 1) as f64;
                whole.max(seconds + after / self.windows.max(1) as f64 * whole)
            }),
        };
        whole.map(|whole| (whole - seconds).max(0.0))
    }

    /// Whether the user has interrupted the solve; says so once.
    fn stops(&mut self) -> bool {
        let asked = self.interrupt.asked();
        if asked && !self.told {
            self.told = true;
            self.display.note("thurible: stopping, the result so far will be written; press Ctrl-C again to end at once without it");
        }
        asked
    }
}

impl Observer for Watch {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        match event {
            Event::IterationBegin { iteration: 1 } => self.clock.nested(),
            Event::PhaseBegin(phase) => self.clock.enter(phase.name),
            Event::PhaseEnd(_) => self.clock.leave(),
            Event::PhaseStep {
                phase: MARCH,
                step,
                value,
                ..
            } => self.marched(step, value as usize),
            Event::PhaseStep {
                phase,
                step,
                value,
                taken,
            } => {
                let step_taken = if taken > 0.0 {
                    format!(", step {taken}")
                } else {
                    String::new()
                };
                self.display.detail(format_args!(
                    "{} {step}, {} {value:.1e}{step_taken}",
                    phase.words, phase.measure
                ));
            }
            _ => self.display.tick(),
        }
        if self.stops() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
