//! Damaged archives are refused, whatever reads them.

use crate::small::{CIRCLE, SIDE, density, refused, scene};
use crate::support::npz::{self, npy};
use crate::support::{fresh_folder, run};
use std::fs;
use std::path::Path;

/// An archive, in which the last bit of the array `damaged` is another than its checksum is of.
fn write(path: &Path, arrays: &[(&str, Vec<u8>)], damaged: &str) {
    npz::write(path, arrays);
    let mut bytes = fs::read(path).unwrap();
    for (_, array) in arrays.iter().filter(|(name, _)| *name == damaged) {
        let start = bytes.windows(array.len()).position(|part| part == array).unwrap();
        bytes[start + array.len() - 1] ^= 1;
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn shapes_and_velocities_from_damaged_archives_are_refused() {
    let folder = fresh_folder("damaged_shapes");
    let file = "file = \"a.npz\"\nname = \"density\"";
    let arrays = [
        ("density", npy(&[SIDE, SIDE], &density())),
        ("velocity_x", npy(&[SIDE, SIDE + 1], &[0.0; SIDE * (SIDE + 1)])),
        ("velocity_y", npy(&[SIDE + 1, SIDE], &[0.0; SIDE * (SIDE + 1)])),
    ];
    let velocity = "control.initial_velocity={file=\"a.npz\"}";
    for (damaged, source, target) in [
        ("density", file, CIRCLE),
        ("density", CIRCLE, file),
        ("velocity_y", CIRCLE, CIRCLE),
    ] {
        let scene = scene(&folder, source, target);
        let command = ["solve", scene.as_str(), "--quiet", "--force", "--set", velocity];
        write(&folder.join("a.npz"), &arrays, "");
        assert_eq!(run(&command).code, 0);
        write(&folder.join("a.npz"), &arrays, damaged);
        refused(
            &run(&command),
            &[&format!("`{damaged}` that is damaged"), "save it again"],
        );
    }
    // The archive is what is damaged, and not the arrays that are asked for.
    write(&folder.join("a.npz"), &arrays, "density");
    let scene = scene(&folder, CIRCLE, CIRCLE);
    assert_eq!(
        run(&["solve", &scene, "--quiet", "--force", "--set", velocity]).code,
        0
    );
}

#[test]
fn a_damaged_result_is_not_gone_on_from() {
    let folder = fresh_folder("damaged_result");
    let scene = scene(&folder, CIRCLE, CIRCLE);
    let result = folder.join("result.npz");
    let two = |shape: &[usize], field: &[f64]| npy(&[&[2], shape].concat(), &[field, field].concat());
    let arrays = [
        ("density", two(&[SIDE, SIDE], &density())),
        ("velocity_x", two(&[SIDE, SIDE + 1], &[0.0; SIDE * (SIDE + 1)])),
        ("velocity_y", two(&[SIDE + 1, SIDE], &[0.0; SIDE * (SIDE + 1)])),
    ];
    let out = folder.join("on");
    let command = [
        "simulate",
        &scene,
        "--quiet",
        "--force",
        "--from",
        folder.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
    ];
    write(&result, &arrays, "");
    assert_eq!(run(&command).code, 0);
    for (damaged, _) in &arrays {
        write(&result, &arrays, damaged);
        refused(
            &run(&command),
            &["--from", &format!("`{damaged}` that is damaged")],
        );
    }
    // Damage in a step that is only passed over counts too.
    write(&result, &arrays, "");
    let mut bytes = fs::read(&result).unwrap();
    let start = bytes.windows(6).position(|part| part == b"\x93NUMPY").unwrap();
    bytes[start + 200] ^= 1;
    fs::write(&result, bytes).unwrap();
    refused(&run(&command), &["`density` that is damaged"]);
}
