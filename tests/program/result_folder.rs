//! What is the user's in a result folder stays, and a result always finds a place.

use crate::support::endless::Endless;
use crate::support::{Ended, fresh_folder, run, thurible};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

const SCENE: &str = "\
[grid]
cells = [12, 12]
[time]
steps = 4
[source]
circle = { center = [0.4, 0.5], radius = 0.25 }
[[keyframe]]
step = 4
circle = { center = [0.6, 0.5], radius = 0.25 }
[method]
name = \"admm\"
iterations = 1
[method.admm]
density_tolerance = 1e-12
";

/// Writes the scene into `folder` and returns its path.
fn scene(folder: &Path) -> String {
    let path = folder.join("scene.toml");
    fs::write(&path, SCENE).unwrap();
    path.to_str().unwrap().into()
}

fn solve(scene: &str, out: &Path, more: &[&str]) -> Ended {
    run(&[
        &["solve", scene, "--quiet", "--force", "-o", out.to_str().unwrap()],
        more,
    ]
    .concat())
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

const RESULT: [&str; 6] = [
    "animation.png",
    "frames",
    "manifest.json",
    "report.html",
    "report.json",
    "result.npz",
];

#[test]
fn files_among_frames_stay() {
    let folder = fresh_folder("files_among_frames");
    let (scene, out) = (scene(&folder), folder.join("out"));
    assert_eq!(solve(&scene, &out, &[]).code, 0);
    assert_eq!(names(&out), RESULT);
    assert_eq!(names(&out.join("frames")).len(), 5);
    for name in ["comp.exr", "frame_0002.png.bak"] {
        fs::write(out.join("frames").join(name), "mine").unwrap();
    }
    let ended = solve(
        &scene,
        &out,
        &["--set", "time.steps=3", "--set", "keyframe[0].step=3"],
    );
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let frames: Vec<String> = (0..=3).map(|step| format!("frame_{step:04}.png")).collect();
    let mut expected = vec!["comp.exr".to_string(), "frame_0002.png.bak".into()];
    expected.extend(frames);
    expected.sort();
    assert_eq!(names(&out.join("frames")), expected);
    assert_eq!(solve(&scene, &out, &["--set", "output.frames=false"]).err, "");
    assert_eq!(names(&out.join("frames")), ["comp.exr", "frame_0002.png.bak"]);
    assert!(!out.join("animation.png").exists());
}

/// A result of a version that kept no list is known by the names of its files.
#[test]
fn a_result_without_a_manifest_is_replaced() {
    let folder = fresh_folder("no_manifest");
    let (scene, out) = (scene(&folder), folder.join("out"));
    assert_eq!(solve(&scene, &out, &[]).code, 0);
    fs::remove_file(out.join("manifest.json")).unwrap();
    fs::write(out.join("frames/comp.exr"), "mine").unwrap();
    assert_eq!(solve(&scene, &out, &["--set", "output.frames=false"]).err, "");
    assert_eq!(names(&out.join("frames")), ["comp.exr"]);
}

#[test]
fn a_folder_filled_meanwhile_keeps_what_it_holds() {
    let folder = fresh_folder("filled_meanwhile");
    let (scene, out) = (scene(&folder), folder.join("out"));
    let running = Endless::solving(&scene, &out);
    fs::create_dir_all(out.join("frames")).unwrap();
    fs::write(out.join("frames/shot.exr"), "mine").unwrap();
    let ended = running.stop();
    assert_eq!(ended.code, 130, "{}", ended.err);
    assert_eq!(names(&out), RESULT);
    assert_eq!(names(&out.join("frames")).len(), 6);
    assert_eq!(fs::read_to_string(out.join("frames/shot.exr")).unwrap(), "mine");
}

#[test]
fn a_result_gives_way_to_what_is_there_meanwhile() {
    let folder = fresh_folder("gives_way");
    let (scene, out, other) = (scene(&folder), folder.join("out"), folder.join("out.1"));
    let running = Endless::solving(&scene, &out);
    fs::create_dir_all(out.join("frames")).unwrap();
    fs::write(out.join("frames/frame_0003.png"), "mine").unwrap();
    let ended = running.stop();
    assert_eq!(ended.code, 4, "{}", ended.err);
    let sentence = "out/frames/frame_0003.png is there and was not written by thurible, so the result is in";
    assert!(
        ended.err.contains(sentence) && ended.err.contains(other.to_str().unwrap()),
        "{}",
        ended.err
    );
    assert!(
        ended.out.contains("\"exit_code\":4") && ended.out.contains(other.to_str().unwrap()),
        "{}",
        ended.out
    );
    assert_eq!(
        fs::read_to_string(out.join("frames/frame_0003.png")).unwrap(),
        "mine"
    );
    assert_eq!(
        (names(&out), names(&other)),
        (vec!["frames".to_string()], RESULT.map(String::from).to_vec())
    );
    // So does the file of an earlier result that was changed after the solve began.
    let running = Endless::solving(&scene, &other);
    fs::write(other.join("report.html"), "my notes").unwrap();
    let ended = running.stop();
    assert!(
        ended.code == 4 && ended.err.contains("out.1/report.html is there"),
        "{}",
        ended.err
    );
    assert_eq!(fs::read_to_string(other.join("report.html")).unwrap(), "my notes");
    assert_eq!(names(&folder.join("out.1.1")), RESULT);
}

#[test]
fn a_result_whose_folder_vanished_goes_to_the_temporary_one() {
    let folder = fresh_folder("vanished");
    let (scene, disc, spare) = (scene(&folder), folder.join("disc"), folder.join("spare"));
    fs::create_dir(&spare).unwrap();
    let mut command = thurible();
    command.args(["solve", &scene, "-o", disc.join("out").to_str().unwrap()]);
    let running = Endless::begin(command.env("TMPDIR", &spare));
    fs::rename(&disc, folder.join("unmounted")).unwrap();
    let ended = running.stop();
    let place = spare.join("out.1");
    assert!(
        ended.code == 4 && ended.err.contains(place.to_str().unwrap()),
        "{}: {}",
        ended.code,
        ended.err
    );
    assert_eq!(names(&place), RESULT);
    assert!(!disc.exists());
}

#[test]
fn what_cannot_be_written_is_refused_before_the_solve() {
    let folder = fresh_folder("cannot_be_written");
    let (scene, out) = (scene(&folder), folder.join("out"));
    let refused = |out: &Path, words: &[&str]| {
        let ended = run(&["solve", &scene, "--json", "--force", "-o", out.to_str().unwrap()]);
        assert_eq!((ended.code, ended.out.as_str()), (4, ""), "{}", ended.err);
        assert!(words.iter().all(|word| ended.err.contains(word)), "{}", ended.err);
        assert_eq!(ended.err.lines().count(), 1);
    };
    symlink("/not/mounted", folder.join("nowhere")).unwrap();
    for place in ["nowhere", "nowhere/below"] {
        refused(&folder.join(place), &["is a link to /not/mounted", "-o DIR"]);
    }
    assert_eq!(solve(&scene, &out, &["--set", "output.frames=false"]).code, 0);
    fs::write(out.join("animation.png"), "mine").unwrap();
    refused(
        &out,
        &["animation.png is there and was not written by thurible", "-o DIR"],
    );
    fs::remove_file(out.join("animation.png")).unwrap();
    symlink(&folder, out.join("frames")).unwrap();
    refused(&out, &["out/frames is there and was not written by thurible"]);
    fs::remove_file(out.join("frames")).unwrap();
    // A folder that is ours, but cannot be written to; nothing is beyond root.
    assert_eq!(solve(&scene, &out, &[]).code, 0);
    let closed = out.join("frames");
    let mode = |mode: &str| {
        assert!(
            Command::new("chmod")
                .arg(mode)
                .arg(&closed)
                .status()
                .unwrap()
                .success()
        )
    };
    mode("555");
    if fs::write(closed.join("probe"), "").is_err() {
        refused(&out, &["cannot write", "-o DIR"]);
    }
    mode("755");
}

/// `new/..` is the folder that `new` would be in.
#[test]
fn a_path_that_leads_back_is_followed_before_anything_is_made() {
    let folder = fresh_folder("leads_back");
    let scene = scene(&folder);
    fs::create_dir(folder.join("frames")).unwrap();
    fs::write(folder.join("frames/mine.exr"), "mine").unwrap();
    fs::write(folder.join("result.npz"), "mine").unwrap();
    let before = names(&folder);
    let mut command = thurible();
    command
        .args(["solve", &scene, "-o", "new/.."])
        .current_dir(&folder);
    let ended = Ended::from(command.output().unwrap());
    assert_eq!(ended.code, 4, "{}", ended.err);
    assert!(ended.err.contains("is not overwritten"), "{}", ended.err);
    assert_eq!(names(&folder), before);
    assert!(folder.join("frames/mine.exr").exists());
}

#[test]
fn paths_are_shown_without_detours() {
    let folder = fresh_folder("detours");
    fs::create_dir(folder.join("scenes")).unwrap();
    fs::write(
        folder.join("scenes/scene.toml"),
        format!("{SCENE}[output]\nfolder = \"../out/letter\"\n"),
    )
    .unwrap();
    let mut command = thurible();
    command.args(["solve", "scenes/scene.toml"]).current_dir(&folder);
    let ended = Ended::from(command.output().unwrap());
    assert_eq!(ended.code, 0, "{}", ended.err);
    let last = ended.out.lines().last().unwrap();
    assert_eq!(last, "result in out/letter; open out/letter/report.html");
    // Where a part of the path is a link, to leave `..` out would lead elsewhere.
    fs::create_dir_all(folder.join("far/away")).unwrap();
    symlink("far/away", folder.join("link")).unwrap();
    let mut command = thurible();
    command
        .args(["solve", "scenes/scene.toml", "-o", "link/../out"])
        .current_dir(&folder);
    let ended = Ended::from(command.output().unwrap());
    assert_eq!(ended.code, 0, "{}", ended.err);
    let place = fs::canonicalize(&folder).unwrap().join("far/out");
    assert!(place.join("result.npz").exists());
    assert!(ended.out.contains(place.to_str().unwrap()), "{}", ended.out);
}

#[test]
fn pages_leave_what_is_not_theirs() {
    let folder = fresh_folder("pages");
    let (scene, out) = (scene(&folder), folder.join("out"));
    let compare = |more: &[&str]| {
        let out = out.to_str().unwrap();
        let command = ["compare", &scene, "--methods", "direct", "--quiet", "-o", out];
        run(&[&command, more].concat())
    };
    assert_eq!(compare(&[]).code, 0);
    // A page is not written over, and neither is a result below what was ended before it had one.
    let report = fs::read(out.join("direct/report.json")).unwrap();
    let ended = compare(&[]);
    assert!(
        ended.code == 4 && ended.err.contains("holds a page already, compare.html"),
        "{}",
        ended.err
    );
    fs::write(out.join("compare.json"), "{\"format\":1}").unwrap();
    let ended = compare(&[]);
    assert!(
        ended.code == 4 && ended.err.contains("direct holds a result already"),
        "{}",
        ended.err
    );
    assert_eq!(fs::read(out.join("direct/report.json")).unwrap(), report);
    for place in ["compare_pictures/mine.png", "direct/frames/mine.png"] {
        fs::write(out.join(place), "mine").unwrap();
    }
    let ended = compare(&["--force"]);
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    for place in ["compare_pictures/mine.png", "direct/frames/mine.png"] {
        assert_eq!(fs::read_to_string(out.join(place)).unwrap(), "mine");
    }
    fs::write(out.join("direct/manifest.json"), "mine").unwrap();
    let ended = compare(&["--force"]);
    assert!(
        ended.code == 4 && ended.err.contains("direct/manifest.json is there"),
        "{}",
        ended.err
    );
}
