//! One pass of the smoother: all cells of one colour, each solved from the state before the pass.

use super::colours::Colours;
use super::level::System;
use super::local;
use crate::exec::{Exec, RowBuffers, Slabs, for_rows};
use crate::grid::{Grid, Space};
use crate::real::Real;
use core::ops::Range;

/// Values of the changes of one row of cells.
pub(super) fn row_changes<S: Space>(grid: &Grid, slots: usize) -> usize {
    slots * local::changes::<S>() * grid.n[0].div_ceil(2)
}

/// Values of the changes of one plane of cells.
pub(super) fn plane_changes<S: Space>(grid: &Grid, slots: usize) -> usize {
    row_changes::<S>(grid, slots) * grid.rows_per_plane()
}

/// One pass over a level.
pub(super) struct Pass<'a, T> {
    /// The equations, but for the unknowns.
    pub(super) given: System<'a, T>,
    pub(super) slabs: Slabs,
    pub(super) colours: Colours,
    /// Which of the passes.
    pub(super) number: usize,
    /// The most cells that a thread solves side by side.
    pub(super) lanes: usize,
}

impl<T: Real> Pass<'_, T> {
    /// Solves the cells of the `count` planes at the edges of slabs.
    pub(super) fn solve_edges<S: Space>(
        &self,
        exec: &dyn Exec,
        state: [&[T]; 8],
        count: usize,
        edges: &mut [T],
        scratch: &mut [T],
    ) {
        let grid = self.given.grid;
        let a_plane = grid.rows_per_plane();
        let system = self.given.of_rows(0..grid.rows(), state);
        let rows = count * a_plane;
        let buffers = RowBuffers::fields([edges]).with_scratch(scratch);
        for_rows(exec, rows, buffers, |task| {
            let [edge, in_plane] = grid.plane_of(task.row);
            let [changes] = task.fields;
            let Range { start, end } = self.slabs.rows_of(edge / 2);
            let plane = if edge % 2 == 0 { start } else { end - 1 };
            self.solve_row::<S>(&system, plane * a_plane + in_plane, changes, task.scratch);
        });
    }

    /// Solves the cells of one row.
    pub(super) fn solve_row<S: Space>(
        &self,
        system: &System<'_, T>,
        row: usize,
        out: &mut [T],
        scratch: &mut [T],
    ) {
        let cells = self.colours.cells(system.grid, self.number, row);
        if cells.count > 0 {
            let half = system.grid.n[0].div_ceil(2);
            let changes = local::Changes { out, half };
            local::solve_row::<T, S>(system, row, cells, self.lanes, scratch, changes);
        }
    }

    /// The number of a plane among those at the edges of slabs, if it is one.
    pub(super) fn edge(&self, plane: usize) -> Option<usize> {
        let slab = self.slabs.slab_of(plane);
        let Range { start, end } = self.slabs.rows_of(slab);
        if plane == start {
            Some(2 * slab)
        } else {
            (plane + 1 == end).then_some(2 * slab + 1)
        }
    }
}
