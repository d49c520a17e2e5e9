//! The plan of a scene under a ceiling. What does not fit is refused, with what would fit.

use crate::blocks::{self, Blocks};
use crate::bytes;
use crate::choices::chosen;
use crate::exit::Failure;
use crate::ledger::over;
use crate::phases::phases;
use crate::problem::{OwnedProblem, Precision, params_of, refusal};
use crate::region::MARGIN;
use crate::scene::Scene;
use crate::threads;
use crate::windows::{Window, Windows};
use serde_json::{Value, json};
use thurible_core::grid::Share;
use thurible_core::method::registry::most_iterations;
use thurible_core::method::registry::steers;
use thurible_core::{Entry, Method, Named, Params, Plan, PlanError, Sharing};

/// What the command line asks of a plan.
#[derive(Clone, Copy, Debug)]
pub struct PlanOptions {
    /// f32 or f64.
    pub precision: Precision,
    /// Threads, or `None` for what the machine offers.
    pub threads: Option<usize>,
    /// The ceiling in bytes, or `None` for the machine's memory.
    pub limit: Option<usize>,
    /// Of a solve that goes on: the ceiling that it began under, by which the choices are made that its bits follow from.
    pub began_under: Option<Option<usize>>,
    /// Which of the ranks this program is, where several share the box.
    pub share: Option<Share>,
    /// Their blocks, or `None` for what suits the box.
    pub blocks: Option<Blocks>,
    /// How many of them share this machine's memory.
    pub on_this_machine: usize,
}

/// A plan, and what it was made from.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The problem of the scene.
    pub problem: OwnedProblem,
    /// The parameters, threads included.
    pub params: Params,
    /// f32 or f64.
    pub precision: Precision,
    /// The core's plan: every buffer, to the byte. Of windows it is that of the one that takes most.
    pub plan: Plan,
    /// `[method] window` and `stride`, where the scene is longer than a window.
    pub windows: Option<Windows>,
    /// See [`PlanOptions::began_under`].
    began_under: Option<Option<usize>>,
}

impl Planned {
    /// The ceiling that choices are made under: none by ranks, which all make the same ones.
    pub fn choosing_ceiling(&self) -> Option<usize> {
        let now = self.params.ceiling.filter(|_| self.problem.share.is_none());
        self.began_under.unwrap_or(now)
    }

    /// The parameters for a part of the problem, or for the flow of one that is not searched, with the choices of the solve that goes on.
    pub fn choices(&self, problem: &OwnedProblem, is_searched: bool) -> Params {
        let params = of_part(&self.params, is_searched);
        chosen(problem, &params, self.precision, self.began_under)
    }

    /// Iterations that the solver reports at most.
    pub fn most_iterations(&self) -> usize {
        let one = most_iterations(&self.problem.problem(), &self.params);
        let searched = self
            .windows()
            .iter()
            .filter(|window| window.is_searched())
            .count();
        one.saturating_mul(searched.max(1))
    }

    /// The windows; none where the scene is solved as a whole.
    pub fn windows(&self) -> Vec<Window> {
        self.windows
            .map_or(Vec::new(), |windows| windows.of(&self.problem))
    }

    /// Bytes of the block for another problem of the same kind.
    pub fn bytes_of(&self, problem: &OwnedProblem, precision: Precision) -> Result<usize, PlanError> {
        let plan = plan_of(problem, self.windows, &self.params, (precision, self.began_under));
        plan.map(|plan| plan.bytes())
    }
}

/// The parameters of what is searched, or of a flow that nothing steers.
fn of_part(params: &Params, is_searched: bool) -> Params {
    let method = if is_searched {
        params.method
    } else {
        Method::Simulate
    };
    Params { method, ..*params }
}

/// The plan of a problem, or of that of its windows that takes most; a flow that nothing steers fits into it too.
fn plan_of(
    problem: &OwnedProblem,
    windows: Option<Windows>,
    params: &Params,
    (precision, began_under): (Precision, Option<Option<usize>>),
) -> Result<Plan, PlanError> {
    let chosen = |problem: &OwnedProblem, params: &Params| chosen(problem, params, precision, began_under);
    let Some(windows) = windows.filter(|windows| windows.length < problem.steps) else {
        return problem.plan(&chosen(problem, params), precision);
    };
    problem.problem().check()?;
    let mut kinds: Vec<(bool, OwnedProblem)> = Vec::new();
    let mut add = |searched, problem: OwnedProblem| {
        let same = |(known, other): &(bool, OwnedProblem)| *known == searched && *other == problem;
        if !kinds.iter().any(same) {
            kinds.push((searched, problem));
        }
    };
    for window in windows.of(problem) {
        add(window.is_searched(), window.problem(problem));
        if let Some(way) = window.way(problem) {
            add(true, way);
            // Where the way leads nowhere, the window does without.
            let alone = window.with_aim(false);
            add(alone.is_searched(), alone.problem(problem));
        }
    }
    if steers(params) {
        let piece = windows.of(&problem.unsteered());
        piece
            .iter()
            .for_each(|piece| add(false, piece.problem(&problem.unsteered())));
    }
    let plan = |(searched, problem): &(bool, OwnedProblem)| {
        let params = chosen(problem, &of_part(params, *searched));
        problem.plan(&params, precision)
    };
    let plans = kinds.iter().map(plan).collect::<Result<Vec<_>, _>>()?;
    plans
        .into_iter()
        .max_by_key(Plan::bytes)
        .ok_or(PlanError::TooLarge)
}

/// Bytes of the block for `plan`, with the margin that bumpalo needs.
pub fn block_bytes(plan: &Plan) -> usize {
    plan.bytes().saturating_add(MARGIN)
}

fn ceiling(options: &PlanOptions) -> Option<usize> {
    let own = || bytes::of_machine().map(|all| all / options.on_this_machine.max(1));
    options.limit.or_else(own)
}

/// The plan of `scene`, within the ceiling if that can be.
pub fn make(scene: &Scene, options: &PlanOptions) -> Result<Planned, Failure> {
    let ceiling = ceiling(options).map(|limit| limit.saturating_sub(MARGIN));
    // Ranks are put side by side on a machine, so each has one thread where nobody says more.
    let by_default = || options.share.map_or_else(threads::available, |_| 1);
    let params = params_of(scene, options.threads.unwrap_or_else(by_default), ceiling);
    let problem = OwnedProblem {
        share: options
            .share
            .map(|share| blocks::cut(share, options.blocks, &scene.grid.cells, &params)),
        ..OwnedProblem::of(scene)
    };
    let windows = scene
        .method
        .windows
        .filter(|windows| windows.length < problem.steps);
    let plan = plan_of(
        &problem,
        windows,
        &params,
        (options.precision, options.began_under),
    )
    .map_err(|error| refusal(scene, error))?;
    Ok(Planned {
        problem,
        params,
        precision: options.precision,
        plan,
        windows,
        began_under: options.began_under,
    })
}

/// The plan of `scene` within the ceiling; on fewer threads, if their number was not given and that makes it fit.
pub fn choose(scene: &Scene, options: &PlanOptions) -> Result<Planned, Failure> {
    let mut planned = make(scene, options)?;
    let Some(limit) = ceiling(options) else {
        return Ok(planned);
    };
    while block_bytes(&planned.plan) > limit {
        if options.threads.is_some() || planned.params.threads <= 1 {
            return Err(over_limit(scene, &planned, options, limit));
        }
        planned = make(
            scene,
            &PlanOptions {
                threads: Some(planned.params.threads / 2),
                ..*options
            },
        )?;
    }
    Ok(planned)
}

/// Refuses a plan that leaves no room under the ceiling for so many bytes more of steps that are streamed to a device.
pub fn leaves(
    scene: &Scene,
    planned: &Planned,
    options: &PlanOptions,
    streamed: usize,
) -> Result<(), Failure> {
    let needed = block_bytes(&planned.plan).saturating_add(streamed);
    match ceiling(options) {
        Some(limit) if streamed > 0 && needed > limit => Err(over(
            scene.document.path(),
            "the solve and the steps that are streamed to the device need",
            (needed, limit),
            options.limit.is_some(),
            &["let it take more of the device by --device-memory".into()],
        )),
        _ => Ok(()),
    }
}

fn over_limit(scene: &Scene, planned: &Planned, options: &PlanOptions, limit: usize) -> Failure {
    let needed = block_bytes(&planned.plan);
    let mut ways = Vec::new();
    let alone = PlanOptions {
        threads: Some(1),
        ..*options
    };
    if planned.params.threads > 1 && make(scene, &alone).is_ok_and(|alone| block_bytes(&alone.plan) <= limit)
    {
        ways.push("use --threads 1, which fits".into());
    }
    if options.began_under.is_some() {
        // A solve goes on as the scene that it is.
        ways.push("go on with it on a machine that has more".into());
    } else {
        smaller(&mut ways, planned, limit);
    }
    let (path, given) = (scene.document.path(), options.limit.is_some());
    over(path, "the solve needs", (needed, limit), given, &ways)
}

/// Adds how a scene is solved within `limit` otherwise.
fn smaller(ways: &mut Vec<String>, planned: &Planned, limit: usize) {
    let fits = |precision| {
        let bytes = planned.bytes_of(&planned.problem, precision);
        bytes.is_ok_and(|bytes| bytes.saturating_add(MARGIN) <= limit)
    };
    if planned.precision == Precision::F64 && fits(Precision::F32) {
        ways.push("use --precision f32, which fits".into());
    }
    ways.push(match largest_grid(planned, limit) {
        Some(cells) => format!("set `grid.cells` to {cells:?}, the largest grid of this shape that fits"),
        None if planned.windows.is_some() => {
            "make `method.window` shorter, as no grid of this shape fits with so many steps".into()
        }
        None => "take fewer steps, as no grid of this shape fits with so many".into(),
    });
    if planned.problem.share.is_some() {
        ways.push("take more ranks".into());
    }
    if planned.windows.is_none() && planned.params.method != Method::Guide {
        ways.push("solve it in parts by `method.window`".into());
    }
}

/// The largest grid of the same proportions, in steps of four cells, whose plan is within `limit`.
pub fn largest_grid(planned: &Planned, limit: usize) -> Option<Vec<usize>> {
    let longest = planned.problem.cells.iter().copied().max()?;
    (1..longest.div_ceil(4))
        .rev()
        .map(|quarter| scaled(&planned.problem.cells, 4 * quarter, longest, 4))
        .find(|cells| {
            let smaller = planned.problem.resized(cells.clone(), planned.problem.steps);
            let bytes = planned.bytes_of(&smaller, planned.precision);
            bytes.is_ok_and(|bytes| bytes.saturating_add(MARGIN) <= limit)
        })
}

/// `cells` times `over / under`, each rounded to a multiple of `unit` and at least 4.
pub fn scaled(cells: &[usize], over: usize, under: usize, unit: usize) -> Vec<usize> {
    let round = |count: usize| (2 * count * over + unit * under) / (2 * unit * under) * unit;
    cells.iter().map(|&count| round(count).max(4)).collect()
}

/// A plan as JSON: for `plan --json` and the first line of `solve --json`.
pub fn plan_fields(planned: &Planned) -> Value {
    let held = planned
        .windows
        .map_or(planned.problem.steps, |windows| windows.length);
    let mut fields = json!({
        "cells": planned.problem.cells,
        "steps": planned.problem.steps,
        "precision": planned.precision.name(),
        "threads": planned.params.threads,
        "method": planned.params.method.name(),
        "planned_bytes": planned.plan.bytes(),
        "block_bytes": block_bytes(&planned.plan),
        "method_bytes": planned.plan.method_bytes(),
        "paper_bound_bytes": planned.plan.paper_bound(),
        "saved_bytes": planned.plan.saved_bytes(),
        "bytes_per_cell_and_step": planned.plan.bytes() as f64 / (planned.problem.cells.iter().product::<usize>() * held) as f64,
        "keyframes": planned.problem.keyframes,
        "boundary": planned.problem.boundary.iter().map(|&boundary| boundary.name()).collect::<Vec<_>>(),
        "phases": phases(planned.plan.entries(), planned.plan.bytes()),
        "ledger": planned.plan.entries().iter().map(entry_fields).collect::<Vec<_>>(),
    });
    if let Some(Windows { length, stride }) = planned.windows {
        let count = planned.windows().len();
        fields["windows"] = json!({ "length": length, "stride": stride, "count": count });
    }
    fields
}

fn entry_fields(entry: &Entry) -> Value {
    let sharing = match entry.sharing {
        Sharing::Buffer => "buffer",
        Sharing::Together => "together",
        Sharing::InTurn => "in_turn",
    };
    json!({ "name": entry.name, "bytes": entry.bytes, "depth": entry.depth, "sharing": sharing })
}

/// `128 x 128`
pub fn size_in_words(cells: &[usize]) -> String {
    cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
}
