//! What commands read beside scenes: they plan, and do no more, where they can.

use clap::{CommandFactory, FromArgMatches, Parser};
use core::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use thurible::cli::{Cli, Command};
use thurible::commands::{condense, deblur, export, resume, solve, sweep, tomography, track};
use thurible::exit::Failure;

/// Runs a command of the program in this process.
pub fn command(arguments: &[&str]) -> Result<u8, Failure> {
    command_with(arguments, |_| ())
}

thread_local! {
    /// What the program is told, which takes longer to say than to read.
    static PROGRAM: RefCell<clap::Command> = RefCell::new(Cli::command());
    /// Command lines that were parsed, which takes longer than most readers do.
    static PARSED: RefCell<HashMap<String, Cli>> = RefCell::default();
}

/// As [`command`], with what `change` makes of the parsed arguments, each time anew.
fn command_with(arguments: &[&str], change: impl FnOnce(&mut Command)) -> Result<u8, Failure> {
    let line = arguments.join("\n");
    // A command that panics leaves none behind: the next one parses it again.
    let known = PARSED.with_borrow_mut(|parsed| parsed.remove(&line));
    let mut cli = match known {
        Some(cli) => cli,
        None => Cli::try_parse_from([&["thurible"], arguments].concat())
            .map_err(|error| Failure::Input(error.to_string()))?,
    };
    change(&mut cli.command);
    let done = run(&cli.command);
    PARSED.with_borrow_mut(|parsed| parsed.insert(line, cli));
    done
}

fn run(command: &Command) -> Result<u8, Failure> {
    match command {
        Command::Solve(arguments) => solve::run(arguments),
        Command::Resume(arguments) => resume::run(arguments),
        Command::Condense(arguments) => condense::run(arguments),
        Command::Tomography(arguments) => tomography::run(arguments),
        Command::Track(arguments) => track::run(arguments),
        Command::Deblur(arguments) => deblur::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::Sweep(arguments) => sweep::run(arguments),
        _ => unreachable!(),
    }
}

/// Whether a command did what it was told.
pub fn is_done(arguments: &[&str]) -> bool {
    command(arguments).is_ok()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Whether a solve goes on to its end from the states in a folder, over what the last one left in `out`.
pub fn is_resumed(states: &Path, out: &Path) -> bool {
    resumed(states, out, &[]).is_ok()
}

fn resumed(states: &Path, out: &Path, more: &[&str]) -> Result<u8, Failure> {
    let over = ["--force", "--quiet", "--threads", "1"];
    command(&[&["resume", text(states), "-o", text(out)][..], &over, more].concat())
}

/// Whether a solve would go on from the states in a folder, if it were given memory.
pub fn is_known(states: &Path, out: &Path) -> bool {
    let done = resumed(states, out, &["--memory-limit", "1B"]);
    matches!(done, Err(Failure::Memory(_)))
}

/// A command line, an argument in each line.
pub fn arguments(_: &Path, bytes: &[u8]) -> bool {
    let line = String::from_utf8_lossy(bytes);
    let all = core::iter::once("thurible").chain(line.lines());
    PROGRAM.with_borrow_mut(|program| {
        let found = program.try_get_matches_from_mut(all);
        found.is_ok_and(|found| Cli::from_arg_matches(&found).is_ok())
    })
}

/// What a sweep varies. It plans every run and prints nothing where there is none of the number that is asked for.
pub fn varied(path: &Path, bytes: &[u8]) -> bool {
    let scene = path.with_file_name("s.toml");
    let line = String::from_utf8_lossy(bytes).into_owned();
    let all = ["sweep", text(&scene), "--vary=a=1", "--only", "99999", "--quiet"];
    let done = command_with(&all, |command| {
        if let Command::Sweep(arguments) = command {
            arguments.vary = vec![line];
        }
    });
    match done {
        Err(Failure::Input(why)) => why.starts_with("--only"),
        _ => false,
    }
}

pub fn condensed(path: &Path, _: &[u8]) -> bool {
    // A mesh of cells is as large as the scene says, up to what is allowed.
    is_done(&[
        "condense",
        text(path),
        "--plan",
        "--quiet",
        "--memory-limit",
        "16MiB",
    ])
}

pub fn condensed_obj(path: &Path, _: &[u8]) -> bool {
    condensed(&path.with_file_name("obj.toml"), &[])
}

pub fn condensed_msh(path: &Path, _: &[u8]) -> bool {
    condensed(&path.with_file_name("msh.toml"), &[])
}

/// Cameras and their pictures.
pub fn views(path: &Path, _: &[u8]) -> bool {
    is_done(&["tomography", text(path), "--plan", "--quiet", "--threads", "1"])
}

pub fn capture(path: &Path, _: &[u8]) -> bool {
    is_done(&["track", text(path), "--plan", "--quiet", "--threads", "1"])
}

pub fn blur(path: &Path, bytes: &[u8]) -> bool {
    let image = path.with_file_name("b.npy");
    let line = String::from_utf8_lossy(bytes).into_owned();
    let all = ["deblur", text(&image), "--psf=disc:1", "--plan", "--quiet"];
    let done = command_with(&all, |command| {
        if let Command::Deblur(arguments) = command {
            arguments.psf = line;
        }
    });
    done.is_ok()
}

/// What a result says of itself, as an export reads it.
pub fn report(path: &Path, _: &[u8]) -> bool {
    let done = path.parent().unwrap();
    let out = done.with_file_name("exported");
    is_done(&[
        "export",
        text(done),
        "--format",
        "vti",
        "--steps",
        "0",
        "-o",
        text(&out),
        "--quiet",
    ])
}
