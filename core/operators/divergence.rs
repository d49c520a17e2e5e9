//! Divergence at cells and gradient at faces (mathematics section 1), row by row: grad = -div^T.

use crate::field::rows::{self, LANES};
use crate::field::{Block, Vector};
use crate::grid::Side;
use crate::grid::geometry::Beyond;
use crate::real::Real;
use crate::simd::{self, vectorised};

/// `out += s div v` at the cells of `row` of a block, div v = sum over axes of (v[high face] - v[low face]) / h. `shifted` is scratch
/// for a row of the block.
pub fn add_divergence<T: Real>(
    block: &Block<'_>,
    row: usize,
    s: T,
    v: Vector<'_, T>,
    out: &mut [T],
    shifted: &mut [T],
) {
    let grid = block.grid;
    for axis in 0..grid.dims {
        let s = s * T::from_f64(1.0 / grid.h[axis]);
        let low = block.of(v[axis], row);
        match block.beside((axis, Side::High), Beyond::Zero, v[axis], row, shifted) {
            Some(high) => rows::add_difference(out, s, high, low),
            None => rows::add_scaled(out, -s, low),
        }
    }
}

/// `out += s (p[high cell] - p[low cell]) / h` at the faces of `row` of a block along `axis`, 0 on walls. `shifted` is scratch for a row
/// of the block.
pub fn add_gradient<T: Real>(
    block: &Block<'_>,
    row: usize,
    axis: usize,
    s: T,
    p: &[T],
    out: &mut [T],
    shifted: &mut [T],
) {
    let grid = block.grid;
    let s = s * T::from_f64(1.0 / grid.h[axis]);
    if let Some(low) = block.beside((axis, Side::Low), Beyond::Own, p, row, shifted) {
        rows::add_difference(out, s, block.of(p, row), low);
    }
}

/// The velocities at the faces around a row of cells, in one slot.
#[derive(Clone, Copy, Debug)]
pub struct RowFaces<'a, T> {
    /// The low faces along every axis; empty where there is none.
    pub low: Vector<'a, T>,
    /// The high face of the last cell along x.
    pub end: T,
    /// The high faces along y and z; empty at a wall.
    pub high: [&'a [T]; 2],
}

/// The largest values that [`divergence`] met.
#[derive(Clone, Copy, Debug)]
struct Sizes<V> {
    divergence: V,
    speed: V,
    /// NaN once a value was not finite.
    poison: V,
}

vectorised! {
    /// `out` = div v at a row of cells, the sum over axes of `scales` (v[high face] - v[low face]); max |out| and max |v| at the low faces, or
    /// NaN when any value is not finite.
    pub fn divergence[T, V](faces: &RowFaces<'_, T>, scales: [T; 3], out: &mut [T]) -> [f64; 2] {
        let n = out.len();
        let x = faces.low[0];
        let mut sizes = Sizes { divergence: V::splat(T::ZERO), speed: V::splat(T::ZERO), poison: V::splat(T::ZERO) };
        let mut last = Sizes { divergence: T::ZERO, speed: T::ZERO, poison: T::ZERO };
        // All cells but the last go by whole vectors; the last vector may overlap the one before.
        let whole = n.saturating_sub(1 + V::LANES);
        let by_vectors = if n > V::LANES { n - 1 } else { 0 };
        for i in (0..by_vectors).step_by(V::LANES) {
            let i = i.min(whole);
            if let Some(above) = x.get(i + 1..i + 1 + V::LANES) {
                divergence_at(i, faces, V::load(above), scales, out, &mut sizes);
            }
        }
        for i in by_vectors..n {
            divergence_at(i, faces, x.get(i + 1).copied().unwrap_or(faces.end), scales, out, &mut last);
        }
        let [mut divergence, mut speed, mut poison] = [[T::ZERO; LANES]; 3];
        sizes.divergence.store(&mut divergence);
        sizes.speed.store(&mut speed);
        sizes.poison.store(&mut poison);
        divergence[0] = last.divergence.max(divergence[0]);
        speed[0] = last.speed.max(speed[0]);
        poison[0] += last.poison;
        [rows::largest_lane(divergence, poison), rows::largest_lane(speed, poison)]
    }
}

/// [`divergence`] at cells from `i` on, whose high faces along x are `above`.
#[inline(always)]
fn divergence_at<T: Real, V: simd::Vector<Elem = T>>(
    i: usize,
    faces: &RowFaces<'_, T>,
    above: V,
    scales: [T; 3],
    out: &mut [T],
    sizes: &mut Sizes<V>,
) {
    let (Some(x), Some(out)) = (faces.low[0].get(i..i + V::LANES), out.get_mut(i..i + V::LANES)) else {
        return;
    };
    let below = V::load(x);
    let mut sum = V::splat(scales[0]) * (above - below);
    sizes.speed = below.max(-below).max(sizes.speed);
    for axis in 1..3 {
        if let Some(below) = faces.low[axis].get(i..i + V::LANES) {
            let below = V::load(below);
            let above = faces.high[axis - 1]
                .get(i..i + V::LANES)
                .map_or(V::splat(T::ZERO), V::load);
            sum = sum + V::splat(scales[axis]) * (above - below);
            sizes.speed = below.max(-below).max(sizes.speed);
        }
    }
    sizes.divergence = sum.max(-sum).max(sizes.divergence);
    sizes.poison = sizes.poison + sum * V::splat(T::ZERO);
    sum.store(out);
}
