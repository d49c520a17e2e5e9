//! The limiter, the density at a face, and their derivatives, lane by lane.

use super::super::kernel::around;
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

/// Which of four faces around cells at `i` are open; anything where that is not read.
#[inline(always)]
pub fn opening<T: Real, V: Vector<Elem = T>, const SOLIDS: bool>(
    open: &[&[T]; 4],
    i: usize,
    unread: V,
) -> [V; 4] {
    if SOLIDS {
        [
            V::at(open[0], i),
            V::at(open[1], i),
            V::at(open[2], i),
            V::at(open[3], i),
        ]
    } else {
        [unread; 4]
    }
}

/// The differences across the four faces between the cells a b c d e; with 1 or 0 at the faces, none across those that are closed.
#[inline(always)]
pub fn differences<V: Vector, const SOLIDS: bool>([a, b, c, d, e]: [V; 5], open: [V; 4]) -> [V; 4] {
    let across = [b - a, c - b, d - c, e - d];
    if SOLIDS {
        let [before, below, above, after] = across;
        [
            before * open[0],
            below * open[1],
            above * open[2],
            after * open[3],
        ]
    } else {
        across
    }
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

    /// rho_f at a face with the cells b | c beside it, through which `v` flows; either side's where nothing flows. `differences` are those
    /// across the face before it, itself and the face after it.
    #[inline(always)]
    pub fn at_face(self, [b, c]: [V; 2], differences: [V; 3], v: V) -> V
    where
        V: Vector,
    {
        let [before, across, after] = differences;
        let half = self.half * self.limited(v.select(before, after), across);
        v.select(b + half, c - half)
    }

    /// As [`Self::at_face`], the mean of both sides' where v is exactly 0.
    #[inline(always)]
    pub fn by_velocity(self, beside: [V; 2], differences: [V; 3], v: V) -> V
    where
        V: Vector,
    {
        let upward = self.at_face(beside, differences, self.one);
        let downward = self.at_face(beside, differences, -self.one);
        v.select(upward, (-v).select(downward, self.half * (upward + downward)))
    }

    /// The sum over the faces around a cell of v_f times the derivative of rho_f by the cell times the change of z across the face: L^T z in
    /// units of h. `across` are the differences of what flows across the faces before, below, above and after the cell. Among solid cells
    /// `open` is 0 at faces across which nothing differs, whatever the cells are: an exit has a flow all the same.
    #[inline(always)]
    pub fn outflow<const SOLIDS: bool>(self, across: [V; 4], z: [V; 5], faces: [V; 4], open: [V; 4]) -> V
    where
        V: Vector,
    {
        let own = |d: V, open: V| if SOLIDS { d * open } else { d };
        let [before, low, high, after] = faces;
        let [c, d] = self.slopes(low.select(across[0], across[2]), across[1]);
        let d = own(d, open[1]);
        let as_right = low.select(self.half * d, self.one + self.half * (c - d));
        let [c, d] = self.slopes(high.select(across[1], across[3]), across[2]);
        let d = own(d, open[2]);
        let as_left = high.select(self.one + self.half * (c - d), self.half * d);
        let [far_left, _] = self.slopes(across[2], across[3]);
        let [far_right, _] = self.slopes(across[1], across[0]);
        let near = low * as_right * (z[2] - z[1]) + high * as_left * (z[3] - z[2]);
        let beyond = after.max(self.zero) * far_left * (z[4] - z[3])
            + before.min(self.zero) * far_right * (z[1] - z[0]);
        near - self.half * beyond
    }
}

/// The inflow to cell c of the cells a b c d e through its faces, low and high.
/// `open` is read among solid cells alone: 1 or 0 at the faces before, below, above and after c.
#[inline(always)]
pub fn inflow<V: Vector, const SOLIDS: bool>(
    numbers: Numbers<V>,
    cells: [V; 5],
    [low, high]: [V; 2],
    open: [V; 4],
) -> V {
    let [before, below, above, after] = differences::<V, SOLIDS>(cells, open);
    let [_, b, c, d, _] = cells;
    low * numbers.at_face([b, c], [before, below, above], low)
        - high * numbers.at_face([c, d], [below, above, after], high)
}

/// The inflow along y or z to cells `c` at `i` of a row, from the rows of cells at -2, -1, 1, 2 and of faces at -1, 0, 1, 2.
#[inline(always)]
pub fn inflow_across<T: Real, V: Vector<Elem = T>, const SOLIDS: bool>(
    numbers: Numbers<V>,
    i: usize,
    c: V,
    cells: &[&[T]; 4],
    faces: &[&[T]; 4],
    open: &[&[T]; 4],
) -> V {
    let through = [V::at(faces[1], i), V::at(faces[2], i)];
    inflow::<V, SOLIDS>(
        numbers,
        around(cells, i, c),
        through,
        opening::<T, V, SOLIDS>(open, i, c),
    )
}
