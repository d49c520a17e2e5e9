//! Saving a solver and going on from what was saved.

use super::shared::Verb;
use super::{SavedError, Solver};
use crate::checkpoint::{self, Buffers, Damaged, PartStore, Record, Refused, Resumable, Sink, Source};
use crate::exec::Ranks;
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
    /// [`SavedError::Length`] when `bytes` are too few; [`SavedError::Refused`] where ranks share it, for which there is [`Self::save_parts`].
    pub fn save(&mut self, bytes: &mut [u8]) -> Result<(), SavedError> {
        checkpoint::save(self, bytes)
    }

    /// As [`Self::save`], piece by piece to `sink`, through one block of [`HEAD`](checkpoint::HEAD) bytes.
    ///
    /// # Errors
    /// [`SavedError::Refused`] where the sink refuses.
    pub fn save_to(&mut self, sink: &mut dyn Sink) -> Result<(), SavedError> {
        checkpoint::save_to(self, sink)
    }

    /// Goes on from what a solver of the same problem, method and choices saved: every later step gives the bits that it would
    /// have given there. Threads, ceiling and iterations may be others. Nothing is changed where the bytes are refused.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SavedError> {
        checkpoint::restore(self, bytes)
    }

    /// As [`Self::restore`], piece by piece from `source`, through one block of [`HEAD`](checkpoint::HEAD) bytes. A source that is refused
    /// for what its first bytes say has changed nothing; where it ends early, or a later field is damaged, the solver is of no use any more.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore_from(&mut self, source: &mut dyn Source) -> Result<(), SavedError> {
        checkpoint::restore_from(self, source)
    }
}

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Saves the state that ranks share, each its part: the first one calls this, and the others, who [follow](Self::follow), do the same with their `store`.
    ///
    /// # Errors
    /// [`Refused`]: the store says why.
    pub fn save_parts(&mut self, store: &mut dyn PartStore) -> Result<(), Refused> {
        self.shared.ask(Verb::Save, [0; 3]);
        checkpoint::save_parts(self, store)
    }

    /// Goes on from what any number of ranks saved, or one program: the first one calls this, and the others, if there are any, do the same with their
    /// `store`.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore_parts(&mut self, store: &mut dyn PartStore) -> Result<(), SavedError> {
        self.shared.ask(Verb::Restore, [0; 3]);
        checkpoint::restore_parts(self, store)
    }
}

impl<T: Real, S: Space> Resumable for Solver<'_, T, S> {
    fn saved_bytes(&self) -> usize {
        self.saved_bytes
    }

    fn fingerprint(&self) -> u64 {
        self.fingerprint ^ self.solid_print
    }

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

    fn fields(&mut self, record: &mut Record<'_>) {
        let mut buffers = Buffers::new(record, self.shared.ranks);
        // What is kept is only shown: nothing can be too small.
        let _ = self.engine.get_mut().layout(&mut Layout::kept(&mut buffers));
        if let Some(release) = &mut self.release {
            let _ = release.layout(&mut Layout::kept(&mut buffers));
        }
        let grid = *self.grid();
        let (count, cells) = (self.fields.len() / grid.cells().max(1), grid.cells());
        let mut layout = Layout::kept(&mut buffers);
        let _ = layout.keep_fields("given densities", &mut self.fields, (count, cells), grid.parts());
    }

    fn ranks(&self) -> Option<&dyn Ranks> {
        self.shared.ranks
    }

    fn taken(&mut self) {
        // The flow that it follows is among the fields.
        self.reference = self.reference.map(|_| true);
    }

    fn spoil(&mut self) {
        (self.mass, self.missing) = (0.0, self.lists.steps.len());
        (self.prepared, self.finished) = (None, false);
        self.reference = self.reference.map(|_| false);
    }
}
