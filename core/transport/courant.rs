//! The Courant number of a velocity: max over cells of the sum over the cell's faces of |v_f| / (2 h).

use super::kernel::Extremes;
use super::rows::{Rows, Velocity, faces};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::sums;
use crate::grid::Grid;
use crate::grid::halo::HALO;
use crate::grid::stencil::Stencil;
use crate::real::Real;
use crate::simd::{self, vectorised};

/// The largest Courant number of a step of length 1, or NaN when any velocity is not finite. `sums` holds a value a row.
pub fn largest<T: Real>(exec: &dyn Exec, grid: &Grid, velocity: Velocity<'_, T>, sums: &mut [f64]) -> f64 {
    let scales = grid.h.map(|h| T::from_f64(0.5 / h));
    let buffers = RowBuffers::<T, 0>::sums(&mut *sums);
    for_rows(exec, grid.rows(), buffers, move |task| {
        let faces = faces(grid, &Stencil::new(grid, task.row), velocity);
        task.sums[0] = of_row(&faces, grid.n[0], grid.dims, scales);
    });
    sums::most(exec, grid, sums.iter().copied())
}

vectorised! {
    /// The largest Courant number of a row of `n` cells of a box of `dims` axes, `scales` being 1 / (2 h).
    fn of_row[T, V](faces: &Rows<'_, T>, n: usize, dims: usize, scales: [T; 3]) -> f64 {
        let (mut most, mut rest) = (Extremes::<V>::none(), Extremes::<T>::none());
        let i = from::<T, V>(0, n, faces, dims, scales, &mut most);
        from::<T, T>(i, n, faces, dims, scales, &mut rest);
        most.with(rest)
    }
}

/// The kernel of [`of_row`] from cell `i` as far as whole vectors go; returns the first cell that is left.
#[inline(always)]
fn from<T: Real, V: simd::Vector<Elem = T>>(
    mut i: usize,
    n: usize,
    faces: &Rows<'_, T>,
    dims: usize,
    scales: [T; 3],
    most: &mut Extremes<V>,
) -> usize {
    let (x, y) = (faces.own(0, n + HALO - 1), faces.along(1, 0, n));
    let z = if dims > 2 { faces.along(2, 0, n) } else { y };
    while i + V::LANES <= n {
        let mut sum = V::splat(T::ZERO);
        for side in 1..3 {
            let v = V::at(x, i + side);
            sum = sum + V::splat(scales[0]) * v.max(-v);
        }
        for side in 1..3 {
            let v = V::at(y[side], i);
            sum = sum + V::splat(scales[1]) * v.max(-v);
        }
        if dims > 2 {
            for side in 1..3 {
                let v = V::at(z[side], i);
                sum = sum + V::splat(scales[2]) * v.max(-v);
            }
        }
        most.take(sum, sum);
        i += V::LANES;
    }
    i
}
