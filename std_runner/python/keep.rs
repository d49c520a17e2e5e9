//! The state of a solve in a file, from which it goes on bit for bit: a word of what it began with, and the core's saved bytes.

use crate::words::refused;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use thurible_core::checkpoint::{Mix, Refused, Sink, Source};
use thurible_core::{Real, SavedError, Solver, Space};

/// Keeps the state of a solve.
pub struct Keep {
    path: PathBuf,
    every: Duration,
    last: Instant,
    /// All that the solve began with.
    begun: u64,
    /// Why the state could not be written, the first time.
    pub trouble: Option<io::Error>,
}

struct Writes<'a>(&'a mut BufWriter<File>, Option<io::Error>);

impl Sink for Writes<'_> {
    fn put(&mut self, bytes: &[u8]) -> Result<(), Refused> {
        self.0.write_all(bytes).map_err(|error| {
            self.1 = Some(error);
            Refused
        })
    }
}

struct Reads(BufReader<File>);

impl Source for Reads {
    fn take(&mut self, bytes: &mut [u8]) -> Result<(), Refused> {
        self.0.read_exact(bytes).map_err(|_| Refused)
    }
}

struct Mixes(Mix);

impl Sink for Mixes {
    fn put(&mut self, bytes: &[u8]) -> Result<(), Refused> {
        self.0.bytes(bytes);
        Ok(())
    }
}

/// All that `solver`, which has not begun yet, was given, in a word.
pub fn digest<T: Real, S: Space>(solver: &mut Solver<'_, T, S>) -> u64 {
    let mut mixes = Mixes(Mix::new());
    // Mixing refuses nothing.
    let _ = solver.save_to(&mut mixes);
    mixes.0.finish()
}

/// Goes on from the state at `path`; `begun` is what the solver was given.
pub fn resume<T: Real, S: Space>(solver: &mut Solver<'_, T, S>, path: &Path, begun: u64) -> PyResult<()> {
    let unread =
        |error: io::Error| PyOSError::new_err(format!("resume: cannot read {}: {error}", path.display()));
    let mut file = BufReader::new(File::open(path).map_err(unread)?);
    let mut word = [0; 8];
    file.read_exact(&mut word).map_err(unread)?;
    let other = || {
        refused(
            "resume",
            "is the state of a solve with other arrays or choices; give those that it began with",
        )
    };
    if u64::from_le_bytes(word) != begun {
        return Err(other());
    }
    let length = file.get_ref().metadata().map_err(unread)?.len();
    let damaged = || {
        refused(
            "resume",
            "is damaged or not whole; solve anew, or take an earlier state",
        )
    };
    if length != 8 + solver.saved_bytes() as u64 {
        return Err(damaged());
    }
    solver
        .restore_from(&mut Reads(file))
        .map_err(|error| match error {
            SavedError::OtherSolve => other(),
            _ => damaged(),
        })
}

impl Keep {
    /// At `path`, after every iteration that ends `seconds` or more after the last state.
    pub fn new(path: PathBuf, seconds: f64, begun: u64) -> Self {
        Self {
            path,
            every: Duration::from_secs_f64(seconds),
            last: Instant::now(),
            begun,
            trouble: None,
        }
    }

    /// Writes the state where it is due: aside, synced, then in its place.
    pub fn after<T: Real, S: Space>(&mut self, solver: &mut Solver<'_, T, S>) {
        if self.last.elapsed() < self.every {
            return;
        }
        if let Err(error) = self.write(solver) {
            // What cannot be written is no reason to end a solve.
            self.trouble.get_or_insert(error);
        }
        self.last = Instant::now();
    }

    fn write<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>) -> io::Result<()> {
        let mut name = self.path.file_name().unwrap_or_default().to_owned();
        name.push(".part");
        let part = self.path.with_file_name(name);
        let mut file = BufWriter::new(File::create(&part)?);
        file.write_all(&self.begun.to_le_bytes())?;
        let mut writes = Writes(&mut file, None);
        if solver.save_to(&mut writes).is_err() {
            let other = || io::Error::from(io::ErrorKind::Other);
            return Err(writes.1.unwrap_or_else(other));
        }
        file.flush()?;
        file.get_ref().sync_all()?;
        fs::rename(&part, &self.path)
    }
}
