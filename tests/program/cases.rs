//! Inputs that people really have, as they had them (`cases/`): read, or refused by a sentence that helps.

use super::support::{Ended, fresh_folder, run};
use std::fs;
use std::path::{Path, PathBuf};

/// A scene of 24 x 24 cells with this source and these keyframes, beside the file `case`; what became of it.
fn solved(test: &str, case: &str, [source, keyframe]: [&str; 2]) -> Ended {
    let folder = fresh_folder(&format!("case_{test}"));
    let given = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/cases");
    if !case.is_empty() {
        fs::copy(given.join(case), folder.join(case)).unwrap();
    }
    let text = format!(
        "[grid]\ncells = [24, 24]\n[time]\nsteps = 6\n[source]\n{source}\n[[keyframe]]\n{keyframe}\n[method]\niterations = 1\n[output]\nframes = false\n"
    );
    let scene = folder.join("scene.toml");
    fs::write(&scene, text).unwrap();
    run(&["solve", scene.to_str().unwrap()])
}

const CIRCLE: &str = "circle = { center = [0.5, 0.5], radius = 0.25 }";

fn ends_well(test: &str, case: &str, source: &str, keyframe: &str) -> Ended {
    let ended = solved(test, case, [source, keyframe]);
    assert!(
        matches!(ended.code, 0 | 5),
        "{test}: {} {}",
        ended.code,
        ended.err
    );
    ended
}

#[test]
fn arrays_as_people_have_them() {
    for case in ["sole_array.npz", "half_precision.npy", "one_channel.npy"] {
        ends_well(case, case, CIRCLE, &format!("step = 6\nfile = \"{case}\""));
    }
    for case in ["own_output.npy", "header_of_python_2.npy"] {
        ends_well(
            case,
            case,
            &format!("file = \"{case}\""),
            &format!("step = 6\n{CIRCLE}"),
        );
    }
    let named = "file = \"member_without_extension.npz\"\nname = \"density\"";
    ends_well(
        "member",
        "member_without_extension.npz",
        named,
        &format!("step = 6\n{CIRCLE}"),
    );
}

#[test]
fn a_density_for_every_frame_gives_those_at_the_steps() {
    let case = "density_sequence.npz";
    let keyframe = format!("steps = {{ from = 2, every = 2 }}\nfile = \"{case}\"");
    let ended = ends_well("sequence", case, CIRCLE, &keyframe);
    assert!(!ended.err.contains("thurible:"), "{}", ended.err);
}

#[test]
fn pictures_as_people_have_them() {
    for case in ["jpeg.jpg", "one_clear_pixel.png", "sixteen_bits.png"] {
        ends_well(case, case, CIRCLE, &format!("step = 6\nimage = \"{case}\""));
    }
    let ended = ends_well(
        "ink",
        "ink_on_paper.png",
        CIRCLE,
        "step = 6\nimage = \"ink_on_paper.png\"",
    );
    assert!(ended.err.contains("ink = \"dark\""), "{}", ended.err);
}

#[test]
fn what_cannot_be_read_says_why() {
    let of = |case: &str| format!("file = \"{case}\"\nname = \"density\"");
    for (case, words) in [
        (
            "damaged_archive.npz",
            ["`density` that is damaged", "save it again"],
        ),
        (
            "other_compression.npz",
            ["packed in an unknown way", "numpy.savez_compressed"],
        ),
    ] {
        let ended = solved(case, case, [&of(case), &format!("step = 6\n{CIRCLE}")]);
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(words.iter().all(|word| ended.err.contains(word)), "{}", ended.err);
    }
    let ended = solved("step_1", "", [CIRCLE, &format!("step = 1\n{CIRCLE}")]);
    assert_eq!(ended.code, 2);
    assert!(
        ended.err.contains("the initial velocity alone decides") && ended.err.contains("begin at 2"),
        "{}",
        ended.err
    );
}

#[test]
fn texts_as_people_have_them() {
    ends_well(
        "hebrew",
        "",
        CIRCLE,
        "step = 6\ntext = \"\u{5e9}\u{5dc}\u{5d5}\u{5dd}\"",
    );
    ends_well("heart", "", CIRCLE, "step = 6\ntext = \"\u{2764}\u{fe0f}\"");
}

/// The scene of plain commands, in a folder of its own.
fn plain(test: &str) -> (PathBuf, String) {
    let folder = fresh_folder(&format!("case_{test}"));
    let scene = folder.join("scene.toml");
    let text = format!(
        "[grid]\ncells = [16, 16]\n[time]\nsteps = 4\n[source]\n{CIRCLE}\n[[keyframe]]\nstep = 4\ntext = \"F\"\n[method]\niterations = 2\n[output]\nframes = false\n"
    );
    fs::write(&scene, text).unwrap();
    (folder, scene.to_str().unwrap().to_owned())
}

/// What cannot be printed is not printed in silence.
#[test]
#[cfg(target_os = "linux")]
fn what_cannot_be_printed_is_told() {
    use super::support::thurible;
    let (_, scene) = plain("full");
    for arguments in [
        &["plan", &scene][..],
        &["plan", &scene, "--json"],
        &["--help"],
        &["--version"],
    ] {
        let full = fs::File::create("/dev/full").unwrap();
        let ended = Ended::from(thurible().args(arguments).stdout(full).output().unwrap());
        assert_eq!(ended.code, 4, "{arguments:?}: {}", ended.err);
        assert!(ended.err.contains("what was printed is lost"), "{}", ended.err);
    }
}

/// Names of results: as long as a system takes, and what only a shell understands.
#[test]
fn names_of_results() {
    let (folder, scene) = plain("names");
    let long = folder.join("a".repeat(240));
    for force in [&[][..], &["--force"]] {
        let common = ["solve", &scene, "--quiet", "-o", long.to_str().unwrap()];
        let ended = run(&[&common[..], force].concat());
        assert!([0, 5].contains(&ended.code), "{}", ended.err);
        assert!(long.join("result.npz").is_file());
    }
    assert_eq!(
        fs::read_dir(&folder).unwrap().count(),
        2,
        "nothing is left behind"
    );
    for home in [["--set", "output.folder=\"~/x\""], ["-o", "~/x"]] {
        let ended = run(&[&["solve", &scene, "--quiet"][..], &home].concat());
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(ended.err.contains("only a shell"), "{}", ended.err);
    }
}

/// A file that grows beyond what the shell allows ends the program by a sentence, not by a signal; what it began is gone.
#[test]
#[cfg(unix)]
fn files_that_may_not_grow() {
    use super::support::with_short_files;
    let (folder, scene) = plain("grown");
    let out = folder.join("out");
    let new = folder.join("new");
    let solve = [
        "solve",
        &scene,
        "--set",
        "grid.cells=[64,64]",
        "--set",
        "time.steps=20",
        "-o",
        out.to_str().unwrap(),
    ];
    let made = ["new", new.to_str().unwrap()];
    for (blocks, arguments) in [(50, &solve[..]), (0, &made)] {
        let ended = Ended::from(with_short_files(blocks).args(arguments).output().unwrap());
        assert_eq!(ended.code, 4, "{arguments:?}: {}", ended.err);
        assert!(ended.err.contains("File too large"), "{}", ended.err);
    }
    assert!(!out.exists() && !folder.join("new.toml").exists());
}

/// A scene that has the mark by which code ends on a page stays code to its end.
#[test]
fn a_fence_in_a_scene() {
    let (folder, scene) = plain("fence");
    let text = fs::read_to_string(&scene).unwrap() + "folder = '''out\n````\n# No heading\n'''\n";
    fs::write(&scene, &text).unwrap();
    let page = folder.join("page");
    let ended = run(&[
        "compare",
        &scene,
        "--methods",
        "direct,pd",
        "--quiet",
        "-o",
        page.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let page = fs::read_to_string(page.join("compare.md")).unwrap();
    assert!(
        page.contains(&format!("`````\n{}\n`````\n", text.trim_end())),
        "{page}"
    );
}
