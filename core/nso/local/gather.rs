//! What the equations of a slot read, cell by cell, side by side.

use super::lanes::{Onto, SideBySide};
use super::stencil::{Around, Reads};
use super::storage::{GROUPS, Gathered};
use super::streams::{OfFaces, OfSlot, Rows};
use crate::grid::Space;
use crate::nso::colours::Cells;
use crate::nso::level::System;
use crate::real::Real;
use crate::simd::Vector;

/// Slots between the one that is read and the one that is prefetched.
const AHEAD: usize = 2;

/// All that some cells of one row read. Behind walls along y and z nothing is read, and the lanes stay 0.
pub(super) struct Gather<'s, T> {
    now: OfSlot<'s, T>,
    /// v in the slot before, of slots side by side.
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

    /// Gathers slot `k`, after slot `k - 1`: [`Gathered::SIZE`] vectors for each group.
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
                .fill_one_by_one::<S, V>(0, V::LANES, Onto::GROUPS, gathered);
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

    /// Adds what slots side by side read too.
    pub(super) fn add_before<S: Space>(&mut self, system: &System<'s, T>, row: usize, cells: Cells) {
        Around::new(system.grid, system.first, row, cells).own_faces(
            &mut self.before,
            system.v,
            self.slots,
            0,
            Gathered::<S>::BEFORE,
        );
    }

    /// Gathers the slots from `k` on that lie side by side in the vectors of one group, `each` lanes for
    /// each.
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
        self.now.fill_slots::<S, V, P>(side_by_side, shift, gathered);
        self.before
            .fill_slots::<S, V, P>(side_by_side, shift.wrapping_sub(self.nx), gathered);
        if k == 0 {
            self.given
                .fill_one_by_one::<S, V>(0, each, side_by_side.onto(0), gathered);
        }
        self.after.fill_slots::<S, V, P>(side_by_side, shift, gathered);
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
