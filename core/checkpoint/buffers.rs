//! The buffers of a state, of which ranks have parts.

use super::Record;
use crate::exec::Ranks;
use crate::exec::ranks::{refresh, swap, tell};
use crate::memory::part::Parts;
use crate::memory::{Held, Visit};
use crate::real::Real;

/// The ranks that share a state.
pub struct Among<'a, T> {
    /// The ranks.
    pub ranks: &'a dyn Ranks,
    /// Where the first one has another one's elements, which pass in pieces of this length: all ranks have as much room.
    pub piece: &'a mut [T],
}

/// Passes a record over buffers.
pub struct Buffers<'r, 'a, T> {
    record: &'r mut Record<'a>,
    among: Option<Among<'r, T>>,
    /// Elements of the current buffer.
    len: usize,
}

impl<'r, 'a, T: Real> Buffers<'r, 'a, T> {
    /// Those of one program, or of one rank `among` others, all of which pass over the same ones.
    pub fn new(record: &'r mut Record<'a>, among: Option<Among<'r, T>>) -> Self {
        Self {
            record,
            among,
            len: 0,
        }
    }

    /// Ends the pass, in all ranks as in the first.
    pub fn end(self) {
        if let Some(Among { ranks, .. }) = self.among {
            self.record.agree(ranks);
        }
    }
}

impl<T: Real> Visit<T> for Buffers<'_, '_, T> {
    fn begin(&mut self, len: usize) {
        self.len = len;
        self.record.begin::<T>(len);
    }

    fn field(&mut self, values: &mut [T], held: Held) {
        let record = &mut *self.record;
        let Some(among) = &mut self.among else {
            return match held {
                Held::All => record.elements(values),
                // What is only checked is read to its end.
                Held::Part { parts, .. } => record.pass_over::<T>(parts.whole(values.len())),
            };
        };
        match held {
            Held::All => {
                record.elements(values);
                if record.is_read() {
                    tell(among.ranks, 0, values);
                }
            }
            Held::Part { parts, .. } => {
                among.pass(record, parts, values);
                if record.is_read() {
                    refresh(among.ranks, held, values);
                }
            }
        }
    }

    fn end(&mut self) {
        self.record.end(self.len);
    }
}

impl<T: Real> Among<'_, T> {
    /// Passes over a field, part after part.
    fn pass(&mut self, record: &mut Record<'_>, parts: Parts, values: &mut [T]) {
        let (held, rank) = (values.len(), self.ranks.rank());
        let mut own = parts.own(held).ranges();
        if rank > 0 {
            return own.for_each(|strip| {
                let strip = values.get_mut(strip).unwrap_or(&mut []);
                let pieces = strip.chunks_mut(self.piece.len().max(1));
                pieces.for_each(|piece| self.follow(record, piece));
            });
        }
        parts.in_order(held, |other, count| {
            if other == 0 {
                let strip = own.next().unwrap_or(0..0);
                record.elements(values.get_mut(strip).unwrap_or(&mut []));
                return;
            }
            let mut left = count;
            while left > 0 {
                let len = left.min(self.piece.len());
                let piece = self.piece.get_mut(..len).unwrap_or(&mut []);
                if record.is_read() {
                    record.elements(piece);
                    swap(self.ranks, Some(other), piece, None, &mut []);
                } else {
                    // It is asked for each, so that no more than that waits here.
                    swap(self.ranks, Some(other), &[0u8], None, &mut []);
                    swap(self.ranks, None, &[], Some(other), piece);
                    record.elements(piece);
                }
                left -= len.max(1);
            }
        });
    }

    /// Passes a piece to the first rank, or from it.
    fn follow(&self, record: &Record<'_>, piece: &mut [T]) {
        if record.is_read() {
            swap(self.ranks, None, &[], Some(0), piece);
        } else {
            swap(self.ranks, None, &[], Some(0), &mut [0u8]);
            swap(self.ranks, Some(0), piece, None, &mut []);
        }
    }
}
