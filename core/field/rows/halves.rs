//! Rows of two numbers in each element: see [`Real::of_halves`].

use super::LANES;
use crate::real::Real;
use crate::simd::multiversion;

multiversion! {
    /// `out = (t x, y - z)`, in halves.
    pub fn keep_halves[T: Real](out: &mut [T], t: T, x: &[T], y: &[T], z: &[T]) {
        for (((o, &x), &y), &z) in out.iter_mut().zip(x).zip(y).zip(z) {
            *o = T::of_halves([t * x, y - z]);
        }
    }
}

multiversion! {
    /// `out += s x + t y` for (x, y) in halves.
    pub fn add_halves[T: Real](out: &mut [T], factors: [T; 2], both: &[T]) {
        let [s, t] = factors;
        for (o, both) in out.iter_mut().zip(both) {
            let [x, y] = both.halves();
            *o += s * x + t * y;
        }
    }
}

multiversion! {
    /// As [`add_products`](super::add_products), of x and of y for (x, y) in halves.
    pub fn add_products_of_halves[T: Real](lanes: &mut [[f64; LANES]; 2], both: &[T], factor: &[T]) {
        let [mut of_x, mut of_y] = *lanes;
        let (wholes, factors) = (both.chunks_exact(LANES), factor.chunks_exact(LANES));
        let rest = wholes.remainder().iter().zip(factors.remainder());
        for (both, factor) in wholes.zip(factors) {
            for l in 0..LANES {
                let ([x, y], factor) = (both[l].halves(), factor[l].to_f64());
                of_x[l] += x.to_f64() * factor;
                of_y[l] += y.to_f64() * factor;
            }
        }
        for (l, (both, &factor)) in rest.enumerate() {
            let ([x, y], factor) = (both.halves(), factor.to_f64());
            of_x[l] += x.to_f64() * factor;
            of_y[l] += y.to_f64() * factor;
        }
        *lanes = [of_x, of_y];
    }
}
