//! `thurible scene check`: one picture, the masses, and a warning for each thing that is probably not meant.

use super::support::{fresh_folder, run};
use std::fs;

const HEAD: &str = "[grid]\ncells = [32, 32]\n[time]\nsteps = 4\n[advection]\nscheme = \"limited\"\n";

/// What is said of a scene with these lines; its picture is a PNG file.
fn said(test: &str, lines: &str) -> [String; 2] {
    let folder = fresh_folder(&format!("scene_check_{test}"));
    let (scene, picture) = (folder.join("scene.toml"), folder.join("seen.png"));
    fs::write(&scene, format!("{HEAD}{lines}")).unwrap();
    let ended = run(&[
        "scene",
        "check",
        scene.to_str().unwrap(),
        "-o",
        picture.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(&picture).unwrap()));
    let reader = decoder.read_info().unwrap();
    assert!(reader.info().width > 300 && reader.info().height > 300);
    [ended.out, ended.err]
}

fn ball(x: f64, y: f64, radius: f64) -> String {
    format!("circle = {{ center = [{x}, {y}], radius = {radius} }}\n")
}

/// What lies in an obstacle counts for no mass and is nothing that has to be reached.
#[test]
fn what_obstacles_take_is_lost() {
    let obstacle =
        |low: [f64; 2], high: [f64; 2]| format!("[[obstacle]]\nbox = {{ min = {low:?}, max = {high:?} }}\n");
    let (source, target) = (ball(0.3, 0.3, 0.15), ball(0.5, 0.4, 0.15));
    let wall = obstacle([0.45, 0.2], [0.5, 0.6]);
    let [_, err] = said(
        "wall_in_target",
        &format!("[source]\n{source}{wall}[[keyframe]]\nstep = 4\n{target}"),
    );
    assert!(
        err.contains("lies inside an obstacle") && !err.contains("cannot be reached"),
        "{err}"
    );
    let wall = obstacle([0.0, 0.0], [0.3, 0.6]);
    let [_, err] = said(
        "wall_in_source",
        &format!("[source]\n{source}{wall}[[keyframe]]\nstep = 4\n{target}[control]\nmatch_mass = false\n"),
    );
    assert!(err.contains("it cannot be met"), "{err}");
}

#[test]
fn a_scene_in_order_is_drawn_without_a_warning() {
    let (source, target) = (ball(0.3, 0.5, 0.15), ball(0.5, 0.5, 0.15));
    let [out, err] = said(
        "good",
        &format!("[source]\n{source}[[keyframe]]\nstep = 4\n{target}"),
    );
    assert!(!err.contains("warning"), "{err}");
    // pi r^2, with an edge as wide inside as outside.
    let mass: f64 = out
        .lines()
        .find(|line| line.contains("source"))
        .unwrap()
        .split_whitespace()
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!((mass - 0.0734).abs() < 0.002, "{out}");
    assert!(out.contains("keyframe[0], step 4"), "{out}");
}

/// Neither the scene itself nor anything else that is no picture is drawn over; an earlier picture is.
#[test]
fn nothing_but_a_picture_is_drawn_over() {
    let folder = fresh_folder("scene_check_over");
    let scene = folder.join("scene.toml");
    let ball = ball(0.5, 0.5, 0.2);
    let text = format!("{HEAD}[source]\n{ball}[[keyframe]]\nstep = 4\n{ball}");
    fs::write(&scene, &text).unwrap();
    let checked = |over: &std::path::Path| {
        run(&[
            "scene",
            "check",
            scene.to_str().unwrap(),
            "-o",
            over.to_str().unwrap(),
        ])
    };
    let refused = checked(&scene);
    assert!(
        refused.code == 4 && refused.err.contains("is there and is no PNG"),
        "{}",
        refused.err
    );
    assert_eq!(fs::read_to_string(&scene).unwrap(), text);
    let picture = folder.join("seen.png");
    assert!(checked(&picture).code == 0 && checked(&picture).code == 0);
    let over = ["schema", "-o", picture.to_str().unwrap()];
    assert!(run(&over).err.contains("is no JSON schema"));
    let schema = folder.join("schema.json");
    let again = ["schema", "-o", schema.to_str().unwrap()];
    assert!(run(&again).code == 0 && run(&again).code == 0);
}

/// In 3D, with a mask and a region, as lines of JSON.
#[test]
fn a_box_in_3d_is_drawn_and_told_of_in_json() {
    let folder = fresh_folder("scene_check_deep");
    let (scene, picture) = (folder.join("scene.toml"), folder.join("seen.png"));
    let sphere =
        |x: f64, radius: f64| format!("sphere = {{ center = [{x}, 0.25, 0.25], radius = {radius} }}");
    let text = [
        "[grid]\ncells = [32, 16, 16]\n[time]\nsteps = 2\n",
        &format!("[source]\n{}\n", sphere(0.2, 0.15)),
        &format!("[control]\nmask = {{ {} }}\n", sphere(0.5, 0.2)),
        &format!("[[keyframe]]\nstep = 2\n{}\n", sphere(0.8, 0.15)),
        &format!("region = {{ {} }}\n", sphere(0.8, 0.2)),
    ]
    .concat();
    fs::write(&scene, text).unwrap();
    let [scene, picture] = [&scene, &picture].map(|path| path.to_str().unwrap());
    let ended = run(&["scene", "check", scene, "--json", "-o", picture]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.is_empty(), "{}", ended.err);
    let events: Vec<serde_json::Value> = ended
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let keys: Vec<&str> = events.iter().filter_map(|event| event["key"].as_str()).collect();
    assert_eq!(
        keys,
        ["source", "keyframe[0]", "keyframe[0].region", "control.mask"]
    );
    let mass = events[3]["mass"].as_f64().unwrap();
    assert!(
        (mass - 0.0335).abs() < 0.003,
        "4/3 pi r^3 of the mask, and not {mass}"
    );
    let warned = |words: &str| {
        let of_warning = |event: &&serde_json::Value| event["event"] == "warning";
        let mut said = events.iter().filter(of_warning);
        said.any(|event| event["message"].as_str().unwrap().contains(words))
    };
    assert!(warned("cannot be reached"), "{events:?}");
    assert_eq!(events.last().unwrap()["file"], picture);
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(picture).unwrap()));
    assert!(decoder.read_info().unwrap().info().width > 300);
}

#[test]
fn what_is_probably_not_meant_is_said() {
    let (source, far) = (ball(0.15, 0.5, 0.1), ball(0.85, 0.5, 0.1));
    let scene =
        |more: &str, target: &str| format!("{more}[source]\n{source}[[keyframe]]\nstep = 2\n{target}");
    let [_, err] = said("far", &scene("", &far));
    assert!(
        err.contains("cannot be reached") && err.contains("farther than 5 cells"),
        "{err}"
    );
    // What is too far away does not matter.
    let both = format!(
        "shapes = [{{ {} }}, {{ {} }}]",
        ball(0.85, 0.5, 0.1).trim(),
        ball(0.2, 0.5, 0.1).trim()
    );
    let [_, err] = said("far_of_two", &scene("", &both));
    assert!(err.contains("cannot be reached"), "{err}");
    let here = format!("{both}\nregion = {{ box = {{ min = [0.0, 0.0], max = [0.5, 1.0] }} }}\n");
    let [out, err] = said("far_outside", &scene("", &here));
    assert!(
        !err.contains("cannot be reached") && out.contains("keyframe[0].region"),
        "{err}"
    );
    let large = ball(0.3, 0.5, 0.2);
    let [_, err] = said("masses", &scene("[control]\nmatch_mass = false\n", &large));
    assert!(err.contains("times the mass of the source"), "{err}");
    // What a rate adds until then counts, and nobody knows what a target adds.
    let emits = |what: &str| format!("[[emitter]]\n{what}\n{source}");
    let near = ball(0.2, 0.5, 0.1);
    let [_, err] = said("masses_rate", &scene(&emits("rate = 1.0"), &near));
    assert!(
        err.contains("has 0.33 times the mass of source and emitters by then"),
        "{err}"
    );
    let [_, err] = said("masses_target", &scene(&emits("target = 1.0"), &near));
    assert!(!err.contains("times the mass"), "{err}");
    let side = ball(0.02, 0.5, 0.12);
    let [_, err] = said("side", &scene("", &side));
    assert!(err.contains("touches the low side along x"), "{err}");
    let wall = "[[obstacle]]\nbox = { min = [0.45, 0.0], max = [0.55, 1.0] }\n";
    let target = ball(0.62, 0.5, 0.06);
    let behind = format!("{wall}[source]\n{source}[[keyframe]]\nstep = 4\n{target}");
    let [_, err] = said("behind", &behind);
    assert!(
        err.contains("cannot be reached: 100 %") && err.contains("on the way around obstacles"),
        "{err}"
    );
    let [_, err] = said("before", &behind.replace(wall, ""));
    assert!(!err.contains("cannot be reached"), "{err}");
    let solid = "[[obstacle]]\nbox = { min = [0.4, 0.3], max = [0.7, 0.7] }\n[[emitter]]\nrate = 0.1\ncircle = { center = [0.5, 0.5], radius = 0.05 }\n";
    let [_, err] = said("solid", &scene(solid, &source));
    assert!(
        err.contains("of emitter[0], steps 0 to 4 lies inside an obstacle"),
        "{err}"
    );
    // Stable Fluids are forced before step 1: there is one step to get there.
    let near = ball(0.2, 0.5, 0.1);
    let early =
        format!("[method]\nname = \"stable_fluids\"\n[source]\n{source}[[keyframe]]\nstep = 1\n{near}");
    let [_, err] = said("early", &early);
    assert!(!err.contains("cannot be reached"), "{err}");
}

/// `simulate` takes a scene without keyframes, so it is drawn; a typist who forgot them is told.
#[test]
fn a_scene_without_keyframes_is_drawn() {
    let [out, err] = said("free", &format!("[source]\n{}", ball(0.5, 0.5, 0.2)));
    assert!(out.contains("source") && out.contains("drawn in"), "{out}");
    assert!(err.contains("there is no keyframe"), "{err}");
}

/// Of many keyframes some are drawn, and everything else; what is said of each is said of a few.
#[test]
fn of_many_keyframes_some_are_drawn_and_the_rest_is_counted() {
    let folder = fresh_folder("scene_check_many");
    let (scene, picture) = (folder.join("scene.toml"), folder.join("seen.png"));
    let mut text = format!(
        "[grid]\ncells = [8, 8]\n[time]\nsteps = 40\n[source]\n{}[control]\nmask = {{ {} }}\n",
        ball(0.5, 0.5, 0.1),
        ball(0.5, 0.5, 0.4).trim()
    );
    for step in 2..=31 {
        text += &format!("[[keyframe]]\nstep = {step}\n{}", ball(0.5, 0.5, 0.3));
    }
    fs::write(&scene, text).unwrap();
    let [scene, picture] = [&scene, &picture].map(|path| path.to_str().unwrap());
    let ended = run(&["scene", "check", scene, "-o", picture]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.out.contains("of 32 layers 24"), "{}", ended.out);
    assert_eq!(ended.err.matches("times the mass of the source").count(), 3);
    assert!(ended.err.contains("so it is with 27 more"), "{}", ended.err);
}
