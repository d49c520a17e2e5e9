//! The rows that a face flux reads, along any axis.

use crate::field::Vector;
use crate::grid::{Grid, Side};
use crate::problem::Scheme;
use crate::real::Real;

/// Extra numbers of a row with its neighbours along x.
pub const HALO: usize = 4;
/// Rows of scratch of a task: two fields of cells and the faces along x with their neighbours, and a row of zeros.
pub const SCRATCH_ROWS: usize = 4;

/// Interpolation to a face from upstream, rho_f = w[0] downstream + w[1] upstream - w[2] next upstream (Leonard 1979).
#[must_use]
pub fn weights<T: Real>(scheme: Scheme) -> [T; 3] {
    match scheme {
        Scheme::Central => [0.5, 0.5, 0.0],
        _ => [0.375, 0.75, 0.125],
    }
    .map(T::from_f64)
}

/// A row of cells and the two next ones on either side along an axis: offsets -2 .. 2.
pub type Cells<'a, T> = [&'a [T]; 5];

/// The rows of a field along all axes.
pub type AllCells<'a, T> = [Cells<'a, T>; 3];

/// The faces -1, 0, 1, 2 along an axis: face 0 is the low and face 1 the high face of the row's cells.
pub type Faces<'a, T> = [&'a [T]; 4];

/// Rows next to `row` at an offset along y or z; at a wall the last one stands for those beyond.
fn row_at(grid: &Grid, row: usize, axis: usize, offset: isize) -> usize {
    let side = if offset < 0 { Side::Low } else { Side::High };
    (0..offset.unsigned_abs()).fold(row, |row, _| grid.neighbour(row, axis, side).unwrap_or(row))
}

/// The rows of `field` around `row`; `halo` receives the row with its neighbours along x.
pub fn cells<'a, T: Real>(grid: &Grid, row: usize, field: &'a [T], halo: &'a mut [T]) -> AllCells<'a, T> {
    let n = grid.n[0];
    let of = |row: usize| &field[row * n..(row + 1) * n];
    let here = of(row);
    halo[2..n + 2].copy_from_slice(here);
    for (at, from) in [(0, n - 2), (1, n - 1)] {
        halo[at] = if grid.periodic[0] { here[from] } else { here[0] };
        halo[n + 2 + at] = if grid.periodic[0] { here[at] } else { here[n - 1] };
    }
    let halo = &*halo;
    let along = |axis: usize| core::array::from_fn(|i| if axis < grid.dims { of(row_at(grid, row, axis, i as isize - 2)) } else { here });
    [core::array::from_fn(|i| &halo[i..i + n]), along(1), along(2)]
}

/// The faces around `row` along all axes; `halo` receives those along x, `zeros` stands for walls.
pub fn faces<'a, T: Real>(grid: &Grid, row: usize, v: Vector<'a, T>, halo: &'a mut [T], zeros: &'a [T]) -> [Faces<'a, T>; 3] {
    let n = grid.n[0];
    let here = &v[0][row * n..(row + 1) * n];
    let wrap = |x: T| if grid.periodic[0] { x } else { T::ZERO };
    halo[0] = wrap(here[n - 1]);
    halo[1..=n].copy_from_slice(here);
    halo[n + 1] = wrap(here[0]);
    halo[n + 2] = wrap(here[1]);
    let halo = &*halo;
    let along = |axis: usize| -> Faces<'a, T> {
        if axis >= grid.dims {
            return [zeros; 4];
        }
        let of = |row: Option<usize>| row.map_or(zeros, |row| &v[axis][row * n..(row + 1) * n]);
        let high = grid.neighbour(row, axis, Side::High);
        [of(grid.neighbour(row, axis, Side::Low)), of(Some(row)), of(high), of(high.and_then(|row| grid.neighbour(row, axis, Side::High)))]
    };
    [core::array::from_fn(|i| &halo[i..i + n]), along(1), along(2)]
}
