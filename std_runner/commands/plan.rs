//! `thurible plan SCENE`: the memory of a solve to the byte, and what other sizes and precisions would take.

use super::options::{OnDevice, SceneArguments, Sharing};
use crate::among::said_by_rank;
use crate::bytes::{grouped, rounded};
use crate::console::print;
use crate::devices::{self, Searching, Taken};
use crate::exit::{DONE, Failure};
use crate::fluids;
use crate::ledger::{line, print_least, print_ledger};
use crate::plan::{self, PlanOptions, Planned, block_bytes, plan_fields, scaled, size_in_words};
use crate::problem::{OwnedProblem, Precision};
use crate::progress::{Display, Mode};
use crate::report::count;
use crate::run::{drawing_bytes, unshared};
use crate::scene::Scene;
use crate::windows::Windows;
use clap::Args;
use core::ops::Range;
use serde_json::{Value, json};
use thurible_core::Method;
use thurible_core::grid::Share;
use thurible_core::{Named, Plan};

/// Arguments of `plan`.
#[derive(Args, Debug)]
pub struct PlanArguments {
    /// The scene and the common options.
    #[command(flatten)]
    pub common: SceneArguments,
    /// Plan what `thurible simulate` does with the scene.
    #[arg(long, conflicts_with = "method")]
    pub simulate: bool,
    /// The device that is planned for.
    #[command(flatten)]
    pub on: OnDevice,
    /// The memory of each of N ranks that share the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub ranks: Option<u32>,
    /// How they cut the box.
    #[command(flatten)]
    pub sharing: Sharing,
}

/// Prints the plan of a scene; the answer is the exit code.
pub fn run(arguments: &PlanArguments) -> Result<u8, Failure> {
    let (simulate, ranks) = (arguments.simulate, arguments.ranks.map(|ranks| ranks as usize));
    let blocks = arguments.sharing.blocks;
    blocks.map_or(Ok(()), |blocks| blocks.check(ranks))?;
    let device = arguments.on.open(ranks.is_some())?;
    let arguments = &arguments.common;
    let (path, set) = (&arguments.scene, &arguments.options.set);
    let (scene, options) = if simulate {
        let scene = Scene::load_free(path, set)?.flow_by(Method::Simulate, false);
        (scene, arguments.options.plan_of_a_flow())
    } else {
        let scene = Scene::load(path, set, arguments.method.as_deref())?;
        (scene, arguments.options.plan())
    };
    if let Some(ranks) = ranks {
        let options = PlanOptions { blocks, ..options };
        return plan_ranks(&scene, &options, ranks, arguments.options.mode());
    }
    if device.is_some() {
        devices::steers(&scene)?;
    }
    if scene.method.fluids.chosen {
        return plan_fluids(&scene, &options, arguments.options.mode());
    }
    let planned = match options.limit {
        Some(_) => plan::choose(&scene, &options)?,
        None => plan::make(&scene, &options)?,
    };
    if let Some(device) = device {
        let taken = devices::check(device, &scene, &planned, &options)?;
        print_taken(device, &scene, &taken, arguments.options.mode());
        return Ok(DONE);
    }
    let others = others(&planned);
    match arguments.options.mode() {
        Mode::Human => print_plan(&scene, &planned, &others),
        Mode::Json => {
            let mut fields = plan_fields(&planned);
            fields["others"] = others.iter().map(other_fields).collect();
            Display::new(Mode::Json, 0).event("plan", fields);
        }
        Mode::Quiet => {}
    }
    Ok(DONE)
}

/// Prints what the search on the finest grid takes of a device.
fn print_taken(device: &dyn Searching, scene: &Scene, taken: &Taken, mode: Mode) {
    let Taken { lines, here } = taken;
    let all: usize = lines.iter().map(|(_, bytes)| bytes).sum();
    match mode {
        Mode::Human => {
            print(&format!(
                "{}: on {}",
                scene.document.path().display(),
                device.name()
            ));
            let lines = lines.iter().map(|&(name, bytes)| (name, bytes, 0));
            print_ledger(lines, all, ", of the device's own memory");
            if *here > 0 {
                print(&format!(
                    "{:>18}  of this machine's, beside the solve's own: steps that are streamed to the device",
                    grouped(*here)
                ));
            }
        }
        Mode::Json => {
            let each = lines
                .iter()
                .map(|(name, bytes)| json!({ "name": name, "bytes": bytes }));
            let fields = json!({
                "device": device.name(),
                "device_bytes": all,
                "streamed_bytes": here,
                "entries": each.collect::<Vec<_>>(),
            });
            Display::new(Mode::Json, 0).event("plan", fields);
        }
        Mode::Quiet => {}
    }
}

/// Prints what each of some ranks needs that share a scene, of which none may need more than a ceiling that is given.
fn plan_ranks(scene: &Scene, options: &PlanOptions, ranks: usize, mode: Mode) -> Result<u8, Failure> {
    unshared(scene)?;
    // One rank alone runs as a program without ranks does.
    let share = |rank: usize| (ranks > 1).then(|| Share::new(rank, ranks));
    let of_rank = |rank: usize| -> Result<([Range<usize>; 2], Planned), Failure> {
        let share = share(rank);
        let options = PlanOptions { share, ..*options };
        let planned = match (share, options.limit) {
            (None, Some(_)) => plan::choose(scene, &options)?,
            _ => plan::make(scene, &options)?,
        };
        let grid = planned.problem.problem().grid();
        let [rows, planes] = [grid.dims - 2, grid.dims - 1].map(|axis| grid.of_rank(axis, rank));
        Ok(([rows, planes], planned))
    };
    let blocks = |planned: &Planned| planned.problem.share.is_some_and(|share| share.beside > 1);
    let plans = (0..ranks).map(of_rank).collect::<Result<Vec<_>, _>>()?;
    let blocks_of_ranks = plans.iter().map(|(_, planned)| block_bytes(&planned.plan));
    let largest = blocks_of_ranks.enumerate().max_by_key(|&(_, bytes)| bytes);
    if let (Some(_), Some((rank, _))) = (options.limit, largest) {
        let share = share(rank);
        let fits = plan::choose(scene, &PlanOptions { share, ..*options });
        fits.map_err(|failure| said_by_rank(rank, failure.code(), &failure.to_string()))?;
    }
    let all: usize = plans.iter().map(|(_, planned)| block_bytes(&planned.plan)).sum();
    match mode {
        Mode::Human => {
            print(&format!(
                "{}: {} cells, {}",
                scene.document.path().display(),
                size_in_words(&scene.grid.cells),
                count(ranks, "rank")
            ));
            let in_blocks = plans.iter().any(|(_, planned)| blocks(planned));
            let row = |rank: &str, [rows, planes]: [&str; 2], bytes: &str| {
                let rows = if in_blocks {
                    format!("{rows:>16}")
                } else {
                    String::new()
                };
                print(&format!("{rank:>8}{rows}{planes:>16}{bytes:>20}"));
            };
            row("rank", ["rows", "planes"], "bytes");
            for (rank, (ranges, planned)) in plans.iter().enumerate() {
                let [rows, planes] = ranges
                    .each_ref()
                    .map(|range| format!("{}..{}", range.start, range.end));
                row(
                    &rank.to_string(),
                    [&rows, &planes],
                    &grouped(block_bytes(&planned.plan)),
                );
            }
            row("all", [""; 2], &grouped(all));
            print(&format!(
                "beside its block rank 0 takes {} while shapes are drawn",
                rounded(drawing_bytes(&scene.grid.cells))
            ));
        }
        Mode::Json => {
            let each = plans.iter().enumerate().map(|(rank, ([rows, planes], planned))| {
                let bytes = [planned.plan.bytes(), block_bytes(&planned.plan)];
                let mut fields = json!({ "rank": rank, "planes": [planes.start, planes.end], "planned_bytes": bytes[0], "block_bytes": bytes[1] });
                if blocks(planned) {
                    fields["rows"] = json!([rows.start, rows.end]);
                }
                fields
            });
            let drawing = drawing_bytes(&scene.grid.cells);
            let fields =
                json!({ "ranks": each.collect::<Vec<_>>(), "block_bytes": all, "drawing_bytes": drawing });
            Display::new(Mode::Json, 0).event("plan", fields);
        }
        Mode::Quiet => {}
    }
    Ok(DONE)
}

/// Prints the plan of a scene that Stable Fluids solve.
fn plan_fluids(scene: &Scene, options: &PlanOptions, mode: Mode) -> Result<u8, Failure> {
    let planned = fluids::planned(scene, options)?;
    match mode {
        Mode::Human => fluids::print_plan(scene, &planned),
        Mode::Json => Display::new(Mode::Json, 0).event("plan", planned.fields()),
        Mode::Quiet => {}
    }
    Ok(DONE)
}

/// Another size, with its bytes in f32 and f64 (`None` where the core refuses it).
struct Other {
    cells: Vec<usize>,
    steps: usize,
    bytes: [Option<usize>; 2],
}

fn others(planned: &Planned) -> Vec<Other> {
    let cells = &planned.problem.cells;
    let steps = planned.problem.steps;
    let half = scaled(cells, 1, 2, 1);
    let double = scaled(cells, 2, 1, 1);
    let mut sizes = vec![
        (cells.clone(), steps),
        (half, steps),
        (double, steps),
        (cells.clone(), 2 * steps),
    ];
    sizes.extend(match cells.len() {
        2 => [(vec![128; 2], 40), (vec![256; 2], 80), (vec![512; 2], 120)],
        _ => [(vec![32; 3], 30), (vec![64; 3], 60), (vec![128; 3], 60)],
    });
    let mut seen = Vec::new();
    sizes.retain(|size| {
        !seen.contains(size) && {
            seen.push(size.clone());
            true
        }
    });
    let bytes_of = |problem: &OwnedProblem, precision| planned.bytes_of(problem, precision).ok();
    sizes
        .into_iter()
        .map(|(cells, steps)| {
            let problem = planned.problem.resized(cells.clone(), steps);
            Other {
                cells,
                steps,
                bytes: [Precision::F32, Precision::F64].map(|precision| bytes_of(&problem, precision)),
            }
        })
        .collect()
}

fn other_fields(other: &Other) -> Value {
    json!({ "cells": other.cells, "steps": other.steps, "f32": other.bytes[0], "f64": other.bytes[1] })
}

fn print_plan(scene: &Scene, planned: &Planned, others: &[Other]) {
    let plan = &planned.plan;
    print(&format!(
        "{}: {} cells, {} steps, {}, {}, method {}",
        scene.document.path().display(),
        size_in_words(&planned.problem.cells),
        planned.problem.steps,
        planned.precision.name(),
        count(planned.params.threads, "thread"),
        planned.params.method.name()
    ));
    if let Some(Windows { length, stride }) = planned.windows {
        print(&format!(
            "{} windows of {length} steps, a new one every {stride}; what follows is one of them",
            planned.windows().len()
        ));
    }
    print_ledger(plan.entries().iter().map(line), plan.bytes(), "");
    print_least(plan.bytes());
    print_bound(plan);
    print(&format!(
        "\n{:>18}{:>8}{:>18}{:>20}",
        "cells", "steps", "f32 bytes", "f64 bytes"
    ));
    for other in others {
        let [single, double] = other.bytes.map(|bytes| bytes.map_or_else(|| "-".into(), grouped));
        print(&format!(
            "{:>18}{:>8}{single:>18}{double:>20}",
            size_in_words(&other.cells),
            other.steps
        ));
    }
    if let Some(machine) = crate::bytes::of_machine()
        && block_bytes(plan) > machine
    {
        print(&format!(
            "\nwarning: this machine has {} bytes, so `solve` would refuse",
            grouped(machine)
        ));
    }
}

fn print_bound(plan: &Plan) {
    let share = 100.0 * plan.method_bytes() as f64 / plan.paper_bound().max(1) as f64;
    print(&format!(
        "{:>18}  of it the method, without source and keyframes",
        grouped(plan.method_bytes())
    ));
    print(&format!(
        "{:>18}  the paper's bound for the method; {share:.1} % of it is used",
        grouped(plan.paper_bound())
    ));
}
