//! Rows of cells that stand side by side: line i has cell i of [`COLUMNS`] rows, so that what is done along rows is done to whole vectors.

use crate::grid::fourier::Fourier;
use crate::grid::spectrum::COLUMNS;
use crate::real::Real;
use crate::simd::{Vector, vectorised};

/// The most lanes of a vector.
const LANES: usize = 16;

/// The transpose of the first `LANES` of `lines`, by taking pairs apart: each time the lowest bit of a value's place becomes the highest one.
#[inline(always)]
fn transpose<V: Vector>(mut lines: [V; LANES]) -> [V; LANES] {
    let half = V::LANES / 2;
    for _ in 0..V::LANES.trailing_zeros() {
        let mut turned = lines;
        for i in 0..half {
            let [even, odd] = lines[2 * i].pairs(lines[2 * i + 1]);
            turned[i] = even.unpaired();
            turned[half + i] = odd.unpaired();
        }
        lines = turned;
    }
    lines
}

vectorised! {
    /// Cell i of each row to line i, or where the tables sort it; what has no row is 0.
    pub fn rows_to_lines[T, V](n: usize, rows: &[T], lines: &mut [T], sorted: Option<&Fourier<'_, T>>) {
        let lanes = <V as Vector>::LANES;
        let count = rows.len() / n;
        if count < COLUMNS {
            lines.fill(T::ZERO);
        }
        let (across, along) = (count / lanes * lanes, n / lanes * lanes);
        for start in (0..along).step_by(lanes) {
            for column in (0..across).step_by(lanes) {
                let mut tile = [V::splat(T::ZERO); LANES];
                let rows = &rows[column * n + start..];
                for j in 0..lanes {
                    tile[j] = V::at(rows, j * n);
                }
                let tile = transpose(tile);
                for i in 0..lanes {
                    tile[i].put(lines, place(sorted, start + i) + column);
                }
            }
        }
        for i in 0..n {
            let line = &mut lines[place(sorted, i)..];
            for column in if i < along { across } else { 0 }..count {
                line[column] = rows[column * n + i];
            }
        }
    }
}

vectorised! {
    /// The inverse of [`rows_to_lines`]; row j is in column j, or j + `shift` modulo [`COLUMNS`], a multiple of the lanes.
    pub fn lines_to_rows[T, V](n: usize, lines: &[T], rows: &mut [T], sorted: Option<&Fourier<'_, T>>, shift: usize) {
        let lanes = <V as Vector>::LANES;
        let count = rows.len() / n;
        let (across, along) = (count / lanes * lanes, n / lanes * lanes);
        for start in (0..along).step_by(lanes) {
            for row in (0..across).step_by(lanes) {
                let mut tile = [V::splat(T::ZERO); LANES];
                for i in 0..lanes {
                    tile[i] = V::at(lines, place(sorted, start + i) + (row + shift) % COLUMNS);
                }
                let tile = transpose(tile);
                let rows = &mut rows[row * n + start..];
                for j in 0..lanes {
                    tile[j].put(rows, j * n);
                }
            }
        }
        for i in 0..n {
            let line = &lines[place(sorted, i)..];
            for row in if i < along { across } else { 0 }..count {
                rows[row * n + i] = line[(row + shift) % COLUMNS];
            }
        }
    }
}

/// Where line i begins, or the one to which the tables sort cell i.
#[inline(always)]
pub fn place<T: Real>(sorted: Option<&Fourier<'_, T>>, i: usize) -> usize {
    COLUMNS
        * match sorted {
            Some(fourier) => fourier.sorted(i),
            None => i,
        }
}
