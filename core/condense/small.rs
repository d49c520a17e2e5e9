//! Small dense matrices in f64: eigenvectors, inverses, the rotation in a matrix.

use libm::{hypot, sqrt};

/// Rows of a square matrix.
pub type Square<const N: usize> = [[f64; N]; N];

/// Sweeps of Jacobi's method at most; it takes 5 to 8.
const SWEEPS: usize = 40;
/// Squares of what is beside the diagonal, in parts of the whole, at which it ends.
const ROUNDING: f64 = 1e-31;

/// The identity.
pub fn identity<const N: usize>() -> Square<N> {
    let mut one = [[0.0; N]; N];
    for (k, row) in one.iter_mut().enumerate() {
        row[k] = 1.0;
    }
    one
}

/// A B.
pub fn product<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    a.map(|row| {
        let mut out = [0.0; N];
        for (value, row) in row.iter().zip(b) {
            for (out, other) in out.iter_mut().zip(row) {
                *out += value * other;
            }
        }
        out
    })
}

/// A^T.
pub fn transposed<const N: usize>(a: &Square<N>) -> Square<N> {
    let mut out = [[0.0; N]; N];
    for (i, row) in a.iter().enumerate() {
        for (out, value) in out.iter_mut().zip(row) {
            out[i] = *value;
        }
    }
    out
}

/// A x.
pub fn times<const N: usize>(a: &Square<N>, x: &[f64; N]) -> [f64; N] {
    a.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

/// The sum of the diagonal.
pub fn trace<const N: usize>(a: &Square<N>) -> f64 {
    a.iter().enumerate().map(|(k, row)| row[k]).sum()
}

/// Makes the leading n x n part of the symmetric `a` diagonal by Jacobi's rotations: its diagonal is then the eigenvalues, and the columns of what is
/// returned are the eigenvectors.
pub fn diagonalise<const N: usize>(n: usize, a: &mut Square<N>) -> Square<N> {
    let n = n.min(N);
    let mut vectors = identity();
    for _ in 0..SWEEPS {
        let (mut beside, mut whole) = (0.0, 0.0);
        for (i, row) in a.iter().enumerate().take(n) {
            for (j, value) in row.iter().enumerate().take(n) {
                whole += value * value;
                beside += if i == j { 0.0 } else { value * value };
            }
        }
        // A NaN ends it too.
        if !(beside > ROUNDING * whole) {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                rotate(n, a, &mut vectors, p, q);
            }
        }
    }
    vectors
}

/// The rotation that makes a_pq zero.
fn rotate<const N: usize>(n: usize, a: &mut Square<N>, vectors: &mut Square<N>, p: usize, q: usize) {
    let beside = a[p][q];
    if beside == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * beside);
    let sign = if theta < 0.0 { -1.0 } else { 1.0 };
    let tangent = sign / (theta.abs() + hypot(theta, 1.0));
    let cosine = 1.0 / hypot(tangent, 1.0);
    let sine = tangent * cosine;
    for row in a.iter_mut().take(n).chain(vectors.iter_mut().take(n)) {
        let [one, other] = [row[p], row[q]];
        row[p] = cosine * one - sine * other;
        row[q] = sine * one + cosine * other;
    }
    let (above, below) = a.split_at_mut(q);
    for (one, other) in above[p].iter_mut().zip(&mut below[0]).take(n) {
        let values = [*one, *other];
        *one = cosine * values[0] - sine * values[1];
        *other = sine * values[0] + cosine * values[1];
    }
    a[p][q] = 0.0;
    a[q][p] = 0.0;
}

/// Takes the negative eigenvalues out of the leading n x n part of the symmetric `a`.
pub fn make_semidefinite<const N: usize>(n: usize, a: &mut Square<N>) {
    let n = n.min(N);
    let mut diagonal = *a;
    let vectors = diagonalise(n, &mut diagonal);
    for k in 0..n {
        let value = diagonal[k][k];
        if value < 0.0 {
            for i in 0..n {
                for j in 0..n {
                    a[i][j] -= value * vectors[i][k] * vectors[j][k];
                }
            }
        }
    }
}

/// Whether Cholesky's method goes through for the leading n x n part of `a` with `shift` on its diagonal.
pub fn is_definite<const N: usize>(n: usize, a: &Square<N>, shift: f64) -> bool {
    let n = n.min(N);
    let mut factor = *a;
    for k in 0..n {
        let pivot = factor[k][k] + shift;
        // A NaN is not.
        if !(pivot > 0.0) {
            return false;
        }
        for i in k + 1..n {
            let part = factor[i][k] / pivot;
            for j in k + 1..=i {
                factor[i][j] -= part * factor[j][k];
            }
        }
    }
    true
}

/// The inverse of a symmetric matrix whose eigenvalues are raised to `least` first.
pub fn inverse_above<const N: usize>(a: &Square<N>, least: f64) -> Square<N> {
    let mut diagonal = *a;
    let vectors = diagonalise(N, &mut diagonal);
    let mut inverse = [[0.0; N]; N];
    for k in 0..N {
        let value = 1.0 / diagonal[k][k].max(least);
        for i in 0..N {
            for j in 0..N {
                inverse[i][j] += value * vectors[i][k] * vectors[j][k];
            }
        }
    }
    inverse
}

/// Cofactors: J A^-T.
pub fn cofactors(a: &Square<3>) -> Square<3> {
    let [x, y, z] = a;
    [cross(y, z), cross(z, x), cross(x, y)]
}

/// a x b.
pub fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// <a, b>.
pub fn inner<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The rotation next to A, that of its polar decomposition: U diag(1, .., det UV^T) V^T of its SVD; in the plane the angle atan2(A_21 - A_12, A_11 +
/// A_22). The identity where A is 0.
pub fn rotation<const D: usize>(a: &Square<D>) -> Square<D> {
    let mut out = identity();
    if D == 2 {
        let (cosine, sine) = (a[0][0] + a[1][1], a[1][0] - a[0][1]);
        let length = hypot(cosine, sine);
        if length > 0.0 {
            (out[0][0], out[1][1]) = (cosine / length, cosine / length);
            (out[0][1], out[1][0]) = (-sine / length, sine / length);
        }
    } else if D == 3 {
        let full = spatial(&core::array::from_fn(|i| core::array::from_fn(|j| a[i][j])));
        for (row, values) in out.iter_mut().zip(&full) {
            row.copy_from_slice(values);
        }
    }
    out
}

/// As [`rotation`], in space: u_1 v_1^T + u_2 v_2^T + (u_1 x u_2) (v_1 x v_2)^T, with v_1, v_2 of the two largest singular values.
fn spatial(a: &Square<3>) -> Square<3> {
    let mut square = product(&transposed(a), a);
    let vectors = transposed(&diagonalise(3, &mut square));
    let mut order = [0, 1, 2];
    order.sort_unstable_by(|&i, &j: &usize| square[j][j].total_cmp(&square[i][i]));
    let (v, w) = (vectors[order[0]], vectors[order[1]]);
    let Some(first) = unit(times(a, &v)) else {
        return identity();
    };
    let second = times(a, &w);
    let along = inner(&first, &second);
    let rest = core::array::from_fn(|k| second[k] - along * first[k]);
    // Of a matrix of rank 1 any direction across will do.
    let across = unit(rest).or_else(|| {
        let thin = if first[0].abs() < 0.5 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        };
        unit(cross(&first, &thin))
    });
    let second = across.unwrap_or(first);
    let (third, last) = (cross(&first, &second), cross(&v, &w));
    core::array::from_fn(|i| {
        core::array::from_fn(|j| first[i] * v[j] + second[i] * w[j] + third[i] * last[j])
    })
}

fn unit(x: [f64; 3]) -> Option<[f64; 3]> {
    let length = sqrt(inner(&x, &x));
    (length > 0.0).then(|| x.map(|x| x / length))
}
