//! Densities that transport has undershot are inputs; what is plainly no density is refused.

use crate::small::{CIRCLE, SIDE, density, refused, scene};
use crate::support::npz::{self, npy};
use crate::support::{fresh_folder, run};
use std::fs;

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
    assert!(!run(&["solve", &scene, "--force"]).err.contains("below 0"));
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
