//! Results as files of other programs. That those programs read them is shown by `.ci/run dcc`; here their bytes are compared with
//! what was read there, and what may go wrong is tried.

use crate::support::{fresh_folder, npz, run, text};
use clap::Parser;
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use thurible::cli::{Cli, Command};
use thurible::commands::export::run as run_export;
use zip::write::SimpleFileOptions;

#[path = "../numerics/fields/channels.rs"]
#[expect(dead_code, reason = "the numerics' tests take all of it")]
mod channels;

/// Exports what must end well.
fn exported(result: &Path, name: &str, more: &[&str]) -> PathBuf {
    let folder = result.with_file_name(name);
    let common = ["export", text(result), "--quiet", "-o", text(&folder)];
    let ended = run(&[&common[..], more].concat());
    assert_eq!(ended.code, 0, "{more:?}: {}", ended.err);
    folder
}

/// A small result of plain numbers: densities of three steps, the flow of two, with walls at the ends of x and z and a ring along y.
fn result(test: &str, axes: usize) -> PathBuf {
    let folder = fresh_folder(test).join("result");
    fs::create_dir_all(&folder).unwrap();
    let cells = &[5, 4, 3][..axes];
    let ends = &["wall", "periodic", "wall"][..axes];
    let report = json!({
        "format": 1, "cells": cells, "boundary": ends, "length": 2.5, "dt": 0.125, "steps": 2, "precision": "f64", "keyframes": [],
    });
    fs::write(folder.join("report.json"), report.to_string()).unwrap();
    let file = fs::File::create(folder.join("result.npz")).unwrap();
    let mut archive = zip::ZipWriter::new(file);
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let mut put = |name: &str, shape: &[usize], value: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..shape.iter().product()).map(value).collect();
        archive.start_file(format!("{name}.npy"), stored).unwrap();
        archive.write_all(&npz::npy(shape, &values)).unwrap();
    };
    let shape = |steps: usize, own: Option<usize>| {
        let mut counts = cells.to_vec();
        if let Some(own) = own.filter(|&own| ends[own] == "wall") {
            counts[own] += 1;
        }
        counts.push(steps);
        counts.reverse();
        counts
    };
    // Every third cell is empty, and the first step begins with eight empty ones.
    put("density", &shape(3, None), &|k| {
        if k < 8 || k % 3 == 0 { 0.0 } else { k as f64 / 64.0 }
    });
    for (axis, name) in ["velocity_x", "velocity_y", "velocity_z"]
        .into_iter()
        .enumerate()
        .take(axes)
    {
        put(name, &shape(2, Some(axis)), &|k| {
            (k * (axis + 1)) as f64 / 32.0 - 1.0
        });
    }
    put("keyframe_step", &[1], &|_| 2.0);
    archive.finish().unwrap();
    folder
}

/// Adds an array to a result.
fn add(result: &Path, name: &str, shape: &[usize]) {
    let file = fs::File::options()
        .read(true)
        .write(true)
        .open(result.join("result.npz"));
    let mut archive = zip::ZipWriter::new_append(file.unwrap()).unwrap();
    let values: Vec<f64> = (0..shape.iter().product()).map(|k| k as f64 + 0.5).collect();
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    archive.start_file(format!("{name}.npy"), stored).unwrap();
    archive.write_all(&npz::npy(shape, &values)).unwrap();
    archive.finish().unwrap();
}

/// What an array of an exported group says of itself.
fn said_of(folder: &Path, array: &str) -> Value {
    let path = folder.join("smoke.zarr").join(array).join("zarr.json");
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// A line for each file below a folder: its name, its bytes and a checksum of them.
fn sums(folder: &Path) -> String {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path)
            } else {
                files.push(path)
            }
        }
    }
    files.sort();
    let line = |path: &PathBuf| {
        let bytes = fs::read(path).unwrap();
        // FNV-1a.
        let sum = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |sum, &byte| {
            (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let name = path
            .strip_prefix(folder)
            .unwrap()
            .to_string_lossy()
            .replace('\\', "/");
        format!("{sum:016x} {:>6} {name}\n", bytes.len())
    };
    let shown = |path: &&PathBuf| !path.ends_with("manifest.json") && !path.ends_with("export.json");
    files.iter().filter(shown).map(line).collect()
}

/// Compares with what was read by other programs; `GOLDEN=write` replaces it, after which `.ci/run dcc` must hold.
fn golden(name: &str, found: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/program/golden")
        .join(name);
    if std::env::var("GOLDEN").is_ok_and(|word| word == "write") {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, found).unwrap();
    }
    let expected = fs::read_to_string(&path).unwrap();
    assert_eq!(found, expected, "{name}");
}

const ALL: &str = "usd,vti,zarr,fga,npz";

#[test]
fn every_format_has_the_bytes_that_other_programs_read() {
    for axes in [2, 3] {
        let result = result(&format!("export_bytes_{axes}"), axes);
        for (name, more) in [
            ("half_blosc", "--up z"),
            (
                "float_zip",
                "--precision float --compression zip --up y --staggered",
            ),
            ("half_none", "--compression none --up y --fps 24 --steps 1..2"),
        ] {
            let more: Vec<&str> = ["--format", ALL].into_iter().chain(more.split(' ')).collect();
            let folder = exported(&result, name, &more);
            golden(&format!("export_{axes}_{name}.txt"), &sums(&folder));
            if name == "half_blosc" {
                for file in [
                    "smoke.usda",
                    "smoke.pvd",
                    "fga/smoke.0002.fga",
                    "smoke.zarr/velocity_x/zarr.json",
                ] {
                    let text = fs::read_to_string(folder.join(file)).unwrap();
                    golden(&format!("export_{axes}_{}", file.replace('/', "_")), &text);
                }
            }
        }
    }
}

#[test]
fn numpy_gets_the_arrays_as_they_are() {
    let result = result("export_npz", 3);
    let folder = exported(&result, "all", &["--format", "npz"]);
    assert_eq!(
        npz::read(&folder.join("smoke.npz")),
        npz::read(&result.join("result.npz"))
    );
    let part =
        npz::read(&exported(&result, "part", &["--format", "npz", "--steps", "1..1"]).join("smoke.npz"));
    let whole = npz::read(&result.join("result.npz"));
    assert_eq!(part["density"].shape, [1, 3, 4, 5]);
    assert_eq!(part["density"].data, whole["density"].data[60..120]);
    assert_eq!(part["velocity_x"].data, whole["velocity_x"].data[72..]);
}

#[test]
fn an_axis_is_of_faces_where_its_end_says_so() {
    let result = result("export_faces", 3);
    // Walls at the ends of x, a ring along y.
    add(&result, "count_x", &[3, 3, 4, 5]);
    add(&result, "flux_x", &[3, 3, 4, 6]);
    add(&result, "flux_y", &[3, 3, 4, 5]);
    add(&result, "sum_y", &[3, 3, 5, 5]);
    let folder = exported(&result, "out", &["--format", "zarr"]);
    let axes = |array: &str| said_of(&folder, array)["dimension_names"].clone();
    assert_eq!(axes("count_x"), json!(["time", "z", "y", "x"]));
    assert_eq!(axes("flux_x"), json!(["time", "z", "y", "x_face"]));
    assert_eq!(axes("flux_y"), json!(["time", "z", "y_face", "x"]));
    assert_eq!(axes("sum_y"), json!(["time", "z", "sum_y_1", "x"]));
}

#[test]
fn what_templates_found_has_no_time() {
    let result = result("export_templates", 2);
    // As many numbers as there are densities, flows and cells along an axis.
    add(&result, "template_0_center", &[3]);
    add(&result, "template_0_amplitude", &[2, 5]);
    add(&result, "template_0_radius", &[]);
    let folder = exported(&result, "out", &["--format", "zarr,npz", "--steps", "1..1"]);
    let arrays = npz::read(&folder.join("smoke.npz"));
    let given = npz::read(&result.join("result.npz"));
    for (array, axes) in [
        (
            "template_0_amplitude",
            json!(["template_0_amplitude_0", "template_0_amplitude_1"]),
        ),
        ("template_0_center", json!(["template_0_center_0"])),
        ("template_0_radius", json!([])),
    ] {
        assert_eq!(arrays[array], given[array], "{array}");
        let said = said_of(&folder, array);
        assert_eq!(said["dimension_names"], axes, "{array}");
        assert_eq!(said["shape"], json!(given[array].shape), "{array}");
    }
    let radius = fs::read(folder.join("smoke.zarr/template_0_radius/c")).unwrap();
    assert_eq!(radius, 0.5_f64.to_le_bytes());
}

#[test]
fn an_array_whose_name_is_a_path_is_refused() {
    let result = result("export_names", 2);
    let whole = fs::read(result.join("result.npz")).unwrap();
    let folder = exported(&result, "out", &["--format", "zarr"]);
    let before = sums(result.parent().unwrap());
    let beside = result.with_file_name("beside");
    for name in ["../../../beside", text(&beside), "..", "a/b", "a\\b", "c:d", ""] {
        fs::write(result.join("result.npz"), &whole).unwrap();
        add(&result, name, &[3, 4, 5]);
        for format in ["zarr", "npz"] {
            let ended = run(&[
                "export",
                text(&result),
                "--quiet",
                "-o",
                text(&folder),
                "--format",
                format,
            ]);
            assert_eq!(ended.code, 2, "{name}: {}", ended.err);
            assert!(
                ended.err.contains(&format!("has an array called {name:?}")),
                "{name}: {}",
                ended.err
            );
        }
    }
    fs::write(result.join("result.npz"), &whole).unwrap();
    assert_eq!(sums(result.parent().unwrap()), before);
}

#[test]
fn a_rate_a_thousandth_away_is_another_one() {
    let result = result("export_rates", 2);
    let path = result.join("report.json");
    let report: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    let played = |dt: f64, more: &[&str]| {
        let mut report = report.clone();
        report["dt"] = dt.into();
        fs::write(&path, report.to_string()).unwrap();
        let folder = exported(&result, "out", more);
        let facts: Value = serde_json::from_slice(&fs::read(folder.join("export.json")).unwrap()).unwrap();
        let number = |key: &str| facts[key].as_f64().unwrap();
        (number("fps"), number("velocity_factor"))
    };
    for whole in [24.0, 30.0, 48.0, 60.0, 120.0] {
        let film: f64 = whole * 1000.0 / 1001.0;
        for dt in [1.0 / film, (1e6 / film).round() / 1e6, (1e7 / film).round() / 1e7] {
            let near = |(fps, factor): (f64, f64), wanted: [f64; 2]| {
                (fps / wanted[0] - 1.0).abs() < 1e-12 && (factor / wanted[1] - 1.0).abs() < 1e-12
            };
            assert!(near(played(dt, &[]), [1.0 / dt, 1.0]), "{dt}");
            let asked = played(dt, &["--fps", &whole.to_string()]);
            assert!(near(asked, [whole, dt * whole]), "{dt}");
        }
    }
    // What few digits leave of a rate is still that rate.
    assert_eq!(played(0.041667, &[]), (24.0, 1.0));
    assert_eq!(played(0.0417, &["--fps", "24"]), (24.0, 1.0));
}

#[test]
fn an_export_says_how_it_plays() {
    let result = result("export_says", 3);
    let facts = |folder: &Path| -> Value {
        serde_json::from_slice(&fs::read(folder.join("export.json")).unwrap()).unwrap()
    };
    // A step of an eighth of a second is no frame of a film.
    let slow = facts(&exported(&result, "slow", &[]));
    assert_eq!(
        (slow["fps"].as_f64(), slow["velocity_factor"].as_f64()),
        (Some(24.0), Some(3.0))
    );
    let real = facts(&exported(&result, "real", &["--fps", "8"]));
    assert_eq!(
        (real["fps"].as_f64(), real["velocity_factor"].as_f64()),
        (Some(8.0), Some(1.0))
    );
    assert_eq!(real["frames"], json!([1, 3]));
    let later = exported(
        &result,
        "later",
        &["--format", "usd,vti,fga", "--first-frame", "1001"],
    );
    assert_eq!(facts(&later)["frames"], json!([1001, 1003]));
    let stage = fs::read_to_string(later.join("smoke.usda")).unwrap();
    for words in [
        "startTimeCode = 1001",
        "endTimeCode = 1003",
        "1002: @./vdb/smoke.1002.vdb@",
        "step k - 1001",
    ] {
        assert!(stage.contains(words), "{words}: {stage}");
    }
    for file in ["vdb/smoke.1001.vdb", "vti/smoke.1003.vti", "fga/smoke.1002.fga"] {
        assert!(later.join(file).is_file(), "{file}");
    }
    let largest = real["largest_density"].as_f64().unwrap();
    assert_eq!(largest, 179.0 / 64.0);
    // Through a quarter of the box 95 % of what is behind is hidden.
    assert!((real["shader_density"].as_f64().unwrap() * largest * 2.5 / 4.0 - 3.0).abs() < 1e-12);
}

#[test]
fn a_new_export_takes_the_place_of_the_old_one_of_its_format_alone() {
    let result = result("export_again", 2);
    let folder = exported(&result, "out", &["--format", "vdb,vti"]);
    fs::write(folder.join("mine.txt"), "mine").unwrap();
    exported(&result, "out", &["--format", "vdb", "--steps", "1..1"]);
    let names = |below: &str| {
        let entries = fs::read_dir(folder.join(below)).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    assert_eq!(names("vdb"), ["smoke.0002.vdb"]);
    assert_eq!(
        names("vti"),
        ["smoke.0001.vti", "smoke.0002.vti", "smoke.0003.vti"]
    );
    assert_eq!(fs::read_to_string(folder.join("mine.txt")).unwrap(), "mine");
    assert!(
        names("").iter().all(|name| !name.starts_with('.')),
        "{:?}",
        names("")
    );
}

#[test]
fn a_stage_goes_with_the_volumes_that_it_plays() {
    let result = result("export_stage", 2);
    let folder = exported(&result, "out", &["--format", "usd,vti"]);
    let stage = folder.join("smoke.usda");
    exported(&result, "out", &["--format", "vti"]);
    assert!(stage.is_file());
    exported(&result, "out", &["--format", "vdb", "--steps", "1..1"]);
    assert!(!stage.exists());
}

#[test]
fn what_cannot_be_exported_is_refused_and_leaves_the_earlier_one() {
    let result = result("export_refused", 3);
    let folder = exported(&result, "out", &["--format", "vdb"]);
    let before = sums(&folder);
    let refused = |more: &[&str], code: i32, sentence: &str| {
        let common = ["export", text(&result), "--quiet", "-o", text(&folder)];
        let ended = run(&[&common[..], more].concat());
        assert_eq!(ended.code, code, "{more:?}: {}", ended.err);
        assert!(ended.err.contains(sentence), "{more:?}: {}", ended.err);
        assert_eq!(sums(&folder), before, "{more:?}");
    };
    refused(&["--steps", "2..9"], 2, "the result has the steps 0 to 2");
    refused(
        &["--format", "abc"],
        2,
        "possible values: vdb, usd, vti, zarr, fga, npz",
    );
    refused(&["--fps", "0"], 2, "allowed is a number from 0.01 to 10000");
    refused(
        &["--format", "vti,zarr", "--staggered"],
        2,
        "--staggered is of vdb or usd",
    );
    refused(
        &["--format", "zarr", "--precision", "float"],
        2,
        "--precision is of vdb or usd, which are not written; add one to --format",
    );
    refused(
        &["--format", "vti", "--compression", "zip"],
        2,
        "--compression is of vdb or usd",
    );
    refused(
        &["--format", "npz,vti", "--up", "y"],
        2,
        "--up is of vdb, usd or fga",
    );
    // Said before the steps are written, which may take hours.
    let own = folder.join("smoke.npz");
    fs::write(&own, "the user's").unwrap();
    let in_the_way = run(&[
        "export",
        text(&result),
        "--format",
        "vti,npz",
        "-o",
        text(&folder),
    ]);
    assert_eq!(in_the_way.code, 4, "{}", in_the_way.err);
    assert!(
        in_the_way
            .err
            .contains("smoke.npz is there and was not written by thurible"),
        "{}",
        in_the_way.err
    );
    assert_eq!(in_the_way.out, "");
    fs::remove_file(&own).unwrap();
    let archive = result.join("result.npz");
    let whole = fs::read(&archive).unwrap();
    fs::write(&archive, &whole[..whole.len() / 2]).unwrap();
    refused(&["--format", "vdb"], 2, "is no .npz");
    fs::remove_file(&archive).unwrap();
    refused(&["--format", "vdb"], 4, "cannot be read");
    fs::write(&archive, &whole).unwrap();
    fs::write(result.join("report.json"), "{}").unwrap();
    refused(
        &["--format", "vdb"],
        2,
        "has a report.json without a usable `cells`",
    );
}

/// Files of more than 8 KiB cannot be written, as on a disc that is full.
#[cfg(unix)]
#[test]
fn an_export_that_cannot_be_written_leaves_the_earlier_one() {
    use crate::support::{Ended, with_short_files};
    let result = result("export_full", 3);
    let folder = exported(&result, "out", &["--format", "usd,vti"]);
    let before = sums(&folder);
    for format in ["vdb", "usd,vti,zarr,npz"] {
        let mut command = with_short_files(16);
        command.args([
            "export",
            text(&result),
            "--quiet",
            "--fps",
            "8",
            "--format",
            format,
            "-o",
            text(&folder),
        ]);
        let ended = Ended::from(command.output().unwrap());
        assert_eq!(ended.code, 4, "{format}: {}", ended.err);
        assert!(
            ended.err.contains("vdb/smoke.0001.vdb: File too large"),
            "{format}: {}",
            ended.err
        );
        assert!(ended.err.contains("free some space"), "{format}: {}", ended.err);
        assert_eq!(ended.err.lines().count(), 1, "{format}: {}", ended.err);
        assert_eq!(sums(&folder), before, "{format}");
        let hidden = |entry: fs::DirEntry| entry.file_name().to_string_lossy().starts_with('.');
        assert!(
            !fs::read_dir(&folder).unwrap().any(|entry| hidden(entry.unwrap())),
            "{format}"
        );
    }
}

/// Ranks share the steps, fewer of them than steps and more: the files are those of one program.
#[test]
fn ranks_share_the_steps() {
    let result = result("export_ranks", 3);
    let formats = ["--format", "usd,vti,zarr,fga,npz"];
    let alone = sums(&exported(&result, "alone", &formats));
    assert!(alone.lines().count() > 20, "{alone}");
    for count in [2, 5] {
        let folder = result.with_file_name(format!("of_{count}"));
        let common = [
            "thurible",
            "export",
            text(&result),
            "--quiet",
            "-o",
            text(&folder),
        ];
        let arguments = [&common[..], &formats].concat();
        let threads: Vec<_> = channels::ranks(count)
            .into_iter()
            .map(|rank| {
                let Command::Export(mut export) = Cli::parse_from(&arguments).command else {
                    unreachable!("it is an export");
                };
                export.ranks = Some(Box::leak(Box::new(rank)));
                std::thread::spawn(move || run_export(&export).unwrap())
            })
            .collect();
        for thread in threads {
            assert_eq!(thread.join().unwrap(), 0);
        }
        assert_eq!(sums(&folder), alone, "{count} ranks");
    }
}

/// What an export leaves of an earlier one is still said.
#[test]
fn what_stays_of_earlier_exports_is_said() {
    let result = result("export_earlier", 3);
    let folder = exported(&result, "out", &["--format", "vti,vdb"]);
    exported(&result, "out", &["--format", "usd,zarr", "--first-frame", "7"]);
    let facts: Value = serde_json::from_slice(&fs::read(folder.join("export.json")).unwrap()).unwrap();
    assert_eq!(facts["formats"], json!(["usd", "zarr"]));
    assert_eq!(facts["earlier"].as_array().unwrap().len(), 1);
    assert_eq!(facts["earlier"][0]["formats"], json!(["vti"]));
    assert_eq!(facts["earlier"][0]["frames"], json!([1, 3]));
}
