//! Scenes that make smoke on the way, let it rise, weigh and hold their keyframes, and let go of it: solved by the program, and checked.

use crate::small::refused;
use crate::support::verify::{Outcome, verify};
use crate::support::{fresh_folder, json, npz, run};
use std::fs;

/// Everything at once in 2D, but for what a test sets otherwise.
const ALL: &str = "\
[grid]
cells = [24, 20]
[time]
steps = 14
[source]
circle = { center = [0.5, 0.25], radius = 0.12 }
[[emitter]]
from = 1
to = 7
rate = 0.2
box = { min = [0.3, 0.05], max = [0.6, 0.2] }
[[keyframe]]
step = 5
weight = 2.5
circle = { center = [0.4, 0.4], radius = 0.2 }
region = { box = { min = [0, 0], max = [0.5, 1] } }
[[keyframe]]
step = 9
hold = 2
circle = { center = [0.55, 0.5], radius = 0.22 }
[[release]]
from = 11
[control]
schedule = [[2, 1.0], [9, 0.2]]
mask = { box = { min = [0.1, 0], max = [0.9, 1] } }
[flow]
buoyancy = 5e-3
viscosity = 1e-4
[method]
iterations = 4
[output]
frames = false
";

/// The mask in [`ALL`].
const MASK: &str = "mask = { box = { min = [0.1, 0], max = [0.9, 1] } }\n";

/// Writes `scene`, runs `command` on it with `more` arguments into a fresh folder, demands that it ends well, and checks what came of it.
fn checked(test: &str, scene: &str, command: &str, more: &[&str]) -> Outcome {
    let folder = fresh_folder(test);
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&path, scene).unwrap();
    let mut arguments = vec![
        command,
        path.to_str().unwrap(),
        "--quiet",
        "-o",
        out.to_str().unwrap(),
    ];
    arguments.extend(more);
    let ended = run(&arguments);
    assert!(
        ended.code == 0 || ended.code == 5,
        "{test}: exit code {}, {}",
        ended.code,
        ended.err
    );
    verify(test, &out)
}

/// That an outcome of [`ALL`] is said to have what it has.
fn has_all(outcome: &Outcome) {
    let report = &outcome.report;
    assert_eq!(report["emission"], true);
    assert_eq!(report["release"], 11);
    assert_eq!(
        outcome.weights,
        [2.5, 1.0, 1.0, 1.0],
        "one for each step of a keyframe"
    );
    assert_eq!((outcome.regions.len(), outcome.targets.len()), (4, 4));
    let mask = outcome.mask.as_ref();
    assert!(mask.is_some_and(|mask| mask.max_abs() > 0.9 && mask.data.iter().any(|&x| x < 0.3)));
    let factors = &outcome.schedule;
    assert_eq!(factors.len(), outcome.force.len());
    assert!(
        factors[..=2]
            .iter()
            .chain(&factors[9..])
            .all(|factor| [1.0, 0.2].contains(factor))
            && factors[2..=9].windows(2).all(|pair| pair[0] > pair[1]),
        "{factors:?}"
    );
    let emits = |step: usize| outcome.emission[step].sum() > 0.0;
    assert_eq!(outcome.emission.len(), outcome.velocity.len());
    assert!((0..outcome.emission.len()).all(|step| emits(step) == (1..7).contains(&step)));
    // Force in slot k turns v_k into v_{k+1}, so from slot 10 on there is none.
    let acts = |slot: &Vec<_>| {
        slot.iter()
            .any(|field: &crate::support::field::Field| field.max_abs() > 0.0)
    };
    assert!(acts(&outcome.force[9]) && outcome.force[10..].iter().all(|slot| !acts(slot)));
}

/// With a flow that sticks to the walls.
#[test]
fn everything_at_once_in_a_sticky_box() {
    let sticky = ["--set", "flow.slip=false", "--set", "flow.viscosity=1e-2"];
    let outcome = checked("effects_sticky", ALL, "solve", &sticky);
    has_all(&outcome);
    assert_eq!(outcome.report["slip"], false);
    let multigrid = ["solve", "examples/small_letter.toml", "--method", "admm"];
    let ended = run(&[&multigrid[..], &sticky].concat());
    refused(&ended, &["`flow.slip` is more than", "nso", "newton_cg"]);
}

/// Smoke everywhere, which rises along a ring between two walls, comes to the parabola of Poiseuille.
#[test]
fn a_flow_that_sticks_becomes_a_parabola() {
    let scene = "[grid]\ncells = [8, 16]\nboundary = [\"periodic\", \"wall\"]\n[time]\nsteps = 60\n[source]\nbox = { min = [-1, -1], max = [2, 2] }\n\
        [flow]\nviscosity = 0.02\nslip = false\nbuoyancy = 1e-3\ngravity = [-1, 0]\n[output]\nframes = false\n";
    let folder = fresh_folder("poiseuille");
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&path, scene).unwrap();
    let ended = run(&[
        "simulate",
        path.to_str().unwrap(),
        "--quiet",
        "-o",
        out.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let outcome = Outcome::read(&out);
    let (last, h) = (outcome.velocity.last().unwrap(), 1.0 / 16.0);
    for at in crate::support::field::indices(last[0].size) {
        let y = (at[1] as f64 + 0.5) * h;
        let expected = 1e-3 / 0.02 * (0.5 * y * (1.0 - y) + h * h / 8.0);
        let found = last[0].at(at);
        assert!(
            (found - expected).abs() < 1e-3 * expected,
            "at {y}: {found} and not {expected}"
        );
    }
}

#[test]
fn everything_at_once_by_direct() {
    has_all(&checked("effects_direct", ALL, "solve", &[]));
}

/// In double precision, with a ring along x and gravity along it.
#[test]
fn everything_at_once_on_a_ring() {
    let ring = [
        "--precision",
        "f64",
        "--set",
        "grid.boundary=[\"periodic\", \"wall\"]",
        "--set",
        "flow.gravity=[1, 0]",
    ];
    let outcome = checked("effects_ring", ALL, "solve", &ring);
    has_all(&outcome);
    assert_eq!(
        (
            &outcome.report["gravity_axis"],
            outcome.report["buoyancy"].as_f64()
        ),
        (&0.into(), Some(-5e-3))
    );
}

#[test]
fn everything_at_once_in_3d() {
    let solid = ALL
        .replace("[24, 20]", "[12, 9, 10]")
        .replace(
            "min = [0.3, 0.05], max = [0.6, 0.2]",
            "min = [0.3, 0.2, 0.05], max = [0.6, 0.5, 0.2]",
        )
        .replace(
            "min = [0, 0], max = [0.5, 1]",
            "min = [0, 0, 0], max = [0.5, 1, 1]",
        )
        .replace(
            "min = [0.1, 0], max = [0.9, 1]",
            "min = [0.1, 0, 0], max = [0.9, 1, 1]",
        )
        .replace("circle", "sphere")
        .replace("iterations = 4", "iterations = 2");
    let outcome = checked("effects_3d", &solid, "solve", &[]);
    has_all(&outcome);
    assert_eq!(outcome.report["gravity_axis"], 2, "buoyancy is along z");
}

#[test]
fn everything_at_once_by_lbfgs() {
    has_all(&checked("effects_lbfgs", ALL, "solve", &["--method", "lbfgs"]));
}

#[test]
fn everything_at_once_by_pd() {
    has_all(&checked("effects_pd", ALL, "solve", &["--method", "pd"]));
}

/// A free flow has emitters and buoyancy; keyframes and what belongs to them are left out.
/// Each effect of the gallery comes to a result, on a few cells and after one iteration.
#[test]
fn the_scenes_of_the_gallery_run_small() {
    for (scene, cells) in [
        ("effects/candle", "[24, 32]"),
        ("effects/flue", "[24, 32]"),
        ("effects/gate", "[32, 24]"),
        ("effects/head", "[24, 32]"),
        ("effects/late", "[32, 32]"),
        ("effects/parade", "[24, 24]"),
        ("effects/two_vents", "[32, 24]"),
        ("effects/wall", "[64, 64]"),
        ("effects/whirl", "[24, 16]"),
        ("logo_wind", "[48, 48]"),
        ("plume_to_horse", "[12, 12, 12]"),
    ] {
        let out = fresh_folder(&format!("gallery_{}", scene.replace('/', "_")));
        let ended = run(&[
            "solve",
            &format!("examples/{scene}.toml"),
            "--set",
            &format!("grid.cells={cells}"),
            "--set",
            "method.iterations=1",
            "--set",
            "output.frames=false",
            "--quiet",
            "-o",
            out.to_str().unwrap(),
        ]);
        assert!(matches!(ended.code, 0 | 5), "{scene}: {}", ended.err);
        let report = json(&out.join("report.json"));
        let missed = report["keyframes"].as_array().unwrap();
        assert!(
            !missed.is_empty() && report["objective"]["total"].as_f64().unwrap() > 0.0,
            "{scene}"
        );
    }
}

#[test]
fn emitted_smoke_rises_freely() {
    let outcome = checked("effects_simulate", ALL, "simulate", &[]);
    assert!(outcome.targets.is_empty() && outcome.report["release"].is_null());
    let (first, last) = (&outcome.density[0], outcome.density.last().unwrap());
    assert!(last.sum() > 1.5 * first.sum(), "nothing was emitted");
}

/// Gravity along no axis of the box.
#[test]
fn smoke_rises_along_any_direction() {
    let outcome = checked(
        "effects_slanted",
        ALL,
        "solve",
        &["--set", "flow.gravity=[3, -4]"],
    );
    let report = &outcome.report;
    assert!(report["gravity_axis"].is_null(), "{}", report["gravity_axis"]);
    for (axis, expected) in [-3e-3, 4e-3].into_iter().enumerate() {
        let found = report["acceleration"][axis].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
}

/// A result goes on with the scene's emitters.
#[test]
fn a_result_is_continued_with_emitters() {
    let folder = fresh_folder("effects_continued");
    let scene = folder.join("scene.toml");
    fs::write(&scene, ALL).unwrap();
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (scene, before, after) = (path("scene.toml"), path("before"), path("after"));
    let ended = run(&[
        "solve",
        &scene,
        "--quiet",
        "--set",
        "method.iterations=1",
        "-o",
        &before,
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let ended = run(&["simulate", &scene, "--quiet", "--from", &before, "-o", &after]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let outcome = verify("continued with emitters", after.as_ref());
    assert!(outcome.emission[1].sum() > 0.0);
}

/// Other sizes and lengths of a scene are planned with its emitters, schedule and release at their share of the time.
#[test]
fn effects_are_planned_at_other_sizes() {
    let folder = fresh_folder("effects_plan");
    let scene = folder.join("scene.toml");
    fs::write(&scene, ALL).unwrap();
    let ended = run(&["plan", scene.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let (_, others) = ended.out.split_once("f64 bytes\n").unwrap();
    let sizes = others.lines().take_while(|line| !line.is_empty());
    assert!(
        sizes.clone().count() > 4 && sizes.clone().all(|line| !line.ends_with('-')),
        "{others}"
    );
}

/// Smoke that is filled up to a density, from nothing.
const FILLED: &str = "\
[grid]
cells = [20, 24]
[time]
steps = 10
[[emitter]]
to = 6
target = 0.8
circle = { center = [0.4, 0.2], radius = 0.1 }
[[keyframe]]
step = 10
circle = { center = [0.4, 0.5], radius = 0.12 }
[control]
match_mass = false
[flow]
buoyancy = 1e-2
[method]
iterations = 4
[output]
frames = false
";

#[test]
fn smoke_is_filled_up_to_a_target() {
    for method in ["direct", "lbfgs", "pd"] {
        let outcome = checked(
            &format!("effects_filled_{method}"),
            FILLED,
            "solve",
            &["--method", method],
        );
        assert_eq!(outcome.density[0].max_abs(), 0.0, "there is no source");
        // In the middle of the emitter the shape is 1, and its density is kept there.
        for step in 1..=6 {
            let kept = outcome.density[step].at([8, 4, 0]);
            assert!((0.7..0.85).contains(&kept), "{method}, step {step}: {kept}");
        }
        assert!(outcome.emission[5].sum() > 0.0 && outcome.emission[6].sum() == 0.0);
    }
}

/// What ADMM can do of it: emitters, buoyancy, weights, regions, holds and a release.
#[test]
fn admm_knows_emitters_buoyancy_weights_and_regions() {
    let scene = ALL
        .replace("schedule = [[2, 1.0], [9, 0.2]]\n", "")
        .replace(MASK, "");
    for precision in ["f32", "f64"] {
        let test = format!("effects_admm_{precision}");
        let outcome = checked(
            &test,
            &scene,
            "solve",
            &["--method", "admm", "--precision", precision],
        );
        assert_eq!(outcome.weights, [2.5, 1.0, 1.0, 1.0]);
        assert!(!outcome.emission.is_empty() && outcome.regions.len() == 4 && outcome.schedule.is_empty());
    }
}

#[test]
fn admm_refuses_what_it_cannot() {
    let folder = fresh_folder("effects_admm_refuses");
    let path = folder.join("scene.toml");
    let alone = |without: &str| ALL.replace(without, "").replace(MASK, "");
    let masked =
        alone("schedule = [[2, 1.0], [9, 0.2]]\n").replace("[control]\n", &format!("[control]\n{MASK}"));
    let cases = [(
        alone(""),
        [
            "scene.toml:24: `control.schedule`",
            "method admm",
            "leave it out, or take another method",
        ],
    )];
    let cases = cases.into_iter().chain([(
        masked,
        [
            "scene.toml:24: `control.mask`",
            "method admm",
            "leave it out, or take another method",
        ],
    )]);
    for (scene, words) in cases {
        fs::write(&path, scene).unwrap();
        refused(
            &run(&["solve", path.to_str().unwrap(), "--method", "admm"]),
            &words,
        );
    }
}

/// Keyframes take the mass that the emitter makes where nobody steers.
#[test]
fn keyframes_take_the_mass_of_a_free_flow() {
    let scene = FILLED.replace("match_mass = false", "match_mass = true");
    let free = checked("effects_mass_free", &scene, "simulate", &[]);
    let steered = checked("effects_mass_steered", &scene, "solve", &[]);
    let (made, wanted) = (free.density[10].sum(), steered.targets[0].1.sum());
    assert!(
        (made - wanted).abs() < 1e-4 * made,
        "{wanted} is wanted where {made} is made"
    );
    let factor = steered.report["keyframes"][0]["mass_factor"].as_f64().unwrap();
    assert!(
        factor > 0.0 && (factor - 1.0).abs() > 1e-3,
        "a factor of {factor}"
    );
}

/// The steps of an earlier result as keyframes: the same smoke, at half its pace.
#[test]
fn an_array_over_time_is_a_sequence_of_keyframes() {
    let folder = fresh_folder("effects_sequence");
    let (first, second) = (folder.join("first.toml"), folder.join("second.toml"));
    let scene = "[grid]\ncells = [16, 16]\n[time]\nsteps = 5\n[source]\ncircle = { center = [0.4, 0.5], radius = 0.2 }\n\
                 [[keyframe]]\nstep = 5\ncircle = { center = [0.6, 0.5], radius = 0.2 }\n[output]\nframes = false\nfolder = \"one\"\n";
    fs::write(&first, scene).unwrap();
    let ended = run(&["solve", first.to_str().unwrap(), "--quiet"]);
    assert!(ended.code == 0 || ended.code == 5, "{}", ended.err);
    let sequence =
        "steps = { from = 2, every = 2 }\nfile = \"one/result.npz\"\nname = \"density\"\nweight = 2.0";
    let scene = scene
        .replace("steps = 5", "steps = 12")
        .replace(
            "step = 5\ncircle = { center = [0.6, 0.5], radius = 0.2 }",
            sequence,
        )
        .replace("\"one\"", "\"two\"");
    fs::write(&second, &scene).unwrap();
    let ended = run(&["solve", second.to_str().unwrap(), "--quiet"]);
    assert!(ended.code == 0 || ended.code == 5, "{}", ended.err);
    let [one, two] = ["one", "two"].map(|name| verify(name, folder.join(name).as_ref()));
    assert_eq!(two.targets.len(), 6);
    for (step, (_, target)) in two.targets.iter().enumerate() {
        let gap = (target.sum() - one.density[step].sum()).abs();
        assert!(gap < 1e-4 * target.sum(), "keyframe {step} has another mass");
        let at = [8, 8, 0];
        assert!(
            (target.at(at) - one.density[step].at(at)).abs() < 1e-3,
            "keyframe {step} is another"
        );
    }
    fs::write(&second, scene.replace("steps = 12", "steps = 11")).unwrap();
    let ended = run(&["solve", second.to_str().unwrap(), "--quiet"]);
    assert_eq!(ended.code, 2);
    assert!(
        ended.err.contains("put 6 shapes at steps up to 12"),
        "{}",
        ended.err
    );
}

/// Obstacles are in the result; nothing is in them.
#[test]
fn obstacles_are_in_the_result() {
    let folder = fresh_folder("effects_obstacle");
    let scene = folder.join("scene.toml");
    let text = "[grid]\ncells = [24, 24]\n[time]\nsteps = 8\n[source]\ncircle = { center = [0.3, 0.5], radius = 0.15 }\n\
                [[obstacle]]\nbox = { min = [0.45, 0.3], max = [0.55, 0.8] }\n\
                [[keyframe]]\nstep = 8\ncircle = { center = [0.72, 0.5], radius = 0.15 }\n[method]\niterations = 4\n[output]\nfolder = \"out\"\n";
    fs::write(&scene, text).unwrap();
    for method in ["direct", "lbfgs", "pd", "admm"] {
        let ended = run(&[
            "solve",
            scene.to_str().unwrap(),
            "--quiet",
            "--force",
            "--method",
            method,
        ]);
        assert!(ended.code == 0 || ended.code == 5, "{}", ended.err);
        let out = folder.join("out");
        let report = fs::read_to_string(out.join("report.json")).unwrap();
        assert!(report.contains("\"solid\": true"), "{report}");
        let mut archive = zip::ZipArchive::new(fs::File::open(out.join("result.npz")).unwrap()).unwrap();
        let mut floats = |name: &str| {
            let mut bytes = Vec::new();
            std::io::Read::read_to_end(&mut archive.by_name(name).unwrap(), &mut bytes).unwrap();
            let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            let values = bytes[head..].chunks_exact(4);
            values
                .map(|x| f32::from_le_bytes(x.try_into().unwrap()))
                .collect::<Vec<_>>()
        };
        let (solid, density) = (floats("solid.npy"), floats("density.npy"));
        assert_eq!(
            (solid.len(), solid.iter().filter(|&&x| x == 1.0).count()),
            (24 * 24, 24)
        );
        let inside = density
            .chunks_exact(24 * 24)
            .flat_map(|rho| rho.iter().zip(&solid));
        assert!(
            inside
                .filter(|&(_, &solid)| solid == 1.0)
                .all(|(&rho, _)| rho == 0.0)
        );
    }
}

/// A folder with this scene, and its path.
fn written(test: &str, scene: &str) -> [std::path::PathBuf; 2] {
    let folder = fresh_folder(test);
    let path = folder.join("scene.toml");
    fs::write(&path, scene).unwrap();
    [folder, path]
}

/// Runs what must end well, on threads or at its limit.
fn well(arguments: &[&str]) {
    let ended = run(arguments);
    assert!(
        ended.code == 0 || ended.code == 5,
        "{arguments:?}: exit code {}, {}",
        ended.code,
        ended.err
    );
}

/// What of a keyframe lies in an obstacle is lost before it takes the mass that a free flow has, as it is where the solver matches masses.
#[test]
fn a_keyframe_beside_an_obstacle_takes_the_mass_of_a_free_flow() {
    let scene = "\
[grid]
cells = [32, 32]
boundary = [\"wall\", [\"wall\", \"open\"]]
[time]
steps = 10
[source]
circle = { center = [0.3, 0.3], radius = 0.15 }
[[obstacle]]
box = { min = [0.55, 0.3], max = [0.65, 0.6] }
[[keyframe]]
step = 10
circle = { center = [0.55, 0.45], radius = 0.15 }
[method]
iterations = 6
[output]
frames = false
";
    let [folder, path] = written("effects_mass_beside", scene);
    let out = folder.join("out");
    well(&[
        "solve",
        path.to_str().unwrap(),
        "--quiet",
        "-o",
        out.to_str().unwrap(),
    ]);
    let arrays = npz::read(&out.join("result.npz"));
    let sum = |values: &[f64]| values.iter().sum::<f64>();
    let smoke = sum(&arrays["density"].data[..32 * 32]);
    let wanted = sum(&arrays["keyframe_density"].data);
    assert!((wanted / smoke - 1.0).abs() < 0.02, "{wanted} of {smoke}");
    // The layer outside of the open side is no other grid.
    let report = json(&out.join("report.json"));
    let finest = report["history"].as_array().unwrap().iter();
    let finest = finest.filter(|entry| entry["level"] == serde_json::json!([32, 32]));
    assert!(finest.count() > 0, "{report}");
}

/// A wind blows in the windows of a free flow as it blows in the whole, and only when it is told to.
#[test]
fn a_wind_blows_alike_in_windows() {
    let scene = "\
[grid]
cells = [16, 16]
[time]
steps = 12
[source]
circle = { center = [0.4, 0.4], radius = 0.15 }
[[template]]
kind = \"wind\"
center = [0.5, 0.5]
radius = 0.2
from = 1
to = 3
amplitude = [0.01, 0.0]
[[template]]
kind = \"vortex\"
center = [0.4, 0.5]
radius = 0.2
from = 6
amplitude = [0.01]
[output]
frames = false
";
    let [folder, path] = written("effects_wind_windows", scene);
    let [whole, windows] = ["whole", "windows"].map(|name| folder.join(name));
    let simulate = [
        "simulate",
        path.to_str().unwrap(),
        "--quiet",
        "--precision",
        "f64",
        "-o",
    ];
    well(&[&simulate[..], &[whole.to_str().unwrap()]].concat());
    let parted = ["--set", "method.window=4", "--set", "method.stride=2"];
    well(&[&simulate[..], &[windows.to_str().unwrap()], &parted].concat());
    let [whole, windows] = [whole, windows].map(|folder| npz::read(&folder.join("result.npz")));
    for name in ["density", "velocity_x", "velocity_y"] {
        let pairs = whole[name].data.iter().zip(&windows[name].data);
        let apart = pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6, "{name}: {apart}");
    }
}

/// What a free flow leaves out does not keep it from flowing: a schedule beyond its end, windows of a method that has none. It goes on from a
/// step before there is any smoke, too.
#[test]
fn a_free_flow_hears_nothing_of_how_it_would_be_steered() {
    let [folder, path] = written("effects_free", ALL);
    let (path, out) = (path.to_str().unwrap(), folder.join("out"));
    let simulate = [
        "simulate",
        path,
        "--quiet",
        "--force",
        "-o",
        out.to_str().unwrap(),
    ];
    well(&[&simulate[..], &["--steps", "8"]].concat());
    let windows = ["--set", "method.name=\"pd\"", "--set", "method.window=4"];
    well(&[&simulate[..], &windows].concat());
    let empty = ALL.replace("[source]\ncircle = { center = [0.5, 0.25], radius = 0.12 }\n", "");
    let [folder, path] = written("effects_from_nothing", &empty);
    let (path, first, more) = (path.to_str().unwrap(), folder.join("first"), folder.join("more"));
    well(&["simulate", path, "--quiet", "-o", first.to_str().unwrap()]);
    let from = ["--from", first.to_str().unwrap(), "--at", "0", "--steps", "8"];
    well(
        &[
            &["simulate", path, "--quiet", "-o", more.to_str().unwrap()][..],
            &from,
        ]
        .concat(),
    );
    let [first, more] = [first, more].map(|folder| npz::read(&folder.join("result.npz")));
    let cells = 24 * 20;
    let [first, more] = [&first, &more].map(|arrays| arrays["density"].data[8 * cells..9 * cells].to_vec());
    let apart = first.iter().zip(&more).map(|(one, other)| (one - other).abs());
    assert!(first.iter().sum::<f64>() > 1.0 && apart.fold(0.0, f64::max) < 1e-4);
}

/// A force that is small beside what emitters push has no more divergence than another.
#[test]
fn a_small_force_beside_a_push_is_free_of_divergence() {
    let scene = "\
[grid]
cells = [17, 27]
length = 10.0
boundary = [\"wall\", \"open_high\"]
[time]
steps = 6
[[emitter]]
box = { min = [4.083, 1.8218], max = [5.5941, 3.3329] }
target = 0.6003
to = 5
velocity = [0.3112, 0.3756]
[[emitter]]
circle = { center = [2.4918, 6.459], radius = 0.7556 }
rate = 0.1892
from = 2
velocity = [-0.1075, -0.1521]
[[obstacle]]
circle = { center = [2.0983, 2.6504], radius = 0.6296 }
[[keyframe]]
step = 5
box = { min = [0.5272, 1.119], max = [2.9901, 3.5819] }
[[release]]
from = 5
[flow]
buoyancy = -0.0073
[control]
smoothness = 4.0
[method]
iterations = 3
[[template]]
kind = \"attract\"
center = [1.2471, 8.1029]
radius = 1.6296
interval = 1
[[template]]
kind = \"noise\"
center = [4.2507, 4.6835]
radius = 1.6296
interval = 1
[output]
frames = false
";
    let [folder, path] = written("effects_small_force", scene);
    let out = folder.join("out");
    let solve = [
        "solve",
        path.to_str().unwrap(),
        "--quiet",
        "--precision",
        "f64",
        "-o",
    ];
    well(&[&solve[..], &[out.to_str().unwrap()]].concat());
    let arrays = npz::read(&out.join("result.npz"));
    let [x, y] = ["force_x", "force_y"].map(|name| &arrays[name].data);
    let (mut divergence, mut largest) = (0.0f64, 0.0f64);
    for step in 0..5 {
        for (row, column) in (0..27).flat_map(|row| (0..17).map(move |column| (row, column))) {
            let across = x[(step * 27 + row) * 18 + column..][..2].to_vec();
            let up = [row, row + 1].map(|row| y[(step * 28 + row) * 17 + column]);
            divergence = divergence.max((across[1] - across[0] + up[1] - up[0]).abs());
            largest = largest.max(across[0].abs()).max(up[0].abs());
        }
    }
    assert!(
        largest > 0.0 && divergence < 1e-4 * largest,
        "{divergence} of {largest}"
    );
}

/// Smoke in one half of the box, in a scene that is the same from left and right.
const MIRRORED: &str = "\
[grid]
cells = [16, 16]
[time]
steps = 8
[source]
circle = { center = [0.5, 0.3], radius = 0.15 }
[[keyframe]]
step = 8
circle = { center = [0.5, 0.6], radius = 0.15 }
[method]
iterations = 1
";

/// Interpolation has a kink at the centre of a cell, where all smoke comes from before anything moves: a search that went to one side of it would
/// go askew.
#[test]
fn searches_that_interpolate_take_no_side_at_rest() {
    for (name, method) in [
        ("lbfgs", "method.name=\"lbfgs\""),
        ("fluids", "method.stable_fluids.pressure=\"cg\""),
        ("pushed", "method.stable_fluids.control=[\"forces\"]"),
    ] {
        let [folder, path] = written(&format!("effects_mirrored_{name}"), MIRRORED);
        let out = folder.join("out");
        let [scene, folder] = [&path, &out].map(|path| path.to_str().unwrap());
        let of_method = match name {
            "lbfgs" => ["--set", "advection.scheme=\"semi_lagrangian\""],
            _ => ["--method", "stable_fluids"],
        };
        let solve = ["solve", scene, "--quiet", "--precision=f64", "--set", method];
        well(&[&solve[..], &of_method, &["-o", folder]].concat());
        let density = &npz::read(&out.join("result.npz"))["density"];
        // Sweeps of the pressure go one way, and what comes of that is small at first.
        let (rows, bound) = (
            density.data.chunks_exact(16),
            if name == "pushed" { 1e-2 } else { 1e-8 },
        );
        let askew = rows.flat_map(|row| (0..8).map(|x| (row[x] - row[15 - x]).abs()));
        let askew = askew.fold(0.0, f64::max);
        assert!(askew < bound, "{name}: {askew}");
        let moved = density.data[..256].iter().zip(&density.data[8 * 256..]);
        let moved = moved.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        assert!(moved > 1e-2, "{name}: {moved}");
    }
}

/// A keyframe is missed by what is wrong in its region alone.
#[test]
fn keyframe_errors_are_those_of_the_region() {
    let two = MIRRORED.replace(
        "[source]\ncircle = { center = [0.5, 0.3], radius = 0.15 }",
        "[source]\nshapes = [{ circle = { center = [0.75, 0.5], radius = 0.15 } }, { circle = { center = [0.25, 0.5], radius = 0.15 } }]",
    );
    let two = two.replace(
        "circle = { center = [0.5, 0.6], radius = 0.15 }",
        "circle = { center = [0.75, 0.5], radius = 0.15 }\nregion = { box = { min = [0.55, 0.0], max = [1.0, 1.0] } }",
    );
    let [folder, path] = written("effects_region_errors", &two);
    for (name, more) in [
        ("whole", &[][..]),
        (
            "windows",
            &["--set", "method.window=6", "--set", "method.stride=4"],
        ),
    ] {
        let out = folder.join(name);
        let out = out.to_str().unwrap();
        let mass = ["--set", "control.match_mass=false"];
        let solve = ["solve", path.to_str().unwrap(), "--quiet", "-o", out];
        well(&[&solve[..], &mass, more].concat());
        let report = json(&folder.join(name).join("report.json"));
        let error = report["keyframes"][0]["relative_l2"].as_f64().unwrap();
        assert!(error < 1e-2, "{name}: {error}");
    }
}

/// Where nothing steers the smoke leaves, and the keyframe is given what is left of it.
#[test]
fn a_keyframe_of_which_a_free_flow_leaves_little_is_told() {
    let scene = "[grid]\ncells = [16, 16]\nboundary = \"open\"\n[time]\nsteps = 20\n[flow]\nbuoyancy = 2e-2\n[source]\ncircle = { center = [0.5, 0.8], radius = 0.15 }\n[[keyframe]]\nstep = 18\ncircle = { center = [0.5, 0.5], radius = 0.15 }\n[method]\niterations = 2\n[output]\nframes = false\n";
    let [folder, path] = written("effects_faint", scene);
    let out = folder.join("out");
    let [scene, result] = [&path, &out].map(|path| path.to_str().unwrap());
    well(&["solve", scene, "--quiet", "-o", result]);
    let said = json(&out.join("report.json"))["remarks"].to_string();
    let faint = "of its mass, since no more smoke is there by then where nothing steers";
    assert!(
        said.contains("the keyframe at step 18 has ") && said.contains(faint),
        "{said}"
    );
    well(&[
        "solve",
        scene,
        "--quiet",
        "--force",
        "-o",
        result,
        "--set",
        "control.match_mass=false",
    ]);
    let said = json(&out.join("report.json"))["remarks"].to_string();
    assert!(!said.contains(faint), "{said}");
}

/// What no smoke can come to is no matter where a region leaves it out.
#[test]
fn a_region_leaves_out_what_is_cut_off() {
    let folder = fresh_folder("effects_cut_off");
    let scene = |region: &str| {
        let path = folder.join("scene.toml");
        let text = format!(
            "[grid]\ncells = [16, 16]\n[time]\nsteps = 4\n[source]\ncircle = {{ center = [0.2, 0.5], radius = 0.15 }}\n\
             [[obstacle]]\nbox = {{ min = [0.45, -1], max = [0.6, 2] }}\n[[keyframe]]\nstep = 4\n{region}\n\
             shapes = [{{ circle = {{ center = [0.2, 0.6], radius = 0.15 }} }}, {{ circle = {{ center = [0.8, 0.5], radius = 0.15 }} }}]\n"
        );
        fs::write(&path, text).unwrap();
        let out = folder.join("out");
        run(&[
            "solve",
            path.to_str().unwrap(),
            "--quiet",
            "--force",
            "--set",
            "method.iterations=1",
            "-o",
            out.to_str().unwrap(),
        ])
    };
    refused(&scene(""), &["`keyframe[0]` cannot be reached"]);
    let ended = scene("region = { box = { min = [-1, -1], max = [0.45, 2] } }");
    assert!(matches!(ended.code, 0 | 5), "{}", ended.err);
}
