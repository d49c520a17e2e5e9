//! A start from the next coarser grid: the same scene, solved there first by the same method in memory that the finer solve is going
//! to use in turn, so that it asks for none of its own.

use super::animation::Animation;
use super::contract::Contract;
use crate::exec::Exec;
use crate::field::{reborrow, view};
use crate::grid::Space;
use crate::memory::{Arena, Layout, Ledger};
use crate::objective::coarse;
use crate::objective::script::Script;
use crate::observe::{Observer, WorkOnly};
use crate::progress::{Progress, Status};
use crate::real::Real;

/// Bytes that a coarse solve by `method`, which has no buffers yet, takes with so many fields of its script.
pub fn bytes<'l, T: Real, S: Space>(
    mut method: impl Contract<'l, T, S>,
    fields: usize,
    ledger: &'l mut Ledger,
) -> Option<usize> {
    let cells = method.animation().grid().cells();
    let mut arena = Arena::measuring(ledger);
    method.layout(&mut Layout::carve(&mut arena)).ok()?;
    let ledger = arena.into_ledger()?;
    ledger.line("fields of the script", fields * cells, T::BYTES);
    ledger.bytes()
}

/// Restricts the scene of `fine` to the grid of `method`, which has no buffers yet, and solves it there in `memory`; how that ended.
/// `scratch` serves the restriction.
///
/// # Errors
/// [`Status::Cancelled`]; [`Status::NotFinite`] where `memory` is too small.
pub fn solve<'m, T: Real, S: Space>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    fine: &Animation<'_, T>,
    script: &Script<'_, T>,
    method: &mut impl Contract<'m, T, S>,
    memory: &'m mut [T],
    scratch: &mut [T],
) -> Result<Status, Status> {
    let mut arena = Arena::over(memory);
    let full = |_| Status::NotFinite;
    method.layout(&mut Layout::carve(&mut arena)).map_err(full)?;
    let cells = method.animation().grid().cells();
    let fields = arena
        .take("fields of the script", script.fields() * cells)
        .map_err(full)?;
    let scene = coarse::Scene {
        source: &fine.rho[..fine.grid().cells()],
        initial: view(&fine.initial),
        script,
    };
    let animation = method.parts().animation;
    animation.levels.take_solids(&fine.levels, 1);
    let coarser = coarse::SceneMut {
        source: &mut animation.rho[..cells],
        initial: reborrow(&mut animation.initial),
        fields: &mut *fields,
    };
    coarse::restrict(exec, &fine.levels, 0, &scene, coarser, scratch);
    let script = script.coarse(1, fields);
    loop {
        let mut progress = Progress::default();
        match method.step(exec, &mut WorkOnly(observer), &script, &mut progress) {
            Ok(()) => {}
            Err(Status::Cancelled) => return Err(Status::Cancelled),
            Err(status) => return Ok(status),
        }
    }
}
