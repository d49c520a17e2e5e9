//! The order of cells: one colour after the other, every cell of a colour reading the state before its pass.
//!
//! Reads reach one and a half cells, so the changes of a plane of cells wait in a ring of a few planes until the planes
//! next to it are solved. Threads share the planes of the ring, or have a ring and a slab of planes each; then the first and the last plane of every slab,
//! the only ones that others read, are solved before all. The result is the same whatever the shape, and for any number of threads.

use super::colours::Colours;
use super::level::{LevelMut, System, Weights};
use super::{Shape, Split, local};
use crate::exec::{Exec, Planes, RowBuffers, RowTask, Serial, Slabs, for_rows, for_rows_across, for_slabs};
use crate::field::rows;
use crate::grid::{Grid, Side, Space};
use crate::memory::pooled;
use crate::real::Real;
use crate::simd::multiversion;
use core::ops::Range;

/// The smoother's buffers.
#[derive(Debug)]
pub struct Workspace<'a, T> {
    /// Changes that wait for other threads: [`waiting_len`].
    pub waiting: &'a mut [T],
    /// Scratch of all threads, [`scratch_len`] each.
    pub scratch: &'a mut [T],
    /// How these are used.
    pub shape: Shape,
}

/// Planes of a slab, at least: in fewer, what one thread reads of the other's takes longer than the other saves.
const LEAST: usize = 8;

/// Planes that stay in the ring besides those being solved.
const STAY: usize = 2;

/// Numbers of the changes of one row of cells.
fn row_changes<S: Space>(grid: &Grid, slots: usize) -> usize {
    slots * local::changes::<S>() * grid.n[0].div_ceil(2)
}

/// Numbers of the changes of one plane of cells.
fn plane_changes<S: Space>(grid: &Grid, slots: usize) -> usize {
    row_changes::<S>(grid, slots) * grid.rows_per_plane()
}

/// Planes at the edges of slabs, the first and the last one of each: none where there is nothing beyond.
fn edges(grid: &Grid, slabs: Slabs) -> usize {
    if slabs.count() > 1 || grid.periodic[grid.dims - 1] {
        2 * slabs.count()
    } else {
        0
    }
}

/// Numbers of changes that wait for other threads.
#[must_use]
pub fn waiting_len<S: Space>(grid: &Grid, slots: usize, threads: usize, split: Split) -> usize {
    let ring = match split {
        Split::Slabs => 0,
        Split::Planes(together) => (together + STAY).min(grid.planes()),
    };
    plane_changes::<S>(grid, slots) * (edges(grid, split.slabs(grid, threads, LEAST)) + ring)
}

/// Numbers of a ring that a thread has alone.
fn own_ring_len<S: Space>(grid: &Grid, slots: usize, split: Split) -> usize {
    if split == Split::Slabs {
        pooled(plane_changes::<S>(grid, slots) * (1 + STAY))
    } else {
        0
    }
}

/// Numbers of scratch of a thread.
#[must_use]
pub fn scratch_len<S: Space>(grid: &Grid, slots: usize, shape: Shape) -> usize {
    own_ring_len::<S>(grid, slots, shape.split) + local::scratch_len::<S>(slots, shape.lanes)
}

/// One smoothing of all colours.
pub fn sweep<T: Real, S: Space>(
    exec: &dyn Exec,
    level: &mut LevelMut<'_, T>,
    weights: &Weights<T>,
    colours: Colours,
    workspace: &mut Workspace<'_, T>,
) {
    let mut state = core::mem::take(&mut level.state);
    let (grid, slots, Shape { lanes, split }) = (level.grid, weights.slots, workspace.shape);
    let slabs = split.slabs(grid, exec.threads(), LEAST);
    let at_edges = edges(grid, slabs);
    let (edges, ring) = workspace
        .waiting
        .split_at_mut(at_edges * plane_changes::<S>(grid, slots));
    let scratch = &mut *workspace.scratch;
    for number in 0..colours.passes(grid) {
        let pass = Pass {
            given: level.system(weights),
            slabs,
            colours,
            number,
            lanes,
        };
        pass.solve_edges::<S>(
            exec,
            state.fields().map(|field| &*field),
            at_edges,
            edges,
            scratch,
        );
        let edges = &*edges;
        if split == Split::Slabs {
            for_slabs(exec, slabs, state.fields(), &mut *scratch, |task| {
                let (ring, scratch) = task.scratch.split_at_mut(own_ring_len::<S>(grid, slots, split));
                Slab {
                    pass: &pass,
                    planes: task.rows,
                    state: task.fields,
                    edges,
                    ring,
                    scratch,
                }
                .smooth::<S>(&Serial);
            });
        } else {
            Slab {
                pass: &pass,
                planes: 0..grid.planes(),
                state: state.fields(),
                edges,
                ring: &mut *ring,
                scratch: &mut *scratch,
            }
            .smooth::<S>(exec);
        }
    }
    level.state = state;
}

/// One pass over a level.
struct Pass<'a, T> {
    /// The equations, but for the unknowns.
    given: System<'a, T>,
    slabs: Slabs,
    colours: Colours,
    number: usize,
    lanes: usize,
}

impl<T: Real> Pass<'_, T> {
    /// Solves the cells of the planes at the edges of slabs.
    fn solve_edges<S: Space>(
        &self,
        exec: &dyn Exec,
        state: [&[T]; 8],
        count: usize,
        edges: &mut [T],
        scratch: &mut [T],
    ) {
        let grid = self.given.grid;
        let (a_plane, system) = (grid.rows_per_plane(), self.given.of_rows(0..grid.rows(), state));
        let rows = count * a_plane;
        for_rows(
            exec,
            rows,
            RowBuffers::fields([edges]).with_scratch(scratch),
            |task| {
                let ([edge, in_plane], [changes]) = (grid.plane_of(task.row), task.fields);
                let Range { start, end } = self.slabs.rows_of(edge / 2);
                let plane = if edge % 2 == 0 { start } else { end - 1 };
                self.solve_row::<S>(&system, plane * a_plane + in_plane, changes, task.scratch);
            },
        );
    }

    /// Solves the cells of one row.
    fn solve_row<S: Space>(&self, system: &System<'_, T>, row: usize, out: &mut [T], scratch: &mut [T]) {
        let cells = self.colours.cells(system.grid, self.number, row);
        if cells.count > 0 {
            local::solve_row::<T, S>(
                system,
                row,
                cells,
                self.lanes,
                scratch,
                local::Changes {
                    out,
                    half: system.grid.n[0].div_ceil(2),
                },
            );
        }
    }

    /// Which of the planes at the edges of slabs a plane is.
    fn edge(&self, plane: usize) -> Option<usize> {
        let slab = self.slabs.slab_of(plane);
        let Range { start, end } = self.slabs.rows_of(slab);
        if plane == start {
            Some(2 * slab)
        } else {
            (plane + 1 == end).then_some(2 * slab + 1)
        }
    }
}

/// Some planes whose unknowns nobody else reads or writes meanwhile.
struct Slab<'a, T> {
    pass: &'a Pass<'a, T>,
    planes: Range<usize>,
    /// The unknowns of these planes.
    state: [&'a mut [T]; 8],
    /// The changes of the planes at the edges of all slabs, if they have any.
    edges: &'a [T],
    ring: &'a mut [T],
    scratch: &'a mut [T],
}

impl<T: Real> Slab<'_, T> {
    /// Solves the planes between the edges, or all, and adds the changes of all.
    fn smooth<S: Space>(&mut self, exec: &dyn Exec) {
        let Range {
            start: low,
            end: high,
        } = self.planes;
        let inner = if self.edges.is_empty() {
            low..high
        } else {
            low + 1..high - 1
        };
        let a_plane = plane_changes::<S>(self.pass.given.grid, self.pass.given.slots);
        let size = (self.ring.len() / a_plane).min(inner.len());
        let together = if size == inner.len() {
            size.max(1)
        } else {
            size - STAY
        };
        let mut applied = low;
        for start in inner.clone().step_by(together) {
            let end = (start + together).min(inner.end);
            self.solve::<S>(exec, start..end, size);
            // The last one is read by the next.
            let ready = if end == inner.end { high } else { end - 1 };
            self.apply::<S>(exec, applied..ready, size);
            applied = ready;
        }
        self.apply::<S>(exec, applied..high, size);
    }

    /// Solves the cells of some planes into a ring of `size` planes; the state stays as it is.
    fn solve<S: Space>(&mut self, exec: &dyn Exec, planes: Range<usize>, size: usize) {
        let Self {
            pass,
            planes: all,
            state,
            ring,
            scratch,
            ..
        } = self;
        let grid = pass.given.grid;
        let (a_plane, row_len) = (grid.rows_per_plane(), row_changes::<S>(grid, pass.given.slots));
        let system = pass.given.of_rows(
            all.start * a_plane..all.end * a_plane,
            state.each_ref().map(|field| &**field),
        );
        let places = Planes {
            count: planes.len(),
            first: planes.start,
            size,
            offset: 0,
        };
        let ring = &mut ring[..size * a_plane * row_len];
        for_rows_across(
            exec,
            size * a_plane,
            a_plane,
            places,
            RowBuffers::fields([ring]).with_scratch(scratch),
            |task| {
                let ([place, in_plane], [changes]) = (grid.plane_of(task.row), task.fields);
                let Some(plane) = planes.clone().find(|&plane| place_in_ring(plane, size) == place) else {
                    return;
                };
                pass.solve_row::<S>(&system, plane * a_plane + in_plane, changes, task.scratch);
            },
        );
    }

    /// Adds the changes to the rows of some planes.
    fn apply<S: Space>(&mut self, exec: &dyn Exec, planes: Range<usize>, size: usize) {
        let Self {
            pass,
            planes: all,
            state,
            edges,
            ring,
            ..
        } = self;
        let (slots, a_plane) = (pass.given.slots, pass.given.grid.rows_per_plane());
        let waiting = Waiting {
            pass,
            edges,
            ring,
            size,
            row_len: row_changes::<S>(pass.given.grid, slots),
        };
        let buffers = RowBuffers::fields(state.each_mut().map(|field| &mut **field));
        let within = Planes::of(planes.start - all.start..planes.end - all.start);
        for_rows_across(exec, all.len() * a_plane, a_plane, within, buffers, |task| {
            waiting.add_to_row::<S>(RowTask {
                row: all.start * a_plane + task.row,
                ..task
            })
        });
    }
}

/// The place of a plane in a ring of `size`.
fn place_in_ring(plane: usize, size: usize) -> usize {
    plane % size.max(1)
}

/// Changes that wait.
struct Waiting<'a, T> {
    pass: &'a Pass<'a, T>,
    edges: &'a [T],
    ring: &'a [T],
    /// Planes of the ring.
    size: usize,
    row_len: usize,
}

impl<T: Real> Waiting<'_, T> {
    /// The changes of the cells of `row`.
    fn of_row(&self, row: usize) -> Source<'_, T> {
        let Pass {
            given: System { grid, .. },
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
            changes,
            cells: colours.cells(grid, number, row),
            half: grid.n[0].div_ceil(2),
        }
    }

    /// Adds to a row of the state the changes of its cells and of those below.
    fn add_to_row<S: Space>(&self, task: RowTask<'_, T, 8>) {
        let RowTask {
            row,
            fields: [v0, v1, v2, w0, w1, w2, p, pbar],
            ..
        } = task;
        let System { grid, slots, .. } = self.pass.given;
        let own = self.of_row(row);
        for (axis, (v, w)) in [(v0, w0), (v1, w1), (v2, w2)]
            .into_iter()
            .enumerate()
            .take(S::DIM)
        {
            let below = if axis > 0 {
                grid.neighbour(row, axis, Side::Low)
                    .map(|below| self.of_row(below))
            } else {
                None
            };
            for (field, quantity) in [(v, 2 * axis), (w, S::FACES + 2 * axis)] {
                if grid.periodic[axis] || axis == 0 || !grid.wall_below(row, axis) {
                    own.add_to(grid, slots, field, quantity, 0, !grid.periodic[0] && axis == 0);
                }
                if axis == 0 {
                    own.add_to(grid, slots, field, quantity + 1, 1, !grid.periodic[0]);
                } else if let Some(below) = &below {
                    below.add_to(grid, slots, field, quantity + 1, 0, false);
                }
            }
        }
        own.add_to(grid, slots, p, 2 * S::FACES, 0, false);
        own.add_to(grid, slots, pbar, 2 * S::FACES + 1, 0, false);
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
    fn add_to(
        &self,
        grid: &Grid,
        slots: usize,
        field: &mut [T],
        quantity: usize,
        offset: usize,
        walls: bool,
    ) {
        let (nx, count, half, first) = (grid.n[0], self.cells.count, self.half, self.cells.start + offset);
        if count == 0 {
            return;
        }
        let wraps = first + 2 * (count - 1) == nx;
        let (from, to) = (
            &self.changes[quantity * slots * half..][..slots * half],
            &mut field[..slots * nx],
        );
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
