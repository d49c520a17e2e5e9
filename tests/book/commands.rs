//! Every command of the README and of docs/ runs, or says why not.
//!
//! A block runs word for word in a folder of its page (`workshop`), whose examples are small; a comment before it,
//! `<!-- not run: why -->`, keeps it from that, and `<!-- after: COMMANDS -->` makes what it begins with. Commands in sentences run without
//! what stands in brackets; those that cannot are listed here with the reason. A name alone, `thurible solve`, must be a command.

use super::pages::{Command, Mark, commands, pages};
use super::workshop::{Workshop, called, filled, told};
use super::{printed, root};
use core::sync::atomic::{AtomicUsize, Ordering};
use std::fs;
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

/// Pages whose commands do not run, and why.
const PAGES: [(&str, &str); 6] = [
    ("CONTRIBUTING.md", "the steps of .ci/run"),
    (
        "docs/paper/2d.md",
        "written by the command that it shows; tests/program/paper.rs runs scenes of it",
    ),
    (
        "docs/paper/3d.md",
        "written by the command that it shows; tests/program/paper.rs runs scenes of it",
    ),
    (
        "docs/thesis/images.md",
        "written by the command that it shows; tests/program/thesis.rs runs figures of it",
    ),
    (
        "docs/thesis/smoke.md",
        "written by the command that it shows; tests/program/thesis.rs runs figures of it",
    ),
    (
        "docs/mosaic.md",
        "written by the command that it shows, which takes Mosaic's solvers and an hour",
    ),
];

/// Commands in sentences that do not run, by what they begin with, and why.
const SENTENCES: [(&str, &str); 24] = [
    ("cargo test", "it is what runs this"),
    (
        "thurible solve scene.toml --device",
        "the program of these tests has no graphics cards; `.ci/run gpu` solves on one",
    ),
    (
        "cargo bench",
        "it measures for minutes; `.ci/run benches` compiles it",
    ),
    (
        "cargo table",
        "it measures for minutes; `.ci/run benches` runs its smallest rows",
    ),
    (
        "cargo thurible-bench",
        "it measures for minutes; its own tests run it on little",
    ),
    (
        "cargo rustc --release --manifest-path core/ffi",
        "`.ci/run web` builds the module",
    ),
    (
        "python3 benches/",
        "it measures for minutes, with Python's packages",
    ),
    (
        "thurible paper fig",
        "it takes minutes; tests/program/paper.rs runs scenes of it",
    ),
    (
        "cargo run --release -- paper",
        "it takes minutes; tests/program/paper.rs runs scenes of it",
    ),
    (
        "thurible compare examples/letter_f.toml --methods direct,lbfgs,pd,stable_fluids",
        "the same as in README with one method more",
    ),
    (
        "thurible resume out/letter_f",
        "nothing is left of a solve that ended; tests/program/checkpoints.rs",
    ),
    (
        "thurible resume out/scene",
        "nothing is left of a solve that ended; tests/program/checkpoints.rs",
    ),
    (
        "thurible readvect out/capture/flow",
        "docs/capture.md makes that folder; its last commands take too long for twice",
    ),
    (
        "thurible remap out/capture/flow",
        "docs/capture.md makes that folder",
    ),
    (
        "thurible guide scene.toml --reference out/capture/flow",
        "docs/capture.md makes that folder",
    ),
    (
        "thurible check-gradient examples/small_3d.toml",
        "the next one runs it: tests/program/check_gradient.rs",
    ),
    (
        "cargo install --locked --path .",
        "`.ci/run packages` installs it",
    ),
    ("mdbook build docs", "`.ci/run book` builds it"),
    (
        "apt-get install ./target/debian",
        "`.ci/run packages` builds and unpacks it",
    ),
    (
        "thurible condense rod",
        "tests/program/condense.rs runs the presets",
    ),
    (
        "thurible condense stretch --methods newton,cc,projected",
        "tests/program/condense.rs runs the presets",
    ),
    (
        "thurible condense cantilever",
        "tests/program/condense.rs runs the presets",
    ),
    (
        "thurible condense buckle",
        "tests/program/condense.rs runs the presets",
    ),
    (
        "thurible condense noise",
        "tests/program/condense.rs runs the presets",
    ),
];

/// How a command came out, with a line of what failed.
fn tried(page: &str, workshop: &Workshop, command: &Command) -> Option<String> {
    let fault = |why: String| {
        Some(format!(
            "{page}:{}: {}\n{why}",
            command.line,
            command.script.trim()
        ))
    };
    let script = match (&command.mark, command.inline) {
        (Mark::NotRun(_), _) => return None,
        (Mark::After(first), _) => {
            let output = workshop.run(&filled(first));
            if !output.status.success() {
                return fault(format!("what comes before it fails: {first}\n{}", told(&output)));
            }
            filled(&command.script)
        }
        (Mark::Nothing, false) => filled(&command.script),
        (Mark::Nothing, true) => called(&command.script).trim().to_owned(),
    };
    if command.inline {
        if let Some(step) = script.strip_prefix(".ci/run ") {
            return if is_step(step) {
                None
            } else {
                fault("there is no such step".into())
            };
        }
        if let Some((name, option)) = alone(&script) {
            let known = is_command(name, option);
            return if known {
                None
            } else {
                fault("there is no such command or option".into())
            };
        }
        if SENTENCES.iter().any(|(begins, _)| script.starts_with(begins)) {
            return None;
        }
    }
    let began = Instant::now();
    let output = workshop.run(&script);
    let seconds = began.elapsed().as_secs_f64();
    if seconds > 1.0 {
        println!(
            "{page}:{}: {seconds:.1} s: {}",
            command.line,
            script.lines().next().unwrap_or_default()
        );
    }
    if output.status.success() {
        return None;
    }
    let told = told(&output);
    let last: Vec<&str> = told.lines().rev().take(12).collect();
    fault(last.into_iter().rev().collect::<Vec<_>>().join("\n"))
}

/// The command that is named without an argument, `thurible solve`, or with an option alone, `thurible render --scale`.
fn alone(script: &str) -> Option<(&str, &str)> {
    let words: Vec<&str> = script.split_whitespace().collect();
    let name = |word: &str| word.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    match words[..] {
        ["thurible", command] if name(command) => Some((command, "")),
        ["thurible", command, option] if name(command) && option == "--scale" => Some((command, option)),
        _ => None,
    }
}

fn is_command(name: &str, option: &str) -> bool {
    let known = printed(&["--help"])
        .lines()
        .any(|line| line.split_whitespace().next() == Some(name));
    known && printed(&[name, "--help"]).contains(option)
}

fn is_step(words: &str) -> bool {
    let ci = fs::read_to_string(root().join(".ci/run")).unwrap();
    let step = |name: &str| ci.lines().any(|line| line.starts_with(&format!("{name}() {{")));
    words.split_whitespace().all(step)
}

/// What fails on a page.
fn failures(page: &str) -> Vec<String> {
    // The journal speaks of the program as it was.
    if page.starts_with("docs/log/") || PAGES.iter().any(|(name, _)| *name == page) {
        return Vec::new();
    }
    let found = commands(&fs::read_to_string(root().join(page)).unwrap());
    if found.is_empty() {
        return Vec::new();
    }
    let workshop = Workshop::new(page);
    found
        .iter()
        .filter_map(|command| tried(page, &workshop, command))
        .collect()
}

#[test]
fn every_command_of_the_readme_and_the_book_runs() {
    if std::process::Command::new("bash")
        .arg("--version")
        .output()
        .is_err()
    {
        println!("SKIPPED: there is no bash, so no command of a page was run");
        return;
    }
    let (pages, next, wrong) = (pages(), AtomicUsize::new(0), Mutex::new(Vec::new()));
    let only = std::env::var("THURIBLE_PAGE").ok();
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(page) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if only.as_ref().is_none_or(|only| page.contains(only.as_str())) {
                        let found = failures(page);
                        wrong.lock().unwrap().extend(found);
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "commands that fail:\n\n{}", wrong.join("\n\n"));
}

#[test]
fn every_reason_is_one_of_a_page_or_a_sentence_that_is_there() {
    let pages = pages();
    for (page, _) in PAGES {
        assert!(pages.iter().any(|name| name == page), "{page} is not there");
    }
    let texts: Vec<_> = pages
        .iter()
        .map(|page| fs::read_to_string(root().join(page)).unwrap())
        .collect();
    let inline: Vec<_> = texts
        .iter()
        .flat_map(|text| commands(text))
        .filter(|command| command.inline)
        .collect();
    for (begins, _) in SENTENCES {
        let used = inline
            .iter()
            .any(|command| called(&command.script).starts_with(begins));
        assert!(used, "no page has `{begins}` any more; take it out of the list");
    }
}
