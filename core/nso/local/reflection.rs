//! H = 1 - u u^T, the Householder reflection of each combination of walls (Golub & Van Loan, Matrix
//! Computations, section 5.1), and the normal g that it turns on e_p. p is a face along y, which is free in
//! all cells of a row or in none.
//!
//! Solid cells close faces here and there, so p may be closed among them. H turns g on e_p all the same, and e_p on g: the
//! closed face is then one of the unknowns, mixed with others. Nothing couples with it, so it comes out as 0 but for rounding.
//! Where all faces are closed H is 1, and nothing changes.

use super::lanes::{at, unroll};
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;

/// The faces along y: p is the one below, or above where there is a wall below.
pub(super) const BELOW: usize = 2;
pub(super) const ABOVE: usize = 3;

/// Offsets in a row of the table: for each face u (that of p in the place of the face below), g, and 1 where
/// the face is free; then three scalars.
pub(super) struct Place<S>(core::marker::PhantomData<S>);
impl<S: Space> Place<S> {
    pub(super) const REFLECTION: usize = 0;
    pub(super) const NORMAL: usize = S::FACES;
    pub(super) const FREE: usize = 2 * S::FACES;
    /// 1 / |g|^2.
    pub(super) const INVERSE: usize = 3 * S::FACES;
    /// u = ALONG g + ACROSS e_p.
    pub(super) const ALONG: usize = Self::INVERSE + 1;
    pub(super) const ACROSS: usize = Self::ALONG + 1;
    pub(super) const SIZE: usize = Self::ACROSS + 1;
}

/// Values of the table of reflections, which has a row for each combination of walls.
#[must_use]
pub fn table_len<S: Space>() -> usize {
    Place::<S>::SIZE << (2 * S::DIM)
}

/// g of a cell of size `h` with a bit for each face that is a wall.
fn normal<S: Space>(h: [f64; 3], walls: usize) -> [f64; 6] {
    let mut g = [0.0; 6];
    for (f, g) in g.iter_mut().enumerate().take(S::FACES) {
        *g = if walls >> f & 1 == 1 {
            0.0
        } else {
            [-1.0, 1.0][f % 2] / h[f / 2]
        };
    }
    g
}

/// Fills the table for cells of size `h`. Among solids p is the face below whatever is closed, elsewhere a free one.
pub fn fill_table<T: Real, S: Space>(h: [f64; 3], among_solids: bool, table: &mut [T]) {
    for (walls, row) in table.chunks_exact_mut(Place::<S>::SIZE).enumerate() {
        let g = normal::<S>(h, walls);
        let squared: f64 = g.iter().map(|g| g * g).sum();
        let above_wall = !among_solids && walls >> BELOW & 1 == 1;
        let p = if above_wall { ABOVE } else { BELOW };
        if squared == 0.0 || (g[p] == 0.0 && !among_solids) {
            // No grid without solids has cells with walls on both sides along y.
            row.fill(T::ZERO);
            continue;
        }
        // u is g / |g| + sign(g_p) e_p, so long that u u^T is twice the projection on it.
        let norm = libm::sqrt(squared);
        let sign = if g[p] > 0.0 { 1.0 } else { -1.0 };
        let across = sign / libm::sqrt(1.0 + sign * g[p] / norm);
        let along = sign * across / norm;
        for (f, &g) in g.iter().enumerate().take(S::FACES) {
            row[Place::<S>::REFLECTION + f] = T::from_f64(along * g + if f == p { across } else { 0.0 });
            row[Place::<S>::NORMAL + f] = T::from_f64(g);
            row[Place::<S>::FREE + f] = T::from_f64(if g == 0.0 { 0.0 } else { 1.0 });
        }
        if above_wall {
            row.swap(Place::<S>::REFLECTION + BELOW, Place::<S>::REFLECTION + ABOVE);
        }
        row[Place::<S>::INVERSE] = T::from_f64(1.0 / squared);
        row[Place::<S>::ALONG] = T::from_f64(along);
        row[Place::<S>::ACROSS] = T::from_f64(across);
    }
}

/// The face of unknown `i`, where p is the face below.
#[inline(always)]
pub(super) const fn face(i: usize) -> usize {
    if i < BELOW { i } else { i + 1 }
}

/// u of all faces.
#[inline(always)]
pub(super) fn reflection<S: Space, V: Vector>(header: &[V::Elem]) -> [V; 6] {
    let mut u = [at(header, Place::<S>::REFLECTION); 6];
    unroll!(f < S::FACES; 1 2 3 4 5; {
        u[f] = at(header, Place::<S>::REFLECTION + f);
    });
    u
}
