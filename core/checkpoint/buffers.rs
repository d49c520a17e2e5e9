//! The buffers of a state, of which ranks have parts.

use super::record::Record;
use crate::exec::Ranks;
use crate::exec::ranks::refresh;
use crate::memory::{Held, Visit};
use crate::real::Real;

/// Passes a record over buffers.
pub struct Buffers<'r, 'a> {
    record: &'r mut Record<'a>,
    ranks: Option<&'r dyn Ranks>,
    /// Elements of the current buffer.
    len: usize,
}

impl<'r, 'a> Buffers<'r, 'a> {
    /// Those of one program, or of one of `ranks`, all of which pass over the same ones.
    pub fn new(record: &'r mut Record<'a>, ranks: Option<&'r dyn Ranks>) -> Self {
        Self {
            record,
            ranks,
            len: 0,
        }
    }
}

impl<T: Real> Visit<T> for Buffers<'_, '_> {
    fn begin(&mut self, len: usize) {
        self.len = len;
        self.record.begin::<T>(len);
    }

    fn field(&mut self, values: &mut [T], held: Held) {
        self.record.field(values, held);
        if let Some(ranks) = self.ranks
            && self.record.is_gathered()
        {
            refresh(ranks, held, values);
        }
    }

    fn end(&mut self) {
        self.record.end(self.len);
    }
}
