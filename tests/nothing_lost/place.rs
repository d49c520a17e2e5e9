//! The program under test, and folders to try it in.

use crate::scenes::Case;
use core::time::Duration;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Where the program and the folders are.
pub struct Place {
    program: PathBuf,
    pub work: PathBuf,
}

/// How a run ended.
#[derive(Debug)]
pub struct Ended {
    pub code: Option<i32>,
    pub err: String,
}

impl Place {
    pub fn new(program: PathBuf, work: PathBuf) -> Self {
        fs::create_dir_all(&work).unwrap();
        Self { program, work }
    }

    /// An empty folder with a scene in it.
    pub fn fresh(&self, case: &Case) -> PathBuf {
        let folder = self.work.join(case.name);
        if folder.exists() {
            fs::remove_dir_all(&folder).unwrap();
        }
        fs::create_dir_all(folder.join("tmp")).unwrap();
        fs::write(folder.join("scene.toml"), case.scene).unwrap();
        folder
    }

    /// The program in `folder`, quiet but for errors.
    pub fn command(&self, folder: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command
            .args(arguments)
            .arg("--quiet")
            .current_dir(folder)
            .env("TMPDIR", folder.join("tmp"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command
    }

    /// The command that solves `case` into `out` and keeps its state after every iteration.
    pub fn solving(&self, folder: &Path, case: &Case, more: &[&str]) -> Command {
        let first = [case.command, "scene.toml", "-o", "out", "--threads", "1"];
        let kept = ["--checkpoint", "every=1"];
        self.command(folder, &[&first[..], &kept, case.more, more].concat())
    }

    /// What a solve that nobody disturbs writes, and how long it takes.
    pub fn whole(&self, case: &Case) -> (Vec<u8>, Duration) {
        let folder = self.fresh(case);
        let begun = Instant::now();
        let ended = run(&mut self.solving(&folder, case, &[]));
        assert!(ended.is_well(), "{}: {ended:?}", case.name);
        (result(&folder).unwrap(), begun.elapsed())
    }
}

impl Ended {
    /// Whether a result was written where it should be.
    pub fn is_well(&self) -> bool {
        matches!(self.code, Some(0 | 5))
    }

    /// Whether it ended in order: a code that is documented, and one sentence where there is something to say.
    pub fn is_in_order(&self) -> bool {
        let words = ["panicked", "RUST_BACKTRACE", "ZipWriter", "unwrap"];
        let sentences = self.err.lines().all(|line| line.starts_with("thurible: "));
        let is_said = self.is_well() || (self.code == Some(4) && self.err.lines().count() == 1);
        is_said && sentences && !words.iter().any(|word| self.err.contains(word))
    }
}

/// Runs a command to its end.
pub fn run(command: &mut Command) -> Ended {
    let output = command.output().unwrap();
    Ended {
        code: output.status.code(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// The arrays of the result in `folder`, if there is a whole one.
pub fn result(folder: &Path) -> Option<Vec<u8>> {
    let out = folder.join("out");
    let names = ["report.json", "report.html", "manifest.json"];
    let is_whole = names.iter().all(|name| out.join(name).is_file());
    fs::read(out.join("result.npz")).ok().filter(|_| is_whole)
}

/// What is in `folder`, but for what was there from the beginning.
pub fn left_over(folder: &Path) -> Vec<String> {
    let names = |folder: &Path| -> Vec<String> {
        let entries = fs::read_dir(folder).into_iter().flatten();
        entries
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect()
    };
    let own = ["scene.toml", "tmp", "out", "count"];
    let mut left = names(folder);
    left.retain(|name| !own.contains(&name.as_str()));
    left.extend(names(&folder.join("tmp")));
    left.extend(
        names(&folder.join("out"))
            .into_iter()
            .filter(|name| name.starts_with('.')),
    );
    left
}
