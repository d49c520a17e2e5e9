//! The facts of a run, as `report.json` holds them.

use super::found::TemplateRecord;
use super::iteration::{IterationRecord, ObjectiveRecord, WindowRecord, by_name};
use crate::stay::Stay;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use thurible_core::grid::Side;
use thurible_core::{Boundary, Method, Named, Status, stable_fluids};

/// Everything that a program needs to check a result without its scene; values that are not finite become `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunRecord {
    /// Version of this file's format: 1.
    pub format: u32,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// How each axis ends: in the file its word, or those of its low and its high side where they differ.
    #[serde(serialize_with = "by_side")]
    pub boundary: Vec<Boundary>,
    /// The longest side of the box.
    pub length: f64,
    /// Length of a time step.
    pub dt: f64,
    /// Number of time steps N.
    pub steps: usize,
    /// Of a simulation that was stopped before its end the steps that were simulated: the densities up to there, and the flow before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated_steps: Option<usize>,
    /// Kinematic viscosity nu in the scene's units.
    pub viscosity: f64,
    /// Whether the flow slips along walls and obstacles.
    pub slip: bool,
    /// Acceleration where the density is 1, in the scene's units: along `gravity_axis`, upwards if positive.
    pub buoyancy: f64,
    /// The axis of the box that buoyancy acts along, x being 0; `null` where it is none of them.
    pub gravity_axis: Option<usize>,
    /// The whole acceleration, a number for each axis.
    pub acceleration: Vec<f64>,
    /// Step from which no force acts; `null` without one.
    pub release: Option<usize>,
    /// Whether there are solid cells: then `result.npz` has `solid`.
    pub solid: bool,
    /// Mass that left by open sides; `null` without any, or where emitters that fill up to a target make it unknown.
    pub outflow: Option<f64>,
    /// Whether smoke was made on the way: then `result.npz` has `emission`.
    pub emission: bool,
    /// Weight r of the force.
    pub force_weight: f64,
    /// s of the price r/2 <u, (1 + s^2 C^T C) u>, as a length.
    pub force_smoothness: f64,
    /// Number m of Gaussian filters; `"auto"` is resolved.
    pub filters: usize,
    /// How density was carried.
    pub advection: AdvectionRecord,
    /// How it was solved; in the file its name.
    pub method: SolvedBy,
    /// "f32" or "f64".
    pub precision: String,
    /// How it ended; in the file its name.
    #[serde(serialize_with = "by_name")]
    pub status: Status,
    /// The objective at the end, of the feasible result.
    pub objective: ObjectiveRecord,
    /// The smallest density of all steps.
    pub density_min: f64,
    /// The largest density of all steps.
    pub density_max: f64,
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
    /// The name of the scene file, from the result folder if that lies below its folder.
    pub scene_file: String,
    /// What the command line changed of the scene, `key = value` each, in order.
    pub overrides: Vec<String>,
    /// The command line.
    pub command: String,
    /// How well each keyframe was reached.
    pub keyframes: Vec<KeyframeRecord>,
    /// The templates of the force as they were found; none in most scenes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub templates: Vec<TemplateRecord>,
    /// How far the densities are from those of the result that the simulation began with or was guided by; none without one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<FrameRecord>,
    /// The windows that it was solved in; none where it was solved as a whole.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<WindowRecord>,
    /// Sentences about what the status alone does not say; mostly none.
    pub remarks: Vec<String>,
    /// What Stable Fluids have to say beside that.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub fluids: Option<FluidsRecord>,
}

/// What solved a scene; in the file its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolvedBy {
    /// A method of the core's solver.
    Method(Method),
    /// Stable Fluids: a search, or the flow alone.
    StableFluids {
        /// Whether it is a search.
        steers: bool,
    },
}

impl From<Method> for SolvedBy {
    fn from(method: Method) -> Self {
        Self::Method(method)
    }
}

impl SolvedBy {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Method(method) => method.name(),
            Self::StableFluids { .. } => stable_fluids::NAME,
        }
    }

    /// The method whose words it has: that of the core, or the one that does the same.
    #[must_use]
    pub fn alike(self) -> Method {
        match self {
            Self::Method(method) => method,
            Self::StableFluids { steers: true } => Method::Lbfgs,
            Self::StableFluids { steers: false } => Method::Simulate,
        }
    }
}

impl Serialize for SolvedBy {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// What Stable Fluids say of a result beside what all say.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FluidsRecord {
    /// Where the velocities of `result.npz` are: `center`.
    pub velocity_location: &'static str,
    /// Every choice as it was used.
    pub stable_fluids: Value,
    /// States that were kept; 0 is all that the adjoint reads.
    pub slots: usize,
    /// Steps that a gradient repeated.
    pub recomputed_steps: usize,
}

/// A density beside that of an earlier result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameRecord {
    /// The step of this result.
    pub step: usize,
    /// The step of the earlier result.
    pub frame: usize,
    /// Euclidean distance, in parts of the size of the earlier one.
    pub relative_l2: f64,
}

/// Writes how axes end, each as a word, or as one for either side where they differ.
pub(crate) fn by_side<S: Serializer>(ends: &[Boundary], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(ends.iter().map(end_in_words))
}

/// How an axis ends, as a word, or as one for either side where they differ.
pub(crate) fn end_in_words(end: &Boundary) -> Value {
    let side = |side: Side| if end.opens(side) { "open" } else { "wall" };
    match end {
        Boundary::OpenLow | Boundary::OpenHigh => json!([side(Side::Low), side(Side::High)]),
        whole => whole.name().into(),
    }
}

/// The section `advection` of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdvectionRecord {
    /// Its name: "limited", "quick", "central" or "semi_lagrangian".
    pub scheme: String,
    /// Truncation error that the transport's exponential series may have.
    pub tolerance: f64,
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

/// How well a keyframe was reached at a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KeyframeRecord {
    /// The time step; a keyframe that is held has a record for each of its steps.
    pub step: usize,
    /// Euclidean distance from the target, in parts of the target's size, both in the keyframe's region.
    pub relative_l2: f64,
    /// The same of the source, as if it had been held still.
    pub relative_l2_before: f64,
    /// What the target was multiplied by.
    pub mass_factor: f64,
    /// The mass of the smoke at the step over that of the source; only Stable Fluids, which do not keep it, say it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_ratio: Option<f64>,
    /// All steps of the keyframe; the page says them, `report.json` lists them anyway.
    #[serde(skip)]
    pub stay: Stay,
}

impl RunRecord {
    /// Of each keyframe the step where it is missed most.
    pub(crate) fn worst_of_each(&self) -> impl Iterator<Item = &KeyframeRecord> {
        let held = |one: &KeyframeRecord, next: &KeyframeRecord| one.stay == next.stay;
        self.keyframes.chunk_by(held).filter_map(|records| {
            records
                .iter()
                .max_by(|one, other| one.relative_l2.total_cmp(&other.relative_l2))
        })
    }
}
