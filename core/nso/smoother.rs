//! The order of cells: one colour after the other, every cell of a colour reading the state before its pass.
//!
//! Reads reach one and a half cells, so the changes of a plane of cells wait in a ring of a few planes until the planes
//! next to it are solved. The result is the same whatever the ring's size, and for any number of threads.

use super::colours::Colours;
use super::level::{LevelMut, Weights};
use super::local;
use crate::exec::{Exec, Planes, RowBuffers, RowTask, for_rows_across};
use crate::field::rows;
use crate::grid::{Grid, Side, Space};
use crate::real::Real;
use crate::simd::multiversion;

/// The smoother's buffers.
#[derive(Debug)]
pub struct Workspace<'a, T> {
    /// Changes that wait: the ring.
    pub ring: &'a mut [T],
    /// Scratch of all threads, for `lanes` cells side by side.
    pub scratch: &'a mut [T],
    /// Cells that a thread solves side by side at most.
    pub lanes: usize,
}

/// Numbers of the changes of one row of cells.
fn row_changes<S: Space>(grid: &Grid, slots: usize) -> usize {
    slots * local::changes::<S>() * grid.n[0].div_ceil(2)
}

/// Planes that stay in the ring besides those being solved.
fn waiting(grid: &Grid) -> usize {
    if grid.periodic[grid.dims - 1] { 3 } else { 2 }
}

/// Numbers of a ring in which `together` planes are solved at a time.
#[must_use]
pub fn ring_len<S: Space>(grid: &Grid, slots: usize, together: usize) -> usize {
    row_changes::<S>(grid, slots) * grid.rows_per_plane() * (together + waiting(grid)).min(grid.planes())
}

/// One smoothing of all colours.
pub fn sweep<T: Real, S: Space>(exec: &dyn Exec, level: &mut LevelMut<'_, T>, weights: &Weights<T>, colours: Colours, workspace: &mut Workspace<'_, T>) {
    for pass in 0..colours.passes(level.grid) {
        let mut ring = Ring::new::<S>(level.grid, weights.slots, colours, pass, workspace);
        let planes = level.grid.planes();
        let mut applied = ring.first_applied();
        for start in (0..planes).step_by(ring.together) {
            let end = (start + ring.together).min(planes);
            ring.solve::<S>(exec, level, weights, start, end);
            let ready = if end == planes { planes } else { end.saturating_sub(1) };
            if ready > applied {
                ring.apply::<S>(exec, level, weights.slots, applied, ready);
                applied = ready;
            }
        }
        if ring.keep_first {
            ring.apply::<S>(exec, level, weights.slots, 0, 1);
        }
    }
}

/// The ring of planes of one pass.
struct Ring<'a, T> {
    changes: &'a mut [T],
    scratch: &'a mut [T],
    lanes: usize,
    colours: Colours,
    pass: usize,
    /// Planes that the ring holds.
    size: usize,
    /// Planes solved at a time.
    together: usize,
    /// Whether plane 0 is read by the last plane, and so waits for it.
    keep_first: bool,
    rows_per_plane: usize,
    row_len: usize,
    half: usize,
}

impl<'a, T: Real> Ring<'a, T> {
    fn new<S: Space>(grid: &Grid, slots: usize, colours: Colours, pass: usize, workspace: &'a mut Workspace<'_, T>) -> Self {
        let (row_len, rows_per_plane, planes) = (row_changes::<S>(grid, slots), grid.rows_per_plane(), grid.planes());
        let size = (workspace.ring.len() / (row_len * rows_per_plane)).min(planes);
        let together = if size == planes { planes } else { size - waiting(grid) };
        Self {
            changes: &mut workspace.ring[..size * rows_per_plane * row_len],
            scratch: workspace.scratch,
            lanes: workspace.lanes,
            colours,
            pass,
            size,
            together,
            keep_first: size < planes && grid.periodic[grid.dims - 1],
            rows_per_plane,
            row_len,
            half: grid.n[0].div_ceil(2),
        }
    }

    fn first_applied(&self) -> usize {
        usize::from(self.keep_first)
    }

    /// The ring's place of a plane.
    fn place(&self, plane: usize) -> usize {
        place(plane, self.size, self.keep_first)
    }

    /// The ring's places of planes `start..end`, as many as are solved at a time or fewer.
    fn places(&self, start: usize, end: usize) -> Planes {
        let kept = usize::from(self.keep_first && start > 0);
        Planes { count: end - start, first: self.place(start) - kept, size: self.size - kept, offset: kept }
    }

    /// Solves the cells of planes `start..end`; the state stays as it is.
    fn solve<S: Space>(&mut self, exec: &dyn Exec, level: &LevelMut<'_, T>, weights: &Weights<T>, start: usize, end: usize) {
        let system = level.system(weights);
        let (rows_per_plane, lanes, half, colours, pass) = (self.rows_per_plane, self.lanes, self.half, self.colours, self.pass);
        let (size, keep_first) = (self.size, self.keep_first);
        let places = self.places(start, end);
        let buffers = RowBuffers { fields: [&mut *self.changes], sums: &mut [], scratch: &mut *self.scratch };
        for_rows_across(exec, size * rows_per_plane, rows_per_plane, places, buffers, |task| {
            let Some(plane) = (start..end).find(|&plane| place(plane, size, keep_first) == task.row / rows_per_plane) else { return };
            let row = plane * rows_per_plane + task.row % rows_per_plane;
            let cells = colours.cells(system.grid, pass, row);
            let [out] = task.fields;
            if cells.count > 0 {
                local::solve_row::<T, S>(&system, row, cells, lanes, task.scratch, local::Changes { out, half });
            }
        });
    }

    /// Adds the changes to the rows of planes `start..end`.
    fn apply<S: Space>(&mut self, exec: &dyn Exec, level: &mut LevelMut<'_, T>, slots: usize, start: usize, end: usize) {
        let grid = level.grid;
        let buffers = RowBuffers { fields: level.state.fields(), sums: &mut [], scratch: &mut [] };
        let ring = &*self;
        for_rows_across(exec, grid.rows(), self.rows_per_plane, Planes::of(start..end), buffers, |task| ring.apply_to_row::<S>(grid, slots, task));
    }

    /// The changes of the cells of `row`.
    fn row(&self, row: usize) -> &[T] {
        let at = self.place(row / self.rows_per_plane) * self.rows_per_plane + row % self.rows_per_plane;
        &self.changes[at * self.row_len..][..self.row_len]
    }

    fn apply_to_row<S: Space>(&self, grid: &Grid, slots: usize, task: RowTask<'_, T, 8>) {
        let RowTask { row, fields: [v0, v1, v2, w0, w1, w2, p, pbar], .. } = task;
        let own = Source { changes: self.row(row), cells: self.colours.cells(grid, self.pass, row), half: self.half };
        for (axis, (v, w)) in [(v0, w0), (v1, w1), (v2, w2)].into_iter().enumerate().take(S::DIM) {
            for (field, quantity) in [(v, 2 * axis), (w, S::FACES + 2 * axis)] {
                if grid.periodic[axis] || axis == 0 || !grid.wall_below(row, axis) {
                    own.add_to(grid, slots, field, quantity, 0, !grid.periodic[0] && axis == 0);
                }
                if axis == 0 {
                    own.add_to(grid, slots, field, quantity + 1, 1, !grid.periodic[0]);
                } else if let Some(below) = grid.neighbour(row, axis, Side::Low) {
                    let cells = self.colours.cells(grid, self.pass, below);
                    Source { changes: self.row(below), cells, ..own }.add_to(grid, slots, field, quantity + 1, 0, false);
                }
            }
        }
        own.add_to(grid, slots, p, 2 * S::FACES, 0, false);
        own.add_to(grid, slots, pbar, 2 * S::FACES + 1, 0, false);
    }
}

/// The place of a plane in a ring of `size`, whose first place may be kept for plane 0.
fn place(plane: usize, size: usize, keep_first: bool) -> usize {
    match (keep_first, plane) {
        (true, 0) => 0,
        (true, _) => 1 + (plane - 1) % (size - 1),
        (false, _) => plane % size,
    }
}

/// The changes of one row of cells.
#[derive(Clone, Copy)]
struct Source<'a, T> {
    changes: &'a [T],
    cells: super::colours::Cells,
    half: usize,
}

impl<T: Real> Source<'_, T> {
    /// Adds a quantity to `field` at the cells plus `offset` along x, in every slot; faces on the wall are left at 0.
    fn add_to(&self, grid: &Grid, slots: usize, field: &mut [T], quantity: usize, offset: usize, walls: bool) {
        let (nx, count, half, first) = (grid.n[0], self.cells.count, self.half, self.cells.start + offset);
        if count == 0 {
            return;
        }
        let wraps = first + 2 * (count - 1) == nx;
        let (from, to) = (&self.changes[quantity * slots * half..][..slots * half], &mut field[..slots * nx]);
        if nx == 2 * count && (walls || !wraps) {
            // Every other number of all slots, and of the wall in the slot after: one long row.
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
    /// Adds the first `count` numbers of every `half` of `from` to every other number from `first` on of every `nx` of `field`, as far
    /// as they go; to those between it adds 0, which keeps the loop a plain one over whole vectors.
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
