//! The order of cells: one colour after the other, every cell of a colour reading the state before its pass.
//!
//! Reads reach one and a half cells, so the changes of a plane of cells stay `pending` in a
//! ring of a few planes until the planes next to it are solved. Threads share the planes of the ring, or have
//! a ring and a slab of planes each; then the first and the last plane of every slab, the only ones that
//! others read, are solved before all. The result is the same however memory is used, and for any number of
//! threads.

use super::colours::Colours;
use super::level::{Coefficients, LevelMut};
use super::local;
use super::params::{SmootherMemory, Split};
use super::pass::{Pass, plane_changes};
use super::pending::{Pending, place_in_ring};
use crate::exec::{Exec, Planes, RowBuffers, RowTask, Serial, Slabs, for_rows_across, for_slabs};
use crate::grid::{Grid, Space};
use crate::memory::pooled;
use crate::real::Real;
use core::ops::Range;

/// The smoother's buffers.
#[derive(Debug)]
pub struct Workspace<'a, T> {
    /// Changes that other threads read: [`waiting_len`].
    pub waiting: &'a mut [T],
    /// Scratch of all threads, [`scratch_len`] each.
    pub scratch: &'a mut [T],
    /// How these are used.
    pub memory: SmootherMemory,
}

/// The fewest planes of a slab: with fewer, a thread loses more by reading its neighbours' planes than it
/// gains by having its own.
const LEAST: usize = 8;

/// Planes that stay in the ring besides those being solved.
const STAY: usize = 2;

/// Planes at the edges of slabs, the first and the last one of each: none where there is nothing beyond.
fn edges(grid: &Grid, slabs: Slabs) -> usize {
    if slabs.count() > 1 || grid.axis(grid.dims - 1).is_ring() {
        2 * slabs.count()
    } else {
        0
    }
}

/// Values of the changes that other threads read.
#[must_use]
pub fn waiting_len<S: Space>(grid: &Grid, slots: usize, threads: usize, split: Split) -> usize {
    let ring = match split {
        Split::Slabs => 0,
        Split::Planes(together) => (together + STAY).min(grid.planes()),
    };
    plane_changes::<S>(grid, slots) * (edges(grid, split.slabs(grid, threads, LEAST)) + ring)
}

/// Values of the ring of one thread, where each has its own.
fn own_ring_len<S: Space>(grid: &Grid, slots: usize, split: Split) -> usize {
    if split == Split::Slabs {
        pooled(plane_changes::<S>(grid, slots) * (1 + STAY))
    } else {
        0
    }
}

/// Values of scratch of one thread.
#[must_use]
pub fn scratch_len<S: Space>(grid: &Grid, slots: usize, memory: SmootherMemory) -> usize {
    own_ring_len::<S>(grid, slots, memory.split) + local::scratch_len::<S>(slots, memory.lanes)
}

/// One smoothing of all colours; where ranks share the grid they exchange copies after each.
pub fn sweep<T: Real, S: Space>(
    exec: &dyn Exec,
    level: &mut LevelMut<'_, T>,
    coefficients: &Coefficients<T>,
    colours: Colours,
    workspace: &mut Workspace<'_, T>,
) {
    let mut state = core::mem::take(&mut level.state);
    let SmootherMemory { lanes, split } = workspace.memory;
    let (grid, slots) = (level.grid, coefficients.slots);
    let slabs = split.slabs(grid, exec.threads(), LEAST);
    let at_edges = edges(grid, slabs);
    let (edges, ring) = workspace
        .waiting
        .split_at_mut(at_edges * plane_changes::<S>(grid, slots));
    let scratch = &mut *workspace.scratch;
    for number in 0..colours.passes(grid) {
        let pass = Pass {
            given: level.system(coefficients),
            slabs,
            colours,
            number,
            lanes,
        };
        let fields = state.fields().map(|field| &*field);
        pass.solve_edges::<S>(exec, fields, at_edges, edges, scratch);
        let edges = &*edges;
        if split == Split::Slabs {
            let buffers = RowBuffers::fields(state.fields()).with_scratch(&mut *scratch);
            for_slabs(exec, slabs, buffers, |task| {
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
        state.refresh(exec, grid);
    }
    level.state = state;
}

/// Some planes whose unknowns no other thread reads or writes meanwhile.
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
            // The last plane is read by the next one.
            let ready = if end == inner.end { high } else { end - 1 };
            self.apply::<S>(exec, applied..ready, size);
            applied = ready;
        }
        self.apply::<S>(exec, applied..high, size);
    }

    /// Solves the cells of some planes into a ring of `size` planes; the state stays as it is.
    fn solve<S: Space>(&mut self, exec: &dyn Exec, planes: Range<usize>, size: usize) {
        let pass = self.pass;
        let grid = pass.given.grid;
        let a_plane = grid.rows_per_plane();
        let system = pass.given.of_rows(
            self.planes.start * a_plane..self.planes.end * a_plane,
            self.state.each_ref().map(|field| &**field),
        );
        let places = Planes {
            count: planes.len(),
            first: planes.start,
            size,
            offset: 0,
        };
        let buffers =
            RowBuffers::fields([&mut self.ring[..size * plane_changes::<S>(grid, pass.given.slots)]])
                .with_scratch(&mut *self.scratch);
        for_rows_across(exec, size * a_plane, a_plane, places, buffers, |task| {
            let [place, in_plane] = grid.plane_of(task.row);
            let [changes] = task.fields;
            let Some(plane) = planes.clone().find(|&plane| place_in_ring(plane, size) == place) else {
                return;
            };
            pass.solve_row::<S>(&system, plane * a_plane + in_plane, changes, task.scratch);
        });
    }

    /// Adds the changes to the rows of some planes.
    fn apply<S: Space>(&mut self, exec: &dyn Exec, planes: Range<usize>, size: usize) {
        let all = self.planes.clone();
        let a_plane = self.pass.given.grid.rows_per_plane();
        let pending = Pending::new::<S>(self.pass, self.edges, self.ring, size);
        let buffers = RowBuffers::fields(self.state.each_mut().map(|field| &mut **field));
        let within = Planes::of(planes.start - all.start..planes.end - all.start);
        for_rows_across(exec, all.len() * a_plane, a_plane, within, buffers, |task| {
            pending.add_to_row::<S>(RowTask {
                row: all.start * a_plane + task.row,
                ..task
            })
        });
    }
}
