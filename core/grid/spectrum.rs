//! The eigenvectors of the second difference along an axis: cosines between walls, cosines and sines on a ring.
//!
//! -div grad of the potentials phi_k = cos(pi k (i + 1/2) / n) between walls, or cos and sin of 2 pi m (i + 1/2) / n on a ring, is
//! lambda phi with lambda = 4 sin^2(pi k / 2 n) / h^2 or 4 sin^2(pi m / n) / h^2 (Strang 1999, The Discrete Cosine Transform).
//! Any symmetric filter that is the same everywhere and is mirrored at walls has them too, such as the Gaussians of the metric.
//!
//! Each eigenvector is even or odd about the middle of the axis, so a transform is two products with matrices of half the size. Where it
//! takes less time, and along axes of more than [`LONGEST`] cells, a [fast transform](super::fourier) leads to the same coefficients
//! ([`is_fast`]). The eigenvectors of axes with open sides have no such symmetry: [`open_modes`].

use super::fourier::{self, Fourier};
use super::gaussian::{ANGLES, Gaussian};
pub use super::parity::{PARITIES, Parity};
use super::{Axis, Grid, open_modes};
use crate::real::Real;

/// The longest axis that is transformed by matrices.
pub const LONGEST: usize = 256;
/// The most cells inside along an axis with an open side, of which the layers outside are among those of [`LONGEST`].
pub const MOST_OPEN: usize = LONGEST - 2;
/// The rows of the left matrix that a product of matrices takes at a time.
pub const TOGETHER: usize = 4;
/// The columns of the right matrix are a multiple of this: two of the widest vectors.
pub const COLUMNS: usize = 32;

/// Whether an axis has a fast transform, and no matrices.
#[must_use]
pub fn is_fast(axis: Axis) -> bool {
    let n = axis.cells();
    n > LONGEST || open_modes::folds(axis) && fourier::pays(n)
}

/// The half waves of eigenvector `k` of a parity along an axis.
fn half_waves(axis: Axis, parity: Parity, k: usize) -> usize {
    match parity {
        Parity::Even => 2 * k,
        Parity::Odd if axis.is_ring() => 2 * (k + 1),
        Parity::Odd => 2 * k + 1,
    }
}

/// Value `i` of eigenvector `k` of an axis, even ones before odd ones, scaled to length 1, and its eigenvalue times h^2.
#[must_use]
pub fn eigenvector_of(axis: Axis, k: usize, i: usize) -> (f64, f64) {
    if !open_modes::folds(axis) {
        return open_modes::eigenvector(axis, k, i);
    }
    let even = Parity::Even.count(axis.cells());
    match k.checked_sub(even) {
        None => eigenvector(axis, Parity::Even, k, i),
        Some(odd) => eigenvector(axis, Parity::Odd, odd, i),
    }
}

/// Value `i` of eigenvector `k` of a parity, scaled to length 1, and its eigenvalue times h^2.
fn eigenvector(axis: Axis, parity: Parity, k: usize, i: usize) -> (f64, f64) {
    if !open_modes::folds(axis) {
        return open_modes::eigenvector(axis, k, i);
    }
    let n = axis.cells();
    let waves = half_waves(axis, parity, k);
    let angle = core::f64::consts::PI * waves as f64;
    let place = (i as f64 + 0.5) / n as f64;
    let sine = axis.is_ring() && parity == Parity::Odd;
    let alone = waves == 0 || (sine && waves == n);
    let length = libm::sqrt(if alone { 1.0 } else { 2.0 } / n as f64);
    let half = libm::sin(angle / (2 * n) as f64);
    (
        length
            * if sine {
                libm::sin(angle * place)
            } else {
                libm::cos(angle * place)
            },
        4.0 * half * half,
    )
}

/// The eigenvalues of G_j G_j along an axis, in the order of the eigenvectors: (sum over taps of w_o cos(pi waves o / n))^2.
fn fill_blur<T: Real>(axis: Axis, j: usize, factors: &mut [T]) {
    let n = axis.cells();
    let mut cosines = [0.0; LONGEST + 1];
    for (i, cosine) in cosines.iter_mut().enumerate().take(n + 1) {
        *cosine = libm::cos(core::f64::consts::PI * i as f64 / n as f64);
    }
    let mut sums = [0.0; LONGEST];
    for (offset, tap) in Gaussian::new(j).taps() {
        let twice = if offset == 0 { tap } else { 2.0 * tap };
        let waves = PARITIES
            .into_iter()
            .flat_map(|parity| (0..parity.count(n)).map(move |k| half_waves(axis, parity, k)));
        for (sum, waves) in sums.iter_mut().zip(waves) {
            let turned = waves * offset % (2 * n);
            *sum += twice * cosines[turned.min(2 * n - turned)];
        }
    }
    for (factor, sum) in factors.iter_mut().zip(sums) {
        *factor = T::from_f64(sum * sum);
    }
}

/// The same along an axis that is longer than [`LONGEST`].
fn fill_long_blur<T: Real>(axis: Axis, j: usize, factors: &mut [T]) {
    let n = axis.cells();
    let mut waves = PARITIES
        .into_iter()
        .flat_map(|parity| (0..parity.count(n)).map(move |k| half_waves(axis, parity, k)));
    for factors in factors.chunks_mut(ANGLES) {
        let angles = core::array::from_fn(|_| {
            let waves = waves.next().unwrap_or(0);
            core::f64::consts::PI * waves as f64 / n as f64
        });
        for (factor, response) in factors.iter_mut().zip(Gaussian::new(j).responses(&angles)) {
            *factor = T::from_f64(response * response);
        }
    }
}

/// The eigenvectors of an axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Modes<'m, T> {
    n: usize,
    first: bool,
    /// Whether each is even or odd about the middle: see [`open_modes::folds`].
    pub folds: bool,
    /// The tables of a fast transform, beside which there are no matrices.
    pub fourier: Option<Fourier<'m, T>>,
    matrices: &'m [T],
    /// Eigenvalues of -div grad, of even eigenvectors first.
    pub eigenvalues: &'m [T],
    blurs: &'m [T],
}

/// The length of a matrix of `count` rows and columns, stored by rows: on axis 0 padded to whole [`COLUMNS`], on others to whole
/// groups of [`TOGETHER`] rows.
const fn matrix_len(count: usize, first: bool) -> usize {
    if first {
        count * count.next_multiple_of(COLUMNS)
    } else {
        count.next_multiple_of(TOGETHER) * count
    }
}

/// The length of all matrices of an axis: analysis and synthesis of either parity.
fn matrices_len(axis: Axis, first: bool) -> usize {
    PARITIES
        .iter()
        .map(|&parity| 2 * matrix_len(open_modes::count(axis, parity), first))
        .sum()
}

/// The length of the matrices or the tables of an axis.
fn own_len<T: Real>(axis: Axis, first: bool) -> usize {
    if is_fast(axis) {
        Fourier::<T>::len(axis.cells())
    } else {
        matrices_len(axis, first)
    }
}

/// Fills what is kept of an axis: its matrices or tables, its eigenvalues, and those of the squares of `filters` Gaussians.
fn fill_axis<T: Real>(grid: &Grid, filters: usize, axis: usize, values: &mut [T]) {
    let n = grid.n[axis];
    let (own, rest) = values.split_at_mut(own_len::<T>(grid.axis(axis), axis == 0));
    let (eigenvalues, blurs) = rest.split_at_mut(n);
    if is_fast(grid.axis(axis)) {
        Fourier::fill(grid.axis(axis), own);
        fill_eigenvalues(grid, axis, eigenvalues);
    } else {
        fill_matrices(grid, axis, own, eigenvalues);
    }
    // Between open sides the Gaussians have other eigenvectors: every tap is added.
    let known = if open_modes::folds(grid.axis(axis)) {
        filters
    } else {
        0
    };
    for (j, factors) in (1..=known).zip(blurs.chunks_exact_mut(n)) {
        if n > LONGEST {
            fill_long_blur(grid.axis(axis), j, factors);
        } else {
            fill_blur(grid.axis(axis), j, factors);
        }
    }
}

/// Fills the eigenvalues of an axis that has no matrices.
fn fill_eigenvalues<T: Real>(grid: &Grid, axis: usize, eigenvalues: &mut [T]) {
    let squared = grid.h[axis] * grid.h[axis];
    let all = PARITIES
        .into_iter()
        .flat_map(|parity| (0..parity.count(grid.n[axis])).map(move |k| (parity, k)));
    for (eigenvalue, (parity, k)) in eigenvalues.iter_mut().zip(all) {
        let (_, times_squared) = eigenvector(grid.axis(axis), parity, k, 0);
        *eigenvalue = T::from_f64(times_squared / squared);
    }
}

/// Fills the matrices of an axis and its eigenvalues.
fn fill_matrices<T: Real>(grid: &Grid, axis: usize, matrices: &mut [T], eigenvalues: &mut [T]) {
    let first = axis == 0;
    matrices.fill(T::ZERO);
    let (mut matrix, mut before) = (0, 0);
    for parity in PARITIES {
        let count = open_modes::count(grid.axis(axis), parity);
        let len = matrix_len(count, first);
        let columns = if first {
            count.next_multiple_of(COLUMNS)
        } else {
            count
        };
        for k in 0..count {
            for i in 0..count {
                let (value, eigenvalue) = eigenvector(grid.axis(axis), parity, k, i);
                let value = T::from_f64(value);
                let place = |row: usize, column: usize| row * columns + column;
                // Along the first axis fields stand left of the matrix.
                let [analysis, synthesis] = if first {
                    [place(i, k), place(k, i)]
                } else {
                    [place(k, i), place(i, k)]
                };
                (matrices[matrix + analysis], matrices[matrix + len + synthesis]) = (value, value);
                eigenvalues[before + k] = T::from_f64(eigenvalue / (grid.h[axis] * grid.h[axis]));
            }
        }
        (matrix, before) = (matrix + 2 * len, before + count);
    }
}

impl<T: Real> Modes<'_, T> {
    /// The cells of the axis.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.n
    }

    /// The matrix from half an axis to its coefficients, by rows: on the first axis for a field times the matrix, else for the matrix
    /// times a field.
    #[must_use]
    pub fn analysis(&self, parity: Parity) -> &[T] {
        self.matrix(parity, 0)
    }

    /// The matrix back to values, the transpose.
    #[must_use]
    pub fn synthesis(&self, parity: Parity) -> &[T] {
        self.matrix(parity, 1)
    }

    /// The eigenvalues of G_j G_j, in the order of [`Self::eigenvalues`]; `j` counts from 1.
    #[must_use]
    pub fn blur(&self, j: usize) -> &[T] {
        &self.blurs[(j - 1) * self.n..][..self.n]
    }

    /// The eigenvectors of a parity.
    #[must_use]
    pub fn count(&self, parity: Parity) -> usize {
        match parity {
            _ if self.folds => parity.count(self.n),
            Parity::Even => self.n,
            Parity::Odd => 0,
        }
    }

    fn matrix(&self, parity: Parity, which: usize) -> &[T] {
        let len = matrix_len(self.count(parity), self.first);
        let before = if parity == Parity::Odd {
            2 * matrix_len(self.count(Parity::Even), self.first)
        } else {
            0
        };
        &self.matrices[before + which * len..][..len]
    }
}

/// The eigenvectors of all axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spectrum<'m, T> {
    /// Axis by axis; empty where the grid has no such axis.
    pub axes: [Modes<'m, T>; 3],
}

impl<'m, T: Real> Spectrum<'m, T> {
    /// Its length in values with `filters` Gaussians.
    #[must_use]
    pub fn len(grid: &Grid, filters: usize) -> usize {
        let grid = &grid.whole();
        (0..grid.dims).map(|axis| Self::len_of(grid, filters, axis)).sum()
    }

    /// Fills [`Self::len`] values for [`Self::view`].
    pub fn fill(grid: &Grid, filters: usize, numbers: &mut [T]) {
        let grid = &grid.whole();
        let mut rest = numbers;
        for axis in 0..grid.dims {
            let (these, after) = rest.split_at_mut(Self::len_of(grid, filters, axis));
            fill_axis(grid, filters, axis, these);
            rest = after;
        }
    }

    /// The eigenvectors that [`Self::fill`] wrote.
    #[must_use]
    pub fn view(grid: &Grid, filters: usize, mut numbers: &'m [T]) -> Self {
        let grid = &grid.whole();
        let mut axes = [Modes::default(); 3];
        for (axis, known) in axes.iter_mut().enumerate().take(grid.dims) {
            let (these, after) = numbers.split_at(Self::len_of(grid, filters, axis));
            let n = grid.n[axis];
            let first = axis == 0;
            let (own, rest) = these.split_at(own_len::<T>(grid.axis(axis), first));
            let (eigenvalues, blurs) = rest.split_at(n);
            let fast = is_fast(grid.axis(axis));
            *known = Modes {
                n,
                first,
                folds: open_modes::folds(grid.axis(axis)),
                fourier: fast.then(|| Fourier::view(grid.axis(axis), own)),
                matrices: if fast { &[] } else { own },
                eigenvalues,
                blurs,
            };
            numbers = after;
        }
        Self { axes }
    }

    fn len_of(grid: &Grid, filters: usize, axis: usize) -> usize {
        own_len::<T>(grid.axis(axis), axis == 0) + (1 + filters) * grid.n[axis]
    }
}
