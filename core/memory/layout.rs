//! The buffers of a method, said once: one pass counts them, hands them out, or goes over what a checkpoint keeps.

use super::arena::{Arena, Plain, TooSmall};
use super::ledger::{Ledger, Sharing};
use super::part::{Held, Parts};
use core::mem::size_of;

/// Goes over the buffers that a checkpoint keeps.
pub trait Visit<T> {
    /// A buffer begins, of so many elements where one program has all of it.
    fn begin(&mut self, len: usize);
    /// The next field of that buffer. What no field fills of it holds nothing.
    fn field(&mut self, values: &mut [T], held: Held);
    /// There is no other field in it.
    fn end(&mut self);
}

/// A pass over the buffers of a method. Each is named with the place of its slice and its length; the order of the calls is the
/// order in memory.
pub struct Layout<'p, 'm, T> {
    pass: Pass<'p, 'm, T>,
}

enum Pass<'p, 'm, T> {
    /// Buffers are counted, or carved out of a block.
    Carve(&'p mut Arena<'m>),
    /// What is kept is shown.
    Kept(&'p mut dyn Visit<T>),
}

impl<'p, 'm, T: Plain> Layout<'p, 'm, T> {
    /// Gives every buffer its part of `arena`, or counts it where the arena only measures.
    pub fn carve(arena: &'p mut Arena<'m>) -> Self {
        Self {
            pass: Pass::Carve(arena),
        }
    }

    /// Shows `visit` every buffer that a checkpoint keeps.
    pub fn kept(visit: &'p mut dyn Visit<T>) -> Self {
        Self {
            pass: Pass::Kept(visit),
        }
    }

    /// A buffer of `len` elements that a checkpoint keeps.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn keep(&mut self, name: &'static str, place: &mut &'m mut [T], len: usize) -> Result<(), TooSmall> {
        self.keep_fields(name, place, (1, len), None)
    }

    /// A buffer of `count` fields of cells, of `len` elements each, that a checkpoint keeps. Of a field that ranks share this one has `parts`.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn keep_fields(
        &mut self,
        name: &'static str,
        place: &mut &'m mut [T],
        (count, len): (usize, usize),
        parts: Option<Parts>,
    ) -> Result<(), TooSmall> {
        let held = Held::of(parts, 0, None);
        match &mut self.pass {
            Pass::Carve(arena) => {
                *place = arena.take(name, count * len)?;
                arena.keep::<T>(count * held.whole(len));
            }
            Pass::Kept(visit) => {
                visit.begin(count * held.whole(len));
                place
                    .chunks_exact_mut(len.max(1))
                    .for_each(|field| visit.field(field, held));
                visit.end();
            }
        }
        Ok(())
    }

    /// One buffer in the ledger, of which each of `places` gets `len` elements, a multiple of the alignment: a checkpoint keeps them all.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn keep_each<'f>(
        &mut self,
        name: &'static str,
        places: impl ExactSizeIterator<Item = &'f mut &'m mut [T]>,
        len: usize,
    ) -> Result<(), TooSmall>
    where
        'm: 'f,
        T: 'm,
    {
        match &mut self.pass {
            Pass::Carve(arena) => {
                let mut rest = arena.take(name, places.len() * len)?;
                for place in places {
                    arena.keep::<T>(len);
                    let (own, behind) = core::mem::take(&mut rest)
                        .split_at_mut_checked(len)
                        .unwrap_or_default();
                    (*place, rest) = (own, behind);
                }
            }
            Pass::Kept(visit) => places.for_each(|place| show(*visit, place, len, Held::All)),
        }
        Ok(())
    }

    /// A vector field that a checkpoint keeps, `len` elements for each of `dims` axes. Of a field that ranks share this one has `parts`.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn keep_vector(
        &mut self,
        name: &'static str,
        field: &mut [&'m mut [T]; 3],
        (dims, len): (usize, usize),
        parts: Option<Parts>,
    ) -> Result<(), TooSmall> {
        let held = |axis| Held::of(parts, dims, Some(axis));
        match &mut self.pass {
            Pass::Carve(arena) => {
                *field = arena.take_vector(name, dims, len)?;
                (0..dims).for_each(|axis| arena.keep::<T>(held(axis).whole(len)));
            }
            Pass::Kept(visit) => {
                for (axis, component) in field.iter_mut().enumerate().take(dims) {
                    show(*visit, component, held(axis).whole(len), held(axis));
                }
            }
        }
        Ok(())
    }

    /// A buffer that each step writes anew.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn work<P: Plain>(
        &mut self,
        name: &'static str,
        place: &mut &'m mut [P],
        len: usize,
    ) -> Result<(), TooSmall> {
        self.tables(|arena| {
            *place = arena.take(name, len)?;
            Ok(())
        })
    }

    /// As [`Self::work`], a vector field.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn work_vector(
        &mut self,
        name: &'static str,
        field: &mut [&'m mut [T]; 3],
        dims: usize,
        len: usize,
    ) -> Result<(), TooSmall> {
        self.tables(|arena| {
            *field = arena.take_vector(name, dims, len)?;
            Ok(())
        })
    }

    /// Buffers that are filled when they are carved and follow from the problem.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn tables(
        &mut self,
        carve: impl FnOnce(&mut Arena<'m>) -> Result<(), TooSmall>,
    ) -> Result<(), TooSmall> {
        match &mut self.pass {
            Pass::Carve(arena) => carve(arena),
            Pass::Kept(_) => Ok(()),
        }
    }

    /// One buffer for all that happens in turn: as long as the longest of the uses that `uses` writes into a ledger. Of its
    /// elements a checkpoint keeps the first `kept`.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn in_turn(
        &mut self,
        place: &mut &'m mut [T],
        kept: usize,
        uses: impl Fn(&mut Ledger),
    ) -> Result<(), TooSmall> {
        let first = |place: &mut [T], visit: &mut dyn Visit<T>| {
            if let Some(kept) = place.get_mut(..kept) {
                visit.field(kept, Held::All);
            }
        };
        self.in_turn_with(place, (kept, first), uses)
    }

    /// The same, where a checkpoint keeps the fields that are shown: `kept` elements at most where one program has all of them.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn in_turn_with(
        &mut self,
        place: &mut &'m mut [T],
        (kept, show): (usize, impl FnOnce(&mut [T], &mut dyn Visit<T>)),
        uses: impl Fn(&mut Ledger),
    ) -> Result<(), TooSmall> {
        match &mut self.pass {
            Pass::Carve(arena) => {
                arena.keep::<T>(kept);
                match arena.ledger() {
                    Some(ledger) => ledger.group("used in turn", Sharing::InTurn, uses),
                    None => *place = arena.take("used in turn", longest::<T>(&uses))?,
                }
            }
            Pass::Kept(visit) => {
                visit.begin(kept);
                show(place, *visit);
                visit.end();
            }
        }
        Ok(())
    }
}

/// Shows a buffer that is one field.
fn show<T>(visit: &mut dyn Visit<T>, field: &mut [T], len: usize, held: Held) {
    visit.begin(len);
    visit.field(field, held);
    visit.end();
}

/// Elements of the longest of `uses`. A ledger takes much of a stack: in a frame of its own it is gone before anything else runs.
#[inline(never)]
fn longest<T>(uses: &impl Fn(&mut Ledger)) -> usize {
    let mut ledger = Ledger::new();
    ledger.group("used in turn", Sharing::InTurn, uses);
    ledger.elements(size_of::<T>())
}
