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

/// The velocities at the faces around a row of cells, in slots that lie side by side.
#[derive(Clone, Copy, Debug)]
pub struct RowFaces<'a, T> {
    /// Cells of the row in one slot.
    pub nx: usize,
    /// The low faces along every axis; empty where there is none.
    pub low: Vector<'a, T>,
    /// Which low face along x is the high face of the last cell; `None` where that is on a wall.
    pub end: Option<usize>,
    /// The high faces along y and z; empty at a wall.
    pub high: [&'a [T]; 2],
}

impl<T> RowFaces<'_, T> {
    /// Slots.
    #[inline(always)]
    #[must_use]
    pub fn slots(&self) -> usize {
        self.low[0].len().checked_div(self.nx).unwrap_or(0)
    }

    /// Those of one slot.
    #[inline(always)]
    #[must_use]
    pub fn slot(&self, slot: usize) -> Self {
        let range = slot * self.nx..(slot + 1) * self.nx;
        let ([x, y, z], [above_y, above_z]) = (self.low, self.high);
        Self {
            low: [
                rows::part(x, range.clone()),
                rows::part(y, range.clone()),
                rows::part(z, range.clone()),
            ],
            high: [rows::part(above_y, range.clone()), rows::part(above_z, range)],
            ..*self
        }
    }
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
    /// div v at a row of cells in every slot, the sum over axes of `scales` (v[high face] - v[low face]), to `outs`, one slice a slot, unless there is none;
    /// max |div v| and max |v| at the low faces, or NaN when any value is not finite.
    pub fn divergence[T, V](faces: &RowFaces<'_, T>, scales: [T; 3], outs: &mut [&mut [T]]) -> [f64; 2] {
        let n = faces.nx;
        let mut sizes = Sizes { divergence: V::splat(T::ZERO), speed: V::splat(T::ZERO), poison: V::splat(T::ZERO) };
        let mut last = Sizes { divergence: T::ZERO, speed: T::ZERO, poison: T::ZERO };
        // All cells but the last go by whole vectors; the last vector may overlap the one before.
        let whole = n.saturating_sub(1 + V::LANES);
        let by_vectors = if n > V::LANES { n - 1 } else { 0 };
        for slot in 0..faces.slots() {
            let faces = faces.slot(slot);
            let x = faces.low[0];
            let end = faces.end.and_then(|first| x.get(first)).copied().unwrap_or(T::ZERO);
            let out = match outs.get_mut(slot) {
                Some(out) => &mut **out,
                None => &mut [],
            };
            for i in (0..by_vectors).step_by(V::LANES) {
                let i = i.min(whole);
                if let Some(above) = x.get(i + 1..i + 1 + V::LANES) {
                    divergence_at(i, &faces, V::load(above), scales, out, &mut sizes);
                }
            }
            for i in by_vectors..n {
                divergence_at(i, &faces, x.get(i + 1).copied().unwrap_or(end), scales, out, &mut last);
            }
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
    let Some(x) = faces.low[0].get(i..i + V::LANES) else {
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
    if let Some(out) = out.get_mut(i..i + V::LANES) {
        sum.store(out);
    }
}

/// The values of a potential around a row of cells, in one slot.
#[derive(Clone, Copy, Debug)]
pub struct RowCells<'a, T> {
    /// At the cells.
    pub own: &'a [T],
    /// At the cell below the first along x; at a wall that of the first itself.
    pub before: T,
    /// At the cells below along y and z; empty behind a wall.
    pub low: [&'a [T]; 2],
}

vectorised! {
    /// `v += scales (p[high cell] - p[low cell])` at the low faces of a row of cells along every axis: [`add_gradient`] of all axes in one pass.
    pub fn add_gradients[T, V](p: &RowCells<'_, T>, scales: [T; 3], v: [&mut [T]; 3]) {
        let n = p.own.len();
        let mut first = [p.before; LANES];
        first[1..].iter_mut().zip(p.own).for_each(|(to, &from)| *to = from);
        let [x, y, z] = v;
        let whole = n - n % V::LANES;
        for i in (0..whole).step_by(V::LANES) {
            let below = if i == 0 { V::load(&first) } else { V::at(p.own, i - 1) };
            gradients_at(i, p, below, scales, [&mut *x, &mut *y, &mut *z]);
        }
        for i in whole..n {
            let below = i.checked_sub(1).and_then(|before| p.own.get(before)).copied();
            let below = below.unwrap_or(p.before);
            gradients_at(i, p, below, scales, [&mut *x, &mut *y, &mut *z]);
        }
    }
}

/// [`add_gradients`] at cells from `i` on, `below` which along x the potential is given.
#[inline(always)]
fn gradients_at<T: Real, V: simd::Vector<Elem = T>>(
    i: usize,
    p: &RowCells<'_, T>,
    below: V,
    scales: [T; 3],
    [x, y, z]: [&mut [T]; 3],
) {
    let own = V::at(p.own, i);
    add_at(i, V::splat(scales[0]) * (own - below), x);
    for (axis, v) in [(1, y), (2, z)] {
        if let Some(below) = p.low[axis - 1].get(i..i + V::LANES) {
            add_at(i, V::splat(scales[axis]) * (own - V::load(below)), v);
        }
    }
}

/// `out += x` from `i` on.
#[inline(always)]
fn add_at<T: Real, V: simd::Vector<Elem = T>>(i: usize, x: V, out: &mut [T]) {
    if let Some(out) = out.get_mut(i..i + V::LANES) {
        (V::load(out) + x).store(out);
    }
}
