//! Saving a solver and going on from what was saved.

use super::{SavedError, Solver};
use crate::checkpoint::{Damaged, FORMAT, HEAD, Label, MAGIC, Record};
use crate::grid::Space;
use crate::memory::Layout;
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Bytes that [`Self::save`] writes: [`Plan::saved_bytes`](super::Plan::saved_bytes).
    #[must_use]
    pub fn saved_bytes(&self) -> usize {
        self.saved_bytes
    }

    /// Writes the whole state as plain bytes, densities included, into the first [`Self::saved_bytes`] of `bytes`. Nothing is
    /// changed: the solver is borrowed to write because one list of its state serves for [`Self::restore`] too.
    ///
    /// # Errors
    /// [`SavedError::Length`] when `bytes` are too few.
    pub fn save(&mut self, bytes: &mut [u8]) -> Result<(), SavedError> {
        let (expected, given) = (self.saved_bytes, bytes.len());
        let short = SavedError::Length { expected, given };
        let mut record = Record::write(bytes.get_mut(..expected).ok_or(short)?);
        self.record(&mut record).map_err(|Damaged| short)?;
        debug_assert_eq!(record.bytes(), expected, "planned and saved bytes differ");
        record.seal(self.fingerprint ^ self.solid_print);
        Ok(())
    }

    /// Goes on from what a solver of the same problem, method and choices saved: every later step gives the bits that it would
    /// have given there. Threads, ceiling and iterations may be others. Nothing is changed where the bytes are refused.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SavedError> {
        let (expected, given) = (self.saved_bytes, bytes.len());
        let length = SavedError::Length { expected, given };
        let label = Label::of(bytes).filter(|_| given >= HEAD).ok_or(length)?;
        match label {
            Label { magic, .. } if magic != MAGIC => Err(SavedError::NotSaved),
            Label { format, .. } if format != FORMAT => Err(SavedError::Format { given: format }),
            Label { fingerprint, .. } if fingerprint != self.fingerprint ^ self.solid_print => {
                Err(SavedError::OtherSolve)
            }
            Label { bytes: said, .. } if given != expected || said != expected as u64 => Err(length),
            label if !label.fits(bytes) => Err(SavedError::Damaged),
            _ => {
                self.record(&mut Record::read(bytes))
                    .map_err(|Damaged| SavedError::Damaged)?;
                // The flow that it follows is among the fields.
                self.reference = self.reference.map(|_| true);
                Ok(())
            }
        }
    }

    /// Passes over all state: scalars, which are all checked before anything is changed, then fields.
    fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut mass, mut missing, mut prepared) = (self.mass, self.missing, self.prepared);
        let (mut objective, mut finished) = (self.objective, self.finished);
        record.real(&mut mass)?;
        record.count(&mut missing, self.lists.steps.len())?;
        record.option(&mut prepared, |record, change| record.real(change))?;
        objective.record(record)?;
        record.flag(&mut finished)?;
        let method = self.engine.get_mut();
        let mut largest = method.parts().setup.sweep.largest;
        record.real(&mut largest)?;
        method.scalars(record)?;
        method.parts().setup.sweep.largest = largest;
        (self.mass, self.missing, self.prepared) = (mass, missing, prepared);
        (self.objective, self.finished) = (objective, finished);
        let mut visit = |field: &mut [T]| record.elements(field);
        // What is kept is only shown: nothing can be too small.
        let _ = method.layout(&mut Layout::kept(&mut visit));
        if let Some(release) = &mut self.release {
            let _ = release.layout(&mut Layout::kept(&mut visit));
        }
        record.elements(self.fields);
        Ok(())
    }
}
