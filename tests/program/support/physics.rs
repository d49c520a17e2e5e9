//! The discrete operators of the method, written a second time, plainly, from mathematics.md.

use super::field::{Field, indices, with};

/// The box: cells (1 along an axis that is not there), dimension, periodic axes, cell size.
#[derive(Clone, Debug)]
pub struct Grid {
    pub cells: [usize; 3],
    pub axes: usize,
    pub periodic: [bool; 3],
    pub h: f64,
}

/// A plaquette: its four faces (A-, A+, B-, B+) and omega.
struct Plaquette {
    a: [[usize; 3]; 2],
    b: [[usize; 3]; 2],
    omega: f64,
}

impl Grid {
    /// Size of the array of faces normal to `axis`.
    pub fn faces(&self, axis: usize) -> [usize; 3] {
        with(
            self.cells,
            axis,
            self.cells[axis] + usize::from(!self.periodic[axis]),
        )
    }

    fn pairs(&self) -> &'static [(usize, usize)] {
        if self.axes == 2 {
            &[(0, 1)]
        } else {
            &[(0, 1), (1, 2), (2, 0)]
        }
    }

    /// The index of the high face of cell `index` along `axis`.
    fn high(&self, axis: usize, index: usize) -> usize {
        if self.periodic[axis] {
            (index + 1) % self.cells[axis]
        } else {
            index + 1
        }
    }

    pub fn divergence(&self, v: &[Field]) -> Field {
        let mut out = Field::zeros(self.cells);
        for at in indices(self.cells) {
            let sum: f64 = v
                .iter()
                .enumerate()
                .map(|(axis, f)| f.at(with(at, axis, self.high(axis, at[axis]))) - f.at(at))
                .sum();
            out.add(at, sum / self.h);
        }
        out
    }

    /// The cell `step` cells from face `index`: 0 is its high cell, -1 its low one; clamped at walls.
    fn cell(&self, axis: usize, index: usize, step: isize) -> usize {
        let count = self.cells[axis] as isize;
        let cell = index as isize + step;
        (if self.periodic[axis] {
            cell.rem_euclid(count)
        } else {
            cell.clamp(0, count - 1)
        }) as usize
    }

    /// The density at the faces of an axis: the mean of its two cells, 0 on walls.
    pub fn at_faces(&self, rho: &Field, axis: usize) -> Field {
        let mut out = Field::zeros(self.faces(axis));
        for at in indices(out.size) {
            let wall = !self.periodic[axis] && [0, self.cells[axis]].contains(&at[axis]);
            let cell = |step| rho.at(with(at, axis, self.cell(axis, at[axis], step)));
            if !wall {
                out.add(at, 0.5 * (cell(-1) + cell(0)));
            }
        }
        out
    }

    /// The rate of change of the density, L(v) rho.
    pub fn transport(&self, rho: &Field, v: &[Field], scheme: &str) -> Field {
        let mut out = Field::zeros(self.cells);
        for (axis, speeds) in v.iter().enumerate() {
            for at in indices(speeds.size) {
                let value = |step| rho.at(with(at, axis, self.cell(axis, at[axis], step)));
                let speed = speeds.at(at);
                let face = match (scheme, speed > 0.0) {
                    ("central", _) => 0.5 * (value(-1) + value(0)),
                    ("limited", true) => {
                        value(-1) + 0.5 * limited(value(-1) - value(-2), value(0) - value(-1))
                    }
                    ("limited", false) => value(0) - 0.5 * limited(value(1) - value(0), value(0) - value(-1)),
                    (_, true) => (3.0 * value(0) + 6.0 * value(-1) - value(-2)) / 8.0,
                    (_, false) => (3.0 * value(-1) + 6.0 * value(0) - value(1)) / 8.0,
                };
                let flux = speed * face / self.h;
                if self.periodic[axis] || at[axis] < self.cells[axis] {
                    out.add(with(at, axis, self.cell(axis, at[axis], 0)), flux);
                }
                if self.periodic[axis] || at[axis] > 0 {
                    out.add(with(at, axis, self.cell(axis, at[axis], -1)), -flux);
                }
            }
        }
        out
    }

    /// A[rho, v]: the exponential series, in sub-steps of Courant number at most 1; three Runge-Kutta stages at most 1/2 where limited.
    pub fn advect(&self, mut rho: Field, v: &[Field], dt: f64, scheme: &str, cut: f64) -> Field {
        let speed = |at: [usize; 3]| -> f64 {
            let faces = v.iter().enumerate();
            faces
                .map(|(axis, f)| f.at(at).abs() + f.at(with(at, axis, self.high(axis, at[axis]))).abs())
                .sum()
        };
        let courant = indices(self.cells).map(speed).fold(0.0, f64::max) * dt / (2.0 * self.h);
        if scheme == "limited" {
            let parts = (2.0 * courant).ceil().max(1.0);
            for _ in 0..parts as usize {
                let stage = |keep: f64, from: &Field| {
                    let mut to = self.transport(from, v, scheme);
                    for ((to, from), rho) in to.data.iter_mut().zip(&from.data).zip(&rho.data) {
                        *to = keep * rho + (1.0 - keep) * (from + dt / parts * *to);
                    }
                    to
                };
                rho = stage(1.0 / 3.0, &stage(0.75, &stage(0.0, &rho)));
            }
            return rho;
        }
        let parts = courant.ceil().max(1.0);
        for _ in 0..parts as usize {
            let mut term = rho.clone();
            for k in 1..60 {
                term = self.transport(&term, v, scheme);
                term.data
                    .iter_mut()
                    .for_each(|value| *value *= dt / parts / f64::from(k));
                rho.data
                    .iter_mut()
                    .zip(&term.data)
                    .for_each(|(sum, part)| *sum += part);
                if term.max_abs() < cut {
                    break;
                }
            }
        }
        rho
    }

    /// Calls `visit` for every plaquette of the axis pair (a, b); those on walls are left out.
    fn plaquettes(&self, v: &[Field], a: usize, b: usize, mut visit: impl FnMut(Plaquette)) {
        for at in indices(self.cells) {
            if [a, b].iter().any(|&axis| !self.periodic[axis] && at[axis] == 0) {
                continue;
            }
            let below = |axis| with(at, axis, self.cell(axis, at[axis], -1));
            let plaquette = Plaquette {
                a: [below(b), at],
                b: [below(a), at],
                omega: 0.0,
            };
            let [a_low, a_high] = plaquette.a.map(|face| v[a].at(face));
            let [b_low, b_high] = plaquette.b.map(|face| v[b].at(face));
            visit(Plaquette {
                omega: (b_high - b_low - a_high + a_low) / self.h,
                ..plaquette
            });
        }
    }

    /// Adv[v] = (curl v) x v.
    pub fn self_advection(&self, v: &[Field]) -> Vec<Field> {
        let mut out: Vec<Field> = v.iter().map(|component| Field::zeros(component.size)).collect();
        for &(a, b) in self.pairs() {
            self.plaquettes(v, a, b, |p| {
                let mean_a = 0.5 * (v[a].at(p.a[0]) + v[a].at(p.a[1]));
                let mean_b = 0.5 * (v[b].at(p.b[0]) + v[b].at(p.b[1]));
                p.a.iter()
                    .for_each(|&face| out[a].add(face, -0.5 * p.omega * mean_b));
                p.b.iter()
                    .for_each(|&face| out[b].add(face, 0.5 * p.omega * mean_a));
            });
        }
        out
    }

    /// C^T C v, C the curl at the plaquettes.
    pub fn curl_curl(&self, v: &[Field]) -> Vec<Field> {
        let mut out: Vec<Field> = v.iter().map(|component| Field::zeros(component.size)).collect();
        for &(a, b) in self.pairs() {
            self.plaquettes(v, a, b, |p| {
                p.a.iter()
                    .zip([1.0, -1.0])
                    .for_each(|(&face, sign)| out[a].add(face, sign * p.omega / self.h));
                p.b.iter()
                    .zip([-1.0, 1.0])
                    .for_each(|(&face, sign)| out[b].add(face, sign * p.omega / self.h));
            });
        }
        out
    }

    /// What walls to which the flow sticks add to minus the Laplacian: 2 v / h^2 at faces beside one.
    pub fn sticking(&self, v: &[Field]) -> Vec<Field> {
        let beside = |axis: usize, at: [usize; 3]| {
            let across = (0..self.axes).filter(|&b| b != axis && !self.periodic[b]);
            across
                .map(|b| usize::from(at[b] == 0) + usize::from(at[b] == self.cells[b] - 1))
                .sum::<usize>()
        };
        let of = |(axis, v): (usize, &Field)| {
            let mut out = Field::zeros(v.size);
            indices(v.size).for_each(|at| {
                out.add(at, 2.0 * beside(axis, at) as f64 * v.at(at) / (self.h * self.h));
            });
            out
        };
        v.iter().enumerate().map(of).collect()
    }

    /// max |omega|, the largest vorticity.
    pub fn curl_max(&self, v: &[Field]) -> f64 {
        let mut max = 0.0_f64;
        for &(a, b) in self.pairs() {
            self.plaquettes(v, a, b, |p| {
                max = if p.omega.is_nan() {
                    f64::NAN
                } else {
                    max.max(p.omega.abs())
                }
            });
        }
        max
    }

    /// G_j with sigma = `sigma` cells.
    pub fn blur(&self, field: &Field, sigma: f64) -> Field {
        let reach = (3.0 * sigma).ceil() as isize;
        let weights: Vec<f64> = (-reach..=reach)
            .map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp())
            .collect();
        let total: f64 = weights.iter().sum();
        let mut field = field.clone();
        for axis in 0..self.axes {
            let mut out = Field::zeros(self.cells);
            for at in indices(self.cells) {
                let tap = |k: isize| field.at(with(at, axis, self.mirrored(axis, at[axis] as isize + k)));
                let sum: f64 = (-reach..=reach)
                    .zip(&weights)
                    .map(|(k, weight)| weight * tap(k))
                    .sum();
                out.add(at, sum / total);
            }
            field = out;
        }
        field
    }

    fn mirrored(&self, axis: usize, index: isize) -> usize {
        let count = self.cells[axis] as isize;
        if self.periodic[axis] {
            return index.rem_euclid(count) as usize;
        }
        let folded = index.rem_euclid(2 * count);
        (if folded >= count {
            2 * count - 1 - folded
        } else {
            folded
        }) as usize
    }

    /// The squared norm <e, C e> of an error of the density.
    pub fn metric(&self, e: &Field, filters: usize) -> f64 {
        let mut out = e.clone();
        for j in 0..filters {
            let sigma = (1_u32 << j).into();
            let blurred = self.blur(&self.blur(e, sigma), sigma);
            out.data
                .iter_mut()
                .zip(&blurred.data)
                .for_each(|(sum, part)| *sum += part);
        }
        out.data
            .iter()
            .zip(&e.data)
            .map(|(left, right)| left * right)
            .sum()
    }
}

/// The limited difference (Koren 1993).
fn limited(c: f64, d: f64) -> f64 {
    let sign = d.signum();
    sign * (2.0 * c * sign)
        .min((c + 2.0 * d) * sign / 3.0)
        .min(2.0 * d * sign)
        .max(0.0)
}
