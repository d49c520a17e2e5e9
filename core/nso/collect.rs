//! Collecting residuals on a coarse level: those of fine planes are computed once, and stored until all
//! coarse planes near have collected.

use super::level::{FACES_OF_STATE, System, place_of};
use super::residual;
use super::window::{NEAR, Near, Window, near};
use crate::exec::{Exec, Planes, RowBuffers, for_rows_across};
use crate::field::transfer::{Place, along};
use crate::field::{Block, rows};
use crate::grid::part::made_here;
use crate::grid::tables::Tables;
use crate::grid::taps::Transfer;
use crate::grid::{Grid, Space};
use crate::real::Real;
use core::ops::Range;

/// Values of the residuals that are stored.
pub(super) fn waiting_len<S: Space>(fine: &Grid, slots: usize) -> usize {
    NEAR.min(fine.planes())
        * fine.rows_per_plane()
        * residual::rows_of::<S>()
        * Block::largest(fine.n[0], slots)
}

/// Some coarse planes, and the stored residuals of some fine planes.
pub(super) struct Slab<'a, T> {
    pub(super) tables: &'a Tables<'a, T>,
    pub(super) fine: System<'a, T>,
    /// Without right-hand sides.
    pub(super) coarse: System<'a, T>,
    pub(super) planes: Range<usize>,
    /// The right-hand sides of these planes: a, c by component, b, d.
    pub(super) sides: [&'a mut [T]; 8],
    pub(super) waiting: &'a mut [T],
    pub(super) scratch: &'a mut [T],
}

impl<T: Real> Slab<'_, T> {
    /// `sides` = f_coarse(R x) + R(residual), block of slots after block.
    pub(super) fn collect<S: Space>(&mut self, exec: &dyn Exec) {
        let room = NEAR.min(self.fine.grid.planes());
        let made = made_here(self.fine.grid, self.coarse.grid);
        let (first, end) = (self.planes.start.max(made.start), self.planes.end.min(made.end));
        for block in Block::all(self.fine.grid, self.fine.slots) {
            let mut start = first;
            let mut known = isize::MIN;
            while start < end {
                let coarse_planes = start..end;
                let window = Window::new(self.tables, self.fine.grid, self.coarse.grid, coarse_planes, room);
                self.store_residuals::<S>(exec, &block, &window, known);
                self.collect_planes::<S>(exec, &block, &window, start);
                (start, known) = (window.end, window.fine.end);
            }
        }
    }

    /// Stores the residuals of the fine planes that are new in a window.
    fn store_residuals<S: Space>(
        &mut self,
        exec: &dyn Exec,
        block: &Block<'_>,
        window: &Window,
        known: isize,
    ) {
        let fine = &self.fine;
        let a_plane = fine.grid.rows_per_plane();
        let rows = window.room * a_plane;
        let fresh = window.fresh(known);
        let buffers =
            RowBuffers::fields([&mut self.waiting[..rows * residual::rows_of::<S>() * block.len()]])
                .with_scratch(&mut *self.scratch);
        for_rows_across(exec, rows, a_plane, window.places(&fresh), buffers, |task| {
            let [values] = task.fields;
            let [place, in_plane] = fine.grid.plane_of(task.row);
            let row = window.plane_at(&fresh, place) * a_plane + in_plane;
            let mut out = residual::Rows::new::<S>(block.len(), values);
            residual::of_block::<T, S>(fine, block, row, &mut out, task.scratch);
        });
    }

    /// The right-hand sides of the coarse planes from `start` to the end of a window.
    fn collect_planes<S: Space>(
        &mut self,
        exec: &dyn Exec,
        block: &Block<'_>,
        window: &Window,
        start: usize,
    ) {
        let Self {
            tables,
            coarse,
            planes,
            sides,
            waiting,
            scratch,
            ..
        } = self;
        let grid = coarse.grid;
        let a_plane = grid.rows_per_plane();
        let coarse_block = Block { grid, ..*block };
        let waiting = Waiting {
            values: waiting,
            window,
            block,
        };
        let buffers = RowBuffers::fields(sides.each_mut().map(|field| &mut **field)).with_scratch(scratch);
        let within = Planes::of(start - planes.start..window.end - planes.start);
        for_rows_across(
            exec,
            planes.len() * a_plane,
            a_plane,
            within,
            buffers,
            |mut task| {
                let row = planes.start * a_plane + task.row;
                let mut out = task.fields.each_mut().map(|field| {
                    if field.is_empty() {
                        &mut [][..]
                    } else {
                        &mut field[coarse_block.span_in_row()]
                    }
                });
                waiting.collect::<S>(tables, grid, row, task.scratch, &mut out);
                let (values, work) = task
                    .scratch
                    .split_at_mut(residual::rows_of::<S>() * coarse_block.len());
                let mut minus_left = residual::Rows::new::<S>(coarse_block.len(), values);
                residual::of_block::<T, S>(coarse, &coarse_block, row, &mut minus_left, work);
                for (out, minus_left) in out.into_iter().zip(minus_left.list()) {
                    rows::sub(out, minus_left);
                }
            },
        );
    }
}

/// The stored residuals of the fine planes of a window.
struct Waiting<'a, T> {
    /// [`residual::Rows`] of the block for each row.
    values: &'a [T],
    window: &'a Window,
    block: &'a Block<'a>,
}

impl<T: Real> Waiting<'_, T> {
    /// `out` = the restricted residuals of one coarse row: a, c by component, b, d. `scratch` holds the rows
    /// of a block.
    fn collect<S: Space>(
        &self,
        tables: &Tables<'_, T>,
        coarse: &Grid,
        row: usize,
        scratch: &mut [T],
        out: &mut [&mut [T]; 8],
    ) {
        let fine = self.block.grid;
        let [y, z] = coarse.row_at(row);
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
                    if index < FACES_OF_STATE {
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
        let a_plane = self.block.grid.rows_per_plane();
        let len = self.block.len();
        let [plane, in_plane] = self.block.grid.plane_of(row);
        let place = self.window.place(plane) * a_plane + in_plane;
        residual::Rows::written::<S>(len, &self.values[place * residual::rows_of::<S>() * len..])
    }
}
