//! `thurible-bench memory`: bytes planned and bytes touched for a table of sizes, methods and precisions.
//!
//! Each row is solved in a process of its own, so that nothing an earlier one left behind is counted: it notes how much of it is
//! resident, takes the block, solves, and asks the system for the most that ever was (`VmHWM`).

mod page;
mod row;

use crate::arguments::MemoryArguments;
use crate::files;
use row::{Measured, Touched, representatives, rows};
use thurible::bytes::grouped;
use thurible::console::print;
use thurible::exit::{DONE, Failure};
use thurible::phases::Phase;
use thurible::plan::size_in_words;

/// Runs `memory`.
pub fn run(arguments: &MemoryArguments) -> Result<u8, Failure> {
    let rows = rows(arguments.quick);
    if let Some(index) = arguments.row {
        let row = rows
            .get(index)
            .ok_or_else(|| Failure::Input(format!("there is no row {index}; there are {}", rows.len())))?;
        print(
            &serde_json::json!(Touched {
                touched_bytes: row.touch()?
            })
            .to_string(),
        );
        return Ok(DONE);
    }
    if let Some(folder) = &arguments.out {
        files::check(folder)?;
    }
    if !arguments.json {
        print(&heading());
    }
    let mut table = Vec::with_capacity(rows.len());
    for (index, row) in rows.iter().enumerate() {
        let measured = row.measure(index, arguments.quick)?;
        print(&if arguments.json {
            serde_json::json!(measured).to_string()
        } else {
            line(&measured)
        });
        table.push(measured);
    }
    if !arguments.json {
        print_phases(&table);
    }
    if let Some(folder) = &arguments.out {
        page::write(folder, &table, arguments.quick)?;
    }
    Ok(DONE)
}

fn heading() -> String {
    format!(
        "{:>14}{:>6}  {:<7}{:<5}{:>15}{:>15}{:>11}{:>15}{:>9}{:>10}",
        "cells", "steps", "method", "", "planned", "touched", "of plan", "bound M", "of M", "B/cell/step"
    )
}

fn line(row: &Measured) -> String {
    let [
        cells,
        steps,
        method,
        precision,
        planned,
        touched,
        part,
        bound,
        of_bound,
        each,
    ] = row.columns(["-", "-"]);
    format!(
        "{cells:>14}{steps:>6}  {method:<7}{precision:<5}{planned:>15}{touched:>15}{part:>11}{bound:>15}{of_bound:>9}{each:>10}"
    )
}

/// High-water marks of the last single-precision row of each method and dimension.
fn print_phases(table: &[Measured]) {
    for row in representatives(table) {
        print(&format!(
            "\n{} by {} in {}, in use at most:",
            size_in_words(&row.cells),
            row.method,
            row.precision
        ));
        for Phase { name, bytes } in &row.phases {
            print(&format!("{:>15}  {name}", grouped(*bytes)));
        }
    }
}
