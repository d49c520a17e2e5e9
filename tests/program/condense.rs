//! `thurible condense`: presets and files to pages and folders, and everything that is refused.

use crate::support::npz::read;
use crate::support::{Ended, fresh_folder, json, run, text};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Lines of the scene of these tests: its mesh, its steps, what holds it at both sides and at the left one alone, its methods.
const MESH: &str = "grid = [2, 2], size = [1.0, 1.0]";
const TIME: &str = "time = { steps = 2 }";
const HOLD: &str = "hold = [ { box = { min = [0, 0], max = [0, 1] } }, { box = { min = [1, 0], max = [1, 1] }, move = [0.1, 0] } ]";
const LEFT: &str = "hold = [ { box = { min = [0, 0], max = [0, 1] } } ]";
const METHODS: &str = "methods = [\"cc\"]";

fn condense(folder: &Path, scene: &str, more: &[&str]) -> Ended {
    let out = folder.join("out");
    let command = ["condense", scene, "--quiet", "--force", "-o", text(&out)];
    run(&[&command, more].concat())
}

/// The folder of a scene that ends well.
fn solved(folder: &Path, scene: &str, more: &[&str]) -> PathBuf {
    let ended = condense(folder, scene, more);
    assert_eq!(ended.code, 0, "{scene}: {}", ended.err);
    folder.join("out")
}

/// A scene of a square of 2 x 2, and what is put in the place of some of its text.
fn scene(folder: &Path, changes: &[(&str, &str)]) -> String {
    let mut text = format!("mesh = {{ {MESH} }}\n{TIME}\n{HOLD}\n[solver]\n{METHODS}\n");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let path = folder.join("scene.toml");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_preset_becomes_a_page_and_a_folder_a_variant() {
    let folder = fresh_folder("condense_stretch");
    let more = [
        "--methods",
        "newton,cc,jgs2",
        "--basis",
        "fixed,corotated",
        "--set",
        "mesh.grid=[4, 4]",
        "--threads",
        "2",
    ];
    let out = solved(&folder, "stretch", &more);
    for (name, expected) in [
        ("newton", [3, 3, 3]),
        ("cc-fixed", [5, 5, 7]),
        ("cc-corotated", [5, 5, 7]),
        ("jgs2-fixed", [69, 69, 68]),
    ] {
        let report = json(&out.join(name).join("report.json"));
        assert_eq!(
            (report["kind"].as_str(), report["status"].as_str()),
            (Some("condense"), Some("converged")),
            "{name}"
        );
        let arrays = read(&out.join(name).join("result.npz"));
        let counts: Vec<f64> = arrays["iterations"].data.clone();
        let near = counts
            .iter()
            .zip(expected)
            .all(|(found, expected)| (found - f64::from(expected)).abs() <= 4.0);
        assert!(near && counts.len() == 3, "{name}: {counts:?}");
        let states = counts.iter().sum::<f64>() as usize + 3;
        assert_eq!(
            (arrays["energy"].shape.clone(), arrays["residual"].shape.clone()),
            (vec![states], vec![states])
        );
        assert_eq!(arrays["position"].shape, [4, 25, 2]);
        assert_eq!(
            (arrays["rest"].shape.clone(), arrays["elements"].shape.clone()),
            (vec![25, 2], vec![32, 3])
        );
        assert_eq!(
            (
                arrays["fixed"].kind.as_str(),
                arrays["fixed"].data.iter().sum::<f64>()
            ),
            ("|b1", 10.0)
        );
        assert_eq!(arrays["elements"].data[..6], [0.0, 1.0, 6.0, 0.0, 6.0, 5.0]);
        // The right edge was pulled by 0.1 three times, the left one is held.
        let last = &arrays["position"].data[3 * 50..];
        assert!((last[4 * 2] - 1.3).abs() < 1e-12 && last[0] == 0.0);
        let builds: f64 = arrays["builds"].data.iter().sum();
        assert_eq!(builds, if name == "newton" { 0.0 } else { 1.0 });
        let memory = &report["memory"];
        let lines = memory["ledger"].as_array().unwrap();
        let top: u64 = lines
            .iter()
            .filter(|line| line["depth"] == 0)
            .map(|line| line["bytes"].as_u64().unwrap())
            .sum();
        assert_eq!(memory["planned_bytes"].as_u64(), Some(top));
        assert!(memory["used_bytes"].as_u64().unwrap() <= top + 8192);
        assert_eq!(report["threads"], 2);
        for key in ["build", "direction", "search"] {
            assert!(report["seconds"][key].as_f64().is_some(), "{key}");
        }
    }
    let page = fs::read_to_string(out.join("condense.md")).unwrap();
    assert!(
        page.contains("| cc-corotated |") && page.contains(".svg") && page.contains(".png"),
        "{page}"
    );
    assert!(out.join("condense.html").is_file());
    assert_eq!(
        json(&out.join("condense.json"))["runs"].as_array().unwrap().len(),
        5
    );
}

#[test]
fn sweeps_make_a_row_each() {
    let folder = fresh_folder("condense_sweep");
    let more = ["--methods", "newton,cc,plain", "--set", "solver.cap=400"];
    let out = solved(&folder, "rod", &more);
    let runs = json(&out.join("condense.json"))["runs"].clone();
    let count = |case: &str, name: &str| {
        let run = runs
            .as_array()
            .unwrap()
            .iter()
            .find(|run| run["case"] == case && run["variant"] == name);
        (
            run.unwrap()["iterations"][0].as_u64().unwrap(),
            run.unwrap()["status"].as_str().unwrap().to_owned(),
        )
    };
    assert_eq!(count("young 100", "cc-fixed"), (1, "converged".into()));
    assert_eq!(count("young 100", "plain"), (46, "converged".into()));
    assert_eq!(count("young 1000", "plain"), (368, "converged".into()));
    assert_eq!(count("young 100000", "plain"), (400, "cap".into()));
    assert!(out.join("young_100/plain/result.npz").is_file());
}

#[test]
fn every_preset_is_listed_written_planned_and_read() {
    let list = run(&["condense", "--list"]);
    assert_eq!(list.code, 0);
    let names: Vec<&str> = list
        .out
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(names.len(), 11);
    let folder = fresh_folder("condense_presets");
    for name in names {
        let path = folder.join(name);
        let ended = run(&["new", text(&path), "--preset", name, "--quiet"]);
        assert_eq!(ended.code, 0, "{name}: {}", ended.err);
        let ended = run(&["condense", text(&path.with_extension("toml")), "--plan"]);
        assert_eq!(ended.code, 0, "{name}: {}", ended.err);
        for part in [
            "Hessian",
            "cc, the whole basis",
            "cc, patches of radius 2",
            "warped, no basis",
        ] {
            assert!(ended.out.contains(part), "{name}: {part}");
        }
    }
    let ended = run(&["new", text(&folder.join("other")), "--preset", "bend"]);
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("presets are rod, stretch"), "{}", ended.err);
    assert!(!ended.err.contains("scene file"), "{}", ended.err);
}

#[test]
fn a_plan_is_what_is_used_and_a_byte_less_is_refused() {
    let folder = fresh_folder("condense_memory");
    let more = ["--methods", "cc", "--set", "mesh.grid=[8, 8]", "--threads", "1"];
    let planned = run(&[&["condense", "stretch", "--plan", "--json"][..], &more].concat());
    let line: Value = serde_json::from_str(planned.out.lines().next().unwrap()).unwrap();
    let bytes = line["variants"][0]["planned_bytes"].as_u64().unwrap();
    // Four states of 81 places.
    assert_eq!(line["result_bytes"], 4 * 81 * 2 * 8);
    let limit = |bytes: u64| {
        condense(
            &folder,
            "stretch",
            &[&more[..], &["--memory-limit", &bytes.to_string()]].concat(),
        )
    };
    let short = limit(bytes + 8191);
    assert_eq!(short.code, 3);
    assert!(
        short.err.contains("cc-fixed needs") && short.err.contains("use --radius W"),
        "{}",
        short.err
    );
    assert!(!folder.join("out").exists());
    let fits = limit(bytes + 8192);
    assert_eq!(fits.code, 0, "{}", fits.err);
    let report = json(&folder.join("out/cc-fixed/report.json"));
    assert_eq!(report["memory"]["planned_bytes"].as_u64(), Some(bytes));
    // The lists of the mesh, and what is made of them, are refused before they are made.
    for (limit, said) in [
        ("1MiB", "the lists of the mesh alone need"),
        ("2MiB", "the order and neighbours of the mesh alone need"),
    ] {
        let more = [
            "--methods",
            "plain",
            "--set",
            "mesh.grid=[200, 200]",
            "--memory-limit",
            limit,
        ];
        let large = condense(&folder, "stretch", &more);
        assert_eq!(large.code, 3);
        assert!(large.err.contains(said), "{}", large.err);
    }
}

/// The fixed point of a spring is no vertex of the body: loads and other springs are next to others, and its length is that of the body alone.
#[test]
fn fixed_points_of_springs_are_no_body() {
    let folder = fresh_folder("condense_fixed_points");
    let spring =
        |from: &str| format!("{{ from = {from}, to = [4, 1], stiffness = 1e-9, rest_length = 3.0 }}");
    let first = |more: &str| {
        let hold = format!("{LEFT}\n{more}\nload = {{ bump = 0.01 }}");
        let scene = scene(&folder, &[(HOLD, &hold), (TIME, "time = { steps = 1 }")]);
        read(&solved(&folder, &scene, &[]).join("cc-fixed/result.npz"))["energy"].data[0]
    };
    let [without, with] = [first(""), first(&format!("spring = [ {} ]", spring("[1, 1]")))];
    assert!((with / without - 1.0).abs() < 1e-6, "{with}, not {without}");
    let twice = format!(
        "{LEFT}\nspring = [ {}, {{ from = [4, 1], to = [1, 1], stiffness = 1.0, rest_length = 1.0 }} ]",
        spring("[1, 0]")
    );
    let ended = condense(&folder, &scene(&folder, &[(HOLD, &twice)]), &[]);
    assert_eq!(ended.code, 2);
    let said = "`spring[1]` begins and ends at the same vertex";
    assert!(ended.err.contains(said), "{}", ended.err);
    let hit = format!(
        "{LEFT}\nspring = [ {} ]\nload = {{ impulse = {{ at = [4, 1], value = [1.0, 0.0] }} }}",
        spring("[1, 1]")
    );
    let hit = scene(
        &folder,
        &[(HOLD, &hit), (TIME, "time = { steps = 1, dt = 0.01 }")],
    );
    solved(&folder, &hit, &[]);
}

#[test]
fn values_of_one_folder_are_refused() {
    let folder = fresh_folder("condense_one_folder");
    let sweep = |key: &str, values: &str| format!("[[sweep]]\nkey = \"{key}\"\nvalues = [{values}]\n");
    let sweeps = sweep("solver.cap", "10, 20") + &sweep("material.young", "100, 1e3, 100.0") + "[solver]";
    let twice = scene(&folder, &[("[solver]", &sweeps)]);
    for more in [&[][..], &["--set", "solver.cap=10"]] {
        let ended = condense(&folder, &twice, more);
        assert_eq!(ended.code, 2, "{}", ended.err);
        let said = "`sweep[1].values` has values whose results would lie in one folder";
        assert!(ended.err.contains(said), "{}", ended.err);
        assert!(ended.err.contains("young_100;"), "{}", ended.err);
    }
}

#[test]
fn single_precision_springs_and_space_run() {
    let folder = fresh_folder("condense_space");
    let more = [
        "--precision",
        "f32",
        "--methods",
        "newton,cc,warped",
        "--set",
        "mesh.grid=[4, 2, 2]",
        "--set",
        "spring[0].stiffness=2e2",
        "--set",
        "solver.tolerance=1e-6",
    ];
    let out = solved(&folder, "spring_3d", &more).join("in_basis_true");
    let tips: Vec<f64> = ["newton", "cc-fixed", "warped-fixed"]
        .iter()
        .map(|name| {
            let report = json(&out.join(name).join("report.json"));
            assert_eq!(
                (report["status"].as_str(), report["precision"].as_str()),
                (Some("converged"), Some("f32")),
                "{name}"
            );
            let position = &read(&out.join(name).join("result.npz"))["position"];
            assert_eq!(position.shape, [2, 46, 3]);
            position.data[46 * 3 + 44 * 3 + 2]
        })
        .collect();
    assert!(
        tips[0] > 0.2 && tips.iter().all(|tip| (tip - tips[0]).abs() < 1e-4),
        "{tips:?}"
    );
}

/// A square of two triangles, as every kind of file has it.
fn files() -> Vec<(&'static str, String)> {
    let obj =
        "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nf 1/1 2/2 3/3\nf -5 -3 4\n".to_owned();
    let older = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
                 $Elements\n3\n1 15 2 0 1 1\n2 2 2 0 1 1 2 3\n3 2 2 0 1 1 3 4\n$EndElements\n";
    let newer = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 0 0\n$EndEntities\n\
                 $Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n\
                 $Elements\n1 2 1 2\n2 1 2 2\n1 1 2 3\n2 1 3 4\n$EndElements\n";
    vec![
        ("a.obj", obj),
        ("b.msh", older.to_owned()),
        ("c.msh", newer.to_owned()),
    ]
}

fn file_scene(folder: &Path, name: &str, content: &str) -> String {
    fs::write(folder.join(name), content).unwrap();
    let mesh = format!("file = \"{name}\"");
    let hold = format!("{LEFT}\nload = {{ gravity = [0.0, -1.0] }}");
    scene(folder, &[(MESH, &mesh), (HOLD, &hold)])
}

#[test]
fn meshes_come_from_files() {
    let folder = fresh_folder("condense_files");
    let mut last = None;
    for (name, content) in files() {
        let scene = file_scene(&folder, name, &content);
        let arrays = read(&solved(&folder, &scene, &[]).join("cc-fixed/result.npz"));
        assert_eq!(
            (arrays["rest"].shape.clone(), arrays["elements"].data.clone()),
            (vec![4, 2], vec![0.0, 1.0, 2.0, 0.0, 2.0, 3.0]),
            "{name}"
        );
        let position = arrays["position"].data.clone();
        assert!(position[2 * 8 + 3] < 0.0, "it hangs down");
        assert!(last.is_none_or(|last| last == position), "{name}");
        last = Some(position);
    }
    let tetrahedron = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n7 0 0 1\n$EndNodes\n\
                       $Elements\n2\n1 2 2 0 1 1 2 3\n2 4 2 0 1 1 2 3 7\n$EndElements\n";
    fs::write(folder.join("t.msh"), tetrahedron).unwrap();
    let space = "mesh = { file = \"t.msh\" }\nhold = [ { box = { min = [0, 0, 0], max = [1, 1, 0] } } ]\nload = { gravity = [0.0, 0.0, -1.0] }\n";
    fs::write(folder.join("t.toml"), space).unwrap();
    let out = solved(&folder, text(&folder.join("t.toml")), &[]);
    assert_eq!(read(&out.join("cc-fixed/result.npz"))["rest"].shape, [4, 3]);
}

#[test]
fn damaged_files_are_refused_by_name() {
    let folder = fresh_folder("condense_damaged");
    let [(_, obj), (_, older), (_, newer)] = <[_; 3]>::try_from(files()).unwrap();
    let rows = [
        (
            "d.obj",
            obj.replace("f 1/1 2/2 3/3", "f 1 2 8"),
            "names vertex 8 in line 7",
        ),
        (
            "d.obj",
            obj.replace("f 1/1 2/2 3/3", "f 1 2 3 4"),
            "has a face of 4 corners in line 7; triangulate it",
        ),
        (
            "d.obj",
            obj.replace("v 1 0 0", "v 1 zero 0"),
            "has \"zero\" in line 3 where a coordinate belongs",
        ),
        (
            "d.obj",
            obj.replace("v 1 0 0", "v 1 nan 0"),
            "in line 3 that is not finite",
        ),
        (
            "d.obj",
            obj.replace("v 1 1 0", "v 1 1 2"),
            "do not lie in a plane",
        ),
        (
            "d.obj",
            "v 0 0 0\n".into(),
            "holds neither triangles nor tetrahedra",
        ),
        (
            "d.obj",
            obj.replace("f -5 -3 4", "f 3 1 4"),
            "element 1 is inverted",
        ),
        (
            "d.msh",
            older.replace("2.2 0", "2.2 1"),
            "is binary; save it in ASCII",
        ),
        ("d.msh", older.replace("2.2 0", "3 0"), "is of version 3"),
        (
            "d.msh",
            older.replace("$Nodes\n4", "$Nodes\n4000000"),
            "says that it has 4000000 vertices, more than it can hold",
        ),
        (
            "d.msh",
            older.replace("$Nodes\n4", "$Nodes\n3"),
            "where $EndNodes belongs",
        ),
        (
            "d.msh",
            older.replace("2 2 2 0 1 1 2 3", "2 3 2 0 1 1 2 3"),
            "has elements of kind 3",
        ),
        (
            "d.msh",
            older.replace("1 1 3 4", "1 1 3 9"),
            "names vertex 9, which it does not have",
        ),
        ("d.msh", older[..older.len() - 20].to_owned(), "it is damaged"),
        (
            "d.msh",
            newer.replace("1 4 1 4", "1 5 1 4"),
            "says that it has 5 vertices, and its blocks have 4",
        ),
        (
            "d.msh",
            newer.replace("1 2 1 2\n2 1 2 2", "1 3 1 2\n2 1 2 2"),
            "says that it has 3 elements, and its blocks have 2",
        ),
        ("d.msh", "nothing".into(), "has no $MeshFormat"),
        ("d.stl", "solid".into(), "is neither .obj nor .msh"),
    ];
    for (name, content, said) in rows {
        let scene = file_scene(&folder, name, &content);
        let ended = condense(&folder, &scene, &[]);
        assert_eq!(ended.code, 2, "{said}: {}", ended.err);
        assert!(
            ended.err.contains(said) && ended.err.contains("scene.toml:1"),
            "{said}: {}",
            ended.err
        );
    }
    fs::write(folder.join("d.obj"), [0xff, 0xfe, 0x00]).unwrap();
    let scene = file_scene(&folder, "e.obj", "");
    fs::remove_file(folder.join("e.obj")).unwrap();
    let ended = condense(&folder, &scene, &[]);
    assert_eq!(ended.code, 4);
    assert!(ended.err.contains("\"e.obj\" cannot be read"), "{}", ended.err);
}

#[test]
fn what_does_not_go_together_is_refused_by_name() {
    let folder = fresh_folder("condense_refusals");
    let left = |more: &str| format!("{LEFT}\n{more}");
    let rows: [(&str, &str, &str); 34] = [
        (MESH, "grid = [2, 0], size = [1.0, 1.0]", "`mesh.grid` is [2, 0]"),
        (MESH, "grid = [2], size = [1.0]", "`mesh.grid` is [2]"),
        (MESH, "grid = [2, 2], size = [1.0, -1.0]", "as many sizes above 0"),
        (
            MESH,
            "grid = [2, 2], rod = 3",
            "must have one of `grid`, `rod` and `file`",
        ),
        (MESH, "rod = 10, length = -1.0", "`mesh.length` is -1"),
        (
            MESH,
            "rod = 10, size = [1.0]",
            "`mesh.size` is for a mesh by `grid`",
        ),
        (
            MESH,
            "grid = [2, 2], length = 1.0",
            "`mesh.length` is for a mesh by `rod`",
        ),
        (
            MESH,
            "grid = [2, 2], area = 0.1",
            "`mesh.area` is for a mesh by `rod`",
        ),
        (
            HOLD,
            "",
            "`hold` is refused: a quasi-static problem must hold a vertex",
        ),
        ("max = [0, 1]", "max = [1, 1]", "no vertex is free"),
        (
            "min = [0, 0], max = [0, 1]",
            "min = [0.1, 0], max = [0.2, 1]",
            "`hold[0].box` holds no vertex",
        ),
        ("move = [0.1, 0]", "move = [0.1]", "`hold[1].move` is [0.1]"),
        (
            HOLD,
            &left("material = { poisson = 0.5 }"),
            "`material.poisson` is 0.5, but only a number above -1 and below 1/2",
        ),
        (HOLD, &left("material = { young = -1.0 }"), "`material.young`"),
        (HOLD, &left("load = { gravity = [1.0] }"), "`load.gravity`"),
        (
            HOLD,
            &left("load = { impulse = { at = [1.0, 1.0], value = [1.0, 0.0] } }"),
            "`load.impulse` needs inertia",
        ),
        (
            &format!("{TIME}\n{HOLD}"),
            &format!(
                "time = {{ steps = 2, dt = 0.1 }}\n{LEFT}\nload = {{ impulse = {{ at = [0.0, 0.5], value = [1.0, 0.0] }} }}"
            ),
            "`load.impulse.at` is next to a vertex that is held",
        ),
        (
            HOLD,
            &left("spring = [ { from = [1, 1], to = [1, 1], stiffness = 1.0, rest_length = 0.1 } ]"),
            "begins and ends at the same vertex",
        ),
        (
            HOLD,
            &left("spring = [ { from = [1, 1], to = [1, 2], stiffness = 0.0, rest_length = 0.1 } ]"),
            "`spring[0].stiffness`",
        ),
        (TIME, "time = { steps = 0 }", "`time.steps` is 0"),
        (TIME, "time = { steps = 2, dt = 0.0 }", "`time.dt`"),
        (
            METHODS,
            "methods = [\"newton\"]\nbasis = \"rebuilt\"",
            "`solver.basis` is for methods that have one, and \"newton\" has none",
        ),
        (
            METHODS,
            "methods = [\"newton\", \"plain\"]\nbasis = \"fixed\"",
            "`solver.basis` is for methods that have one, and \"newton\" has none",
        ),
        (
            METHODS,
            "methods = [\"cc\"]\nbasis = []",
            "`solver.basis` is a list of 0, but only a word or a list of words",
        ),
        (
            METHODS,
            "methods = [\"cc\"]\nbasis = [1]",
            "`solver.basis` is 1, but only a word or a list of words",
        ),
        (
            METHODS,
            "methods = [\"plain\"]\nradius = 2",
            "`solver.radius` is for methods that keep a basis",
        ),
        (
            METHODS,
            "methods = [\"cc\"]\nbasis = \"corotated\"\nblock = \"scalar\"",
            "\"scalar\" cannot be co-rotated",
        ),
        (
            METHODS,
            "methods = [\"chord\"]\nbasis = \"corotated\"",
            "\"chord\" cannot be co-rotated",
        ),
        (
            METHODS,
            "methods = [\"plain\", \"cc\"]\norder = \"colours\"",
            "`solver.order` is refused: order \"colours\" is for method \"plain\"",
        ),
        (METHODS, "methods = [\"gauss\"]", "`solver.methods` is \"gauss\""),
        (METHODS, "methods = []", "`solver.methods` is empty"),
        (
            METHODS,
            "methods = [\"cc\"]\ntolerance = 0.0",
            "`solver.tolerance`",
        ),
        (METHODS, "methods = [\"cc\"]\ncap = 0", "`solver.cap` is 0"),
        (METHODS, "methods = [\"cc\"]\nspeed = 1", "speed"),
    ];
    for (from, to, said) in rows {
        let scene = scene(&folder, &[(from, to)]);
        let ended = condense(&folder, &scene, &[]);
        assert_eq!(ended.code, 2, "{to}: {}", ended.err);
        assert!(ended.err.contains(said), "{to}: {}", ended.err);
        assert_eq!(ended.err.trim().lines().count(), 1, "{}", ended.err);
        assert!(!folder.join("out").exists());
    }
    for (arguments, said) in [
        (
            vec!["condense", "bend"],
            "is neither a preset nor the name of a scene file",
        ),
        (
            vec!["condense", "missing.toml"],
            "cannot read the scene missing.toml",
        ),
        (
            vec![
                "condense",
                "stretch",
                "--methods",
                "newton",
                "--basis",
                "corotated",
                "--plan",
            ],
            "--basis corotated: `solver.basis`",
        ),
        (
            vec!["condense", "stretch", "--methods", "newton", "--basis", "fixed"],
            "--basis fixed: `solver.basis` is for methods that have one",
        ),
        (
            vec!["condense", "stretch", "--methods", "cc,gauss", "--plan"],
            "--methods cc,gauss: `solver.methods`",
        ),
    ] {
        let ended = run(&arguments);
        assert!(ended.code == 2 || ended.code == 4, "{arguments:?}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments:?}: {}", ended.err);
    }
    // The bases of a preset are not meant for methods that the command line names.
    let ended = run(&["condense", "cantilever", "--methods", "newton", "--plan"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
}

#[test]
fn sweeps_of_nothing_and_of_too_much_are_refused() {
    let folder = fresh_folder("condense_sweep_sizes");
    let values = |count: usize| {
        (1..=count)
            .map(|value| value.to_string())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let sweep =
        |key: &str, count: usize| format!("[[sweep]]\nkey = \"{key}\"\nvalues = [{}]\n", values(count));
    for (sweeps, said) in [
        (
            sweep("solver.cap", 0),
            "`sweep[0].values` has 0 values; give some",
        ),
        (
            sweep("solver.cap", 40) + &sweep("solver.rebuild", 26),
            "`sweep[1].values` has 26 values; give some, and no more than 1000 problems in all",
        ),
    ] {
        let scene = scene(&folder, &[("[solver]", &(sweeps + "[solver]"))]);
        let ended = condense(&folder, &scene, &[]);
        assert_eq!(ended.code, 2, "{}", ended.err);
        assert!(ended.err.contains(said), "{}", ended.err);
        assert!(!folder.join("out").exists());
    }
}

/// A boundary that is pushed through the mesh is not finite, a cap that is reached is no failure, and where rounding errors are more than the tolerance
/// the search stalls; all leave their results.
#[test]
fn exit_codes_say_how_it_ended() {
    let folder = fresh_folder("condense_codes");
    let through = scene(&folder, &[("move = [0.1, 0]", "move = [-0.9, 0]")]);
    let ended = condense(&folder, &through, &[]);
    assert_eq!(ended.code, 1, "{}", ended.err);
    let status = |name: &str| json(&folder.join("out").join(name).join("report.json"))["status"].clone();
    assert_eq!(status("cc-fixed"), "not_finite");
    let plain = "methods = [\"plain\"]\ntolerance = 1e-300\ncap = 3";
    solved(&folder, &scene(&folder, &[(METHODS, plain)]), &[]);
    assert_eq!(status("plain"), "cap");
    let hold = format!("{LEFT}\nload = {{ bump = 0.001 }}");
    let below = "methods = [\"newton\", \"cc\"]\ntolerance = 1e-30";
    let stalls = scene(
        &folder,
        &[
            ("grid = [2, 2]", "grid = [4, 4]"),
            (HOLD, &hold),
            (METHODS, below),
        ],
    );
    let ended = condense(&folder, &stalls, &[]);
    assert_eq!(ended.code, 5, "{}", ended.err);
    for name in ["newton", "cc-fixed"] {
        assert_eq!(status(name), "stalled", "{name}");
        let iterations = &read(&folder.join("out").join(name).join("result.npz"))["iterations"];
        assert_eq!(iterations.data.len(), 1, "{name} ends in its first step");
    }
}

/// A run that is stopped leaves what there is.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_its_result() {
    let out = fresh_folder("condense_interrupted").join("out");
    let mut command = crate::support::thurible();
    command.args([
        "condense",
        "rod",
        "--methods",
        "plain,newton",
        "--json",
        "--set",
        "material.young=1e12",
    ]);
    command.args(["--set", "solver.cap=100000000", "-o", text(&out)]);
    let ended =
        crate::support::endless::Endless::seen(&mut command, |line| line.contains("\"variant\"")).stop();
    assert_eq!(ended.code, 130, "{}", ended.err);
    assert_eq!(json(&out.join("plain/report.json"))["status"], "cancelled");
    assert!(!out.join("newton").exists() && out.join("condense.html").is_file());
    assert_eq!(read(&out.join("plain/result.npz"))["position"].shape, [2, 101, 1]);
}

/// Stopped before its first build it has a result without a step; wherever it is stopped, the lists belong together.
#[cfg(unix)]
#[test]
fn a_step_without_a_state_is_no_step() {
    let out = fresh_folder("condense_before").join("out");
    let mut command = crate::support::thurible();
    command.args(["condense", "rod", "--methods", "chord", "--json"]);
    command.args(["--set", "mesh.rod=500000", "--set", "material.young=1e2"]);
    command.args(["-o", text(&out)]);
    crate::support::endless::Endless::seen(&mut command, |line| line.contains("\"variant\"")).stop();
    let arrays = read(&out.join("chord-fixed/result.npz"));
    let iterations = &arrays["iterations"].data;
    let steps = iterations.len();
    assert_eq!(
        arrays["energy"].data.len(),
        iterations.iter().sum::<f64>() as usize + steps
    );
    assert_eq!(arrays["builds"].data.len(), steps);
    assert_eq!(arrays["position"].shape, [steps + 1, 500_001, 1]);
    let page = fs::read_to_string(out.join("condense.md")).unwrap();
    assert!(page.contains("cancelled, step 1") || steps > 0, "{page}");
}
