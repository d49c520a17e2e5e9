//! Plaquettes (mathematics section 2): where vorticity lives, and how what happens there reaches the faces around.
//!
//! For the ordered axis pair (a, b) a plaquette is a corner (2D) or edge (3D) with four faces: A-, A+ are the a-faces half
//! a cell below and above it along b; B-, B+ the b-faces half a cell below and above it along a. Plaquette `i` is at the
//! low corner of cell `i`, so its A+ and B+ are the faces `i`. Plaquettes on walls do nothing (free slip), nor those at
//! closed faces of solid cells.

use crate::field::{Block, Vector, rows};
use crate::grid::geometry::Beyond;
use crate::grid::solids::{Solids, dead};
use crate::grid::{Side, Space};
use crate::real::Real;
use crate::simd::multiversion;

/// The four faces of plaquettes: A-, A+, B-, B+.
pub type Quad<'a, T> = [&'a [T]; 4];

/// The four velocities at a plaquette, and what follows from them.
#[derive(Clone, Copy, Debug)]
pub struct Plaquette<T> {
    /// Vorticity, (B+ - B-) / h_a - (A+ - A-) / h_b.
    pub omega: T,
    /// (A- + A+) / 2.
    pub abar: T,
    /// (B- + B+) / 2.
    pub bbar: T,
}

impl<T: Copy + core::ops::Add<Output = T> + core::ops::Sub<Output = T> + core::ops::Mul<Output = T>>
    Plaquette<T>
{
    /// From the velocities at A-, A+, B-, B+; `inverse` holds 1 / h_a and 1 / h_b.
    #[inline(always)]
    pub fn new(a: [T; 2], b: [T; 2], inverse: [T; 2], half: T) -> Self {
        Self {
            omega: (b[1] - b[0]) * inverse[0] - (a[1] - a[0]) * inverse[1],
            abar: (a[0] + a[1]) * half,
            bbar: (b[0] + b[1]) * half,
        }
    }
}

/// What happens at a row of plaquettes: four rows of contributions to A-, A+, B-, B+.
pub trait Rule<T>: Copy {
    /// Reads the velocities at four faces (and those of a second field) and overwrites the four contributions.
    fn contribute(self, velocity: Quad<'_, T>, second: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]);

    /// The nu by which the flow [sticks](super::sticking) to surfaces: 0 of what sticks to none.
    fn sticking(self) -> T;
}

/// Adv(v) + nu C^T C v: A gets -omega bbar / 2, B gets +omega abar / 2, and nu omega / h on A- and B+, minus that on A+ and B-.
/// It holds nu.
#[derive(Clone, Copy, Debug)]
pub struct Advection<T>(pub T);

multiversion! {
    fn advection[T: Real](viscosity: T, v: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]) {
        let [am_out, ap_out, bm_out, bp_out] = out;
        let n = am_out.len();
        let (ap_out, bm_out, bp_out) = (&mut ap_out[..n], &mut bm_out[..n], &mut bp_out[..n]);
        let [am, ap, bm, bp] = v.map(|row| &row[..n]);
        for i in 0..n {
            let p = Plaquette::new([am[i], ap[i]], [bm[i], bp[i]], inverse, T::HALF);
            let (half, drag) = (p.omega * T::HALF, viscosity * p.omega);
            let (on_a, on_b) = (-(half * p.bbar), half * p.abar);
            am_out[i] = on_a + drag * inverse[1];
            ap_out[i] = on_a - drag * inverse[1];
            bm_out[i] = on_b - drag * inverse[0];
            bp_out[i] = on_b + drag * inverse[0];
        }
    }
}

impl<T: Real> Rule<T> for Advection<T> {
    fn contribute(self, velocity: Quad<'_, T>, _second: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]) {
        advection(self.0, velocity, inverse, out);
    }

    fn sticking(self) -> T {
        self.0
    }
}

/// J(v) d + nu C^T C d: the derivative of [`Advection`] at v along the second field d; it holds nu.
#[derive(Clone, Copy, Debug)]
pub struct Derivative<T>(pub T);

multiversion! {
    fn derivative[T: Real](viscosity: T, v: Quad<'_, T>, d: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]) {
        let [am_out, ap_out, bm_out, bp_out] = out;
        let n = am_out.len();
        let (ap_out, bm_out, bp_out) = (&mut ap_out[..n], &mut bm_out[..n], &mut bp_out[..n]);
        let [am, ap, bm, bp] = v.map(|row| &row[..n]);
        let [dam, dap, dbm, dbp] = d.map(|row| &row[..n]);
        for i in 0..n {
            let p = Plaquette::new([am[i], ap[i]], [bm[i], bp[i]], inverse, T::HALF);
            let dp = Plaquette::new([dam[i], dap[i]], [dbm[i], dbp[i]], inverse, T::HALF);
            let drag = viscosity * dp.omega;
            let (on_a, on_b) = (-(T::HALF * (dp.omega * p.bbar + p.omega * dp.bbar)), T::HALF * (dp.omega * p.abar + p.omega * dp.abar));
            am_out[i] = on_a + drag * inverse[1];
            ap_out[i] = on_a - drag * inverse[1];
            bm_out[i] = on_b - drag * inverse[0];
            bp_out[i] = on_b + drag * inverse[0];
        }
    }
}

impl<T: Real> Rule<T> for Derivative<T> {
    fn contribute(self, velocity: Quad<'_, T>, second: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]) {
        derivative(self.0, velocity, second, inverse, out);
    }

    fn sticking(self) -> T {
        self.0
    }
}

/// J(v)^T m + nu C^T C m for the second field m: the adjoint of [`Derivative`]. It holds nu.
#[derive(Clone, Copy, Debug)]
pub struct Adjoint<T>(pub T);

multiversion! {
    fn adjoint[T: Real](viscosity: T, v: Quad<'_, T>, m: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]) {
        let [am_out, ap_out, bm_out, bp_out] = out;
        let n = am_out.len();
        let (ap_out, bm_out, bp_out) = (&mut ap_out[..n], &mut bm_out[..n], &mut bp_out[..n]);
        let [am, ap, bm, bp] = v.map(|row| &row[..n]);
        let [mam, map, mbm, mbp] = m.map(|row| &row[..n]);
        for i in 0..n {
            let p = Plaquette::new([am[i], ap[i]], [bm[i], bp[i]], inverse, T::HALF);
            let mp = Plaquette::new([mam[i], map[i]], [mbm[i], mbp[i]], inverse, T::HALF);
            let (ma, mb) = (-mp.abar, mp.bbar);
            let g = ma * p.bbar + mb * p.abar + viscosity * mp.omega;
            let (spread_a, spread_b) = (mb * p.omega * T::HALF, ma * p.omega * T::HALF);
            am_out[i] = spread_a + g * inverse[1];
            ap_out[i] = spread_a - g * inverse[1];
            bm_out[i] = spread_b - g * inverse[0];
            bp_out[i] = spread_b + g * inverse[0];
        }
    }
}

impl<T: Real> Rule<T> for Adjoint<T> {
    fn contribute(self, velocity: Quad<'_, T>, second: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]) {
        adjoint(self.0, velocity, second, inverse, out);
    }

    fn sticking(self) -> T {
        self.0
    }
}

/// J(v)^T m alone, as [`Adjoint`] without viscosity.
#[derive(Clone, Copy, Debug)]
pub struct Bend;

impl<T: Real> Rule<T> for Bend {
    fn contribute(self, velocity: Quad<'_, T>, second: Quad<'_, T>, inverse: [T; 2], out: [&mut [T]; 4]) {
        Adjoint(T::ZERO).contribute(velocity, second, inverse, out);
    }

    fn sticking(self) -> T {
        T::ZERO
    }
}

/// Rows of scratch that [`accumulate`] needs, and the most rows of vorticity around those of the faces, which [`drag`](super::drag) gathers from.
pub const SCRATCH_ROWS: usize = 7;

/// Adds what all plaquettes do to the faces of `row`: `out[a] +=` the contributions of `rule` at v and `second`.
///
/// `scratch` holds [`SCRATCH_ROWS`] rows of the block.
pub fn accumulate<T: Real, S: Space, R: Rule<T>>(
    (block, row, solids): (&Block<'_>, usize, Solids<'_>),
    rule: R,
    v: Vector<'_, T>,
    second: Vector<'_, T>,
    out: &mut [&mut [T]; 3],
    scratch: &mut [T],
) {
    let mut work = Work::new(block, solids, scratch);
    for (pair, &(a, b)) in S::PAIRS.iter().enumerate() {
        let pair = (pair, (a, b));
        if work.evaluate(block, row, pair, rule, v, second) {
            rows::add(out[a], work.out[1]);
            rows::add(out[b], work.out[3]);
            work.add_shifted(block, (a, b), out);
        }
        for (along, other, minus) in [(b, a, 0), (a, b, 2)] {
            let Some(next) = (along > 0)
                .then(|| block.grid.neighbour(row, along, Side::High))
                .flatten()
            else {
                continue;
            };
            if work.evaluate(block, next, pair, rule, v, second) {
                rows::add(out[other], work.out[minus]);
            }
        }
    }
}

/// The rows of scratch by use.
struct Work<'a, T> {
    out: [&'a mut [T]; 4],
    shifted: [&'a mut [T]; 3],
    solids: Solids<'a>,
}

impl<'a, T: Real> Work<'a, T> {
    fn new(block: &Block<'_>, solids: Solids<'a>, scratch: &'a mut [T]) -> Self {
        let mut parts = scratch.chunks_exact_mut(block.len());
        debug_assert!(parts.len() >= SCRATCH_ROWS);
        let mut next = || parts.next().unwrap_or(&mut []);
        Self {
            out: core::array::from_fn(|_| next()),
            shifted: core::array::from_fn(|_| next()),
            solids,
        }
    }

    /// The contributions of the plaquettes of `row`, or false when they are all on a wall.
    fn evaluate<R: Rule<T>>(
        &mut self,
        block: &Block<'_>,
        row: usize,
        (pair, (a, b)): (usize, (usize, usize)),
        rule: R,
        v: Vector<'_, T>,
        second: Vector<'_, T>,
    ) -> bool {
        let grid = block.grid;
        if [a, b].iter().any(|&axis| axis > 0 && grid.wall_below(row, axis)) {
            return false;
        }
        let [low_v, low_second, _] = &mut self.shifted;
        let quad_v = quad(block, row, (a, b), v, low_v);
        let quad_second = if second[a].is_empty() {
            [&[][..]; 4]
        } else {
            quad(block, row, (a, b), second, low_second)
        };
        let inverse = [T::from_f64(1.0 / grid.h[a]), T::from_f64(1.0 / grid.h[b])];
        rule.contribute(
            quad_v,
            quad_second,
            inverse,
            self.out.each_mut().map(|row| &mut **row),
        );
        if a == 0 || b == 0 {
            self.out
                .iter_mut()
                .for_each(|values| block.clear_closed(0, row, values));
        }
        if self.solids.there() {
            let solids = self.solids;
            let all = self.out.iter_mut();
            all.for_each(|values| solids.clear(grid.n[0], row, dead(pair), values));
        }
        true
    }

    /// The contributions to A- and B- of the faces one plaquette back along x.
    fn add_shifted(&mut self, block: &Block<'_>, (a, b): (usize, usize), out: &mut [&mut [T]; 3]) {
        for (along, other, minus) in [(b, a, 0), (a, b, 2)] {
            if along == 0 {
                block.shift(Side::High, Beyond::Zero, self.out[minus], self.shifted[2]);
                rows::add(out[other], self.shifted[2]);
            }
        }
    }
}

/// The faces A-, A+, B-, B+ of the plaquettes of `row`, which is not on a wall along y or z; those one back along x go to `shifted`.
fn quad<'a, T: Real>(
    block: &Block<'_>,
    row: usize,
    (a, b): (usize, usize),
    v: Vector<'a, T>,
    shifted: &'a mut [T],
) -> Quad<'a, T> {
    let (ap, bp) = (block.of(v[a], row), block.of(v[b], row));
    // At most one of the axes is x, so that one row of scratch serves both.
    let (of_a, of_b) = if b == 0 {
        (shifted, &mut [][..])
    } else {
        (&mut [][..], shifted)
    };
    let am = block.beside((b, Side::Low), Beyond::Zero, v[a], row, of_a);
    let bm = block.beside((a, Side::Low), Beyond::Zero, v[b], row, of_b);
    [am.unwrap_or(ap), ap, bm.unwrap_or(bp), bp]
}
