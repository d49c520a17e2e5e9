//! Where runs are made, each once: in a folder of its own below that of the page, by the same doors as the commands.

use crate::commands::options::Options;
use crate::destination::{Earlier, remove_written};
use crate::exit::{FILE, Failure, INTERRUPTED, NOT_FINITE};
use crate::interrupt::Interrupt;
use crate::output::OutputError;
use crate::progress::Clock;
use crate::quoted::Scale;
use crate::report::ARCHIVE;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Why a row was not made.
#[derive(Clone, Debug)]
pub(crate) enum Halt {
    /// The user asked to stop.
    Asked,
    /// The run came to nothing; the sentence goes into its row.
    Failed(String),
    /// Nothing else can be run either.
    Broken(Failure),
}

impl From<Failure> for Halt {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::NotFinite(why) | Failure::Memory(why) => Self::Failed(why),
            other => Self::Broken(other),
        }
    }
}

impl From<OutputError> for Halt {
    fn from(error: OutputError) -> Self {
        Self::Broken(error.into())
    }
}

/// A run that is over.
#[derive(Debug)]
pub(crate) struct Made {
    /// Its result folder.
    pub folder: PathBuf,
    /// Its `report.json`, where it has one.
    pub report: Value,
    /// That it took, reading, drawing and writing included.
    pub seconds: f64,
}

impl Made {
    /// Its arrays.
    pub fn archive(&self) -> PathBuf {
        self.folder.join(ARCHIVE)
    }

    /// What it says of its iterations, pairs, steps or chains.
    pub fn history(&self) -> &[Value] {
        self.list("history")
    }

    /// A list of its report.
    pub fn list(&self, key: &str) -> &[Value] {
        let list = self.report.get(key).and_then(Value::as_array);
        list.map_or(&[], Vec::as_slice)
    }

    /// A number of its report.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.report.get(key).and_then(Value::as_f64)
    }

    /// Cells along x, y (and z).
    pub fn cells(&self) -> Vec<usize> {
        let cells = self.list("cells").iter().filter_map(Value::as_u64);
        cells.map(|count| count as usize).collect()
    }

    /// Bytes of its block.
    pub fn bytes(&self) -> Option<usize> {
        let planned = self.report.get("memory").unwrap_or(&self.report);
        let bytes = planned.get("planned_bytes").and_then(Value::as_u64);
        bytes.and_then(|bytes| usize::try_from(bytes).ok())
    }
}

/// A number of an entry of a history.
pub(crate) fn at(entry: &Value, key: &str) -> Option<f64> {
    entry.get(key).and_then(Value::as_f64)
}

/// Makes runs, and remembers them.
pub(crate) struct Bench<'a> {
    /// Those of the command line.
    pub options: &'a Options,
    /// How much smaller than usual everything is.
    pub scale: Scale,
    /// Where the runs' folders are, and what becomes of results there.
    folder: PathBuf,
    earlier: Earlier,
    /// Whether the user wants to stop.
    pub interrupt: Interrupt,
    done: BTreeMap<String, Result<Rc<Made>, String>>,
}

impl<'a> Bench<'a> {
    /// Nothing made yet.
    pub fn new(
        options: &'a Options,
        scale: Scale,
        (folder, earlier): (&Path, Earlier),
        interrupt: &Interrupt,
    ) -> Self {
        Self {
            options,
            scale,
            folder: folder.to_owned(),
            earlier,
            interrupt: interrupt.clone(),
            done: BTreeMap::new(),
        }
    }

    /// The folder of the run `name`.
    pub fn place(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// That the run `name` has failed, if it has.
    pub fn remember(&mut self, name: &str, halt: &Halt) {
        if let Halt::Failed(why) = halt {
            self.done.insert(name.into(), Err(why.clone()));
        }
    }

    /// Whether the run `name` has been made, or has failed.
    pub fn has(&self, name: &str) -> bool {
        self.done.contains_key(name)
    }

    /// `cells` at the scale, multiples of 4 and 8 at least.
    pub fn cells(&self, cells: &[usize]) -> Vec<usize> {
        let scaled = self.scale.cells(cells);
        scaled.into_iter().map(|count| count.max(8)).collect()
    }

    /// The run `name`: as it was made before, or as `make` makes it in the folder that it is handed, with the exit code that it returns.
    pub fn once(
        &mut self,
        name: &str,
        make: impl FnOnce(&Self, &Path) -> Result<u8, Halt>,
    ) -> Result<Rc<Made>, Halt> {
        if let Some(done) = self.done.get(name) {
            return done.clone().map_err(Halt::Failed);
        }
        let made = self
            .make(name, make)
            .inspect_err(|halt| self.remember(name, halt))?;
        self.done.insert(name.into(), Ok(Rc::clone(&made)));
        Ok(made)
    }

    fn make(
        &self,
        name: &str,
        make: impl FnOnce(&Self, &Path) -> Result<u8, Halt>,
    ) -> Result<Rc<Made>, Halt> {
        if self.interrupt.asked() {
            return Err(Halt::Asked);
        }
        let (folder, clock) = (self.place(name), Clock::start());
        self.earlier.check(&folder, "-o DIR")?;
        match make(self, &folder)? {
            INTERRUPTED => Err(Halt::Asked),
            NOT_FINITE => Err(Halt::Failed("left the finite numbers".into())),
            FILE => Err(Halt::Broken(Failure::File(format!(
                "the result of {name} could not be written where the next run looks for it; free some space, or choose another folder with -o DIR"
            )))),
            _ => {
                let text = fs::read_to_string(folder.join("report.json")).unwrap_or_default();
                Ok(Rc::new(Made {
                    report: serde_json::from_str(&text).unwrap_or_default(),
                    seconds: clock.total(),
                    folder,
                }))
            }
        }
    }

    /// Removes the arrays of a run that nobody needs any more.
    pub fn forget_arrays(&self, made: &Made) -> Result<(), Failure> {
        remove_written(&made.folder, ARCHIVE)
    }

    /// Removes the arrays of all runs.
    pub fn forget_all_arrays(&self) -> Result<(), Failure> {
        let made = self.done.values().filter_map(|done| done.as_ref().ok());
        made.into_iter().try_for_each(|made| self.forget_arrays(made))
    }
}
