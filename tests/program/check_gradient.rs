//! `thurible check-gradient`: gradients of scenes are exact, and what cannot be checked is refused.

use crate::small::refused;
use crate::support::{bytes_after, run};
use serde_json::Value;

fn checked(scene: &str, more: &[&str]) -> Value {
    let scene = format!("examples/{scene}.toml");
    let arguments = [&["check-gradient", &scene, "--json", "--threads", "1"], more].concat();
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{scene}: {}{}", ended.out, ended.err);
    let line = ended.out.lines().last().unwrap();
    serde_json::from_str(line).unwrap()
}

#[test]
fn gradients_of_scenes_are_exact() {
    for (scene, cells) in [
        ("small_odd", None),
        ("small_3d", None),
        ("effects/two_vents", Some("grid.cells=[24, 24]")),
        ("effects/head", Some("grid.cells=[24, 24]")),
    ] {
        let more: Vec<&str> = cells.into_iter().flat_map(|cells| ["--set", cells]).collect();
        let said = checked(scene, &more);
        assert_eq!(said["event"], "gradient_check");
        assert_eq!(said["exact"], true, "{scene}: {said}");
        assert_eq!(said["rows"].as_array().unwrap().len(), 5);
        let parts = said["parts"].as_object().unwrap().values();
        let sum: f64 = parts.map(|part| part.as_f64().unwrap()).sum();
        let whole = said["derivative"].as_f64().unwrap();
        assert!((sum - whole).abs() < 1e-9 * whole.abs(), "{scene}: {said}");
    }
}

#[test]
fn fewer_states_are_kept_under_a_limit_and_the_gradient_is_the_same() {
    let whole = checked("small_odd", &[]);
    let few = checked("small_odd", &["--memory-limit", "700KiB"]);
    assert!(few["slots"].as_u64() < whole["slots"].as_u64());
    assert!(few["repeated_steps"].as_u64() > whole["repeated_steps"].as_u64());
    assert_eq!(
        (&few["derivative"], &few["rows"]),
        (&whole["derivative"], &whole["rows"])
    );
    // The ceiling that the refusal names is enough, and a byte less is not.
    let under = |limit: &str| {
        let scene = ["check-gradient", "examples/small_odd.toml", "--threads", "1"];
        run(&[&scene[..], &["--memory-limit", limit]].concat())
    };
    let refusal = under("100KiB");
    assert_eq!(refusal.code, 3);
    let needed = bytes_after(&refusal.err, "the check needs ");
    assert_eq!(under(&(needed - 1).to_string()).code, 3);
    let least = under(&needed.to_string());
    assert_eq!(least.code, 0, "{}", least.err);
}

/// The gradient of the search, by each of its controls alone and by several at once.
#[test]
fn gradients_of_stable_fluids_are_exact() {
    let templates = "template=[{ kind = \"wind\", center = [0.5, 0.4], radius = 0.3, interval = 3, move = true, amplitude = [0.1, 0.2] }, { kind = \"vortex\", center = [0.4, 0.5], radius = 0.2 }]";
    let fluids = ["--set", "method.name=stable_fluids"];
    for (scene, control, cells) in [
        ("small_letter", "[\"initial_velocity\"]", "[24, 24]"),
        ("small_letter", "[\"forces\"]", "[24, 24]"),
        ("small_letter", "[\"initial_velocity\", \"forces\"]", "[24, 24]"),
        ("small_letter", "[\"templates\"]", "[24, 24]"),
        ("small_3d", "[\"initial_velocity\"]", "[12, 12, 12]"),
    ] {
        let control = format!("method.stable_fluids.control={control}");
        let cells = format!("grid.cells={cells}");
        for slots in ["method.stable_fluids.slots=0", "method.stable_fluids.slots=3"] {
            let mut more = vec!["--set", &control, "--set", &cells, "--set", slots];
            if control.contains("templates") {
                more.extend(["--set", templates]);
            }
            let said = checked(scene, &[&fluids[..], &more].concat());
            assert_eq!(said["exact"], true, "{scene}, {control}: {said}");
            let parts = said["parts"].as_object().unwrap();
            assert!(
                !parts.is_empty() && parts.keys().all(|name| control.contains(name.as_str())),
                "{said}"
            );
        }
    }
    let whole = run(&[
        &[
            "check-gradient",
            "examples/small_letter.toml",
            "--set",
            "method.stable_fluids.slots=0",
        ],
        &fluids[..],
    ]
    .concat());
    assert!(whole.out.contains(" bytes, all steps kept"), "{}", whole.out);
    let free = ["--set", "keyframe=[]"];
    refused(
        &run(&[
            &["check-gradient", "examples/small_letter.toml"],
            &fluids[..],
            &free,
        ]
        .concat()),
        &["`keyframe`"],
    );
}

/// A second solve in place of the adjoint is right only where the first one converged: five iterations are not enough.
#[test]
fn a_wrong_gradient_is_said_to_be_wrong() {
    let arguments = [
        "check-gradient",
        "examples/small_letter.toml",
        "--set",
        "method.name=stable_fluids",
        "--set",
        "method.stable_fluids.pressure=cg",
        "--set",
        "method.stable_fluids.adjoint=second_solve",
    ];
    let ended = |iterations: &str, more: &[&str]| {
        let iterations = format!("method.stable_fluids.cg_iterations={iterations}");
        run(&[&arguments[..], &["--set", &iterations], more].concat())
    };
    let enough = ended("500", &[]);
    assert_eq!(enough.code, 0, "{}{}", enough.out, enough.err);
    assert!(enough.out.contains("the gradient is exact"), "{}", enough.out);
    let few = ended("5", &[]);
    assert_eq!(few.code, 1, "{}{}", few.out, few.err);
    assert!(few.out.contains("the gradient is WRONG"), "{}", few.out);
    let json = ended("5", &["--json"]);
    assert_eq!(json.code, 1, "{}{}", json.out, json.err);
    let line: Value = serde_json::from_str(json.out.lines().last().unwrap()).unwrap();
    assert_eq!(line["exact"], false, "{line}");
}

#[test]
fn single_precision_is_refused() {
    refused(
        &run(&["check-gradient", "examples/small_odd.toml", "--precision", "f32"]),
        &["--precision f32", "leave it out"],
    );
}
