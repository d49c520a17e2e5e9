//! From a checked [`Scene`] to the core's [`Problem`](thurible_core::Problem) and [`Params`], and to a [`Plan`] of any precision.

use crate::exit::Failure;
pub use crate::owned::OwnedProblem;
use crate::scene::{Keyframe, Scene};
use thurible_core::{
    D2, D3, Emitter, Feature, Method, Named, Params, Plan, PlanError, ProblemError, Real, ShareError,
    Template,
};

/// f32 or f64.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Precision {
    /// Single precision, IEEE 754 binary32.
    F32,
    /// Double precision, IEEE 754 binary64.
    F64,
}

impl Precision {
    /// The precision of `T`.
    pub fn of<T: Real>() -> Self {
        if T::BYTES == size_of::<f64>() {
            Precision::F64
        } else {
            Precision::F32
        }
    }

    /// The word for it, `f32` or `f64`.
    pub fn name(self) -> &'static str {
        match self {
            Precision::F32 => "f32",
            Precision::F64 => "f64",
        }
    }
}

impl OwnedProblem {
    /// The problem of a scene.
    pub fn of(scene: &Scene) -> Self {
        OwnedProblem {
            cells: scene.grid.cells.clone(),
            boundary: scene.grid.boundary.clone(),
            keyframes: scene
                .keyframes
                .iter()
                .flat_map(|keyframe| keyframe.stay().steps())
                .collect(),
            keyframe_weights: weights(scene),
            keyframe_regions: scene.keyframes.iter().any(|keyframe| keyframe.region.is_some()),
            emitters: scene.emitters.iter().map(|emitter| emitter.emits).collect(),
            solids: !scene.obstacles.is_empty(),
            buoyancy: scene.flow.buoyancy,
            templates: scene.templates.clone(),
            release: scene.release,
            schedule: scene.control.schedule.clone(),
            mask: scene.control.mask.is_some(),
            steps: scene.time.steps,
            length: scene.grid.length,
            dt: scene.time.dt,
            viscosity: scene.flow.viscosity,
            slip: scene.flow.slip,
            force_weight: scene.control.force_weight,
            smoothness: scene.control.smoothness,
            filters: scene.control.filters,
            match_mass: scene.control.match_mass && !scene.asks_a_free_flow(),
            advection: scene.advection,
            projection_tolerance: scene.method.projection_tolerance,
            share: None,
        }
    }

    /// The same problem on other cells, with `steps` steps; keyframes, emitters, schedule and release keep their share of the time.
    pub fn resized(&self, cells: Vec<usize>, steps: usize) -> Self {
        let count = self.keyframes.len();
        let shared = |step: usize| step * steps / self.steps;
        let mut keyframes: Vec<usize> = self.keyframes.iter().map(|&step| shared(step)).collect();
        for (index, step) in keyframes.iter_mut().enumerate() {
            *step = (*step).clamp(2 + index, steps.saturating_sub(count - 1 - index).max(2 + index));
        }
        let emitters = self.emitters.iter().map(|emitter| {
            let from = shared(emitter.from);
            Emitter {
                from,
                to: shared(emitter.to).max(from + 1),
                ..*emitter
            }
        });
        let templates = self.templates.iter().map(|template| {
            let from = shared(template.from);
            Template {
                from,
                to: shared(template.to).max(from + 1),
                interval: shared(template.interval).max(1),
                ..*template
            }
        });
        let mut schedule: Vec<(usize, f64)> = Vec::new();
        for &(step, factor) in &self.schedule {
            let at = schedule.last().map_or(0, |&(before, _)| before + 1);
            schedule.push((shared(step).max(at), factor));
        }
        let last = keyframes.last().copied().unwrap_or(2);
        OwnedProblem {
            cells,
            steps,
            emitters: emitters.collect(),
            templates: templates.collect(),
            schedule,
            release: self.release.map(|step| shared(step).max(last)),
            keyframes,
            ..self.clone()
        }
    }

    /// The core's plan of this problem in `precision`.
    pub fn plan(&self, params: &Params, precision: Precision) -> Result<Plan, PlanError> {
        let problem = self.problem();
        match (self.cells.len(), precision) {
            (2, Precision::F32) => Plan::new::<f32, D2>(&problem, params),
            (2, Precision::F64) => Plan::new::<f64, D2>(&problem, params),
            (_, Precision::F32) => Plan::new::<f32, D3>(&problem, params),
            (_, Precision::F64) => Plan::new::<f64, D3>(&problem, params),
        }
    }
}

/// What the data term of each keyframe is multiplied by, at all its steps; none where all are 1.
fn weights(scene: &Scene) -> Vec<f64> {
    let weights = |keyframe: &Keyframe| {
        keyframe.stay().steps().map({
            let weight = keyframe.weight;
            move |_| weight
        })
    };
    let weights: Vec<f64> = scene.keyframes.iter().flat_map(weights).collect();
    if weights.iter().all(|&weight| weight == 1.0) {
        Vec::new()
    } else {
        weights
    }
}

/// The core's parameters for a scene on `threads` threads, within `ceiling` bytes if that can be.
pub fn params_of(scene: &Scene, threads: usize, ceiling: Option<usize>) -> Params {
    Params {
        threads,
        ceiling,
        ..scene.method.params
    }
}

/// The sentence for a plan that the core refuses.
pub fn refusal(scene: &Scene, error: PlanError) -> Failure {
    let path = scene.document.path().display();
    match error {
        PlanError::TooLarge => Failure::Memory(format!(
            "{path}: the scene needs more bytes than this machine can address; make `grid.cells` or `time.steps` smaller"
        )),
        PlanError::Problem(ProblemError::NoTemplate) => {
            let name = Method::Templates.name();
            let why =
                format!("is {name}, but the scene has no [[template]]; write one, or take another method");
            scene.document.refuse("method.name", why)
        }
        PlanError::Problem(ProblemError::Share(error @ ShareError::Method { .. })) => {
            let key = "method.name";
            scene.document.refuse(key, format!("is not for ranks: {error}"))
        }
        PlanError::Problem(ProblemError::Share(error)) => Failure::Input(format!("{path}: {error}")),
        PlanError::Problem(ProblemError::Unfit { method, feature }) => {
            let (key, otherwise) = match feature {
                Feature::Smoothness => ("control.smoothness", "set it to 0 or \"auto\""),
                Feature::Buoyancy => ("flow.buoyancy", "set it to 0"),
                Feature::Solids => ("obstacle", "leave it out"),
                Feature::Schedule => ("control.schedule", "leave it out"),
                Feature::Mask => ("control.mask", "leave it out"),
                Feature::Open => ("grid.boundary", "close the box by walls"),
                Feature::Templates => ("template", "leave it out"),
                Feature::Jets => ("emitter", "leave out its `velocity`"),
                Feature::Emitters => ("emitter", "leave it out"),
                Feature::Regions => ("keyframe.region", "leave it out"),
                Feature::Release => ("release", "leave it out"),
                Feature::Sticking => ("flow.slip", "set it to true"),
            };
            let other = match feature {
                Feature::Templates => format!("the method {}", Method::Templates.name()),
                Feature::Open | Feature::Sticking if method == Method::Admm.name() => {
                    "another method, or set `method.admm.nso` to \"newton_cg\"".into()
                }
                _ => "another method".into(),
            };
            let why = format!("is more than the method {method} can do; {otherwise}, or take {other}");
            scene.document.refuse(key, why)
        }
        PlanError::Problem(error @ (ProblemError::SolidScheme | ProblemError::OpenScheme)) => scene
            .document
            .refuse("advection.scheme", format!("cannot be used: {error}")),
        PlanError::Problem(error @ ProblemError::OpenCells { .. }) => scene
            .document
            .refuse("grid.cells", format!("cannot be used: {error}; take fewer")),
        other => Failure::Input(format!("{path}: {other}; change that value in the scene")),
    }
}
