//! The record of a run, from which `report.json` and `report.html` are written.

use super::plan::Planned;
use super::written::Seen;
use crate::progress::Watch;
use crate::report::{
    AdvectionRecord, FluidsRecord, KeyframeRecord, LedgerLine, MemoryRecord, ObjectiveRecord, RunRecord,
    SolvedBy, TemplateRecord, template_record,
};
use crate::run::command_line;
use crate::run::outcome::{buoyancy, scene_file, seconds};
use crate::scene::Scene;
use serde_json::{Map, Value, json};
use std::path::Path;
use thurible_core::choices::{Choices, Value as Chosen};
use thurible_core::stable_fluids::Pressure;
use thurible_core::{Exec, Fluids, Named, Real, Silent, Space, Status};

/// What is known beside what was found.
pub(super) struct Known<'a> {
    pub scene: &'a Scene,
    pub planned: &'a Planned,
    /// Bytes that the block takes from the system.
    pub footprint: usize,
    pub mass_factors: &'a [f64],
    /// The result folder.
    pub folder: &'a Path,
}

/// The record of what was found, as `watch` saw it; `ended` is how it ended.
pub(super) fn of<T: Real, S: Space>(
    known: &Known<'_>,
    fluids: &mut Fluids<'_, T, S>,
    exec: &dyn Exec,
    seen: &Seen,
    ended: Status,
    watch: &mut Watch,
) -> RunRecord {
    let (scene, planned) = (known.scene, known.planned);
    let problem = &planned.problem;
    let (lift, gravity_axis) = buoyancy(&problem.buoyancy, problem.cells.len());
    let steers = !planned.params.controls.is_empty();
    let objective = if steers || !problem.templates.is_empty() {
        // A result without a value has none that is finite.
        let value = fluids.value(exec, &mut Silent);
        value.unwrap_or_else(|_| fluids.objective())
    } else {
        // Nothing is wanted and nothing pushes: J is 0, and no run is needed to say so.
        fluids.objective()
    };
    let priced = |objective: ObjectiveRecord| ObjectiveRecord {
        initial: objective.initial.or(Some(0.0)),
        plain: objective.force,
        ..objective
    };
    let mut history = core::mem::take(&mut watch.history);
    history
        .iter_mut()
        .for_each(|entry| entry.objective = priced(entry.objective));
    let [density_min, density_max] = seen.range;
    RunRecord {
        format: 1,
        cells: problem.cells.clone(),
        boundary: problem.boundary.clone(),
        length: problem.length,
        dt: problem.dt,
        steps: problem.steps,
        simulated_steps: None,
        viscosity: problem.viscosity,
        slip: problem.slip,
        buoyancy: lift,
        gravity_axis,
        acceleration: problem.buoyancy[..problem.cells.len()].to_vec(),
        release: None,
        solid: false,
        outflow: None,
        emission: false,
        force_weight: problem.force_weight,
        force_smoothness: 0.0,
        filters: problem.problem().filters(),
        advection: AdvectionRecord {
            scheme: "semi_lagrangian".into(),
            tolerance: 0.0,
        },
        method: SolvedBy::StableFluids { steers },
        precision: planned.precision.name().into(),
        status: ended.of_result(true),
        objective: priced(objective.into()),
        density_min,
        density_max,
        history,
        memory: memory::<T>(known),
        seconds: seconds(&watch.clock),
        threads: planned.params.threads,
        version: env!("CARGO_PKG_VERSION").into(),
        scene: scene.document.text().into(),
        scene_file: scene_file(scene.document.path(), known.folder),
        overrides: scene.document.assignments().map(Into::into).collect(),
        command: command_line(),
        keyframes: keyframes(known, seen),
        templates: templates(fluids),
        frames: Vec::new(),
        windows: Vec::new(),
        remarks: remarks(known),
        fluids: Some(FluidsRecord {
            velocity_location: "center",
            stable_fluids: choices(planned),
            slots: planned.params.slots.states(),
            recomputed_steps: planned.repeated(),
        }),
    }
}

fn keyframes(known: &Known<'_>, seen: &Seen) -> Vec<KeyframeRecord> {
    let stays = known.scene.keyframes.iter().map(|keyframe| keyframe.stay());
    let each_step = stays.flat_map(|stay| stay.steps().map(move |step| (step, stay)));
    let seen = seen.errors.iter().zip(&seen.mass_ratios);
    let all = each_step.zip(seen).zip(known.mass_factors);
    all.map(
        |(((step, stay), (error, &mass_ratio)), &mass_factor)| KeyframeRecord {
            step,
            relative_l2: error.after,
            relative_l2_before: error.before,
            mass_factor,
            mass_ratio: Some(mass_ratio),
            stay,
        },
    )
    .collect()
}

fn templates<T: Real, S: Space>(fluids: &mut Fluids<'_, T, S>) -> Vec<TemplateRecord> {
    let mut records = Vec::new();
    while let Some(found) = fluids.template(records.len()) {
        let index = records.len();
        let amplitudes =
            (0..found.intervals).filter_map(|interval| fluids.template_amplitude(index, interval));
        records.push(template_record(&found.template, S::DIM, amplitudes));
    }
    records
}

fn memory<T: Real>(known: &Known<'_>) -> MemoryRecord {
    let plan = &known.planned.plan;
    let line = |entry: &thurible_core::Entry| LedgerLine {
        name: entry.name.into(),
        bytes: entry.bytes,
        depth: entry.depth,
    };
    let problem = &known.planned.problem;
    let dims = problem.cells.len();
    let numbers =
        4.0 * (1.0 + dims as f64) * problem.steps as f64 * problem.cells.iter().product::<usize>() as f64;
    MemoryRecord {
        planned_bytes: plan.bytes(),
        used_bytes: known.footprint,
        paper_bound_bytes: (numbers / (1.0 - 0.5_f64.powi(dims as i32))) as usize * T::BYTES,
        ledger: plan.entries().iter().map(line).collect(),
    }
}

/// Every choice as it was used.
fn choices(planned: &Planned) -> Value {
    let params = &planned.params;
    let controls: Vec<&str> = params.controls.list().map(Named::name).collect();
    let mut all = Map::new();
    all.insert("control".into(), json!(controls));
    for (index, choice) in params.table().iter().enumerate() {
        let value = match params.get(index) {
            Some(Chosen::Number(number)) => json!(number),
            Some(Chosen::Count(count)) => json!(count),
            Some(Chosen::Flag(flag)) => json!(flag),
            Some(Chosen::Word(word)) => json!(word),
            _ => Value::Null,
        };
        all.insert(choice.name.into(), value);
    }
    all.insert("slots".into(), json!(planned.params.slots.states()));
    Value::Object(all)
}

/// What a reader should know of the solver's limits.
fn remarks(known: &Known<'_>) -> Vec<String> {
    let (params, cells) = (&known.planned.params, &known.planned.problem.cells);
    let longest = cells.iter().copied().max().unwrap_or(0);
    if params.pressure == Pressure::Conjugate && longest > 64 && params.cg_iterations <= 200 {
        return vec![format!(
            "with {longest} cells a side conjugate gradients need more than {} iterations to project; raise `method.stable_fluids.cg_iterations`",
            params.cg_iterations
        )];
    }
    Vec::new()
}
