//! Parts of one buffer, handed out front to back: what the phases of a solve use in turn.

use super::ledger::{Ledger, Sharing};
use core::mem::size_of;

/// Hands out parts of one slice, or only counts them in a ledger: whoever takes its workspace from a pool says in one place what
/// it takes, how it is used, and what the plan of it reads.
#[derive(Debug)]
pub struct Pool<'a, T> {
    rest: &'a mut [T],
    /// Where parts are counted, in a pool that measures.
    ledger: Option<&'a mut Ledger>,
}

/// Elements that `len` of them take in a [`Pool`]: whole cache lines of the narrower precision.
#[must_use]
pub const fn pooled(len: usize) -> usize {
    len.next_multiple_of(16)
}

/// Elements that `take` takes of a pool. A ledger takes much of a stack: in a frame of its own it is gone before anything else runs.
#[inline(never)]
pub fn measured<T>(take: impl FnOnce(Pool<'_, T>)) -> usize {
    let mut ledger = Ledger::new();
    take(Pool::measuring(&mut ledger));
    ledger.elements(size_of::<T>())
}

impl<'a, T> Pool<'a, T> {
    /// A pool over `elements`.
    pub fn new(elements: &'a mut [T]) -> Self {
        Self {
            rest: elements,
            ledger: None,
        }
    }

    /// A pool that hands out empty slices and writes into `ledger` what it was asked for.
    pub fn measuring(ledger: &'a mut Ledger) -> Self {
        Self {
            rest: &mut [],
            ledger: Some(ledger),
        }
    }

    /// The next `len` elements, with whatever they hold; `name` is their line in the ledger.
    pub fn take(&mut self, name: &'static str, len: usize) -> &'a mut [T] {
        if let Some(ledger) = &mut self.ledger {
            ledger.line(name, pooled(len), size_of::<T>());
            return &mut [];
        }
        let (taken, rest) = core::mem::take(&mut self.rest).split_at_mut(pooled(len));
        self.rest = rest;
        &mut taken[..len]
    }

    /// Neighbours of `lengths` elements in one buffer, of which the first begins `skip` elements after its start.
    pub fn take_split<const N: usize>(
        &mut self,
        name: &'static str,
        skip: usize,
        lengths: [usize; N],
    ) -> [&'a mut [T]; N] {
        let mut rest = self.take(name, skip + lengths.iter().sum::<usize>());
        if self.ledger.is_some() {
            return core::array::from_fn(|_| Default::default());
        }
        rest = &mut rest[skip..];
        lengths.map(|len| {
            let (part, after) = core::mem::take(&mut rest).split_at_mut(len);
            rest = after;
            part
        })
    }

    /// As many elements as the longest of some uses needs, which come one after the other.
    pub fn take_longest(&mut self, name: &'static str, uses: &[(&'static str, usize)]) -> &'a mut [T] {
        if let Some(ledger) = &mut self.ledger {
            ledger.group(name, Sharing::InTurn, |ledger| {
                for &(name, len) in uses {
                    ledger.line(name, pooled(len), size_of::<T>());
                }
            });
            return &mut [];
        }
        self.take(name, uses.iter().map(|&(_, len)| len).max().unwrap_or(0))
    }

    /// What is left.
    #[must_use]
    pub fn into_rest(self) -> &'a mut [T] {
        self.rest
    }

    /// One part for each axis of a vector field, empty for the third one in 2D.
    pub fn take_vector(&mut self, name: &'static str, dims: usize, len: usize) -> [&'a mut [T]; 3] {
        self.line(name, |pool| {
            core::array::from_fn(|axis| {
                if axis < dims {
                    pool.take(name, len)
                } else {
                    Default::default()
                }
            })
        })
    }

    /// What `take` takes, as a group of lines in the ledger.
    pub fn group<R>(&mut self, name: &'static str, sharing: Sharing, take: impl FnOnce(&mut Self) -> R) -> R {
        if let Some(ledger) = &mut self.ledger {
            ledger.open(name, sharing);
        }
        let taken = take(self);
        if let Some(ledger) = &mut self.ledger {
            ledger.close();
        }
        taken
    }

    /// What `take` takes, as one line of the ledger.
    pub fn line<R>(&mut self, name: &'static str, take: impl FnOnce(&mut Self) -> R) -> R {
        self.group(name, Sharing::Buffer, take)
    }
}
