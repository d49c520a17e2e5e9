//! Keyframes and emitters from many files or one array with time: which files are meant, where they stand, and what is refused.

use super::small::{CIRCLE, SIDE, density, refused};
use super::support::verify::verify;
use super::support::{Ended, fresh_folder, npz::npy, run, text as text_of, thurible};
use std::fs;
use std::path::{Path, PathBuf};

/// A scene of four steps with this keyframe, and two arrays beside it.
fn written(test: &str, keyframe: &str) -> PathBuf {
    let folder = fresh_folder(&format!("sequences_{test}"));
    for number in 0..2 {
        let array = npy(&[SIDE, SIDE], &density());
        fs::write(folder.join(format!("blob_{number}.npy")), array).unwrap();
    }
    let text = format!(
        "[grid]\ncells = [{SIDE}, {SIDE}]\n[time]\nsteps = 4\n[source]\n{CIRCLE}\n[[keyframe]]\n{keyframe}\n"
    );
    fs::write(folder.join("scene.toml"), text).unwrap();
    folder
}

/// What is said of a scene when the program is run in the folder `here`; its picture goes to `folder`.
fn seen(here: &Path, scene: &str, folder: &Path) -> Ended {
    let mut command = thurible();
    command.current_dir(here).args(["scene", "check", scene, "-o"]);
    command.arg(folder.join("seen.png")).output().unwrap().into()
}

/// The scene is drawn, with this layer.
fn assert_stands(folder: &Path, layer: &str) {
    let ended = seen(folder, "scene.toml", folder);
    assert!(ended.code == 0 && ended.out.contains(layer), "{}", ended.err);
}

#[test]
fn files_are_looked_for_beside_the_scene_wherever_the_program_runs() {
    let folder = written(
        "beside",
        "steps = { from = 2, every = 2 }\nfiles = \"blob_*.npy\"",
    );
    let name = folder.file_name().unwrap().to_str().unwrap();
    let from_above = format!("{name}/scene.toml");
    let whole = folder.join("scene.toml");
    for (here, scene) in [
        (folder.as_path(), "scene.toml"),
        (folder.as_path(), "./scene.toml"),
        (folder.parent().unwrap(), from_above.as_str()),
        (Path::new("/"), whole.to_str().unwrap()),
    ] {
        let ended = seen(here, scene, &folder);
        assert_eq!(ended.code, 0, "{scene}: {}", ended.err);
        assert!(
            ended.out.contains("keyframe[0], step 4"),
            "{scene}: {}",
            ended.out
        );
    }
}

/// Of an array with a density for each step of the scene those at the keyframes' steps are taken; of another one, one after the other.
#[test]
fn an_array_of_all_steps_gives_those_that_are_asked_for() {
    let keyframe = "steps = { from = 2, every = 2 }\nfile = \"all.npy\"";
    for (frames, taken) in [(5, [2.0, 4.0]), (2, [0.0, 1.0])] {
        let folder = written(&format!("all_{frames}"), keyframe);
        let values: Vec<f64> = (0..frames)
            .flat_map(|frame| density().into_iter().map(move |x| x * f64::from(frame + 1)))
            .collect();
        let array = npy(&[frames as usize, SIDE, SIDE], &values);
        fs::write(folder.join("all.npy"), array).unwrap();
        let ended = seen(&folder, "scene.toml", &folder);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let mass = |step: usize| -> f64 {
            let title = format!("keyframe[0], step {step}");
            let found = ended.out.lines().find(|line| line.contains(&title));
            let number = found.unwrap().split_whitespace().next().unwrap();
            number.parse().unwrap()
        };
        let ratio = mass(4) / mass(2);
        let expected = (taken[1] + 1.0) / (taken[0] + 1.0);
        assert!((ratio - expected).abs() < 1e-3 * expected, "{frames}: {ratio}");
    }
}

#[test]
fn a_header_that_promises_more_steps_than_there_are_is_refused() {
    let keyframe = "steps = { from = 2, every = 2 }\nfile = \"huge.npy\"";
    let folder = written("huge", keyframe);
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (9000000000000000000, 8, 8), }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    fs::write(folder.join("huge.npy"), bytes).unwrap();
    let ended = seen(&folder, "scene.toml", &folder);
    refused(
        &ended,
        &[
            "`keyframe[0].steps`",
            "put 9000000000000000000 shapes at steps up to",
        ],
    );
}

#[test]
fn keys_that_would_be_passed_over_are_refused() {
    let steps = "steps = { from = 2, every = 2 }";
    for (key, words) in [
        (
            "files = \"blob_*.npy\"\nfile = \"blob_0.npy\"",
            "`keyframe[0].file` stands beside `files`",
        ),
        (
            "files = \"blob_*.npy\"\nimage = \"a.png\"",
            "`keyframe[0].image` stands beside `files`",
        ),
        (
            "files = \"blob_*.npy\"\nmesh = \"a.obj\"",
            "`keyframe[0].mesh` stands beside `files`",
        ),
        ("files = \"*_*.npy\"", "has more than one `*`"),
        (
            "file = \"blob_0.npy\"\nentry = 1",
            "`keyframe[0].entry` stands beside `steps`",
        ),
    ] {
        let folder = written("keys", &format!("{steps}\n{key}"));
        refused(&seen(&folder, "scene.toml", &folder), &[words, "; "]);
    }
}

/// A cached frame that is missing would shift all that come after it.
#[test]
fn a_missing_number_is_refused() {
    let keyframe = "steps = { from = 2, every = 1 }\nfiles = \"blob_*\"";
    let folder = written("gap", keyframe);
    fs::copy(folder.join("blob_0.npy"), folder.join("blob_3.npy")).unwrap();
    let said = [
        "`keyframe[0].files`",
        "number 2 is missing between blob_1.npy and blob_3.npy",
    ];
    refused(&seen(&folder, "scene.toml", &folder), &said);
    fs::rename(folder.join("blob_3.npy"), folder.join("blob_2.npy")).unwrap();
    assert_stands(&folder, "keyframe[0], step 3");
}

/// The first picture says what of all of them is smoke, whatever another one looks like.
#[test]
fn one_ink_is_that_of_all_pictures() {
    let folder = fresh_folder("sequences_ink");
    let picture = |name: &str, grey: [u8; 2]| {
        let pixel = |x: u32, y: u32| match (x + y) % 2 {
            _ if !(4..12).contains(&x) || !(4..12).contains(&y) => image::Rgba([0; 4]),
            parity => {
                let grey = grey[parity as usize];
                image::Rgba([grey, grey, grey, 255])
            }
        };
        image::RgbaImage::from_fn(16, 16, pixel)
            .save(folder.join(name))
            .unwrap();
    };
    // One tone, whose alpha is smoke; then two, of which by itself the light would be.
    picture("puff_0.tif", [128, 128]);
    picture("puff_1.tif", [64, 192]);
    let text = format!(
        "[grid]\ncells = [16, 16]\n[time]\nsteps = 4\n[source]\n{CIRCLE}\n[[keyframe]]\nsteps = {{ from = 2, every = 1 }}\nfiles = \"puff_*.tif\"\n"
    );
    fs::write(folder.join("scene.toml"), text).unwrap();
    let ended = seen(&folder, "scene.toml", &folder);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let mass = |title: &str| {
        let line = ended.out.lines().find(|line| line.ends_with(title));
        line.unwrap().split_whitespace().next().unwrap().to_owned()
    };
    assert_eq!(
        mass("keyframe[0], step 2"),
        mass("keyframe[0], step 3"),
        "{}",
        ended.out
    );
}

/// Nothing says where a file without a number comes, or which of two with the same one is first; hidden files are none of a sequence.
#[test]
fn files_that_nothing_puts_in_order_are_refused() {
    let keyframe = |pattern: &str| format!("steps = {{ from = 2, every = 1 }}\nfiles = \"{pattern}\"");
    for (other, said) in [
        (
            "blob_last.npy",
            "which blob_last.npy fits too, that has no number",
        ),
        ("blob_01.npy", "blob_01.npy and blob_1.npy have the same number"),
    ] {
        let folder = written("order", &keyframe("blob_*.npy"));
        fs::copy(folder.join("blob_0.npy"), folder.join(other)).unwrap();
        refused(
            &seen(&folder, "scene.toml", &folder),
            &["`keyframe[0].files`", said, "; "],
        );
    }
    let folder = written("hidden", &keyframe("in/*.npy"));
    fs::create_dir(folder.join("in")).unwrap();
    for (from, to) in [("blob_0.npy", "in/1.npy"), ("blob_1.npy", "in/2.npy")] {
        fs::copy(folder.join(from), folder.join(to)).unwrap();
    }
    fs::write(folder.join("in/._1.npy"), "what another system keeps").unwrap();
    assert_stands(&folder, "keyframe[0], step 3");
}

/// A shape that is empty is named by its file, and by its entry.
#[test]
fn an_empty_shape_of_a_sequence_is_named() {
    let empty = vec![0.0; SIDE * SIDE];
    for (shapes, said) in [
        ("files = \"blob_*.npy\"", "blob_2.npy` puts nothing into the box;"),
        (
            "file = \"two.npy\"",
            "two.npy` puts nothing into the box by its entry 1;",
        ),
    ] {
        let folder = written("empty", &format!("steps = {{ from = 2, every = 1 }}\n{shapes}"));
        fs::write(folder.join("blob_2.npy"), npy(&[SIDE, SIDE], &empty)).unwrap();
        let two: Vec<f64> = density().into_iter().chain(empty.clone()).collect();
        fs::write(folder.join("two.npy"), npy(&[2, SIDE, SIDE], &two)).unwrap();
        refused(&seen(&folder, "scene.toml", &folder), &["in keyframe[0]", said]);
    }
}

/// Each shape of an emitter adds its smoke until the next one does, and the last one as long as the others, or to the end.
#[test]
fn an_emitter_moves_from_shape_to_shape() {
    let emitter = |steps: &str, shapes: &str| format!("[[emitter]]\nsteps = {steps}\nrate = 0.1\n{shapes}\n");
    let circle = format!("step = 4\n{CIRCLE}\n");
    let many = |name: &str, frames: u32| {
        let folder = written(name, &circle);
        let blob = |frame: u32| density().into_iter().map(move |x| x * f64::from(frame + 1));
        let values: Vec<f64> = (0..frames).flat_map(blob).collect();
        fs::write(
            folder.join("all.npy"),
            npy(&[frames as usize, SIDE, SIDE], &values),
        )
        .unwrap();
        folder
    };
    // What emits in each of the four steps: the number of the shape and one more, or nothing.
    let cases = [
        (
            "{ from = 1, every = 1 }",
            "files = \"blob_*.npy\"",
            [0.0, 1.0, 1.0, 0.0],
        ),
        (
            "{ from = 0, every = 3 }",
            "files = \"blob_*.npy\"",
            [1.0, 1.0, 1.0, 1.0],
        ),
        (
            "{ from = 1, every = 2 }",
            "file = \"two.npy\"",
            [0.0, 1.0, 1.0, 2.0],
        ),
        // An entry for each density: those of the steps.
        (
            "{ from = 1, every = 2 }",
            "file = \"all.npy\"",
            [0.0, 2.0, 2.0, 4.0],
        ),
    ];
    for (number, (steps, shapes, expected)) in cases.into_iter().enumerate() {
        let folder = many(&format!("moving_{number}"), 5);
        fs::copy(many("two", 2).join("all.npy"), folder.join("two.npy")).unwrap();
        let scene = folder.join("scene.toml");
        let text = fs::read_to_string(&scene).unwrap() + &emitter(steps, shapes);
        fs::write(
            &scene,
            text + "[method]\niterations = 1\n[output]\nframes = false\n",
        )
        .unwrap();
        let out = folder.join("out");
        let ended = run(&["solve", text_of(&scene), "-o", text_of(&out), "--quiet"]);
        assert!([0, 5].contains(&ended.code), "{shapes}: {}", ended.err);
        let found = verify("moving emitter", &out).emission;
        assert_eq!(found.len(), 4);
        for (step, (found, times)) in found.iter().zip(expected).enumerate() {
            let wanted = density().into_iter().map(|x| 0.1 * times * x);
            let largest = found.data.iter().zip(wanted).map(|(a, b)| (a - b).abs());
            let largest = largest.fold(0.0, f64::max);
            assert!(largest < 1e-6, "{shapes}, step {step}: {largest}");
        }
    }
}

#[test]
fn an_emitter_says_once_when_it_emits() {
    let files = "rate = 0.1\nfiles = \"blob_*.npy\"";
    let cases = [
        (
            "steps = { from = 0, every = 1 }\nfrom = 1",
            "`emitter[0].steps` stands beside `from`",
        ),
        ("to = 3", "`emitter[0].steps` is missing"),
        (
            "steps = { from = 3, every = 1 }",
            "put 2 shapes at steps up to 4, but none may stand after step 3",
        ),
        ("steps = { from = 4, every = 1 }", "`emitter[0].steps.from` is 4"),
        (
            "steps = { from = 1, every = 1 }\nfile = \"blob_0.npy\"",
            "`emitter[0].file` stands beside `files`",
        ),
    ];
    for (keys, words) in cases {
        let folder = written(
            "emitter",
            &format!("step = 4\n{CIRCLE}\n[[emitter]]\n{files}\n{keys}"),
        );
        refused(&seen(&folder, "scene.toml", &folder), &[words, "; "]);
    }
}
