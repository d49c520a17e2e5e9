//! The force that produces a given flow (mathematics section 6): w_k = v_k - v_{k-1} + Adv(v_k) + grad p_k; its derivative,
//! the adjoint of that, and the second derivative of its square.

pub mod time_line;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Block, Vector, VectorMut, rows, subtract_next, subtract_previous};
use crate::grid::{Grid, Space};
use crate::operators::divergence::add_gradient;
use crate::operators::plaquette::{self, Adjoint, Advection, Derivative, accumulate};
use crate::real::Real;

/// Numbers of scratch a thread needs for [`from_velocity`].
#[must_use]
pub fn scratch_per_thread(grid: &Grid, slots: usize) -> usize {
    plaquette::SCRATCH_ROWS * Block::largest(grid.n[0], slots)
}

/// `w_k = v_k - v_{k-1} + Adv(v_k) + grad p_k` in every slot; without the gradient where `p` is empty.
pub fn from_velocity<T: Real, S: Space>(
    exec: &dyn Exec,
    grid: &Grid,
    slots: usize,
    v: Vector<'_, T>,
    v0: Vector<'_, T>,
    p: &[T],
    w: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: w, sums: &mut [], scratch }, |task| {
        let (row, mut w) = (task.row, task.fields);
        for block in Block::all(grid, slots) {
            let mut parts = parts_of(&mut w, &block);
            accumulate::<T, S, _>(&block, row, Advection, v, [&[]; 3], &mut parts, task.scratch);
            for (axis, part) in parts.iter_mut().enumerate().take(S::DIM) {
                rows::add(part, block.of(v[axis], row));
                subtract_previous(&block, row, v[axis], v0[axis], part);
                if !p.is_empty() {
                    add_gradient(&block, row, axis, T::ONE, p, part, &mut task.scratch[..block.len()]);
                }
            }
        }
    });
}

/// `out_k = d_k - d_{k-1} + J(v_k) d_k` in every slot, d_0 = 0: the derivative of [`from_velocity`] along d, without a gradient.
pub fn apply_derivative<T: Real, S: Space>(
    exec: &dyn Exec,
    grid: &Grid,
    slots: usize,
    v: Vector<'_, T>,
    d: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: out, sums: &mut [], scratch }, |task| {
        let (row, mut out) = (task.row, task.fields);
        for block in Block::all(grid, slots) {
            let mut parts = parts_of(&mut out, &block);
            accumulate::<T, S, _>(&block, row, Derivative, v, d, &mut parts, task.scratch);
            for (axis, part) in parts.iter_mut().enumerate().take(S::DIM) {
                rows::add(part, block.of(d[axis], row));
                subtract_previous(&block, row, d[axis], &[], part);
            }
        }
    });
}

/// `out_k = w_k - w_{k+1} + J(v_k)^T w_k` in every slot, w_{T+1} = 0: the derivative of 1/2 sum |w(v)|^2, not projected yet.
///
/// It is the adjoint of [`apply_derivative`], applied to w.
pub fn apply_adjoint<T: Real, S: Space>(
    exec: &dyn Exec,
    grid: &Grid,
    slots: usize,
    v: Vector<'_, T>,
    w: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: out, sums: &mut [], scratch }, |task| {
        let (row, mut out) = (task.row, task.fields);
        for block in Block::all(grid, slots) {
            let mut parts = parts_of(&mut out, &block);
            accumulate::<T, S, _>(&block, row, Adjoint, v, w, &mut parts, task.scratch);
            for (axis, part) in parts.iter_mut().enumerate().take(S::DIM) {
                rows::add(part, block.of(w[axis], row));
                subtract_next(&block, row, w[axis], part);
            }
        }
    });
}

/// `out_k += J(d_k)^T w_k` in every slot: with the derivative and its adjoint, D^T D d + J(d)^T w is the second derivative of
/// 1/2 sum |w(v)|^2 along d, since J is linear in v.
pub fn add_curvature<T: Real, S: Space>(
    exec: &dyn Exec,
    grid: &Grid,
    slots: usize,
    d: Vector<'_, T>,
    w: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: out, sums: &mut [], scratch }, |task| {
        let mut out = task.fields;
        for block in Block::all(grid, slots) {
            let span = block.span_in_row();
            let mut parts = out.each_mut().map(|out| if out.is_empty() { &mut [][..] } else { &mut out[span.clone()] });
            accumulate::<T, S, _>(&block, task.row, Adjoint, d, w, &mut parts, task.scratch);
        }
    });
}

/// The block's part of a row of each component, filled with 0.
fn parts_of<'a, T: Real>(fields: &'a mut [&mut [T]; 3], block: &Block<'_>) -> [&'a mut [T]; 3] {
    let span = block.span_in_row();
    let mut parts = fields.each_mut().map(|field| if field.is_empty() { &mut [][..] } else { &mut field[span.clone()] });
    parts.iter_mut().for_each(|part| part.fill(T::ZERO));
    parts
}
