//! The lines of the speed table.

use super::machine::Moment;
use super::solves::Iterations;
use super::table::{self, Line};
use serde::Serialize;
use thurible::bytes::rounded;
use thurible::plan::size_in_words;

/// The triad of the machine that the targets are for.
const TARGET_TRIAD: f64 = 45e9;
/// What a solve may touch beyond its plan: the program, a scene,
const BESIDE: usize = 8 << 20;
/// and the stack of each thread.
const STACK: usize = 2 << 20;

/// A line of the table: one measurement.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Row {
    pub name: String,
    pub cells: Vec<usize>,
    pub steps: usize,
    /// None if it was not reached.
    pub seconds: Option<f64>,
    /// For a machine with a triad of 45 GB/s.
    pub target_seconds: Option<f64>,
    /// For this one.
    pub target_here_seconds: Option<f64>,
    /// What must at least be moved.
    pub least_bytes: Option<f64>,
    /// How long the triad would take for that.
    pub floor_seconds: Option<f64>,
    /// Iterations until it was reached.
    pub iterations: Option<usize>,
    /// Objectives computed in an iteration.
    pub evaluations: Option<f64>,
    /// The largest Courant number.
    pub courant: Option<f64>,
    /// What the machine did before and after, on average.
    #[serde(flatten)]
    pub moment: Option<Moment>,
}

impl Row {
    pub fn new(name: &str, cells: &[usize], steps: usize, seconds: Option<f64>) -> Self {
        Self {
            name: name.into(),
            cells: cells.to_vec(),
            steps,
            seconds,
            ..Self::default()
        }
    }

    /// With the seconds that it should take at most.
    pub fn targeting(self, target: f64) -> Self {
        Self {
            target_seconds: Some(target),
            ..self
        }
    }

    /// With the f32 values that must at least be moved for each cell and step.
    pub fn moving(self, numbers: f64) -> Self {
        Self {
            least_bytes: Some(
                numbers * (size_of::<f32>() * self.cells.iter().product::<usize>() * self.steps) as f64,
            ),
            ..self
        }
    }

    /// With what is known of iterations.
    pub fn of(self, iterations: &Iterations) -> Self {
        Self {
            evaluations: Some(iterations.evaluations),
            courant: Some(iterations.courant),
            ..self
        }
    }

    /// With what the machine's triad makes of it; targets are not for tiny sizes.
    pub fn beside(self, moment: Moment, quick: bool) -> Self {
        let target_seconds = self.target_seconds.filter(|_| !quick);
        Self {
            target_seconds,
            target_here_seconds: target_seconds.map(|target| target * TARGET_TRIAD / moment.triad),
            floor_seconds: self.least_bytes.map(|bytes| bytes / moment.triad),
            moment: Some(moment),
            ..self
        }
    }
}

impl Line<11> for Row {
    const HEAD: [&'static str; 11] = [
        "what",
        "cells, steps",
        "took",
        "target",
        "of target",
        "floor",
        "of floor",
        "GB/s",
        "GFLOP/s",
        "ns",
        "note",
    ];
    const WIDTHS: &'static [usize] = &[44, 18];

    fn texts(&self) -> [String; 11] {
        let time = |value: Option<f64>| value.map_or_else(|| "-".into(), table::time);
        let ratio = |by: Option<f64>| {
            self.seconds
                .zip(by)
                .map_or_else(|| "-".into(), |(seconds, by)| format!("{:.2}", seconds / by))
        };
        let moment = |of: &dyn Fn(Moment) -> Option<f64>, digits: usize| {
            self.moment
                .and_then(of)
                .map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
        };
        let evaluations = self.evaluations.map(|count| {
            format!(
                "{count:.2} evaluations, Courant {:.1}",
                self.courant.unwrap_or(0.0)
            )
        });
        let iterations = self.iterations.map(|count| format!("{count} iterations"));
        [
            self.name.clone(),
            format!("{}, {}", size_in_words(&self.cells), self.steps),
            time(self.seconds),
            time(self.target_here_seconds),
            ratio(self.target_here_seconds),
            time(self.floor_seconds),
            ratio(self.floor_seconds),
            moment(&|moment| Some(1e-9 * moment.triad), 1),
            moment(&|moment| Some(1e-9 * moment.flops), 0),
            moment(&|moment| Some(1e9 * moment.handover?), 0),
            evaluations
                .or(iterations)
                .map_or_else(String::new, |note| format!("  {note}")),
        ]
    }
}

/// What memory a solve took.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Peak {
    planned_bytes: usize,
    touched_bytes: Option<usize>,
    allowed_bytes: usize,
}

impl Peak {
    pub fn new(iterations: &Iterations, threads: usize) -> Self {
        let planned = iterations.planned;
        Self {
            planned_bytes: planned,
            touched_bytes: iterations.touched,
            allowed_bytes: planned + BESIDE + threads * STACK,
        }
    }

    pub fn sentence(&self) -> String {
        let touched = self
            .touched_bytes
            .map_or_else(|| "not told by this system".into(), rounded);
        format!(
            "Peak resident memory of the 3D iterations: {touched}; planned {}, allowed {}.",
            rounded(self.planned_bytes),
            rounded(self.allowed_bytes)
        )
    }
}
