//! A row of the memory table: what is solved in it, and what is measured.

use crate::prepared::no_memory;
use crate::process::resident;
use core::ops::ControlFlow;
use core::time::Duration;
use serde::{Deserialize, Serialize};
use std::process::Command;
use std::time::Instant;
use thurible::bytes::grouped;
use thurible::exit::Failure;
use thurible::phases::{Phase, phases};
use thurible::plan::{block_bytes, size_in_words};
use thurible::problem::{OwnedProblem, Precision};
use thurible::region::Region;
use thurible::run::inputs::solver_refusal;
use thurible_core::method::registry;
use thurible_core::{D2, D3, Event, Method, Named, Observer, Params, Real, Serial, Solver, Space};

/// Sizes of the table, smallest first in each dimension; `--quick` takes the first of each.
const SIZES: [(&[usize], usize); 6] = [
    (&[64, 64], 20),
    (&[128, 128], 40),
    (&[256, 256], 40),
    (&[16, 16, 16], 16),
    (&[32, 32, 32], 30),
    (&[40, 40, 40], 30),
];
const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];
/// A row is solved for no longer than this: the whole block is touched before the first iteration.
const LONGEST: Duration = Duration::from_millis(700);

/// Methods of the table: those that steer to keyframes alone, without templates.
pub(super) fn methods() -> impl Iterator<Item = Method> {
    let all = Method::ALL.iter().copied();
    all.filter(|&method| method != Method::Templates)
        .filter(|&method| {
            registry::steers(&Params {
                method,
                ..Params::default()
            })
        })
}

/// What is solved in a row.
pub(super) struct Row {
    /// Cells, steps and a keyframe at the last of them.
    pub problem: OwnedProblem,
    /// The method, on one thread, with its defaults.
    pub params: Params,
    /// f32 or f64.
    pub precision: Precision,
}

/// A row that has been measured.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Measured {
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// Number of time steps N.
    pub steps: usize,
    /// Name of the method.
    pub method: &'static str,
    /// f32 or f64.
    pub precision: &'static str,
    /// Bytes of the block by its plan.
    pub planned_bytes: usize,
    /// Bytes of it for the method: all but the keyframe.
    pub method_bytes: usize,
    /// Bytes that the process touched beyond those it had before, if the system tells.
    pub touched_bytes: Option<usize>,
    /// The paper's bound M for the method.
    pub paper_bound_bytes: usize,
    /// Planned bytes for each cell and step.
    pub bytes_per_cell_and_step: f64,
    /// High-water marks.
    pub phases: Vec<Phase>,
}

/// What the process of a row says.
#[derive(Deserialize, Serialize)]
pub(super) struct Touched {
    /// Beyond what it had before; `None` where the system does not tell.
    pub touched_bytes: Option<usize>,
}

/// All rows, or those of the smallest sizes.
pub(super) fn rows(quick: bool) -> Vec<Row> {
    let sizes = SIZES
        .iter()
        .enumerate()
        .filter(|(index, _)| !quick || index % 3 == 0)
        .map(|(_, size)| size);
    let mut rows = Vec::new();
    for (cells, steps) in sizes {
        for method in methods() {
            rows.extend(PRECISIONS.map(|precision| Row {
                problem: OwnedProblem::new(cells.to_vec(), vec![*steps]),
                params: Params {
                    method,
                    ..Params::default()
                },
                precision,
            }));
        }
    }
    rows
}

/// The largest single-precision row of each method and dimension.
pub(super) fn representatives(table: &[Measured]) -> impl Iterator<Item = &Measured> {
    [2, 3].into_iter().flat_map(move |dims| {
        let named = move |row: &&Measured, method| {
            row.cells.len() == dims && row.precision == "f32" && row.method == method
        };
        methods().filter_map(move |method| table.iter().rev().find(|row| named(row, method.name())))
    })
}

impl Measured {
    /// The columns of the table; `untold` stands for bytes touched, and their part of the plan, where the system does not tell.
    pub fn columns(&self, untold: [&str; 2]) -> [String; 10] {
        let [touched, part] = match self.touched_bytes {
            Some(touched) => [
                grouped(touched),
                format!("{:.2} %", 100.0 * touched as f64 / self.planned_bytes as f64),
            ],
            None => untold.map(String::from),
        };
        [
            size_in_words(&self.cells),
            self.steps.to_string(),
            self.method.to_string(),
            self.precision.to_string(),
            grouped(self.planned_bytes),
            touched,
            part,
            grouped(self.paper_bound_bytes),
            format!("{:.1} %", self.part_of_bound()),
            format!("{:.1}", self.bytes_per_cell_and_step),
        ]
    }

    /// The method's bytes in percent of the paper's bound.
    pub fn part_of_bound(&self) -> f64 {
        100.0 * self.method_bytes as f64 / self.paper_bound_bytes as f64
    }
}

impl Row {
    /// Plans the row, and has it solved by a process of its own.
    pub fn measure(&self, index: usize, quick: bool) -> Result<Measured, Failure> {
        let plan = self
            .problem
            .plan(&self.params, self.precision)
            .map_err(|error| Failure::Input(error.to_string()))?;
        let cells: usize = self.problem.cells.iter().product();
        Ok(Measured {
            cells: self.problem.cells.clone(),
            steps: self.problem.steps,
            method: self.params.method.name(),
            precision: self.precision.name(),
            planned_bytes: plan.bytes(),
            method_bytes: plan.method_bytes(),
            touched_bytes: ask(index, quick)?,
            paper_bound_bytes: plan.paper_bound(),
            bytes_per_cell_and_step: plan.bytes() as f64 / (cells * self.problem.steps) as f64,
            phases: phases(plan.entries(), plan.bytes()),
        })
    }

    /// Solves the row here; bytes that were touched meanwhile.
    pub fn touch(&self) -> Result<Option<usize>, Failure> {
        match (self.problem.cells.len(), self.precision) {
            (2, Precision::F32) => self.solve::<f32, D2>(),
            (2, Precision::F64) => self.solve::<f64, D2>(),
            (_, Precision::F32) => self.solve::<f32, D3>(),
            (_, Precision::F64) => self.solve::<f64, D3>(),
        }
    }

    fn solve<T: Real, S: Space>(&self) -> Result<Option<usize>, Failure> {
        let plan = self
            .problem
            .plan(&self.params, self.precision)
            .map_err(|error| Failure::Input(error.to_string()))?;
        let [source, target] = [0.4, 0.6].map(|at| self.blob::<T>(at));
        let before = resident("VmRSS:");
        let short = || no_memory(block_bytes(&plan));
        let mut region = Region::new(plan.bytes()).ok_or_else(short)?;
        let block = region.carve(plan.bytes()).ok_or_else(short)?;
        let mut solver = Solver::<T, S>::new(&self.problem.problem(), &self.params, block)
            .map_err(|error| solver_refusal(&error))?;
        let given = solver
            .set_source(&source)
            .and_then(|()| solver.set_keyframe(0, &target));
        given.map_err(|error| Failure::Input(error.to_string()))?;
        let mut deadline = Deadline(Instant::now() + LONGEST);
        while solver.step(&Serial, &mut deadline).status.is_none() {}
        Ok(resident("VmHWM:")
            .zip(before)
            .map(|(most, before)| most.saturating_sub(before)))
    }

    /// Smoke around a point of the middle line.
    fn blob<T: Real>(&self, at: f64) -> Vec<T> {
        let cells = &self.problem.cells;
        let density = |mut index: usize| {
            let squares = cells.iter().enumerate().map(|(axis, &count)| {
                let place = (index % count) as f64 / count as f64 - if axis == 0 { at } else { 0.5 };
                index /= count;
                place * place
            });
            T::from_f64(1.0 / (1.0 + 100.0 * squares.sum::<f64>()))
        };
        (0..cells.iter().product()).map(density).collect()
    }
}

/// Stops when its time has come.
struct Deadline(Instant);

impl Observer for Deadline {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        if Instant::now() >= self.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// What a process that solves row `index` says that it touched.
fn ask(index: usize, quick: bool) -> Result<Option<usize>, Failure> {
    let cannot = |why: String| {
        Failure::Input(format!(
            "cannot measure row {index} in a process of its own: {why}; run the program from its file"
        ))
    };
    let program = std::env::current_exe().map_err(|error| cannot(error.to_string()))?;
    let mut command = Command::new(program);
    command
        .args(["memory", "--row", &index.to_string()])
        .args(quick.then_some("--quick"));
    let output = command.output().map_err(|error| cannot(error.to_string()))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr)
            .trim()
            .trim_start_matches("thurible-bench: ")
            .to_string();
        return Err(if output.status.code() == Some(thurible::exit::MEMORY.into()) {
            Failure::Memory(said)
        } else {
            cannot(said)
        });
    }
    let said: Touched = serde_json::from_slice(&output.stdout).map_err(|error| cannot(error.to_string()))?;
    Ok(said.touched_bytes)
}
