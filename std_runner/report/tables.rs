//! Tables of the report: parameters, memory, time.

use super::charts::by_grid;
use super::iteration::{IterationRecord, WindowRecord};
use super::record::{LedgerLine, RunRecord};
use super::words::{bytes, count, escape, grouped, number, seconds};
use thurible_core::Named;

/// Lines of a list of names and values; values are HTML.
fn list(rows: &[(&str, String)]) -> String {
    let row =
        |(name, value): &(&str, String)| format!("<div><dt>{}</dt><dd>{value}</dd></div>", escape(name));
    format!("<dl>{}</dl>", rows.iter().map(row).collect::<String>())
}

/// What was solved, and with what.
pub(super) fn parameters(record: &RunRecord) -> String {
    let mut boundary = record.boundary.clone();
    boundary.dedup();
    let mut rows = vec![
        ("Grid", product(&record.cells)),
        (
            "Boundary",
            escape(
                &if boundary.len() == 1 {
                    &boundary
                } else {
                    &record.boundary
                }
                .iter()
                .map(|end| end.name().replace('_', " "))
                .collect::<Vec<_>>()
                .join(", "),
            ),
        ),
        ("Length of the box", number(record.length)),
        ("Time", format!("{} steps of {}", record.steps, number(record.dt))),
        (
            "Viscosity",
            match record.slip {
                true => number(record.viscosity),
                false => format!(
                    "{}, by which the flow sticks to surfaces",
                    number(record.viscosity)
                ),
            },
        ),
        ("Force weight r", number(record.force_weight)),
        ("Smoothness of the force s", smoothness(record)),
        ("Filters m", record.filters.to_string()),
        (
            "Transport",
            format!(
                "{}, tolerance {}",
                escape(&record.advection.scheme),
                number(record.advection.tolerance)
            ),
        ),
        ("Method", escape(record.method.name())),
        ("Precision", escape(&record.precision)),
        ("Threads", record.threads.to_string()),
        ("Version", escape(&record.version)),
    ];
    rows.extend(effects(record));
    list(&rows)
}

/// What a scene has beside its keyframes, where it has it.
fn effects(record: &RunRecord) -> impl Iterator<Item = (&'static str, String)> {
    let lifted = record.acceleration.iter().any(|&b| b != 0.0);
    let lift = record.acceleration.iter().map(|&b| number(b));
    let lift = lifted.then(|| {
        (
            "Acceleration where the density is 1",
            lift.collect::<Vec<_>>().join(", "),
        )
    });
    let release = record
        .release
        .map(|step| ("Released from step", step.to_string()));
    let emission = record.emission.then(|| ("Emitters", "yes".into()));
    [lift, emission, release].into_iter().flatten()
}

/// The smoothness of the force in cells of the finest grid, and as a length: "2.5 cells (0.0195)".
pub(crate) fn smoothness(record: &RunRecord) -> String {
    let most = record.cells.iter().copied().max().unwrap_or(1);
    let cells = record.force_smoothness * most as f64 / record.length;
    if cells > 0.0 {
        format!("{} cells ({})", number(cells), number(record.force_smoothness))
    } else {
        "0".into()
    }
}

/// The windows, a line each.
pub(super) fn windows(record: &RunRecord) -> String {
    let row = |window: &WindowRecord| {
        let end = window.start + window.steps;
        let keyframes = match window.keyframes.as_slice() {
            [] => "none".to_owned(),
            [one] => one.to_string(),
            [first, .., last] => format!("{first} to {last}"),
        };
        let begun = if window.continued {
            "the last window"
        } else {
            "the start"
        };
        format!(
            "<tr><th>{} to {end}</th><td>{}</td><td>{keyframes}</td><td>{begun}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            window.start,
            window.kept,
            window.iterations,
            escape(&window.status.name().replace('_', " ")),
            number(window.objective.total()),
            seconds(window.seconds)
        )
    };
    let rows: String = record.windows.iter().map(row).collect();
    format!(
        "<table><thead><tr><th>Steps</th><td>kept</td><td>keyframes</td><td>begun from</td><td>iterations</td><td>ended</td><td>J</td><td></td></tr></thead>\
         <tbody>{rows}</tbody></table>"
    )
}

/// Where the time went, as bars.
pub(super) fn times(record: &RunRecord) -> String {
    let spent = record.seconds;
    let mut rows = if spent.ao + spent.nso > 0.0 {
        vec![
            ("Advection problem".to_owned(), spent.ao, Some(spent.ao_average)),
            (
                "Navier\u{2013}Stokes problem".to_owned(),
                spent.nso,
                Some(spent.nso_average),
            ),
            ("Rest of the iterations".to_owned(), spent.other, None),
            ("Nested start on coarser grids".to_owned(), spent.nested, None),
        ]
    } else if record.windows.is_empty() {
        times_by_grid(record)
    } else {
        vec![
            ("Nested starts on coarser grids".to_owned(), spent.nested, None),
            ("Iterations".to_owned(), spent.other, None),
        ]
    };
    rows.push(("Making the result feasible".to_owned(), spent.finish, None));
    rows.push(("Reading, drawing, planning".to_owned(), spent.setup, None));
    let row = |(name, value, average): &(String, f64, Option<f64>)| {
        let average = average
            .map(|average| format!("<small>{} each</small>", seconds(average)))
            .unwrap_or_default();
        format!(
            "<tr><th>{name}{average}</th><td>{}</td><td class=\"wide\">{}</td></tr>",
            seconds(*value),
            bar(*value, spent.total, "c1")
        )
    };
    let rows: String = rows
        .iter()
        .filter(|(_, value, _)| *value > 0.0)
        .map(row)
        .collect();
    format!(
        "<table><tbody>{rows}</tbody><tfoot><tr><th>Total</th><td>{}</td><td></td></tr></tfoot></table>",
        seconds(spent.total)
    )
}

/// The iterations of each grid with their seconds, in all and each.
fn times_by_grid(record: &RunRecord) -> Vec<(String, f64, Option<f64>)> {
    let mut before = 0.0;
    let row = |piece: &[IterationRecord]| {
        let until = piece.last().map_or(before, |entry| entry.seconds);
        let spent = until - before;
        before = until;
        let cells = piece
            .first()
            .and_then(|entry| entry.level.as_ref())
            .unwrap_or(&record.cells);
        let evaluations: f64 = piece
            .iter()
            .filter_map(|entry| entry.facts.get("evaluations"))
            .sum();
        let evaluations = evaluations as usize;
        let counted = if evaluations > 0 {
            format!(", {}", count(evaluations, "evaluation"))
        } else {
            String::new()
        };
        let name = format!(
            "{} on {} cells{counted}",
            count(piece.len(), "iteration"),
            product(cells)
        );
        (name, spent, Some(spent / piece.len().max(1) as f64))
    };
    by_grid(&record.history).map(row).collect()
}

/// "128 x 128" as on a page.
pub(crate) fn product(cells: &[usize]) -> String {
    cells
        .iter()
        .map(usize::to_string)
        .collect::<Vec<_>>()
        .join(" \u{d7} ")
}

/// The ledger, each line with its part of the whole.
pub(super) fn ledger(record: &RunRecord) -> String {
    let memory = &record.memory;
    let whole = memory.planned_bytes.max(1) as f64;
    let row = |line: &LedgerLine| {
        let depth = line.depth.min(4);
        let name = escape(&line.name);
        let size = line.bytes as f64;
        let bar = bar(size, whole, if line.depth <= 1 { "c2" } else { "c2 part" });
        format!(
            "<tr class=\"d{depth}\"><th>{name}</th><td>{}</td><td>{}</td><td class=\"wide\">{bar}</td></tr>",
            grouped(line.bytes),
            bytes(line.bytes)
        )
    };
    let rows: String = memory.ledger.iter().map(row).collect();
    format!(
        "<table class=\"ledger\"><thead><tr><th>Buffer</th><td>bytes</td><td></td><td></td></tr></thead><tbody>{rows}</tbody></table>"
    )
}

/// Planned, used and the paper's bound in one sentence.
pub(super) fn memory_sentence(record: &RunRecord) -> String {
    let memory = &record.memory;
    let used = if memory.used_bytes == memory.planned_bytes {
        "exactly that was used".to_owned()
    } else {
        format!("{} were taken for it from the system", grouped(memory.used_bytes))
    };
    format!(
        "One block of {} bytes ({}) was planned, and {used}. The paper's bound for a problem of this size is {} bytes ({}).",
        grouped(memory.planned_bytes),
        bytes(memory.planned_bytes),
        grouped(memory.paper_bound_bytes),
        bytes(memory.paper_bound_bytes)
    )
}

fn bar(value: f64, whole: f64, class: &str) -> String {
    let part = if whole > 0.0 {
        (100.0 * value / whole).clamp(0.0, 100.0)
    } else {
        0.0
    };
    format!("<span class=\"bar {class}\"><i style=\"width:{part:.2}%\"></i></span>")
}
