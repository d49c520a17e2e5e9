//! Between two levels (mathematics section 5): the solution is restricted by means that keep the divergence, residuals by
//! the scaled transpose of the prolongation (cells: by the mean), corrections are prolonged linearly.

use super::level::{LevelMut, Rhs, System, Weights};
use super::{Split, residual};
use crate::exec::{Exec, Planes, RowBuffers, Serial, for_rows, for_rows_across, for_slabs};
use crate::field::transfer::{Move, Place, along};
use crate::field::{Block, rows, view};
use crate::grid::levels::{Tables, Transfer};
use crate::grid::{Grid, Space};
use crate::real::Real;
use core::ops::Range;

/// The places of [`super::level::State::fields`].
fn place_of(field: usize) -> Place {
    if field < 6 {
        Place::Face(field % 3)
    } else {
        Place::Cell
    }
}

/// Coarse planes of a slab, at least.
const LEAST: usize = 4;

/// Fine planes whose residuals wait, and that a coarse plane collects from, at most.
const NEAR: usize = 8;

/// Numbers of residuals that wait.
fn waiting_len<S: Space>(fine: &Grid, slots: usize) -> usize {
    NEAR.min(fine.planes())
        * fine.rows_per_plane()
        * residual::rows_of::<S>()
        * Block::largest(fine.n[0], slots)
}

/// Numbers of scratch for any transfer from `fine`, and for its norm: rows of a block for each thread, and residuals that wait, with slabs for each thread too.
#[must_use]
pub fn scratch_len<S: Space>(fine: &Grid, slots: usize, threads: usize, split: Split) -> usize {
    let rings = if split == Split::Slabs { threads } else { 1 };
    threads * residual::norm_scratch::<S>(fine, slots) + rings * waiting_len::<S>(fine, slots)
}

/// `coarse = R fine`, the solution and v_0.
pub fn restrict_solution<T: Real>(
    exec: &dyn Exec,
    fine: &mut LevelMut<'_, T>,
    coarse: &mut LevelMut<'_, T>,
    tables: &Tables<'_, T>,
    slots: usize,
    scratch: &mut [T],
) {
    let step = Move {
        tables,
        source: fine.grid,
        target: coarse.grid,
        cell: Transfer::RestrictCell,
        face: Transfer::RestrictFace,
    };
    let from = fine.state.fields().map(|field| &*field);
    move_fields(
        exec,
        step,
        from,
        coarse.state.fields(),
        slots,
        T::ONE,
        true,
        scratch,
    );
    let v0 = view(&fine.v0);
    let none = || <&mut [T]>::default();
    let [x, y, z] = coarse.v0.each_mut().map(|c| &mut **c);
    move_fields(
        exec,
        step,
        [v0[0], v0[1], v0[2], &[], &[], &[], &[], &[]],
        [x, y, z, none(), none(), none(), none(), none()],
        1,
        T::ONE,
        true,
        scratch,
    );
}

/// `fine += s P coarse`, the solution.
pub fn add_prolonged<T: Real>(
    exec: &dyn Exec,
    fine: &mut LevelMut<'_, T>,
    coarse: &mut LevelMut<'_, T>,
    tables: &Tables<'_, T>,
    slots: usize,
    s: T,
    scratch: &mut [T],
) {
    let step = Move {
        tables,
        source: coarse.grid,
        target: fine.grid,
        cell: Transfer::ProlongCell,
        face: Transfer::ProlongFace,
    };
    let from = coarse.state.fields().map(|field| &*field);
    move_fields(exec, step, from, fine.state.fields(), slots, s, false, scratch);
}

/// Moves the eight fields of a state; empty ones are left out.
fn move_fields<T: Real>(
    exec: &dyn Exec,
    step: Move<'_, T>,
    from: [&[T]; 8],
    to: [&mut [T]; 8],
    slots: usize,
    s: T,
    overwrite: bool,
    scratch: &mut [T],
) {
    let count = Block::slots_per_block(step.source.n[0].max(step.target.n[0]), slots);
    for_rows(
        exec,
        step.target.rows(),
        RowBuffers::fields(to).with_scratch(scratch),
        |task| {
            for (index, (field, out)) in from
                .iter()
                .zip(task.fields)
                .enumerate()
                .filter(|(_, (field, _))| !field.is_empty())
            {
                if overwrite {
                    out.fill(T::ZERO);
                }
                for first in (0..slots).step_by(count) {
                    let count = count.min(slots - first);
                    let block = Block {
                        grid: step.target,
                        slots,
                        first,
                        count,
                    };
                    step.add_row(
                        place_of(index),
                        field,
                        slots,
                        first,
                        count,
                        task.row,
                        s,
                        &mut out[block.span_in_row()],
                        task.scratch,
                    );
                }
            }
        },
    );
}

/// The coarse right-hand side: f_coarse(R x) + R(residual), with the coarse solution already R x.
pub fn restrict_residual<T: Real, S: Space>(
    exec: &dyn Exec,
    fine: &LevelMut<'_, T>,
    coarse: &mut LevelMut<'_, T>,
    tables: &Tables<'_, T>,
    weights: &Weights<T>,
    split: Split,
    scratch: &mut [T],
) {
    let fine = fine.system(weights);
    let LevelMut {
        grid,
        state,
        v0,
        a,
        b,
        c,
        d,
        table,
        ..
    } = coarse;
    let (grid, [a0, a1, a2], [c0, c1, c2]) = (
        *grid,
        a.each_mut().map(|c| &mut **c),
        c.each_mut().map(|c| &mut **c),
    );
    let none: &[T] = &[];
    let coarse = System {
        grid,
        rhs: Rhs {
            scale: T::ONE,
            a: [none; 3],
            b: none,
            c: [none; 3],
            d: none,
        },
        v: view(&state.v),
        w: view(&state.w),
        p: state.p,
        pbar: state.pbar,
        v0: view(v0),
        table,
        ..fine
    };
    let sides = [a0, a1, a2, c0, c1, c2, &mut **b, &mut **d];
    let waiting_len = waiting_len::<S>(fine.grid, weights.slots);
    if split == Split::Slabs {
        for_slabs(
            exec,
            split.slabs(grid, exec.threads(), LEAST),
            sides,
            scratch,
            |task| {
                let (waiting, scratch) = task.scratch.split_at_mut(waiting_len);
                Slab {
                    tables,
                    fine,
                    coarse,
                    planes: task.rows,
                    sides: task.fields,
                    waiting,
                    scratch,
                }
                .collect::<S>(&Serial);
            },
        );
    } else {
        let (waiting, scratch) = scratch.split_at_mut(waiting_len);
        Slab {
            tables,
            fine,
            coarse,
            planes: 0..grid.planes(),
            sides,
            waiting,
            scratch,
        }
        .collect::<S>(exec);
    }
}

/// Some coarse planes, with the residuals of some fine planes that wait until the coarse planes among them have collected theirs.
struct Slab<'a, T> {
    tables: &'a Tables<'a, T>,
    fine: System<'a, T>,
    /// Without right-hand sides.
    coarse: System<'a, T>,
    planes: Range<usize>,
    /// The right-hand sides of these planes: a, c by component, b, d.
    sides: [&'a mut [T]; 8],
    waiting: &'a mut [T],
    scratch: &'a mut [T],
}

impl<T: Real> Slab<'_, T> {
    fn collect<S: Space>(&mut self, exec: &dyn Exec) {
        let Self {
            tables,
            fine,
            coarse,
            planes,
            sides,
            waiting,
            scratch,
        } = self;
        let (grid, rows_per_plane) = (coarse.grid, coarse.grid.rows_per_plane());
        for block in Block::all(fine.grid, fine.slots) {
            let coarse_block = Block { grid, ..block };
            let (a_row, a_plane) = (residual::rows_of::<S>() * block.len(), fine.grid.rows_per_plane());
            let room = NEAR.min(fine.grid.planes());
            let waiting = &mut waiting[..room * a_plane * a_row];
            let (mut start, mut known) = (planes.start, isize::MIN);
            while start < planes.end {
                let window = Window::new(tables, fine.grid, grid, start..planes.end, room);
                let fresh = window.fresh(known);
                let buffers = RowBuffers::fields([&mut *waiting]).with_scratch(scratch);
                for_rows_across(
                    exec,
                    room * a_plane,
                    a_plane,
                    window.places(&fresh),
                    buffers,
                    |task| {
                        let [numbers] = task.fields;
                        let [place, in_plane] = fine.grid.plane_of(task.row);
                        let row = window.plane_at(&fresh, place) * a_plane + in_plane;
                        residual::of_block::<T, S>(
                            fine,
                            &block,
                            row,
                            &mut residual::Rows::new::<S>(block.len(), numbers),
                            task.scratch,
                        );
                    },
                );
                let waiting = Waiting {
                    numbers: waiting,
                    window: &window,
                    block: &block,
                };
                let buffers =
                    RowBuffers::fields(sides.each_mut().map(|field| &mut **field)).with_scratch(scratch);
                let within = Planes::of(start - planes.start..window.end - planes.start);
                for_rows_across(
                    exec,
                    planes.len() * rows_per_plane,
                    rows_per_plane,
                    within,
                    buffers,
                    |mut task| {
                        let row = planes.start * rows_per_plane + task.row;
                        let mut out = task.fields.each_mut().map(|field| {
                            if field.is_empty() {
                                &mut [][..]
                            } else {
                                &mut field[coarse_block.span_in_row()]
                            }
                        });
                        waiting.collect::<S>(tables, grid, row, task.scratch, &mut out);
                        let (numbers, work) = task
                            .scratch
                            .split_at_mut(residual::rows_of::<S>() * coarse_block.len());
                        let mut minus_left = residual::Rows::new::<S>(coarse_block.len(), numbers);
                        residual::of_block::<T, S>(coarse, &coarse_block, row, &mut minus_left, work);
                        for (out, minus_left) in out.into_iter().zip(minus_left.list()) {
                            rows::sub(out, minus_left);
                        }
                    },
                );
                (start, known) = (window.end, window.fine.end);
            }
        }
    }
}

/// The fine planes that some coarse planes collect from, one after the other, in a ring of places; those before plane 0 and behind the last are
/// on the other side of a periodic axis.
struct Window {
    /// Behind the last coarse plane.
    end: usize,
    fine: Range<isize>,
    /// Fine planes in all.
    planes: usize,
    /// Places of the ring.
    room: usize,
}

impl Window {
    /// As many of these coarse planes, from the first on, as need no more than `room` fine ones, but one of them at least.
    fn new<T: Real>(
        tables: &Tables<'_, T>,
        fine: &Grid,
        coarse: &Grid,
        coarse_planes: Range<usize>,
        room: usize,
    ) -> Self {
        let (planes, start) = (fine.planes(), coarse_planes.start);
        let centre = |plane: usize| plane * planes / coarse.planes();
        let mut window = Self {
            end: start,
            fine: 0..0,
            planes,
            room,
        };
        let (mut low, mut high) = (isize::MAX, isize::MIN);
        while window.end < coarse_planes.end {
            for (plane, _) in near(tables, fine.dims - 1, window.end) {
                // Steps from the middle of its coarse plane, the shorter way around.
                let steps = ((plane + planes + planes / 2 - centre(window.end)) % planes) as isize
                    - (planes / 2) as isize;
                let from_start = steps + (centre(window.end) - centre(start)) as isize;
                (low, high) = (low.min(from_start), high.max(from_start));
            }
            let count = planes.min((high - low + 1) as usize);
            if !window.fine.is_empty() && count > room {
                break;
            }
            let first = centre(start) as isize + low;
            window = Self {
                end: window.end + 1,
                fine: first..first + count as isize,
                ..window
            };
        }
        debug_assert!(window.fine.len() <= room);
        window
    }

    /// Those that are not in the ring yet, where the last ones before `known` are.
    fn fresh(&self, known: isize) -> Range<isize> {
        known.max(self.fine.start).min(self.fine.end)..self.fine.end
    }

    /// The places of some of them.
    fn places(&self, fine: &Range<isize>) -> Planes {
        Planes {
            count: fine.len(),
            first: around(fine.start, self.room),
            size: self.room,
            offset: 0,
        }
    }

    /// Which of some of them is at a place.
    fn plane_at(&self, fine: &Range<isize>, place: usize) -> usize {
        around(
            fine.start + around(place as isize - fine.start, self.room) as isize,
            self.planes,
        )
    }

    /// The place of a fine plane.
    fn place(&self, plane: usize) -> usize {
        around(
            self.fine.start + around(plane as isize - self.fine.start, self.planes) as isize,
            self.room,
        )
    }
}

/// Number `i` of a circle of `count`.
fn around(i: isize, count: usize) -> usize {
    i.rem_euclid(count as isize) as usize
}

/// A fine row near a coarse one along one axis, with the weights of cells, of faces across and of faces along the axis.
type Near<T> = heapless::Vec<(usize, [T; 3]), NEAR>;

const KINDS: [Transfer; 3] = [
    Transfer::RestrictCell,
    Transfer::CollectCell,
    Transfer::CollectFace,
];

fn near<T: Real>(tables: &Tables<'_, T>, axis: usize, i: usize) -> Near<T> {
    let mut list: Near<T> = heapless::Vec::new();
    for (kind, &transfer) in KINDS.iter().enumerate() {
        for (at, weight) in tables.taps(axis, transfer, i) {
            match list.iter_mut().find(|(have, _)| *have == at) {
                Some((_, weights)) => weights[kind] = weight,
                None => {
                    let mut weights = [T::ZERO; 3];
                    weights[kind] = weight;
                    let pushed = list.push((at, weights));
                    debug_assert!(pushed.is_ok());
                }
            }
        }
    }
    list
}

/// The residuals of the rows of some fine planes.
struct Waiting<'a, T> {
    /// [`residual::Rows`] of the block for each row.
    numbers: &'a [T],
    window: &'a Window,
    block: &'a Block<'a>,
}

impl<T: Real> Waiting<'_, T> {
    /// `out` = the restricted residuals of one coarse row: a, c by component, b, d. `scratch` holds the rows of a block.
    fn collect<S: Space>(
        &self,
        tables: &Tables<'_, T>,
        coarse: &Grid,
        row: usize,
        scratch: &mut [T],
        out: &mut [&mut [T]; 8],
    ) {
        let (fine, [y, z]) = (self.block.grid, coarse.row_at(row));
        let mut sums = residual::Rows::new::<S>(self.block.len(), scratch);
        let mut sums = sums.list();
        sums.iter_mut().for_each(|row| row.fill(T::ZERO));
        let one: Near<T> = core::iter::once((0, [T::ONE; 3])).collect();
        let in_z = if S::DIM == 3 { near(tables, 2, z) } else { one };
        for (fine_z, weight_z) in &in_z {
            for (fine_y, weight_y) in near(tables, 1, y) {
                let values = self.row::<S>(fine.row(fine_y, *fine_z));
                for (index, sum) in sums.iter_mut().enumerate().filter(|(_, sum)| !sum.is_empty()) {
                    let kind = |axis: usize| match place_of(index) {
                        Place::Cell => 0,
                        Place::Face(own) => 1 + usize::from(own == axis),
                    };
                    let weight = weight_y[kind(1)] * weight_z[kind(2)];
                    if weight != T::ZERO {
                        rows::add_scaled(sum, weight, values[index]);
                    }
                }
            }
        }
        for (index, (sum, out)) in sums.into_iter().zip(out.iter_mut()).enumerate() {
            out.fill(T::ZERO);
            if !sum.is_empty() {
                let transfer = along(
                    place_of(index),
                    0,
                    if index < 6 {
                        Transfer::CollectCell
                    } else {
                        Transfer::RestrictCell
                    },
                    Transfer::CollectFace,
                );
                tables.add_along_x(transfer, sum, fine.n[0], out, coarse.n[0]);
            }
        }
    }

    /// The residuals of a fine row, in the order of [`residual::Rows::list`].
    fn row<S: Space>(&self, row: usize) -> [&[T]; 8] {
        let (a_plane, len) = (self.block.grid.rows_per_plane(), self.block.len());
        let [plane, in_plane] = self.block.grid.plane_of(row);
        let place = self.window.place(plane) * a_plane + in_plane;
        residual::Rows::written::<S>(len, &self.numbers[place * residual::rows_of::<S>() * len..])
    }
}
