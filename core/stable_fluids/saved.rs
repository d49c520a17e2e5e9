//! Saving a search and going on from what was saved.

use super::Fluids;
use crate::checkpoint::{self, Buffers, Damaged, MANY, Record, Resumable, SavedError, Sink, Source};
use crate::grid::Space;
use crate::memory::Layout;
use crate::optimise::descent::Descent;
use crate::optimise::quasi_newton::history::History;
use crate::progress::Objective;
use crate::real::Real;

impl<T: Real, S: Space> Fluids<'_, T, S> {
    /// Bytes that [`Self::save`] writes: [`FluidsPlan::saved_bytes`](super::FluidsPlan::saved_bytes).
    #[must_use]
    pub fn saved_bytes(&self) -> usize {
        self.saved_bytes
    }

    /// Writes the whole state of the search as plain bytes, densities included, into the first [`Self::saved_bytes`] of `bytes`. Nothing is
    /// changed: it is borrowed to write because one list of its state serves for [`Self::restore`] too.
    ///
    /// # Errors
    /// [`SavedError::Length`] when `bytes` are too few.
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

    /// Goes on from what a search of the same problem and choices saved: every later step gives the bits that it would have given there.
    /// Threads, what is kept for the way back, and iterations may be others. Nothing is changed where the bytes are refused.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SavedError> {
        checkpoint::restore(self, bytes)
    }

    /// As [`Self::restore`], piece by piece from `source`, through one block of [`HEAD`](checkpoint::HEAD) bytes. A source that is refused for
    /// what its first bytes say has changed nothing; where it ends early, or a later field is damaged, there are neither source nor keyframes until they are set, and it begins at rest.
    ///
    /// # Errors
    /// [`SavedError`].
    pub fn restore_from(&mut self, source: &mut dyn Source) -> Result<(), SavedError> {
        checkpoint::restore_from(self, source)
    }
}

impl<T: Real, S: Space> Resumable for Fluids<'_, T, S> {
    fn saved_bytes(&self) -> usize {
        self.saved_bytes
    }

    fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut mass, mut begun, mut iteration) = (self.mass, self.begun, self.iteration);
        let (mut objective, mut scale, mut descent) = (self.objective, self.scale, self.descent.clone());
        record.real(&mut mass)?;
        record.flag(&mut begun)?;
        record.count(&mut iteration, MANY)?;
        objective.record(record)?;
        record.real(&mut scale)?;
        descent.record(record)?;
        (self.mass, self.begun, self.iteration) = (mass, begun, iteration);
        (self.objective, self.scale, self.descent) = (objective, scale, descent);
        Ok(())
    }

    fn fields(&mut self, record: &mut Record<'_>) {
        // What is kept is only shown: nothing can be too small.
        let _ = self.layout(&mut Layout::kept(&mut Buffers::new(record, None)));
    }

    fn taken(&mut self) {
        // What is kept for the way back is that of other unknowns.
        self.taped = false;
    }

    fn spoil(&mut self) {
        (self.mass, self.begun) = (0.0, false);
        self.set_at_rest();
        (self.iteration, self.objective) = (0, Objective::default());
        // A keyframe that is 0 is none.
        self.keyframes.fill(T::ZERO);
        self.descent = Descent::new(History::full(self.params.history));
    }
}
