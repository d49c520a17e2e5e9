//! The limiter, the density at a face, and their derivatives, lane by lane.

use crate::real::Real;
use crate::simd::Vector;

/// Numbers that the limiter needs.
#[derive(Clone, Copy)]
pub struct Numbers<V> {
    pub zero: V,
    pub half: V,
    one: V,
    two: V,
    third: V,
    two_thirds: V,
    two_fifths: V,
    four: V,
}

impl<V: Copy> Numbers<V> {
    /// The same numbers in every lane.
    #[inline(always)]
    pub fn new<T: Real>() -> Self
    where
        V: Vector<Elem = T>,
    {
        let splat = |x: f64| V::splat(T::from_f64(x));
        Self {
            zero: splat(0.0),
            half: splat(0.5),
            one: splat(1.0),
            two: splat(2.0),
            third: splat(1.0 / 3.0),
            two_thirds: splat(2.0 / 3.0),
            two_fifths: splat(0.4),
            four: splat(4.0),
        }
    }

    /// lim(c, d): what is smallest of 2 c, (c + 2 d) / 3 and 2 d where c and d have one sign, else 0.
    #[inline(always)]
    fn limited(self, c: V, d: V) -> V
    where
        V: Vector,
    {
        let (at_c, mean, at_d) = (c + c, (c + d + d) * self.third, d + d);
        let rising = at_c.min(mean).min(at_d).max(self.zero);
        let falling = at_c.max(mean).max(at_d).min(self.zero);
        rising + falling
    }

    /// The derivatives of lim(c, d) by c and by d, of the branch that is taken. The three are equal at c = 2/5 d and at c = 4 d.
    #[inline(always)]
    fn slopes(self, c: V, d: V) -> [V; 2]
    where
        V: Vector,
    {
        let sign = d.select(self.one, -self.one);
        let (c, d) = (c * sign, d * sign);
        let (above_first, above_second) = (d * self.two_fifths - c, d * self.four - c);
        let by_c = above_first.select(self.two, above_second.select(self.third, self.zero));
        let by_d = above_first.select(self.zero, above_second.select(self.two_thirds, self.two));
        [c.select(by_c, self.zero), c.select(by_d, self.zero)]
    }

    /// rho_f at a face with the cells a b | c d around it, through which `v` flows; either side's where nothing flows.
    #[inline(always)]
    pub fn at_face(self, [a, b, c, d]: [V; 4], v: V) -> V
    where
        V: Vector,
    {
        let across = c - b;
        let half = self.half * self.limited(v.select(b - a, d - c), across);
        v.select(b + half, c - half)
    }

    /// As [`Self::at_face`], the mean of both sides' where v is exactly 0.
    #[inline(always)]
    pub fn by_velocity(self, around: [V; 4], v: V) -> V
    where
        V: Vector,
    {
        let (upward, downward) = (self.at_face(around, self.one), self.at_face(around, -self.one));
        v.select(upward, (-v).select(downward, self.half * (upward + downward)))
    }

    /// The sum over the faces around cell c, among y = a b c d e, of v_f times the derivative of rho_f by c times the change of z
    /// across the face: L^T z in units of h.
    #[inline(always)]
    pub fn outflow(self, y: [V; 5], z: [V; 5], faces: [V; 4]) -> V
    where
        V: Vector,
    {
        let [before, low, high, after] = faces;
        let across: [V; 4] = [y[1] - y[0], y[2] - y[1], y[3] - y[2], y[4] - y[3]];
        let [c, d] = self.slopes(low.select(across[0], across[2]), across[1]);
        let as_right = low.select(self.half * d, self.one + self.half * (c - d));
        let [c, d] = self.slopes(high.select(across[1], across[3]), across[2]);
        let as_left = high.select(self.one + self.half * (c - d), self.half * d);
        let [far_left, _] = self.slopes(across[2], across[3]);
        let [far_right, _] = self.slopes(across[1], across[0]);
        let near = low * as_right * (z[2] - z[1]) + high * as_left * (z[3] - z[2]);
        let beyond = after.max(self.zero) * far_left * (z[4] - z[3])
            + before.min(self.zero) * far_right * (z[1] - z[0]);
        near - self.half * beyond
    }
}
