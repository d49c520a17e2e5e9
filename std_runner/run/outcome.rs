//! The outcome of a solve: its [`RunRecord`], from which `report.json` and `report.html` are written, and its pictures.

use super::found::{Found, gradients, windows_fall};
use crate::console;
use crate::exit::code_of_result;
use crate::output::Gallery;
use crate::plan::Planned;
use crate::problem::{OwnedProblem, Precision};
use crate::progress::{Clock, Watch};
use crate::remarks::{KeyframeError, OF_SCENES, faint, or_else, remarks, still_falls};
use crate::report::{AdvectionRecord, KeyframeRecord, LedgerLine, MemoryRecord, RunRecord, SecondsRecord};
use crate::scene::{Keyframe, Scene};
use crate::stay::Stay;
use std::fs;
use std::path::Path;
use thurible_core::method::registry::resolved;
use thurible_core::{Named, Status};

/// The outcome of a solve, as a comparison needs it.
pub(crate) struct Outcome {
    /// What `report.json` holds.
    pub record: RunRecord,
    /// The pictures of `report.html`; none if there was no memory for them.
    pub gallery: Gallery,
    /// Whether the result is elsewhere than it should be.
    pub diverted: bool,
}

impl Outcome {
    /// The exit code.
    pub fn exit_code(&self) -> u8 {
        code_of_result(self.record.status, self.diverted)
    }
}

/// What the record holds that the solver does not know.
pub(super) struct Facts<'a> {
    /// The scene, for its text.
    pub scene: &'a Scene,
    /// Parameters and ledger.
    pub planned: &'a Planned,
    /// What was solved: all of the scene, or as much of it as there is a result of.
    pub problem: &'a OwnedProblem,
    /// Bytes that the block takes from the system.
    pub footprint: usize,
    /// What each keyframe was multiplied by, for every step that it stands at.
    pub mass_factors: &'a [f64],
    /// The result folder.
    pub folder: &'a Path,
}

impl Facts<'_> {
    /// The record of what was found, as `watch` saw it; `ended` is how its last step ended.
    pub fn record(&self, found: Found, ended: Status, watch: &mut Watch) -> RunRecord {
        let problem = self.problem;
        let Found {
            errors,
            densities: [density_min, density_max],
            outflow,
            objective,
            templates,
            windows,
        } = found;
        let falls = if windows.is_empty() {
            still_falls(ended, gradients(&watch.history, &problem.cells))
        } else {
            windows_fall(&windows, &watch.history, &problem.cells)
        };
        let (buoyancy, gravity_axis) = buoyancy(&problem.buoyancy, problem.cells.len());
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
            buoyancy,
            gravity_axis,
            acceleration: problem.buoyancy[..problem.cells.len()].to_vec(),
            release: problem.release,
            solid: problem.solids,
            outflow,
            emission: !problem.emitters.is_empty(),
            force_weight: problem.force_weight,
            force_smoothness: self.smoothness(),
            filters: problem.problem().filters(),
            advection: AdvectionRecord {
                scheme: problem.advection.scheme.name().into(),
                tolerance: problem.advection.tolerance,
            },
            method: self.planned.params.method.into(),
            precision: self.planned.precision.name().into(),
            status: ended.of_result(true),
            objective: objective.into(),
            density_min,
            density_max,
            history: core::mem::take(&mut watch.history),
            memory: self.memory(),
            seconds: seconds(&watch.clock),
            threads: self.planned.params.threads,
            version: env!("CARGO_PKG_VERSION").into(),
            scene: self.scene.document.text().into(),
            scene_file: scene_file(self.scene.document.path(), self.folder),
            overrides: self.scene.document.assignments().map(Into::into).collect(),
            command: command_line(),
            keyframes: self.keyframes(&errors),
            templates,
            frames: Vec::new(),
            windows,
            remarks: self.remarks(ended, &errors, falls),
            fluids: None,
        }
    }

    /// What the status alone does not say.
    fn remarks(&self, ended: Status, errors: &[KeyframeError], falls: Option<String>) -> Vec<String> {
        let problem = self.problem.problem();
        let is_double = self.planned.precision == Precision::F64;
        let said = remarks(
            &problem,
            &self.planned.params,
            ended,
            errors,
            is_double,
            &OF_SCENES,
        );
        let mut said = or_else(said, falls);
        said.extend(faint(&problem, self.mass_factors, &OF_SCENES));
        said
    }

    /// s of the price of the force, as a length.
    fn smoothness(&self) -> f64 {
        let problem = self.problem;
        resolved(&problem.problem(), &self.planned.params)
            .scaled_smoothing()
            .sqrt()
            * problem.length
    }

    fn memory(&self) -> MemoryRecord {
        let plan = &self.planned.plan;
        let line = |entry: &thurible_core::Entry| LedgerLine {
            name: entry.name.into(),
            bytes: entry.bytes,
            depth: entry.depth,
        };
        MemoryRecord {
            planned_bytes: plan.bytes(),
            used_bytes: self.footprint,
            paper_bound_bytes: plan.paper_bound(),
            ledger: plan.entries().iter().map(line).collect(),
        }
    }

    fn keyframes(&self, errors: &[KeyframeError]) -> Vec<KeyframeRecord> {
        let stays = self.scene.keyframes.iter().map(Keyframe::stay);
        let each_step = stays.flat_map(|stay| stay.steps().map(move |step| (step, stay)));
        let record =
            |(((step, stay), error), &mass_factor): (((usize, Stay), &KeyframeError), &f64)| KeyframeRecord {
                step,
                relative_l2: error.after,
                relative_l2_before: error.before,
                mass_factor,
                mass_ratio: None,
                stay,
            };
        each_step.zip(errors).zip(self.mass_factors).map(record).collect()
    }
}

/// Buoyancy along one axis and the axis; its strength and none where it is along several. Without buoyancy the axis is the last.
pub(crate) fn buoyancy(acceleration: &[f64; 3], dims: usize) -> (f64, Option<usize>) {
    let mut along = acceleration.iter().enumerate().filter(|&(_, &b)| b != 0.0);
    match (along.next(), along.next()) {
        (None, _) => (0.0, Some(dims - 1)),
        (Some((axis, &b)), None) => (b, Some(axis)),
        _ => (acceleration.iter().map(|b| b * b).sum::<f64>().sqrt(), None),
    }
}

pub(crate) fn seconds(clock: &Clock) -> SecondsRecord {
    let iterations = clock.solved - clock.begun;
    let [ao, nso] = ["ao", "nso"].map(|phase| clock.spent(phase));
    SecondsRecord {
        total: clock.total(),
        setup: clock.begun,
        nested: clock.nested,
        ao: ao.seconds(),
        nso: nso.seconds(),
        other: (iterations - clock.nested - clock.in_phases()).max(0.0),
        finish: clock.finished - clock.solved,
        ao_average: ao.average(),
        nso_average: nso.average(),
    }
}

/// The name of the scene at `path`, with the way to it from `folder` where that goes through parents alone, or through folders below the one that the
/// program was called in: of no other folder is anything said.
pub(crate) fn scene_file(path: &Path, folder: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let place = path.parent().filter(|place| !place.as_os_str().is_empty());
    let way = fs::canonicalize(place.unwrap_or(Path::new(".")))
        .ok()
        .and_then(|place| {
            let from =
                |above: &Path| Some((folder.strip_prefix(above).ok()?, place.strip_prefix(above).ok()?));
            let here = || fs::canonicalize(".").ok();
            let (back, on) = from(&place).or_else(|| from(&here()?))?;
            let back = "../".repeat(back.components().count());
            let on = on
                .components()
                .map(|part| format!("{}/", part.as_os_str().to_string_lossy()));
            Some(back + &on.collect::<String>())
        });
    way.unwrap_or_default() + &name
}

/// The command line as it may be shown to others: an argument, or what stands in it after `=` or in quotation marks, comes down to its last name
/// where it is an absolute path, so that a page tells little of the folders of the machine that made it. What a shell would split stands in quotes.
pub(crate) fn command_line() -> String {
    let arguments = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    arguments
        .enumerate()
        .map(|(index, argument)| console::quoted(&without_folders(index, &argument)))
        .collect::<Vec<_>>()
        .join(" ")
}

/// An argument whose paths are only names: that of the program always, others where they are absolute.
fn without_folders(index: usize, argument: &str) -> String {
    let name = |path: &str| match Path::new(path).file_name() {
        Some(name) if index == 0 || Path::new(path).has_root() => name.to_string_lossy().into_owned(),
        _ => path.to_owned(),
    };
    let start = argument.find('=').map_or(0, |place| place + 1);
    let (option, value) = argument.split_at(start);
    // Every second part stands between quotation marks.
    let parts: Vec<String> = value.split('"').map(name).collect();
    format!("{option}{}", parts.join("\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_shows_no_folders_of_the_machine() {
        for (index, argument, shown) in [
            (0, "target/release/thurible", "thurible"),
            (1, "examples/letter_f.toml", "examples/letter_f.toml"),
            (2, "/home/someone/scene.toml", "scene.toml"),
            (3, "--output=/tmp/paper", "--output=paper"),
            (4, "time.steps=20", "time.steps=20"),
            (5, "1/2", "1/2"),
            (6, "/", "/"),
            (
                7,
                "keyframe[0]={step=9,image=\"/home/someone/f.png\"}",
                "keyframe[0]={step=9,image=\"f.png\"}",
            ),
        ] {
            assert_eq!(without_folders(index, argument), shown);
        }
    }
}
