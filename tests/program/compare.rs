//! `thurible compare` from end to end: every figure of a page is one that the run itself wrote down.

use crate::support::verify::verify;
use crate::support::{fresh_folder, json, run, without_pictures};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn number(value: &Value, pointer: &str) -> f64 {
    value
        .pointer(pointer)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{pointer} is no number in {value}"))
}

/// Rows of the first table of a Markdown page, heads first.
pub fn table(page: &str) -> Vec<Vec<&str>> {
    let lines = page
        .lines()
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'));
    lines
        .filter(|line| !line.contains("---"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

/// What a row says in the column `name`.
pub fn cell<'a>(table: &[Vec<&'a str>], row: usize, name: &str) -> &'a str {
    let column = table[0]
        .iter()
        .position(|head| *head == name)
        .unwrap_or_else(|| panic!("no column {name}"));
    table[row + 1][column]
}

fn about(text: &str, value: f64) -> bool {
    let found: f64 = text.parse().unwrap_or_else(|_| panic!("{text} is no number"));
    (found - value).abs() <= 6e-4 * value.abs().max(1.0)
}

/// A row of the facts agrees with the report of its method.
pub fn check_row(row: &Value, report: &Value) {
    let method = report["method"].as_str().unwrap();
    assert_eq!(row["method"], report["method"]);
    assert_eq!(
        (&row["status"], &row["threads"]),
        (&report["status"], &report["threads"])
    );
    for (of_row, of_report) in [
        ("/objective/total", "/objective/total"),
        ("/objective/data", "/objective/data"),
        ("/planned_bytes", "/memory/planned_bytes"),
    ] {
        assert_eq!(
            number(row, of_row),
            number(report, of_report),
            "{method}: {of_row}"
        );
    }
    let history = report["history"].as_array().unwrap();
    let finest = history
        .iter()
        .filter(|entry| entry.get("level").is_none_or(|level| *level == report["cells"]))
        .count();
    assert_eq!(
        row["iterations"].as_u64(),
        Some(finest as u64),
        "{method}: iterations"
    );
    assert_eq!(
        row["coarser_iterations"].as_u64(),
        Some((history.len() - finest) as u64)
    );
    assert_eq!(
        number(row, "/seconds"),
        number(history.last().unwrap(), "/seconds"),
        "{method}: seconds"
    );
    assert_eq!(row["ao_average"].is_number(), method == "admm");
    if method == "admm" {
        assert_eq!(
            number(row, "/nso_average"),
            number(report, "/seconds/nso_average")
        );
        assert!(
            history
                .iter()
                .all(|entry| entry["kkt"].is_number() && entry.get("level").is_none())
        );
    } else {
        assert!(history.iter().all(|entry| entry["level"].is_array()
            && entry["evaluations"].is_number()
            && entry.get("kkt").is_none()));
    }
}

/// The seconds to 1 % are those of the first iteration on the finest grid that is so near, if the method ends there.
fn check_near(row: &Value, report: &Value, best: f64) {
    let ended = number(report, "/objective/total");
    let finest = report["history"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|entry| entry.get("level").is_none_or(|level| *level == report["cells"]));
    let near = finest
        .filter(|entry| number(entry, "/total") <= 1.01 * best)
        .map(|entry| number(entry, "/seconds"))
        .next();
    match row["seconds_to_best"].as_f64() {
        Some(seconds) => assert_eq!(near.unwrap_or_else(|| number(row, "/seconds")), seconds),
        None => assert!(ended > 1.01 * best),
    }
}

#[test]
fn two_methods_on_one_page() {
    let folder = fresh_folder("compare").join("out");
    let out = folder.to_str().unwrap();
    let arguments = [
        "compare",
        "examples/small_nonsquare.toml",
        "--threads",
        "1",
        "--set",
        "output.frames=false",
        "-o",
        out,
    ];
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}", ended.err);

    let (facts, page) = (
        json(&folder.join("compare.json")),
        fs::read_to_string(folder.join("compare.md")).unwrap(),
    );
    let reports = ["direct", "admm"].map(|method| verify(method, &folder.join(method)).report);
    let totals = [
        number(&reports[0], "/objective/total"),
        number(&reports[1], "/objective/total"),
    ];
    let best = totals[0].min(totals[1]);
    assert_eq!(number(&facts, "/best"), best);
    let table = table(&page);
    assert_eq!(table.len(), 3);
    for (index, report) in reports.iter().enumerate() {
        let row = &facts["rows"][index];
        check_row(row, report);
        check_near(row, report, best);
        assert!(row["seconds_to_worst"].is_number());
        assert_eq!(cell(&table, index, "method"), report["method"]);
        assert!(about(cell(&table, index, "objective"), totals[index]));
        assert!(about(
            cell(&table, index, "force part"),
            number(report, "/objective/force")
        ));
        assert!(
            about(cell(&table, index, "s to own stop"), number(row, "/seconds"))
                || number(row, "/seconds") >= 1.0
        );
        assert_eq!(cell(&table, index, "iterations"), row["iterations"].to_string());
    }
    assert!(
        ended
            .out
            .contains(page.lines().find(|line| line.starts_with("| direct")).unwrap()),
        "the table is not printed"
    );

    assert_eq!(number(&reports[0], "/force_smoothness"), 0.0);
    assert_eq!(reports[0]["force_smoothness"], reports[1]["force_smoothness"]);
    let note = "admm cannot price curls, so all methods solve with `control.smoothness` 0, not with the 2.5 that goes with this transport";
    assert_eq!(facts["note"], note);
    for text in [&page, &ended.out] {
        assert!(text.contains(note), "nothing is said of the smoothness: {text}");
    }
    assert!(
        page.contains("smoothness of the force 0, limited transport"),
        "{page}"
    );

    let html = fs::read_to_string(folder.join("compare.html")).unwrap();
    let text = without_pictures(&html);
    for forbidden in ["http:", "https:", "<script", "<link", "url(", "NaN", "inf,"] {
        assert!(!text.contains(forbidden), "{forbidden}");
    }
    assert_eq!(html.matches("<svg").count(), 2);
    assert!(html.matches("data:image/png;base64,").count() >= 5);
    for picture in page
        .split("src=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
    {
        assert!(folder.join(picture).is_file(), "{picture} is missing");
    }
    let again = run(&[&arguments[..], &["--force"]].concat());
    assert_eq!(again.code, 0, "a second run into the same folder: {}", again.err);
}

/// Iterations are those of all windows, and none of them says when the whole was near its end.
#[test]
fn windows_are_compared_as_a_whole() {
    let folder = fresh_folder("compare_windows").join("out");
    let ended = run(&[
        "compare",
        "examples/small_letter.toml",
        "--methods",
        "direct,lbfgs",
        "--set",
        "method.window=6",
        "--set",
        "method.stride=3",
        "--set",
        "method.iterations=3",
        "--quiet",
        "-o",
        folder.to_str().unwrap(),
    ]);
    assert!(matches!(ended.code, 0 | 5), "{}", ended.err);
    let facts = json(&folder.join("compare.json"));
    for row in facts["rows"].as_array().unwrap() {
        let report = json(&folder.join(row["method"].as_str().unwrap()).join("report.json"));
        assert!(report["windows"].as_array().unwrap().len() > 1);
        let history = report["history"].as_array().unwrap();
        let finest = |entry: &&Value| entry["level"].is_null() || entry["level"] == report["cells"];
        assert_eq!(row["iterations"], history.iter().filter(finest).count());
        assert!(
            row["seconds_to_best"].is_null() && row["seconds_to_worst"].is_null(),
            "{row}"
        );
    }
}

/// Names are shown as they are by both pages, and a list of values is a line.
#[test]
fn what_looks_like_a_tag_is_none() {
    let folder = fresh_folder("compare_tags");
    let scene = folder.join("a<b>c.toml");
    fs::copy("examples/small_letter.toml", &scene).unwrap();
    let out = folder.join("out");
    let ended = run(&[
        "compare",
        scene.to_str().unwrap(),
        "--methods",
        "pd",
        "--quiet",
        "-o",
        out.to_str().unwrap(),
    ]);
    assert!(matches!(ended.code, 0 | 5), "{}", ended.err);
    let page = fs::read_to_string(out.join("compare.md")).unwrap();
    assert!(page.starts_with("# a&lt;b>c, compared"), "{page}");
}

#[test]
fn one_method_in_json_lines() {
    let folder = fresh_folder("compare_json").join("out");
    let arguments = [
        "compare",
        "examples/small_letter.toml",
        "--methods",
        "direct",
        "--json",
        "--set",
        "method.iterations=2",
        "-o",
        folder.to_str().unwrap(),
    ];
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let events: Vec<Value> = ended
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let named = |name: &str| events.iter().filter(|event| event["event"] == name).count();
    assert_eq!((named("plan"), named("result"), named("compare")), (1, 1, 1));
    let iteration = events.iter().find(|event| event["event"] == "iteration").unwrap();
    assert!(
        iteration["level"].is_array() && iteration["slope"].is_number() && iteration.get("kkt").is_none()
    );
    assert!(events.last().unwrap()["rows"][0]["seconds_to_best"].is_number());
    assert!(events.last().unwrap()["note"].is_null());
    let page = fs::read_to_string(folder.join("compare.md")).unwrap();
    assert!(
        page.contains("smoothness of the force 2.5 cells (0.05208), limited transport"),
        "{page}"
    );
    let report = fs::read_to_string(folder.join("direct/report.html")).unwrap();
    for word in [
        "<dd>2.5 cells (0.05208)</dd>",
        "</b>of that without the price of curls</li>",
        "</b>densities</li>",
        "<h3>Gradient</h3>",
    ] {
        assert!(report.contains(word), "{word} is not in report.html");
    }
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = fresh_folder("compare_refused");
    let full = folder.join("full");
    fs::create_dir_all(full.join("admm")).unwrap();
    fs::write(full.join("admm/diary.txt"), "mine").unwrap();
    let new = folder.join("new").to_str().unwrap().to_owned();
    let scene = "examples/small_letter.toml";
    let table: [(&[&str], i32, &[&str]); 8] = [
        (
            &["compare", scene, "--methods", "direct,magic", "-o", &new],
            2,
            &["--methods magic", "\"direct\""],
        ),
        (
            &["compare", scene, "--methods", "admm,admm", "-o", &new],
            2,
            &["named twice"],
        ),
        (
            &["compare", "examples/nowhere.toml", "-o", &new],
            4,
            &["nowhere.toml"],
        ),
        (
            &["compare", scene, "--memory-limit", "1MiB", "-o", &new],
            3,
            &["--memory-limit"],
        ),
        (
            &["compare", scene, "-o", full.to_str().unwrap()],
            4,
            &["not empty", "-o DIR"],
        ),
        (
            &["paper", "mona_lisa", "-o", &new],
            2,
            &["\"mona_lisa\"", "fluid", "--list"],
        ),
        (
            &["paper", "fluid", "--scale", "1/3", "-o", &new],
            2,
            &["1/3", "1/2"],
        ),
        (
            &["paper", "fig7", "--methods", "direct", "-o", &new],
            2,
            &["fig7", "--methods admm"],
        ),
    ];
    for (arguments, code, words) in table {
        let ended = run(arguments);
        assert_eq!(ended.code, code, "{arguments:?}: {}", ended.err);
        for word in words {
            assert!(
                ended.err.contains(word),
                "{arguments:?}: {word} is not in: {}",
                ended.err
            );
        }
        assert!(!Path::new(&new).exists(), "{arguments:?} wrote something");
    }
}
