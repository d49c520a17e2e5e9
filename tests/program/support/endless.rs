//! A solve that a test stops when it has seen enough.

use super::Ended;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

/// A solve that goes on until it is stopped, seen to iterate.
pub struct Endless {
    program: Child,
    lines: BufReader<ChildStdout>,
}

impl Endless {
    /// Starts `command`, and waits for an iteration.
    pub fn begin(command: &mut Command) -> Self {
        let command = command.args(["--json", "--set", "method.iterations=1000000"]);
        Self::seen(command, |line| line.contains("\"iteration\""))
    }

    /// Starts `command`, which prints lines of JSON, and waits for one that `is_it`.
    pub fn seen(command: &mut Command, mut is_it: impl FnMut(&str) -> bool) -> Self {
        let mut program = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(program.stdout.take().unwrap());
        let mut line = String::new();
        while !is_it(&line) {
            line.clear();
            assert!(
                lines.read_line(&mut line).unwrap() > 0,
                "what is waited for was not seen"
            );
        }
        Self { program, lines }
    }

    /// Solves `scene` into `out`.
    pub fn solving(scene: &str, out: &Path) -> Self {
        Self::begin(super::thurible().args(["solve", scene, "--force", "-o", out.to_str().unwrap()]))
    }

    /// Ends it at once, by the signal that nobody hears.
    pub fn kill(mut self) {
        self.program.kill().unwrap();
        self.program.wait().unwrap();
    }

    /// Asks it to stop, and returns how it ended.
    pub fn stop(self) -> Ended {
        let kill = format!("kill -INT {}", self.program.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        self.wait()
    }

    /// Waits until somebody has stopped it, and returns how it ended.
    pub fn wait(mut self) -> Ended {
        let mut out = String::new();
        self.lines.read_to_string(&mut out).unwrap();
        let mut ended = Ended::from(self.program.wait_with_output().unwrap());
        ended.out = out;
        ended
    }
}
