//! A plain second implementation of the mathematics (sections 1 to 4), one number at a time in double precision, written
//! from the formulas and not from the core.

use super::{Components, places};
use thurible_core::Scheme;
use thurible_core::grid::Grid;
use thurible_core::transport::Stepping;

/// A box of cells whose fields are read by whole-number places.
#[derive(Clone, Copy)]
pub struct Naive {
    pub grid: Grid,
    /// Kinematic viscosity nu.
    pub viscosity: f64,
    /// Which cells are solid.
    pub solid: Solid,
}

/// Whether a cell is solid.
pub type Solid = fn(&Grid, [usize; 3]) -> bool;

/// Nothing is.
fn nowhere(_: &Grid, _: [usize; 3]) -> bool {
    false
}

impl Naive {
    /// On `grid`, without viscosity.
    pub fn new(grid: &Grid) -> Self {
        Naive {
            grid: *grid,
            viscosity: 0.0,
            solid: nowhere,
        }
    }

    /// On `grid`, among solid cells.
    pub fn among(grid: &Grid, solid: Option<Solid>) -> Self {
        Naive {
            solid: solid.unwrap_or(nowhere),
            ..Naive::new(grid)
        }
    }

    /// The place `by` further along `axis`, or `None` beyond a wall. `faces` counts the high wall face as inside.
    pub fn step(&self, at: [usize; 3], axis: usize, by: isize) -> Option<[usize; 3]> {
        let n = self.grid.n[axis] as isize;
        let i = at[axis] as isize + by;
        let i = if self.grid.axis(axis).is_ring() {
            i.rem_euclid(n)
        } else {
            i
        };
        let mut to = at;
        to[axis] = usize::try_from(i).ok()?;
        (i < n).then_some(to)
    }

    /// The place `by` further along `axis`, one cell at a time and no further than the last one before a wall.
    pub fn walk(&self, at: [usize; 3], axis: usize, by: isize) -> [usize; 3] {
        (0..by.abs()).fold(at, |at, _| self.step(at, axis, by.signum()).unwrap_or(at))
    }

    /// The number of a cell.
    pub fn id(&self, at: [usize; 3]) -> usize {
        (at[2] * self.grid.n[1] + at[1]) * self.grid.n[0] + at[0]
    }

    /// Whether the low face of a cell along `axis` is a wall, or closed by a solid cell.
    pub fn wall(&self, at: [usize; 3], axis: usize) -> bool {
        let is_solid = |at: [usize; 3]| (self.solid)(&self.grid, at);
        self.step(at, axis, -1)
            .is_none_or(|low| is_solid(at) || is_solid(low))
    }

    /// How close the surfaces beside a face are to it, across: the sum of (v - ghost) / (v h^2) over the neighbours that are closed, where the ghost is -v
    /// beyond a surface that is half a cell away, and 0 on one.
    pub fn closeness(&self, solid: &impl Fn([usize; 3]) -> bool, at: [usize; 3], axis: usize) -> f64 {
        let mut sum = 0.0;
        for across in (0..self.grid.dims).filter(|&across| across != axis) {
            for by in [-1, 1] {
                let ghost = self.step(at, across, by).map_or(Some(-1.0), |to| {
                    let pair = [Some(to), self.step(to, axis, -1)].map(|cell| cell.is_none_or(solid));
                    match pair {
                        [true, true] => Some(-1.0),
                        [false, false] => None,
                        _ => Some(0.0),
                    }
                });
                sum += ghost.map_or(0.0, |ghost| 1.0 - ghost) / (self.grid.h[across] * self.grid.h[across]);
            }
        }
        sum
    }

    /// The velocity at the low (0) or high (1) face of a cell.
    pub fn face(&self, v: &Components<f64>, at: [usize; 3], axis: usize, side: isize) -> f64 {
        match self.step(at, axis, side) {
            Some(at) if !self.wall(at, axis) => v[axis][self.id(at)],
            _ => 0.0,
        }
    }

    /// The divergence div v, at cells.
    pub fn divergence(&self, v: &Components<f64>) -> Vec<f64> {
        let sum = |at| {
            (0..self.grid.dims)
                .map(|a| (self.face(v, at, a, 1) - self.face(v, at, a, 0)) / self.grid.h[a])
                .sum()
        };
        places(&self.grid).map(sum).collect()
    }

    /// The gradient grad p, at faces; 0 on walls.
    pub fn gradient(&self, p: &[f64]) -> Components<f64> {
        self.at_faces(|axis, at| {
            let low = self.step(at, axis, -1).map_or(0.0, |low| p[self.id(low)]);
            (p[self.id(at)] - low) / self.grid.h[axis]
        })
    }

    /// A vector field from a formula for the faces that are not walls.
    pub fn at_faces(&self, value: impl Fn(usize, [usize; 3]) -> f64) -> Components<f64> {
        let component = |axis| {
            places(&self.grid)
                .map(|at| if self.wall(at, axis) { 0.0 } else { value(axis, at) })
                .collect()
        };
        core::array::from_fn(|axis| {
            if axis < self.grid.dims {
                component(axis)
            } else {
                Vec::new()
            }
        })
    }

    /// The Courant number of a step of length 1.
    pub fn courant(&self, v: &Components<f64>) -> f64 {
        let of = |at| {
            (0..self.grid.dims)
                .map(|a| {
                    (self.face(v, at, a, 0).abs() + self.face(v, at, a, 1).abs()) / (2.0 * self.grid.h[a])
                })
                .sum()
        };
        super::largest(places(&self.grid).map(of))
    }

    /// C e of the metric, section 4.
    pub fn metric(&self, filters: usize, e: &[f64]) -> Vec<f64> {
        let mut out = e.to_vec();
        for j in 1..=filters {
            let twice = self.gaussian(j, &self.gaussian(j, e));
            out.iter_mut().zip(twice).for_each(|(out, x)| *out += x);
        }
        out
    }

    fn gaussian(&self, j: usize, e: &[f64]) -> Vec<f64> {
        let sigma = f64::from(1u32 << (j - 1));
        let radius = (3.0 * sigma).ceil() as isize;
        let weight = |o: isize| (-0.5 * (o as f64 / sigma).powi(2)).exp();
        let total: f64 = (-radius..=radius).map(weight).sum();
        let mut now = e.to_vec();
        for axis in 0..self.grid.dims {
            let n = self.grid.n[axis] as isize;
            let fold = |i: isize| if self.grid.axis(axis).is_ring() { i.rem_euclid(n) } else { mirrored(i, n) } as usize;
            let blurred = |at: [usize; 3]| {
                let value = |o: isize| {
                    let mut from = at;
                    from[axis] = fold(at[axis] as isize + o);
                    weight(o) / total * now[self.id(from)]
                };
                (-radius..=radius).map(value).sum()
            };
            now = places(&self.grid).map(blurred).collect();
        }
        now
    }
}

/// The limited difference (Koren 1993).
fn koren(c: f64, d: f64) -> f64 {
    let sign = d.signum();
    sign * (2.0 * c * sign)
        .min((c + 2.0 * d) * sign / 3.0)
        .min(2.0 * d * sign)
        .max(0.0)
}

/// Half-sample mirroring at both walls, as often as it takes.
fn mirrored(mut i: isize, n: isize) -> isize {
    while !(0..n).contains(&i) {
        i = if i < 0 { -1 - i } else { 2 * n - 1 - i };
    }
    i
}

/// Density transport, section 3.
impl Naive {
    /// L(v) rho with the fluxes of section 3.
    fn generator(&self, scheme: Scheme, v: &Components<f64>, rho: &[f64]) -> Vec<f64> {
        let flux = |at: [usize; 3], axis: usize| -> f64 {
            let Some(low) = self.step(at, axis, -1) else {
                return 0.0;
            };
            let v = v[axis][self.id(at)];
            let (l, r) = (rho[self.id(low)], rho[self.id(at)]);
            let ll = self.step(low, axis, -1).map_or(l, |at| rho[self.id(at)]);
            let rr = self.step(at, axis, 1).map_or(r, |at| rho[self.id(at)]);
            let face = match scheme {
                Scheme::Central => (l + r) / 2.0,
                Scheme::Limited if v > 0.0 => l + koren(l - ll, r - l) / 2.0,
                Scheme::Limited => r - koren(rr - r, r - l) / 2.0,
                _ if v > 0.0 => (3.0 * r + 6.0 * l - ll) / 8.0,
                _ => (3.0 * l + 6.0 * r - rr) / 8.0,
            };
            v * face
        };
        let cell = |at| {
            (0..self.grid.dims)
                .map(|a| {
                    (flux(at, a) - self.step(at, a, 1).map_or(0.0, |high| flux(high, a))) / self.grid.h[a]
                })
                .sum()
        };
        places(&self.grid).map(cell).collect()
    }

    /// One step rho' = A[rho, v] of length 1; the tolerance is that of `Stepping` times max rho_0.
    pub fn transport(
        &self,
        Stepping {
            scheme,
            tolerance: cut,
            courant,
        }: Stepping,
        v: &Components<f64>,
        rho: &[f64],
    ) -> Vec<f64> {
        let longest = match scheme {
            Scheme::SemiLagrangian => 1.0,
            Scheme::Limited => 0.5 * courant.min(2.0),
            _ => courant,
        };
        let substeps = (self.courant(v) / longest).ceil().max(1.0);
        let tau = 1.0 / substeps;
        let mut rho = rho.to_vec();
        for _ in 0..substeps as usize {
            rho = match scheme {
                Scheme::SemiLagrangian => self.trace(tau, v, &rho),
                Scheme::Limited => self.runge_kutta(tau, v, &rho),
                _ => self.exponential(scheme, cut, tau, v, rho),
            };
        }
        rho
    }

    fn runge_kutta(&self, tau: f64, v: &Components<f64>, rho: &[f64]) -> Vec<f64> {
        let stage = |keep: f64, x: &[f64]| -> Vec<f64> {
            let change = self.generator(Scheme::Limited, v, x);
            let moved = x.iter().zip(&change).map(|(x, change)| x + tau * change);
            rho.iter()
                .zip(moved)
                .map(|(rho, moved)| keep * rho + (1.0 - keep) * moved)
                .collect()
        };
        stage(1.0 / 3.0, &stage(0.75, &stage(0.0, rho)))
    }

    fn exponential(
        &self,
        scheme: Scheme,
        cut: f64,
        tau: f64,
        v: &Components<f64>,
        mut rho: Vec<f64>,
    ) -> Vec<f64> {
        let mut term = rho.clone();
        for k in 1..=20 {
            term = self
                .generator(scheme, v, &term)
                .iter()
                .map(|x| x * tau / f64::from(k))
                .collect();
            rho.iter_mut().zip(&term).for_each(|(rho, x)| *rho += x);
            if super::largest(term.iter().copied()) < cut {
                break;
            }
        }
        rho
    }

    fn trace(&self, tau: f64, v: &Components<f64>, rho: &[f64]) -> Vec<f64> {
        let dims = self.grid.dims;
        let cell = |at: [usize; 3]| {
            let mut sum = 0.0;
            for corner in 0..1usize << dims {
                let (mut weight, mut from) = (1.0, at);
                for a in 0..dims {
                    let n = self.grid.n[a] as isize;
                    let speed = (self.face(v, at, a, 0) + self.face(v, at, a, 1)) / 2.0;
                    let place = at[a] as f64 - tau * speed / self.grid.h[a];
                    let place = if self.grid.axis(a).is_ring() {
                        place
                    } else {
                        place.clamp(0.0, (n - 1) as f64)
                    };
                    let part = place - place.floor();
                    let high = corner >> a & 1 == 1;
                    weight *= if high { part } else { 1.0 - part };
                    from[a] = (place.floor() as isize + isize::from(high)).rem_euclid(n) as usize;
                }
                sum += if weight == 0.0 {
                    0.0
                } else {
                    weight * rho[self.id(from)]
                };
            }
            sum
        };
        places(&self.grid).map(cell).collect()
    }
}
