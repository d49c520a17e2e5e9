//! `thurible-bench roofline`: bytes, operations and rates of each kernel beside what the machine can do.

use super::kernels::Kernel;
use super::machine::Machine;
use super::printer::Printer;
use super::section;
use super::table::{self, Line, Table};
use super::threads::with_threads;
use crate::arguments::RooflineArguments;
use serde::Serialize;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use thurible::exit::{DONE, Failure};
use thurible::plan::size_in_words;
use thurible_core::simd::{self, Level};
use thurible_core::{D2, D3, Exec};

/// The box of each dimension.
const SIZES: [(&[usize], usize); 2] = [(&[128; 2], 40), (&[64; 3], 60)];
const QUICK_SIZES: [(&[usize], usize); 2] = [(&[32; 2], 8), (&[12; 3], 6)];
/// Where operations are counted: the projection, which the direct method has too, takes more of them in longer boxes.
const COUNTED_SIZES: [(&[usize], usize); 2] = [(&[128; 2], 8), (&[64; 3], 4)];
const COUNTED_SMALL: (&[usize], usize) = (&[32; 3], 8);
/// Times that a kernel runs; from the third iteration on the direct method moves as fast as in a solve.
const REPEATS: usize = 4;

/// A line of the table: one kernel in one box.
#[derive(Clone, Debug, Serialize)]
struct Row {
    kernel: &'static str,
    cells: Vec<usize>,
    steps: usize,
    seconds: f64,
    /// What must at least be moved.
    least_bytes: f64,
    /// `None` if they were not counted.
    flops: Option<f64>,
    /// Seconds that the triad would take for the bytes, in parts of all.
    of_memory: f64,
    /// Seconds that adds and multiplies at their peak would take for the operations, in parts of all.
    of_arithmetic: Option<f64>,
}

/// Runs `roofline`.
pub(super) fn run(arguments: &RooflineArguments) -> Result<u8, Failure> {
    let common = &arguments.common;
    if let Some(order) = &arguments.only {
        return with_threads(common.threads, |exec| only(exec, order));
    }
    section::check(common.out.as_deref())?;
    let counts = arguments.flops.as_deref().map_or(Ok(Value::Null), counts)?;
    let printer = Printer::of(common);
    with_threads(common.threads, |exec| {
        let machine = Machine::measure(exec, common.quick)?;
        printer.say(&machine.sentence(), json!({ "machine": machine }));
        let mut table = Table::begin(printer);
        for (cells, steps) in if common.quick { QUICK_SIZES } else { SIZES } {
            for kernel in Kernel::ALL {
                table.add(Row::new(
                    kernel,
                    cells,
                    steps,
                    time(exec, kernel, cells, steps, REPEATS)?,
                    &counts,
                    &machine,
                ));
            }
        }
        section::write(
            common.out.as_deref(),
            "roofline",
            &format!("{}\n\n{}", machine.sentence(), table.markdown()),
        )
    })?;
    Ok(DONE)
}

fn time(
    exec: &dyn Exec,
    kernel: Kernel,
    cells: &[usize],
    steps: usize,
    repeats: usize,
) -> Result<f64, Failure> {
    if cells.len() == 2 {
        kernel.seconds::<D2>(exec, cells, steps, repeats)
    } else {
        kernel.seconds::<D3>(exec, cells, steps, repeats)
    }
}

/// Runs the kernel of `order`, as in `cycle,3,2`: its word, dimensions, times; prints cells times slots.
fn only(exec: &dyn Exec, order: &str) -> Result<u8, Failure> {
    let mut words = order.split(',');
    let kernel = words
        .next()
        .and_then(|word| Kernel::ALL.into_iter().find(|kernel| kernel.word() == word));
    let mut numbers = words.map_while(|word| word.parse::<usize>().ok());
    let (Some(kernel), Some(dims @ 2..=3), Some(times @ 1..)) = (kernel, numbers.next(), numbers.next())
    else {
        return Err(Failure::Input(format!(
            "--only {order}: there is no such kernel; write one as in cycle,3,2"
        )));
    };
    // Valgrind does not know all of AVX2 and nothing of AVX-512; narrow vectors do the same operations.
    let _ = simd::limit(Level::Baseline);
    let projects = matches!(kernel, Kernel::Projection | Kernel::Direct);
    let (cells, steps) = if dims == 2 || projects {
        COUNTED_SIZES[dims - 2]
    } else {
        COUNTED_SMALL
    };
    time(exec, kernel, cells, steps, times)?;
    thurible::console::print(&(cells.iter().product::<usize>() * (steps - 1)).to_string());
    Ok(DONE)
}

/// The file of counted operations.
fn counts(path: &Path) -> Result<Value, Failure> {
    let shown = path.display();
    let text = fs::read(path).map_err(|error| {
        Failure::File(format!(
            "cannot read {shown}: {error}; let benches/flops.py write it"
        ))
    })?;
    serde_json::from_slice(&text).map_err(|error| {
        Failure::Input(format!(
            "{shown} is not JSON: {error}; let benches/flops.py write it"
        ))
    })
}

impl Row {
    fn new(
        kernel: Kernel,
        cells: &[usize],
        steps: usize,
        seconds: f64,
        counts: &Value,
        machine: &Machine,
    ) -> Self {
        let [of_step, of_all] = [1, steps].map(|steps| (cells.iter().product::<usize>() * steps) as f64);
        let least_bytes = size_of::<f32>() as f64 * kernel.least_values(cells.len()) * of_all;
        let flops = counts[kernel.word()][cells.len().to_string()]
            .as_f64()
            .map(|flops| flops * (of_all - of_step));
        Self {
            kernel: kernel.name(),
            cells: cells.to_vec(),
            steps,
            seconds,
            least_bytes,
            flops,
            of_memory: least_bytes / machine.moment.triad / seconds,
            of_arithmetic: flops.map(|flops| flops / machine.moment.flops / seconds),
        }
    }
}

impl Line<10> for Row {
    const HEAD: [&'static str; 10] = [
        "kernel",
        "cells, steps",
        "took",
        "GB at least",
        "GFLOP",
        "GB/s",
        "GFLOP/s",
        "of the triad",
        "of arithmetic",
        "FLOP a byte",
    ];
    const WIDTHS: &'static [usize] = &[34, 18];

    fn texts(&self) -> [String; 10] {
        let counted = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
        };
        let percent =
            |part: Option<f64>| part.map_or_else(|| "-".into(), |part| format!("{:.1} %", 100.0 * part));
        [
            self.kernel.into(),
            format!("{}, {}", size_in_words(&self.cells), self.steps),
            table::time(self.seconds),
            format!("{:.3}", 1e-9 * self.least_bytes),
            counted(self.flops.map(|flops| 1e-9 * flops), 2),
            format!("{:.1}", 1e-9 * self.least_bytes / self.seconds),
            counted(self.flops.map(|flops| 1e-9 * flops / self.seconds), 1),
            percent(Some(self.of_memory)),
            percent(self.of_arithmetic),
            counted(self.flops.map(|flops| flops / self.least_bytes), 1),
        ]
    }
}
