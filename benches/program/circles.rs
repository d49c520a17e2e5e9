//! `thurible-bench circles`: iterations of the direct method and a solve, in both precisions, of the scene that rivals solve.

use super::machine::Machine;
use super::printer::Printer;
use super::solves;
use super::speed::PART;
use super::table::{Line, Table, time};
use super::threads::with_threads;
use super::{scenes, section};
use crate::arguments::MeasureArguments;
use serde::Serialize;
use serde_json::json;
use thurible::exit::{DONE, Failure};
use thurible::plan::size_in_words;
use thurible::problem::Precision;
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

/// Runs `circles`.
pub(super) fn run(arguments: &MeasureArguments) -> Result<u8, Failure> {
    section::check(arguments.out.as_deref())?;
    let printer = Printer::of(arguments);
    with_threads(arguments.threads, |exec| {
        let machine = Machine::measure(exec, arguments.quick)?;
        printer.say(&machine.sentence(), json!({ "machine": machine }));
        let mut table = Table::begin(printer);
        for (side, steps) in if arguments.quick { QUICK_SIZES } else { SIZES } {
            table.add(Row::measure::<f32>(exec, side, steps)?);
            table.add(Row::measure::<f64>(exec, side, steps)?);
        }
        section::write(
            arguments.out.as_deref(),
            "circles",
            &format!("{}\n\n{}", machine.sentence(), table.markdown()),
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
        let prepared = scenes::two_circles(&sets, exec.threads())?;
        let [iterations] = solves::iterations::<T, D2, 1>([exec], &prepared, ITERATIONS)?;
        let reached = solves::to_part::<T, D2>(exec, &prepared, PART)?;
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
