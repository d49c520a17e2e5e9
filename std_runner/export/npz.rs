//! An archive of NumPy's arrays: those of the result, of the steps that are exported.

use super::arrays::arrays;
use super::sink::{SMOKE, Sink};
use super::source::{Frame, Source};
use crate::output::{OutputError, Streamed, write_streamed};
use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// One file, written in the end.
pub(super) struct Archive;

impl Sink for Archive {
    fn parts(&self) -> Vec<PathBuf> {
        vec![format!("{SMOKE}.npz").into()]
    }

    fn step(&mut self, _: &Path, _: &mut Source, _: &Frame) -> Result<(), OutputError> {
        Ok(())
    }

    fn finish(
        &mut self,
        folder: &Path,
        source: &mut Source,
        steps: RangeInclusive<usize>,
    ) -> Result<(), OutputError> {
        let mut all = arrays(source).map_err(OutputError::Source)?;
        all.retain(|held| !held.entries(&steps).is_empty());
        let streamed = all.iter().map(|held| {
            let order = if held.kind.ends_with('1') { '|' } else { '<' };
            Streamed {
                name: held.name.clone(),
                kind: format!("{order}{}", held.kind),
                count: held.entries(&steps).len(),
                shape: held.shape().to_vec(),
            }
        });
        let streamed: Vec<Streamed> = streamed.collect();
        let path = folder.join(format!("{SMOKE}.npz"));
        write_streamed(&path, &streamed, &mut |array, entry| {
            let Some(held) = all.get_mut(array) else {
                return Ok(Vec::new());
            };
            let entry = held.entries(&steps).start + entry;
            held.bytes(source, entry).map_err(OutputError::Source)
        })
    }
}
