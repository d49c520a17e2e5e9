//! One slot of Poisson's problem by the eigenvectors of the box.

use crate::exec::Exec;
use crate::field::transform;
use crate::field::turned::Turned;
use crate::grid::Grid;
use crate::grid::spectrum::Spectrum;
use crate::real::Real;
use crate::simd::multiversion;
use core::ops::Range;

/// `field`, a right-hand side at the cells of one slot, becomes the q of mean 0 with div grad q = right-hand side less its mean.
pub fn solve<T: Real>(
    exec: &dyn Exec,
    (grid, spectrum): (&Grid, &Spectrum<'_, T>),
    field: &mut [T],
    scratch: &mut [T],
) {
    transform::multiply(exec, (grid, spectrum), field, scratch, inverse(grid, spectrum));
}

/// [`solve`] for all `fields` of a box that ranks share, slot by slot.
pub fn solve_turned<T: Real>(
    exec: &dyn Exec,
    (grid, spectrum): (&Grid, &Spectrum<'_, T>),
    fields: &mut [T],
    turned: &mut Turned<'_, T>,
    scratch: &mut [T],
) {
    let whole = grid.whole();
    let symbol = inverse(&whole, spectrum);
    turned.multiply((exec, exec), (grid, spectrum), fields, scratch, symbol);
}

/// What coefficients are multiplied by in a row of a whole box.
fn inverse<T: Real>(
    grid: &Grid,
    spectrum: &Spectrum<'_, T>,
) -> impl Fn(usize, Range<usize>, &[T], &mut [T]) + Sync {
    move |row, span, coefficients, out| {
        let at = grid.row_at(row);
        let across = (1..grid.dims).fold(T::ZERO, |sum, axis| {
            sum + spectrum.axes[axis].eigenvalues[at[axis - 1]]
        });
        divide(coefficients, &spectrum.axes[0].eigenvalues[span], across, out);
    }
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
