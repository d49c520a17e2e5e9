//! The defaults that the schema names are those of the program: a scene that says them all is the scene that says none.

use super::{resolved, root, schema};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Scenes with little in them, and how each is solved.
const SCENES: [(&str, &str, &str); 6] = [
    (
        "direct",
        "direct",
        "[source]\ncircle = { center = [0.4, 0.5], radius = 0.2 }\n",
    ),
    (
        "admm",
        "admm",
        "[source]\ncircle = { center = [0.4, 0.5], radius = 0.2 }\n",
    ),
    (
        "lbfgs",
        "lbfgs",
        "[source]\ncircle = { center = [0.4, 0.5], radius = 0.2 }\n",
    ),
    (
        "pd",
        "pd",
        "[source]\ncircle = { center = [0.4, 0.5], radius = 0.2 }\n",
    ),
    (
        "stable_fluids",
        "stable_fluids",
        "[source]\ncircle = { center = [0.4, 0.5], radius = 0.2 }\n",
    ),
    (
        "templates",
        "templates",
        "[[emitter]]\nrate = 0.1\nbox = { min = [0.3, 0.1], max = [0.7, 0.3] }\n[[template]]\nkind = \"noise\"\ncenter = [0.5, 0.4]\nradius = 0.3\n",
    ),
];
const REST: &str = "[grid]\ncells = [12, 10]\n[time]\nsteps = 6\n[[keyframe]]\nstep = 6\ncircle = { center = [0.6, 0.5], radius = 0.2 }\n";

/// Writes into `scene` what the schema says of the keys that it leaves out; counts them.
fn complete(root: &Value, schema: &Value, scene: &mut toml::Table, shape: bool) -> usize {
    let mut count = 0;
    for (name, key) in schema["properties"].as_object().unwrap() {
        let held = resolved(root, key);
        match (key.get("default"), scene.get_mut(name)) {
            // Of a shape what goes with text, meshes and files has no place beside a circle.
            (Some(_), _) if shape && name == "weight" => {}
            (Some(value), None) => {
                scene.insert(name.clone(), toml::Value::try_from(value).unwrap());
                count += 1;
            }
            (None, Some(toml::Value::Table(table))) if held.get("properties").is_some() => {
                count += complete(root, held, table, held["properties"].get("circle").is_some());
            }
            (None, Some(toml::Value::Array(tables))) if held.get("items").is_some() => {
                let items = resolved(root, &held["items"]);
                for table in tables.iter_mut().filter_map(toml::Value::as_table_mut) {
                    count += complete(root, items, table, items["properties"].get("circle").is_some());
                }
            }
            // A table without a key that must be there.
            (None, None)
                if !shape
                    && held
                        .get("properties")
                        .is_some_and(|keys| keys.get("circle").is_none())
                    && held.get("required").is_none() =>
            {
                let mut table = toml::Table::new();
                count += complete(root, held, &mut table, false);
                scene.insert(name.clone(), table.into());
            }
            _ => {}
        }
    }
    count
}

fn solved(folder: &Path, scene: &str, method: &str) -> Vec<u8> {
    fs::create_dir_all(folder).unwrap();
    let path = folder.join("scene.toml");
    fs::write(&path, scene).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_thurible"))
        .args([
            "solve",
            path.to_str().unwrap(),
            "--method",
            method,
            "--quiet",
            "--force",
            "--threads",
            "1",
        ])
        .args([
            "--set",
            "method.iterations=2",
            "--set",
            "output.frames=false",
            "-o",
        ])
        .arg(folder.join("out"))
        .current_dir(root())
        .output()
        .unwrap();
    let code = output.status.code();
    assert!(
        [Some(0), Some(5)].contains(&code),
        "{method}: {}\n{scene}",
        String::from_utf8_lossy(&output.stderr)
    );
    fs::read(folder.join("out/result.npz")).unwrap()
}

#[test]
fn a_scene_that_says_all_defaults_is_the_one_that_says_none() {
    let schema = schema();
    for (name, method, text) in SCENES {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("book_defaults")
            .join(name);
        let bare = format!("{REST}{text}");
        let mut full: toml::Table = bare.parse().unwrap();
        let count = complete(&schema, &schema, &mut full, false);
        assert!(count > 45, "only {count} keys of {name} have a default");
        // The name is that of the command line, and ADMM takes no price of curls.
        let bare_result = solved(&folder.join("bare"), &bare, method);
        let full_result = solved(&folder.join("full"), &toml::to_string(&full).unwrap(), method);
        assert!(
            bare_result == full_result,
            "{name}: the defaults of the schema are not those of the program"
        );
    }
}
