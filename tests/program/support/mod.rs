//! What the tests of the program share: running it, reading its files, and checking them by themselves.

#[cfg(unix)]
pub mod endless;
pub mod field;
pub mod npz;
pub mod physics;
pub mod verify;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program under test.
pub fn thurible() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_thurible"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// The same, where a shell lets no file grow beyond so many blocks of 512 bytes.
#[cfg(unix)]
pub fn with_short_files(blocks: u32) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -f {blocks}; exec \"$@\""), "sh"]);
    command.arg(thurible().get_program());
    command
}

/// A fresh, empty folder for the test `name`.
pub fn fresh_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A path as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The number that stands in a sentence after `words`, as in `takes 1,024 bytes`.
pub fn bytes_after(sentence: &str, words: &str) -> usize {
    let (_, rest) = sentence.split_once(words).unwrap();
    rest.split(' ').next().unwrap().replace(',', "").parse().unwrap()
}

/// The JSON of a file.
pub fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The exit code and what was printed on stdout and stderr.
pub struct Ended {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl From<Output> for Ended {
    fn from(output: Output) -> Self {
        Ended {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

/// Runs the program with `arguments`.
pub fn run(arguments: &[&str]) -> Ended {
    thurible().args(arguments).output().unwrap().into()
}

/// Solves `examples/NAME.toml` into a fresh folder, demands that it ends well, and returns the folder.
pub fn solve_example(name: &str, test: &str, more: &[&str]) -> PathBuf {
    let folder = fresh_folder(test).join("out");
    let scene = format!("examples/{name}.toml");
    let mut arguments = vec![
        "solve",
        &scene,
        "--quiet",
        "--set",
        "output.frames=false",
        "-o",
        folder.to_str().unwrap(),
    ];
    arguments.extend(more);
    let ended = run(&arguments);
    assert!(
        ended.code == 0 || ended.code == 5,
        "{test}: exit code {}, {}",
        ended.code,
        ended.err
    );
    folder
}

/// A page but for the data of its pictures, in which any few letters may happen to stand.
pub fn without_pictures(page: &str) -> String {
    let mut parts = page.split("base64,");
    let first = parts.next().unwrap_or_default();
    core::iter::once(first)
        .chain(parts.map(|part| &part[part.find('"').unwrap_or_default()..]))
        .collect()
}
