//! What is made of a flow that is known: simulated on from any step, and guiding another simulation.

use crate::support::{Ended, fresh_folder, run};
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

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

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
    // From step 5 of the reference on, with its smoke.
    let late = guided("late", &["--at", "5", "--from-reference", "--steps", "6"]);
    assert_eq!(frames(&late)[0].1, 6);
    assert!(last(&late) < 0.01, "{}", last(&late));
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
                "grid.cells=[24, 30]",
            ],
            2,
            &["--reference", "velocity_x", "same cells"],
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
