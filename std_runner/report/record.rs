//! The facts of a run, as `report.json` holds them.

use serde::{Serialize, Serializer};
use thurible_core::{AdmmProgress, DirectProgress, Method, Named, Objective, Progress, Status};

/// Everything that a program needs to check a result without its scene; values that are not finite become `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunRecord {
    /// Version of this file's format: 1.
    pub format: u32,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// "wall" or "periodic" per axis.
    pub boundary: Vec<String>,
    /// The longest side of the box.
    pub length: f64,
    /// Length of a time step.
    pub dt: f64,
    /// Number of time steps N.
    pub steps: usize,
    /// Kinematic viscosity nu in the scene's units.
    pub viscosity: f64,
    /// Weight r of the force.
    pub force_weight: f64,
    /// Number m of Gaussian filters; `"auto"` is resolved.
    pub filters: usize,
    /// How density was carried.
    pub advection: AdvectionRecord,
    /// How it was solved; in the file its name.
    #[serde(serialize_with = "by_name")]
    pub method: Method,
    /// "f32" or "f64".
    pub precision: String,
    /// How it ended; in the file its name.
    #[serde(serialize_with = "by_name")]
    pub status: Status,
    /// The objective at the end, of the feasible result.
    pub objective: ObjectiveRecord,
    /// One entry an outer iteration.
    pub history: Vec<IterationRecord>,
    /// Bytes planned and used, and what for.
    pub memory: MemoryRecord,
    /// Seconds by phase.
    pub seconds: SecondsRecord,
    /// Threads that the solve used.
    pub threads: usize,
    /// Version of the program.
    pub version: String,
    /// The text of the scene file.
    pub scene: String,
    /// The command line.
    pub command: String,
    /// How well each keyframe was reached.
    pub keyframes: Vec<KeyframeRecord>,
    /// Sentences about what the status alone does not say; mostly none.
    pub remarks: Vec<String>,
}

/// Writes a choice as the word that stands for it.
pub(crate) fn by_name<T: Named, S: Serializer>(choice: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(choice.name())
}

/// The section `advection` of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdvectionRecord {
    /// "quick", "central" or "semi_lagrangian".
    pub scheme: String,
    /// Truncation error that the transport's exponential series may have.
    pub tolerance: f64,
}

/// The objective and its two parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectiveRecord {
    /// Distance from the keyframes.
    pub data: f64,
    /// r/2 times the squared forces.
    pub force: f64,
}

impl From<Objective> for ObjectiveRecord {
    fn from(Objective { data, force }: Objective) -> Self {
        Self { data, force }
    }
}

impl ObjectiveRecord {
    /// The sum of both.
    pub fn total(&self) -> f64 {
        self.data + self.force
    }
}

impl Serialize for ObjectiveRecord {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Parts {
            data: f64,
            force: f64,
            total: f64,
        }
        Parts {
            data: self.data,
            force: self.force,
            total: self.total(),
        }
        .serialize(serializer)
    }
}

/// One outer iteration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IterationRecord {
    /// Number of the iteration, from 1.
    pub iteration: usize,
    /// Since the solve began.
    pub seconds: f64,
    /// The objective after the iteration.
    #[serde(flatten)]
    pub objective: ObjectiveRecord,
    /// What ADMM alone can tell.
    #[serde(flatten)]
    pub admm: Option<AdmmRecord>,
    /// What the direct method alone can tell.
    #[serde(flatten)]
    pub direct: Option<DirectRecord>,
}

impl IterationRecord {
    /// Of an iteration that ended `seconds` after the solve began.
    pub(crate) fn new(seconds: f64, progress: &Progress) -> Self {
        let Progress {
            iteration,
            objective,
            admm,
            direct,
            ..
        } = progress;
        let is_admm = !admm.nso_residuals.is_empty();
        Self {
            iteration: *iteration,
            seconds,
            objective: (*objective).into(),
            admm: is_admm.then(|| admm.into()),
            direct: (direct.level_iteration > 0).then(|| direct.into()),
        }
    }
}

/// One iteration of the direct method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DirectRecord {
    /// Cells of the grid that it worked on.
    pub level: Vec<usize>,
    /// Step along the direction, 0 when none gained anything.
    pub step: f64,
    /// The objective's derivative along the direction.
    pub slope: f64,
    /// Flows whose objective was computed.
    pub evaluations: usize,
}

/// Cells of the grid that an iteration of the direct method worked on.
pub(crate) fn cells(direct: &DirectProgress) -> Vec<usize> {
    direct.cells.into_iter().filter(|&count| count > 1).collect()
}

impl From<&DirectProgress> for DirectRecord {
    fn from(progress: &DirectProgress) -> Self {
        Self {
            level: cells(progress),
            step: progress.step,
            slope: progress.slope,
            evaluations: progress.evaluations,
        }
    }
}

/// One iteration of ADMM.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdmmRecord {
    /// Blending step of the advection problem.
    pub ao_step: f64,
    /// Largest change of the density, in parts of the source's largest.
    pub density_change: f64,
    /// max |f|, scaled, before the first V-cycle of the Navier-Stokes problem and after each.
    pub nso_residuals: Vec<f64>,
    /// Residual of the optimality conditions of the whole problem (the paper's Figure 7).
    pub kkt: f64,
    /// Residual of the advection problem in each of its fixed-point iterations (the paper's Figure 7).
    pub ao_residuals: Vec<f64>,
    /// Distance between v and v*.
    pub gap: f64,
    /// Distance of v* from the keyframes, where the objective's is that of v.
    pub data_of_star: f64,
    /// Whether the multipliers were held.
    pub held: bool,
}

impl From<&AdmmProgress> for AdmmRecord {
    fn from(progress: &AdmmProgress) -> Self {
        Self {
            ao_step: progress.ao_step,
            density_change: progress.density_change,
            nso_residuals: progress.nso_residuals.iter().copied().collect(),
            kkt: progress.kkt,
            ao_residuals: progress.ao_residuals.iter().copied().collect(),
            gap: progress.gap,
            data_of_star: progress.data_of_star,
            held: progress.held,
        }
    }
}

/// The section `memory` of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MemoryRecord {
    /// The block that was asked for.
    pub planned_bytes: usize,
    /// What was carved from it.
    pub used_bytes: usize,
    /// The paper's bound M, in values of this precision.
    pub paper_bound_bytes: usize,
    /// What the bytes are for.
    pub ledger: Vec<LedgerLine>,
}

/// One line of the ledger; a line's parts follow it, one level deeper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LedgerLine {
    /// What the bytes hold.
    pub name: String,
    /// Bytes, those of its parts included.
    pub bytes: usize,
    /// Depth in the tree, 0 for the whole.
    pub depth: usize,
}

/// `seconds`, by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SecondsRecord {
    /// From start to the end of the solve.
    pub total: f64,
    /// Reading the scene, drawing shapes, taking memory.
    pub setup: f64,
    /// The nested start on coarser grids.
    pub nested: f64,
    /// All advection problems.
    pub ao: f64,
    /// All Navier-Stokes problems.
    pub nso: f64,
    /// Everything else of the iterations.
    pub other: f64,
    /// Making the result feasible at the end.
    pub finish: f64,
    /// One advection problem, on average.
    pub ao_average: f64,
    /// One Navier-Stokes problem, on average.
    pub nso_average: f64,
}

/// How well a keyframe was reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KeyframeRecord {
    /// The time step of the keyframe.
    pub step: usize,
    /// Euclidean distance from the target, in parts of the target's size.
    pub relative_l2: f64,
    /// The same of the source, as if it had been held still.
    pub relative_l2_before: f64,
    /// What the target was multiplied by.
    pub mass_factor: f64,
}
