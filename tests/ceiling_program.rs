//! The program under an address-space limit: beyond its size at start and the plan it needs a few MiB, on one thread, for the
//! stack that listens for Ctrl-C and for writing the result; 64 KiB less than the plan is a clean error.
#![cfg(all(target_os = "linux", feature = "std"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test says what went wrong by panicking")]
#![allow(unsafe_code, reason = "a system call before the program starts")]

use serde_json::Value;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Output};

const MIB: u64 = 1 << 20;
/// A thread's stack of 2 MiB, buffers of files.
const SPARE: u64 = 6 * MIB;

const SCENE: &str = r#"
[grid]
cells = [96, 96]

[time]
steps = 24

[source]
circle = { center = [0.4, 0.5], radius = 0.2 }

[[keyframe]]
step = 24
circle = { center = [0.6, 0.5], radius = 0.2 }

[method]
iterations = 1

[output]
frames = false
"#;

/// Runs the program in `folder` with at most `limit` bytes of addresses.
fn run(folder: &Path, limit: u64, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_thurible"));
    command.current_dir(folder).args(arguments);
    // SAFETY: between fork and exec only one system call is made, on a value of its own.
    unsafe {
        command.pre_exec(move || {
            let limit = libc::rlimit { rlim_cur: limit, rlim_max: limit };
            if libc::setrlimit(libc::RLIMIT_AS, &limit) == 0 { Ok(()) } else { Err(std::io::Error::last_os_error()) }
        });
    }
    command.output().unwrap()
}

/// The least address space, to a page, in which the program starts and says its version.
fn size_at_start(folder: &Path) -> u64 {
    let (mut short, mut enough) = (0, 1 << 33);
    while enough - short > 4096 {
        let middle = (short + enough) / 2;
        let starts = run(folder, middle, &["--version"]).status.success();
        (short, enough) = if starts { (short, middle) } else { (middle, enough) };
    }
    enough
}

#[test]
fn the_program_needs_its_plan_and_little_more() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ceiling_program");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let everything = 1 << 40;
    let plan = run(&folder, everything, &["plan", "scene.toml", "--threads", "1", "--json"]);
    assert!(plan.status.success(), "{plan:?}");
    let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
    let bytes = plan["planned_bytes"].as_u64().unwrap();
    assert!(bytes > 4 * MIB);
    let start = size_at_start(&folder);
    let solve = ["solve", "scene.toml", "--threads", "1", "--quiet", "-o", "out"];
    let enough = run(&folder, start + bytes + SPARE, &solve);
    assert!(matches!(enough.status.code(), Some(0 | 5)), "with {start} + {bytes} + {SPARE}: {enough:?}");
    let short = run(&folder, start + bytes - 65_536, &solve);
    let words = String::from_utf8_lossy(&short.stderr).into_owned();
    assert_eq!(short.status.code(), Some(3), "64 KiB short: {short:?}");
    assert!(words.trim().lines().count() == 1 && words.contains("bytes"), "{words}");
}
