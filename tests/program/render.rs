//! `thurible render`: pictures of a result, and what it refuses.

use crate::support::{fresh_folder, npz, run, text};
use std::fs;
use std::path::{Path, PathBuf};

pub const FLAT: &str = "[grid]\ncells = [24, 16]\n[time]\nsteps = 3\n[source]\ncircle = { center = [0.25, 0.3], radius = 0.15 }\n[[obstacle]]\nbox = { min = [0.5, 0.2], max = [0.6, 0.5] }\n[[keyframe]]\nstep = 3\ncircle = { center = [0.3, 0.35], radius = 0.15 }\n[method]\niterations = 2\n[output]\nframes = false\n";
pub const DEEP: &str = "[grid]\ncells = [10, 8, 9]\n[time]\nsteps = 3\n[source]\nsphere = { center = [0.5, 0.4, 0.4], radius = 0.2 }\n[[keyframe]]\nstep = 3\nsphere = { center = [0.5, 0.4, 0.6], radius = 0.2 }\n[method]\niterations = 2\n[output]\nframes = false\n";

/// The result of a scene.
pub fn solved(test: &str, scene: &str) -> PathBuf {
    let folder = fresh_folder(test);
    let path = folder.join("scene.toml");
    fs::write(&path, scene).unwrap();
    let out = folder.join("out");
    let ended = run(&["solve", text(&path), "--quiet", "-o", text(&out)]);
    assert!(ended.code == 0 || ended.code == 5, "{}", ended.err);
    out
}

/// Width, height and the bytes of the pixels of a PNG file.
pub fn png(path: &Path) -> (usize, usize, Vec<u8>) {
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    (info.width as usize, info.height as usize, bytes)
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_plane_is_drawn_cell_by_cell_with_its_bodies() {
    let result = solved("render_flat", &FLAT.replace("frames = false", ""));
    let ended = run(&["render", text(&result)]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(
        ended.out.contains("steps 0 to 3 of 1032 x 688 pixels"),
        "{}",
        ended.out
    );
    assert!(ended.err.contains("   4/4 step 3, 0.0 s left"), "{}", ended.err);
    let folder = result.join("render");
    let frames = (0..4).map(|step| format!("frame_{step:04}.png"));
    let expected: Vec<String> = frames
        .chain(["manifest.json".into(), "render.json".into()])
        .collect();
    assert_eq!(names(&folder), expected);
    // Places in the unit of the scene, whose longest side is 1: a body is grey, smoke is bright and warm, and the rest is dark. The
    // frames of the solve show the same.
    for (path, size) in [(folder.clone(), (1032, 688)), (result.join("frames"), (384, 256))] {
        let (width, height, bytes) = png(&path.join("frame_0000.png"));
        assert_eq!((width, height), size);
        let at = |x: f64, y: f64| {
            let column = (x * width as f64) as usize;
            let pixel = (height - 1 - (y * width as f64) as usize) * width + column;
            [bytes[3 * pixel], bytes[3 * pixel + 1], bytes[3 * pixel + 2]]
        };
        assert_eq!(at(0.55, 0.35), [112, 113, 116]);
        let smoke = at(0.25, 0.35);
        assert!(smoke[0] > 200 && smoke[0] > smoke[2], "{smoke:?}");
        assert_eq!(at(0.9, 0.6), [13, 14, 19]);
    }
    // Another size: whole cells on the ground.
    let ended = run(&[
        "render",
        text(&result),
        "--size",
        "100x40",
        "--steps",
        "2",
        "--quiet",
    ]);
    assert_eq!((ended.code, ended.out.as_str()), (0, ""));
    let (width, height, bytes) = png(&folder.join("frame_0002.png"));
    assert_eq!((width, height, &bytes[..3]), (100, 40, &[13, 14, 19][..]));
    assert_eq!(names(&folder), expected, "the other steps stay");
}

#[test]
fn a_box_is_the_same_for_any_threads_and_steps() {
    let result = solved("render_deep", DEEP);
    let folder = |name: &str| result.with_file_name(name);
    let render = |name: &str, more: &[&str]| {
        let out = folder(name);
        let mut arguments = vec![
            "render",
            text(&result),
            "--size",
            "96x54",
            "--json",
            "-o",
            text(&out),
        ];
        arguments.extend(more);
        let ended = run(&arguments);
        assert_eq!(ended.code, 0, "{}", ended.err);
        ended.out
    };
    let said = render("one", &["--threads", "1"]);
    assert!(
        said.contains("\"event\":\"frame\"") && said.contains("\"event\":\"render\""),
        "{said}"
    );
    render("three", &["--threads", "3"]);
    render("last", &["--steps", "3..3"]);
    let read = |name: &str, step: usize| fs::read(folder(name).join(format!("frame_{step:04}.png"))).unwrap();
    for step in 0..4 {
        assert_eq!(read("one", step), read("three", step), "step {step}");
    }
    assert_eq!(read("one", 3), read("last", 3));
    let (width, height, bytes) = png(&folder("one").join("frame_0003.png"));
    assert_eq!((width, height), (96, 54));
    assert!(bytes.iter().any(|&byte| byte > 120) && bytes.iter().any(|&byte| byte < 40));
    // What may be asked for changes the picture.
    for (name, more) in [
        ("camera", ["--camera", "-60,40"]),
        ("exposure", ["--exposure", "-1.5"]),
        ("detail", ["--detail", "0"]),
    ] {
        render(name, &[more[0], more[1], "--steps", "3"]);
        assert_ne!(read("one", 3), read(name, 3), "{name}");
    }
    render("light", &["--format", "exr", "--steps", "1"]);
    let exr = fs::read(folder("light").join("frame_0001.exr")).unwrap();
    assert!(exr.starts_with(&[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]));
    assert_eq!(exr.len() % 2, (exr.len() - 54 * (8 + 8 + 96 * 6)) % 2);
}

#[test]
fn what_cannot_be_drawn_is_refused_with_a_sentence() {
    let result = solved("render_refused", FLAT);
    let nothing = result.with_file_name("nothing");
    fs::create_dir_all(&nothing).unwrap();
    fs::write(nothing.join("mine.txt"), "mine").unwrap();
    let (result, nothing) = (text(&result), text(&nothing));
    for (arguments, code, words) in [
        (vec![nothing], 2, "is no result folder"),
        (vec!["nowhere"], 4, "there is no folder nowhere"),
        (vec![result, "--fps", "24"], 2, "--fps 24: pictures have no rate"),
        (
            vec![result, "--format", "webp", "--fps", "240"],
            2,
            "ask for at most 90",
        ),
        (
            vec![result, "--size", "0x10"],
            2,
            "allowed are width and height in pixels",
        ),
        (vec![result, "--size", "20x20"], 2, "there are 24 x 16 cells"),
        (
            vec![result, "--steps", "2..4"],
            2,
            "the result has the steps 0 to 3",
        ),
        (
            vec![result, "--steps", "3..2"],
            2,
            "allowed are the first and the last step",
        ),
        (vec![result, "--camera", "10,10"], 2, "--camera: a result in 2D"),
        (vec![result, "--detail", "1"], 2, "--detail: a result in 2D"),
        (vec![result, "--camera", "10,100"], 2, "an elevation from 0 to 90"),
        (vec![result, "--exposure", "much"], 2, "allowed is a number"),
        (vec![result, "-o", nothing], 4, "holds no result of thurible"),
    ] {
        let ended = run(&[&["render"], arguments.as_slice()].concat());
        assert_eq!(ended.code, code, "{arguments:?}: {}", ended.err);
        assert!(ended.err.contains(words), "{arguments:?}: {}", ended.err);
    }
}

#[cfg(unix)]
#[test]
fn films_are_made_where_ffmpeg_is() {
    use crate::support::{Ended, thurible};
    use std::os::unix::fs::PermissionsExt;

    let result = solved("render_film", DEEP);
    let place = result.with_file_name("bin");
    fs::create_dir_all(&place).unwrap();
    let render = |path: &str| -> Ended {
        let mut command = thurible();
        let arguments = ["render", text(&result), "--size", "33x21", "--format", "mp4"];
        command.args(arguments).env("PATH", path).output().unwrap().into()
    };
    let ended = render(text(&place));
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(ended.err.contains("no ffmpeg on the PATH"), "{}", ended.err);
    // One that keeps what it is given.
    let ffmpeg = place.join("ffmpeg");
    let script = "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor last; do :; done\nexec cat > \"$last\"\n";
    fs::write(&ffmpeg, script).unwrap();
    fs::set_permissions(&ffmpeg, fs::Permissions::from_mode(0o755)).unwrap();
    let ended = render(&format!("{}:/bin:/usr/bin", text(&place)));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let film = fs::read(result.join("render/render.mp4")).unwrap();
    assert_eq!(film.len(), 4 * 3 * 33 * 21);
    let script = "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\necho no such encoder >&2\nexit 8\n";
    fs::write(&ffmpeg, script).unwrap();
    let ended = render(&format!("{}:/bin:/usr/bin", text(&place)));
    assert_eq!(ended.code, 4, "{}", ended.err);
    let said = "ffmpeg ended with exit status: 8 and says: no such encoder; take a build of it with libx264";
    assert!(ended.err.contains(said), "{}", ended.err);
    assert_eq!(fs::read(result.join("render/render.mp4")).unwrap(), film);
}

/// What becomes of an array by its name: its shape, and its values.
type Change<'a> = &'a dyn Fn(&str, &mut Vec<usize>, &mut Vec<f64>);

/// Another program may have saved an archive again, in another way or with other numbers.
#[test]
fn what_another_program_made_of_a_result_is_drawn_or_refused() {
    let result = solved("render_changed", FLAT);
    let archive = result.join("result.npz");
    let arrays = npz::read(&archive);
    let save = |change: Change<'_>| {
        let saved = arrays.iter().map(|(name, array)| {
            let (mut shape, mut values) = (array.shape.clone(), array.data.clone());
            change(name, &mut shape, &mut values);
            (name.as_str(), npz::npy(&shape, &values))
        });
        npz::write(&archive, &saved.collect::<Vec<_>>());
    };
    let render = |more: &[&str]| run(&[&["render", text(&result), "--size", "48x32"], more].concat());
    let picture = |name: &str| {
        let out = result.with_file_name(name);
        let ended = render(&["-o", text(&out)]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        fs::read(out.join("frame_0003.png")).unwrap()
    };
    let before = picture("render_changed_before");
    // Doubles, where report.json says that there are none.
    save(&|_, _, _| {});
    assert_eq!(picture("render_changed_doubles"), before);
    let film = result.with_file_name("render_changed_film");
    let filmed = ["-o", text(&film), "--format", "webp"];
    assert_eq!(render(&filmed).code, 0);
    let whole = fs::read(film.join("render.webp")).unwrap();
    let density = |name: &str| name == "density";
    let cells: usize = arrays["density"].shape[1..].iter().product();
    let changes: [(Change<'_>, &str); 5] = [
        (
            &|name, _, values| {
                if density(name) {
                    values[3 * cells + 5] = f64::NAN
                }
            },
            "holds NaN in entry 3 of `density`",
        ),
        (
            &|name, _, values| {
                if density(name) {
                    values[5] = f64::INFINITY
                }
            },
            "holds inf",
        ),
        // More than single precision holds.
        (
            &|name, _, values| {
                if density(name) {
                    values[5] = 1e41
                }
            },
            "holds 1e41 in entry 0 of `density`",
        ),
        (
            &|name, shape, values| {
                if density(name) {
                    shape[0] -= 1;
                    values.truncate(3 * cells);
                }
            },
            "has 3 entries of `density` and a report.json of the steps 0 to 3",
        ),
        (
            &|name, shape, _| {
                if density(name) {
                    shape.swap(1, 2);
                }
            },
            "has `density` of [24, 16] and a report.json by which that is of [16, 24]",
        ),
    ];
    for (change, words) in changes {
        save(change);
        let ended = render(&filmed);
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(ended.err.contains(words), "{}", ended.err);
        assert_eq!(fs::read(film.join("render.webp")).unwrap(), whole, "{words}");
    }
    // A folder that was to have a film, of which there is no picture, may still have one.
    let new = result.with_file_name("render_changed_new");
    let filmed = ["-o", text(&new), "--format", "webp"];
    assert_eq!(render(&filmed).code, 2);
    save(&|_, _, _| {});
    let ended = render(&filmed);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_eq!(fs::read(new.join("render.webp")).unwrap(), whole);
}

#[test]
fn an_animated_webp_has_the_pixels_of_the_pictures() {
    let result = solved("webp", DEEP);
    let size = ["--size", "33x21"];
    let rendered = |name: &str, format: &str| {
        let out = result.with_file_name(name);
        let arguments = ["render", text(&result), "-o", text(&out), "--format", format];
        let ended = run(&[&arguments[..], &size[..]].concat());
        assert_eq!(ended.code, 0, "{}", ended.err);
        (ended, out)
    };
    let (_, pictures) = rendered("pictures", "png");
    let (ended, film) = rendered("film", "webp");
    assert!(ended.out.contains("render.webp"), "{}", ended.out);
    assert_eq!(names(&film), ["manifest.json", "render.json", "render.webp"]);
    let file = std::io::BufReader::new(fs::File::open(film.join("render.webp")).unwrap());
    let mut decoder = image_webp::WebPDecoder::new(file).unwrap();
    assert!(decoder.is_animated());
    assert_eq!((decoder.dimensions(), decoder.num_frames()), ((33, 21), 4));
    assert_eq!(decoder.loop_count(), image_webp::LoopCount::Forever);
    let mut durations = Vec::new();
    for step in 0..4 {
        let mut bytes = vec![0; decoder.output_buffer_size().unwrap()];
        durations.push(decoder.read_frame(&mut bytes).unwrap());
        let (_, _, expected) = png(&pictures.join(format!("frame_{step:04}.png")));
        let channels = bytes.len() / (33 * 21);
        let shown: Vec<u8> = bytes
            .chunks(channels)
            .flat_map(|pixel| pixel[..3].to_vec())
            .collect();
        assert_eq!(shown, expected, "step {step}");
    }
    assert_eq!(durations, [42, 41, 42, 42]);
    let slow = result.with_file_name("slow");
    let arguments = [
        "render",
        text(&result),
        "-o",
        text(&slow),
        "--format",
        "webp",
        "--fps",
        "0.01",
        "--steps",
        "0..1",
    ];
    let ended = run(&[&arguments[..], &size[..]].concat());
    assert_eq!(ended.code, 0, "{}", ended.err);
    let file = std::io::BufReader::new(fs::File::open(slow.join("render.webp")).unwrap());
    let mut decoder = image_webp::WebPDecoder::new(file).unwrap();
    let mut bytes = vec![0; decoder.output_buffer_size().unwrap()];
    assert_eq!(decoder.read_frame(&mut bytes).unwrap(), 100_000);
    let ended = run(&["render", text(&result), "--format", "webp", "--size", "16384x10"]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(ended.err.contains("has at most 16383 pixels"), "{}", ended.err);
}
