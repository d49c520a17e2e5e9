//! Changes of cells that are solved but not yet added to the state, since cells beside still read it as it
//! was.

use super::colours::Cells;
use super::level::System;
use super::pass::{Pass, row_changes};
use crate::exec::RowTask;
use crate::field::rows;
use crate::grid::solids::closed;
use crate::grid::{Grid, Side, Space};
use crate::real::Real;
use crate::simd::multiversion;

/// The place of a plane in a ring of `size`.
pub(super) fn place_in_ring(plane: usize, size: usize) -> usize {
    plane % size.max(1)
}

/// Pending changes: of the planes at the edges of slabs, and of those in a ring.
pub(super) struct Pending<'a, T> {
    pass: &'a Pass<'a, T>,
    edges: &'a [T],
    ring: &'a [T],
    /// Planes of the ring.
    size: usize,
    row_len: usize,
}

impl<'a, T: Real> Pending<'a, T> {
    /// In a ring of `size` planes.
    pub(super) fn new<S: Space>(pass: &'a Pass<'a, T>, edges: &'a [T], ring: &'a [T], size: usize) -> Self {
        Self {
            pass,
            edges,
            ring,
            size,
            row_len: row_changes::<S>(pass.given.grid, pass.given.slots),
        }
    }

    /// The changes of the cells of `row`.
    fn of_row(&self, row: usize) -> Source<'_, T> {
        let Pass {
            given: System { grid, slots, .. },
            colours,
            number,
            ..
        } = *self.pass;
        let [plane, in_plane] = grid.plane_of(row);
        let edge = if self.edges.is_empty() {
            None
        } else {
            self.pass.edge(plane)
        };
        let (planes, place) = edge.map_or_else(
            || (self.ring, place_in_ring(plane, self.size)),
            |edge| (self.edges, edge),
        );
        let changes = &planes[(place * grid.rows_per_plane() + in_plane) * self.row_len..][..self.row_len];
        Source {
            grid,
            slots,
            changes,
            cells: colours.cells(grid, number, row),
        }
    }

    /// Adds to a row of the state the changes of its cells and of those below.
    pub(super) fn add_to_row<S: Space>(&self, task: RowTask<'_, T, 8>) {
        let RowTask {
            row,
            fields: [v0, v1, v2, w0, w1, w2, p, pbar],
            ..
        } = task;
        let System { grid, solids, .. } = self.pass.given;
        let own = self.of_row(row);
        let walls = grid.axis(0).open_face(0).is_none();
        for (axis, (v, w)) in [(v0, w0), (v1, w1), (v2, w2)]
            .into_iter()
            .enumerate()
            .take(S::DIM)
        {
            let below = (axis > 0).then(|| grid.neighbour(row, axis, Side::Low));
            let below = below.flatten().map(|below| self.of_row(below));
            for (field, quantity) in [(&mut *v, 2 * axis), (&mut *w, S::FACES + 2 * axis)] {
                if axis == 0 {
                    own.add_to(field, quantity, 0, walls);
                    own.add_to(field, quantity + 1, 1, walls);
                } else if let Some(below) = &below {
                    own.add_to(field, quantity, 0, false);
                    below.add_to(field, quantity + 1, 0, false);
                }
                if solids.there() {
                    // Rounding is all that there is.
                    solids.clear(grid.n[0], row, closed(axis), field);
                }
            }
        }
        own.add_to(p, 2 * S::FACES, 0, false);
        own.add_to(pbar, 2 * S::FACES + 1, 0, false);
    }
}

/// The changes of one row of cells.
#[derive(Clone, Copy)]
struct Source<'a, T> {
    grid: &'a Grid,
    slots: usize,
    changes: &'a [T],
    cells: Cells,
}

impl<T: Real> Source<'_, T> {
    /// Adds a quantity to `field` at the cells plus `offset` along x, in every slot. With `walls`, values at
    /// x = 0 are on a wall and stay 0.
    fn add_to(&self, field: &mut [T], quantity: usize, offset: usize, walls: bool) {
        let (nx, slots, count) = (self.grid.n[0], self.slots, self.cells.count);
        let half = nx.div_ceil(2);
        let first = self.cells.start + offset;
        if count == 0 {
            return;
        }
        let wraps = first + 2 * (count - 1) == nx;
        let from = &self.changes[quantity * slots * half..][..slots * half];
        let to = &mut field[..slots * nx];
        if nx == 2 * count && (walls || !wraps) {
            // Every other value of all slots, and of the wall in the slot after: one long row.
            add_to_every_other(to, slots * nx, first, from, slots * half, slots * half);
        } else {
            add_to_every_other(to, nx, first, from, half, count);
        }
        if walls && (wraps || first == 0) {
            rows::clear_first(to, nx);
        } else if wraps {
            for (to, from) in to.chunks_exact_mut(nx).zip(from.chunks(half)) {
                to[0] += from[count - 1];
            }
        }
    }
}

multiversion! {
    /// Adds, in every slot, the first `count` of `half` values of `from` to every other one of `nx` values of
    /// `field`, from `first` on as far as they go. To those between it adds 0, which keeps the loop a plain
    /// one over whole vectors.
    fn add_to_every_other[T: Real](field: &mut [T], nx: usize, first: usize, from: &[T], half: usize, count: usize) {
        for (to, from) in field.chunks_exact_mut(nx).zip(from.chunks(half)) {
            let (Some(to), Some(from)) = (to.get_mut(first..), from.get(..count)) else { continue };
            let mut pairs = to.chunks_exact_mut(2);
            for (pair, &change) in pairs.by_ref().zip(from) {
                pair[0] += change;
                pair[1] += T::ZERO;
            }
            if let ([last], Some(&change)) = (pairs.into_remainder(), from.get((nx - first) / 2)) {
                *last += change;
            }
        }
    }
}
