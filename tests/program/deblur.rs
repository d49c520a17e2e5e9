//! `thurible deblur`: sharper images, and everything that is refused.

use crate::support::npz::{npy, read, write};
use crate::support::{Ended, fresh_folder, json, run, text};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A bright square on grey, 32 x 24, blurred by a box of 5 x 5, and itself.
fn images(folder: &Path) {
    let sharp = |x: usize, y: usize| {
        if (12..24).contains(&x) && (10..20).contains(&y) {
            0.8
        } else {
            0.2
        }
    };
    let (mut truth, mut blurred) = (Vec::new(), Vec::new());
    for y in 4..28 {
        for x in 4..36 {
            truth.push(sharp(x, y));
            let sum: f64 = (0..25).map(|k| sharp(x + k % 5 - 2, y + k / 5 - 2)).sum();
            blurred.push(sum / 25.0);
        }
    }
    for (name, values) in [("truth.npy", truth), ("blurred.npy", blurred)] {
        fs::write(folder.join(name), npy(&[24, 32], &values)).unwrap();
    }
    fs::write(folder.join("psf.npy"), npy(&[5, 5], &[1.0; 25])).unwrap();
}

fn deblur(folder: &Path, image: &str, out: &str, more: &[&str]) -> Ended {
    let (image, out) = (folder.join(image), folder.join(out));
    run(&[
        &["deblur", text(&image), "--quiet", "--force", "-o", text(&out)],
        more,
    ]
    .concat())
}

fn report(folder: &Path) -> Value {
    json(&folder.join("report.json"))
}

#[test]
fn an_image_becomes_sharper_by_every_method() {
    let folder = fresh_folder("deblur_methods");
    images(&folder);
    let (psf, truth) = (folder.join("psf.npy"), folder.join("truth.npy"));
    for (method, gain) in [
        ("walk", 8.0),
        ("richardson_lucy", 3.0),
        ("wiener", 2.0),
        ("primal_dual", 8.0),
    ] {
        let more = [
            "--psf",
            text(&psf),
            "--truth",
            text(&truth),
            "--method",
            method,
            "--iterations",
            "300",
        ];
        // The walk counts mutations.
        let more = if method == "walk" { &more[..6] } else { &more[..] };
        let ended = deblur(&folder, "blurred.npy", method, more);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let out = folder.join(method);
        let report = report(&out);
        assert_eq!(report["kind"], "deblur");
        let [before, after] = ["blurred_psnr", "psnr"].map(|key| report[key].as_f64().unwrap());
        assert!(after > before + gain, "{method}: {before} dB becomes {after} dB");
        assert_eq!(read(&out.join("result.npz"))["image"].shape, [24, 32]);
        for file in ["image.png", "report.html"] {
            assert!(out.join(file).is_file());
        }
        let history = report["history"].as_array().unwrap();
        let objective = |entry: &Value| entry["objective"].as_f64().unwrap();
        assert!(objective(history.last().unwrap()) <= objective(&history[0]));
    }
}

/// Patches are taken, and come about as far as pixels do in as many mutations of a small image.
#[test]
fn pixels_change_in_patches() {
    let folder = fresh_folder("deblur_patches");
    images(&folder);
    let psf = folder.join("psf.npy");
    let objective = |name: &str, more: &[&str]| {
        let set = [
            "--psf",
            text(&psf),
            "--prior",
            "atv",
            "--gamma",
            "1e-3",
            "--precision",
            "f64",
        ];
        let ended = deblur(&folder, "blurred.npy", name, &[&set[..], more].concat());
        assert_eq!(ended.code, 0, "{}", ended.err);
        let report = report(&folder.join(name));
        let last = report["history"].as_array().unwrap().last().unwrap().clone();
        (
            last["objective"].as_f64().unwrap(),
            report["deblur"]["move"].clone(),
        )
    };
    let (pixels, word) = objective("pixels", &[]);
    assert_eq!(word, "pixel");
    let (patches, word) = objective("patches", &["--move", "patch"]);
    assert_eq!(word, "patch");
    assert!(
        patches < 1.05 * pixels,
        "{patches} by patches, {pixels} by pixels"
    );
    let ended = deblur(
        &folder,
        "blurred.npy",
        "no",
        &["--psf", text(&psf), "--move", "row"],
    );
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("\"pixel\" or \"patch\""), "{}", ended.err);
}

/// Kernels for each pixel that are all the same are that kernel.
#[test]
fn a_field_of_one_kernel_is_that_kernel() {
    let folder = fresh_folder("deblur_field");
    images(&folder);
    let psf = folder.join("psf.npy");
    let field = folder.join("field.npz");
    let [kernels, index] = [npy(&[2, 5, 5], &[1.0; 50]), npy(&[24, 32], &[1.0; 24 * 32])];
    write(&field, &[("kernels", kernels), ("index", index)]);
    for (name, psf) in [("one", &psf), ("many", &field)] {
        let ended = deblur(
            &folder,
            "blurred.npy",
            name,
            &["--psf", text(psf), "--budget", "20"],
        );
        assert_eq!(ended.code, 0, "{}", ended.err);
    }
    let image = |name: &str| read(&folder.join(name).join("result.npz"))["image"].data.clone();
    assert_eq!(image("one"), image("many"));
}

/// Kernels of different pixels leave even light even: what they send to a pixel does not sum to 1, and is divided by its sum.
#[test]
fn several_kernels_leave_no_bands() {
    let folder = fresh_folder("deblur_bands");
    let mut kernels = vec![0.0; 25];
    kernels[12] = 1.0;
    kernels.extend([0.04; 25]);
    let index: Vec<f64> = (0..24 * 32)
        .map(|pixel| if pixel % 32 < 16 { 0.0 } else { 1.0 })
        .collect();
    let field = folder.join("field.npz");
    let arrays = [
        ("kernels", npy(&[2, 5, 5], &kernels)),
        ("index", npy(&[24, 32], &index)),
    ];
    write(&field, &arrays);
    fs::write(folder.join("even.npy"), npy(&[24, 32], &[0.5; 24 * 32])).unwrap();
    let method = [
        "--psf",
        text(&field),
        "--method",
        "richardson_lucy",
        "--iterations",
        "40",
    ];
    let ended = deblur(&folder, "even.npy", "out", &method);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let image = read(&folder.join("out/result.npz"))["image"].data.clone();
    let far = image.iter().map(|value| (value - 0.5).abs()).fold(0.0, f64::max);
    assert!(far < 1e-4, "{far}");
}

/// An archive of kernels of which there are none, or more than can be named, is refused.
#[test]
fn kernels_that_are_none_or_too_many_are_refused() {
    let folder = fresh_folder("deblur_kernels");
    images(&folder);
    let field = folder.join("field.npz");
    for (shape, words) in [
        ([2, 0, 0], "holds no number"),
        ([0, 5, 5], "holds no number"),
        ([65537, 1, 1], "65537 kernels, and there may be 65536"),
    ] {
        let kernels = npy(&shape, &vec![1.0; shape.iter().product()]);
        let index = npy(&[24, 32], &[0.0; 24 * 32]);
        write(&field, &[("kernels", kernels), ("index", index)]);
        let ended = deblur(&folder, "blurred.npy", "no", &["--psf", text(&field)]);
        assert_eq!(ended.code, 2, "{shape:?}: {}", ended.err);
        assert!(ended.err.contains(words), "{shape:?}: {}", ended.err);
        assert!(ended.err.contains("field.npz"), "{}", ended.err);
    }
    let half = ("index", npy(&[24, 32], &[0.5; 24 * 32]));
    write(&field, &[("kernels", npy(&[2, 1, 1], &[1.0; 2])), half]);
    let ended = deblur(&folder, "blurred.npy", "no", &["--psf", text(&field)]);
    assert!(
        ended.code == 2
            && ended
                .err
                .contains("names the kernel 0.5; they are whole numbers from 0 to 1"),
        "{}",
        ended.err
    );
}

/// An array of 24 x 32 whole numbers.
fn whole_numbers(kind: &str, bytes: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (24, 32), }}\n");
    let mut all = b"\x93NUMPY\x01\x00".to_vec();
    all.extend((header.len() as u16).to_le_bytes());
    all.extend(header.as_bytes());
    all.extend(bytes);
    all
}

/// Bytes and words are parts of the largest there are, as in pictures; of other whole numbers white is not known.
#[test]
fn whole_numbers_are_parts_of_white() {
    let folder = fresh_folder("deblur_whole");
    images(&folder);
    let levels: Vec<u8> = (0..24 * 32).map(|pixel| (pixel % 200) as u8).collect();
    let light: Vec<f64> = levels.iter().map(|&level| f64::from(level) / 255.0).collect();
    let words: Vec<u8> = levels
        .iter()
        .flat_map(|&level| (u16::from(level) * 257).to_le_bytes())
        .collect();
    let long: Vec<u8> = levels
        .iter()
        .flat_map(|&level| i64::from(level).to_le_bytes())
        .collect();
    fs::write(folder.join("light.npy"), npy(&[24, 32], &light)).unwrap();
    fs::write(folder.join("bytes.npy"), whole_numbers("|u1", &levels)).unwrap();
    fs::write(folder.join("words.npy"), whole_numbers("<u2", &words)).unwrap();
    fs::write(folder.join("long.npy"), whole_numbers("<i8", &long)).unwrap();
    let psf = folder.join("psf.npy");
    let image = |name: &str| {
        let file = format!("{name}.npy");
        let ended = deblur(&folder, &file, name, &["--psf", text(&psf), "--budget", "5"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        read(&folder.join(name).join("result.npz"))["image"].data.clone()
    };
    let known = image("light");
    assert_eq!(known, image("bytes"));
    assert_eq!(known, image("words"));
    let ended = deblur(&folder, "long.npy", "no", &["--psf", text(&psf)]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    for word in ["long.npy", "whole numbers up to 199", "divide them"] {
        assert!(ended.err.contains(word), "{}", ended.err);
    }
}

#[test]
fn what_cannot_be_is_refused_in_a_sentence() {
    let folder = fresh_folder("deblur_refusals");
    images(&folder);
    let write = |name: &str, shape: &[usize], value: f64| {
        fs::write(
            folder.join(name),
            npy(shape, &vec![value; shape.iter().product()]),
        )
        .unwrap();
    };
    write("nothing.npy", &[5, 5], 0.0);
    write("minus.npy", &[5, 5], -1.0);
    write("large.npy", &[41, 41], 1.0);
    write("line.npy", &[5], 1.0);
    write("nan.npy", &[24, 32], f64::NAN);
    write("below.npy", &[24, 32], -0.5);
    write("small.npy", &[12, 12], 0.5);
    write("bright.npy", &[24, 32], 2.0);
    let at = |name: &str| text(&folder.join(name)).to_owned();
    let (good, truth) = (at("psf.npy"), at("small.npy"));
    let cases: &[(&str, &[&str], &[&str])] = &[
        (
            "blurred.npy",
            &["--psf", &at("nothing.npy")],
            &["nothing.npy", "sums to nothing"],
        ),
        (
            "blurred.npy",
            &["--psf", &at("minus.npy")],
            &["minus.npy", "takes none"],
        ),
        (
            "blurred.npy",
            &["--psf", &at("large.npy")],
            &["41 x 41", "larger than the image"],
        ),
        ("blurred.npy", &["--psf", &at("line.npy")], &["rows x columns"]),
        ("blurred.npy", &["--psf", "square:3"], &["square:3", "disc:3"]),
        ("blurred.npy", &["--psf", "disc:-1"], &["disc:-1", "above 0"]),
        ("nan.npy", &["--psf", &good], &["nan.npy", "NaN"]),
        ("below.npy", &["--psf", &good], &["below.npy", "at least 0"]),
        ("gone.npy", &["--psf", &good], &["gone.npy"]),
        (
            "blurred.npy",
            &["--psf", &good, "--truth", &truth],
            &["--truth", "12 x 12"],
        ),
        (
            "bright.npy",
            &["--psf", &good, "--saturation"],
            &["--saturation", "no pixel below"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--tau", "1"],
            &["--tau", "below 1"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--method", "primal_dual", "--prior", "sparse"],
            &["--prior sparse", "atv alone"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--method", "richardson_lucy", "--saturation"],
            &["--saturation", "takes every pixel"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--method", "wiener", "--saturation"],
            &["--saturation", "wiener takes every pixel", "primal_dual"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--method", "wiener", "--prior", "tv"],
            &["--prior", "wiener knows none"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--method", "wiener", "--budget", "20"],
            &["--budget is of the walk", "--method walk"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--iterations", "20"],
            &["--iterations is of the baselines", "--budget"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--prior", "tv", "--mu", "2"],
            &["--mu is of the prior clusters"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--method", "wiener", "--signed"],
            &["--signed is of the walk and primal_dual"],
        ),
        (
            "blurred.npy",
            &["--psf", "motion:5,nan"],
            &["\"nan\"", "an angle in degrees"],
        ),
        (
            "blurred.npy",
            &["--psf", "gaussian:1e-9"],
            &["0.000000001", "0.05 pixels or more"],
        ),
        // A number below 0 is a value.
        (
            "blurred.npy",
            &["--psf", &good, "--gamma", "-1"],
            &["--gamma", "must be"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--prior", "smooth"],
            &["smooth", "clusters"],
        ),
        (
            "blurred.npy",
            &["--psf", &good, "--memory-limit", "9KiB"],
            &["--memory-limit", "bytes"],
        ),
    ];
    for (image, more, words) in cases {
        let ended = deblur(&folder, image, "no", more);
        assert!(
            [2, 3, 4].contains(&ended.code),
            "{more:?}: {} {}",
            ended.code,
            ended.err
        );
        for word in *words {
            assert!(ended.err.contains(word), "{image} {more:?}: {}", ended.err);
        }
        assert!(!folder.join("no").exists());
    }
}

/// Ctrl-C leaves the image as far as it came.
#[test]
#[cfg(unix)]
fn an_interrupt_leaves_what_is_there() {
    use crate::support::endless::Endless;
    let folder = fresh_folder("deblur_interrupted");
    images(&folder);
    let [image, psf, out] = ["blurred.npy", "psf.npy", "out"].map(|name| folder.join(name));
    let mut command = crate::support::thurible();
    command.args([
        "deblur",
        text(&image),
        "--psf",
        text(&psf),
        "-o",
        text(&out),
        "--json",
    ]);
    command.args(["--budget", "100000000"]);
    let running = Endless::seen(&mut command, |line| line.contains("\"plan\""));
    std::thread::sleep(core::time::Duration::from_millis(300));
    let ended = running.stop();
    assert_eq!(ended.code, 130, "{}", ended.err);
    let found = report(&out);
    assert_eq!(found["status"], "cancelled");
    let image = &read(&out.join("result.npz"))["image"];
    assert!(image.data.iter().all(|value| value.is_finite()));
    assert!(image.data.iter().any(|&value| value > 0.1));
}
