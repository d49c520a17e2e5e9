//! What is made of a flow that is known: simulated on from any step, and guiding another simulation.

use crate::support::{Ended, bytes_after, fresh_folder, run, text};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// A plume in a small box.
const PLUME: &str = r#"
[grid]
cells = [24, 32]
boundary = ["wall", "periodic"]
[time]
steps = 12
[source]
circle = { center = [0.4, 0.35], radius = 0.15 }
[flow]
buoyancy = 0.003
[output]
frames = false
"#;

/// The plume of a test, simulated: its scene and its result.
fn plume(test: &str) -> [PathBuf; 2] {
    let folder = fresh_folder(test);
    let (scene, result) = (folder.join("scene.toml"), folder.join("plume"));
    fs::write(&scene, PLUME).unwrap();
    well(&["simulate", text(&scene), "--quiet", "-o", text(&result)]);
    [scene, result]
}

/// Runs what must end well.
fn well(arguments: &[&str]) -> Ended {
    let ended = run(arguments);
    assert_eq!(ended.code, 0, "{arguments:?}: {}", ended.err);
    ended
}

fn report(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("report.json")).unwrap()).unwrap()
}

/// Step, step of the earlier result, and how far apart.
fn frames(report: &Value) -> Vec<(u64, u64, f64)> {
    let frames = report["frames"].as_array().unwrap();
    let number = |frame: &Value, key: &str| frame[key].as_u64().unwrap();
    frames
        .iter()
        .map(|frame| {
            (
                number(frame, "step"),
                number(frame, "frame"),
                frame["relative_l2"].as_f64().unwrap(),
            )
        })
        .collect()
}

#[test]
fn a_free_flow_goes_on_from_any_step_as_it_went() {
    let [scene, result] = plume("flows_on");
    let on = result.with_file_name("on");
    well(&[
        "simulate",
        text(&scene),
        "--from",
        text(&result),
        "--at",
        "4",
        "--steps",
        "10",
        "--quiet",
        "-o",
        text(&on),
    ]);
    let frames = frames(&report(&on));
    // Steps beyond the end of the earlier result have nothing beside them.
    assert_eq!(frames.len(), 8);
    for (index, &(step, frame, apart)) in frames.iter().enumerate() {
        assert_eq!((step, frame), (index as u64 + 1, index as u64 + 5));
        assert!(apart < 1e-4, "step {step}: {apart}");
    }
    let page = fs::read_to_string(on.join("report.html")).unwrap();
    assert!(page.contains("Beside the earlier result"));
    // Without --at it goes on from the end, where nothing is known.
    let end = result.with_file_name("end");
    well(&[
        "simulate",
        text(&scene),
        "--from",
        text(&result),
        "--quiet",
        "-o",
        text(&end),
    ]);
    assert!(report(&end).get("frames").is_none());
}

#[test]
fn a_flow_goes_on_in_a_box_that_is_open_at_one_end_of_an_axis() {
    let folder = fresh_folder("flows_half_open");
    let path = folder.join("scene.toml");
    let scene = "[grid]\ncells = [12, 12]\nboundary = [\"wall\", [\"wall\", \"open\"]]\n[time]\nsteps = 4\n[flow]\nbuoyancy = 2e-3\n[source]\ncircle = { center = [0.5, 0.3], radius = 0.2 }\n";
    fs::write(&path, scene).unwrap();
    let [first, on] = ["first", "on"].map(|name| folder.join(name));
    well(&["simulate", text(&path), "--quiet", "-o", text(&first)]);
    let from = ["--from", text(&first), "--at", "2"];
    well(&[&["simulate", text(&path), "--quiet", "-o", text(&on)][..], &from].concat());
    // The other end is another box.
    let turned = ["--set", "grid.boundary=[\"wall\", \"open_low\"]", "--force"];
    let ended = run(&[&["simulate", text(&path), "-o", text(&on)][..], &from, &turned].concat());
    assert_eq!(ended.code, 2, "{}", ended.err);
    let said =
        "has the boundary [\"wall\",[\"wall\",\"open\"]], and the scene [\"wall\",[\"open\",\"wall\"]]";
    assert!(ended.err.contains(said), "{}", ended.err);
}

#[test]
fn a_guided_flow_follows_its_reference() {
    let [scene, result] = plume("flows_guided");
    let guided = |name: &str, more: &[&str]| {
        let folder = result.with_file_name(name);
        let common = [
            "guide",
            text(&scene),
            "--reference",
            text(&result),
            "--quiet",
            "-o",
            text(&folder),
        ];
        well(&[&common[..], more].concat());
        report(&folder)
    };
    let last = |report: &Value| frames(report).last().unwrap().2;
    let weightless = ["--set", "flow.buoyancy=0"];
    let near = guided("near", &weightless);
    assert_eq!(near["method"], "guide");
    assert!(last(&near) < 0.03, "{}", last(&near));
    // Little is left of it where the correction is dear.
    let loose = guided(
        "loose",
        &[&weightless[..], &["--set", "method.guide.kinetic=100"]].concat(),
    );
    assert!(last(&loose) > 5.0 * last(&near), "{}", last(&loose));
    // ADMM comes to nearly the same.
    let admm = guided(
        "admm",
        &[&weightless[..], &["--set", "method.guide.solver=\"admm\""]].concat(),
    );
    assert!((last(&admm) - last(&near)).abs() < 1e-3);
    // On finer cells it leads as well; how far the densities are is not known there.
    let finer = guided(
        "finer",
        &[&weightless[..], &["--set", "grid.cells=[48, 64]"]].concat(),
    );
    assert!(finer.get("frames").is_none());
    let top = |folder: &str, cells: [usize; 2]| {
        let (_, density) = array(&result.with_file_name(folder), "density");
        let last = &density[12 * cells[0] * cells[1]..];
        let rows = last.chunks(cells[0]).enumerate();
        let (sum, weighed) = rows.fold((0.0, 0.0), |(sum, weighed), (up, row)| {
            let mass: f64 = row.iter().sum();
            (sum + mass, weighed + mass * (up as f64 + 0.5) / cells[1] as f64)
        });
        weighed / sum
    };
    let still = {
        let (_, density) = array(&result, "density");
        let rows = density.chunks(24).take(32).enumerate();
        let (sum, weighed) = rows.fold((0.0, 0.0), |(sum, weighed), (up, row)| {
            let mass: f64 = row.iter().sum();
            (sum + mass, weighed + mass * (up as f64 + 0.5) / 32.0)
        });
        weighed / sum
    };
    let [risen, led] = [top("plume", [24, 32]), top("finer", [48, 64])];
    assert!(
        (led - risen).abs() < 0.1 * (risen - still),
        "{led} beside {risen}, from {still}"
    );
    // From step 5 of the reference on, with its smoke.
    let late = guided("late", &["--at", "5", "--from-reference", "--steps", "6"]);
    assert_eq!(frames(&late)[0].1, 6);
    assert!(last(&late) < 0.01, "{}", last(&late));
    // A reference is taken step by step, whatever units the scene has.
    let from_there = ["--at", "5", "--from-reference", "--steps", "6"];
    let units = ["--set", "grid.length=3", "--set", "time.dt=0.25"];
    let obstacle = |center, radius| format!("obstacle=[{{circle={{center={center},radius={radius}}}}}]");
    let [here, there] = [obstacle("[0.3,0.7]", "0.1"), obstacle("[0.9,2.1]", "0.3")];
    for solid in [None, Some([here, there])] {
        let last_of = |name: &str, which: usize, units: &[&str]| {
            let set = solid
                .as_ref()
                .map_or("output.frames=false", |solid| &solid[which]);
            let more = [&from_there, &weightless[..], units, &["--force", "--set", set]].concat();
            last(&guided(name, &more))
        };
        let [same, other] = [last_of("same", 0, &[]), last_of("units", 1, &units)];
        assert!((other - same).abs() < 1e-3 * same, "{other} beside {same}");
    }
    // What goes on from it takes its velocities as they are, and steps of another length are not compared.
    let folder = result.with_file_name("on");
    well(
        &[
            &[
                "simulate",
                text(&scene),
                "--from",
                text(&result),
                "--at",
                "5",
                "--quiet",
            ][..],
            &["--steps", "4", "-o", text(&folder)],
            &units,
        ]
        .concat(),
    );
    assert!(report(&folder).get("frames").is_none());
}

/// An array of a result: its shape and its values.
fn array(folder: &Path, name: &str) -> (Vec<usize>, Vec<f64>) {
    let mut all = crate::support::npz::read(&folder.join("result.npz"));
    let found = all.remove(name).unwrap();
    (found.shape, found.data)
}

#[test]
fn smoke_is_carried_again_by_its_flow() {
    let [_, result] = plume("flows_again");
    let again = |name: &str, more: &[&str]| {
        let folder = result.with_file_name(name);
        well(&[&["readvect", text(&result), "--quiet", "-o", text(&folder)], more].concat());
        folder
    };
    let once = again("once", &["--threads", "1"]);
    let said = report(&once);
    assert_eq!((&said["kind"], &said["steps"]), (&"readvect".into(), &12.into()));
    let history = said["history"].as_array().unwrap();
    let apart = |step: &Value| step["relative_l2"].as_f64().unwrap();
    // Another transport than that of the simulation, which begins at rest.
    assert!(history.iter().all(|step| apart(step) < 0.08), "{history:?}");
    assert!(apart(&history[11]) > 1e-4, "{}", history[11]);
    assert_eq!(array(&once, "density").0, [13, 32, 24]);
    // The result is the folder where the program is: what is made of it goes beside it, not into it.
    let here = crate::support::thurible()
        .args(["readvect", ".", "--quiet"])
        .current_dir(&result)
        .output()
        .unwrap();
    assert!(here.status.success(), "{here:?}");
    assert!(
        result
            .with_file_name("plume_readvect")
            .join("result.npz")
            .is_file()
    );
    // Projected once more, which changes rounding errors alone.
    let [(shape, flow), (_, given)] = [&once, &result].map(|folder| array(folder, "velocity_x"));
    assert_eq!((shape, flow.len()), (vec![12, 32, 25], given.len()));
    assert!(flow.iter().zip(&given).all(|(x, y)| (x - y).abs() < 1e-16));
    let mass = |folder: &Path, step: usize, cells: usize| {
        let (_, values) = array(folder, "density");
        values[step * cells..(step + 1) * cells].iter().sum::<f64>()
    };
    let [first, last] = [0, 12].map(|step| mass(&once, step, 24 * 32));
    assert!((last - first).abs() < 1e-4 * first);
    let three = again("three", &["--threads", "3"]);
    assert_eq!(
        array(&once, "density"),
        array(&three, "density"),
        "on three threads"
    );
    // From step 4 on, on cells twice as fine, in memory that steps do not enlarge.
    let finer = again("finer", &["--scale", "2", "--at", "4"]);
    let said = report(&finer);
    assert_eq!((&said["from"], &said["steps"]), (&4.into(), &8.into()));
    assert_eq!(array(&finer, "velocity_y").0, [8, 64, 48]);
    let less = again("less", &["--scale", "2", "--at", "9"]);
    assert_eq!(said["planned_bytes"], report(&less)["planned_bytes"]);
    // The last step alone, and what has no other.
    let last = again("last", &["--at", "11"]);
    assert_eq!(array(&last, "density").0, [2, 32, 24]);
    let out = result.with_file_name("last_finer");
    well(&[
        "upsample",
        text(&last),
        "--factor",
        "2",
        "--quiet",
        "-o",
        text(&out),
    ]);
    assert_eq!(array(&out, "velocity_x").0, [1, 64, 49]);
    // What follows can be taken further too.
    well(&[
        "readvect",
        text(&finer),
        "--quiet",
        "-o",
        text(&result.with_file_name("further")),
    ]);
    well(&[
        "render",
        text(&finer),
        "--quiet",
        "--steps",
        "8",
        "-o",
        text(&result.with_file_name("pictures")),
    ]);
}

#[test]
fn a_flow_goes_round_what_is_solid_and_dyed_parts_change_least() {
    let [scene, result] = plume("flows_round");
    let solid = scene.with_file_name("post.toml");
    let post = "[[obstacle]]\ncircle = { center = [0.4, 0.75], radius = 0.1 }\n[flow]";
    fs::write(&solid, PLUME.replace("[flow]", post)).unwrap();
    let remapped = |name: &str, more: &[&str]| {
        let folder = result.with_file_name(name);
        let common = [
            "remap",
            text(&result),
            "--solid",
            text(&solid),
            "--quiet",
            "-o",
            text(&folder),
        ];
        well(&[&common[..], more].concat());
        folder
    };
    let [weighted, plain] = [remapped("weighted", &[]), remapped("plain", &["--plain"])];
    let dyed = |folder: &Path| {
        let said = report(folder);
        let history = said["history"].as_array().unwrap().clone();
        let changes = history.iter().map(|step| step["changed"][1].as_f64().unwrap());
        changes.sum::<f64>() / history.len() as f64
    };
    assert!(
        dyed(&weighted) < 0.8 * dyed(&plain),
        "{} and {}",
        dyed(&weighted),
        dyed(&plain)
    );
    let (shape, cells) = array(&weighted, "solid");
    assert_eq!(shape, [32, 24]);
    assert!(cells.contains(&1.0));
    let (_, x) = array(&weighted, "velocity_x");
    let (_, y) = array(&weighted, "velocity_y");
    let (_, density) = array(&weighted, "density");
    let fastest = x.iter().chain(&y).fold(0.0_f64, |most, v| most.max(v.abs()));
    for step in 0..12 {
        for cell in 0..24 * 32 {
            let (across, up) = (cell % 24, cell / 24);
            let low = x[(step * 32 + up) * 25 + across];
            let high = x[(step * 32 + up) * 25 + across + 1];
            let below = y[(step * 32 + up) * 24 + across];
            let above = y[(step * 32 + (up + 1) % 32) * 24 + across];
            assert!(
                (high - low + above - below).abs() < 1e-4 * fastest,
                "divergence at {across}, {up}"
            );
            if cells[cell] == 1.0 {
                assert_eq!([low, high, below, above], [0.0; 4], "flow into a solid cell");
                assert_eq!(density[step * 24 * 32 + cell], 0.0);
            }
        }
    }
}

/// The largest difference of what flows into a cell and out of it at any step, in parts of the fastest velocity.
fn divergence(folder: &Path, [nx, ny]: [usize; 2], steps: usize) -> f64 {
    let (_, x) = array(folder, "velocity_x");
    let (_, y) = array(folder, "velocity_y");
    let fastest = x.iter().chain(&y).fold(0.0_f64, |most, v| most.max(v.abs()));
    // Walls along x, a ring along y.
    let mut most = 0.0_f64;
    for (step, up) in (0..steps).flat_map(|step| (0..ny).map(move |up| (step, up))) {
        for across in 0..nx {
            let low = (step * ny + up) * (nx + 1) + across;
            let below = y[(step * ny + up) * nx + across];
            let above = y[(step * ny + (up + 1) % ny) * nx + across];
            most = most.max((x[low + 1] - x[low] + above - below).abs());
        }
    }
    most / fastest
}

#[test]
fn turbulence_is_added_on_finer_cells() {
    let [_, result] = plume("flows_upsampled");
    let upsampled = |name: &str, more: &[&str]| {
        let folder = result.with_file_name(name);
        let common = [
            "upsample",
            text(&result),
            "--factor",
            "2",
            "--quiet",
            "-o",
            text(&folder),
        ];
        well(&[&common[..], more].concat());
        folder
    };
    let one = upsampled("one", &["--threads", "1"]);
    let said = report(&one);
    assert_eq!((&said["kind"], &said["steps"]), (&"upsample".into(), &12.into()));
    assert_eq!((&said["turbulence"], &said["seed"]), (&1.0.into(), &1.into()));
    assert_eq!(array(&one, "density").0, [13, 64, 48]);
    assert_eq!(array(&one, "velocity_x").0, [12, 64, 49]);
    let energies = |said: &Value, which: usize| -> f64 {
        let history = said["history"].as_array().unwrap();
        history
            .iter()
            .map(|step| step["energy"][which].as_f64().unwrap())
            .sum()
    };
    assert!(energies(&said, 0) > 0.0);
    assert!(divergence(&one, [48, 64], 12) < 1e-4);
    let page = fs::read_to_string(one.join("report.html")).unwrap();
    assert!(page.contains("with turbulence"));
    // Any threads, the same; another seed, another noise; none, what readvect writes.
    let bits = |folder: &Path| ["density", "velocity_x", "velocity_y"].map(|name| array(folder, name));
    assert_eq!(bits(&one), bits(&upsampled("three", &["--threads", "3"])));
    assert_ne!(bits(&one), bits(&upsampled("other", &["--seed", "2"])));
    let calm = upsampled("calm", &["--turbulence", "0"]);
    let again = result.with_file_name("again");
    let readvect = [
        "readvect",
        text(&result),
        "--scale",
        "2",
        "--quiet",
        "-o",
        text(&again),
    ];
    well(&readvect);
    assert_eq!(bits(&calm), bits(&again));
    // What is added is as strong as is asked for, and less than the flow.
    let strong = upsampled("strong", &["--turbulence", "4"]);
    let apart = |folder: &Path| {
        let (_, with) = array(folder, "velocity_y");
        let (_, without) = array(&calm, "velocity_y");
        let pairs = with.iter().zip(&without);
        pairs
            .map(|(with, without)| (with - without).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let (_, flow) = array(&calm, "velocity_y");
    let size = flow.iter().map(|v| v * v).sum::<f64>().sqrt();
    let [one, four] = [&one, &strong].map(|folder| apart(folder));
    assert!(
        (four - 4.0 * one).abs() < 1e-3 * four && one > 1e-3 * size && one < 0.2 * size,
        "{one:e}, {four:e} of {size:e}"
    );
    assert!(energies(&report(&strong), 1) > energies(&said, 0));
    let late = upsampled("late", &["--at", "6"]);
    assert_eq!(report(&late)["steps"], 6);
    // It can be taken further, like any other.
    well(&[
        "render",
        text(&late),
        "--quiet",
        "--steps",
        "4",
        "-o",
        text(&result.with_file_name("pictures")),
    ]);
}

#[test]
fn what_emitters_add_goes_to_finer_cells_too() {
    let [scene, result] = plume("flows_emitted");
    let emitter = "[[emitter]]\nrate = 0.2\nto = 8\nbox = { min = [0.3, 0.1], max = [0.5, 0.2] }\n[flow]";
    fs::write(&scene, PLUME.replace("[flow]", emitter)).unwrap();
    well(&[
        "simulate",
        text(&scene),
        "--force",
        "--quiet",
        "-o",
        text(&result),
    ]);
    let again = result.with_file_name("again");
    well(&[
        "readvect",
        text(&result),
        "--scale",
        "2",
        "--quiet",
        "-o",
        text(&again),
    ]);
    let [coarse, fine] = [(&result, 24 * 32), (&again, 48 * 64)].map(|(folder, cells)| {
        let (_, density) = array(folder, "density");
        density
            .chunks(cells)
            .map(|step| step.iter().sum::<f64>())
            .collect::<Vec<_>>()
    });
    assert!(coarse[12] > 1.2 * coarse[0]);
    for (step, (coarse, fine)) in coarse.iter().zip(&fine).enumerate() {
        assert!(
            (fine / 4.0 - coarse).abs() < 0.02 * coarse,
            "step {step}: {fine} beside {coarse}"
        );
    }
}

#[test]
fn a_smooth_change_is_one_with_less_vorticity() {
    let [scene, result] = plume("flows_smooth");
    let solid = scene.with_file_name("post.toml");
    let post = "[[obstacle]]\ncircle = { center = [0.4, 0.75], radius = 0.1 }\n[flow]";
    fs::write(&solid, PLUME.replace("[flow]", post)).unwrap();
    let remapped = |name: &str, more: &[&str]| {
        let folder = result.with_file_name(name);
        let common = [
            "remap",
            text(&result),
            "--solid",
            text(&solid),
            "--quiet",
            "-o",
            text(&folder),
        ];
        well(&[&common[..], more].concat());
        folder
    };
    let rough = remapped("rough", &[]);
    let smooth = remapped("smooth", &["--alpha", "1"]);
    let plain = remapped("plain", &["--alpha", "1", "--plain"]);
    let stiff = report(&remapped("stiff", &["--alpha", "30"]));
    let ended = |step: &Value| step["iterations"] == 100;
    assert!(stiff["history"].as_array().unwrap().iter().any(ended));
    let remarks = stiff["remarks"].to_string();
    assert!(remarks.contains("had not come to rest"), "{remarks}");
    let said = report(&smooth);
    assert!(said.get("remarks").is_none(), "{}", said["remarks"]);
    assert_eq!(said["smoothness"], 1.0);
    let history = said["history"].as_array().unwrap();
    let iterations = |step: &Value| step["iterations"].as_u64().unwrap_or(0);
    assert!(
        history
            .iter()
            .skip(1)
            .all(|step| (1..=100).contains(&iterations(step))),
        "{history:?}"
    );
    let (_, solid) = array(&smooth, "solid");
    let [before, rough, smooth, plain] = [&result, &rough, &smooth, &plain].map(|folder| {
        assert!(folder == &result || divergence(folder, [24, 32], 12) < 1e-3);
        [array(folder, "velocity_x").1, array(folder, "velocity_y").1]
    });
    // The vorticity of the change of the last step where no solid cell is near.
    let vorticity = |after: &[Vec<f64>; 2]| {
        let mut sum = 0.0;
        for (across, up) in (1..24).flat_map(|across| (0..32).map(move |up| (across, up))) {
            let row = |up: usize| 11 * 32 + (up + 32) % 32;
            let cells = [
                (across, up),
                (across - 1, up),
                (across, up + 31),
                (across - 1, up + 31),
            ];
            if cells.into_iter().any(|(x, y)| solid[y % 32 * 24 + x] == 1.0) {
                continue;
            }
            let x = |up: usize| {
                let face = row(up) * 25 + across;
                after[0][face] - before[0][face]
            };
            let y = |across: usize| {
                let face = row(up) * 24 + across;
                after[1][face] - before[1][face]
            };
            sum += (y(across) - y(across - 1) - x(up) + x(up + 31)).powi(2);
        }
        sum
    };
    let [rough, smooth, plain] = [&rough, &smooth, &plain].map(vorticity);
    assert!(
        smooth < 0.5 * rough && plain < smooth,
        "{rough:e}, {smooth:e}, {plain:e}"
    );
}

#[test]
fn what_cannot_be_taken_further_is_refused() {
    let [scene, result] = plume("flows_no_further");
    let result = text(&result);
    let folder = fresh_folder("flows_no_further_out");
    let empty = folder.join("empty.npy");
    fs::write(&empty, crate::support::npz::npy(&[32, 24], &[0.0; 24 * 32])).unwrap();
    let full = folder.join("full.npy");
    fs::write(&full, crate::support::npz::npy(&[32, 24], &[1.0; 24 * 32])).unwrap();
    let out = folder.join("out");
    for (arguments, code, parts) in [
        (
            &["readvect", "no_such_folder"][..],
            4,
            &["report.json", "name a result folder"][..],
        ),
        (
            &["readvect", result, "--at", "12"],
            2,
            &["no flow of step 12", "0 to 11"],
        ),
        (
            &["readvect", result, "--scale", "3"],
            2,
            &["--scale", "1, 2, 4 and 8"],
        ),
        (
            &["readvect", result, "--memory-limit", "10KiB"],
            3,
            &["24 x 32 cells takes", "--memory-limit"],
        ),
        (
            &["upsample", "no_such_folder"],
            4,
            &["report.json", "name a result folder"],
        ),
        (
            &["upsample", result, "--at", "12"],
            2,
            &["no flow of step 12", "0 to 11"],
        ),
        (
            &["upsample", result, "--factor", "3"],
            2,
            &["--factor", "2, 4 and 8"],
        ),
        (
            &["upsample", result, "--turbulence", "-1"],
            2,
            &["--turbulence", "from 0"],
        ),
        (
            &["upsample", result, "--turbulence", "nan"],
            2,
            &["--turbulence", "from 0"],
        ),
        (&["upsample", result, "--seed", "x"], 2, &["--seed"]),
        (
            &["upsample", result, "--memory-limit", "10KiB"],
            3,
            &["upsample", "96 x 128", "--memory-limit"],
        ),
        (
            &["remap", result, "--solid", text(&scene), "--alpha=-1"],
            2,
            &["--alpha", "from 0"],
        ),
        (&["remap", result], 2, &["--solid"]),
        (
            &["remap", result, "--solid", "none.png"],
            4,
            &["--solid none.png", "cannot be read"],
        ),
        (
            &["remap", result, "--solid", text(&scene)],
            2,
            &["--solid", "no [[obstacle]]"],
        ),
        (
            &["remap", result, "--solid", text(&empty)],
            2,
            &["--solid", "empty"],
        ),
        (
            &["remap", result, "--solid", text(&full)],
            2,
            &["--solid", "leaves no cell"],
        ),
    ] {
        let ended = run(&[arguments, &["-o", text(&out)]].concat());
        assert_eq!(ended.code, code, "{arguments:?}: {}", ended.err);
        for part in parts {
            assert!(
                ended.err.contains(part),
                "{arguments:?}: no {part:?} in {}",
                ended.err
            );
        }
        assert!(!out.exists() && !ended.err.contains("panicked"), "{}", ended.err);
    }
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let [scene, result] = plume("flows_refused");
    let (scene, result) = (text(&scene), text(&result));
    let folder = fresh_folder("flows_refused_out");
    let out = ["-o", text(&folder)];
    for (arguments, code, parts) in [
        (
            &["simulate", scene, "--from", result, "--at", "12"][..],
            2,
            &["--from", "no flow of step 12", "0 to 11"][..],
        ),
        (
            &[
                "simulate",
                scene,
                "--from",
                result,
                "--set",
                "grid.boundary=\"open\"",
            ][..],
            2,
            &["--from", "has the boundary", "`grid.boundary`"][..],
        ),
        (&["simulate", scene, "--at", "3"], 2, &["--from"]),
        (
            &["guide", scene, "--reference", result, "--at", "2"],
            2,
            &["--reference", "the flow of 12 steps", "14 are needed", "--steps"],
        ),
        (
            &[
                "guide",
                scene,
                "--reference",
                result,
                "--set",
                "grid.boundary=[\"wall\", \"wall\"]",
            ],
            2,
            &["--reference", "has the boundary", "`grid.boundary`"],
        ),
        (
            &[
                "guide",
                scene,
                "--reference",
                result,
                "--from-reference",
                "--set",
                "grid.cells=[24, 30]",
            ],
            2,
            &["--reference", "density", "same cells"],
        ),
        (
            &["guide", scene, "--reference", "no_such_folder"],
            4,
            &["--reference no_such_folder", "result.npz"],
        ),
        (
            &[
                "guide",
                scene,
                "--reference",
                result,
                "--set",
                "grid.boundary=[\"open\", \"wall\"]",
            ],
            2,
            &["grid.boundary", "guide"],
        ),
        (
            &[
                "guide",
                scene,
                "--reference",
                result,
                "--set",
                "method.guide.smoothness=0",
            ],
            2,
            &["method.guide.smoothness", "above 0"],
        ),
        (
            &["solve", scene, "--method", "guide"],
            2,
            &["--method guide", "direct"],
        ),
    ] {
        let ended = run(&[arguments, &out[..]].concat());
        assert_eq!(ended.code, code, "{arguments:?}: {}", ended.err);
        for part in parts {
            assert!(
                ended.err.contains(part),
                "{arguments:?}: no {part:?} in {}",
                ended.err
            );
        }
        assert!(!ended.err.contains("panicked"), "{}", ended.err);
    }
}

#[test]
fn an_entry_of_an_array_over_time_is_a_shape() {
    let [scene, result] = plume("flows_entry");
    let with = |entry: &str| {
        let source = format!("file = \"plume/result.npz\"\nname = \"density\"\nentry = {entry}");
        let circle = "circle = { center = [0.4, 0.35], radius = 0.15 }";
        fs::write(&scene, PLUME.replace(circle, &source)).unwrap();
        let on = result.with_file_name("entry");
        let ended = run(&["simulate", text(&scene), "--force", "--quiet", "-o", text(&on)]);
        (ended, on)
    };
    let (_, all) = array(&result, "density");
    let cells = 24 * 32;
    for (entry, step) in [("\"last\"", 12), ("5", 5)] {
        let (ended, on) = with(entry);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let (_, density) = array(&on, "density");
        let apart = density.iter().zip(&all[step * cells..]).take(cells);
        assert!(
            apart.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) < 1e-12,
            "{entry}"
        );
    }
    for (entry, parts) in [
        ("13", ["`entry` is 13", "0 to 12"]),
        ("\"first\"", ["`entry` is \"first\"", "\"last\""]),
        ("-1", ["entry", "whole number from 0"]),
    ] {
        let (ended, _) = with(entry);
        assert_eq!(ended.code, 2, "{entry}: {}", ended.err);
        for part in parts {
            assert!(ended.err.contains(part), "{entry}: no {part:?} in {}", ended.err);
        }
    }
}

/// Ctrl-C leaves the steps that are done, whatever is made of a flow.
#[test]
#[cfg(unix)]
fn an_interrupt_leaves_the_steps_that_are_done() {
    use crate::support::endless::Endless;
    let folder = fresh_folder("flows_interrupted");
    let (scene, result) = (folder.join("scene.toml"), folder.join("plume"));
    fs::write(&scene, PLUME.replace("[24, 32]", "[48, 64]")).unwrap();
    well(&["simulate", text(&scene), "--quiet", "-o", text(&result)]);
    for (deed, finer) in [("upsample", "--factor"), ("readvect", "--scale")] {
        let out = folder.join(deed);
        let mut command = crate::support::thurible();
        command.args([deed, text(&result), "-o", text(&out), "--json", "--threads", "1"]);
        command.args([finer, "8"]);
        let ended = Endless::seen(&mut command, |line| line.contains("\"plan\"")).stop();
        assert_eq!(ended.code, 130, "{deed}: {}", ended.err);
        let said = report(&out);
        assert_eq!(said["status"], "cancelled", "{deed}");
        let steps = said["steps"].as_u64().unwrap() as usize;
        assert!(steps < 12, "{deed}: {steps}");
        let (shape, values) = array(&out, "velocity_x");
        assert_eq!(shape[0], steps, "{deed}");
        assert!(values.iter().all(|value| value.is_finite()), "{deed}");
    }
}

/// The flow of Stable Fluids is that of cells. Between rings its arrays have the shape of those of faces, and nobody takes them for these.
#[test]
fn a_flow_of_cells_is_not_taken_for_one_of_faces() {
    let folder = fresh_folder("flows_of_cells");
    let scene = folder.join("scene.toml");
    let rings = PLUME.replace(r#"["wall", "periodic"]"#, r#""periodic""#);
    fs::write(&scene, rings.replace("cells = [24, 32]", "cells = [24, 24]")).unwrap();
    let steered = folder.join("steered.toml");
    let keyframe = "[[keyframe]]\nstep = 12\ncircle = { center = [0.5, 0.6], radius = 0.15 }\n";
    fs::write(&steered, fs::read_to_string(&scene).unwrap() + keyframe).unwrap();
    let (scene, result, out) = (text(&scene), folder.join("fluids"), folder.join("out"));
    let result = text(&result);
    let solve = [
        "solve",
        text(&steered),
        "--method",
        "stable_fluids",
        "--quiet",
        "-o",
        result,
    ];
    let ended = run(&[&solve[..], &["--set", "method.iterations=2"]].concat());
    assert!(matches!(ended.code, 0 | 5), "{}", ended.err);
    for arguments in [
        &["readvect", result][..],
        &["upsample", result],
        &["simulate", scene, "--from", result],
        &["guide", scene, "--reference", result, "--steps", "6"],
    ] {
        let ended = run(&[arguments, &["-o", text(&out)]].concat());
        assert_eq!(ended.code, 2, "{arguments:?}: {}", ended.err);
        assert!(
            ended
                .err
                .contains("of cells, not of faces; give a result of another method"),
            "{}",
            ended.err
        );
        assert!(!out.exists());
    }
    // Its densities are tracked, and nothing is compared with its flow.
    well(&[
        "track",
        result,
        "--quiet",
        "--set",
        "capture.first=1",
        "-o",
        text(&out),
    ]);
    let said = report(&out);
    assert!(
        said["remarks"].to_string().contains("that of cells"),
        "{}",
        said["remarks"]
    );
    assert!(
        crate::support::npz::read(&out.join("result.npz"))
            .keys()
            .all(|name| !name.contains("truth"))
    );
}

/// What takes a flow further takes no more than its ceiling.
#[test]
fn the_least_ceiling_is_kept() {
    let [_, result] = plume("flows_ceiling");
    let (folder, result) = (fresh_folder("flows_ceiling_out"), text(&result));
    for deed in ["readvect", "upsample"] {
        let out = folder.join(deed);
        let deed = [deed, result, "--threads", "1", "--quiet", "-o", text(&out)];
        let refused = run(&[&deed[..], &["--memory-limit", "1000"]].concat());
        assert_eq!(refused.code, 3, "{}", refused.err);
        let needed = bytes_after(&refused.err, "takes ");
        let one_short = run(&[&deed[..], &["--memory-limit", &(needed - 1).to_string()]].concat());
        assert_eq!(one_short.code, 3, "{}", one_short.err);
        well(&[&deed[..], &["--memory-limit", &needed.to_string()]].concat());
        let used = report(&out)["used_bytes"].as_u64().unwrap();
        assert!(used as usize <= needed, "{used} of {needed}");
    }
}

/// A simulation that was stopped is taken further as far as it went.
#[test]
#[cfg(unix)]
fn a_flow_that_was_stopped_goes_as_far_as_it_came() {
    use crate::support::endless::Endless;
    let folder = fresh_folder("flows_stopped");
    let (scene, result, out) = (
        folder.join("scene.toml"),
        folder.join("plume"),
        folder.join("out"),
    );
    fs::write(&scene, PLUME.replace("steps = 12", "steps = 4000")).unwrap();
    let mut command = crate::support::thurible();
    command.args([
        "simulate",
        text(&scene),
        "-o",
        text(&result),
        "--json",
        "--threads",
        "1",
    ]);
    let endless = Endless::seen(&mut command, |line| line.contains("\"plan\""));
    std::thread::sleep(core::time::Duration::from_millis(300));
    let ended = endless.stop();
    assert_eq!(ended.code, 130, "{}", ended.err);
    let steps = report(&result)["simulated_steps"].as_u64().unwrap() as usize;
    assert!((1..4000).contains(&steps), "{steps}");
    well(&["readvect", text(&result), "--quiet", "-o", text(&out)]);
    assert_eq!(array(&out, "density").0[0], steps + 1);
    // Projected once more, which changes rounding errors alone.
    let [(shape, flow), (_, given)] = [&out, &result].map(|folder| array(folder, "velocity_x"));
    assert_eq!(shape[0], steps);
    let far = flow.iter().zip(&given).map(|(one, other)| (one - other).abs());
    assert!(far.fold(0.0, f64::max) < 1e-6);
    let beyond = run(&[
        "guide",
        text(&scene),
        "--reference",
        text(&result),
        "-o",
        text(&folder.join("guided")),
    ]);
    assert_eq!(beyond.code, 2, "{}", beyond.err);
    assert!(
        beyond.err.contains(&format!("has the flow of {steps} step")),
        "{}",
        beyond.err
    );
}
