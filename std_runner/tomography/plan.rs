//! The memory of a run: a block of lanes, and the results beside it.

use super::request::Request;
use super::views::Views;
use crate::exit::Failure;
use crate::ledger::{plan_event, print_least};
use crate::plan::size_in_words;
use crate::progress::Mode;
use crate::region::MARGIN;
use crate::{bytes, console, threads};
use serde_json::json;
use thurible_core::Real;
use thurible_core::memory::Ledger;
use thurible_core::tomography::{Reconstruction, Tomography};

/// The memory of a run.
pub(super) struct Plan {
    pub ledger: Ledger,
    /// Bytes of a lane.
    pub lane: usize,
    /// Frames that run side by side.
    pub lanes: usize,
    /// Bytes of the results, which are kept until they are written.
    pub beside: usize,
    pub threads: usize,
    pub limit: usize,
}

impl Plan {
    /// Bytes of the block.
    pub fn block(&self) -> usize {
        self.lane.saturating_mul(self.lanes)
    }

    fn all(&self) -> usize {
        self.block().saturating_add(MARGIN).saturating_add(self.beside)
    }
}

/// The plan of `problem` within the ceiling, on fewer lanes if that makes it fit.
pub(super) fn plan<T: Real, const D: usize>(
    request: &Request<'_>,
    views: &Views,
    problem: &Tomography<'_, D>,
) -> Result<Plan, Failure> {
    let mut ledger = Ledger::new();
    Reconstruction::<T, D>::plan(problem, &mut ledger);
    let cells = if problem.settings.keeps_cells() {
        problem.cells.len()
    } else {
        0
    };
    let kept = cells.saturating_add(views.pixels());
    let threads = request
        .options
        .resources
        .threads
        .unwrap_or_else(threads::available);
    let mut plan = Plan {
        lane: ledger.bytes().unwrap_or(usize::MAX),
        lanes: if views.settings.warm {
            1
        } else {
            threads.min(views.frames)
        },
        beside: kept.saturating_mul(T::BYTES).saturating_mul(views.frames),
        limit: request
            .options
            .resources
            .memory_limit
            .or_else(bytes::of_machine)
            .unwrap_or(usize::MAX),
        ledger,
        threads,
    };
    while plan.all() > plan.limit && plan.lanes > 1 && request.options.resources.threads.is_none() {
        plan.lanes /= 2;
    }
    if plan.all() > plan.limit {
        return Err(too_large(request, views, &plan));
    }
    Ok(plan)
}

/// The failure of what does not fit.
pub(super) fn too_large(request: &Request<'_>, views: &Views, plan: &Plan) -> Failure {
    let whose = if request.options.resources.memory_limit.is_some() {
        "--memory-limit allows"
    } else {
        "the system gives no more than"
    };
    Failure::Memory(format!(
        "{}: {} frames of {} cells take {} bytes ({}), and {whose} {} bytes; raise --memory-limit, use fewer --threads or frames, or set `box.cells` smaller",
        views.document.path().display(),
        views.frames,
        size_in_words(&views.cells),
        bytes::grouped(plan.all()),
        bytes::rounded(plan.all()),
        bytes::grouped(plan.limit),
    ))
}

/// Prints it.
pub(super) fn print_plan(request: &Request<'_>, plan: &Plan) {
    if request.options.mode() == Mode::Quiet {
        return;
    }
    let entries = plan.ledger.entries();
    if request.options.mode() == Mode::Json {
        let more = json!({ "lanes": plan.lanes, "lane_bytes": plan.lane, "result_bytes": plan.beside });
        return plan_event(entries, plan.block(), more);
    }
    for entry in entries {
        console::print(&format!("{:>18}  {}", bytes::grouped(entry.bytes), entry.name));
    }
    let lines = [
        (plan.lane, "a frame".to_owned()),
        (plan.block(), format!("the block: {} at a time", plan.lanes)),
        (
            plan.beside,
            "beside it: results until they are written".to_owned(),
        ),
    ];
    for (count, name) in lines {
        console::print(&format!("{:>18}  {name}", bytes::grouped(count)));
    }
    print_least(plan.block().saturating_add(plan.beside));
}
