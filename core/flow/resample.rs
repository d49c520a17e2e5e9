//! Fields between grids of any ratio, by Catmull-Rom interpolation axis by axis, x first, in cells of either grid.
//!
//! A cell of the new grid has its centre at (i + 1/2) s of the old one, s being the ratio of the cell counts; cells are mirrored at
//! walls. A face component goes like cells across its axis, and along it a face is at i s and continues odd about a wall.

use super::sample::{floor, weights};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows;
use crate::grid::{Axis, Grid};
use crate::real::Real;

/// What is resampled: a field of cells, or the component of a field of faces along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// At cell centres.
    Cells,
    /// At the faces of this axis.
    Faces(usize),
}

/// Four samples of the old axis and their weights, 0 where there stands none.
type Taps = [(usize, f64); 4];

/// What makes value `i` of an axis of `cells` cells, times `scale`.
#[inline(always)]
fn taps(from: Axis, cells: usize, faces: bool, i: usize, scale: f64) -> Taps {
    let ratio = from.cells() as f64 / cells as f64;
    let x = if faces {
        i as f64 * ratio
    } else {
        (i as f64 + 0.5) * ratio - 0.5
    };
    let first = floor(x + 1e-12);
    let weights = weights(x - first as f64);
    core::array::from_fn(|k| {
        let (place, weight) = (first - 1 + k as isize, weights[k] * scale);
        if faces {
            // Between walls and on rings one face stands for it, if any does.
            let face = from.continued_face(place).first().copied();
            face.map_or((0, 0.0), |(face, sign)| (face, sign * weight))
        } else {
            (from.mirrored(place), weight)
        }
    })
}

/// Along `axis`: `from` on the cells `n` (and the boundary of `grid`) to `to` on `cells` cells along that axis, times `scale`.
fn along<T: Real>(
    exec: &dyn Exec,
    (grid, n): (&Grid, [usize; 3]),
    (axis, cells): (usize, usize),
    (kind, scale): (Kind, f64),
    from: &[T],
    to: &mut [T],
) {
    let line = grid.axis(axis);
    let faces = kind == Kind::Faces(axis);
    let mut m = n;
    m[axis] = cells;
    let to = rows::part_mut(to, 0..m.iter().product());
    for_rows(exec, m[1] * m[2], RowBuffers::fields([to]), |task| {
        let [out] = task.fields;
        if axis == 0 {
            let row = rows::part(from, task.row * n[0]..(task.row + 1) * n[0]);
            for (i, out) in out.iter_mut().enumerate() {
                let sum = taps(line, cells, faces, i, scale);
                *out = sum.iter().fold(T::ZERO, |sum, &(place, weight)| {
                    sum + T::from_f64(weight) * row.get(place).copied().unwrap_or(T::ZERO)
                });
            }
            return;
        }
        let mut at = [task.row % m[1], task.row / m[1].max(1)];
        let four = taps(line, cells, faces, at[axis - 1], scale).map(|(place, weight)| {
            at[axis - 1] = place;
            let row = at[1] * n[1] + at[0];
            (
                rows::part(from, row * n[0]..(row + 1) * n[0]),
                T::from_f64(weight),
            )
        });
        let [(x0, w0), (x1, w1), (x2, w2), (x3, w3)] = four;
        rows::sum_of_four(out, [w0, w1, w2, w3], x0, x1, x2, x3);
    });
}

/// `field` of `source` becomes `out` of `target`, times `scale`. `work` holds two fields of as many cells as the larger grid has.
pub fn resample<T: Real>(
    exec: &dyn Exec,
    grids: [&Grid; 2],
    (kind, scale): (Kind, f64),
    field: &[T],
    out: &mut [T],
    [first, second]: [&mut [T]; 2],
) {
    along_rows(exec, grids, kind, field, first);
    across_rows(exec, grids, (kind, scale), [first, second], out);
}

/// The first part of [`resample`], along x.
pub fn along_rows<T: Real>(
    exec: &dyn Exec,
    [source, target]: [&Grid; 2],
    kind: Kind,
    field: &[T],
    out: &mut [T],
) {
    along(
        exec,
        (source, source.n),
        (0, target.n[0]),
        (kind, 1.0),
        field,
        out,
    );
}

/// The rest of [`resample`], from what the first part left in `first`; `second` is work.
pub fn across_rows<T: Real>(
    exec: &dyn Exec,
    [source, target]: [&Grid; 2],
    (kind, scale): (Kind, f64),
    [first, second]: [&mut [T]; 2],
    out: &mut [T],
) {
    let m = target.n;
    let mut n = [m[0], source.n[1], source.n[2]];
    if source.dims == 2 {
        return along(exec, (source, n), (1, m[1]), (kind, scale), first, out);
    }
    along(exec, (source, n), (1, m[1]), (kind, 1.0), first, second);
    n[1] = m[1];
    along(exec, (source, n), (2, m[2]), (kind, scale), second, out);
}
