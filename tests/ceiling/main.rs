//! The program under an address-space limit: the plan and what docs/memory.md promises beside it are enough for every method,
//! precision and dimension, and a page less than the plan is refused. On one thread the program needs a few hundred KiB beyond its
//! size at start and the plan, for the shapes as they are drawn and the buffers of files. Less is a clean error, and pictures that do
//! not fit are left out.
#![cfg(all(target_os = "linux", feature = "std"))]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]
#![allow(unsafe_code, reason = "a system call before the program starts")]

mod table;

use serde_json::Value;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const MIB: u64 = 1 << 20;
/// What is allowed beyond the plan. Measured: 0.48 to 0.51 MiB for this scene, by pages of the heap and by profile.
const SPARE: u64 = MIB * 5 / 8;

const SCENE: &str = r#"
[grid]
cells = [64, 64]

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

/// The program in `folder` with at most `limit` bytes of addresses.
fn limited(folder: &Path, limit: u64, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_thurible"));
    command.current_dir(folder).args(arguments);
    // SAFETY: between fork and exec only one system call is made, on a value of its own.
    unsafe {
        command.pre_exec(move || {
            let limit = libc::rlimit {
                rlim_cur: limit,
                rlim_max: limit,
            };
            if libc::setrlimit(libc::RLIMIT_AS, &limit) == 0 {
                Ok(())
            } else {
                Err(std::io::Error::last_os_error())
            }
        });
    }
    command
}

fn run(folder: &Path, limit: u64, arguments: &[&str]) -> Output {
    limited(folder, limit, arguments).output().unwrap()
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
    let plan = run(
        &folder,
        everything,
        &["plan", "scene.toml", "--threads", "1", "--json"],
    );
    assert!(plan.status.success(), "{plan:?}");
    let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
    let start = size_at_start(&folder);
    (folder, start, plan["planned_bytes"].as_u64().unwrap())
}

/// The arguments of a solve that is measured.
const SOLVE: [&str; 8] = [
    "solve",
    "scene.toml",
    "--threads",
    "1",
    "--quiet",
    "--force",
    "-o",
    "out",
];

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn the_program_needs_its_plan_and_little_more() {
    let (folder, start, bytes) = prepared("ceiling_program", SCENE);
    assert!(bytes > 4 * MIB);
    let enough = run(&folder, start + bytes + SPARE, &SOLVE);
    assert!(
        matches!(enough.status.code(), Some(0 | 5)),
        "with {start} + {bytes} + {SPARE}: {enough:?}"
    );
    assert!(
        fs::read_to_string(folder.join("out/report.html"))
            .unwrap()
            .contains("data:image"),
        "no pictures"
    );
    for less in (0..=20).map(|step| step * 32 * 1024) {
        let short = run(&folder, start + bytes + SPARE - less, &SOLVE);
        match short.status.code() {
            Some(0 | 5) => {}
            Some(3) => assert!(
                words(&short).trim().lines().count() == 1 && words(&short).contains("bytes"),
                "{}",
                words(&short)
            ),
            _ => panic!("{less} bytes less: {short:?}"),
        }
    }
    let short = run(&folder, start + bytes - 65_536, &SOLVE);
    assert_eq!(short.status.code(), Some(3), "64 KiB short: {short:?}");
}

/// Pictures of a small scene are larger than its plan.
#[test]
fn pictures_that_do_not_fit_are_left_out() {
    let small = SCENE
        .replace("[64, 64]", "[16, 16]")
        .replace("steps = 24", "steps = 4")
        .replace("step = 24", "step = 4")
        .replace("frames = false", "");
    let (folder, start, bytes) = prepared("ceiling_pictures", &small);
    let ended = run(
        &folder,
        start + bytes + SPARE,
        &["solve", "scene.toml", "--threads", "1", "--force", "-o", "out"],
    );
    assert!(matches!(ended.status.code(), Some(0 | 5)), "{ended:?}");
    assert!(
        words(&ended).contains("warning: the system has not the memory to draw pictures"),
        "{}",
        words(&ended)
    );
    for name in ["result.npz", "report.json", "report.html"] {
        assert!(folder.join("out").join(name).exists(), "{name}");
    }
    assert!(!folder.join("out/frames").exists());
}

/// What docs/memory.md promises that a run takes beside its block, in addresses and in resident memory: code, files, stacks,
const BESIDE: u64 = 36 * MIB;
/// and so many bytes for each cell while shapes are drawn.
const DRAWING: u64 = 16;

/// How a child ended, and the most memory that it had at a time.
#[expect(clippy::zombie_processes, reason = "`wait4` waits, and tells the memory too")]
fn ended(mut command: Command) -> (Option<i32>, u64) {
    let child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // SAFETY: all zeros is a value of these numbers.
    let mut usage: libc::rusage = unsafe { core::mem::zeroed() };
    let (mut status, child) = (0, libc::pid_t::try_from(child.id()).unwrap());
    // SAFETY: a system call that writes to two values that live; the child is ours and nobody else waits for it.
    assert_eq!(unsafe { libc::wait4(child, &mut status, 0, &mut usage) }, child);
    let code = libc::WIFEXITED(status).then(|| libc::WEXITSTATUS(status));
    // The parent's memory at the fork counts as well, which can only raise it.
    (code, u64::try_from(usage.ru_maxrss).unwrap() * 1024)
}

/// The most memory that this program has had, in bytes.
fn own_peak() -> u64 {
    // SAFETY: all zeros is a value of these numbers.
    let mut usage: libc::rusage = unsafe { core::mem::zeroed() };
    // SAFETY: a system call that writes to a value that lives.
    assert_eq!(unsafe { libc::getrusage(libc::RUSAGE_SELF, &mut usage) }, 0);
    u64::try_from(usage.ru_maxrss).unwrap() * 1024
}

/// A scene that is refused when its last shape has been drawn, so that nothing else takes long.
#[test]
fn drawing_takes_what_is_promised() {
    let (cells, steps) = ("cells = [1024, 1024]", "steps = 2");
    let large = SCENE
        .replace("cells = [64, 64]", cells)
        .replace("steps = 24", steps)
        .replace("step = 24", "step = 2")
        .replace("[0.6, 0.5]", "[9.0, 9.0]");
    let (folder, _, bytes) = prepared("ceiling_drawing", &large);
    let promised = bytes + BESIDE + DRAWING * 1024 * 1024;
    assert!(
        words(&run(&folder, promised, &SOLVE)).contains("puts nothing into the box"),
        "with {promised} bytes of addresses"
    );
    let (code, peak) = ended(limited(&folder, promised, &SOLVE));
    assert_eq!(code, Some(2));
    assert!(
        (bytes..=promised).contains(&peak),
        "{peak} bytes were resident, of {bytes} planned"
    );
}

#[test]
fn a_picture_that_does_not_fit_is_refused() {
    let (folder, start, bytes) = prepared(
        "ceiling_picture",
        &SCENE.replacen(
            "circle = { center = [0.4, 0.5], radius = 0.2 }",
            "image = \"large.png\"",
            1,
        ),
    );
    let side = 8192;
    let mut encoder = png::Encoder::new(fs::File::create(folder.join("large.png")).unwrap(), side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&vec![255; (side * side) as usize])
        .unwrap();
    let needed = u64::from(side * side);
    let short = run(&folder, start + bytes + needed / 2, &SOLVE);
    assert_eq!(short.status.code(), Some(2), "{short:?}");
    assert!(
        words(&short).contains("67,108,864 bytes to read"),
        "{}",
        words(&short)
    );
    let enough = run(&folder, start + bytes + BESIDE + needed, &SOLVE);
    assert!(matches!(enough.status.code(), Some(0 | 5)), "{enough:?}");
}

/// Where there is room for the block but not for the threads, threads are refused, and not started to end the program.
#[test]
fn threads_without_addresses_are_refused() {
    let (folder, start, bytes) = prepared("ceiling_threads", SCENE);
    for more in [1, 3, 8, 16, 40, 70, 100, 130, 190, 240, 300] {
        let ended = run(
            &folder,
            start + bytes + MIB + more * MIB,
            &[
                "solve",
                "scene.toml",
                "--threads",
                "2",
                "--quiet",
                "--force",
                "-o",
                "out",
            ],
        );
        match ended.status.code() {
            Some(3) if more < 200 => assert!(words(&ended).contains("use --threads 1"), "{}", words(&ended)),
            Some(0 | 5) if more > 200 => {}
            _ => panic!("{more} MiB more: {ended:?}"),
        }
    }
}
