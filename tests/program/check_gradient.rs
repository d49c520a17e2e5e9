//! `thurible check-gradient`: gradients of scenes are exact, and what cannot be checked is refused.

use crate::small::refused;
use crate::support::run;
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
    let refusal = run(&[
        "check-gradient",
        "examples/small_odd.toml",
        "--memory-limit",
        "100KiB",
    ]);
    assert_eq!(refusal.code, 3);
    assert!(
        refusal.err.contains("bytes are needed at least"),
        "{}",
        refusal.err
    );
}

/// Stable Fluids' gradient is not that of the operator: a table of that would say nothing of it.
#[test]
fn another_simulator_is_refused_by_name() {
    refused(
        &run(&[
            "check-gradient",
            "examples/small_letter.toml",
            "--set",
            "method.name=stable_fluids",
        ]),
        &[
            "`method.name` is \"stable_fluids\"",
            "--set method.name=\"lbfgs\"",
        ],
    );
}

#[test]
fn single_precision_is_refused() {
    refused(
        &run(&["check-gradient", "examples/small_odd.toml", "--precision", "f32"]),
        &["--precision f32", "leave it out"],
    );
}
