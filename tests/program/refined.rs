//! `thurible render --scale`: finer pictures of a result, and what it refuses.

use crate::lines::{FLOW, rendered};
use crate::render::{DEEP, FLAT, png, solved};
use crate::support::npz::npy;
use crate::support::{fresh_folder, run, text};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The fields of the events with this name.
fn events(said: &str, name: &str) -> Vec<Value> {
    let lines = said
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter(|event| event["event"] == name).collect()
}

#[test]
fn finer_cells_show_the_same_smoke_in_the_memory_of_a_step() {
    let result = solved("refined_flat", FLOW);
    let mut bytes = Vec::new();
    for (scale, name) in [("2", "two"), ("4", "four")] {
        let (ended, _) = rendered(&result, name, &["--scale", scale, "--json", "--threads", "2"]);
        let finer = events(&ended.out, "finer");
        let by: u64 = scale.parse().unwrap();
        assert_eq!(finer[0]["cells"], serde_json::json!([24 * by, 16 * by]));
        bytes.push(finer[0]["bytes"].as_u64().unwrap());
        assert_eq!(events(&ended.out, "frame").len(), 7);
        let keyframes = events(&ended.out, "keyframe");
        // The source, drawn with edges as sharp as the finer cells are, and the keyframe.
        assert_eq!(
            keyframes.iter().map(|event| &event["step"]).collect::<Vec<_>>(),
            [0, 6]
        );
        for event in keyframes {
            let apart = event["relative_l2"].as_f64().unwrap();
            assert!(apart > 0.0 && apart < 0.3, "scale {scale}: {event}");
        }
    }
    // Four times the cells take about four times as much, and so do more steps: nothing.
    assert!(bytes[1] < 4 * bytes[0] && bytes[1] > 2 * bytes[0], "{bytes:?}");
    let longer = solved("refined_longer", &FLOW.replace("steps = 6", "steps = 9"));
    let (ended, _) = rendered(
        &longer,
        "two",
        &["--scale", "2", "--json", "--threads", "2", "--steps", "1"],
    );
    assert_eq!(
        events(&ended.out, "finer")[0]["bytes"].as_u64().unwrap(),
        bytes[0]
    );
}

#[test]
fn finer_pictures_are_the_same_for_any_threads_and_steps() {
    let result = solved("refined_threads", DEEP);
    let options = ["--scale", "2", "--size", "96x54"];
    let (ended, one) = rendered(&result, "one", &[&options[..], &["--threads", "1"]].concat());
    assert!(
        ended.err.contains("on 20 x 16 x 18 cells: ") && ended.err.contains("whatever the number of steps"),
        "{}",
        ended.err
    );
    assert!(
        ended.err.contains("step 3: the smoke of the finer cells is"),
        "{}",
        ended.err
    );
    let (_, three) = rendered(&result, "three", &[&options[..], &["--threads", "3"]].concat());
    let (ended, last) = rendered(&result, "last", &[&options[..], &["--steps", "3"]].concat());
    assert!(
        ended.err.contains("   2/3 smoke carried to step 2")
            && ended.err.contains("   3/3 step 3, 0.0 s left"),
        "{}",
        ended.err
    );
    let read = |folder: &Path, step: usize| fs::read(folder.join(format!("frame_{step:04}.png"))).unwrap();
    for step in 0..4 {
        assert_eq!(read(&one, step), read(&three, step), "step {step}");
    }
    assert_eq!(read(&one, 3), read(&last, 3));
    let (_, coarse) = rendered(&result, "coarse", &["--size", "96x54", "--steps", "3"]);
    assert_ne!(read(&coarse, 3), read(&one, 3));
    let (_, plain) = rendered(
        &result,
        "plain",
        &[&options[..], &["--steps", "3", "--detail", "0"]].concat(),
    );
    assert_ne!(read(&plain, 3), read(&one, 3), "detail goes with it");
}

#[test]
fn a_finer_picture_has_edges_as_sharp_as_its_cells() {
    // What the command line changed is drawn again too.
    let folder = fresh_folder("refined_edges");
    let (scene, result) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&scene, FLAT).unwrap();
    let set = [
        "--set",
        "grid.cells=[12, 8]",
        "--set",
        "source.circle.radius=0.18",
    ];
    let ended = run(&[&["solve", text(&scene), "--quiet", "-o", text(&result)], &set[..]].concat());
    assert!(ended.code == 0 || ended.code == 5, "{}", ended.err);
    let size = ["--size", "768x512", "--steps", "0", "--quiet"];
    let soft = |folder: &Path| {
        let (_, _, bytes) = png(&folder.join("frame_0000.png"));
        bytes
            .chunks(3)
            .filter(|pixel| (60..200).contains(&pixel[0]))
            .count()
    };
    let (_, coarse) = rendered(&result, "coarse", &size);
    let (_, fine) = rendered(&result, "fine", &[&size[..], &["--scale", "8"]].concat());
    let [coarse, fine] = [soft(&coarse), soft(&fine)];
    assert!(fine < coarse * 2 / 3, "{fine} of {coarse}");
}

#[test]
fn a_result_that_does_not_begin_with_its_source_begins_with_its_first_density() {
    let result = solved("refined_from", FLOW);
    let on = result.with_file_name("on");
    let scene = result.with_file_name("scene.toml");
    let arguments = [
        "simulate",
        text(&scene),
        "--from",
        text(&result),
        "--quiet",
        "-o",
        text(&on),
    ];
    let ended = run(&[&arguments[..], &["--precision", "f32"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.err);
    let (ended, _) = rendered(&on, "on_pictures", &["--scale", "2"]);
    assert!(
        ended
            .err
            .contains("the result does not begin with the source of its scene"),
        "{}",
        ended.err
    );
}

#[test]
fn files_of_shapes_are_found_where_the_scene_was_or_where_it_is_said_to_be() {
    let folder = fresh_folder("refined_files");
    let place = folder.join("place");
    fs::create_dir_all(&place).unwrap();
    let scene = place.join("scene.toml");
    let source = "circle = { center = [0.25, 0.3], radius = 0.15 }\n[[obstacle]]";
    fs::write(&scene, FLAT.replace(source, "file = \"smoke.npy\"\n[[obstacle]]")).unwrap();
    let smoke = |cell: usize| {
        f64::from(u8::from(
            (3..9).contains(&(cell % 24)) && (4..9).contains(&(cell / 24)),
        ))
    };
    let smoke: Vec<f64> = (0..16 * 24).map(smoke).collect();
    fs::write(place.join("smoke.npy"), npy(&[16, 24], &smoke)).unwrap();
    let result = place.join("out");
    let ended = run(&["solve", text(&scene), "--quiet", "-o", text(&result)]);
    assert!(ended.code == 0 || ended.code == 5, "{}", ended.err);
    rendered(&result, "pictures", &["--scale", "2", "--quiet"]);
    // The result goes elsewhere without the files.
    let moved = folder.join("moved/out");
    fs::create_dir_all(folder.join("moved")).unwrap();
    fs::rename(&result, &moved).unwrap();
    let ended = run(&["render", text(&moved), "--scale", "2"]);
    assert_eq!(ended.code, 4, "{}", ended.err);
    assert!(
        ended.err.contains("smoke.npy") && ended.err.contains("cannot be read"),
        "{}",
        ended.err
    );
    rendered(
        &moved,
        "pictures",
        &["--scale", "2", "--quiet", "--scene", text(&scene)],
    );
}

#[test]
fn what_cannot_be_finer_is_refused_with_a_sentence() {
    let result = solved("refined_refused", FLOW);
    let refused = |folder: &Path, more: &[&str], code: i32, words: &str| {
        let ended = run(&[&["render", text(folder)], more].concat());
        assert_eq!(ended.code, code, "{more:?}: {}", ended.err);
        assert!(ended.err.contains(words), "{more:?}: {}", ended.err);
    };
    refused(
        &result,
        &["--scale", "3"],
        2,
        "found \"3\", allowed are 2, 4 and 8",
    );
    refused(&result, &["--scene", "scene.toml"], 2, "--scale");
    refused(
        &result,
        &["--scale", "8", "--size", "100x100"],
        2,
        "there are 192 x 128 cells",
    );
    refused(
        &result,
        &["--scale", "8", "--memory-limit", "1MiB"],
        3,
        "--scale 8: 192 x 128 cells take ",
    );
    // A report that says less than it should.
    let report = result.join("report.json");
    let whole = fs::read_to_string(&report).unwrap();
    let change = |key: &str, value: Value| {
        let mut facts: Value = serde_json::from_str(&whole).unwrap();
        facts[key] = value;
        fs::write(&report, facts.to_string()).unwrap();
    };
    change("scene", Value::Null);
    refused(&result, &["--scale", "2"], 2, "holds no scene");
    change("overrides", serde_json::json!(["time.steps=5"]));
    refused(
        &result,
        &["--scale", "2"],
        2,
        "holds a scene of other cells or steps",
    );
    change(
        "overrides",
        serde_json::json!(["method.name=\"pd\"", "method.pd.gathering=0.01"]),
    );
    rendered(&result, "not_pd", &["--scale", "2", "--quiet"]);
    let mut facts: Value = serde_json::from_str(&fs::read_to_string(&report).unwrap()).unwrap();
    facts["method"] = "pd".into();
    fs::write(&report, facts.to_string()).unwrap();
    refused(
        &result,
        &["--scale", "2"],
        2,
        "smoke was gathered (method.pd.gathering)",
    );
    fs::write(&report, &whole).unwrap();
    without_velocity(&result.join("result.npz"));
    refused(&result, &["--scale", "2"], 2, "has no velocity");
    refused(&result, &["--streaklines"], 2, "has no velocity");
    rendered(&result, "coarse", &["--quiet"]);
}

/// Renames the arrays of the velocity in an archive, byte by byte.
fn without_velocity(archive: &Path) {
    let mut bytes = fs::read(archive).unwrap();
    let (name, other) = (b"velocity_x.npy", b"velocite_x.npy");
    let mut at = 0;
    let mut found = 0;
    while let Some(next) = bytes[at..].windows(name.len()).position(|window| window == name) {
        at += next;
        bytes[at..at + name.len()].copy_from_slice(other);
        found += 1;
    }
    assert_eq!(found, 2, "its head and its place in the directory");
    fs::write(archive, bytes).unwrap();
}

#[test]
fn lines_are_drawn_over_finer_smoke() {
    let result = solved("refined_lines", FLOW);
    let options = ["--scale", "2", "--size", "480x320", "--steps", "5", "--quiet"];
    let (_, plain) = rendered(&result, "plain", &options);
    let lines = ["--arrows", "velocity", "--streaklines"];
    let (_, over) = rendered(&result, "over", &[&options[..], &lines].concat());
    let read = |folder: &Path| png(&folder.join("frame_0005.png")).2;
    assert_ne!(read(&plain), read(&over));
}

/// The files of a scene that lies beside the folder of results are found again, or the user hears which option names the scene.
#[test]
fn a_scene_beside_the_results_is_found_again() {
    let folder = crate::checkpoints::folder_with("refined_beside", crate::checkpoints::PLAIN);
    let (scenes, elsewhere) = (folder.join("scenes"), folder.join("elsewhere"));
    fs::create_dir(&scenes).unwrap();
    for name in ["scene.toml", "source.npy"] {
        fs::rename(folder.join(name), scenes.join(name)).unwrap();
    }
    let ended = |arguments: &[&str]| crate::checkpoints::ended(&folder, arguments);
    let solved = ended(&["simulate", "scenes/scene.toml", "--quiet", "-o", "out/scene"]);
    assert_eq!(solved.code, 0, "{}", solved.err);
    let render = ["render", "out/scene", "--scale", "2", "--steps", "1", "--quiet"];
    let drawn = ended(&render);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    fs::rename(&scenes, &elsewhere).unwrap();
    let refused = ended(&render);
    assert!(
        refused.code == 4 && refused.err.contains("--scene"),
        "{}",
        refused.err
    );
    let named = ended(&[&render[..], &["--scene", "elsewhere/scene.toml"]].concat());
    assert_eq!(named.code, 0, "{}", named.err);
}
