//! What the equations of a slot read, cell by cell, side by side.
//!
//! They read some fifty rows of eight fields, every other number of each, and of some the numbers between too. Every row is a stream of its
//! own through memory, more of them than processors follow; so all are read, and asked for ahead, in small loops, and what is compiled for
//! the equations finds its numbers in places that are known.

use super::GROUPS;
use super::edge::Edge;
use crate::field::Vector as Field;
use crate::grid::{Grid, Side, Space};
use crate::nso::colours::Cells;
use crate::nso::level::System;
use crate::real::Real;
use crate::simd::{Cache, Vector, prefetch};

/// Slots between the one that is read and the one that is asked for.
const AHEAD: usize = 2;

/// Offsets, in vectors, of what is gathered for a group.
pub(super) struct Gathered<S>(core::marker::PhantomData<S>);
impl<S: Space> Gathered<S> {
    /// Of v and of w: the cell's own faces, then for each edge the outside faces along its axes a and b.
    pub(super) const V: usize = 0;
    pub(super) const W: usize = S::FACES + 2 * S::EDGES;
    /// Of both pressures: at the cell, then beside each face.
    pub(super) const P: usize = 2 * Self::W;
    pub(super) const PBAR: usize = Self::P + 1 + S::FACES;
    /// At the cell's own faces: v in the slot before, w in the slot after, and the right-hand sides of equations a and c.
    pub(super) const BEFORE: usize = Self::PBAR + 1 + S::FACES;
    pub(super) const AFTER: usize = Self::BEFORE + S::FACES;
    pub(super) const TARGET: usize = Self::AFTER + S::FACES;
    pub(super) const SOURCE: usize = Self::TARGET + S::FACES;
    /// The right-hand sides of equations b and d.
    pub(super) const B: usize = Self::SOURCE + S::FACES;
    pub(super) const D: usize = Self::B + 1;
    pub(super) const SIZE: usize = Self::D + 1;
}

/// A row of a field, of which the cells' own numbers are read, every other one; with `READS` = 2 those after them too, with 3 those
/// before them.
struct Row<'s, T, const READS: usize> {
    field: &'s [T],
    /// Where the number of the first cell in slot 0 is.
    start: usize,
    /// Which of the gathered vectors they become.
    places: [usize; READS],
}

/// Where what is read goes: the lane of the first cell, and whether cells stay in order or are as [`Vector::load_pairs`] leaves them.
#[derive(Clone, Copy)]
struct Onto {
    lane: usize,
    in_order: bool,
}

impl Onto {
    /// A row's cells in groups of their own.
    const GROUPS: Self = Self {
        lane: 0,
        in_order: false,
    };

    /// The lane of a cell read by `P`.
    #[inline(always)]
    fn lane<P: Vector>(self, cell: usize) -> usize {
        self.lane
            + if self.in_order {
                cell
            } else {
                P::PAIRED.get(cell).copied().unwrap_or(cell)
            }
    }
}

impl<T: Real, const READS: usize> Row<'_, T, READS> {
    /// Gathers for each of `COUNT` groups, of vectors `V`, as many cells as `P` has lanes, from what is `shift` numbers after slot 0.
    #[inline(always)]
    fn fill<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
        &self,
        shift: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        let (from, both, lead) = (
            self.start.wrapping_add(shift),
            2 * P::LANES,
            usize::from(READS > 2),
        );
        let Some(row) = self
            .field
            .get(from.wrapping_sub(lead)..from.wrapping_add(COUNT * both))
        else {
            return self.fill_by_numbers::<S, V, P>(from, P::LANES, onto, gathered);
        };
        let zero = P::splat(T::ZERO);
        let (mut own, mut after, mut before) = ([zero; COUNT], [zero; COUNT], [zero; COUNT]);
        for group in 0..COUNT {
            [own[group], after[group]] = P::load_pairs(&row[group * both + lead..]);
            if READS > 2 {
                [before[group], _] = P::load_pairs(&row[group * both..]);
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

    /// Stores a vector of each group where it belongs.
    #[inline(always)]
    fn put<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
        &self,
        vectors: &[P; COUNT],
        read: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        let (first, size) = (
            self.places[read] * V::LANES + onto.lane,
            Gathered::<S>::SIZE * V::LANES,
        );
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

    /// As [`Self::fill`] from number `from`, the first `cells` of each group number by number, 0 beyond the ends of the field.
    #[cold]
    #[inline(never)]
    fn fill_by_numbers<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>>(
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
                    let number = from
                        .wrapping_add(offset)
                        .wrapping_add(2 * (group * V::LANES + cell));
                    if let Some(to) = gathered.get_mut(place * V::LANES + onto.lane::<P>(cell)) {
                        *to = self.field.get(number).copied().unwrap_or(T::ZERO);
                    }
                }
            }
        }
    }
}

/// A number that is on the other side of a periodic axis.
struct Wrapped<'s, T> {
    field: &'s [T],
    /// Where it is in slot 0.
    start: usize,
    /// Which of the gathered vectors it belongs to.
    place: usize,
    /// The cell that reads it.
    cell: usize,
}

/// Rows, so many at most by how much of them is read, and what is read across a periodic boundary.
struct Rows<'s, T, const ONE: usize, const TWO: usize, const THREE: usize, const WRAPPED: usize> {
    single: heapless::Vec<Row<'s, T, 1>, ONE>,
    pairs: heapless::Vec<Row<'s, T, 2>, TWO>,
    triples: heapless::Vec<Row<'s, T, 3>, THREE>,
    wrapped: heapless::Vec<Wrapped<'s, T>, WRAPPED>,
}
/// Those of all that the equations of a slot read.
type OfSlot<'s, T> = Rows<'s, T, 34, 12, 10, 32>;
/// Those of the cells' own faces.
type OfFaces<'s, T> = Rows<'s, T, 4, 1, 0, 1>;

/// As [`Row::fill`] for all of them, and asks for what is `ahead` after that, unless that is 0.
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

impl<T: Real, const ONE: usize, const TWO: usize, const THREE: usize, const WRAPPED: usize>
    Rows<'_, T, ONE, TWO, THREE, WRAPPED>
{
    const EMPTY: Self = Self {
        single: heapless::Vec::new(),
        pairs: heapless::Vec::new(),
        triples: heapless::Vec::new(),
        wrapped: heapless::Vec::new(),
    };

    /// As [`fill_all`].
    #[inline(always)]
    fn fill<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
        &self,
        shift: usize,
        ahead: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        self.fill_rows::<S, V, P, COUNT>(shift, ahead, onto, gathered);
        self.fill_wrapped::<S, V>(shift, onto, gathered);
    }

    /// As [`fill_all`], without what is across a boundary.
    #[inline(always)]
    fn fill_rows<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const COUNT: usize>(
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

    #[inline(always)]
    fn fill_wrapped<S: Space, V: Vector<Elem = T>>(&self, shift: usize, onto: Onto, gathered: &mut [T]) {
        for number in &self.wrapped {
            let (group, cell) = (number.cell / V::LANES, number.cell % V::LANES);
            let place = (group * Gathered::<S>::SIZE + number.place) * V::LANES + onto.lane::<V>(cell);
            debug_assert!(place < gathered.len());
            if let (Some(to), Some(&value)) = (
                gathered.get_mut(place),
                number.field.get(number.start.wrapping_add(shift)),
            ) {
                *to = value;
            }
        }
    }

    /// Gathers the first `cells` of each group number by number.
    #[inline(never)]
    fn fill_by_numbers<S: Space, V: Vector<Elem = T>>(
        &self,
        shift: usize,
        cells: usize,
        onto: Onto,
        gathered: &mut [T],
    ) {
        let from = |start: usize| start.wrapping_add(shift);
        self.triples
            .iter()
            .for_each(|row| row.fill_by_numbers::<S, V, V>(from(row.start), cells, onto, gathered));
        self.pairs
            .iter()
            .for_each(|row| row.fill_by_numbers::<S, V, V>(from(row.start), cells, onto, gathered));
        self.single
            .iter()
            .for_each(|row| row.fill_by_numbers::<S, V, V>(from(row.start), cells, onto, gathered));
        self.fill_wrapped::<S, V>(shift, onto, gathered);
    }
}

/// All that some cells of one row read. Behind walls along y and z there is nothing, and what is gathered stays 0.
pub(super) struct Gather<'s, T> {
    now: OfSlot<'s, T>,
    /// v in the slot before, of slots side by side.
    #[cfg(target_arch = "x86_64")]
    before: OfFaces<'s, T>,
    /// w in the slot after.
    after: OfFaces<'s, T>,
    /// The velocity before slot 0.
    given: OfFaces<'s, T>,
    slots: usize,
    nx: usize,
}

impl<'s, T: Real> Gather<'s, T> {
    /// For `cells` of `row`.
    pub(super) fn new<S: Space>(system: &System<'s, T>, row: usize, cells: Cells) -> Self {
        let &System {
            grid,
            first,
            slots,
            v,
            w,
            p,
            pbar,
            v0,
            rhs,
            ..
        } = system;
        let around = Around::new(grid, first, row, cells);
        let mut gather = Self {
            now: Rows::EMPTY,
            #[cfg(target_arch = "x86_64")]
            before: Rows::EMPTY,
            after: Rows::EMPTY,
            given: Rows::EMPTY,
            slots,
            nx: grid.n[0],
        };
        let now = &mut gather.now;
        for axis in 0..S::DIM {
            let around_edges = Reads::own_faces(axis).with_outside_faces::<S>(axis);
            for (field, place) in [(v, Gathered::<S>::V), (w, Gathered::<S>::W)] {
                around.read(now, field[axis], slots, 0, &around_edges, place);
            }
        }
        let beside = Reads::cell_and_beside::<S>();
        around.read(now, p, slots, 0, &beside, Gathered::<S>::P);
        around.read(now, pbar, slots, 0, &beside, Gathered::<S>::PBAR);
        let own = Reads::cell();
        around.read(now, rhs.b, slots, 0, &own, Gathered::<S>::B);
        around.read(now, rhs.d, slots, 0, &own, Gathered::<S>::D);
        around.own_faces(now, rhs.a, slots, 0, Gathered::<S>::TARGET);
        around.own_faces(now, rhs.c, slots, 0, Gathered::<S>::SOURCE);
        around.own_faces(&mut gather.after, w, slots, 1, Gathered::<S>::AFTER);
        around.own_faces(&mut gather.given, v0, 1, 0, Gathered::<S>::BEFORE);
        gather
    }

    /// Gathers slot `k` after slot `k - 1`: group after group, [`Gathered::SIZE`] vectors each.
    #[inline(always)]
    pub(super) fn fill<S: Space, V: Vector<Elem = T>>(&self, k: usize, gathered: &mut [T]) {
        const { assert!(GROUPS == 4, "one to four groups") };
        match gathered.len() / (Gathered::<S>::SIZE * V::LANES) {
            1 => self.fill_groups::<S, V, 1>(k, gathered),
            2 => self.fill_groups::<S, V, 2>(k, gathered),
            3 => self.fill_groups::<S, V, 3>(k, gathered),
            _ => self.fill_groups::<S, V, 4>(k, gathered),
        }
    }

    #[inline(always)]
    fn fill_groups<S: Space, V: Vector<Elem = T>, const COUNT: usize>(&self, k: usize, gathered: &mut [T]) {
        let own_faces = |place: usize| place * V::LANES..(place + S::FACES) * V::LANES;
        if k == 0 {
            self.given
                .fill_by_numbers::<S, V>(0, V::LANES, Onto::GROUPS, gathered);
        } else {
            for group in gathered.chunks_exact_mut(Gathered::<S>::SIZE * V::LANES) {
                group.copy_within(own_faces(Gathered::<S>::V), Gathered::<S>::BEFORE * V::LANES);
            }
        }
        self.now
            .fill::<S, V, V, COUNT>(k * self.nx, AHEAD * self.nx, Onto::GROUPS, gathered);
        if k + 1 < self.slots {
            self.after
                .fill::<S, V, V, COUNT>(k * self.nx, 0, Onto::GROUPS, gathered);
        } else {
            for group in gathered.chunks_exact_mut(Gathered::<S>::SIZE * V::LANES) {
                group[own_faces(Gathered::<S>::AFTER)].fill(T::ZERO);
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl<'s, T: Real> Gather<'s, T> {
    /// Adds what slots side by side read besides.
    pub(super) fn add_before<S: Space>(&mut self, system: &System<'s, T>, row: usize, cells: Cells) {
        Around::new(system.grid, system.first, row, cells).own_faces(
            &mut self.before,
            system.v,
            self.slots,
            0,
            Gathered::<S>::BEFORE,
        );
    }

    /// Gathers the slots from `k` on that lie side by side in the vectors of one group, `each` lanes for each.
    #[inline(always)]
    pub(super) fn fill_slots<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>>(
        &self,
        k: usize,
        each: usize,
        gathered: &mut [T],
    ) {
        let side_by_side = SideBySide {
            each,
            count: (self.slots - k).min(V::LANES / each),
            nx: self.nx,
        };
        let shift = k * self.nx;
        side_by_side.fill::<T, S, V, P, 34, 12, 10, 32>(&self.now, shift, gathered);
        side_by_side.fill::<T, S, V, P, 4, 1, 0, 1>(&self.before, shift.wrapping_sub(self.nx), gathered);
        if k == 0 {
            self.given
                .fill_by_numbers::<S, V>(0, each, side_by_side.onto(0), gathered);
        }
        side_by_side.fill::<T, S, V, P, 4, 1, 0, 1>(&self.after, shift, gathered);
        if k + side_by_side.count == self.slots {
            for face in Gathered::<S>::AFTER..Gathered::<S>::AFTER + S::FACES {
                gathered
                    .iter_mut()
                    .skip(face * V::LANES + (side_by_side.count - 1) * each)
                    .take(each)
                    .for_each(|after| *after = T::ZERO);
            }
        }
    }
}

/// A few slots side by side in a vector, `each` lanes for each.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct SideBySide {
    each: usize,
    count: usize,
    nx: usize,
}

#[cfg(target_arch = "x86_64")]
impl SideBySide {
    fn onto(self, slot: usize) -> Onto {
        Onto {
            lane: slot * self.each,
            in_order: true,
        }
    }

    /// Gathers the first of them from what is `shift` numbers after slot 0: where a row has twice as many cells as a slot has lanes, all of them as
    /// one long row, elsewhere one by one, by vectors of `each` numbers.
    #[inline(always)]
    fn fill<
        T: Real,
        S: Space,
        V: Vector<Elem = T>,
        P: Vector<Elem = T>,
        const ONE: usize,
        const TWO: usize,
        const THREE: usize,
        const WRAPPED: usize,
    >(
        self,
        rows: &Rows<'_, T, ONE, TWO, THREE, WRAPPED>,
        shift: usize,
        gathered: &mut [T],
    ) {
        let at = |slot: usize| shift.wrapping_add(slot * self.nx);
        if self.nx == 2 * self.each {
            rows.fill_rows::<S, V, V, 1>(shift, 0, self.onto(0), gathered);
            (0..self.count).for_each(|slot| rows.fill_wrapped::<S, V>(at(slot), self.onto(slot), gathered));
        } else {
            (0..self.count).for_each(|slot| rows.fill::<S, V, P, 1>(at(slot), 0, self.onto(slot), gathered));
        }
    }
}

/// Which numbers of a field the equations of a cell read, and which of the gathered vectors they become: for each of the rows around
/// the cell (see [`Around`]) the cell's own, the one after it and the one before it. Where one is read, so are those named before it.
struct Reads([[Option<usize>; 3]; 9]);

impl Reads {
    const NOTHING: Self = Self([[None; 3]; 9]);

    /// The number at the cell.
    fn cell() -> Self {
        let mut reads = Self::NOTHING;
        reads.add([0; 3], 0);
        reads
    }

    /// The number at the cell, then those beside its faces.
    fn cell_and_beside<S: Space>() -> Self {
        let mut reads = Self::cell();
        for f in 0..S::FACES {
            let mut beside = [0; 3];
            beside[f / 2] = [-1, 1][f % 2];
            reads.add(beside, 1 + f);
        }
        reads
    }

    /// The faces of the cell along `axis`.
    fn own_faces(axis: usize) -> Self {
        let mut reads = Self::NOTHING;
        for side in 0..2 {
            let mut offset = [0; 3];
            offset[axis] = side;
            reads.add(offset, 2 * axis + side as usize);
        }
        reads
    }

    /// And those outside that meet them at edges.
    fn with_outside_faces<S: Space>(mut self, axis: usize) -> Self {
        for e in 0..S::EDGES {
            let edge = Edge::new::<S>(e);
            if edge.a == axis {
                self.add(edge.outside_a(), S::FACES + 2 * e);
            }
            if edge.b == axis {
                self.add(edge.outside_b(), S::FACES + 2 * e + 1);
            }
        }
        self
    }

    fn add(&mut self, offset: [isize; 3], place: usize) {
        self.0[(offset[1] + 1 + 3 * (offset[2] + 1)) as usize][(offset[0].rem_euclid(3)) as usize] =
            Some(place);
    }
}

/// Where some cells of a row are, and the rows around it, by where they are in a field; `None` behind a wall.
struct Around<'g> {
    grid: &'g Grid,
    cells: Cells,
    rows: [Option<usize>; 9],
}

impl<'g> Around<'g> {
    /// For fields that begin with row `first`.
    fn new(grid: &'g Grid, first: usize, row: usize, cells: Cells) -> Self {
        let step = |row: Option<usize>, axis: usize, offset: usize| match offset {
            0 => grid.neighbour(row?, axis, Side::Low),
            2 => grid.neighbour(row?, axis, Side::High),
            _ => row,
        };
        let rows = core::array::from_fn(|i| {
            let in_y = step(Some(row), 1, i % 3);
            let row = if grid.dims == 3 {
                step(in_y, 2, i / 3)
            } else {
                in_y.filter(|_| i / 3 == 1)
            };
            row?.checked_sub(first)
        });
        Self { grid, cells, rows }
    }

    /// Adds what is read of a field of `slots` slots, `time` slots after the one that is gathered, the vectors beginning at `first`.
    fn read<'s, T: Real, const ONE: usize, const TWO: usize, const THREE: usize, const WRAPPED: usize>(
        &self,
        rows: &mut Rows<'s, T, ONE, TWO, THREE, WRAPPED>,
        field: &'s [T],
        slots: usize,
        time: usize,
        reads: &Reads,
        first: usize,
    ) {
        if field.is_empty() {
            return;
        }
        let (nx, Cells { start: x, count }) = (self.grid.n[0], self.cells);
        for (&row, &places) in self.rows.iter().zip(&reads.0) {
            debug_assert!(places.is_sorted_by_key(|place| place.is_none()));
            let (Some(row), [Some(own), after, before]) =
                (row, places.map(|place| place.map(|place| first + place)))
            else {
                continue;
            };
            let (begin, last) = ((row * slots + time) * nx, x + 2 * (count - 1));
            let start = begin + x;
            let fits = match (after, before) {
                (Some(after), Some(before)) => rows
                    .triples
                    .push(Row {
                        field,
                        start,
                        places: [own, after, before],
                    })
                    .is_ok(),
                (Some(after), None) => rows
                    .pairs
                    .push(Row {
                        field,
                        start,
                        places: [own, after],
                    })
                    .is_ok(),
                _ => rows
                    .single
                    .push(Row {
                        field,
                        start,
                        places: [own],
                    })
                    .is_ok(),
            };
            debug_assert!(fits);
            let across = [
                (before.filter(|_| x == 0), begin + nx - 1, 0),
                (after.filter(|_| last + 1 == nx), begin, count - 1),
            ];
            for (place, start, cell) in across {
                if let Some(place) = place.filter(|_| self.grid.periodic[0]) {
                    let fits = rows
                        .wrapped
                        .push(Wrapped {
                            field,
                            start,
                            place,
                            cell,
                        })
                        .is_ok();
                    debug_assert!(fits);
                }
            }
        }
    }

    /// Adds the cells' own faces, place after place.
    fn own_faces<
        's,
        T: Real,
        const ONE: usize,
        const TWO: usize,
        const THREE: usize,
        const WRAPPED: usize,
    >(
        &self,
        rows: &mut Rows<'s, T, ONE, TWO, THREE, WRAPPED>,
        field: Field<'s, T>,
        slots: usize,
        time: usize,
        first: usize,
    ) {
        for (axis, component) in field.into_iter().enumerate().take(self.grid.dims) {
            self.read(rows, component, slots, time, &Reads::own_faces(axis), first);
        }
    }
}
