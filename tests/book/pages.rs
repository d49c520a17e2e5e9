//! The commands of a page: blocks of `sh` and indented lines, and what stands between backticks.

use super::root;
use std::fs;
use std::path::{Path, PathBuf};

/// What a page says of a block in a comment before it, `<!-- not run: why -->` or `<!-- after: COMMANDS -->`.
#[derive(Debug, PartialEq)]
pub enum Mark {
    Nothing,
    NotRun(String),
    After(String),
}

#[derive(Debug)]
pub struct Command {
    /// Its line, from 1.
    pub line: usize,
    /// What a shell is given.
    pub script: String,
    pub mark: Mark,
    /// Whether it stands between backticks in a sentence, or alone and indented, where `DIR` and brackets stand for what a reader puts there.
    pub inline: bool,
}

/// What begins a command.
const PROGRAMS: [&str; 9] = [
    "thurible",
    "cargo",
    "python3",
    "pip",
    ".ci/run",
    "target/release/thurible",
    "blender",
    "apt-get",
    "mdbook",
];

/// The README and all pages of docs/, by their names from the root.
pub fn pages() -> Vec<String> {
    let mut files = vec![root().join("README.md"), root().join("CONTRIBUTING.md")];
    below(&root().join("docs"), &mut files);
    files
        .iter()
        .map(|path| path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned())
        .collect()
}

fn below(folder: &Path, files: &mut Vec<PathBuf>) {
    let mut all: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    all.sort();
    for path in all {
        if path.is_dir() {
            below(&path, files);
        } else if path.extension().is_some_and(|end| end == "md") {
            files.push(path);
        }
    }
}

fn mark(line: &str) -> Option<Mark> {
    let words = line.trim().strip_prefix("<!--")?.strip_suffix("-->")?.trim();
    match words.split_once(": ")? {
        ("not run", why) => Some(Mark::NotRun(why.into())),
        ("after", commands) => Some(Mark::After(commands.into())),
        _ => None,
    }
}

fn begins(text: &str) -> bool {
    text.split_whitespace()
        .next()
        .is_some_and(|first| PROGRAMS.contains(&first))
}

/// The commands of a page in their order.
pub fn commands(text: &str) -> Vec<Command> {
    let (mut found, mut said) = (Vec::new(), Mark::Nothing);
    let mut lines = text.lines().enumerate().peekable();
    while let Some((index, line)) = lines.next() {
        let line_number = index + 1;
        if let Some(language) = line.trim_start().strip_prefix("```") {
            let mut script = String::new();
            for (_, inner) in lines
                .by_ref()
                .take_while(|(_, inner)| !inner.trim_start().starts_with("```"))
            {
                script.push_str(inner);
                script.push('\n');
            }
            if ["sh", "bash"].contains(&language) || (["", "text"].contains(&language) && begins(&script)) {
                let mark = core::mem::replace(&mut said, Mark::Nothing);
                found.push(Command {
                    line: line_number,
                    script,
                    mark,
                    inline: false,
                });
            }
        } else if let Some(new) = mark(line) {
            said = new;
            continue;
        } else if let Some(script) = line.strip_prefix("    ").filter(|line| begins(line)) {
            let mut script = script.to_owned();
            while let Some((_, more)) =
                lines.next_if(|(_, more)| more.strip_prefix("    ").is_some_and(begins))
            {
                script.push('\n');
                script.push_str(more);
            }
            let mark = core::mem::replace(&mut said, Mark::Nothing);
            found.push(Command {
                line: line_number,
                script,
                mark,
                inline: true,
            });
        } else {
            found.extend(
                between_backticks(&joined(line, &mut lines)).map(|script| Command {
                    line: line_number,
                    script,
                    mark: Mark::Nothing,
                    inline: true,
                }),
            );
        }
        if !line.trim().is_empty() {
            said = Mark::Nothing;
        }
    }
    found
}

/// A line with those after it while one of its backticks is open.
fn joined<'a>(
    line: &str,
    lines: &mut core::iter::Peekable<impl Iterator<Item = (usize, &'a str)>>,
) -> String {
    let mut text = line.to_owned();
    while text.matches('`').count() % 2 == 1 {
        let Some((_, more)) = lines.next() else { break };
        text.push(' ');
        text.push_str(more.trim());
    }
    text
}

fn between_backticks(text: &str) -> impl Iterator<Item = String> {
    let codes: Vec<String> = text.split('`').skip(1).step_by(2).map(str::to_owned).collect();
    codes
        .into_iter()
        .filter(|code| begins(code) && code.contains(' '))
}

#[test]
fn commands_and_their_marks_are_found() {
    let page = "# A\n`thurible solve\nSCENE` and `thurible`.\n\n<!-- not run: minutes -->\n```sh\nthurible paper 2d\n```\n\n```rust\nthurible x\n```\n\n    thurible plan a.toml\n";
    let found = commands(page);
    let scripts: Vec<_> = found
        .iter()
        .map(|command| (command.line, command.script.as_str(), command.inline))
        .collect();
    let expected = [
        (2, "thurible solve SCENE", true),
        (6, "thurible paper 2d\n", false),
        (14, "thurible plan a.toml", true),
    ];
    assert_eq!(scripts, expected);
    assert_eq!(found[1].mark, Mark::NotRun("minutes".into()));
    assert_eq!(found[2].mark, Mark::Nothing);
}
