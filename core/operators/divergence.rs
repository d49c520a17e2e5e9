//! Divergence at cells and gradient at faces (mathematics section 1), row by row: grad = -div^T.

use crate::field::{Block, Vector, rows};
use crate::grid::Side;
use crate::real::Real;

/// `out += s div v` at the cells of `row`: the sum over axes of (v[high face] - v[low face]) / h. `shifted` is a row of scratch.
pub fn add_divergence<T: Real>(block: &Block<'_>, row: usize, s: T, v: Vector<'_, T>, out: &mut [T], shifted: &mut [T]) {
    let grid = block.grid;
    for axis in 0..grid.dims {
        let s = s * T::from_f64(1.0 / grid.h[axis]);
        let low = block.of(v[axis], row);
        if axis == 0 {
            rows::shift_high(shifted, low, grid.n[0], grid.periodic[0]);
            rows::add_difference(out, s, shifted, low);
        } else {
            match grid.neighbour(row, axis, Side::High) {
                Some(next) => rows::add_difference(out, s, block.of(v[axis], next), low),
                None => rows::add_scaled(out, -s, low),
            }
        }
    }
}

/// `out += s (p[high cell] - p[low cell]) / h` at the faces of `row` along `axis`, 0 on walls. `shifted` is a row of scratch.
pub fn add_gradient<T: Real>(block: &Block<'_>, row: usize, axis: usize, s: T, p: &[T], out: &mut [T], shifted: &mut [T]) {
    let grid = block.grid;
    let s = s * T::from_f64(1.0 / grid.h[axis]);
    let high = block.of(p, row);
    if axis == 0 {
        rows::shift_low(shifted, high, grid.n[0], grid.periodic[0]);
        if !grid.periodic[0] {
            shifted.iter_mut().step_by(grid.n[0]).zip(high.iter().step_by(grid.n[0])).for_each(|(s, &h)| *s = h);
        }
        rows::add_difference(out, s, high, shifted);
    } else if let Some(below) = grid.neighbour(row, axis, Side::Low) {
        rows::add_difference(out, s, high, block.of(p, below));
    }
}
