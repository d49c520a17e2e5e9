//! `thurible bench circles`: iterations of the direct method and a solve, in both precisions, of the scene that rivals solve.

use super::arguments::MeasureArguments;
use super::sheet::{Line, Sheet, time};
use super::solves;
use super::speed::PART;
use super::yardstick::Yardstick;
use super::{Voice, scenes, section, with_team};
use crate::exit::{DONE, Failure};
use crate::plan::size_in_words;
use crate::problem::Precision;
use serde::Serialize;
use serde_json::json;
use thurible_core::{D2, Exec, Real};

const SIZES: [(usize, usize); 2] = [(64, 20), (128, 40)];
const QUICK_SIZES: [(usize, usize); 2] = [(16, 6), (32, 8)];
/// Iterations on the finest grid that are measured, from 1.
const ITERATIONS: [usize; 2] = [2, 21];

/// One size in one precision.
#[derive(Clone, Debug, Serialize)]
struct Row {
    cells: [usize; 2],
    steps: usize,
    precision: &'static str,
    /// Of an iteration on the finest grid, everything.
    iteration_seconds: f64,
    /// Objectives that an iteration computed.
    evaluations: f64,
    /// Until the squared distance from the keyframe was 1 % of that at rest.
    solve_seconds: Option<f64>,
    /// Iterations until then, on all grids.
    solve_iterations: usize,
}

/// Runs `bench circles`.
pub(super) fn run(arguments: &MeasureArguments) -> Result<u8, Failure> {
    section::check(arguments.out.as_deref())?;
    let voice = Voice::of(arguments);
    with_team(arguments.threads, |exec| {
        let yardstick = Yardstick::measure(exec, arguments.quick)?;
        voice.say(&yardstick.sentence(), json!({ "machine": yardstick }));
        let mut sheet = Sheet::begin(voice);
        for (side, steps) in if arguments.quick { QUICK_SIZES } else { SIZES } {
            sheet.add(Row::measure::<f32>(exec, side, steps)?);
            sheet.add(Row::measure::<f64>(exec, side, steps)?);
        }
        section::write(
            arguments.out.as_deref(),
            "circles",
            &format!("{}\n\n{}", yardstick.sentence(), sheet.markdown()),
        )
    })?;
    Ok(DONE)
}

impl Row {
    fn measure<T: Real>(exec: &dyn Exec, side: usize, steps: usize) -> Result<Self, Failure> {
        let cells = [side; 2];
        let sets = [
            format!("grid.cells={cells:?}"),
            format!("time.steps={steps}"),
            format!("keyframe[0].step={steps}"),
        ];
        let ready = scenes::two_circles(&sets, exec.threads())?;
        let [iterations] = solves::iterations::<T, D2, 1>([exec], &ready, ITERATIONS)?;
        let reached = solves::to_part::<T, D2>(exec, &ready, PART)?;
        Ok(Self {
            cells,
            steps,
            precision: Precision::of::<T>().name(),
            iteration_seconds: iterations.seconds,
            evaluations: iterations.evaluations,
            solve_seconds: reached.seconds,
            solve_iterations: reached.iterations,
        })
    }
}

impl Line<6> for Row {
    const HEAD: [&'static str; 6] = [
        "cells, steps",
        "precision",
        "an iteration",
        "evaluations",
        "to 1 %",
        "iterations",
    ];
    const WIDTHS: &'static [usize] = &[16, 11];

    fn texts(&self) -> [String; 6] {
        [
            format!("{}, {}", size_in_words(&self.cells), self.steps),
            self.precision.into(),
            time(self.iteration_seconds),
            format!("{:.2}", self.evaluations),
            self.solve_seconds.map_or_else(|| "-".into(), time),
            self.solve_iterations.to_string(),
        ]
    }
}
