//! One slot of Poisson's problem by the eigenvectors of the box.

use crate::field::transform;
use crate::grid::Grid;
use crate::grid::spectrum::Spectrum;
use crate::real::Real;
use crate::simd::multiversion;

/// `field`, a right-hand side at the cells of one slot, becomes the q of mean 0 with div grad q = right-hand side less its mean.
pub fn solve<T: Real>(grid: &Grid, spectrum: &Spectrum<'_, T>, field: &mut [T], scratch: &mut [T]) {
    transform::multiply(grid, spectrum, field, scratch, |row, span, coefficients, out| {
        let at = grid.row_at(row);
        let across = (1..grid.dims).fold(T::ZERO, |sum, axis| {
            sum + spectrum.axes[axis].eigenvalues[at[axis - 1]]
        });
        divide(coefficients, &spectrum.axes[0].eigenvalues[span], across, out);
    });
}

multiversion! {
    /// Coefficients over minus their eigenvalues, `along` the row and `across`; 0 for the mean.
    fn divide[T: Real](coefficients: &[T], along: &[T], across: T, out: &mut [T]) {
        for ((out, &coefficient), &along) in out.iter_mut().zip(coefficients).zip(along) {
            let eigenvalue = along + across;
            *out = if eigenvalue > T::ZERO { -(coefficient / eigenvalue) } else { coefficient * T::ZERO };
        }
    }
}
