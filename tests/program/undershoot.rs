//! Densities that transport has undershot are inputs; what is plainly no density is refused.

use crate::support::npz::{self, npy};
use crate::support::{Ended, fresh_folder, run};
use std::fs;
use std::path::Path;

const SIDE: usize = 8;

fn density() -> Vec<f64> {
    let cell = |index: usize| ((index % SIDE) as f64 - 3.5).hypot((index / SIDE) as f64 - 3.5);
    (0..SIDE * SIDE)
        .map(|index| (3.0 - cell(index)).clamp(0.0, 1.0))
        .collect()
}

fn scene(folder: &Path, source: &str, target: &str) -> String {
    let path = folder.join("scene.toml");
    let text = format!(
        "[grid]\ncells = [8, 8]\n[time]\nsteps = 2\n[source]\n{source}\n[[keyframe]]\nstep = 2\n{target}\n[method]\niterations = 1\n[output]\nframes = false\n"
    );
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

const CIRCLE: &str = "circle = { center = [0.5, 0.5], radius = 0.3 }";

fn refused(ended: &Ended, words: &[&str]) {
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(words.iter().all(|word| ended.err.contains(word)), "{}", ended.err);
}

#[test]
fn what_a_scheme_undershoots_becomes_zero() {
    let folder = fresh_folder("undershoot");
    let mut values = density();
    values[2] = -0.006;
    values[5] = -0.001;
    fs::write(folder.join("a.npy"), npy(&[SIDE, SIDE], &values)).unwrap();
    let scene = scene(&folder, "file = \"a.npy\"", CIRCLE);
    let ended = run(&["solve", &scene, "--precision", "f64"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let words = "holds 2 values below 0, the least -6.000e-3; they become 0";
    assert!(
        ended.err.contains("in source: ") && ended.err.contains(words),
        "{}",
        ended.err
    );
    let solved = npz::read(&folder.join("out/result.npz"));
    for (found, given) in solved["density"].data.iter().zip(&values) {
        assert_eq!(*found, given.max(0.0));
    }
    // A result, whatever it has undershot, is a source and goes on.
    let out = folder.join("out");
    let ended = run(&[
        "simulate",
        &scene,
        "--from",
        out.to_str().unwrap(),
        "-o",
        folder.join("on").to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    // Nothing to say of a density that is one.
    fs::write(folder.join("a.npy"), npy(&[SIDE, SIDE], &density())).unwrap();
    assert!(!run(&["solve", &scene]).err.contains("below 0"));
}

#[test]
fn what_is_no_density_is_refused() {
    let folder = fresh_folder("no_density");
    let scene = scene(&folder, "file = \"a.npy\"", CIRCLE);
    let below: Vec<f64> = density().iter().map(|value| value - 0.5).collect();
    let mut hole = density();
    hole[SIDE + 3] = -9999.0;
    for (values, place) in [(below, "holds -0.5 at [0, 0]"), (hole, "holds -9999 at [1, 3]")] {
        fs::write(folder.join("a.npy"), npy(&[SIDE, SIDE], &values)).unwrap();
        refused(&run(&["solve", &scene]), &[place, "numpy.maximum(a, 0)"]);
    }
}
