//! One slot of Poisson's problem by the eigenvectors of all axes of the box but the first, along which it is solved by [recursion](super::recursion).

use super::recursion::solve_rows;
use crate::exec::Exec;
use crate::field::transform;
use crate::field::turned::Turned;
use crate::grid::Grid;
use crate::grid::spectrum::Spectrum;
use crate::real::Real;

/// `field`, a right-hand side at the cells of one slot, becomes the q of mean 0 with div grad q = right-hand side less its mean.
pub fn solve<T: Real>(
    exec: &dyn Exec,
    (grid, spectrum): (&Grid, &Spectrum<'_, T>),
    field: &mut [T],
    scratch: &mut [T],
) {
    transform::across(
        exec,
        (grid, spectrum),
        field,
        scratch,
        |exec, of, rows, scratch| {
            solve_rows(exec, (grid, spectrum), of, rows, scratch);
        },
    );
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
    turned.across(
        (exec, exec),
        (grid, spectrum),
        fields,
        scratch,
        |exec, of, rows, scratch| {
            solve_rows(exec, (&whole, spectrum), of, rows, scratch);
        },
    );
}
