//! What is read here of the parts of a state that ranks wrote.

use super::label::HEAD;
use super::{Broken, CHECK, Refused};
use crate::memory::part::{Parts, Strips};
use crate::memory::{Held, Share};
use crate::real::Real;

/// The parts of a state, or the state of one program.
pub trait SavedParts {
    /// The first of the ranks that wrote them: how many there were, and how they cut the box. One program alone has one.
    fn share(&self) -> Share;
    /// Fills `bytes` with those of the part of `rank` from number `at` on.
    ///
    /// # Errors
    /// [`Refused`], also where there are too few.
    fn take(&mut self, rank: usize, at: u64, bytes: &mut [u8]) -> Result<(), Refused>;
}

/// What stands before a field that all ranks have all of, instead of how it is cut.
pub(super) const WHOLE: [u64; 3] = [0; 3];

/// What is read of parts: where the next field is in the first one, and in all others.
pub(super) struct Gather<'a> {
    saved: &'a mut dyn SavedParts,
    share: Share,
    at: [u64; 2],
    /// Where the next buffer is in the state of one program.
    next: u64,
}

impl<'a> Gather<'a> {
    pub fn new(saved: &'a mut dyn SavedParts) -> Self {
        let share = saved.share();
        Self {
            saved,
            share,
            at: [HEAD as u64, 0],
            next: 0,
        }
    }

    fn is_of_one(&self) -> bool {
        self.share.ranks < 2
    }

    /// Begins a buffer, which one program has all bytes of.
    pub fn begin(&mut self, bytes: usize) {
        let check = if bytes > 0 { CHECK as u64 } else { 0 };
        self.next = self.at[0].saturating_add(bytes as u64).saturating_add(check);
    }

    pub fn end(&mut self) {
        if self.is_of_one() {
            self.at[0] = self.next;
        }
    }

    /// Fills what is `held` here of the next field, through a block.
    pub fn take<T: Real>(
        &mut self,
        block: &mut [u8; HEAD],
        values: &mut [T],
        held: Held,
    ) -> Result<(), Broken> {
        let whole = held.whole(values.len());
        let cut = self.cut(whole)?;
        let (own, of_whole) = match held {
            Held::All => (Strips::all(whole), Strips::all(whole)),
            Held::Part { parts, .. } => (parts.own(values.len()), parts.own_of_whole(values.len())),
        };
        for (here, there) in own.ranges().zip(of_whole.ranges()) {
            let (mut strip, mut index) = (values.get_mut(here).unwrap_or(&mut []), there.start);
            while !strip.is_empty() {
                let (rank, place, follow) = match cut {
                    None => (0, index, strip.len()),
                    Some(parts) => parts.whose(whole, index),
                };
                let count = follow.min(strip.len()).min(HEAD / T::BYTES);
                let (now, later) = strip.split_at_mut_checked(count).ok_or(Broken::Damaged)?;
                if now.is_empty() {
                    return Err(Broken::Damaged);
                }
                let [first, others] = self.at;
                let begin = if rank == 0 { first } else { others };
                let at = begin.saturating_add((place * T::BYTES) as u64);
                let bytes = block.get_mut(..count * T::BYTES).unwrap_or(&mut []);
                self.saved.take(rank, at, bytes)?;
                now.iter_mut()
                    .zip(bytes.chunks_exact(T::BYTES))
                    .for_each(|(value, bytes)| *value = T::read(bytes));
                (strip, index) = (later, index + count);
            }
        }
        let most = cut.map_or(whole, |parts| parts.most(whole));
        let bytes = (most * T::BYTES) as u64;
        self.at[0] = self.at[0].saturating_add(bytes);
        if cut.is_some() {
            self.at[1] = self.at[1].saturating_add(bytes);
        }
        Ok(())
    }

    /// How the next field of so many values was cut; `None` where the first one had all of it.
    fn cut(&mut self, whole: usize) -> Result<Option<Parts>, Broken> {
        if self.is_of_one() {
            return Ok(None);
        }
        let mut words = [0; 3];
        for word in &mut words {
            let mut bytes = [0; 8];
            self.saved.take(0, self.at[0], &mut bytes)?;
            self.at[0] = self.at[0].saturating_add(8);
            *word = u64::from_le_bytes(bytes);
        }
        if words == WHOLE {
            return Ok(None);
        }
        match Parts::of_words(self.share, words) {
            parts if parts.are_of(whole) => Ok(Some(parts)),
            _ => Err(Broken::Damaged),
        }
    }
}
