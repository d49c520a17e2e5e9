//! `thurible render` in planes: arrows and streaklines over the smoke.

use crate::render::{DEEP, png, solved};
use crate::support::{Ended, fresh_folder, run, text};
use std::fs;
use std::path::{Path, PathBuf};

/// Smoke that goes round a disc, from a source and from an emitter; the box repeats along x.
pub const FLOW: &str = "[grid]\ncells = [24, 16]\nboundary = [\"periodic\", \"wall\"]\nlength = 3.0\n[time]\nsteps = 6\ndt = 0.5\n[source]\ncircle = { center = [0.8, 0.9], radius = 0.45 }\n[[emitter]]\nfrom = 1\nto = 4\nrate = 0.2\ncircle = { center = [1.5, 0.9], radius = 0.3 }\n[[obstacle]]\ncircle = { center = [2.2, 1.0], radius = 0.4 }\n[[keyframe]]\nstep = 6\ncircle = { center = [1.2, 1.0], radius = 0.5 }\n[control]\nforce_weight = 1\n[method]\niterations = 10\n[output]\nframes = false\n";

pub fn rendered(result: &Path, name: &str, more: &[&str]) -> (Ended, PathBuf) {
    let out = result.with_file_name(name);
    let arguments = [&["render", text(result), "-o", text(&out)], more].concat();
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}", ended.err);
    (ended, out)
}

#[test]
fn arrows_and_streaklines_are_drawn_over_the_smoke() {
    let result = solved("lines_flat", FLOW);
    let size = ["--size", "480x320"];
    let (_, plain) = rendered(&result, "plain", &size);
    let read = |folder: &Path, step: usize| png(&folder.join(format!("frame_{step:04}.png"))).2;
    for (name, options, step) in [
        ("force", &["--arrows", "force"][..], 3),
        ("velocity", &["--arrows", "velocity"], 3),
        ("streaks", &["--streaklines"], 5),
    ] {
        let (_, over) = rendered(&result, name, &[&size[..], options].concat());
        let (_, alone) = rendered(
            &result,
            &format!("{name}_3"),
            &[&size[..], options, &["--steps", &step.to_string()]].concat(),
        );
        assert_eq!(
            read(&over, step),
            read(&alone, step),
            "{name}: whatever else is drawn"
        );
        let changed = |step: usize| {
            let (over, plain) = (read(&over, step), read(&plain, step));
            over.chunks(3)
                .zip(plain.chunks(3))
                .filter(|(over, plain)| over != plain)
                .count()
        };
        let share = changed(step) as f64 / (480.0 * 320.0);
        assert!((0.002..0.4).contains(&share), "{name}: {share} of the picture");
        // No flow has led to the first step, and no force acts from the last ones.
        let none = if name == "streaks" { 0 } else { 6 };
        assert_eq!(changed(none), 0, "{name}");
    }
}

#[test]
fn lines_are_for_planes() {
    let result = solved("lines_deep", DEEP);
    let free = fresh_folder("lines_free");
    let (scene, simulated) = (free.join("scene.toml"), free.join("out"));
    fs::write(
        &scene,
        FLOW.replace("[control]", "[flow]\nbuoyancy = 0.05\n[control]"),
    )
    .unwrap();
    let ended = run(&["simulate", text(&scene), "--quiet", "-o", text(&simulated)]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let ended = run(&["render", text(&simulated), "--arrows", "force"]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(ended.err.contains("nothing steers the flow"), "{}", ended.err);
    for option in [&["--arrows", "force"][..], &["--streaklines"]] {
        let ended = run(&[&["render", text(&result)], option].concat());
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(
            ended.err.contains("a result in 3D is drawn without lines"),
            "{}",
            ended.err
        );
    }
}
