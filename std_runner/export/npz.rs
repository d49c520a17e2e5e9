//! An archive of NumPy's arrays: those of the result, of the steps that are exported.

use super::arrays::{Held, arrays, number_bytes};
use super::sink::{SMOKE, Sink};
use super::source::{Frame, Source};
use crate::exit::Failure;
use crate::output::{OutputError, write_npz};
use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// One file, written in the end.
pub(super) struct Archive {
    arrays: Vec<Held>,
}

impl Archive {
    /// That of `source`.
    pub fn of(source: &Source) -> Result<Self, Failure> {
        let arrays = arrays(source)?;
        Ok(Self { arrays })
    }
}

impl Sink for Archive {
    fn parts(&self) -> Vec<PathBuf> {
        vec![format!("{SMOKE}.npz").into()]
    }

    fn step(&mut self, _: &Path, _: &mut Source, _: &Frame) -> Result<(), OutputError> {
        Ok(())
    }

    fn later(&self, steps: &RangeInclusive<usize>) -> u64 {
        let bytes = |held: &Held| {
            let numbers: usize = held.whole(held.entries(steps).len()).iter().product();
            numbers as u64 * number_bytes(&held.kind) as u64
        };
        self.arrays.iter().map(bytes).sum()
    }

    fn finish(
        &mut self,
        folder: &Path,
        source: &mut Source,
        steps: RangeInclusive<usize>,
    ) -> Result<(), OutputError> {
        let all = self.arrays.iter_mut();
        let all = all.filter(|held| !held.entries(&steps).is_empty());
        let path = folder.join(format!("{SMOKE}.npz"));
        write_npz(&path, |npz| {
            for held in all {
                let entries = held.entries(&steps);
                let order = if held.kind.ends_with('1') { '|' } else { '<' };
                let shape = held.whole(entries.len());
                npz.begin(&held.name, &format!("{order}{}", held.kind), &shape)?;
                for entry in entries {
                    let bytes = held.bytes(source, entry).map_err(OutputError::Source)?;
                    npz.put(|file| file.write_all(&bytes))?;
                }
            }
            Ok(())
        })
    }
}
