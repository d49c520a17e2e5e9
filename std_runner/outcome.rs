//! What a finished solve says about itself: the [`RunRecord`] behind `report.json` and `report.html`.

use crate::job::Job;
use crate::progress::{Clock, Watch};
use crate::report::{AdvectionRecord, KeyframeRecord, LedgerLine, MemoryRecord, RunRecord, SecondsRecord};
use thurible_core::{Named, Real, Solver, Space, Status};

/// The record of `job`, solved by `solver` under the eyes of `watch`.
pub fn record<T: Real, S: Space>(
    job: &Job,
    solver: &Solver<'_, T, S>,
    status: Status,
    watch: &mut Watch,
    mass_factors: &[f64],
) -> RunRecord {
    let problem = &job.planned.problem;
    RunRecord {
        format: 1,
        cells: problem.cells.clone(),
        boundary: problem
            .boundary
            .iter()
            .map(|&boundary| boundary.name().into())
            .collect(),
        length: problem.length,
        dt: problem.dt,
        steps: problem.steps,
        viscosity: problem.viscosity,
        force_weight: problem.force_weight,
        filters: problem.problem().filters(),
        advection: AdvectionRecord {
            scheme: problem.advection.scheme.name().into(),
            tolerance: problem.advection.tolerance,
        },
        method: job.planned.params.method,
        precision: job.planned.precision.name().into(),
        status,
        objective: solver.objective().into(),
        history: core::mem::take(&mut watch.history),
        memory: memory(job),
        seconds: seconds(&watch.clock),
        threads: job.planned.params.threads,
        version: env!("CARGO_PKG_VERSION").into(),
        scene: job.scene.document.text().into(),
        command: command_line(),
        keyframes: keyframes(job, solver, mass_factors),
    }
}

fn memory(job: &Job) -> MemoryRecord {
    let plan = &job.planned.plan;
    let line = |entry: &thurible_core::Entry| LedgerLine {
        name: entry.name.into(),
        bytes: entry.bytes,
        depth: entry.depth,
    };
    MemoryRecord {
        planned_bytes: plan.bytes(),
        used_bytes: job.footprint,
        paper_bound_bytes: plan.paper_bound(),
        ledger: plan.entries().iter().map(line).collect(),
    }
}

fn seconds(clock: &Clock) -> SecondsRecord {
    let iterations = clock.solved - clock.begun;
    SecondsRecord {
        total: clock.total(),
        setup: clock.begun,
        nested: clock.nested,
        ao: clock.ao.seconds(),
        nso: clock.nso.seconds(),
        other: (iterations - clock.nested - clock.ao.seconds() - clock.nso.seconds()).max(0.0),
        finish: clock.finished - clock.solved,
        ao_average: clock.ao.average(),
        nso_average: clock.nso.average(),
    }
}

fn keyframes<T: Real, S: Space>(
    job: &Job,
    solver: &Solver<'_, T, S>,
    mass_factors: &[f64],
) -> Vec<KeyframeRecord> {
    let steps = job.planned.problem.keyframes.iter().zip(mass_factors).enumerate();
    steps
        .map(|(index, (&step, &mass_factor))| {
            let (mut off, mut size) = (0.0, 0.0);
            for (found, wanted) in solver.density(step).iter().zip(solver.keyframe(index)) {
                let (found, wanted) = (found.to_f64(), wanted.to_f64());
                off += (found - wanted) * (found - wanted);
                size += wanted * wanted;
            }
            KeyframeRecord {
                step,
                relative_l2: (off / size).sqrt(),
                mass_factor,
            }
        })
        .collect()
}

/// The command line, with quotes around what a shell would split.
fn command_line() -> String {
    let plain = |text: &str| {
        text.chars()
            .all(|letter| letter.is_ascii_alphanumeric() || "-_./=:,+".contains(letter))
    };
    let quoted = |text: String| {
        if plain(&text) && !text.is_empty() {
            text
        } else {
            format!("'{}'", text.replace('\'', r"'\''"))
        }
    };
    std::env::args_os()
        .map(|argument| quoted(argument.to_string_lossy().into_owned()))
        .collect::<Vec<_>>()
        .join(" ")
}
