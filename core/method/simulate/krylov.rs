//! GMRES (Saad & Schultz 1986) on fields of one slot: one cycle, for the correction of a residual.

use crate::exec::Exec;
use crate::field::trajectory::{Shape, add, dot, scale};
use crate::field::{Vector, VectorMut, view};
use crate::grid::Grid;
use crate::memory::Pool;
use crate::real::Real;
use crate::transport::Stop;

/// Directions of a cycle at most, and as many as a step has by default.
pub const DIRECTIONS: usize = 20;
/// Error of L d, relative to what is to be left of the residual.
const ACCURACY: f64 = 0.1;

/// What is solved: writes L d for the direction d, with a relative error of at most the given one.
pub type Apply<'a, T> =
    dyn FnMut(Vector<'_, T>, &mut VectorMut<'_, T>, f64, &mut [f64]) -> Result<(), Stop> + 'a;

/// The orthonormal directions.
pub struct Krylov<'a, T> {
    basis: heapless::Vec<VectorMut<'a, T>, { DIRECTIONS + 1 }>,
}

impl<'a, T: Real> Krylov<'a, T> {
    /// Takes its workspace for cycles of at most `directions` from a pool, of which there are at most [`DIRECTIONS`].
    pub fn carve(grid: &Grid, directions: usize, pool: &mut Pool<'a, T>) -> Self {
        pool.line("Krylov directions", |pool| Self {
            basis: (0..=directions.min(DIRECTIONS))
                .map(|_| pool.take_vector("direction", grid.dims, grid.cells()))
                .collect(),
        })
    }

    /// `out` = a d for which |residual - L d| is at most `left` times |residual|, which is not 0, or the best of one cycle.
    ///
    /// L is applied the less exactly the less of the residual is left (Simoncini & Szyld 2003).
    ///
    /// # Errors
    /// Those of `apply`.
    pub fn correct(
        &mut self,
        exec: &dyn Exec,
        grid: &Grid,
        residual: Vector<'_, T>,
        left: f64,
        out: &mut VectorMut<'_, T>,
        sums: &mut [f64],
        apply: &mut Apply<'_, T>,
    ) -> Result<(), Stop> {
        let shape = Shape { grid, slots: 1 };
        let size = libm::sqrt(dot(exec, shape, residual, residual, sums));
        add(exec, shape, &mut self.basis[0], 0.0, 1.0 / size, residual);
        let mut triangle = Triangle::new();
        while triangle.columns + 1 < self.basis.len() && triangle.left() > left {
            let (known, next) = self.basis.split_at_mut(triangle.columns + 1);
            let (last, next) = (&known[triangle.columns], &mut next[0]);
            apply(
                view(last),
                next,
                (ACCURACY * left / triangle.left()).min(ACCURACY),
                sums,
            )?;
            let mut column = [0.0; DIRECTIONS + 1];
            for (direction, entry) in known.iter().zip(&mut column) {
                *entry = dot(exec, shape, view(direction), view(next), sums);
                add(exec, shape, next, 1.0, -*entry, view(direction));
            }
            let norm = libm::sqrt(dot(exec, shape, view(next), view(next), sums));
            column[known.len()] = norm;
            triangle.push(column);
            if norm == 0.0 {
                break;
            }
            scale(exec, shape, next, 1.0 / norm);
        }
        let weights = triangle.solve();
        add(exec, shape, out, 0.0, size * weights[0], view(&self.basis[0]));
        for (direction, &weight) in self.basis.iter().zip(&weights).take(triangle.columns).skip(1) {
            add(exec, shape, out, 1.0, size * weight, view(direction));
        }
        Ok(())
    }
}

/// The projection of L to the directions, made triangular by rotations as it grows; the right-hand side is of length 1.
struct Triangle {
    columns: usize,
    entries: [[f64; DIRECTIONS + 1]; DIRECTIONS],
    rotations: [[f64; 2]; DIRECTIONS],
    right: [f64; DIRECTIONS + 1],
}

impl Triangle {
    fn new() -> Self {
        let mut right = [0.0; DIRECTIONS + 1];
        right[0] = 1.0;
        Self {
            columns: 0,
            entries: [[0.0; DIRECTIONS + 1]; DIRECTIONS],
            rotations: [[0.0; 2]; DIRECTIONS],
            right,
        }
    }

    /// What is left of the right-hand side.
    fn left(&self) -> f64 {
        self.right[self.columns].abs()
    }

    fn push(&mut self, mut column: [f64; DIRECTIONS + 1]) {
        let at = self.columns;
        let rotate = |[c, s]: [f64; 2], pair: &mut [f64]| {
            (pair[0], pair[1]) = (c * pair[0] + s * pair[1], c * pair[1] - s * pair[0])
        };
        for (i, &rotation) in self.rotations.iter().enumerate().take(at) {
            rotate(rotation, &mut column[i..i + 2]);
        }
        let length = libm::hypot(column[at], column[at + 1]);
        self.rotations[at] = if length > 0.0 {
            [column[at] / length, column[at + 1] / length]
        } else {
            [1.0, 0.0]
        };
        rotate(self.rotations[at], &mut column[at..at + 2]);
        rotate(self.rotations[at], &mut self.right[at..at + 2]);
        self.entries[at] = column;
        self.columns += 1;
    }

    /// The weights of the directions.
    fn solve(&self) -> [f64; DIRECTIONS] {
        let mut weights = [0.0; DIRECTIONS];
        for i in (0..self.columns).rev() {
            let known: f64 = (i + 1..self.columns)
                .map(|j| self.entries[j][i] * weights[j])
                .sum();
            let pivot = self.entries[i][i];
            weights[i] = if pivot == 0.0 {
                0.0
            } else {
                (self.right[i] - known) / pivot
            };
        }
        weights
    }
}
