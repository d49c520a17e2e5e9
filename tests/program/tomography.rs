//! `thurible photograph` and `thurible tomography`: from a known density to its reconstruction, and everything that is refused.

use crate::support::npz::{npy, read, write};
use crate::support::{fresh_folder, json, run, text};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Two frames of a disc that moves, 20 x 16 cells, and in a box.
fn density(folder: &Path, dims: usize) -> PathBuf {
    let cells: &[usize] = if dims == 2 { &[20, 16] } else { &[10, 9, 8] };
    let count: usize = cells.iter().product();
    let mut values = Vec::new();
    for frame in 0..2 {
        for index in 0..count {
            let mut rest = index;
            let square: f64 = cells
                .iter()
                .enumerate()
                .map(|(axis, &count)| {
                    let at = (rest % count) as f64 + 0.5;
                    rest /= count;
                    let middle = 0.5 * count as f64 + if axis == 0 { frame as f64 } else { 0.0 };
                    (at - middle).powi(2)
                })
                .sum();
            values.push(f64::from(u8::from(square < if dims == 2 { 20.0 } else { 6.0 })));
        }
    }
    let mut shape = vec![2];
    shape.extend(cells.iter().rev());
    let path = folder.join("density.npy");
    fs::write(&path, npy(&shape, &values)).unwrap();
    path
}

fn report(folder: &Path) -> Value {
    json(&folder.join("report.json"))
}

/// Views of a density in a fresh folder.
fn views(test: &str, dims: usize, more: &[&str]) -> (PathBuf, PathBuf) {
    let folder = fresh_folder(test);
    let (density, views) = (density(&folder, dims), folder.join("views"));
    let mut arguments = vec![
        "photograph",
        text(&density),
        "--views",
        "6",
        "--quiet",
        "-o",
        text(&views),
    ];
    arguments.extend(more);
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}", ended.err);
    (folder, views)
}

fn reconstruct(views: &Path, out: &Path, more: &[&str]) -> crate::support::Ended {
    let mut arguments = vec!["tomography", text(views), "--quiet", "--force", "-o", text(out)];
    arguments.extend(more);
    run(&arguments)
}

#[test]
fn a_known_density_comes_back() {
    for (dims, more) in [(2, &[][..]), (2, &["--pinhole"]), (3, &[]), (3, &["--pinhole"])] {
        let (folder, views) = views(&format!("tomography_{dims}_{}", more.len()), dims, more);
        let out = folder.join("out");
        let ended = reconstruct(&views, &out, &["--set", "tomography.budget=5e5"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let report = report(&out);
        assert_eq!(report["kind"], "tomography");
        assert_eq!(report["steps"], 1);
        let error = report["rms_error"].as_f64().unwrap();
        assert!(error < 0.17, "{dims}D {more:?}: RMS error {error}");
        assert!(report["history"].as_array().unwrap().len() > 4);
        let arrays = read(&out.join("result.npz"));
        assert_eq!(arrays["density"].shape[0], 2);
        assert_eq!(arrays["density"].shape.len(), dims + 1);
        assert!(arrays["density"].data.iter().all(|&value| value >= 0.0));
        assert_eq!(arrays["reprojection_5"].shape[0], 2);
        for file in ["report.html", "frames/frame_0001.png", "animation.png"] {
            assert!(out.join(file).is_file(), "{file}");
        }
    }
}

#[test]
fn threads_change_no_bit_and_seeds_do() {
    let (folder, views) = views("tomography_bits", 2, &[]);
    let density = |name: &str, more: &[&str]| {
        let out = folder.join(name);
        let budget = ["--set", "tomography.budget=50000"];
        let ended = reconstruct(&views, &out, &[&budget[..], more].concat());
        assert_eq!(ended.code, 0, "{}", ended.err);
        read(&out.join("result.npz"))["density"].data.clone()
    };
    let one = density("one", &["--threads", "1"]);
    assert_eq!(one, density("two", &["--threads", "2"]));
    assert_eq!(one, density("three", &["--threads", "3"]));
    assert_ne!(one, density("seed", &["--set", "tomography.seed=2"]));
    let warm = density("warm", &["--set", "tomography.warm=true"]);
    assert_ne!(one, warm);
}

#[test]
fn the_plan_is_kept_and_a_ceiling_refuses() {
    let (folder, views) = views("tomography_plan", 2, &[]);
    let planned = run(&["tomography", text(&views), "--plan", "--json", "--threads", "2"]);
    let plan: Value = serde_json::from_str(planned.out.trim()).unwrap();
    let out = folder.join("out");
    let ended = reconstruct(
        &views,
        &out,
        &["--threads", "2", "--set", "tomography.budget=1000"],
    );
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_eq!(report(&out)["memory"]["planned_bytes"], plan["planned_bytes"]);
    let refused = reconstruct(
        &views,
        &folder.join("no"),
        &["--threads", "2", "--memory-limit", "9KiB"],
    );
    assert_eq!(refused.code, 3);
    for word in ["bytes", "--memory-limit", "box.cells"] {
        assert!(refused.err.contains(word), "{}", refused.err);
    }
}

/// A file of views, changed, and what the refusal names.
#[test]
fn bad_views_are_refused_in_a_sentence() {
    let (folder, views) = views("tomography_refusals", 2, &[]);
    let good = fs::read_to_string(views.join("views.toml")).unwrap();
    let cases: &[(&str, &str, &[&str])] = &[
        ("cells = [20, 16]", "cells = [20]", &["box.cells", "two or three"]),
        ("cells = [20, 16]", "cells = [1, 16]", &["box.cells"]),
        ("length = 1", "length = -1", &["box.length", "above 0"]),
        (
            "[pictures]",
            "[tomography]\nhull_threshold = 9e9\n[pictures]",
            &[
                "tomography.hull_threshold",
                "no camera sees smoke",
                "0 by default",
            ],
        ),
        (
            "kind = \"orthographic\"",
            "kind = \"fisheye\"",
            &["camera[0].kind", "pinhole"],
        ),
        (
            "azimuth = 0\n",
            "azimuth = 0\ncenter = [9.0, 9.0]\n",
            &["camera[0]", "sees nothing of the box"],
        ),
        ("azimuth = 0\n", "azimuth = 0\nroll = 3\n", &["roll"]),
        (
            "azimuth = 0\n",
            "azimuth = 0\nfield_of_view = 40\n",
            &["camera[0].field_of_view", "for cameras of kind pinhole"],
        ),
        (
            "kind = \"orthographic\"",
            "kind = \"pinhole\"",
            &["camera[0].azimuth", "for cameras of kind orthographic"],
        ),
        (
            "kind = \"orthographic\"\nazimuth = 0\n",
            "kind = \"matrix\"\nup = [0.0, 1.0]\n",
            &["camera[0].", "this one is matrix"],
        ),
        (
            "array = \"camera_1\"",
            "array = \"camera_77\"",
            &["camera[1]", "camera_77", "it holds"],
        ),
        (
            "file = \"pictures.npz\"\narray = \"camera_2\"\n",
            "",
            &["camera[2]", "needs its pictures"],
        ),
        (
            "file = \"pictures.npz\"\narray = \"camera_2\"\n",
            "files = \"missing_*.png\"\n",
            &["missing_*.png", "fits no file"],
        ),
        ("dt = 1", "dt = 0", &["pictures.dt"]),
        ("dt = 1", "dt = 1\nlast = 7", &["pictures", "there are 0 to 1"]),
        (
            "[pictures]",
            "[tomography]\nprior = \"smooth\"\n[pictures]",
            &["tomography.prior", "sad"],
        ),
        (
            "[pictures]",
            "[tomography]\ngamma = -1.0\n[pictures]",
            &["tomography.gamma", "at least 0"],
        ),
        (
            "[pictures]",
            "[tomography]\nbudget = 0\n[pictures]",
            &["tomography.budget"],
        ),
    ];
    for (from, to, words) in cases {
        assert!(good.contains(from), "{from}");
        fs::write(views.join("bad.toml"), good.replacen(from, to, 1)).unwrap();
        let ended = reconstruct(&views.join("bad.toml"), &folder.join("no"), &[]);
        assert_eq!(ended.code, 2, "{to}: {}", ended.err);
        for word in *words {
            assert!(ended.err.contains(word), "{to}: {}", ended.err);
        }
        assert_eq!(ended.err.trim().lines().count(), 1, "{}", ended.err);
    }
    assert_eq!(
        reconstruct(&folder.join("nowhere"), &folder.join("no"), &[]).code,
        4
    );
}

/// Pictures that will not do.
#[test]
fn bad_pictures_are_refused_in_a_sentence() {
    let folder = fresh_folder("tomography_pictures");
    let head = "[box]\ncells = [8, 8]\n";
    let camera =
        |azimuth: f64, source: &str| format!("[[camera]]\nazimuth = {azimuth}\npitch = 0.125\n{source}\n");
    let lit = [0.0, 0.0, 1.0, 3.0, 3.0, 1.0, 0.0, 0.0];
    let write =
        |name: &str, values: &[f64]| fs::write(folder.join(name), npy(&[values.len()], values)).unwrap();
    write("good.npy", &lit);
    write("nan.npy", &[0.0, f64::NAN, 1.0, 3.0, 3.0, 1.0, 0.0, 0.0]);
    write("dark.npy", &[0.0; 8]);
    write("below.npy", &[-5.0, 0.0, 1.0, 3.0, 3.0, 1.0, 0.0, 0.0]);
    for (name, values) in [
        ("s_1.npy", &lit[..]),
        ("s_2.npy", &lit),
        ("s_4.npy", &lit),
        ("s_5.npy", &lit),
    ] {
        write(name, values);
    }
    for (name, values) in [("t_1.npy", &lit[..]), ("t_2.npy", &lit[..6])] {
        write(name, values);
    }
    for name in ["d_1.npy", "d_01.npy"] {
        write(name, &lit);
    }
    write("faint.npy", &lit.map(|value| 1e-300 * value));
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "file = \"good.npy\"",
            "file = \"nan.npy\"",
            &["nan.npy", "holds NaN at [1]", "finite"],
        ),
        (
            "file = \"good.npy\"",
            "file = \"dark.npy\"",
            &["camera[1]", "dark", "dark.npy"],
        ),
        (
            "file = \"dark.npy\"",
            "file = \"dark.npy\"",
            &["nothing but zeros"],
        ),
        (
            "file = \"good.npy\"",
            "file = \"below.npy\"",
            &["below.npy", "below 0", "-5"],
        ),
        (
            "files = \"s_*.npy\"",
            "files = \"s_*.npy\"",
            &["frame 3 is missing", "s_*.npy"],
        ),
        (
            "files = \"t_*.npy\"",
            "files = \"t_*.npy\"",
            &["t_2.npy", "one size"],
        ),
        (
            "file = \"good.npy\"",
            "files = \"t_*.npy\"",
            &["camera[0]", "1 frames", "2"],
        ),
        (
            "files = \"d_*.npy\"",
            "files = \"d_*.npy\"",
            &["d_*.npy", "d_01.npy and d_1.npy", "the same number"],
        ),
        (
            "file = \"faint.npy\"",
            "file = \"faint.npy\"",
            &["3e-300", "pictures.scale"],
        ),
        (
            "file = \"good.npy\"",
            "file = \"gone.npy\"",
            &["gone.npy", "cannot be read"],
        ),
    ];
    for (one, other, words) in cases {
        let path = folder.join("views.toml");
        fs::write(
            &path,
            format!("{head}{}{}", camera(0.0, one), camera(90.0, other)),
        )
        .unwrap();
        let ended = reconstruct(&path, &folder.join("no"), &[]);
        assert!(
            ended.code == 2 || ended.code == 4,
            "{other}: {} {}",
            ended.code,
            ended.err
        );
        for word in *words {
            assert!(ended.err.contains(word), "{one}, {other}: {}", ended.err);
        }
    }
}

/// Numbers slightly below 0, as a background taken off leaves them, become 0 and are told; a dark frame is empty.
#[test]
fn noise_below_zero_and_dark_frames_are_taken() {
    let folder = fresh_folder("tomography_noise");
    let lit = [-0.01, 0.0, 1.0, 3.0, 3.0, 1.0, 0.0, 0.0];
    let frames: Vec<f64> = lit.into_iter().chain([0.0; 8]).collect();
    fs::write(folder.join("q.npy"), npy(&[2, 8], &frames)).unwrap();
    let camera = |azimuth: f64| format!("[[camera]]\nazimuth = {azimuth}\npitch = 0.125\nfile = \"q.npy\"\n");
    let path = folder.join("views.toml");
    fs::write(
        &path,
        format!("[box]\ncells = [8, 8]\n{}{}", camera(0.0), camera(90.0)),
    )
    .unwrap();
    let out = folder.join("out");
    let ended = run(&[
        "tomography",
        text(&path),
        "-o",
        text(&out),
        "--set",
        "tomography.budget=20000",
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.contains("below 0"), "{}", ended.err);
    let density = read(&out.join("result.npz"))["density"].data.clone();
    assert!(density[..64].iter().sum::<f64>() > 4.0);
    assert!(density[64..].iter().all(|&value| value == 0.0));
}

/// A few chains that find nothing are no end of a frame.
#[test]
fn a_small_budget_is_spent() {
    let (folder, views) = views("tomography_few", 2, &[]);
    for seed in 1..7 {
        let (out, seed) = (folder.join("out"), format!("tomography.seed={seed}"));
        let ended = reconstruct(
            &views,
            &out,
            &["--set", "tomography.budget=20000", "--set", &seed],
        );
        assert_eq!(ended.code, 0, "{}", ended.err);
        let report = report(&out);
        let spent = |frame: u64| {
            let entries = report["history"].as_array().unwrap().iter();
            let of_frame = entries.filter(|entry| entry["frame"] == frame);
            of_frame.filter_map(|entry| entry["mutations"].as_u64()).max()
        };
        for frame in 0..report["frames"].as_array().unwrap().len() as u64 {
            assert_eq!(spent(frame), Some(20000), "frame {frame}, {seed}");
        }
    }
}

/// What is no density is not photographed.
#[test]
fn what_cannot_be_photographed_is_refused() {
    let folder = fresh_folder("photograph_refusals");
    let path = folder.join("density.npy");
    for (value, words) in [
        (-0.5, "a density is never negative"),
        (1e300, "holds 1e300; cameras see densities up to 1e30"),
    ] {
        let mut values = vec![0.1; 2 * 36];
        values[36..].iter_mut().for_each(|cell| *cell = value);
        fs::write(&path, npy(&[2, 6, 6], &values)).unwrap();
        let ended = run(&["photograph", text(&path), "-o", text(&folder.join("no"))]);
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(
            ended.err.contains("density.npy") && ended.err.contains("[1]") && ended.err.contains(words),
            "{}",
            ended.err
        );
        assert!(!folder.join("no").exists());
    }
    fs::write(&path, npy(&[2, 6, 6], &[0.1; 72])).unwrap();
    for (more, words) in [
        (["--elevation", "20"], "cameras of a plane lie in it"),
        (["--size", "12x9"], "write --size 12x1"),
    ] {
        let ended = run(&[
            &["photograph", text(&path), "-o", text(&folder.join("no"))][..],
            &more,
        ]
        .concat());
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(ended.err.contains(words), "{}", ended.err);
        assert!(!folder.join("no").exists());
    }
}

/// After a dark frame a warm walk begins from nothing, with the whole budget, as a cold one does.
#[test]
fn after_a_dark_frame_nothing_is_warm() {
    let folder = fresh_folder("tomography_dark");
    let lit = [0.0, 0.0, 1.0, 3.0, 3.0, 1.0, 0.0, 0.0];
    let frames = [lit, [0.0; 8], lit].concat();
    fs::write(folder.join("q.npy"), npy(&[3, 8], &frames)).unwrap();
    let camera = |azimuth: f64| format!("[[camera]]\nazimuth = {azimuth}\npitch = 0.125\nfile = \"q.npy\"\n");
    let path = folder.join("views.toml");
    let both = format!("[box]\ncells = [8, 8]\n{}{}", camera(0.0), camera(90.0));
    fs::write(&path, both).unwrap();
    let density = |warm: &str| {
        let (out, key) = (folder.join(warm), format!("tomography.warm={warm}"));
        let set = ["--set", "tomography.budget=20000", "--set", &key];
        let ended = reconstruct(&path, &out, &set);
        assert_eq!(ended.code, 0, "{}", ended.err);
        read(&out.join("result.npz"))["density"].data.clone()
    };
    let cold = density("false");
    assert!(cold[128..].iter().sum::<f64>() > 4.0);
    assert_eq!(cold, density("true"));
}

/// Levels as screens show them, before a bright ground, are the light that they were made of.
#[test]
fn levels_of_screens_and_a_background_are_taken_off() {
    let folder = fresh_folder("tomography_light");
    let light = [0.0, 0.1, 0.3, 0.5, 0.5, 0.3, 0.1, 0.0];
    let ground = [0.2, 0.21, 0.22, 0.23, 0.24, 0.25, 0.26, 0.27];
    let coded = |light: f64| {
        if light <= 0.003_130_8 {
            12.92 * light
        } else {
            1.055 * light.powf(1.0 / 2.4) - 0.055
        }
    };
    let seen: Vec<f64> = light
        .iter()
        .zip(ground)
        .map(|(light, ground)| coded(light + ground))
        .collect();
    let empty: Vec<f64> = ground.iter().map(|&ground| coded(ground)).collect();
    let dim = light.map(|light| light / 4.0);
    for (name, values) in [
        ("plain", &light[..]),
        ("seen", &seen),
        ("empty", &empty),
        ("dim", &dim),
    ] {
        fs::write(folder.join(format!("{name}.npy")), npy(&[8], values)).unwrap();
    }
    let found = |name: &str, pictures: &str, camera: &str| {
        let one = |azimuth: f64| {
            format!("[[camera]]\nazimuth = {azimuth}\npitch = 0.125\nfile = \"{name}.npy\"\n{camera}")
        };
        let text = format!(
            "[box]\ncells = [8, 8]\n[pictures]\n{pictures}{}{}",
            one(0.0),
            one(90.0)
        );
        let path = folder.join(format!("{name}.toml"));
        fs::write(&path, text).unwrap();
        let ended = reconstruct(&path, &folder.join(name), &["--set", "tomography.method=sart"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        read(&folder.join(name).join("result.npz"))["density"]
            .data
            .clone()
    };
    let plain = found("plain", "", "");
    let taken = found("seen", "light = \"srgb\"\n", "background = \"empty.npy\"\n");
    assert!(plain.iter().sum::<f64>() > 0.1);
    assert_eq!(found("dim", "", "scale = 4.0\n"), plain);
    for (plain, taken) in plain.iter().zip(&taken) {
        assert!((plain - taken).abs() < 1e-5, "{plain} and {taken}");
    }
    fs::write(folder.join("short.npy"), npy(&[7], &empty[..7])).unwrap();
    for (pictures, camera, words) in [
        ("light = \"film\"\n", "", "pictures.light"),
        ("", "background = -1.0\n", "write a number from 0"),
        ("", "background = \"short.npy\"\n", "give one of the same size"),
        ("", "background = \"none.npy\"\n", "none.npy"),
        ("", "scale = 0.0\n", "camera[0].scale"),
    ] {
        let text = format!(
            "[box]\ncells = [8, 8]\n[pictures]\n{pictures}[[camera]]\nazimuth = 0.0\npitch = 0.125\nfile = \"seen.npy\"\n{camera}"
        );
        let path = folder.join("wrong.toml");
        fs::write(&path, text).unwrap();
        let ended = reconstruct(&path, &folder.join("wrong"), &[]);
        assert!(
            [2, 4].contains(&ended.code) && ended.err.contains(words),
            "{words}: {}",
            ended.err
        );
    }
}

/// A truth of fewer frames than are reconstructed is refused, and fits those that it has.
#[test]
fn a_truth_that_ends_early_is_refused() {
    let (folder, views) = views("tomography_truth", 2, &[]);
    let truth = views.join("truth.npz");
    let density = &read(&truth)["density"];
    let (cells, count) = (&density.shape[1..], density.data.len() / 2);
    let first = npy(&[1, cells[0], cells[1]], &density.data[..count]);
    write(&truth, &[("density", first)]);
    let out = folder.join("out");
    let ended = reconstruct(&views, &out, &[]);
    assert_eq!(ended.code, 2, "{}", ended.err);
    for words in [
        "truth.npz",
        "has 1 frames, and the pictures need 2",
        "pictures.last",
    ] {
        assert!(ended.err.contains(words), "{}", ended.err);
    }
    let one = ["--set", "pictures.last=0", "--set", "tomography.budget=1000"];
    let ended = reconstruct(&views, &out, &one);
    assert_eq!(ended.code, 0, "{}", ended.err);
}

/// Cameras that see smoke, but never in the same place, leave nothing, and the user hears of it.
#[test]
fn cameras_that_agree_on_nothing_are_told_of() {
    let (folder, views) = views("tomography_nowhere", 2, &[]);
    let pictures = views.join("pictures.npz");
    let arrays = read(&pictures);
    let narrowed = arrays.iter().map(|(name, array)| {
        let width = *array.shape.last().unwrap();
        let mut values = array.data.clone();
        for row in values.chunks_exact_mut(width) {
            // One pixel at the edge of what was seen: those of all cameras have no cell in common.
            let lit = row.iter().position(|&value| value > 0.0).unwrap();
            let kept = row[lit];
            row.fill(0.0);
            row[lit] = kept;
        }
        (name.as_str(), npy(&array.shape, &values))
    });
    write(&pictures, &narrowed.collect::<Vec<_>>());
    let out = folder.join("out");
    let ended = run(&[
        "tomography",
        text(&views),
        "-o",
        text(&out),
        "--set",
        "tomography.budget=1e4",
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let words =
        "frame 0 holds no smoke: there is no cell in which all cameras see some, or none that is worth";
    assert!(ended.err.contains(words), "{}", ended.err);
    assert!(
        read(&out.join("result.npz"))["density"]
            .data
            .iter()
            .all(|&value| value == 0.0)
    );
}

/// Cameras that cannot all be right leave most of their pictures unexplained, which is said and written.
#[test]
fn cameras_that_contradict_each_other_are_told_of() {
    let (folder, views) = views("tomography_contradicts", 2, &["--pinhole"]);
    let good = fs::read_to_string(views.join("views.toml")).unwrap();
    // One of six sees twenty times the light.
    let file = "file = \"pictures.npz\"\narray = \"camera_1\"";
    let wrong = good.replace(file, &format!("scale = 20\n{file}"));
    assert_ne!(good, wrong);
    fs::write(views.join("views.toml"), wrong).unwrap();
    let out = folder.join("out");
    let ended = reconstruct(&views, &out, &["--set", "tomography.budget=1e5"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let remarks = json(&out.join("report.json"))["remarks"].to_string();
    assert!(remarks.contains("of its pictures unexplained"), "{remarks}");
}

/// A camera given as a matrix sees what the same camera given by its place sees.
#[test]
fn a_matrix_is_the_same_camera() {
    let (folder, views) = views("tomography_matrix", 3, &["--pinhole", "--elevation", "0"]);
    let good = fs::read_to_string(views.join("views.toml")).unwrap();
    let number = |key: &str| -> Vec<f64> {
        let rest = good.split(key).nth(1).unwrap().lines().next().unwrap();
        rest.trim_matches(|c: char| " =[]".contains(c))
            .split(", ")
            .map(|x| x.parse().unwrap())
            .collect()
    };
    let (eye, angle) = (number("position"), number("field_of_view")[0]);
    let pictures = read(&views.join("pictures.npz"));
    let [height, width] = pictures["camera_0"].shape[1..] else {
        unreachable!()
    };
    // The first camera looks along y: u = f (x - ex) / (y - ey) + w/2, v = -f (z - ez) / (y - ey) + h/2.
    let f = 0.5 * width as f64 / (0.5 * angle).to_radians().tan();
    let (cx, cy) = (0.5 * width as f64, 0.5 * height as f64);
    let rows = [
        [f, cx, 0.0, -f * eye[0] - cx * eye[1]],
        [0.0, cy, -f, f * eye[2] - cy * eye[1]],
        [0.0, 1.0, 0.0, -eye[1]],
    ];
    let start = good.find("kind = \"pinhole\"").unwrap();
    let end = start + good[start..].find("file =").unwrap();
    let changed = format!(
        "{}kind = \"matrix\"\nmatrix = {rows:?}\n{}",
        &good[..start],
        &good[end..]
    );
    fs::write(views.join("matrix.toml"), changed).unwrap();
    let density = |file: &str| {
        let out = folder.join(file);
        let ended = reconstruct(
            &views.join(file),
            &out,
            &[
                "--precision",
                "f64",
                "--set",
                "tomography.budget=20000",
                "--set",
                "pictures.last=0",
            ],
        );
        assert_eq!(ended.code, 0, "{}", ended.err);
        let cameras = report(&out)["cameras"][0].clone();
        (cameras, read(&out.join("result.npz"))["density"].data.clone())
    };
    let ((by_place, one), (by_matrix, other)) = (density("views.toml"), density("matrix.toml"));
    for key in ["eye", "across", "down", "forward", "at"] {
        let list = |value: &Value| -> Vec<f64> {
            value[key]
                .as_array()
                .unwrap()
                .iter()
                .map(|x| x.as_f64().unwrap())
                .collect()
        };
        for (one, other) in list(&by_place).iter().zip(list(&by_matrix)) {
            assert!(
                (one - other).abs() < 1e-6 * one.abs().max(1.0),
                "{key}: {one} {other}"
            );
        }
    }
    let (sum, apart): (f64, f64) = (
        one.iter().sum(),
        one.iter().zip(&other).map(|(a, b)| (a - b).abs()).sum(),
    );
    assert!(apart < 0.2 * sum, "{apart} of {sum}");
}

/// Ctrl-C: what is done is written.
#[test]
#[cfg(unix)]
fn an_interrupt_leaves_what_is_done() {
    use crate::support::endless::Endless;
    let (folder, views) = views("tomography_interrupt", 2, &[]);
    let out = folder.join("out");
    let mut command = crate::support::thurible();
    command.args([
        "tomography",
        text(&views),
        "--json",
        "-o",
        text(&out),
        "--threads",
        "1",
    ]);
    command.args([
        "--set",
        "tomography.budget=1e9",
        "--set",
        "tomography.tolerance=0",
    ]);
    let running = Endless::seen(&mut command, |line| line.contains("\"plan\""));
    std::thread::sleep(core::time::Duration::from_millis(300));
    let ended = running.stop();
    assert_eq!(ended.code, 130, "{}", ended.err);
    let report = report(&out);
    assert_eq!(report["status"], "cancelled");
    assert_eq!(report["steps"], 0);
    assert!(
        read(&out.join("result.npz"))["density"]
            .data
            .iter()
            .any(|&value| value > 0.0)
    );
}

/// A camera that is made a novel view is photographed again without its pictures, with a volume and without.
#[test]
fn novel_views_are_reconstructed() {
    for (dims, most) in [(2, 0.25), (3, 0.5)] {
        let (folder, views) = views(&format!("tomography_novel_{dims}"), dims, &[]);
        let file = views.join("views.toml");
        let written = fs::read_to_string(&file).unwrap();
        let (before, after) = written.rsplit_once("[[camera]]").unwrap();
        fs::write(&file, format!("{before}[[novel]]{after}")).unwrap();
        for (prior, more) in [
            ("sad", &[][..]),
            ("image_tv", &[]),
            ("image_sad", &["--set", "tomography.volume=true"]),
        ] {
            let out = folder.join(prior);
            let prior_key = format!("tomography.prior=\"{prior}\"");
            let set = ["--set", &prior_key, "--set", "tomography.budget=2e5"];
            let ended = reconstruct(&views, &out, &[&set[..], more].concat());
            assert_eq!(ended.code, 0, "{}", ended.err);
            let (report, arrays) = (report(&out), read(&out.join("result.npz")));
            let volume = prior != "image_tv";
            assert_eq!(arrays.contains_key("density"), volume, "{prior}");
            assert_eq!(report["tomography"]["volume"], volume);
            assert_eq!(arrays["novel_0"].shape.len(), dims);
            assert!(!arrays.contains_key("reprojection_5"));
            let far = report["novel"][0]["relative_error"].as_f64().unwrap();
            assert!(far < most, "{prior}, {dims}D: {far}");
            let page = fs::read_to_string(out.join("report.html")).unwrap();
            assert!(page.contains("Novel views in frame") && page.contains("as it was photographed"));
            assert_eq!(page.contains("The density"), volume);
        }
        let (views, out) = (views.as_path(), folder.join("refused"));
        let refused = |text: &str, more: &[&str], said: &[&str]| {
            fs::write(&file, text).unwrap();
            let ended = reconstruct(views, &out, more);
            assert_eq!(ended.code, 2, "{}", ended.err);
            for words in said {
                assert!(ended.err.contains(words), "{words}: {}", ended.err);
            }
        };
        let on_images = ["--set", "tomography.prior=\"image_sad\""];
        refused(
            &written,
            &on_images,
            &["tomography.prior", "there is no novel view; add a [[novel]]"],
        );
        let sad = [
            "--set",
            "tomography.prior=sad",
            "--set",
            "tomography.volume=false",
        ];
        let words = ["`tomography.volume` is false", "the prior sad is on the volume"];
        refused(&written, &sad, &words);
        let bare = "kind = \"orthographic\"\nazimuth = 40.0\npitch = 0.05\n";
        let novel = |more: &str| format!("{written}\n[[novel]]\n{bare}{more}\n");
        refused(&novel(""), &[], &["novel[0]", "neither pictures nor a size"]);
        refused(
            &novel("size = [4, 4, 4]"),
            &[],
            &["novel[0].size", "write how large its picture is"],
        );
        let size = if dims == 2 {
            "size = [30]"
        } else {
            "size = [30, 20]"
        };
        let warm = ["--set", "tomography.warm=true"];
        refused(
            &novel(size),
            &[&on_images[..], &warm].concat(),
            &["tomography.warm", "no volume is kept"],
        );
        let away = format!(
            "{size}\ncenter = {}",
            if dims == 2 {
                "[90.0, 0.0]"
            } else {
                "[90.0, 0.0, 0.0]"
            }
        );
        refused(&novel(&away), &[], &["novel[0]", "sees nothing of the box"]);
        let sized = format!("{before}[[camera]]\n{size}{after}");
        refused(&sized, &[], &["size", "is for novel views without pictures"]);
        fs::write(&file, novel(size)).unwrap();
        let ended = reconstruct(views, &out, &["--set", "tomography.budget=2e4"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        assert!(report(&out)["novel"][0]["relative_error"].is_null());
    }
}

/// A file of views that somebody has changed is not written over; one that nobody has touched is.
#[test]
fn views_that_were_changed_stay() {
    let (folder, views) = views("tomography_changed_views", 2, &[]);
    let again = [
        "photograph",
        text(&folder.join("density.npy")),
        "--views",
        "3",
        "--quiet",
        "-o",
        text(&views),
    ]
    .map(String::from);
    let again = again.each_ref().map(String::as_str);
    assert_eq!(run(&again).code, 0);
    let file = views.join("views.toml");
    let mine = fs::read_to_string(&file).unwrap() + "\n[tomography]\ngamma = 0.2\n";
    fs::write(&file, &mine).unwrap();
    let refused = run(&again);
    assert!(
        refused.code == 4 && refused.err.contains("--force"),
        "{}",
        refused.err
    );
    assert_eq!(fs::read_to_string(&file).unwrap(), mine);
    assert_eq!(run(&[&again[..], &["--force"]].concat()).code, 0);
    // A result whose report says nothing of its box is no subject.
    let result = folder.join("result");
    fs::create_dir(&result).unwrap();
    fs::write(result.join("result.npz"), b"").unwrap();
    fs::write(result.join("report.json"), "{").unwrap();
    let refused = run(&["photograph", text(&result), "-o", text(&folder.join("no"))]);
    assert!(
        refused.code != 0 && refused.err.contains("report.json"),
        "{}",
        refused.err
    );
}
