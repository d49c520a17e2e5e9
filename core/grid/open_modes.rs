//! The eigenvectors of the second difference along an axis with open sides: they are 0 in the cells outside the box.
//!
//! With n cells inside, -div grad of sin(pi k (i + 1) / (n + 1)), k >= 1, between two open sides is lambda times it with
//! lambda = 4 sin^2(pi k / (2 (n + 1))) / h^2; of cos(pi (k + 1/2) (i + 1/2) / (n + 1/2)), k >= 0, between a wall and an open side with
//! lambda = 4 sin^2(pi (2 k + 1) / (2 (2 n + 1))) / h^2 (Strang 1999, The Discrete Cosine Transform). They are kept whole.

use super::Axis;
use super::parity::Parity;

/// Whether the eigenvectors of an axis are even and odd about its middle: with open sides all of them count as even, and are kept whole.
#[must_use]
pub fn folds(axis: Axis) -> bool {
    axis.inside().len() == axis.cells()
}

/// Value `i` of eigenvector `k` along an axis with open sides, and its eigenvalue times h^2; there are as many as cells, and the last belong to
/// the cells outside and are 0.
#[must_use]
pub fn eigenvector(axis: Axis, k: usize, i: usize) -> (f64, f64) {
    let inside = axis.inside();
    let n = inside.len();
    let both = axis.cells() - n == 2;
    if k >= n || !inside.contains(&i) {
        return (0.0, if k >= n { 1.0 } else { eigenvalue(n, both, k) });
    }
    let i = i - inside.start;
    let value = if both {
        let angle = core::f64::consts::PI / (n + 1) as f64;
        libm::sqrt(2.0 / (n + 1) as f64) * libm::sin(angle * ((k + 1) * (i + 1)) as f64)
    } else {
        // From the wall.
        let i = if inside.start > 0 { n - 1 - i } else { i };
        let angle = core::f64::consts::PI / (2 * (2 * n + 1)) as f64;
        2.0 / libm::sqrt((2 * n + 1) as f64) * libm::cos(angle * ((2 * k + 1) * (2 * i + 1)) as f64)
    };
    (value, eigenvalue(n, both, k))
}

/// Eigenvalue `k` times h^2 of `n` cells inside, with `both` sides open or one.
fn eigenvalue(n: usize, both: bool, k: usize) -> f64 {
    let half = if both {
        core::f64::consts::PI * (k + 1) as f64 / (2 * (n + 1)) as f64
    } else {
        core::f64::consts::PI * (2 * k + 1) as f64 / (2 * (2 * n + 1)) as f64
    };
    let half = libm::sin(half);
    4.0 * half * half
}

/// The eigenvectors of a parity along an axis, or of either by their coefficients; those of the cells outside are 0.
#[must_use]
pub fn count(axis: Axis, parity: Parity) -> usize {
    match (folds(axis), parity) {
        (true, _) => parity.count(axis.cells()),
        (false, Parity::Even) => axis.cells(),
        (false, Parity::Odd) => 0,
    }
}
