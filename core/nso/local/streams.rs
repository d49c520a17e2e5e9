//! Rows of fields as streams: every other value of a row, in all slots, into the lanes of vectors.
//!
//! The equations read some fifty rows of eight fields, and of each row every other value, of some the values
//! between too. Every row is a stream of its own through memory, and there are more of them than a processor
//! follows. So all are read, and prefetched, in small loops, and the equations, compiled apart from that,
//! find their values at fixed places.

use super::lanes::{Onto, SideBySide};
use super::storage::Gathered;
use crate::grid::Space;
use crate::real::Real;
use crate::simd::{Cache, Vector, prefetch};

/// A row of a field, of which every other value is read, those of the cells; with `READS` = 2 the values
/// after them too, with 3 also those before them.
struct Row<'s, T, const READS: usize> {
    field: &'s [T],
    /// The place of the first cell's value in slot 0.
    start: usize,
    /// Which of the gathered vectors the values become.
    places: [usize; READS],
}

impl<T: Real, const READS: usize> Row<'_, T, READS> {
    /// Gathers the cells of `COUNT` groups of vectors `V`, in each as many as `P` has lanes, from `shift`
    /// values after slot 0 on.
    #[inline(always)]
    fn fill<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
        &self,
        shift: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        let from = self.start.wrapping_add(shift);
        let pairs = 2 * P::LANES;
        let lead = usize::from(READS > 2);
        let span = from.wrapping_sub(lead)..from.wrapping_add(COUNT * pairs);
        let Some(row) = self.field.get(span) else {
            return self.fill_one_by_one::<S, V, P>(from, P::LANES, onto, gathered);
        };
        let zero = P::splat(T::ZERO);
        let [mut own, mut after, mut before] = [[zero; COUNT]; 3];
        for group in 0..COUNT {
            [own[group], after[group]] = P::load_pairs(&row[group * pairs + lead..]);
            if READS > 2 {
                [before[group], _] = P::load_pairs(&row[group * pairs..]);
            }
        }
        self.put::<S, V, P, COUNT>(&own, 0, onto, gathered);
        if READS > 1 {
            self.put::<S, V, P, COUNT>(&after, 1, onto, gathered);
        }
        if READS > 2 {
            self.put::<S, V, P, COUNT>(&before, 2, onto, gathered);
        }
    }

    /// Stores what is `read`-th of a cell, a vector for each group.
    #[inline(always)]
    fn put<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
        &self,
        vectors: &[P; COUNT],
        read: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        let first = self.places[read] * V::LANES + onto.lane;
        let size = Gathered::<S>::SIZE * V::LANES;
        let to = gathered.get_mut(first..first.wrapping_add((COUNT - 1) * size + P::LANES));
        debug_assert!(to.is_some());
        let Some(to) = to else { return };
        for group in 0..COUNT {
            let vector = if onto.in_order {
                vectors[group].unpaired()
            } else {
                vectors[group]
            };
            vector.store(&mut to[group * size..]);
        }
    }

    /// As [`Self::fill`] from place `from` on, value by value, the first `cells` of each group; 0 stands
    /// beyond the ends of the field.
    #[cold]
    #[inline(never)]
    fn fill_one_by_one<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>>(
        &self,
        from: usize,
        cells: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        for (group, gathered) in gathered
            .chunks_exact_mut(Gathered::<S>::SIZE * V::LANES)
            .enumerate()
        {
            for (place, offset) in self.places.into_iter().zip([0, 1, usize::MAX]) {
                for cell in 0..cells {
                    let index = from
                        .wrapping_add(offset)
                        .wrapping_add(2 * (group * V::LANES + cell));
                    if let Some(to) = gathered.get_mut(place * V::LANES + onto.lane::<P>(cell)) {
                        *to = self.field.get(index).copied().unwrap_or(T::ZERO);
                    }
                }
            }
        }
    }
}

/// A value on the other side of a periodic axis.
struct Wrapped<'s, T> {
    field: &'s [T],
    /// Its place in slot 0.
    start: usize,
    /// Which of the gathered vectors it belongs to.
    place: usize,
    /// The cell that reads it.
    cell: usize,
}

/// Rows of fields by how many values of each cell are read, and values across a periodic boundary: the
/// parameters are the most of each.
pub(super) struct Rows<'s, T, const ONE: usize, const TWO: usize, const THREE: usize, const WRAPPED: usize> {
    single: heapless::Vec<Row<'s, T, 1>, ONE>,
    pairs: heapless::Vec<Row<'s, T, 2>, TWO>,
    triples: heapless::Vec<Row<'s, T, 3>, THREE>,
    wrapped: heapless::Vec<Wrapped<'s, T>, WRAPPED>,
}
/// All that the equations of a slot read.
pub(super) type OfSlot<'s, T> = Rows<'s, T, 34, 12, 10, 32>;
/// The cells' own faces.
pub(super) type OfFaces<'s, T> = Rows<'s, T, 4, 1, 0, 1>;

/// As [`Row::fill`] for all `rows`; prefetches what is `ahead` values further on, unless that is 0.
#[inline(always)]
fn fill_all<
    T: Real,
    S: Space,
    V: Vector<Elem = T>,
    P: Vector<Elem = T>,
    const COUNT: usize,
    const READS: usize,
>(
    rows: &[Row<'_, T, READS>],
    shift: usize,
    ahead: usize,
    onto: Onto,
    gathered: &mut [T],
) {
    for row in rows {
        if ahead > 0 {
            prefetch(
                Cache::Second,
                row.field,
                row.start.wrapping_add(shift + ahead),
                2 * P::LANES * COUNT,
            );
        }
        row.fill::<S, V, P, COUNT>(shift, onto, gathered);
    }
}

impl<'s, T, const ONE: usize, const TWO: usize, const THREE: usize, const WRAPPED: usize>
    Rows<'s, T, ONE, TWO, THREE, WRAPPED>
{
    /// Adds a row of `field` from `start` on, of which the vector `own` is read, and those after and before
    /// it; where there is one before, there is one after.
    pub(super) fn push(
        &mut self,
        field: &'s [T],
        start: usize,
        own: usize,
        [after, before]: [Option<usize>; 2],
    ) {
        let fits = if let (Some(after), Some(before)) = (after, before) {
            let places = [own, after, before];
            self.triples.push(Row { field, start, places }).is_ok()
        } else if let Some(after) = after {
            let places = [own, after];
            self.pairs.push(Row { field, start, places }).is_ok()
        } else {
            let places = [own];
            self.single.push(Row { field, start, places }).is_ok()
        };
        debug_assert!(fits);
    }

    /// Adds the value at `start` of `field`, read by a cell across a periodic boundary.
    pub(super) fn push_wrapped(&mut self, field: &'s [T], start: usize, place: usize, cell: usize) {
        let wrapped = Wrapped {
            field,
            start,
            place,
            cell,
        };
        let fits = self.wrapped.push(wrapped).is_ok();
        debug_assert!(fits);
    }
}

impl<T: Real, const ONE: usize, const TWO: usize, const THREE: usize, const WRAPPED: usize>
    Rows<'_, T, ONE, TWO, THREE, WRAPPED>
{
    pub(super) const EMPTY: Self = Self {
        single: heapless::Vec::new(),
        pairs: heapless::Vec::new(),
        triples: heapless::Vec::new(),
        wrapped: heapless::Vec::new(),
    };

    /// As [`fill_all`], for all of them.
    #[inline(always)]
    pub(super) fn fill<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
        &self,
        shift: usize,
        ahead: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        self.fill_rows::<S, V, P, COUNT>(shift, ahead, onto, gathered);
        self.fill_wrapped::<S, V>(shift, onto, gathered);
    }

    /// As [`fill_all`], without values across a boundary.
    #[inline(always)]
    pub(super) fn fill_rows<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
        &self,
        shift: usize,
        ahead: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        fill_all::<T, S, V, P, COUNT, 3>(&self.triples, shift, ahead, onto, gathered);
        fill_all::<T, S, V, P, COUNT, 2>(&self.pairs, shift, ahead, onto, gathered);
        fill_all::<T, S, V, P, COUNT, 1>(&self.single, shift, ahead, onto, gathered);
    }

    /// Gathers the values across a boundary.
    #[inline(always)]
    pub(super) fn fill_wrapped<S: Space, V: Vector<Elem = T>>(
        &self,
        shift: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        for wrapped in &self.wrapped {
            let (group, cell) = (wrapped.cell / V::LANES, wrapped.cell % V::LANES);
            let place = (group * Gathered::<S>::SIZE + wrapped.place) * V::LANES + onto.lane::<V>(cell);
            debug_assert!(place < gathered.len());
            if let (Some(to), Some(&value)) = (
                gathered.get_mut(place),
                wrapped.field.get(wrapped.start.wrapping_add(shift)),
            ) {
                *to = value;
            }
        }
    }

    /// Gathers the first `cells` of each group value by value.
    #[inline(never)]
    pub(super) fn fill_one_by_one<S: Space, V: Vector<Elem = T>>(
        &self,
        shift: usize,
        cells: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        let from = |start: usize| start.wrapping_add(shift);
        self.triples
            .iter()
            .for_each(|row| row.fill_one_by_one::<S, V, V>(from(row.start), cells, onto, gathered));
        self.pairs
            .iter()
            .for_each(|row| row.fill_one_by_one::<S, V, V>(from(row.start), cells, onto, gathered));
        self.single
            .iter()
            .for_each(|row| row.fill_one_by_one::<S, V, V>(from(row.start), cells, onto, gathered));
        self.fill_wrapped::<S, V>(shift, onto, gathered);
    }

    /// Gathers slots side by side from `shift` values after slot 0 on: as one long row where a row has twice
    /// as many cells as a slot has lanes, elsewhere slot by slot, by vectors `P` of as many lanes as a slot.
    #[inline(always)]
    pub(super) fn fill_slots<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>>(
        &self,
        slots: SideBySide,
        shift: usize,
        gathered: &mut [T],
    ) {
        let at = |slot: usize| shift.wrapping_add(slot * slots.nx);
        if slots.nx == 2 * slots.each {
            self.fill_rows::<S, V, V, 1>(shift, 0, slots.onto(0), gathered);
            (0..slots.count).for_each(|slot| self.fill_wrapped::<S, V>(at(slot), slots.onto(slot), gathered));
        } else {
            (0..slots.count)
                .for_each(|slot| self.fill::<S, V, P, 1>(at(slot), 0, slots.onto(slot), gathered));
        }
    }
}
