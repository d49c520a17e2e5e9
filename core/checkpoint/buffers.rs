//! The buffers of a state, of which ranks have parts.

use super::Record;
use crate::exec::Ranks;
use crate::exec::ranks::{refresh, swap, tell};
use crate::memory::part::Part;
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
                Held::Planes(part) | Held::Between(part) => record.pass_over::<T>(part.whole(values.len())),
            };
        };
        match held {
            Held::All => {
                record.elements(values);
                if record.is_read() {
                    tell(among.ranks, 0, values);
                }
            }
            Held::Planes(part) | Held::Between(part) => {
                among.pass(record, part, values);
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
    fn pass(&mut self, record: &mut Record<'_>, part: Part, values: &mut [T]) {
        let plane = values.len() / part.held().max(1);
        let (own, rank) = (part.own(), self.ranks.rank());
        let own = values
            .get_mut(own.start * plane..own.end * plane)
            .unwrap_or(&mut []);
        if rank > 0 {
            return own
                .chunks_mut(self.piece.len().max(1))
                .for_each(|piece| self.follow(record, piece));
        }
        record.elements(own);
        for other in 1..part.share.ranks {
            let mut left = part.of(other).len() * plane;
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
        }
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
