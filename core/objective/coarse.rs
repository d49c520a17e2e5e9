//! What nested starts share (mathematics section 6): the same scene on a grid of half as many cells an axis.
//!
//! The same r and K (all sums shrink alike), densities restricted by means, flows by means that keep them free of
//! divergence, one filter fewer so that the widest stays as wide; flows come back by the prolongation of STFAS. ADMM and L-BFGS
//! keep dt and N; the direct method takes two steps for one where it can.

use crate::exec::{Capped, Exec, RowBuffers, for_rows};
use crate::field::borders;
use crate::field::transfer::{Move, Place, Placed};
use crate::field::{Block, Vector, VectorMut, rows};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::grid::taps::Transfer;
use crate::objective::script::Script;
use crate::real::Real;

/// `threads`, then ever half as many, down to 1: what a coarse solve tries to run on.
pub fn halvings(threads: usize) -> impl Iterator<Item = usize> + Clone {
    core::iter::successors(Some(threads), |&threads| (threads > 1).then_some(threads / 2))
}

/// The smallest grid of a nested start has this many cells along its longest axis at least.
fn smallest(dims: usize) -> usize {
    if dims == 2 { 16 } else { 8 }
}

/// Whether a scene on grid `fine` of a hierarchy is to begin on the next one, `coarse`: where every axis halves exactly and
/// the coarse grid is not too small.
#[must_use]
pub fn begins_on(fine: &Grid, coarse: &Grid) -> bool {
    let [fine_cells, cells] = [fine, coarse].map(|grid| grid.whole().inside().map(|inside| inside.len()));
    large_enough(coarse) && (0..fine.dims).all(|axis| fine_cells[axis] == 2 * cells[axis])
}

/// Whether a scene may begin on `grid`: it has enough cells along its longest axis, and half of that along every other.
#[must_use]
pub fn large_enough(grid: &Grid) -> bool {
    let (least, cells) = (
        smallest(grid.dims),
        grid.whole().inside().map(|inside| inside.len()),
    );
    let mut along = cells.iter().take(grid.dims);
    along.clone().all(|&n| n >= least / 2) && along.any(|&n| n >= least)
}

/// The data of a scene on one grid.
pub struct Scene<'a, T> {
    /// rho_0.
    pub source: &'a [T],
    /// v_0.
    pub initial: Vector<'a, T>,
    /// What is given for its steps.
    pub script: &'a Script<'a, T>,
}

/// The data of the scene on the next coarser grid, to write; of the script the fields alone, since its lists are the same.
pub struct SceneMut<'a, T> {
    /// rho_0.
    pub source: &'a mut [T],
    /// v_0.
    pub initial: VectorMut<'a, T>,
    /// The fields of the script, one after the other.
    pub fields: &'a mut [T],
}

/// Planes, or rows, on either side that a rank needs copies of where scenes pass between grids of any length: one more than where every axis halves.
pub const REACH: usize = 3;

/// Numbers of scratch that one thread needs to pass fields of so many slots to and from the grids below `fine`.
#[must_use]
pub fn scratch_per_thread(fine: &Grid, slots: usize) -> usize {
    Block::largest(fine.n[0], slots)
}

/// The scene on grid `level + 1` from that on grid `level`.
pub fn restrict<T: Real>(
    exec: &dyn Exec,
    levels: &Levels<'_, T>,
    level: usize,
    fine: &Scene<'_, T>,
    coarse: SceneMut<'_, T>,
    scratch: &mut [T],
) {
    let (source, target) = (&levels.grids[level], &levels.grids[level + 1]);
    let step = Move {
        tables: &levels.tables[level],
        source,
        target,
        cell: Transfer::RestrictCell,
        face: Transfer::RestrictFace,
    };
    for (index, field) in coarse.fields.chunks_exact_mut(target.cells()).enumerate() {
        let from = fine.script.field(index, source.cells());
        pass(exec, step, Place::Cell, from, field, 1, scratch);
    }
    pass(exec, step, Place::Cell, fine.source, coarse.source, 1, scratch);
    let components = fine.initial.into_iter().zip(coarse.initial);
    for (axis, (from, to)) in components.enumerate().take(source.dims) {
        pass(exec, step, Place::Face(axis), from, to, 1, scratch);
    }
}

/// The flow on grid `level` from that on grid `level + 1`; its divergence is not zero.
pub fn prolong<T: Real>(
    exec: &dyn Exec,
    levels: &Levels<'_, T>,
    level: usize,
    slots: usize,
    coarse: Vector<'_, T>,
    fine: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let (source, target) = (&levels.grids[level + 1], &levels.grids[level]);
    let step = Move {
        tables: &levels.tables[level],
        source,
        target,
        cell: Transfer::ProlongCell,
        face: Transfer::ProlongFace,
    };
    for (axis, (from, to)) in coarse.into_iter().zip(fine).enumerate().take(source.dims) {
        pass(exec, step, Place::Face(axis), from, to, slots, scratch);
    }
}

/// The flow at all slots, 2 `few` + 1 of them, from that of the same grid at steps twice as long: linear in time between the middles
/// of the long steps, of which `initial` fills the first, constant after the last, and halved, as a step is half as long.
pub fn refine_time<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    few: usize,
    initial: Vector<'_, T>,
    coarse: Vector<'_, T>,
    fine: VectorMut<'_, T>,
) {
    let n = grid.n[0];
    let (near, far) = (T::from_f64(0.5 * 0.75), T::from_f64(0.5 * 0.25));
    for_rows(exec, grid.rows(), RowBuffers::fields(fine), |task| {
        for (axis, fine) in task.fields.into_iter().enumerate().take(grid.dims) {
            let long = |step: usize| match step.min(few).checked_sub(1) {
                None => &initial[axis][task.row * n..][..n],
                Some(slot) => &coarse[axis][(task.row * few + slot) * n..][..n],
            };
            for (slot, out) in fine.chunks_exact_mut(n).enumerate() {
                let step = slot.div_ceil(2);
                rows::scale(out, near, long(step));
                rows::add_scaled(out, far, long(if slot % 2 == 0 { step + 1 } else { step - 1 }));
            }
        }
    });
}

/// `to` = `from` passed to the other grid, on as many threads as `scratch` is enough for.
fn pass<T: Real>(
    exec: &dyn Exec,
    step: Move<'_, T>,
    place: Place,
    from: &[T],
    to: &mut [T],
    slots: usize,
    scratch: &mut [T],
) {
    let field = Placed { place, values: from };
    let grid = step.target;
    let wide = step.source.n[0].max(step.target.n[0]);
    let (count, row) = (Block::slots_per_block(wide, slots), Block::largest(wide, slots));
    let exec = &Capped::new(exec, scratch.len() / row);
    let scratch = &mut scratch[..exec.threads() * row];
    for_rows(
        exec,
        grid.rows(),
        RowBuffers::fields([&mut *to]).with_scratch(scratch),
        |task| {
            let [out] = task.fields;
            out.fill(T::ZERO);
            for first in (0..slots).step_by(count) {
                let block = Block {
                    grid,
                    slots,
                    first,
                    count: count.min(slots - first),
                };
                let out = &mut out[block.span_in_row()];
                step.add_row(field, &block, task.row, T::ONE, out, task.scratch);
            }
        },
    );
    borders::settle(exec, [step.source, step.target], place, to);
}
