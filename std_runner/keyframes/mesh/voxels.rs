//! From a surface to densities on cells.

use rayon::prelude::*;

use super::surface::{Point, Surface};
use super::winding::{Winding, cross};
use crate::keyframes::Canvas;
use crate::keyframes::solid::{dot, minus};

/// Points a side at which a cell on the surface is looked at.
const FINER: usize = 3;
/// The largest part of those points that is less than half of them.
const LESS_THAN_HALF: f64 = 13.0 / 27.0;
/// Weight of each neighbour in a pass of smoothing. Two passes bring the edge of the covered part of a cell (variance 1/12 of a cell) to
/// that of 0.5 - 0.5 tanh(d / h), as other shapes have it (pi^2 / 12).
const BESIDE: f64 = 0.185;

/// A body on cells.
pub(super) struct Filled {
    /// Densities 0 ..= 1.
    pub density: Vec<f64>,
    /// Cells inside, those of them around which the surface goes backwards, and those around which it goes more than once.
    pub inside: usize,
    pub flipped: usize,
    pub overlaps: usize,
}

/// How a body ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::keyframes) enum Edge {
    /// Over a cell or two, as smoke does.
    Soft,
    /// At a side of a cell: of one whose middle is inside at least half is covered, of any other less, as it is of shapes with a distance.
    Cut,
}

/// Fills `surface`, which lies where the box of `canvas` does.
pub(super) fn fill(surface: &Surface, canvas: &Canvas, end: Edge) -> Filled {
    let winding = Winding::new(surface);
    let place = Place {
        h: canvas.cell_size(),
        cells: canvas.cells_3d(),
    };
    let shifts = images(surface, canvas);
    let around = |point: Point| {
        let each = shifts.iter().map(|&shift| winding.at(minus(point, shift)));
        each.fold(0.0, |most: f64, w| if w.abs() > most.abs() { w } else { most })
    };
    let count = canvas.cell_count();
    let mut winds = vec![0.0_f32; count];
    let [nx, ..] = place.cells;
    winds.par_chunks_mut(nx).enumerate().for_each(|(row, cells)| {
        for (i, cell) in cells.iter_mut().enumerate() {
            *cell = around(place.at(row * nx + i, [0.5; 3])) as f32;
        }
    });
    let inside = |w: f32| w.abs() > 0.5;
    let edge = edge_cells(surface, &place, &shifts, &winds);
    let mut density = vec![0.0; count];
    density.par_iter_mut().enumerate().for_each(|(index, cell)| {
        let whole = winds.get(index).copied().is_some_and(inside);
        *cell = if edge.get(index) == Some(&true) {
            covered(|offset| around(place.at(index, offset)).abs() > 0.5)
        } else {
            f64::from(u8::from(whole))
        };
    });
    match end {
        Edge::Soft => (0..2).for_each(|_| smooth(&mut density, canvas)),
        Edge::Cut => density.iter_mut().zip(&winds).for_each(|(cell, &w)| {
            *cell = if inside(w) {
                cell.max(0.5)
            } else {
                cell.min(LESS_THAN_HALF)
            };
        }),
    }
    Filled {
        density,
        inside: winds.iter().filter(|&&w| inside(w)).count(),
        flipped: winds.iter().filter(|&&w| w < -0.5).count(),
        overlaps: winds.iter().filter(|&&w| w.abs() > 1.5).count(),
    }
}

/// Where cells are.
struct Place {
    h: f64,
    cells: [usize; 3],
}

impl Place {
    /// The point of cell `index` at `offset`, in cells from its lower corner.
    fn at(&self, index: usize, offset: Point) -> Point {
        let [nx, ny, _] = self.cells;
        let cell = [index % nx, index / nx % ny, index / (nx * ny)];
        core::array::from_fn(|axis| (cell[axis] as f64 + offset[axis]) * self.h)
    }
}

/// The part of a cell whose points are `inside`.
fn covered(inside: impl Fn(Point) -> bool) -> f64 {
    let at = |step: usize| (step as f64 + 0.5) / FINER as f64;
    let count = FINER * FINER * FINER;
    let hits = (0..count).filter(|&point| {
        inside([
            at(point % FINER),
            at(point / FINER % FINER),
            at(point / (FINER * FINER)),
        ])
    });
    hits.count() as f64 / count as f64
}

/// By how much the surface is moved so that its images along periodic axes are there too, those that reach into the box.
fn images(surface: &Surface, canvas: &Canvas) -> Vec<Point> {
    let [low, high] = surface.bounds();
    let extent = canvas.extent();
    let reaches = |shift: &Point| {
        (0..3).all(|axis| {
            let stays = shift[axis] == 0.0;
            stays || low[axis] + shift[axis] < extent[axis] && high[axis] + shift[axis] > 0.0
        })
    };
    canvas.images().into_iter().filter(reaches).collect()
}

/// Cells that a triangle passes through, or where inside ends without one: over a hole.
fn edge_cells(surface: &Surface, place: &Place, shifts: &[Point], winds: &[f32]) -> Vec<bool> {
    let mut edge = vec![false; winds.len()];
    for &triangle in &surface.triangles {
        for &shift in shifts {
            let corners = surface.corners(triangle);
            mark(
                corners.map(|corner| core::array::from_fn(|axis| corner[axis] + shift[axis])),
                place,
                &mut edge,
            );
        }
    }
    let [nx, ny, nz] = place.cells;
    let inside = |index: usize| winds.get(index).is_some_and(|w| w.abs() > 0.5);
    for (axis, stride) in [1, nx, nx * ny].into_iter().enumerate() {
        for index in 0..winds.len().saturating_sub(stride) {
            let along = [index % nx, index / nx % ny, index / (nx * ny)];
            let last = along[axis] + 1 >= [nx, ny, nz][axis];
            if !last && inside(index) != inside(index + stride) {
                for cell in [index, index + stride] {
                    if let Some(slot) = edge.get_mut(cell) {
                        *slot = true;
                    }
                }
            }
        }
    }
    edge
}

/// Marks the cells within the bounds of a triangle that its plane passes through.
fn mark(triangle: [Point; 3], place: &Place, edge: &mut [bool]) {
    let [a, b, c] = triangle;
    let normal = cross(minus(b, a), minus(c, a));
    let size = dot(normal, normal).sqrt();
    let mut from = [0; 3];
    let mut to = [0; 3];
    for axis in 0..3 {
        let low = a[axis].min(b[axis]).min(c[axis]) / place.h;
        let high = a[axis].max(b[axis]).max(c[axis]) / place.h;
        let cells = place.cells[axis];
        if high < 0.0 || low > cells as f64 {
            return;
        }
        from[axis] = low.max(0.0) as usize;
        to[axis] = (high.max(0.0) as usize).min(cells - 1);
    }
    let reach = place.h * 3.0_f64.sqrt() / 2.0 * size;
    let [nx, ny, _] = place.cells;
    for k in from[2]..=to[2] {
        for j in from[1]..=to[1] {
            for i in from[0]..=to[0] {
                let index = i + nx * (j + ny * k);
                if dot(minus(place.at(index, [0.5; 3]), a), normal).abs() <= reach
                    && let Some(slot) = edge.get_mut(index)
                {
                    *slot = true;
                }
            }
        }
    }
}

/// One pass of [`BESIDE`], 1 - 2 [`BESIDE`], [`BESIDE`] along each axis; nothing passes through the sides of the box.
fn smooth(density: &mut [f64], canvas: &Canvas) {
    let cells = canvas.cells_3d();
    let mut stride = 1;
    for (axis, &count) in cells.iter().enumerate() {
        let before = density.to_vec();
        let slab = stride * count;
        density
            .par_chunks_mut(slab)
            .enumerate()
            .for_each(|(number, out)| {
                for (place, value) in out.iter_mut().enumerate() {
                    let at = place / stride;
                    let beside = |step: isize| {
                        let wanted = at as isize + step;
                        let kept = if canvas.repeats(axis) {
                            wanted.rem_euclid(count as isize)
                        } else {
                            wanted.clamp(0, count as isize - 1)
                        };
                        let index = number * slab + kept as usize * stride + place % stride;
                        before.get(index).copied().unwrap_or(0.0)
                    };
                    *value += BESIDE * (beside(-1) - 2.0 * *value + beside(1));
                }
            });
        stride = slab;
    }
}
