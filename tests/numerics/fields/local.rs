//! The smoother's step at one cell as a dense system (section 5), solved by elimination: nothing is eliminated by hand.

use super::naive::Naive;
use super::spacetime::{Equations, Residual};
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::surroundings::Surroundings;

/// What a cell's faces, in the order low x, high x, low y, .., are to the local problem.
struct Face {
    axis: usize,
    at: [usize; 3],
    /// Outward sign / h, 0 on a wall.
    normal: f64,
}

fn faces(naive: &Naive, at: [usize; 3]) -> Vec<Face> {
    let face = |f: usize| {
        let (axis, high) = (f / 2, f % 2 == 1);
        let place = if high { naive.step(at, axis, 1) } else { Some(at) };
        let free = place.filter(|&place| !naive.wall(place, axis));
        let sign = if high { 1.0 } else { -1.0 };
        Face {
            axis,
            at: place.unwrap_or(at),
            normal: if free.is_some() {
                sign / naive.grid.h[axis]
            } else {
                0.0
            },
        }
    };
    (0..2 * naive.grid.dims).map(face).collect()
}

/// J restricted to the faces, by central differences, which are exact for a quadratic.
fn jacobian(problem: &Equations, k: usize, faces: &[Face]) -> Vec<Vec<f64>> {
    let naive = &problem.naive;
    let column = |face: &Face| {
        let moved = |by: f64| {
            let mut v = problem.v[k].clone();
            v[face.axis][naive.id(face.at)] += by;
            naive.advection(&v)
        };
        let (plus, minus) = (moved(1.0), moved(-1.0));
        let slope = |f: &Face| {
            if f.normal == 0.0 {
                0.0
            } else {
                (plus[f.axis][naive.id(f.at)] - minus[f.axis][naive.id(f.at)]) / 2.0
            }
        };
        faces.iter().map(slope).collect::<Vec<_>>()
    };
    let columns: Vec<Vec<f64>> = faces
        .iter()
        .map(|face| {
            if face.normal == 0.0 {
                vec![0.0; faces.len()]
            } else {
                column(face)
            }
        })
        .collect();
    (0..faces.len())
        .map(|f| columns.iter().map(|column| column[f]).collect())
        .collect()
}

/// O: what the faces do to the outside faces of the plaquettes at the cell's corners (edges in 3D), squared.
fn outside(problem: &Equations, k: usize, faces: &[Face]) -> Vec<Vec<f64>> {
    let (naive, v) = (&problem.naive, &problem.v[k]);
    let mut sum = vec![vec![0.0; faces.len()]; faces.len()];
    naive.each_plaquette(|(a, b), at| {
        let own = |axis: usize, place: [usize; 3]| {
            faces
                .iter()
                .position(|f| f.axis == axis && f.at == place && f.normal != 0.0)
        };
        let own = [own(a, at[0]), own(a, at[1]), own(b, at[2]), own(b, at[3])];
        if own.iter().flatten().count() != 2 || own[0].is_some() == own[1].is_some() {
            return;
        }
        let force = |moved: Option<usize>, by: f64| {
            let value = |i: usize| {
                v[[a, a, b, b][i]][naive.id(at[i])]
                    + if moved.is_some() && own[i] == moved {
                        by
                    } else {
                        0.0
                    }
            };
            let at_all = naive.at_plaquette((a, b), [0, 1, 2, 3].map(value));
            let mut others = (0..4).filter(|&i| own[i].is_none()).map(|i| at_all[i]);
            [others.next().unwrap(), others.next().unwrap()]
        };
        let mut rows = [vec![0.0; faces.len()], vec![0.0; faces.len()]];
        for face in own.into_iter().flatten() {
            let (plus, minus) = (force(Some(face), 1.0), force(Some(face), -1.0));
            (0..2).for_each(|i| rows[i][face] = (plus[i] - minus[i]) / 2.0);
        }
        for (row, f) in rows
            .iter()
            .flat_map(|row| (0..faces.len()).map(move |f| (row, f)))
        {
            row.iter()
                .zip(&mut sum[f])
                .for_each(|(x, sum)| *sum += row[f] * x);
        }
    });
    sum
}

/// `by` on the diagonal.
fn damping(by: f64, faces: &[Face]) -> Vec<Vec<f64>> {
    (0..faces.len())
        .map(|i| (0..faces.len()).map(|j| if i == j { by } else { 0.0 }).collect())
        .collect()
}

fn scaled(by: f64, matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    matrix
        .iter()
        .map(|row| row.iter().map(|x| by * x).collect())
        .collect()
}

/// P O P with P the projection onto changes that keep the cell's divergence.
fn tangential(o: &[Vec<f64>], faces: &[Face]) -> Vec<Vec<f64>> {
    let squared = faces
        .iter()
        .map(|f| f.normal * f.normal)
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let n = faces.len();
    let p = |i: usize, j: usize| f64::from(u8::from(i == j)) - faces[i].normal * faces[j].normal / squared;
    let entry = |i: usize, j: usize| {
        (0..n)
            .flat_map(|l| (0..n).map(move |m| (l, m)))
            .map(|(l, m)| p(i, l) * o[l][m] * p(m, j))
            .sum()
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

/// The sum of (v_f / h)^2 over the faces of the cell at `at` in each slot.
pub fn squares(problem: &Equations, at: [usize; 3]) -> Vec<f64> {
    let faces = faces(&problem.naive, at);
    problem
        .v
        .iter()
        .map(|v| {
            faces
                .iter()
                .map(|f| (f.normal * v[f.axis][problem.naive.id(f.at)]).powi(2))
                .sum()
        })
        .collect()
}

/// The changes of the cell at `at`: for each slot dv and dw at its faces, dp and dpbar. In slots in which the cell is slow, J and O are left
/// out, and changes that keep its divergence are damped.
pub fn changes(
    problem: &Equations,
    residual: &Residual,
    surroundings: Surroundings<f64>,
    local: LocalDamping<f64>,
    at: [usize; 3],
) -> Vec<Vec<f64>> {
    let (naive, slots) = (&problem.naive, problem.v.len());
    let faces = faces(naive, at);
    let (n, size) = (faces.len(), 2 * faces.len() + 2);
    let mut matrix = vec![vec![0.0; size * slots]; size * slots];
    let mut right = vec![0.0; size * slots];
    let squares = squares(problem, at);
    let mass = surroundings.mass;
    for k in 0..slots {
        let is_damped = squares[k] <= local.threshold && naive.viscosity == 0.0;
        let j = if is_damped {
            vec![vec![0.0; n]; n]
        } else {
            jacobian(problem, k, &faces)
        };
        let o = if is_damped {
            damping(mass * squares[k], &faces)
        } else {
            scaled(surroundings.outside / mass, &outside(problem, k, &faces))
        };
        let o = tangential(&o, &faces);
        let mut closed = true;
        let (v, w, p, pbar) = (k * size, k * size + n, k * size + 2 * n, k * size + 2 * n + 1);
        for (f, face) in faces.iter().enumerate() {
            let (a, c, i) = (v + f, w + f, naive.id(face.at));
            (matrix[a][v + f], matrix[c][w + f]) = (1.0, 1.0);
            if face.normal == 0.0 {
                continue;
            }
            closed = false;
            (right[a], right[c]) = (residual.a[k][face.axis][i], residual.c[k][face.axis][i]);
            (matrix[a][v + f], matrix[a][w + f], matrix[a][pbar]) =
                (mass * problem.kappa, mass, -face.normal);
            (matrix[c][v + f], matrix[c][w + f], matrix[c][p]) = (mass, -mass, -face.normal);
            if k + 1 < slots {
                matrix[a][w + size + f] = -mass;
            }
            if k > 0 {
                matrix[c][v + f - size] = -mass;
            }
            for e in 0..n {
                matrix[a][v + e] += o[f][e];
                matrix[a][w + e] += j[e][f];
                matrix[c][v + e] += j[f][e];
            }
            (matrix[p][v + f], matrix[pbar][w + f]) = (face.normal, face.normal);
        }
        if closed {
            // Nothing can change.
            (matrix[p][p], matrix[pbar][pbar]) = (1.0, 1.0);
            continue;
        }
        (right[p], right[pbar]) = (residual.b[k][naive.id(at)], residual.d[k][naive.id(at)]);
    }
    solve(matrix, right)
        .chunks_exact(size)
        .map(<[f64]>::to_vec)
        .collect()
}

/// Gaussian elimination with row exchanges.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for column in 0..n {
        let pivot = (column..n)
            .max_by(|&i, &j| matrix[i][column].abs().total_cmp(&matrix[j][column].abs()))
            .unwrap();
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        for row in column + 1..n {
            let factor = matrix[row][column] / matrix[column][column];
            if factor != 0.0 {
                let (upper, lower) = matrix.split_at_mut(row);
                lower[0][column..]
                    .iter_mut()
                    .zip(&upper[column][column..])
                    .for_each(|(x, y)| *x -= factor * y);
                right[row] -= factor * right[column];
            }
        }
    }
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|i| matrix[row][i] * right[i]).sum();
        right[row] = (right[row] - known) / matrix[row][row];
    }
    right
}
