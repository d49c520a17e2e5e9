//! `memory.md` and its figures.

use super::row::{Measured, methods, representatives};
use crate::files;
use std::path::Path;
use thurible::address_space;
use thurible::bytes::grouped;
use thurible::exit::Failure;
use thurible::plan::size_in_words;
use thurible::region::MARGIN;
use thurible::report::{Chart, Curve, Scale};
use thurible_core::{Method, Named};

/// Name of the page.
const PAGE: &str = "memory.md";

/// Writes the page and a figure for each dimension.
pub(super) fn write(folder: &Path, table: &[Measured], quick: bool) -> Result<(), Failure> {
    for dims in [2, 3] {
        files::put(folder, &figure(dims), &chart(table, dims).to_svg())?;
    }
    files::put(folder, PAGE, &page(table, quick))
}

fn figure(dims: usize) -> String {
    format!("memory_{dims}d.svg")
}

/// Planned bytes for each cell and step against the size, in single precision.
fn chart(table: &[Measured], dims: usize) -> Chart {
    let rows: Vec<&Measured> = table
        .iter()
        .filter(|row| row.cells.len() == dims && row.precision == "f32")
        .collect();
    let per_number = |row: &Measured, bytes: usize| {
        let count = (row.cells.iter().product::<usize>() * row.steps) as f64;
        (count, bytes as f64 / count)
    };
    let curve = |(index, method): (usize, Method)| {
        let points = rows
            .iter()
            .filter(|row| row.method == method.name())
            .map(|row| per_number(row, row.planned_bytes));
        Curve::new(method.name(), 1 + index, points.collect::<Vec<_>>().into_iter())
    };
    let mut curves: Vec<Curve> = methods().enumerate().map(curve).collect();
    let bound = rows
        .iter()
        .filter(|row| row.method == Method::Admm.name())
        .map(|row| per_number(row, row.paper_bound_bytes));
    curves.push(Curve::new("bound", 5, bound.collect::<Vec<_>>().into_iter()));
    Chart {
        title: "Planned bytes for each cell and step",
        note: "".into(),
        across: "cells times steps, f32",
        scale: Scale::Logarithmic,
        curves,
    }
}

fn page(table: &[Measured], quick: bool) -> String {
    let command = if quick {
        "cargo thurible-bench memory --quick --out docs"
    } else {
        "cargo thurible-bench memory --out docs"
    };
    let thread = address_space::OF_A_THREAD >> 20;
    let mut page = format!(
        "# Memory\n\nThis page says how many bytes a solve takes: planned, touched, and beside its block. `{command}` writes it; `thurible plan SCENE --json` says the same of any scene.\n\n\
         ## What is promised\n\n\
         A solve takes one block, of the planned bytes and at most {} more, before it begins. Beside it the program takes:\n\n\
         | what | at most | shown by |\n|---|---|---|\n\
         | resident memory: code, the buffers of files, stacks | 36 MiB | `tests/ceiling/table.rs`, for 20 combinations of method, precision, dimension, size and threads |\n\
         | and while shapes are drawn, one after the other | 16 bytes for each cell of the grid | the same test, for 1024 x 1024 cells |\n\
         | addresses (`ulimit -v`), one thread | as much | the same test: with exactly so many it solves, with a page less than the plan it ends with exit code 3 |\n\
         | addresses, T > 1 threads | {thread} MiB (T + 1) more | the same; glibc reserves 64 MiB for each thread and touches next to nothing of it |\n\n\
         A scene with `[method] window` takes the block of its largest window, whatever its length, and beside it one field more: [windows](effects.md#longer-than-memory-windows).\n\n\
         `--memory-limit X` is the ceiling of the block; with the lines above it bounds what the process has, for a scene without files. While a \
         file that a scene names is read it takes the pixels of a picture as the file keeps them, 1 to 16 bytes each and at most 16 times the file and 64 MiB, and 16 bytes for each number of an array. What does not fit, threads \
         included, is refused before it begins, with exit code 3; a picture for which there is no memory is refused with exit code 2.\n\n",
        grouped(MARGIN)
    );
    page.push_str(&figures());
    page.push_str(&measured(table));
    page.push_str(&high_water(table));
    page
}

fn figures() -> String {
    let show = |dims: usize| {
        format!(
            "![Planned bytes for each cell and step, {dims}D]({})\n\n",
            figure(dims)
        )
    };
    format!(
        "## By size and method\n\n{}{}*Planned bytes for each cell and step in f32, source and keyframe included; in f64 twice as many. The bound is the \
         paper's for its method, M = 4 (1 + d) N prod(n) / (1 - 2^-d) numbers.*\n\n",
        show(2),
        show(3)
    )
}

fn measured(table: &[Measured]) -> String {
    let mut text = String::from(
        "## Planned and touched\n\n\
         On one thread, each method with its defaults and a keyframe at the last step. *Touched* is how much the resident memory of a process grew from \
         before the block was taken to its peak (`VmHWM` of `/proc/self/status`): each row ran in a process of its own, for 0.7 s or as long as it took. \
         What it shows above 100 % is code, stack and file buffers; all of the block is touched, since it is zeroed before the first iteration.\n\n\
         | cells | steps | method | precision | planned bytes | touched bytes | touched / planned | bound M | method / M | bytes a cell and step |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in table {
        text.push_str(&format!("| {} |\n", row.columns(["not told", ""]).join(" | ")));
    }
    text
}

fn high_water(table: &[Measured]) -> String {
    let mut text = String::from(
        "\n## High-water marks by phase\n\nBuffers that are needed one after the other lie in the same bytes. What is in use in each phase, of the plan's \
         bytes, by the ledger:\n\n| cells | method | phase | bytes in use | of the block |\n|---|---|---|---|---|\n",
    );
    for row in representatives(table) {
        for phase in &row.phases {
            let part = 100.0 * phase.bytes as f64 / row.planned_bytes as f64;
            let size = size_in_words(&row.cells);
            text.push_str(&format!(
                "| {size} | {} | {} | {} | {part:.1} % |\n",
                row.method,
                phase.name,
                grouped(phase.bytes)
            ));
        }
    }
    text
}
