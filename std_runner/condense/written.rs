//! The folder of a variant: `result.npz` and `report.json`.

use super::cases::{Case, Variant};
use super::job::{Outcome, status_word};
use super::planned::ledger;
use crate::output::{List, OutputError, Values, write_bytes, write_lists};
use crate::report;
use crate::run::command_line;
use serde_json::{Value, json};
use std::path::Path;
use thurible_core::Named;

/// Writes both into `folder`.
pub(super) fn write(
    folder: &Path,
    case: &Case,
    variant: &Variant,
    outcome: &Outcome,
) -> Result<(), OutputError> {
    let mesh = &case.problem.mesh;
    let (n, dims) = (mesh.held.len(), mesh.dims);
    let elements: Vec<i64> = mesh.elements.iter().map(|&corner| i64::from(corner)).collect();
    let whole = |list: &[usize]| -> Vec<i64> { list.iter().map(|&count| count as i64).collect() };
    let (iterations, builds) = (whole(&outcome.iterations), whole(&outcome.builds));
    let list = |name: &'static str, shape: Vec<usize>, values| List { name, shape, values };
    let lists = [
        list("rest", vec![n, dims], Values::Reals(&mesh.rest)),
        list(
            "elements",
            vec![elements.len() / (dims + 1), dims + 1],
            Values::Whole(&elements),
        ),
        list("fixed", vec![n], Values::Flags(&mesh.held)),
        list(
            "position",
            vec![outcome.iterations.len() + 1, n, dims],
            Values::Reals(&outcome.position),
        ),
        list("iterations", vec![iterations.len()], Values::Whole(&iterations)),
        list("builds", vec![builds.len()], Values::Whole(&builds)),
        list(
            "energy",
            vec![outcome.energy.len()],
            Values::Reals(&outcome.energy),
        ),
        list(
            "residual",
            vec![outcome.residual.len()],
            Values::Reals(&outcome.residual),
        ),
    ];
    write_lists(&folder.join(report::ARCHIVE), &lists)?;
    let path = folder.join("report.json");
    let json = serde_json::to_vec_pretty(&record(case, variant, outcome)).map_err(OutputError::of(&path))?;
    write_bytes(&path, &json)
}

/// The facts of a run.
pub(super) fn record(case: &Case, variant: &Variant, outcome: &Outcome) -> Value {
    let params = &outcome.params;
    let [build, direction, search] = outcome.seconds;
    json!({
        "format": 1,
        "kind": "condense",
        "version": env!("CARGO_PKG_VERSION"),
        "command": command_line(),
        "scene": case.document.text(),
        "overrides": case.document.assignments().collect::<Vec<_>>(),
        "case": case.label,
        "variant": variant.name,
        "method": params.method.name(),
        "basis": params.method.is_built().then(|| params.basis.name()),
        "block": params.block.name(),
        "order": params.order.name(),
        "rebuild": params.rebuild,
        "radius": params.radius,
        "noise": params.noise,
        "seed": params.seed,
        "search": params.search,
        "dt": params.dt,
        "tolerance": params.tolerance,
        "cap": params.cap,
        "precision": outcome.precision.name(),
        "threads": params.threads,
        "vertices": case.problem.mesh.held.len(),
        "elements": case.problem.mesh.mesh().count(),
        "steps": case.problem.steps,
        "status": status_word(outcome.status),
        "iterations": outcome.iterations,
        "builds": outcome.builds,
        "energy": outcome.energy.last(),
        "residual": outcome.residual.last(),
        "seconds": { "build": build, "direction": direction, "search": search, "total": outcome.total },
        "memory": {
            "planned_bytes": outcome.planned,
            "used_bytes": outcome.used,
            "ledger": ledger(&outcome.ledger),
        },
    })
}
