//! The potential of the noise at the corners or edges of a finer grid, and what its curl adds to a flow there.
//!
//! In 2D it has one component, at corners; in 3D three, each at the edges along its axis. Places count in cells of the captured grid.

use super::tile::{Three, around, value};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows};
use crate::flow::sample::four;
use crate::grid::{Grid, Side};
use crate::operators::curl::turns;
use crate::real::Real;

/// What a potential is made of.
pub(super) struct Texture<'a, T> {
    /// The captured grid, in cells.
    pub grid: &'a Grid,
    /// The noise.
    pub tile: &'a [T],
    /// c - x of both sets, at cells.
    pub drift: [Vector<'a, T>; 2],
    /// How much each is stretched.
    pub stretch: [&'a [T]; 2],
    pub weights: [f64; 2],
    /// [`speed`] of each octave.
    pub speeds: &'a [f64],
    /// The size of a finer cell, in cells.
    pub finer: f64,
}

/// What is kept of noise of which a finer cell holds so many values: all up to a half, nothing from 1 on.
fn kept(values: f64) -> f64 {
    (2.0 - 2.0 * values).clamp(0.0, 1.0)
}

/// 2^(-5b/6): the speed in octave `b`, in parts of that in the first.
pub(super) fn speed(octave: usize) -> f64 {
    libm::exp2(-5.0 / 6.0 * octave as f64)
}

/// Corners of `grid` along each axis; those of a ring's end are those of its beginning.
pub(super) fn corners(grid: &Grid) -> [usize; 3] {
    core::array::from_fn(|axis| grid.n[axis] + usize::from(axis < grid.dims))
}

/// Components of a potential.
pub(super) fn components(dims: usize) -> usize {
    if dims == 2 { 1 } else { 3 }
}

/// The potential in `out`, [`components`] fields at the [`corners`] of `fine`. `scratch` has a row of the captured grid for each axis
/// and one more, for every thread.
pub(super) fn fill<T: Real>(
    exec: &dyn Exec,
    texture: &Texture<'_, T>,
    fine: &Grid,
    mut out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let (dims, n) = (fine.dims, corners(fine));
    for (component, out) in out.iter_mut().enumerate().take(components(dims)) {
        // Where it stands beside a corner.
        let half = |axis: usize| {
            if dims == 3 && axis == component { 0.5 } else { 0.0 }
        };
        let buffers = RowBuffers::fields([&mut **out]).with_scratch(&mut *scratch);
        for_rows(exec, n[1] * n[2], buffers, |task| {
            let [out] = task.fields;
            out.fill(T::ZERO);
            let row = [task.row % n[1], task.row / n[1]];
            let across = core::array::from_fn(|k| {
                let place = row[k] as f64 + half(k + 1);
                place * texture.finer
            });
            for set in 0..2 {
                let line = Line {
                    texture,
                    set,
                    component,
                    across,
                };
                line.add(half(0), out, task.scratch);
            }
        });
    }
}

/// A row of corners or edges, and what one of the two sets of coordinates makes of it.
struct Line<'t, 'a, T> {
    texture: &'t Texture<'a, T>,
    set: usize,
    component: usize,
    /// Its place along y and z.
    across: [f64; 2],
}

impl<T: Real> Line<'_, '_, T> {
    /// Adds the noise at the places `half` beside corners.
    fn add(&self, half: f64, out: &mut [T], scratch: &mut [T]) {
        let texture = self.texture;
        let weight = texture.weights[self.set];
        if weight == 0.0 {
            return;
        }
        let (grid, dims) = (texture.grid, texture.grid.dims);
        let n = grid.n[0];
        let [x, y, z] = texture.drift[self.set];
        let fields = [x, y, z]
            .into_iter()
            .take(dims)
            .chain([texture.stretch[self.set]]);
        for (field, line) in fields.zip(scratch.chunks_exact_mut(n)) {
            self.combine(field, line);
        }
        for (x, out) in out.iter_mut().enumerate() {
            let along = (x as f64 + half) * texture.finer;
            let taps = four(grid.axis(0), along);
            let mut place = [along, self.across[0], self.across[1]];
            let between = |field: usize| {
                let line = rows::part(&*scratch, field * n..(field + 1) * n);
                taps.iter().fold(0.0, |sum, &(at, weight)| {
                    sum + weight * line.get(at).map_or(0.0, |value| value.to_f64())
                })
            };
            for (axis, place) in place.iter_mut().enumerate().take(dims) {
                *place += between(axis);
            }
            *out += T::from_f64(weight * self.noise(place, between(dims).max(1.0)));
        }
    }

    /// `out` = a field of cells in this row, by cubics across it.
    fn combine(&self, field: &[T], out: &mut [T]) {
        let grid = self.texture.grid;
        let n = grid.n[0];
        out.fill(T::ZERO);
        let in_y = four(grid.axis(1), self.across[0]);
        let in_z = if grid.dims == 3 {
            four(grid.axis(2), self.across[1])
        } else {
            [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]
        };
        for (z, weight_z) in in_z.into_iter().take(3 * grid.dims - 5) {
            for (y, weight_y) in in_y {
                let row = grid.row(y, z);
                let source = rows::part(field, row * n..(row + 1) * n);
                rows::add_scaled(out, T::from_f64(weight_y * weight_z), source);
            }
        }
    }

    /// The octaves at a place of the texture that is stretched so much.
    fn noise(&self, place: [f64; 3], stretch: f64) -> f64 {
        let (texture, dims) = (self.texture, self.texture.grid.dims);
        let mut sum = 0.0;
        for (octave, speed) in texture.speeds.iter().enumerate() {
            let scale = (1usize << octave) as f64;
            let kept = kept(scale * stretch * texture.finer) / stretch;
            if kept == 0.0 {
                continue;
            }
            let shift = 32 * self.set + 21 * self.component + 11 * octave;
            let three = |axis: usize| -> Three {
                let line = texture.grid.axis(axis);
                let ring = line.is_ring().then(|| line.cells() << octave);
                around(scale * place[axis], ring, shift)
            };
            let z = (dims == 3).then(|| three(2));
            sum += kept * speed / scale * value(texture.tile, three(0), three(1), z);
        }
        sum
    }
}

/// `v += s amplitude curl psi` at the faces of `fine`, but on walls; `amplitude` at its cells. Differences are over `finer` cells of the captured grid.
pub(super) fn add_curl<T: Real>(
    exec: &dyn Exec,
    fine: &Grid,
    (s, finer): (f64, f64),
    (psi, amplitude): (Vector<'_, T>, &[T]),
    v: &mut VectorMut<'_, T>,
) {
    let (n, dims) = (corners(fine), fine.dims);
    let scale = T::from_f64(s / finer);
    let corner = |[x, y, z]: [usize; 3]| (z * n[1] + y) * n[0] + x;
    for_rows(exec, fine.rows(), RowBuffers::fields(reborrow(v)), |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(dims) {
            let terms = turns(dims, axis);
            for (x, out) in out.iter_mut().enumerate() {
                let here = fine.cell_at(task.row, x);
                let Some(low) = fine.beside(here, axis, Side::Low) else {
                    continue;
                };
                let mut curl = T::ZERO;
                for (component, along, sign) in terms {
                    let mut next = here;
                    next[along] += 1;
                    let value = |at| psi[component].get(corner(at)).copied().unwrap_or(T::ZERO);
                    curl += T::from_f64(sign) * (value(next) - value(here));
                }
                let of = |at| amplitude.get(fine.index(at)).copied().unwrap_or(T::ZERO);
                *out += scale * (T::HALF * (of(low) + of(here))) * curl;
            }
        }
    });
}
