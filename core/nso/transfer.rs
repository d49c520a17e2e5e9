//! Between two levels (mathematics section 5): the solution is restricted by means that keep the divergence,
//! residuals by the scaled transpose of the prolongation (cells: by the mean), corrections are prolonged
//! linearly.

use super::collect::{Slab, waiting_len};
use super::level::{Coefficients, LevelMut, System, place_of};
use super::params::Split;
use super::residual;
use crate::exec::{Exec, RowBuffers, Serial, for_rows, for_slabs};
use crate::field::transfer::{Move, Place, Placed};
use crate::field::{Block, borders, view};
use crate::grid::solids::{Solids, closed};
use crate::grid::tables::Tables;
use crate::grid::taps::Transfer;
use crate::grid::{Grid, Space};
use crate::real::Real;

/// Planes, or rows, beside its own that a rank needs copies of. A coarse plane of its own collects residuals from up to three fine planes below the rank's, where
/// the axis is odd, since the grids are not dealt out at the same places then. A residual reads one plane further; and on the lowest
/// faces of the copies stands 0.
pub const REACH: usize = 5;
/// The fewest coarse planes of a slab.
const LEAST: usize = 4;

/// Values of scratch for any transfer from `fine`, and for its norm: rows of a block for each thread, and
/// stored residuals, with slabs for each thread too.
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
    let states = FieldsMove {
        step: Move {
            tables,
            source: fine.grid,
            target: coarse.grid,
            cell: Transfer::RestrictCell,
            face: Transfer::RestrictFace,
        },
        solids: coarse.solids,
        slots,
        factor: T::ONE,
        overwrite: true,
    };
    let from = fine.state.fields().map(|field| &*field);
    states.run(exec, from, coarse.state.fields(), scratch);
    let velocities = FieldsMove { slots: 1, ..states };
    velocities.run(
        exec,
        view(&fine.v0),
        coarse.v0.each_mut().map(|c| &mut **c),
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
    let states = FieldsMove {
        step: Move {
            tables,
            source: coarse.grid,
            target: fine.grid,
            cell: Transfer::ProlongCell,
            face: Transfer::ProlongFace,
        },
        solids: fine.solids,
        slots,
        factor: s,
        overwrite: false,
    };
    let from = coarse.state.fields().map(|field| &*field);
    states.run(exec, from, fine.state.fields(), scratch);
}

/// How the fields of a state go from one grid to another.
#[derive(Clone, Copy)]
struct FieldsMove<'a, T> {
    step: Move<'a, T>,
    /// Those of the target, at whose closed faces nothing arrives.
    solids: Solids<'a>,
    slots: usize,
    factor: T,
    /// Whether what the fields hold is overwritten, or added to.
    overwrite: bool,
}

impl<T: Real> FieldsMove<'_, T> {
    /// Moves the first `K` fields of a state; empty ones are left out.
    fn run<const K: usize>(
        &self,
        exec: &dyn Exec,
        from: [&[T]; K],
        mut to: [&mut [T]; K],
        scratch: &mut [T],
    ) {
        let rows = self.step.target.rows();
        let buffers = RowBuffers::fields(to.each_mut().map(|field| &mut **field)).with_scratch(scratch);
        for_rows(exec, rows, buffers, |task| {
            for (index, (&values, out)) in from.iter().zip(task.fields).enumerate() {
                if values.is_empty() {
                    continue;
                }
                if self.overwrite {
                    out.fill(T::ZERO);
                }
                let field = Placed {
                    place: place_of(index),
                    values,
                };
                self.add_row(field, task.row, out, task.scratch);
                if let (Place::Face(axis), true) = (field.place, self.solids.there()) {
                    self.solids
                        .clear(self.step.target.n[0], task.row, closed(axis), out);
                }
            }
        });
        settle(exec, [self.step.source, self.step.target], to);
    }

    /// Adds a field to a row of the target, block by block.
    #[inline]
    fn add_row(&self, field: Placed<'_, T>, row: usize, out: &mut [T], scratch: &mut [T]) {
        let Self {
            step, slots, factor, ..
        } = *self;
        let most = Block::slots_per_block(step.source.n[0].max(step.target.n[0]), slots);
        for first in (0..slots).step_by(most) {
            let block = Block {
                grid: step.target,
                slots,
                first,
                count: most.min(slots - first),
            };
            let out = &mut out[block.span_in_row()];
            step.add_row(field, &block, row, factor, out, scratch);
        }
    }
}

/// The coarse right-hand side: f_coarse(R x) + R(residual), with the coarse solution already R x.
pub fn restrict_residual<T: Real, S: Space>(
    exec: &dyn Exec,
    fine: &LevelMut<'_, T>,
    coarse: &mut LevelMut<'_, T>,
    tables: &Tables<'_, T>,
    coefficients: &Coefficients<T>,
    split: Split,
    scratch: &mut [T],
) {
    let fine = fine.system(coefficients);
    let grid = coarse.grid;
    collect_residual::<T, S>(exec, fine, coarse.sides(coefficients), tables, split, scratch);
    let (_, sides) = coarse.sides(coefficients);
    settle(exec, [fine.grid, grid], sides);
}

/// Brings up to date what other ranks have of fields in the order of a state's.
fn settle<T: Real, const K: usize>(exec: &dyn Exec, grids: [&Grid; 2], fields: [&mut [T]; K]) {
    for (index, field) in fields.into_iter().enumerate() {
        if !field.is_empty() {
            borders::settle(exec, grids, place_of(index), field);
        }
    }
}

/// What this rank makes of the coarse right-hand side.
fn collect_residual<T: Real, S: Space>(
    exec: &dyn Exec,
    fine: System<'_, T>,
    (coarse, sides): (System<'_, T>, [&mut [T]; 8]),
    tables: &Tables<'_, T>,
    split: Split,
    scratch: &mut [T],
) {
    let grid = coarse.grid;
    let waiting_len = waiting_len::<S>(fine.grid, fine.slots);
    if split == Split::Slabs {
        for_slabs(
            exec,
            split.slabs(grid, exec.threads(), LEAST),
            RowBuffers::fields(sides).with_scratch(scratch),
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
