//! The mass that keyframes are scaled to where emitters fill up to a target: nobody knows it before, so a free flow is asked.

use super::inputs::set_smoke;
use super::job::Job;
use super::stages::Stage;
use crate::exit::Failure;
use crate::remarks::mass;
use core::mem::MaybeUninit;
use thurible_core::{Exec, Real, Silent, SolverError, Space};

/// The mass of the smoke at every step of a flow that nothing steers, simulated in the block of the solve; `None` where no keyframe asks.
///
/// # Errors
/// The block is too small for a simulation, or the flow too fast.
pub(super) fn of_a_free_flow<T: Real, S: Space>(
    job: &Job,
    exec: &dyn Exec,
    block: &mut [MaybeUninit<u8>],
) -> Result<Option<Vec<f64>>, Failure> {
    let scene = &job.request.scene;
    if !scene.asks_a_free_flow() {
        return Ok(None);
    }
    let unknown = |why: &str| {
        let why = format!("cannot be true here: {why}; set it to false, or let the emitters add by a rate");
        scene.document.refuse("control.match_mass", why)
    };
    let refusal = |error: &SolverError| unknown(&format!("the mass is that of a free flow, and {error}"));
    let (mut solver, _) = job.lead_unless::<T, S>(Stage::Free, block, refusal)?;
    set_smoke(scene, &mut solver, &mut Vec::new())?;
    solver.solve(exec, &mut Silent, &mut |_| {});
    if !solver.is_finished() {
        return Err(unknown(
            "the mass is that of a free flow, which becomes too fast to follow",
        ));
    }
    Ok(Some(
        (0..=solver.steps()).map(|step| mass(&solver, step)).collect(),
    ))
}
