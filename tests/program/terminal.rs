//! What a terminal shows, with colours and without, and pipes whose reader goes away.

use super::support::{fresh_folder, text, thurible};
use std::fs::File;
use std::io::Read;
use std::os::fd::{FromRawFd, OwnedFd};
use std::process::{Command, Stdio};

/// Both ends of a terminal of 120 columns: ours, and the program's.
#[allow(unsafe_code, reason = "the standard library opens no terminal")]
fn terminal() -> [OwnedFd; 2] {
    let mut ends = [-1; 2];
    let size = libc::winsize {
        ws_row: 40,
        ws_col: 120,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    let [ours, its] = &mut ends;
    let (name, modes) = (core::ptr::null_mut(), core::ptr::null_mut());
    // SAFETY: it writes two descriptors, which nobody else owns, and reads the size.
    unsafe {
        assert_eq!(
            libc::openpty(ours, its, name, modes, (&raw const size).cast_mut()),
            0
        );
        ends.map(|end| OwnedFd::from_raw_fd(end))
    }
}

/// What a terminal is shown of a command.
fn shown(mut command: Command) -> String {
    let [ours, its] = terminal();
    let mut program = command
        .stdin(Stdio::null())
        .stdout(its.try_clone().unwrap())
        .stderr(its)
        .spawn()
        .unwrap();
    // It has the only other ends.
    drop(command);
    let mut all = Vec::new();
    // Where the last other end is closed, Linux answers with an error.
    let _ = File::from(ours).read_to_end(&mut all);
    program.wait().unwrap();
    String::from_utf8_lossy(&all).into_owned()
}

/// A command of a terminal that knows colours.
fn command(arguments: &[&str], colours: bool) -> Command {
    let mut command = thurible();
    command.args(arguments).env("TERM", "xterm-256color");
    for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "CI"] {
        command.env_remove(name);
    }
    if !colours {
        command.env("NO_COLOR", "1");
    }
    command
}

/// Whether there are colours or weights of letters in it; where the cursor goes is another matter.
fn is_coloured(shown: &str) -> bool {
    let mut codes = shown.split("\x1b[").skip(1);
    codes.any(|code| {
        code.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';')
            .starts_with('m')
    })
}

#[test]
fn no_color_takes_the_colours_away() {
    for arguments in [
        &["--help"][..],
        &["solve"],
        &["solve", "--nonsense"],
        &["solve", "nowhere.toml"],
    ] {
        let plain = shown(command(arguments, false));
        assert!(
            !is_coloured(&plain) && plain.len() > 20,
            "{arguments:?}: {plain:?}"
        );
    }
    // There are some to take away.
    let help = shown(command(&["--help"], true));
    assert!(is_coloured(&help), "{help:?}");
}

#[test]
fn a_bar_is_drawn_on_a_terminal() {
    let out = fresh_folder("terminal").join("out");
    let solve = [
        "solve",
        "examples/small_letter.toml",
        "--set",
        "output.frames=false",
        "-o",
        text(&out),
    ];
    let plain = shown(command(&solve, false));
    assert!(
        plain.contains('\r') || plain.contains("\x1b["),
        "no bar: {plain:?}"
    );
    assert!(!is_coloured(&plain), "{plain:?}");
    assert!(out.join("result.npz").exists());
}

/// As in `thurible ... | head -n 1`: no word of it, and what was asked for is done.
#[test]
fn a_reader_that_goes_away_is_not_told_of() {
    let out = fresh_folder("closed_pipe").join("out");
    let solve = [
        "solve",
        "examples/small_letter.toml",
        "--json",
        "--set",
        "output.frames=false",
        "-o",
        text(&out),
    ];
    for arguments in [
        &solve[..],
        &["--help"],
        &["schema"],
        &[
            "scene",
            "check",
            "examples/small_letter.toml",
            "-o",
            text(&out.join("seen.png")),
        ],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let ended = thurible()
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert!(
            ended.stderr.is_empty(),
            "{arguments:?}: {}",
            String::from_utf8_lossy(&ended.stderr)
        );
        assert!(
            matches!(ended.status.code(), Some(0 | 5)),
            "{arguments:?}: {}",
            ended.status
        );
    }
    assert!(out.join("result.npz").exists() && out.join("seen.png").exists());
}
