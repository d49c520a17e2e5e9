//! Saving a solver and going on from what was saved.

use super::{SavedError, Solver};
use crate::checkpoint::{Broken, Damaged, FORMAT, HEAD, Label, MAGIC, Record, Sink, Source};
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
        let mut bytes = bytes.get_mut(..expected).ok_or(short)?;
        self.save_to(&mut bytes)
    }

    /// As [`Self::save`], piece by piece to `sink`, through one block of [`HEAD`] bytes.
    ///
    /// # Errors
    /// [`SavedError::Refused`] where the sink refuses.
    pub fn save_to(&mut self, sink: &mut dyn Sink) -> Result<(), SavedError> {
        let mut record = Record::write(sink);
        self.scalars(&mut record).map_err(Broken::from)?;
        record.seal(self.saved_bytes, self.fingerprint ^ self.solid_print)?;
        self.kept(&mut record);
        record.ended()?;
        debug_assert_eq!(record.bytes(), self.saved_bytes, "planned and saved bytes differ");
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
        let (head, fields) = bytes.split_first_chunk::<HEAD>().ok_or(length)?;
        self.accept(head, given)?;
        let (mut source, mut again) = (fields, fields);
        let mut record = Record::check(*head, &mut source);
        self.kept(&mut record);
        record.ended()?;
        self.take(*head, &mut again)
    }

    /// As [`Self::restore`], piece by piece from `source`, through one block of [`HEAD`] bytes. A source that is refused for what its
    /// first bytes say has changed nothing; where it ends early, or a later field is damaged, the solver is of no use any more.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore_from(&mut self, source: &mut dyn Source) -> Result<(), SavedError> {
        let mut head = [0; HEAD];
        source.take(&mut head).map_err(Broken::from)?;
        self.accept(&head, self.saved_bytes)?;
        self.take(head, source)
    }

    /// Whether bytes with this head, of which so many are given, are a state of this solver.
    fn accept(&self, head: &[u8; HEAD], given: usize) -> Result<(), SavedError> {
        let expected = self.saved_bytes;
        let length = SavedError::Length { expected, given };
        match Label::of(head).ok_or(length)? {
            Label { magic, .. } if magic != MAGIC => Err(SavedError::NotSaved),
            Label { format, .. } if format != FORMAT => Err(SavedError::Format { given: format }),
            Label { fingerprint, .. } if fingerprint != self.fingerprint ^ self.solid_print => {
                Err(SavedError::OtherSolve)
            }
            Label { bytes: said, .. } if given != expected || said != expected as u64 => Err(length),
            label if !label.fits(head) => Err(SavedError::Damaged),
            _ => Ok(()),
        }
    }

    /// Takes a state whose head was accepted.
    fn take(&mut self, head: [u8; HEAD], source: &mut dyn Source) -> Result<(), SavedError> {
        let mut record = Record::read(head, source);
        self.scalars(&mut record).map_err(Broken::from)?;
        self.kept(&mut record);
        if let Err(broken) = record.ended() {
            // Half of it is another state: nothing can be done with it but to set it up anew.
            (self.mass, self.missing) = (0.0, self.lists.steps.len());
            (self.prepared, self.finished) = (None, false);
            return Err(broken.into());
        }
        // The flow that it follows is among the fields.
        self.reference = self.reference.map(|_| true);
        Ok(())
    }

    /// Passes over all scalars, which are all checked before anything is changed.
    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
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
        Ok(())
    }

    /// Passes over all fields.
    fn kept(&mut self, record: &mut Record<'_>) {
        let mut visit = |field: &mut [T]| record.elements(field);
        // What is kept is only shown: nothing can be too small.
        let _ = self.engine.get_mut().layout(&mut Layout::kept(&mut visit));
        if let Some(release) = &mut self.release {
            let _ = release.layout(&mut Layout::kept(&mut visit));
        }
        record.elements(self.fields);
    }
}
