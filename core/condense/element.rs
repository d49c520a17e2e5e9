//! A simplex of the mesh: an edge of a rod, a triangle, a tetrahedron. Its energy, gradient and Hessian (condensation, section 3).
//!
//! Vectors have three components here, of which those beyond the mesh's are 0: a matrix F of the plane is that of space with F_33 = 1, which leaves
//! J, |F|^2 - d and so the energy as they are (plane strain).

use super::material::Material;
use super::small::{Square, cofactors, inner, is_definite, make_semidefinite, times};
use libm::log1p;

/// Numbers of the corners of the largest simplex.
pub const LARGEST: usize = 12;
/// Corners of the largest simplex.
pub const CORNERS: usize = 4;
/// Orthonormal differences of corners.
const HELMERT: [[f64; CORNERS]; 3] = {
    let [two, six, twelve] = [
        core::f64::consts::FRAC_1_SQRT_2,
        0.408_248_290_463_863,
        0.288_675_134_594_812_87,
    ];
    [
        [two, -two, 0.0, 0.0],
        [six, six, -2.0 * six, 0.0],
        [twelve, twelve, twelve, -3.0 * twelve],
    ]
};
/// A matrix whose least eigenvalue is above this part of its trace below 0 counts as semidefinite: what its projection would change is rounding.
const SLACK: f64 = 1e-14;

/// A simplex at rest.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// Components of a vector.
    dims: usize,
    /// Signed length, area or volume.
    pub volume: f64,
    /// Gradients of its shape functions.
    gradients: [[f64; 3]; CORNERS],
}

/// Where a simplex has gone.
pub struct Strained {
    /// F - I.
    pub shift: Square<3>,
    /// F^-T.
    inverse: Square<3>,
    /// ln J; not finite where it is inverted.
    log: f64,
}

impl Element {
    /// The simplex with these corners.
    pub fn new(dims: usize, corners: &[[f64; 3]; CORNERS]) -> Self {
        let mut sides = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (side, corner) in sides.iter_mut().zip(&corners[1..]).take(dims) {
            for ((side, x), origin) in side.iter_mut().zip(corner).zip(&corners[0]).take(dims) {
                *side = x - origin;
            }
        }
        // Rows of `sides` are x_a - x_0, so the gradients are the rows of their inverse's transpose.
        let cofactors = cofactors(&sides);
        let jacobian = inner(&sides[0], &cofactors[0]);
        let mut gradients = [[0.0; 3]; CORNERS];
        let (first, others) = gradients.split_at_mut(1);
        for (gradient, row) in others.iter_mut().zip(&cofactors).take(dims) {
            for ((gradient, first), value) in gradient.iter_mut().zip(&mut first[0]).zip(row).take(dims) {
                *gradient = value / jacobian;
                *first -= *gradient;
            }
        }
        let parts = [1.0, 1.0, 2.0, 6.0];
        Self {
            dims,
            volume: jacobian / parts[dims.min(3)],
            gradients,
        }
    }

    /// F and what follows from it, of displacements of the corners.
    pub fn strained(&self, moved: &[[f64; 3]; CORNERS]) -> Strained {
        let shift = self.shift(moved);
        let [x, y, z] = shift;
        let minors = x[0] * y[1] - x[1] * y[0] + x[0] * z[2] - x[2] * z[0] + y[1] * z[2] - y[2] * z[1];
        let determinant = inner(&x, &cofactors(&shift)[0]);
        let growth = x[0] + y[1] + z[2] + minors + determinant;
        let mut whole = shift;
        (0..3).for_each(|k| whole[k][k] += 1.0);
        let jacobian = 1.0 + growth;
        Strained {
            shift,
            inverse: cofactors(&whole).map(|row| row.map(|value| value / jacobian)),
            log: if jacobian > 0.0 {
                log1p(growth)
            } else {
                f64::INFINITY
            },
        }
    }

    /// F - I.
    pub fn shift(&self, moved: &[[f64; 3]; CORNERS]) -> Square<3> {
        let mut shift = [[0.0; 3]; 3];
        for (moved, gradient) in moved.iter().zip(&self.gradients) {
            for (row, u) in shift.iter_mut().zip(moved) {
                for (value, g) in row.iter_mut().zip(gradient) {
                    *value += u * g;
                }
            }
        }
        shift
    }

    /// The energy: infinite where it is inverted.
    pub fn energy(&self, material: &Material, moved: &[[f64; 3]; CORNERS]) -> f64 {
        let weight = self.volume * material.thickness(self.dims);
        if self.dims == 1 {
            let shift = self.shift(moved)[0][0];
            return 0.5 * weight * material.young * shift * shift;
        }
        let strained = self.strained(moved);
        if !strained.log.is_finite() {
            return f64::INFINITY;
        }
        let [mu, lambda] = material.lame();
        let [x, y, z] = &strained.shift;
        let square = 2.0 * (x[0] + y[1] + z[2]) + inner(x, x) + inner(y, y) + inner(z, z);
        weight * (0.5 * mu * square - mu * strained.log + 0.5 * lambda * strained.log * strained.log)
    }

    /// The gradient by the displacement of corner `corner`.
    pub fn force(&self, material: &Material, moved: &[[f64; 3]; CORNERS], corner: usize) -> [f64; 3] {
        let weight = self.volume * material.thickness(self.dims);
        let gradient = self.gradients.get(corner).copied().unwrap_or_default();
        if self.dims == 1 {
            let shift = self.shift(moved)[0][0];
            return [weight * material.young * shift * gradient[0], 0.0, 0.0];
        }
        let strained = self.strained(moved);
        let [mu, lambda] = material.lame();
        let [along, back] = [
            times(&strained.shift, &gradient),
            times(&strained.inverse, &gradient),
        ];
        core::array::from_fn(|k| {
            weight * (mu * (along[k] + gradient[k] - back[k]) + lambda * strained.log * back[k])
        })
    }

    /// The Hessian, component within corner, projected to positive semidefinite:
    ///
    /// ```text
    /// V (mu delta_ik <g_a, g_b> + lambda q_ai q_bk + (mu - lambda ln J) q_ak q_bi),    q_a = F^-T g_a
    /// ```
    pub fn hessian(&self, material: &Material, moved: &[[f64; 3]; CORNERS]) -> Square<LARGEST> {
        let (dims, corners) = (self.dims, self.dims + 1);
        let mut hessian = [[0.0; LARGEST]; LARGEST];
        let weight = self.volume * material.thickness(dims);
        let [mu, lambda] = material.lame();
        let linear = dims == 1;
        let strained = self.strained(moved);
        let back = self.gradients.map(|gradient| times(&strained.inverse, &gradient));
        for (a, (p, q)) in self.gradients.iter().zip(&back).enumerate().take(corners) {
            for (b, (r, s)) in self.gradients.iter().zip(&back).enumerate().take(corners) {
                let even = inner(p, r);
                for i in 0..dims {
                    for k in 0..dims {
                        let mixed = lambda * q[i] * s[k] + (mu - lambda * strained.log) * q[k] * s[i];
                        let same = if i == k { mu * even } else { 0.0 };
                        let value = if linear {
                            material.young * even
                        } else {
                            same + mixed
                        };
                        hessian[a * dims + i][b * dims + k] = weight * value;
                    }
                }
            }
        }
        if !linear {
            self.project(&mut hessian);
        }
        hessian
    }

    /// Takes negative eigenvalues out, in the space without translations, which cost nothing.
    fn project(&self, hessian: &mut Square<LARGEST>) {
        let (dims, order) = (self.dims, self.dims * self.dims);
        let mut reduced = [[0.0; LARGEST]; LARGEST];
        self.both(hessian, &mut reduced, false);
        let sum: f64 = (0..order).map(|k| reduced[k][k].abs()).sum();
        if is_definite(order, &reduced, SLACK * sum) {
            return;
        }
        let whole = reduced;
        make_semidefinite(order, &mut reduced);
        for (change, whole) in reduced.as_flattened_mut().iter_mut().zip(whole.as_flattened()) {
            *change -= whole;
        }
        let mut change = [[0.0; LARGEST]; LARGEST];
        self.both(&reduced, &mut change, true);
        for (row, change) in hessian.iter_mut().zip(&change).take(order + dims) {
            row.iter_mut()
                .zip(change)
                .for_each(|(value, change)| *value += change);
        }
    }

    /// Q A Q^T, or Q^T A Q if `back`: the rows of Q are the differences of Helmert, (1, -1, 0, 0) / 2^(1/2), (1, 1, -2, 0) / 6^(1/2), ..,
    /// for each component.
    fn both(&self, from: &Square<LARGEST>, to: &mut Square<LARGEST>, back: bool) {
        let dims = self.dims;
        let mut half = [[0.0; LARGEST]; LARGEST];
        for (corner, row) in HELMERT.iter().enumerate().take(dims) {
            for (other, &factor) in row.iter().enumerate().take(dims + 1) {
                let (into, out) = if back { (other, corner) } else { (corner, other) };
                for k in 0..dims {
                    for (to, value) in half[into * dims + k].iter_mut().zip(&from[out * dims + k]) {
                        *to += factor * value;
                    }
                }
            }
        }
        for (to, half) in to.iter_mut().zip(&half) {
            for (corner, row) in HELMERT.iter().enumerate().take(dims) {
                for (other, &factor) in row.iter().enumerate().take(dims + 1) {
                    let (into, out) = if back { (other, corner) } else { (corner, other) };
                    for k in 0..dims {
                        to[into * dims + k] += factor * half[out * dims + k];
                    }
                }
            }
        }
    }
}
