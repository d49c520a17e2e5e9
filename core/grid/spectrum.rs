//! The eigenvectors of the second difference along an axis: cosines between walls, cosines and sines on a ring.
//!
//! -div grad of the potentials phi_k = cos(pi k (i + 1/2) / n) between walls, or cos and sin of 2 pi m (i + 1/2) / n on a ring, is
//! lambda phi with lambda = 4 sin^2(pi k / 2 n) / h^2 or 4 sin^2(pi m / n) / h^2 (Strang 1999, The Discrete Cosine Transform).
//! Each is even or odd about the middle of the axis, so a transform is two products with matrices of half the size: for the
//! lengths of an axis that grids have these matrices, kept in the caches, are as fast as a fast transform, and any length will do.

use super::Grid;
use crate::real::Real;

/// The longest axis whose eigenvectors are kept.
pub const LONGEST: usize = 256;
/// Rows of a matrix that are stored side by side, see [`Axis::analysis`].
pub const TOGETHER: usize = 4;
/// Columns are a multiple of this: two of the widest vectors.
pub const COLUMNS: usize = 32;

/// Eigenvectors about the middle: even or odd.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// The same on both sides.
    Even,
    /// Opposite.
    Odd,
}

/// Both, in the order in which a transform stores them.
pub const PARITIES: [Parity; 2] = [Parity::Even, Parity::Odd];

impl Parity {
    /// Eigenvectors of this parity along an axis of `n`: so many numbers of a half describe one.
    #[must_use]
    pub const fn count(self, n: usize) -> usize {
        match self {
            Self::Even => n.div_ceil(2),
            Self::Odd => n / 2,
        }
    }
}

/// Number `i` of eigenvector `k` of its parity, of length 1, and its eigenvalue times h^2.
fn eigenvector(n: usize, periodic: bool, parity: Parity, k: usize, i: usize) -> (f64, f64) {
    let pi = core::f64::consts::PI;
    let place = (i as f64 + 0.5) / n as f64;
    let (wave, turns) = match (periodic, parity) {
        (false, Parity::Even) => (2 * k, 0.5),
        (false, Parity::Odd) => (2 * k + 1, 0.5),
        (true, Parity::Even) => (k, 1.0),
        (true, Parity::Odd) => (k + 1, 1.0),
    };
    let angle = 2.0 * pi * turns * wave as f64;
    let sine = periodic && parity == Parity::Odd;
    let alone = wave == 0 || (sine && 2 * wave == n);
    let length = libm::sqrt(if alone { 1.0 } else { 2.0 } / n as f64);
    let half = libm::sin(angle / (2 * n) as f64);
    (length * if sine { libm::sin(angle * place) } else { libm::cos(angle * place) }, 4.0 * half * half)
}

/// The eigenvectors of an axis.
#[derive(Clone, Debug)]
pub struct Axis<'m, T> {
    n: usize,
    first: bool,
    matrices: &'m [T],
    /// Eigenvalues: even ones first.
    pub eigenvalues: &'m [T],
}

/// Numbers of a matrix of `count` rows and columns: of axis 0 by rows, of others [`TOGETHER`] rows side by side.
const fn matrix_len(count: usize, first: bool) -> usize {
    if first { count * count.next_multiple_of(COLUMNS) } else { count.next_multiple_of(TOGETHER) * count }
}

/// Numbers of all matrices of an axis: analysis and synthesis of either parity.
fn matrices_len(n: usize, first: bool) -> usize {
    PARITIES.iter().map(|parity| 2 * matrix_len(parity.count(n), first)).sum()
}

/// Fills the numbers of an axis: its matrices, then its eigenvalues.
fn fill_axis<T: Real>(grid: &Grid, axis: usize, numbers: &mut [T]) {
    let (n, first) = (grid.n[axis], axis == 0);
    let (matrices, eigenvalues) = numbers.split_at_mut(matrices_len(n, first));
    matrices.fill(T::ZERO);
    let (mut matrix, mut number) = (0, 0);
    for parity in PARITIES {
        let count = parity.count(n);
        let len = matrix_len(count, first);
        for k in 0..count {
            for i in 0..count {
                let (value, eigenvalue) = eigenvector(n, grid.periodic[axis], parity, k, i);
                let value = T::from_f64(value);
                let place = |row: usize, column: usize| match first {
                    true => row * count.next_multiple_of(COLUMNS) + column,
                    false => (row / TOGETHER * count + column) * TOGETHER + row % TOGETHER,
                };
                // Along the first axis fields stand left of the matrix.
                let [analysis, synthesis] = if first { [place(i, k), place(k, i)] } else { [place(k, i), place(i, k)] };
                (matrices[matrix + analysis], matrices[matrix + len + synthesis]) = (value, value);
                eigenvalues[number + k] = T::from_f64(eigenvalue / (grid.h[axis] * grid.h[axis]));
            }
        }
        (matrix, number) = (matrix + 2 * len, number + count);
    }
}

impl<T: Real> Axis<'_, T> {
    /// From half an axis to its coefficients: `first` by rows, for a field times the matrix; else [`TOGETHER`] rows side by side.
    #[must_use]
    pub fn analysis(&self, parity: Parity) -> &[T] {
        self.matrix(parity, 0)
    }

    /// Back.
    #[must_use]
    pub fn synthesis(&self, parity: Parity) -> &[T] {
        self.matrix(parity, 1)
    }

    fn matrix(&self, parity: Parity, which: usize) -> &[T] {
        let len = matrix_len(parity.count(self.n), self.first);
        let before = if parity == Parity::Odd { 2 * matrix_len(Parity::Even.count(self.n), self.first) } else { 0 };
        &self.matrices[before + which * len..][..len]
    }
}

/// The eigenvectors of all axes.
#[derive(Clone, Debug)]
pub struct Spectrum<'m, T> {
    /// Axis by axis.
    pub axes: heapless::Vec<Axis<'m, T>, 3>,
}

impl<'m, T: Real> Spectrum<'m, T> {
    /// Whether a grid has one.
    #[must_use]
    pub fn exists(grid: &Grid) -> bool {
        grid.n.iter().all(|&n| n <= LONGEST)
    }

    /// Its numbers, 0 if there is none.
    #[must_use]
    pub fn len(grid: &Grid) -> usize {
        if Self::exists(grid) { (0..grid.dims).map(|axis| Self::len_of(grid, axis)).sum() } else { 0 }
    }

    /// Fills [`Self::len`] numbers for [`Self::view`].
    pub fn fill(grid: &Grid, numbers: &mut [T]) {
        let mut rest = numbers;
        for axis in 0..if Self::exists(grid) { grid.dims } else { 0 } {
            let (these, after) = rest.split_at_mut(Self::len_of(grid, axis));
            fill_axis(grid, axis, these);
            rest = after;
        }
    }

    /// The eigenvectors that [`Self::fill`] wrote.
    #[must_use]
    pub fn view(grid: &Grid, mut numbers: &'m [T]) -> Self {
        let mut axes = heapless::Vec::new();
        for axis in 0..grid.dims {
            let (these, after) = numbers.split_at(Self::len_of(grid, axis));
            let (n, first) = (grid.n[axis], axis == 0);
            let (matrices, eigenvalues) = these.split_at(matrices_len(n, first));
            let pushed = axes.push(Axis { n, first, matrices, eigenvalues });
            debug_assert!(pushed.is_ok());
            numbers = after;
        }
        Self { axes }
    }

    fn len_of(grid: &Grid, axis: usize) -> usize {
        matrices_len(grid.n[axis], axis == 0) + grid.n[axis]
    }
}
