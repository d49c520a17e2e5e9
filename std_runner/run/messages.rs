//! What a solve prints before and after, and its failures.

use crate::bytes;
use crate::checkpoint::Keeper;
use crate::console;
use crate::destination::{Destination, RUN_AGAIN};
use crate::exit::{Failure, code_of_result};
use crate::plan::{Planned, plan_fields, size_in_words};
use crate::problem::OwnedProblem;
use crate::progress::{Display, Mode, Watch, in_words};
use crate::remarks::{self, KeyframeError};
use crate::report::{KeyframeRecord, RunRecord, count, template_lines};
use crate::scene::Scene;
use crate::windows::Window;
use serde_json::json;
use std::path::Path;
use thurible_core::{Method, Named, Status};

/// Says what is going to be solved, and in how many bytes.
pub(super) fn plan(display: &Display, scene: &Scene, planned: &Planned) {
    display.event("plan", plan_fields(planned));
    display.note(&format!(
        "{} by {}: {} cells, {}, {} bytes ({}) in {}, {}",
        scene.document.path().display(),
        planned.params.method.name(),
        size_in_words(&planned.problem.cells),
        count(planned.problem.steps, "step"),
        bytes::grouped(planned.plan.bytes()),
        bytes::rounded(planned.plan.bytes()),
        planned.precision.name(),
        count(planned.params.threads, "thread")
    ));
}

/// Says how many windows there are.
pub(super) fn windows(display: &Display, windows: &[Window]) {
    let longest = windows.iter().map(|window| window.steps).max().unwrap_or(0);
    let count = windows.len();
    display.note(&format!(
        "{count} windows of {longest} steps at most, one after the other in this memory"
    ));
}

/// Says which window is next.
pub(super) fn window(
    display: &Display,
    problem: &OwnedProblem,
    (number, count): (usize, usize),
    window: &Window,
) {
    let (start, end) = (window.start, window.start + window.steps);
    let steps = window
        .keyframes
        .iter()
        .filter_map(|number| problem.keyframes.get(*number));
    let steps: Vec<usize> = steps.copied().collect();
    let ahead = window.beyond().and_then(|number| problem.keyframes.get(number));
    display.event(
        "window",
        json!({ "window": number, "start": start, "steps": window.steps, "keyframes": steps, "ahead": ahead }),
    );
    let to = match steps.as_slice() {
        [] => String::new(),
        [one] => format!(", to the keyframe at {one}"),
        [first, .., last] => format!(", to the keyframes from {first} to {last}"),
    };
    let then = match ahead {
        Some(step) => format!(", on the way to the keyframe at {step}"),
        None if steps.is_empty() => ", simulated".into(),
        None => String::new(),
    };
    display.note(&format!(
        "window {} of {count}: steps {start} to {end}{to}{then}",
        number + 1
    ));
}

/// That a result has fewer than the `whole` steps of its scene.
pub(super) fn short(record: &RunRecord, whole: usize) -> Option<String> {
    let RunRecord { steps, .. } = record;
    (*steps < whole)
        .then(|| format!("the result ends at step {steps} of {whole}: the windows after it were not solved"))
}

/// That what was simulated was stopped after a step.
pub(super) fn stopped_after(step: usize, steps: usize) -> String {
    format!(
        "It was stopped after step {step} of {steps}: the flow behind it was not simulated, and is that of the start, or the given one."
    )
}

/// That the flow behind a step, with which the result ends, became too fast.
pub(super) fn too_fast(step: usize) -> String {
    format!(
        "The flow behind step {step} became too fast to follow, so the result ends there; try more `time.steps`, or a weaker drive or buoyancy."
    )
}

/// Says how the solve ended, and where the result is.
pub(crate) fn result(mode: Mode, watch: &Watch, record: &RunRecord, destination: &Destination) {
    let (status, objective) = (record.status, record.objective);
    let folder = destination.shown();
    watch.display.event(
        "result",
        json!({
            "status": status.name(),
            "exit_code": code_of_result(status, destination.diverted().is_some()),
            "iterations": record.history.len(),
            "seconds": watch.clock.seconds(),
            "objective": objective,
            "folder": folder.display().to_string(),
            "keyframes": record.keyframes,
            "templates": record.templates,
            "remarks": record.remarks,
        }),
    );
    if mode == Mode::Human {
        summary(watch, record, folder);
    }
    if let Some(why) = destination.diverted() {
        console::error(&format!("thurible: {why}"));
    }
}

/// Says that the solve goes on from a state, and how far that was.
pub(crate) fn goes_on(display: &Display, folder: &Path, watch: &Watch) {
    let (done, seconds) = (watch.history.len(), watch.clock.seconds());
    display.event(
        "resumed",
        json!({ "iterations": done, "seconds": seconds, "from": folder.display().to_string() }),
    );
    display.note(&format!(
        "going on from {} after {} and {}",
        folder.display(),
        count(done, "iteration"),
        in_words(seconds)
    ));
}

/// Says that no states are kept of a simulation that is one pass, whatever was asked for.
pub(super) fn keeps_none(display: &Display, method: Method) {
    display.note(if method == Method::Guide {
        "a guided flow is one pass, so `--checkpoint` keeps nothing of it"
    } else {
        "a simulation is one pass, so `--checkpoint` keeps nothing of it; in windows (method.window) it does"
    });
}

/// Says how an interrupted solve is gone on with.
pub(super) fn can_go_on(display: &Display, states: &Path) {
    display.event("kept", json!({ "states": states.display().to_string() }));
    if display.mode() == Mode::Human {
        console::print(&format!(
            "its state is kept: `thurible resume {}` goes on",
            console::quoted_path(states)
        ));
    }
}

/// The failure of a result that could not be written, with where the state of its solve is kept.
pub(crate) fn unwritten(failure: Failure, kept: Option<&Path>) -> Failure {
    let Failure::File(why) = failure else {
        return failure;
    };
    let why = why.trim_end_matches(RUN_AGAIN).trim_end_matches("; ");
    Failure::File(match kept {
        Some(place) => format!(
            "{why}; the state of the solve is kept in {}: free some space and `thurible resume {}` writes the result, with -o DIR elsewhere",
            place.display(),
            console::quoted_path(place)
        ),
        None => format!("{why}; {RUN_AGAIN}"),
    })
}

/// How it ended, the objective, and where the result is.
fn summary(watch: &Watch, record: &RunRecord, folder: &Path) {
    let (status, objective) = (record.status, record.objective);
    console::print(&format!(
        "{} after {} and {}",
        in_sentence(status),
        count(record.history.len(), "iteration"),
        in_words(watch.clock.seconds())
    ));
    let initial = objective.initial.map_or_else(String::new, |initial| {
        format!(" + initial velocity {initial:.5e}")
    });
    console::print(&format!(
        "objective {:.5e} = keyframes {:.5e} + force {:.5e}{initial}",
        objective.total(),
        objective.data,
        objective.force
    ));
    if let Some(errors) = keyframe_errors(record) {
        console::print(&format!("keyframe error: {errors}"));
    }
    template_lines(&record.templates).for_each(|line| console::print(&line));
    record
        .remarks
        .iter()
        .for_each(|remark| console::print(&format!("note: {remark}")));
    console::print(&format!(
        "result in {}; open {}",
        folder.display(),
        folder.join("report.html").display()
    ));
}

/// The keyframe errors of a result in words; that of a keyframe that is held is its largest.
fn keyframe_errors(record: &RunRecord) -> Option<String> {
    let error = |keyframe: &KeyframeRecord| KeyframeError {
        stay: keyframe.stay,
        before: keyframe.relative_l2_before,
        after: keyframe.relative_l2,
        // The words do not tell it.
        denser: keyframe.mass_factor,
    };
    remarks::in_words(&record.worst_of_each().map(error).collect::<Vec<_>>())
}

fn in_sentence(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::MaxIterations => "stopped at its limit",
        Status::Stalled => "stalled before its tolerance",
        Status::NotFinite => "left the finite numbers",
        Status::Cancelled => "interrupted",
        Status::NotReady => "lacked its densities",
    }
}

/// The failure of a block, or of what the runner needs beside it, that the system does not give.
pub(crate) fn no_memory(bytes: usize) -> Failure {
    Failure::Memory(format!(
        "the system has not {} bytes ({}) for the solve and a little more to read and write; close other programs, or make `grid.cells` or `time.steps` smaller",
        bytes::grouped(bytes),
        bytes::rounded(bytes)
    ))
}

/// The failure of a solve that `ended` without a flow that a result could hold. States go, but for those of a solve that was stopped: it goes on from them.
pub(super) fn without_flow(scene: &Scene, ended: Status, keeper: &mut Keeper) -> Failure {
    if ended != Status::Cancelled {
        keeper.forget();
        return not_finite(scene);
    }
    let remedy = match keeper.kept() {
        Some(states) => format!(
            "its state is kept: `thurible resume {}` goes on",
            console::quoted_path(states)
        ),
        None => "no state of it was kept: solve it again, with --checkpoint to keep one".into(),
    };
    Failure::NotFinite(format!(
        "{}: it was stopped, and the flow so far becomes too fast where it is followed to the end of the scene, so nothing was written; {remedy}",
        scene.document.path().display()
    ))
}

/// The failure of a solve without a result that could be written.
pub(crate) fn not_finite(scene: &Scene) -> Failure {
    Failure::NotFinite(format!(
        "{}: the solve left the finite numbers, or a flow was too fast to follow from the start, and nothing was written; try --precision f64, more `time.steps`, a slower initial velocity or a weaker buoyancy",
        scene.document.path().display()
    ))
}
