//! Inputs that people really have, as they had them (`cases/`): read, or refused by a sentence that helps.

use super::support::{Ended, fresh_folder, run};
use std::fs;
use std::path::Path;

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
