//! What the equations of a slot read, cell by cell, side by side.
//!
//! They read some sixty rows of eight fields, every other number of each. Every row is a stream of its own through memory, more of them
//! than processors follow; so all are read, and asked for ahead, in one small loop, and what is compiled for the equations finds its
//! numbers in places that are known.

use super::GROUPS;
use super::edge::Edge;
use crate::field::Vector as Field;
use crate::grid::{D3, Grid, Side, Space};
use crate::nso::colours::Cells;
use crate::nso::level::System;
use crate::real::Real;
use crate::simd::{Cache, Vector, prefetch};

/// Slots between the one that is read and the one that is asked for.
const AHEAD: usize = 2;
/// Streams at most.
const MOST: usize = Gathered::<D3>::SIZE;
/// Those of them that may begin or end across a periodic boundary.
const MOST_WRAPPED: usize = 32;
/// Streams of the given velocity at most.
const FACES: usize = D3::FACES;

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

/// Every other number of a row of a field.
struct Stream<'s, T> {
    field: &'s [T],
    /// Where the number of the first cell in slot 0 is; before the field where that is left of it.
    start: usize,
    /// Which of the gathered vectors it becomes.
    place: usize,
}

impl<T: Real> Stream<'_, T> {
    /// Gathers for each of `COUNT` groups what is `shift` numbers after slot 0.
    #[inline(always)]
    fn fill<S: Space, V: Vector<Elem = T>, const COUNT: usize>(&self, shift: usize, gathered: &mut [T]) {
        let (from, both) = (self.start.wrapping_add(shift), 2 * V::LANES);
        let row = self.field.get(from..from.wrapping_add(COUNT * both));
        for group in 0..COUNT {
            let place = (group * Gathered::<S>::SIZE + self.place) * V::LANES;
            debug_assert!(place + V::LANES <= gathered.len());
            let Some(to) = gathered.get_mut(place..place + V::LANES) else { return };
            match row {
                Some(row) => V::load_even(&row[group * both..]).store(to),
                None => at_the_end(self.field, from.wrapping_add(group * both), to),
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

/// Streams, and what they read across a periodic boundary.
struct Streams<'s, T, const MOST: usize, const WRAPPED: usize> {
    list: heapless::Vec<Stream<'s, T>, MOST>,
    /// The first so many ask for their rows ahead, for all that read the same.
    leading: usize,
    wrapped: heapless::Vec<Wrapped<'s, T>, WRAPPED>,
}

impl<'s, T: Real, const MOST: usize, const WRAPPED: usize> Streams<'s, T, MOST, WRAPPED> {
    const EMPTY: Self = Self { list: heapless::Vec::new(), leading: 0, wrapped: heapless::Vec::new() };

    /// Adds a stream, in front of those that do not lead if it leads.
    fn add(&mut self, stream: Stream<'s, T>, leads: bool) {
        let last = self.list.len();
        if self.list.push(stream).is_ok() && leads {
            self.list.swap(self.leading, last);
            self.leading += 1;
        }
    }

    /// Gathers for each of `COUNT` groups what is `shift` numbers after slot 0, and asks for what is `ahead` after that.
    #[inline(always)]
    fn fill<S: Space, V: Vector<Elem = T>, const COUNT: usize>(&self, shift: usize, ahead: usize, gathered: &mut [T]) {
        let mut streams = self.list.iter();
        for stream in streams.by_ref().take(self.leading) {
            prefetch(Cache::Second, stream.field, stream.start.wrapping_add(shift + ahead), 2 * V::LANES * COUNT);
            stream.fill::<S, V, COUNT>(shift, gathered);
        }
        for stream in streams {
            stream.fill::<S, V, COUNT>(shift, gathered);
        }
        let size = Gathered::<S>::SIZE * V::LANES;
        for number in &self.wrapped {
            let Some(&value) = number.field.get(number.start.wrapping_add(shift)) else { continue };
            gathered[number.cell / V::LANES * size + number.place * V::LANES + number.cell % V::LANES] = value;
        }
    }
}

/// Number by number at the ends of a field, 0 beyond.
#[cold]
#[inline(never)]
fn at_the_end<T: Real>(field: &[T], from: usize, to: &mut [T]) {
    for (lane, to) in to.iter_mut().enumerate() {
        *to = field.get(from.wrapping_add(2 * lane)).copied().unwrap_or(T::ZERO);
    }
}

/// All that some cells of one row read. Behind walls along y and z there is nothing, and what is gathered stays 0.
pub(super) struct Gather<'s, T> {
    streams: Streams<'s, T, MOST, MOST_WRAPPED>,
    /// The velocity before slot 0.
    given: Streams<'s, T, FACES, 1>,
    slots: usize,
    nx: usize,
}

impl<'s, T: Real> Gather<'s, T> {
    /// For `cells` of `row`.
    pub(super) fn new<S: Space>(system: &System<'s, T>, row: usize, cells: Cells) -> Self {
        let &System { grid, slots, v, w, p, pbar, v0, rhs, .. } = system;
        let around = Around::new(grid, row, cells);
        let mut gather = Self { streams: Streams::EMPTY, given: Streams::EMPTY, slots, nx: grid.n[0] };
        let all = &mut gather.streams;
        for (field, place) in [(v, Gathered::<S>::V), (w, Gathered::<S>::W)] {
            around.own_faces(all, field, place, slots, 0);
            for e in 0..S::EDGES {
                let edge = Edge::new::<S>(e);
                around.read(all, field[edge.a], place + S::FACES + 2 * e, slots, 0, edge.outside_a());
                around.read(all, field[edge.b], place + S::FACES + 2 * e + 1, slots, 0, edge.outside_b());
            }
        }
        for (field, place) in [(p, Gathered::<S>::P), (pbar, Gathered::<S>::PBAR)] {
            around.read(all, field, place, slots, 0, [0; 3]);
            for f in 0..S::FACES {
                let mut beside = [0; 3];
                beside[f / 2] = [-1, 1][f % 2];
                around.read(all, field, place + 1 + f, slots, 0, beside);
            }
        }
        around.own_faces(all, v, Gathered::<S>::BEFORE, slots, -1);
        around.own_faces(all, w, Gathered::<S>::AFTER, slots, 1);
        around.own_faces(all, rhs.a, Gathered::<S>::TARGET, slots, 0);
        around.own_faces(all, rhs.c, Gathered::<S>::SOURCE, slots, 0);
        around.read(all, rhs.b, Gathered::<S>::B, slots, 0, [0; 3]);
        around.read(all, rhs.d, Gathered::<S>::D, slots, 0, [0; 3]);
        around.own_faces(&mut gather.given, v0, Gathered::<S>::BEFORE, 1, 0);
        gather
    }

    /// Gathers slot `k`: group after group, [`Gathered::SIZE`] vectors each.
    #[inline(always)]
    pub(super) fn fill<S: Space, V: Vector<Elem = T>>(&self, k: usize, gathered: &mut [T]) {
        const { assert!(GROUPS == 2, "one group, or two") };
        match gathered.len() / (Gathered::<S>::SIZE * V::LANES) {
            1 => self.fill_groups::<S, V, 1>(k, gathered),
            _ => self.fill_groups::<S, V, 2>(k, gathered),
        }
    }

    #[inline(always)]
    fn fill_groups<S: Space, V: Vector<Elem = T>, const COUNT: usize>(&self, k: usize, gathered: &mut [T]) {
        self.streams.fill::<S, V, COUNT>(k * self.nx, AHEAD * self.nx, gathered);
        if k == 0 {
            self.given.fill::<S, V, COUNT>(0, 0, gathered);
        }
        if k + 1 == self.slots {
            for group in gathered.chunks_exact_mut(Gathered::<S>::SIZE * V::LANES) {
                group[Gathered::<S>::AFTER * V::LANES..][..S::FACES * V::LANES].fill(T::ZERO);
            }
        }
    }
}

/// Where some cells of a row are, and the rows around it; `None` behind a wall.
struct Around<'g> {
    grid: &'g Grid,
    cells: Cells,
    rows: [Option<usize>; 9],
}

impl<'g> Around<'g> {
    fn new(grid: &'g Grid, row: usize, cells: Cells) -> Self {
        let step = |row: Option<usize>, axis: usize, offset: usize| match offset {
            0 => grid.neighbour(row?, axis, Side::Low),
            2 => grid.neighbour(row?, axis, Side::High),
            _ => row,
        };
        let rows = core::array::from_fn(|i| {
            let in_y = step(Some(row), 1, i % 3);
            if grid.dims == 3 { step(in_y, 2, i / 3) } else { in_y.filter(|_| i / 3 == 1) }
        });
        Self { grid, cells, rows }
    }

    /// Adds a field of `slots` slots, `offset` from the cells and `time` slots after the one that is gathered.
    fn read<'s, T: Real, const MOST: usize, const WRAPPED: usize>(
        &self,
        streams: &mut Streams<'s, T, MOST, WRAPPED>,
        field: &'s [T],
        place: usize,
        slots: usize,
        time: isize,
        offset: [isize; 3],
    ) {
        let (grid, nx) = (self.grid, self.grid.n[0]);
        let Some(row) = self.rows[(offset[1] + 1 + 3 * (offset[2] + 1)) as usize].filter(|_| !field.is_empty()) else { return };
        let Cells { start: x, count } = self.cells;
        let start = (row * slots * nx).wrapping_add_signed(time * nx as isize + x as isize + offset[0]);
        streams.add(Stream { field, start, place }, time == 0 && offset[0] == 0);
        let last = 2 * (count - 1);
        if grid.periodic[0] && offset[0] == -1 && x == 0 {
            let _ = streams.wrapped.push(Wrapped { field, start: start.wrapping_add(nx), place, cell: 0 });
        } else if grid.periodic[0] && offset[0] == 1 && x + last + 1 == nx {
            let _ = streams.wrapped.push(Wrapped { field, start: start.wrapping_add(last).wrapping_sub(nx), place, cell: count - 1 });
        }
    }

    /// Adds the cells' own faces, place after place.
    fn own_faces<'s, T: Real, const MOST: usize, const WRAPPED: usize>(
        &self,
        streams: &mut Streams<'s, T, MOST, WRAPPED>,
        field: Field<'s, T>,
        place: usize,
        slots: usize,
        time: isize,
    ) {
        for (axis, component) in field.into_iter().enumerate().take(self.grid.dims) {
            for side in 0..2 {
                let mut offset = [0; 3];
                offset[axis] = side;
                self.read(streams, component, place + 2 * axis + side as usize, slots, time, offset);
            }
        }
    }
}
