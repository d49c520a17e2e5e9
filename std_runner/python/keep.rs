//! The state of a solve in a file, from which it goes on bit for bit: a word of what it began with, and the core's saved bytes.

use crate::words::{read, refused};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use std::ffi::CString;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use thurible_core::SavedError;
use thurible_core::checkpoint::{Mix, Refused, Resumable, Sink, Source, restore_from, save_to};

/// Keeps the state of a solve.
pub struct Keep {
    path: PathBuf,
    every: Duration,
    last: Instant,
    /// All that the solve began with.
    begun: u64,
    /// Why the state could not be written, the first time.
    trouble: Option<io::Error>,
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

/// All that `one`, which has not begun yet, was given, in a word.
fn digest(one: &mut dyn Resumable) -> u64 {
    let mut mixes = Mixes(Mix::new());
    // Mixing refuses nothing.
    let _ = save_to(one, &mut mixes);
    mixes.0.finish()
}

/// The arguments by which a state is kept, and gone on from.
pub const ARGUMENTS: [&str; 3] = ["checkpoint", "checkpoint_every", "resume"];

/// Where the state is kept, how often in seconds, and where one is gone on from.
pub struct States {
    checkpoint: Option<PathBuf>,
    every: f64,
    resume: Option<PathBuf>,
}

impl States {
    /// Those of the [`ARGUMENTS`].
    pub fn read([checkpoint, every, resume]: [Option<Bound<'_, PyAny>>; 3]) -> PyResult<Self> {
        let path = |name: &str, value: Option<Bound<'_, PyAny>>| {
            value.map(|value| read(name, &value, "a path")).transpose()
        };
        let [_, name, _] = ARGUMENTS;
        let every = every.map_or(Ok(60.0), |every| read(name, &every, "a number of seconds"))?;
        if !(0.0..1e9).contains(&every) {
            return Err(refused(name, "is no number of seconds from 0; give one"));
        }
        Ok(Self {
            checkpoint: path("checkpoint", checkpoint)?,
            every,
            resume: path("resume", resume)?,
        })
    }

    /// Lets `one`, which was given its arrays, go on if that is asked for; what keeps its state.
    pub fn begin(&self, one: &mut dyn Resumable) -> PyResult<Option<Keep>> {
        if self.checkpoint.is_none() && self.resume.is_none() {
            return Ok(None);
        }
        let begun = digest(one);
        if let Some(path) = &self.resume {
            resume(one, path, begun)?;
        }
        let keep = |path: &PathBuf| Keep::new(path.clone(), self.every, begun);
        self.checkpoint.as_ref().map(keep).transpose()
    }
}

/// An error of the system in our words, of the kind that Python has for it: `FileNotFoundError` and so on.
fn failed(error: &io::Error, words: String) -> PyErr {
    io::Error::new(error.kind(), words).into()
}

/// Goes on from the state at `path`; `begun` is what `one` was given.
fn resume(one: &mut dyn Resumable, path: &Path, begun: u64) -> PyResult<()> {
    let damaged = || {
        refused(
            "resume",
            "is damaged or not whole; solve anew, or take an earlier state",
        )
    };
    let unread = |error: io::Error| {
        if error.kind() == io::ErrorKind::UnexpectedEof {
            return damaged();
        }
        failed(&error, format!("resume: cannot read {}: {error}", path.display()))
    };
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
    if length != 8 + one.saved_bytes() as u64 {
        return Err(damaged());
    }
    restore_from(one, &mut Reads(file)).map_err(|error| match error {
        SavedError::OtherSolve => other(),
        _ => damaged(),
    })
}

impl Keep {
    /// At `path`, after every iteration that ends `seconds` or more after the last state. A place that cannot be written to is refused now, and
    /// not after hours.
    fn new(path: PathBuf, seconds: f64, begun: u64) -> PyResult<Self> {
        let keep = Self {
            path,
            every: Duration::from_secs_f64(seconds),
            last: Instant::now(),
            begun,
            trouble: None,
        };
        let part = keep.part();
        let path = keep.path.display();
        if keep.path.is_dir() || keep.path.file_name().is_none() {
            return Err(refused(
                "checkpoint",
                format!("is the folder {path:?}; give the path of a file"),
            ));
        }
        let tried = File::create(&part).and_then(|_| fs::remove_file(&part));
        tried.map_err(|error| {
            let remedy = "give a path in a folder that is there";
            failed(
                &error,
                format!("checkpoint: cannot write {path}: {error}; {remedy}"),
            )
        })?;
        Ok(keep)
    }

    /// Where a state is written before it is whole.
    fn part(&self) -> PathBuf {
        let mut name = self.path.file_name().unwrap_or_default().to_owned();
        name.push(".part");
        self.path.with_file_name(name)
    }

    /// Writes the state where it is due: aside, synced, then in its place.
    pub fn after(&mut self, one: &mut dyn Resumable) {
        if self.last.elapsed() < self.every {
            return;
        }
        if let Err(error) = self.write(one) {
            // What cannot be written is no reason to end a solve.
            self.trouble.get_or_insert(error);
        }
        self.last = Instant::now();
    }

    fn write(&self, one: &mut dyn Resumable) -> io::Result<()> {
        let part = self.part();
        let mut file = BufWriter::new(File::create(&part)?);
        file.write_all(&self.begun.to_le_bytes())?;
        let mut writes = Writes(&mut file, None);
        if save_to(one, &mut writes).is_err() {
            let other = || io::Error::from(io::ErrorKind::Other);
            return Err(writes.1.unwrap_or_else(other));
        }
        file.flush()?;
        file.get_ref().sync_all()?;
        fs::rename(&part, &self.path).inspect_err(|_| {
            // The state before is whole; what of this one cannot be put there is of no use.
            let _ = fs::remove_file(&part);
        })
    }

    /// Warns where the state could not be kept.
    pub fn end(self, py: Python<'_>) -> PyResult<()> {
        let Some(error) = self.trouble else {
            return Ok(());
        };
        let text = CString::new(format!("checkpoint: the state could not be kept: {error}"))?;
        PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)
    }
}
