//! `thurible track`: frames in, flows out; what is refused, what is said, what an interruption leaves.

use crate::support::npz;
use crate::support::{fresh_folder, json, run};
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A small plume and its flow, simulated.
fn plume(test: &str, scene: &str) -> PathBuf {
    plume_with(test, scene, &[])
}

/// The same with more arguments.
fn plume_with(test: &str, scene: &str, others: &[&str]) -> PathBuf {
    let folder = fresh_folder(test).join("flow");
    let scene = format!("examples/{scene}.toml");
    let more = [
        "--quiet",
        "--set",
        "output.frames=false",
        "--set",
        "flow.buoyancy=0.05",
        "--precision",
        "f32",
    ];
    let first = ["simulate", &scene, "-o", folder.to_str().unwrap()];
    let ended = run(&[&first[..], &more, others].concat());
    assert_eq!(ended.code, 0, "{}", ended.err);
    folder
}

fn track(frames: &Path, out: &Path, more: &[&str]) -> crate::support::Ended {
    let arguments = [
        "track",
        frames.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
        "--threads",
        "2",
        "--force",
    ];
    run(&[&arguments[..], more].concat())
}

fn report(folder: &Path) -> Value {
    json(&folder.join("report.json"))
}

/// An array file.
fn npy(path: &Path, shape: &[usize], values: &[f32]) {
    let values: Vec<f64> = values.iter().map(|&value| f64::from(value)).collect();
    fs::write(path, npz::npy(shape, &values)).unwrap();
}

/// A blob on 16 x 12 cells that moves to the right.
fn blob(time: usize) -> Vec<f32> {
    (0..192)
        .map(|cell| {
            let (x, y) = ((cell % 16) as f32, (cell / 16) as f32);
            (-((x - 4.0 - 0.8 * time as f32).powi(2) + (y - 6.0).powi(2)) / 8.0).exp()
        })
        .collect()
}

/// A folder with blobs as files of these numbers.
fn files(test: &str, numbers: &[usize]) -> PathBuf {
    let folder = fresh_folder(test).join("frames");
    fs::create_dir_all(&folder).unwrap();
    for &number in numbers {
        npy(
            &folder.join(format!("smoke_{number}.npy")),
            &[12, 16],
            &blob(number),
        );
    }
    folder
}

#[test]
fn a_simulated_flow_is_found() {
    let flow = plume("track_found", "small_odd");
    let out = flow.with_file_name("out");
    let ended = track(&flow, &out, &["--set", "capture.first=1"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.contains("left, up to"), "progress: {}", ended.err);
    let report = report(&out);
    assert_eq!(report["kind"], "track");
    let history = report["history"].as_array().unwrap();
    assert_eq!(history.len(), report["steps"].as_u64().unwrap() as usize);
    let error = history.last().unwrap()["velocity_relative_error"]
        .as_f64()
        .unwrap();
    assert!(error < 0.4, "{error}");
    let memory = &report["memory"];
    let (planned, used) = (
        memory["planned_bytes"].as_u64().unwrap(),
        memory["used_bytes"].as_u64().unwrap(),
    );
    assert!(used >= planned && used <= planned + 8192);
    let arrays = npz::read(&out.join("result.npz"));
    for name in [
        "captured",
        "density",
        "velocity_x",
        "predicted_y",
        "correction_x",
        "truth_y",
    ] {
        let frames = history.len() + usize::from(name == "captured" || name == "density");
        assert_eq!(arrays[name].shape[0], frames, "{name}");
    }
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for what in [
        "carried to frame",
        "true flow from frame",
        "Misfit of the frames",
        "direction and speed",
    ] {
        assert!(page.contains(what), "{what}");
    }
}

#[test]
fn every_method_and_option_is_taken() {
    let flow = plume("track_methods", "small_3d");
    let out = flow.with_file_name("out");
    let fine = ["--set", "capture.first=1", "--quiet"];
    for more in [
        &["--method", "admm", "--precision", "f64"][..],
        &["--method", "horn_schunck", "--set", "track.gamma=10"],
        &[
            "--alpha",
            "1e-3",
            "--beta",
            "0.5",
            "--set",
            "track.warp=\"quick\"",
            "--set",
            "track.predict=\"bfecc\"",
        ],
        &[
            "--set",
            "track.predict=\"none\"",
            "--set",
            "track.readvect=false",
            "--set",
            "track.levels=1",
        ],
        &[
            "--set",
            "track.independent=true",
            "--set",
            "track.warps=2",
            "--set",
            "track.sigma=0",
        ],
        &[
            "--set",
            "track.cg_tolerance=\"auto\"",
            "--set",
            "track.buoyancy=0.05",
        ],
    ] {
        let ended = track(&flow, &out, &[&fine[..], more].concat());
        assert_eq!(ended.code, 0, "{more:?}: {}", ended.err);
        let error = report(&out)["history"][1]["velocity_relative_error"]
            .as_f64()
            .unwrap();
        assert!(error.is_finite() && error < 3.0, "{more:?}: {error}");
    }
}

/// What a result has and a tracked flow does not know is said, and so is a key of another method; rings are known all the same.
#[test]
fn what_is_not_known_of_a_result_is_said() {
    let ends = "grid.boundary=[\"periodic\", \"open_high\"]";
    let solid = "obstacle=[{box={min=[0.0,0.0],max=[0.2,0.2]}}]";
    let flow = plume_with("track_unknown", "small_odd", &["--set", ends, "--set", solid]);
    let out = flow.with_file_name("out");
    let more = ["--set", "capture.first=1", "--set", "track.gamma=5"];
    let ended = track(&flow, &out, &more);
    assert_eq!(ended.code, 0, "{}", ended.err);
    for words in [
        "open sides",
        "solid cells",
        "`track.gamma` is for horn_schunck alone",
    ] {
        assert!(ended.err.contains(words), "{words}: {}", ended.err);
    }
    let report = report(&out);
    assert_eq!(report["remarks"].as_array().unwrap().len(), 3);
    assert_eq!(report["boundary"], serde_json::json!(["periodic", "wall"]));
    let wide = track(&flow, &out, &["--set", "track.sigma=50"]);
    assert!(
        wide.code == 2 && wide.err.contains("from 0 to 32"),
        "{}",
        wide.err
    );
}

#[test]
fn frames_come_in_files_and_captures() {
    let frames = files("track_files", &[8, 9, 10]);
    let out = frames.with_file_name("out");
    let pattern = frames.join("smoke_*.npy");
    for source in [frames.as_path(), pattern.as_path()] {
        let ended = track(source, &out, &["--quiet"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let arrays = npz::read(&out.join("result.npz"));
        // By number: 10 comes after 9.
        let last: Vec<f32> = arrays["captured"].data[2 * 192..]
            .iter()
            .map(|&value| value as f32)
            .collect();
        assert_eq!(last, blob(10));
    }
    // A folder's name has no ending: what follows on a point is a version.
    let version = frames.with_file_name("frames.v002");
    fs::rename(&frames, &version).unwrap();
    let ended = run(&["track", version.to_str().unwrap(), "--quiet"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(frames.with_file_name("frames.v002_track").is_dir());
    fs::rename(&version, &frames).unwrap();
    let capture = frames.with_file_name("blob.toml");
    let text = "[capture]\nfiles = \"frames/smoke_*.npy\"\nboundary = [\"periodic\", \"wall\"]\nlength = 2.0\ndt = 0.1\nlast = 1\n[track]\nbeta = 0.3\n";
    fs::write(&capture, text).unwrap();
    let ended = track(&capture, &out, &["--quiet"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let report = report(&out);
    assert_eq!(
        (report["steps"].as_u64(), report["boundary"][0].as_str()),
        (Some(1), Some("periodic"))
    );
    let arrays = npz::read(&out.join("result.npz"));
    assert_eq!(arrays["velocity_x"].shape, [1, 12, 16]);
    let fastest = arrays["velocity_x"].data.iter().copied().fold(0.0, f64::max);
    // 0.8 cells of 2 / 16 in a tenth of a unit of time, less what beta keeps.
    assert!(fastest > 0.1 && fastest < 1.5, "{fastest}");
}

#[test]
fn what_cannot_be_tracked_is_refused() {
    let frames = files("track_refused", &[0, 1, 2, 3]);
    let out = frames.with_file_name("out");
    let refused = |what: &str, said: &[&str]| {
        let ended = track(&frames, &out, &["--quiet"]);
        assert_eq!(ended.code, 2, "{what}: {}", ended.err);
        for words in said {
            assert!(ended.err.contains(words), "{what}: {}", ended.err);
        }
        assert!(!out.exists(), "{what}");
    };
    let one = frames.join("smoke_2.npy");
    fs::remove_file(&one).unwrap();
    refused(
        "a gap",
        &["lacks frame 2 between smoke_1.npy and smoke_3.npy", "add it"],
    );
    // Two cameras in one folder.
    let twins = frames.with_file_name("twins");
    fs::create_dir_all(&twins).unwrap();
    for (name, time) in [("left_0", 0), ("left_1", 1), ("right_0", 0), ("right_1", 1)] {
        npy(&twins.join(format!("{name}.npy")), &[12, 16], &blob(time));
    }
    let ended = track(&twins, &out, &["--quiet"]);
    assert!(
        ended.code == 2 && ended.err.contains("the same number, left_0.npy and right_0.npy"),
        "{}",
        ended.err
    );
    // One that is not numbered among others that are.
    fs::remove_file(twins.join("right_0.npy")).unwrap();
    fs::rename(twins.join("right_1.npy"), twins.join("mask.npy")).unwrap();
    let ended = track(&twins, &out, &["--quiet"]);
    assert!(
        ended.code == 2 && ended.err.contains("has mask.npy among frames that are numbered"),
        "{}",
        ended.err
    );
    // What the sentence offers: the frames before and after the gap, on their own.
    let part = frames.with_file_name("part");
    npy(&frames.join("smoke_4.npy"), &[12, 16], &blob(4));
    for half in ["capture.last=1", "capture.first=2"] {
        let ended = track(&frames, &part, &["--quiet", "--set", half]);
        assert_eq!(ended.code, 0, "{half}: {}", ended.err);
        assert_eq!(report(&part)["steps"], 1, "{half}");
    }
    fs::remove_file(frames.join("smoke_4.npy")).unwrap();
    npy(&one, &[16, 12], &blob(2));
    refused(
        "a size",
        &[
            "smoke_2.npy",
            "12 x 16 cells where the frames before have 16 x 12",
        ],
    );
    let mut values = blob(2);
    values[20] = f32::NAN;
    npy(&one, &[12, 16], &values);
    refused("NaN", &["smoke_2.npy", "holds NaN at [1, 4]"]);
    npy(
        &one,
        &[12, 16],
        &blob(2).iter().map(|value| value - 0.5).collect::<Vec<_>>(),
    );
    refused("negative values", &["smoke_2.npy", "a density is never negative"]);
    npy(&one, &[12, 16], &[0.0; 192]);
    refused(
        "a blank frame",
        &["smoke_2.npy", "no smoke anywhere, and the frame before has some"],
    );
    for number in 0..4 {
        npy(
            &frames.join(format!("smoke_{number}.npy")),
            &[12, 16],
            &[0.0; 192],
        );
    }
    refused("no smoke", &["all others have no smoke anywhere"]);
    for number in 1..4 {
        fs::remove_file(frames.join(format!("smoke_{number}.npy"))).unwrap();
    }
    refused("one frame", &["a single frame", "a flow needs two frames"]);
    for name in ["smoke.svg", "smoke.vdb", "smoke.png"] {
        let path = frames.with_file_name(name);
        fs::write(&path, b"whatever").unwrap();
        let ended = track(&path, &out, &["--quiet"]);
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(
            ended.err.contains("is one frame, and a flow needs two; "),
            "{}",
            ended.err
        );
    }
}

/// Frames in colour are no thin volumes, in one array or in a file each.
#[test]
fn frames_in_colour_are_refused() {
    let folder = fresh_folder("track_colour");
    let (array, out) = (folder.join("smoke.npy"), folder.join("out"));
    let colour = |time: usize, channels: usize| -> Vec<f32> {
        let grey = blob(time);
        grey.into_iter().flat_map(|value| vec![value; channels]).collect()
    };
    let refused = |frames: &Path, found: &str| {
        let ended = track(frames, &out, &["--quiet"]);
        assert_eq!(ended.code, 2, "{}", ended.err);
        for words in [found, "looks like colour", "give one channel"] {
            assert!(ended.err.contains(words), "{words}: {}", ended.err);
        }
        assert!(!out.exists());
    };
    for channels in [3, 4] {
        let frames: Vec<f32> = (0..3).flat_map(|time| colour(time, channels)).collect();
        npy(&array, &[3, 12, 16, channels], &frames);
        refused(&array, &format!("has {channels} values along its last axis"));
    }
    let frames = folder.join("frames");
    fs::create_dir_all(&frames).unwrap();
    for time in 0..2 {
        let file = frames.join(format!("smoke_{time}.npy"));
        npy(&file, &[12, 16, 3], &colour(time, 3));
    }
    refused(&frames, "smoke_0.npy");
}

#[test]
fn an_array_may_have_any_name() {
    let folder = fresh_folder("track_name");
    let (path, out) = (folder.join("smoke.npz"), folder.join("out"));
    let mut archive = zip::ZipWriter::new(fs::File::create(&path).unwrap());
    let packed =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    archive.start_file("a/../b.npy", packed).unwrap();
    let values: Vec<f64> = (0..3).flat_map(blob).map(f64::from).collect();
    archive.write_all(&npz::npy(&[3, 12, 16], &values)).unwrap();
    archive.finish().unwrap();
    let capture = folder.join("capture.toml");
    fs::write(&capture, "[capture]\nfiles = \"smoke.npz\"\nname = \"a/../b\"\n").unwrap();
    let ended = track(&capture, &out, &["--quiet"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
}

#[test]
fn what_is_odd_is_said() {
    let frames = files("track_odd", &[0, 1, 2]);
    let out = frames.with_file_name("out");
    let mut values = blob(1);
    values[0] = -0.01;
    npy(&frames.join("smoke_1.npy"), &[12, 16], &values);
    npy(&frames.join("smoke_2.npy"), &[12, 16], &blob(13));
    let ended = track(&frames, &out, &[]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    for words in ["below 0", "the smoke jumps"] {
        assert!(ended.err.contains(words), "{}", ended.err);
    }
    assert_eq!(report(&out)["remarks"].as_array().unwrap().len(), 2);
    npy(&frames.join("smoke_0.npy"), &[12, 16], &[0.0; 192]);
    npy(&frames.join("smoke_1.npy"), &[12, 16], &blob(1));
    let ended = track(&frames, &out, &[]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let words = "from frame 0 to 1 smoke appears where there was none at all, which no flow does: its flow means nothing; begin at frame 1 by capture.first";
    assert!(ended.err.contains(words), "{}", ended.err);
    let first = report(&out)["history"][0]["fastest"].as_f64().unwrap();
    assert!(first < 1e-3, "{first} cells a frame out of nothing");
}

/// Forces are one fewer than flows, without divergence, and change no flow (std_runner/python/tests has them bring each flow to the next).
#[test]
fn forces_are_written_when_asked() {
    let frames = files("track_forces", &[0, 1, 2, 3]);
    let folder = frames.parent().unwrap();
    let [plain, forced] = ["plain", "forced"].map(|name| folder.join(name));
    for (out, forces) in [(&plain, "track.forces=false"), (&forced, "track.forces=true")] {
        let ended = track(
            &frames,
            out,
            &["--quiet", "--set", "capture.dt=0.5", "--set", forces],
        );
        assert_eq!(ended.code, 0, "{}", ended.err);
    }
    let bytes = |out: &Path| report(out)["memory"]["planned_bytes"].as_u64().unwrap();
    assert!(bytes(&forced) > bytes(&plain));
    let [plain, forced] = [plain, forced].map(|out| npz::read(&out.join("result.npz")));
    assert!(!plain.contains_key("force_x"));
    for name in ["velocity_x", "velocity_y"] {
        assert_eq!(plain[name].data, forced[name].data);
    }
    let (x, y) = (&forced["force_x"], &forced["force_y"]);
    assert_eq!((&x.shape[..], &y.shape[..]), (&[2, 12, 17][..], &[2, 13, 16][..]));
    let largest = x.data.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    assert!(largest > 0.0);
    for (k, row, column) in (0..2 * 12 * 16).map(|cell| (cell / 192, cell / 16 % 12, cell % 16)) {
        let (x, y) = (
            |at: usize| x.data[(k * 12 + row) * 17 + at],
            |at: usize| y.data[(k * 13 + at) * 16 + column],
        );
        let divergence = x(column + 1) - x(column) + y(row + 1) - y(row);
        assert!(divergence.abs() < 1e-4 * largest, "{divergence} beside {largest}");
    }
    // One pair alone has none, and is a whole result as any other.
    let frames = files("track_forces_alone", &[0, 1]);
    let [out, into] = ["out", "exported"].map(|name| frames.parent().unwrap().join(name));
    let ended = track(&frames, &out, &["--quiet", "--set", "track.forces=true"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(!npz::read(&out.join("result.npz")).contains_key("force_x"));
    let [from, into] = [&out, &into].map(|path| path.to_str().unwrap());
    let ended = run(&["export", from, "--format", "zarr", "-o", into, "--quiet"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
}

/// The flow of the first pair is taken from a velocity alone, or from the first step of a result; of other cells it is refused.
#[test]
fn the_first_flow_may_be_known() {
    let frames = files("track_initial", &[0, 1, 2]);
    let folder = frames.parent().unwrap();
    let (out, again) = (folder.join("out"), folder.join("again"));
    let ended = track(&frames, &out, &["--quiet", "--set", "track.beta=0.1"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let arrays = npz::read(&out.join("result.npz"));
    let file = folder.join("v0.npz");
    let first = |name| {
        let (array, shape) = (&arrays[name], &arrays[name].shape[1..]);
        let count: usize = shape.iter().product();
        (name, npz::npy(shape, &array.data[..count]))
    };
    npz::write(&file, &["velocity_x", "velocity_y"].map(first));
    let of = |file: &Path| format!("track.initial_velocity={{ file = {:?} }}", file.to_str().unwrap());
    let predicted = |file: &Path| {
        let ended = track(&frames, &again, &["--quiet", "--set", &of(file)]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        npz::read(&again.join("result.npz"))["predicted_x"].data[..12 * 17].to_vec()
    };
    let known = &arrays["velocity_x"].data[..12 * 17];
    for found in [predicted(&file), predicted(&out.join("result.npz"))] {
        let gaps = found.iter().zip(known).map(|(x, y)| (x - y).abs());
        assert!(gaps.fold(0.0, f64::max) < 1e-5);
        assert!(found.iter().any(|speed| speed.abs() > 0.05));
    }
    let other = files("track_initial_other", &[0]);
    npy(&other.join("smoke_0.npy"), &[6, 16], &blob(0)[..96]);
    npy(&other.join("smoke_1.npy"), &[6, 16], &blob(1)[..96]);
    let ended = track(&other, &again, &["--quiet", "--set", &of(&file)]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    let words = "has velocity_x that is refused: it has 204 values where 102 are needed";
    assert!(ended.err.contains(words), "{}", ended.err);
    let ended = track(&other, &again, &["--quiet", "--set", "track.winds=true"]);
    let words = "there is no key `winds` here; expected one of `method`";
    assert!(
        ended.err.contains(words) && ended.err.contains("`initial_velocity`"),
        "{}",
        ended.err
    );
}

/// Volumes are frames as arrays are, planes too.
#[test]
fn volumes_are_frames() {
    let folder = fresh_folder("track_volumes");
    for scene in ["small_3d", "small_letter"] {
        let names = [scene.into(), format!("{scene}_vdb"), "out".into()];
        let [result, volumes, out] = names.map(|name: String| folder.join(name));
        let [from, into] = [&result, &volumes].map(|path| path.to_str().unwrap());
        let small = [
            "--set",
            "output.frames=false",
            "--quiet",
            "--set",
            "method.iterations=2",
        ];
        let solve = ["solve", &format!("examples/{scene}.toml"), "-o", from];
        assert_eq!(run(&[&solve[..], &small].concat()).code, 0);
        let ended = run(&["export", from, "--format", "vdb", "-o", into]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let ended = track(&volumes.join("vdb"), &out, &["--quiet"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let [found, known] = [&out, &result].map(|folder| npz::read(&folder.join("result.npz")));
        let [frames, densities] = [&found["captured"], &known["density"]];
        assert_eq!(frames.shape.len(), densities.shape.len(), "{scene}");
        assert_eq!(frames.shape[0], densities.shape[0], "{scene}");
        // A box round the voxels that hold smoke, in half precision.
        let [mass, all] = [frames, densities].map(|array| array.data.iter().sum::<f64>());
        assert!((mass / all - 1.0).abs() < 1e-2, "{scene}: {mass} of {all}");
        assert!(
            found["velocity_x"].data.iter().any(|speed| speed.abs() > 1e-3),
            "{scene}"
        );
    }
}

/// Where the truth rests there is no error in parts of it, and pairs on their own say that nothing was predicted.
#[test]
fn a_truth_that_rests_is_no_divisor() {
    let folder = fresh_folder("track_rest");
    let file = folder.join("smoke.npz");
    let frames: Vec<f64> = (0..3).flat_map(blob).map(f64::from).collect();
    let arrays = [
        ("density", npz::npy(&[3, 12, 16], &frames)),
        ("velocity_x", npz::npy(&[2, 12, 17], &[0.0; 2 * 12 * 17])),
        ("velocity_y", npz::npy(&[2, 13, 16], &[0.0; 2 * 13 * 16])),
    ];
    npz::write(&file, &arrays);
    let out = folder.join("out");
    let mut wrong = arrays;
    let mut values = [0.0; 2 * 12 * 17];
    values[12 * 17 + 3] = f64::NAN;
    wrong[1].1 = npz::npy(&[2, 12, 17], &values);
    let broken = folder.join("broken.npz");
    npz::write(&broken, &wrong);
    let ended = track(&broken, &out, &[]);
    assert!(
        ended.code == 2 && ended.err.contains("`capture.truth`") && ended.err.contains("in step 1"),
        "{}",
        ended.err
    );
    let ended = track(&file, &out, &["--set", "track.independent=true"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.contains("where the truth rests"), "{}", ended.err);
    let report = report(&out);
    assert_eq!(report["track"]["predict"], "none");
    let pair = &report["history"][0];
    assert!(pair["velocity_rms_error"].as_f64().unwrap() > 0.0);
    assert!(pair.get("velocity_relative_error").is_none() && pair["angular_error"] == 0.0);
}

#[test]
fn a_plan_and_a_ceiling_are_heard() {
    let frames = files("track_plan", &[0, 1]);
    let out = frames.with_file_name("out");
    let ended = track(&frames, &out, &["--plan"]);
    assert!(
        ended.code == 0 && ended.out.contains("whatever the number of frames"),
        "{}",
        ended.err
    );
    let ended = track(&frames, &out, &["--plan", "--json"]);
    let planned: Value = serde_json::from_str(&ended.out).unwrap();
    let lines = planned["ledger"].as_array().unwrap();
    assert!(
        planned["planned_bytes"].as_u64() > Some(1000) && lines.len() > 3,
        "{planned}"
    );
    assert!(!out.exists());
    let ended = track(&frames, &out, &["--memory-limit", "20KiB"]);
    assert!(
        ended.code == 3 && ended.err.contains("raise --memory-limit"),
        "{}",
        ended.err
    );
}

/// Ctrl-C leaves the pairs that are done.
#[test]
#[cfg(unix)]
fn an_interrupted_run_is_a_shorter_result() {
    use crate::support::endless::Endless;
    let frames = fresh_folder("track_interrupted").join("smoke.npy");
    let (count, side) = (40, 128);
    let values: Vec<f32> = (0..count * side * side)
        .map(|index| {
            let (x, y) = ((index % side) as f32, (index / side % side) as f32);
            let time = (index / side / side) as f32;
            ((0.11 * x + 0.02 * time).sin() * (0.13 * y - 0.01 * time).cos()).abs()
        })
        .collect();
    npy(&frames, &[count, side, side], &values);
    let out = frames.with_file_name("out");
    let mut command = crate::support::thurible();
    command.args(["track", frames.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    command.args(["--threads", "1", "--json"]);
    let ended = Endless::seen(&mut command, |line| line.contains("\"event\":\"pair\"")).stop();
    assert_eq!(ended.code, 130, "{}", ended.err);
    let report = report(&out);
    let done = report["steps"].as_u64().unwrap() as usize;
    assert!((1..count - 1).contains(&done), "{done} pairs");
    assert_eq!(report["status"], "cancelled");
    let arrays = npz::read(&out.join("result.npz"));
    assert_eq!(
        (arrays["captured"].shape[0], arrays["velocity_x"].shape[0]),
        (done + 1, done)
    );
    let ended = run(&["resume", out.to_str().unwrap()]);
    assert!(
        ended.code == 4 && ended.err.contains("it is no solve") && !ended.err.contains("--checkpoint"),
        "{}",
        ended.err
    );
}

/// Whatever the flow, it is carried as it is where its cells are: Horn and Schunck's has a divergence.
#[test]
fn a_flow_with_a_divergence_is_carried_as_it_is() {
    let flow = plume("track_readvect", "small_periodic");
    let (out, again) = (flow.with_file_name("out"), flow.with_file_name("again"));
    let more = ["--method", "horn_schunck", "--set", "capture.first=1"];
    let ended = track(&flow, &out, &more);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let ended = run(&[
        "readvect",
        out.to_str().unwrap(),
        "-o",
        again.to_str().unwrap(),
        "--quiet",
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let [found, carried] = [&out, &again].map(|folder| npz::read(&folder.join("result.npz")));
    for name in ["velocity_x", "velocity_y"] {
        assert_eq!(found[name].data, carried[name].data, "{name}");
    }
    let pairs = found["density"].data.iter().zip(&carried["density"].data);
    let apart = pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-4, "{apart}");
}

/// What is made between frames is taken off where it is known: beside the frames, in a file of its own, or not at all.
#[test]
fn what_is_made_is_taken_off() {
    let folder = fresh_folder("track_emission");
    let made: Vec<f64> = (0..192)
        .map(|cell| {
            let (x, y) = ((cell % 16) as f64, (cell / 16) as f64);
            0.3 * (-((x - 9.0).powi(2) + (y - 5.0).powi(2)) / 6.0).exp()
        })
        .collect();
    let frames: Vec<f64> = (0..4)
        .flat_map(|time| {
            let still = blob(0);
            let both = still.into_iter().zip(&made);
            both.map(move |(still, made)| f64::from(still) + f64::from(time) * made)
        })
        .collect();
    let capture = folder.join("capture.toml");
    fs::write(folder.join("smoke.npy"), npz::npy(&[4, 12, 16], &frames)).unwrap();
    fs::write(folder.join("made.npy"), npz::npy(&[3, 12, 16], &made.repeat(3))).unwrap();
    fs::write(
        &capture,
        "[capture]\nfiles = \"smoke.npy\"\nemission = \"made.npy\"\n",
    )
    .unwrap();
    let fastest = |more: &[&str]| {
        let out = folder.join("out");
        let ended = track(&capture, &out, &[&["--quiet"][..], more].concat());
        assert_eq!(ended.code, 0, "{}", ended.err);
        let history = report(&out)["history"].as_array().unwrap().clone();
        let fastest = history.iter().map(|pair| pair["fastest"].as_f64().unwrap());
        (fastest.fold(0.0, f64::max), npz::read(&out.join("result.npz")))
    };
    let (known, arrays) = fastest(&[]);
    assert_eq!(arrays["emission"].shape, [3, 12, 16]);
    let (unknown, without) = fastest(&["--set", "capture.emission=\"none\""]);
    assert!(!without.contains_key("emission"));
    assert!(known < 1e-3 && unknown > 0.05, "{known} with, {unknown} without");
    // A result has it beside its frames, and so has what is tracked again.
    let (again, arrays) = {
        let (first, out) = (folder.join("first"), folder.join("again"));
        assert_eq!(track(&capture, &first, &["--quiet"]).code, 0);
        let ended = track(&first, &out, &["--quiet"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let history = report(&out)["history"].as_array().unwrap().clone();
        let fastest = history.iter().map(|pair| pair["fastest"].as_f64().unwrap());
        (fastest.fold(0.0, f64::max), npz::read(&out.join("result.npz")))
    };
    assert!(again < 1e-3 && arrays.contains_key("emission"), "{again}");
    let refused = |values: &[f64], shape: &[usize], said: &str| {
        fs::write(folder.join("made.npy"), npz::npy(shape, values)).unwrap();
        let ended = track(&capture, &folder.join("no"), &["--quiet"]);
        assert_eq!(ended.code, 2, "{}", ended.err);
        let remedy = "or leave it out by capture.emission = \"none\"";
        assert!(
            ended.err.contains(said) && ended.err.contains(remedy),
            "{}",
            ended.err
        );
    };
    refused(
        &made.repeat(2),
        &[2, 12, 16],
        "holds 2 steps of [12, 16] cells where 3 of [12, 16] are needed",
    );
    refused(&made.repeat(3), &[3, 16, 12], "where 3 of [12, 16] are needed");
    let mut wrong = made.repeat(3);
    wrong[192 + 17] = -0.5;
    refused(
        &wrong,
        &[3, 12, 16],
        "holds -0.5 at [1, 1] of step 1; what is made is finite and never negative",
    );
    wrong[192 + 17] = f64::NAN;
    refused(&wrong, &[3, 12, 16], "holds NaN at [1, 1] of step 1");
    fs::remove_file(folder.join("made.npy")).unwrap();
    let ended = track(&capture, &folder.join("no"), &["--quiet"]);
    assert!(
        ended.code != 0 && ended.err.contains("capture.emission"),
        "{}",
        ended.err
    );
}

/// What follows on frames and flows does not write over a result unless it is asked to.
#[test]
fn a_result_is_written_over_when_asked() {
    let frames = files("track_again", &[0, 1, 2]);
    let (out, on) = (frames.with_file_name("out"), frames.with_file_name("on"));
    let [capture, from, into] = [&frames, &out, &on].map(|path| path.to_str().unwrap());
    for arguments in [
        &["track", capture, "-o", from, "--quiet"][..],
        &["readvect", from, "-o", into, "--quiet"],
    ] {
        let folder = Path::new(arguments[3]);
        assert_eq!(run(arguments).code, 0);
        let before = fs::read(folder.join("report.json")).unwrap();
        let ended = run(arguments);
        assert_eq!(ended.code, 4, "{}", ended.err);
        let words = "holds a result already: keep it and choose another folder with -o DIR, or write over it with --force";
        assert!(ended.err.contains(words), "{}", ended.err);
        assert!(fs::read(folder.join("report.json")).unwrap() == before);
        let ended = run(&[arguments, &["--force"]].concat());
        assert_eq!(ended.code, 0, "{}", ended.err);
    }
}

/// Keys that no frame and no pair hears are told of, and the truth may be a result folder.
#[test]
fn keys_that_nothing_hears_are_told_of() {
    let frames = files("track_unheard", &[0, 1, 2]);
    let [out, truth] = ["out", "truth"].map(|name| frames.with_file_name(name));
    fs::create_dir_all(&truth).unwrap();
    let rests = [
        ("velocity_x", npz::npy(&[2, 12, 17], &[0.0; 2 * 12 * 17])),
        ("velocity_y", npz::npy(&[2, 13, 16], &[0.0; 2 * 13 * 16])),
    ];
    npz::write(&truth.join("result.npz"), &rests);
    let more = ["--method", "horn_schunck", "--truth", truth.to_str().unwrap()];
    let sets = [
        "--set",
        "capture.ink=dark",
        "--set",
        "capture.name=density",
        "--set",
        "track.predict=bfecc",
    ];
    let ended = track(&frames, &out, &[&more[..], &sets].concat());
    assert_eq!(ended.code, 0, "{}", ended.err);
    for words in [
        "`capture.ink` is for pictures alone",
        "`capture.name` is for archives and volumes alone",
        "`track.predict` is for flows that are predicted",
    ] {
        assert!(ended.err.contains(words), "{}", ended.err);
    }
    assert!(report(&out)["history"][0]["velocity_rms_error"].as_f64().unwrap() > 0.0);
    let heard = ["--set", "track.predict=bfecc"];
    let ended = track(&frames, &out, &heard);
    assert!(
        ended.code == 0 && !ended.err.contains("does nothing"),
        "{}",
        ended.err
    );
}

#[test]
fn frames_of_nothing_and_of_too_much_say_so() {
    let frames = files("track_odd_values", &[0, 1]);
    let out = frames.with_file_name("out");
    let mut huge: Vec<f64> = blob(1).into_iter().map(f64::from).collect();
    huge[17] = 1e300;
    fs::write(frames.join("smoke_1.npy"), npz::npy(&[12, 16], &huge)).unwrap();
    let ended = track(&frames, &out, &[]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(
        ended.err.contains("holds 1e300 at") && ended.err.contains("in another unit"),
        "{}",
        ended.err
    );
    for number in 0..2 {
        let faint: Vec<f64> = blob(number)
            .into_iter()
            .map(|value| 1e-40 * f64::from(value))
            .collect();
        fs::write(
            frames.join(format!("smoke_{number}.npy")),
            npz::npy(&[12, 16], &faint),
        )
        .unwrap();
    }
    let ended = track(&frames, &out, &[]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(ended.err.contains("1e-30 and more"), "{}", ended.err);
    for number in 0..2 {
        npy(
            &frames.join(format!("smoke_{number}.npy")),
            &[12, 16],
            &blob(number),
        );
    }
    let ended = track(&frames, &out, &["--set", "capture.density_scale=1e12"]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(
        ended.err.contains("`capture.density_scale`") && ended.err.contains("or leave it out"),
        "{}",
        ended.err
    );
    for number in 0..2 {
        npy(&frames.join(format!("smoke_{number}.npy")), &[0, 16], &[]);
    }
    let ended = track(&frames, &out, &[]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(
        ended.err.contains("has frames of 16 x 0 cells") && ended.err.contains("a cell along each axis"),
        "{}",
        ended.err
    );
    fs::write(frames.join("beside.png"), "no picture").unwrap();
    let ended = track(&frames, &out, &[]);
    assert!(
        ended.code == 2
            && ended
                .err
                .contains("files of several kinds; say which by a pattern"),
        "{}",
        ended.err
    );
}
