//! The program under an address-space limit, on one thread: beyond its size at start and the plan it needs a few hundred KiB for
//! the shapes as they are drawn and the buffers of files. Less is a clean error, and pictures that do not fit are left out.
#![cfg(all(target_os = "linux", feature = "std"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test says what went wrong by panicking")]
#![allow(unsafe_code, reason = "a system call before the program starts")]

use serde_json::Value;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const MIB: u64 = 1 << 20;
/// What is allowed beyond the plan. Measured: 0.4 MiB for this scene.
const SPARE: u64 = MIB / 2;

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

/// An empty folder with `scene`, the program's size at start and the planned bytes.
fn prepared(name: &str, scene: &str) -> (PathBuf, u64, u64) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("scene.toml"), scene).unwrap();
    let everything = 1 << 40;
    let plan = run(&folder, everything, &["plan", "scene.toml", "--threads", "1", "--json"]);
    assert!(plan.status.success(), "{plan:?}");
    let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
    let start = size_at_start(&folder);
    (folder, start, plan["planned_bytes"].as_u64().unwrap())
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn the_program_needs_its_plan_and_little_more() {
    let (folder, start, bytes) = prepared("ceiling_program", SCENE);
    assert!(bytes > 4 * MIB);
    let solve = ["solve", "scene.toml", "--threads", "1", "--quiet", "-o", "out"];
    let enough = run(&folder, start + bytes + SPARE, &solve);
    assert!(matches!(enough.status.code(), Some(0 | 5)), "with {start} + {bytes} + {SPARE}: {enough:?}");
    assert!(fs::read_to_string(folder.join("out/report.html")).unwrap().contains("data:image"), "no pictures");
    for less in (0..=16).map(|step| step * 32 * 1024) {
        let short = run(&folder, start + bytes + SPARE - less, &solve);
        match short.status.code() {
            Some(0 | 5) => {}
            Some(3) => assert!(words(&short).trim().lines().count() == 1 && words(&short).contains("bytes"), "{}", words(&short)),
            _ => panic!("{less} bytes less: {short:?}"),
        }
    }
    let short = run(&folder, start + bytes - 65_536, &solve);
    assert_eq!(short.status.code(), Some(3), "64 KiB short: {short:?}");
}

/// Pictures of a small scene are larger than its plan.
#[test]
fn pictures_that_do_not_fit_are_left_out() {
    let small = SCENE.replace("[96, 96]", "[16, 16]").replace("steps = 24", "steps = 4").replace("step = 24", "step = 4").replace("frames = false", "");
    let (folder, start, bytes) = prepared("ceiling_pictures", &small);
    let ended = run(&folder, start + bytes + SPARE, &["solve", "scene.toml", "--threads", "1", "-o", "out"]);
    assert!(matches!(ended.status.code(), Some(0 | 5)), "{ended:?}");
    assert!(words(&ended).contains("warning: the system has not the memory to draw pictures"), "{}", words(&ended));
    for name in ["result.npz", "report.json", "report.html"] {
        assert!(folder.join("out").join(name).exists(), "{name}");
    }
    assert!(!folder.join("out/frames").exists());
}
