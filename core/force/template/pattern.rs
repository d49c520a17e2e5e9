//! The fields that templates are made of, at a point.
//!
//! ```text
//! w = exp(-|d|^2 / (2 s^2)),  d = x - c
//! wind      f = a w
//! vortex    f = w/s a x d,  a along z in 2D
//! noise     f = a l curl(w psi),  psi a sum of waves of length 2 pi l that ride on c
//! attract   f = - a w/s rho d,  rho at a face the mean of its two cells
//! ```

use super::dual::{Number, PARTS};
use crate::problem::{Template, TemplateKind};

/// Waves that noise is made of, for each component of its potential.
const WAVES: u32 = 8;

/// The field of a template of amplitude 1, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Pattern {
    /// The form.
    pub kind: TemplateKind,
    /// 2 or 3.
    pub dims: usize,
    /// c.
    pub center: [f64; 3],
    /// s.
    pub radius: f64,
    /// Length of the waves of noise.
    pub size: f64,
    /// Which noise.
    pub seed: u32,
}

/// What the field is computed from at a point.
#[derive(Clone, Copy)]
struct Point<N> {
    /// d = x - c.
    d: [N; 3],
    /// w.
    weight: N,
    /// 1 / s.
    inverse: N,
}

impl Pattern {
    /// That of `template`, which is in scaled numbers.
    #[must_use]
    pub fn new(template: &Template, dims: usize) -> Self {
        let Template {
            kind,
            center,
            radius,
            size,
            seed,
            ..
        } = *template;
        Self {
            kind,
            dims,
            center,
            radius,
            size,
            seed,
        }
    }

    /// Component `axis` of the field at `x`, for each number of the amplitude being 1 alone. Derivatives are those by c along each axis and by
    /// log s.
    pub fn at<N: Number>(&self, axis: usize, x: [f64; 3]) -> [N; 3] {
        let mut d = [N::of(0.0); 3];
        for (part, ((d, x), c)) in d.iter_mut().zip(x).zip(self.center).enumerate().take(self.dims) {
            *d = N::variable(x - c, part, -1.0);
        }
        let inverse = N::variable(self.radius, PARTS - 1, self.radius).inverse();
        let square = d.iter().fold(N::of(0.0), |sum, &d| sum + d * d);
        let weight = (-(square * inverse * inverse * N::of(0.5))).exp();
        let point = Point { d, weight, inverse };
        match self.kind {
            TemplateKind::Wind => core::array::from_fn(|j| if j == axis { weight } else { N::of(0.0) }),
            TemplateKind::Vortex => self.vortex(axis, point),
            TemplateKind::Attract => self.attract(axis, point),
            TemplateKind::Noise => [self.noise(axis, point), N::of(0.0), N::of(0.0)],
        }
    }

    /// (e_j x d) w/s along `axis`.
    fn vortex<N: Number>(&self, axis: usize, point: Point<N>) -> [N; 3] {
        let scale = point.weight * point.inverse;
        let [x, y, z] = point.d.map(|d| d * scale);
        let zero = N::of(0.0);
        let turned = match axis {
            0 => [zero, z, -y],
            1 => [-z, zero, x],
            _ => [y, -x, zero],
        };
        let [_, _, around_z] = turned;
        if self.dims == 2 {
            [around_z, zero, zero]
        } else {
            turned
        }
    }

    /// - d w/s along `axis`, where the density is 1.
    fn attract<N: Number>(&self, axis: usize, point: Point<N>) -> [N; 3] {
        let d = point.d.get(axis).copied().unwrap_or(N::of(0.0));
        [-(d * point.weight * point.inverse), N::of(0.0), N::of(0.0)]
    }

    /// l curl(w psi) along `axis`; in 2D psi stands along z.
    fn noise<N: Number>(&self, axis: usize, point: Point<N>) -> N {
        let scale = N::of(self.size / core::f64::consts::TAU);
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let zero = N::of(0.0);
        let [plus, minus] = match (self.dims, axis) {
            // With psi along z alone nothing changes along z.
            (2, 0) => [self.slope(2, 1, point), zero],
            (2, _) => [zero, self.slope(2, 0, point)],
            _ => [self.slope(last, next, point), self.slope(next, last, point)],
        };
        (plus - minus) * scale
    }

    /// The derivative of w psi along `axis`, where psi is component `which` of the potential.
    fn slope<N: Number>(&self, which: usize, axis: usize, point: Point<N>) -> N {
        let (mut psi, mut along) = (N::of(0.0), N::of(0.0));
        let mut random = Random::new(self.seed, which as u32);
        for _ in 0..WAVES {
            let wave = self.wave(&mut random);
            let phase = N::of(core::f64::consts::TAU * random.next());
            let angle = wave
                .iter()
                .zip(point.d)
                .fold(phase, |sum, (&k, d)| sum + N::of(k) * d);
            let [sine, cosine] = angle.sine_and_cosine();
            psi = psi + cosine;
            along = along - sine * N::of(wave.get(axis).copied().unwrap_or(0.0));
        }
        let d = point.d.get(axis).copied().unwrap_or(N::of(0.0));
        let part = N::of(libm::sqrt(2.0 / f64::from(WAVES)));
        (along - psi * d * point.inverse * point.inverse) * point.weight * part
    }

    /// A wave's direction times 2 pi over its length.
    fn wave(&self, random: &mut Random) -> [f64; 3] {
        let (sine, cosine) = libm::sincos(core::f64::consts::TAU * random.next());
        let up = if self.dims == 2 {
            0.0
        } else {
            2.0 * random.next() - 1.0
        };
        let flat = libm::sqrt(1.0 - up * up);
        [flat * cosine, flat * sine, up].map(|part| part * core::f64::consts::TAU / self.size)
    }
}

/// Numbers that look random: splitmix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn new(seed: u32, which: u32) -> Self {
        Self(u64::from(seed) << 32 | u64::from(which))
    }

    /// From 0 up to but not 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }
}
