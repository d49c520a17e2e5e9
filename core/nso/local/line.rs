//! The steps of a group of cells in time.

use super::factor::eliminate;
use super::group::Group;
use super::lanes::MAX_LANES;
use super::storage::{Changes, Header, lower_len, slot_mut};
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;

/// A group of cells in all slots: lines of unknowns in time, side by side.
pub(super) struct Line<'s, 'a, 'm, T> {
    pub(super) group: Group<'s, 'a, T>,
    pub(super) header: &'m mut [T],
    pub(super) lower: &'m mut [T],
    pub(super) stored: &'m mut [T],
}

impl<'s, 'a, 'm, T: Real> Line<'s, 'a, 'm, T> {
    /// In scratch of [`group_len`] vectors.
    #[inline(always)]
    pub(super) fn new<S: Space, V: Vector<Elem = T>>(group: Group<'s, 'a, T>, scratch: &'m mut [T]) -> Self {
        let (header, scratch) = scratch.split_at_mut(Header::<S>::SIZE * V::LANES);
        group.fill_header::<S, V>(V::LANES, header);
        let (lower, stored) = scratch.split_at_mut(lower_len::<S>() * V::LANES);
        Self {
            group,
            header,
            lower,
            stored,
        }
    }

    /// Assembles slot `k`.
    #[inline(always)]
    pub(super) fn assemble<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &mut self,
        gathered: &[T],
        k: usize,
    ) {
        let diagonal = V::splat(self.group.diagonal(k));
        let now = slot_mut::<S, V>(self.stored, k);
        self.group
            .assemble::<S, V, VISCOUS>(self.header, gathered, diagonal, now);
    }

    /// Assembles the slots from `k` on, of `each` lanes, to `long`.
    #[inline(always)]
    pub(super) fn assemble_side_by_side<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &self,
        header: &[T],
        gathered: &[T],
        [k, each]: [usize; 2],
        long: &mut [T],
    ) {
        let mut diagonal = [T::ZERO; MAX_LANES];
        for (lane, diagonal) in diagonal.iter_mut().enumerate() {
            *diagonal = self.group.diagonal(k + lane / each);
        }
        let now = slot_mut::<S, V>(long, 0);
        self.group
            .assemble::<S, V, VISCOUS>(header, gathered, V::load(&diagonal), now);
    }

    /// Takes what was assembled for slot `k` out of vectors `V`, from lane `lane` on.
    #[inline(always)]
    pub(super) fn take_slot<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>>(
        &mut self,
        k: usize,
        long: &[T],
        lane: usize,
    ) {
        let now = slot_mut::<S, P>(self.stored, k).chunks_exact_mut(P::LANES);
        let from = long
            .get(lane..)
            .into_iter()
            .flat_map(|long| long.chunks(V::LANES));
        for (from, now) in from.zip(now) {
            P::load(from).store(now);
        }
    }

    /// Eliminates slot `k`, after those before it.
    #[inline(always)]
    pub(super) fn eliminate<S: Space, V: Vector<Elem = T>>(&mut self, k: usize) {
        let diagonal = self.group.diagonal(k);
        eliminate::<T, S, V>(self.stored, self.lower, k, self.group.system.slots, diagonal);
    }

    /// Writes the changes of all slots.
    #[inline(always)]
    pub(super) fn back_substitute<S: Space, V: Vector<Elem = T>>(&self, out: &mut Changes<'_, T>) {
        self.group.back_substitute::<S, V>(self.header, self.stored, out);
    }
}
