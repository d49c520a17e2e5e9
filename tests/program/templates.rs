//! Scenes whose force is made of templates, and emitters whose smoke has a velocity: solved by the program, and checked.

use crate::support::verify::{Outcome, verify};
use crate::support::{Ended, fresh_folder, run};
use std::fs;
use std::path::PathBuf;

/// A jet, carried by a wind, a vortex that moves, noise and a pull, and released.
const SCENE: &str = "\
[grid]
cells = [24, 20]
length = 2.0
[time]
steps = 14
dt = 0.5
[source]
circle = { center = [0.6, 0.5], radius = 0.2 }
[[emitter]]
to = 5
rate = 0.1
velocity = [0.1, 0.2]
box = { min = [0.3, 0.1], max = [0.7, 0.4] }
[[keyframe]]
step = 10
circle = { center = [1.2, 1.0], radius = 0.3 }
[[release]]
from = 11
[flow]
buoyancy = 5e-3
viscosity = 1e-4
[control]
force_weight = 1.0
[method]
iterations = 5
[output]
frames = false
[[template]]
kind = \"wind\"
center = [0.6, 0.6]
radius = 0.4
interval = 4
[[template]]
kind = \"vortex\"
center = [1.0, 0.8]
radius = 0.3
from = 2
to = 8
move = true
amplitude = 1e-3
[[template]]
kind = \"noise\"
center = [0.8, 0.8]
radius = 0.5
size = 0.4
seed = 7
[[template]]
kind = \"attract\"
center = [1.2, 1.0]
radius = 0.4
";

fn ran(test: &str, scene: &str, command: &str, more: &[&str]) -> (PathBuf, Ended) {
    let folder = fresh_folder(test);
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&path, scene).unwrap();
    let arguments = [command, path.to_str().unwrap(), "-o", out.to_str().unwrap()];
    let ended = run(&[&arguments[..], more].concat());
    assert!(
        ended.code == 0 || ended.code == 5,
        "{test}: {}, {}",
        ended.code,
        ended.err
    );
    (out, ended)
}

fn checked(test: &str, scene: &str, command: &str, more: &[&str]) -> Outcome {
    let (out, _) = ran(test, scene, command, &[more, &["--quiet"]].concat());
    verify(test, &out)
}

#[test]
fn templates_are_found_and_told() {
    for precision in ["f32", "f64"] {
        let test = format!("templates_{precision}");
        let (out, ended) = ran(&test, SCENE, "solve", &["--precision", precision]);
        let outcome = verify(&test, &out);
        let report = &outcome.report;
        assert_eq!(report["method"], "templates");
        let found = report["templates"].as_array().unwrap();
        let kinds: Vec<&str> = found.iter().map(|one| one["kind"].as_str().unwrap()).collect();
        assert_eq!(kinds, ["wind", "vortex", "noise", "attract"]);
        // Ten forces up to the release: three intervals of the wind, of which the last has two steps.
        let amplitudes = |index: usize| found[index]["amplitude"].as_array().unwrap();
        let shape = |index: usize| {
            (
                amplitudes(index).len(),
                amplitudes(index)[0].as_array().unwrap().len(),
            )
        };
        assert_eq!([0, 1, 2, 3].map(shape), [(3, 2), (1, 1), (1, 1), (1, 1)]);
        assert_eq!((&found[1]["to"], &found[0]["to"]), (&8.into(), &10.into()));
        assert_eq!((&found[0]["radius"], &found[2]["seed"]), (&0.4.into(), &7.into()));
        assert!(found[1]["radius"] != 0.3 && found[1]["move"] == true && found[1].get("seed").is_none());
        for line in [
            "template[0] wind: center 0.6, 0.6, radius 0.4, amplitude ",
            " in steps 8 to 9",
            "template[3] attract: center 1.2, 1",
        ] {
            assert!(ended.out.contains(line), "{line} is not in {}", ended.out);
        }
        let page = fs::read_to_string(out.join("report.html")).unwrap();
        assert!(page.contains("<h2>Templates</h2>") && page.contains("template[1] vortex"));
        assert!(
            report["objective"]["data"].as_f64().unwrap() < report["history"][0]["data"].as_f64().unwrap()
        );
    }
}

/// A simulation takes what the file says, and a scene without templates says nothing of them.
#[test]
fn a_simulation_is_pushed_by_templates() {
    let scene = SCENE.replace("interval = 4\n", "interval = 4\namplitude = [0.05, 0.0]\n");
    let outcome = checked("templates_simulate", &scene, "simulate", &[]);
    let pushed = outcome.force[3][0].max_abs();
    assert!((0.01..0.06).contains(&pushed), "{pushed}");
    assert_eq!(outcome.report["templates"][0]["amplitude"][0][0], 0.05);
    let (plain, _) = SCENE.split_once("[[template]]").unwrap();
    let (out, ended) = ran("no_fans", plain, "solve", &[]);
    let outcome = verify("no_fans", &out);
    assert!(outcome.report.get("templates").is_none() && !ended.out.contains("template["));
    assert_eq!(outcome.report["method"], "direct");
}

/// The flow in an emitter has the velocity of its smoke, and what takes it there is beside the force.
#[test]
fn emitters_push_by_every_method() {
    let (plain, _) = SCENE.split_once("[[template]]").unwrap();
    for method in ["direct", "lbfgs", "pd"] {
        let outcome = checked(&format!("jets_{method}"), plain, "solve", &["--method", method]);
        assert_eq!(outcome.jets.len(), outcome.force.len());
        let strength = |step: usize| outcome.jets[step][1].max_abs();
        assert!(
            strength(0) > 0.1 && strength(4) > 0.0,
            "{method}: {}",
            strength(0)
        );
        assert!(
            (5..13).all(|step| strength(step) == 0.0),
            "{method}: it pushes after its end"
        );
    }
    let outcome = checked("jets_simulate", plain, "simulate", &["--precision", "f64"]);
    // In the middle of the box, in cells of 1/12: pressure takes away what cannot leave.
    let upwards = outcome.velocity[4][1].at([6, 3, 0]);
    assert!((0.05..0.25).contains(&upwards), "{upwards}");
}
