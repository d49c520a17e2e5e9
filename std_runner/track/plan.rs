//! The plan of a capture under a ceiling.

use super::given::Given;
use super::scene::CaptureScene;
use crate::bytes;
use crate::console::print;
use crate::exit::Failure;
use crate::ledger::{line, over, plan_event, print_least, print_ledger};
use crate::plan::{PlanOptions, size_in_words};
use crate::problem::Precision;
use crate::progress::Mode;
use crate::region::MARGIN;
use crate::report::count;
use crate::threads;
use serde_json::json;
use thurible_core::{Capture, D2, D3, Named, PlanError, TrackParams, TrackPlan};

/// A plan, and what it was made from.
pub(crate) struct Planned {
    pub given: Given,
    pub params: TrackParams,
    pub precision: Precision,
    pub plan: TrackPlan,
    /// Acceleration along each axis where the density is 1.
    pub buoyancy: [f64; 3],
}

impl Given {
    /// The core's view of the capture.
    pub(super) fn capture(&self, buoyancy: [f64; 3]) -> Capture<'_> {
        Capture {
            length: self.length,
            dt: self.dt,
            density_scale: self.density_scale,
            buoyancy,
            emission: self.has_emission(),
            ..Capture::new(&self.cells, &self.boundary)
        }
    }
}

/// Opens the frames of a capture and plans it within the ceiling; on fewer threads, if their number was not given and that makes it fit.
pub(crate) fn planned(scene: &CaptureScene, options: &PlanOptions) -> Result<Planned, Failure> {
    let given = Given::open(scene)?;
    // Smoke rises along y in 2D and along z in 3D.
    let mut buoyancy = [0.0; 3];
    if let Some(along) = buoyancy.get_mut(given.cells.len() - 1) {
        *along = scene.buoyancy;
    }
    let ceiling = options.limit.or_else(bytes::of_machine);
    let mut threads = options.threads.unwrap_or_else(threads::available);
    loop {
        let params = TrackParams {
            threads,
            ..scene.params
        };
        let plan = plan_of(&given.capture(buoyancy), &params, options.precision)
            .map_err(|error| scene.document.refuse("capture", format!("is refused: {error}")))?;
        let needed = plan.bytes().saturating_add(MARGIN);
        match ceiling {
            Some(limit) if needed > limit => {
                if options.threads.is_some() || threads <= 1 {
                    return Err(over_limit(scene, options, needed, limit));
                }
                threads /= 2;
            }
            _ => {
                return Ok(Planned {
                    given,
                    params,
                    precision: options.precision,
                    plan,
                    buoyancy,
                });
            }
        }
    }
}

fn plan_of(
    capture: &Capture<'_>,
    params: &TrackParams,
    precision: Precision,
) -> Result<TrackPlan, PlanError> {
    match (capture.cells.len(), precision) {
        (2, Precision::F32) => TrackPlan::new::<f32, D2>(capture, params),
        (2, Precision::F64) => TrackPlan::new::<f64, D2>(capture, params),
        (_, Precision::F32) => TrackPlan::new::<f32, D3>(capture, params),
        (_, Precision::F64) => TrackPlan::new::<f64, D3>(capture, params),
    }
}

fn over_limit(scene: &CaptureScene, options: &PlanOptions, needed: usize, limit: usize) -> Failure {
    let less = if options.precision == Precision::F64 {
        "use --precision f32"
    } else {
        "give frames of fewer cells"
    };
    let (path, given) = (scene.document.path(), options.limit.is_some());
    over(path, "tracking needs", (needed, limit), given, &[less.into()])
}

/// Says what is planned, buffer by buffer.
pub(crate) fn print_plan(scene: &CaptureScene, planned: &Planned, mode: Mode) {
    let Planned {
        given,
        params,
        precision,
        plan,
        ..
    } = planned;
    match mode {
        Mode::Quiet => return,
        Mode::Json => return plan_event(plan.entries(), plan.bytes(), json!({})),
        _ => {}
    }
    print(&format!(
        "{}: {} cells, {} frames, {}, {}, method {}",
        scene.document.path().display(),
        size_in_words(&given.cells),
        given.pairs + 1,
        precision.name(),
        count(params.threads, "thread"),
        params.flow.minimiser.name()
    ));
    let lines = plan.entries().iter().map(line);
    print_ledger(lines, plan.bytes(), ", whatever the number of frames");
    print_least(plan.bytes());
}
