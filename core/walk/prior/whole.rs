//! Gamma itself, over a whole field.

use super::Prior;
use crate::real::Real;
use crate::walk::Cells;

/// Gamma(p).
#[must_use]
pub fn whole<T: Real, const D: usize>(prior: Prior, cells: &Cells<D>, field: &[T]) -> f64 {
    let value = |cell: &[usize; D]| field.get(cells.index(cell)).map_or(0.0, |value| value.to_f64());
    let mut sum = 0.0;
    for index in 0..if prior.on_cells() { cells.len() } else { 0 } {
        let cell = cells.cell(index);
        let here = value(&cell);
        // The cell beside it, so far along each axis, less itself; nothing beyond the box.
        let beside = |offsets: &[isize; D]| {
            let mut other = cell;
            for axis in 0..D {
                other[axis] = cell[axis].checked_add_signed(offsets[axis])?;
                if other[axis] >= cells.counts[axis] {
                    return None;
                }
            }
            Some(value(&other) - here)
        };
        sum += match prior {
            Prior::None | Prior::ImageTv | Prior::ImageSad => 0.0,
            Prior::L2 => {
                let laplacian: f64 = (0..D)
                    .flat_map(|axis| [along(axis, 1), along(axis, -1)])
                    .filter_map(|offset| beside(&offset))
                    .sum();
                0.5 * laplacian * laplacian
            }
            Prior::Tv => {
                let ahead = (0..D).filter_map(|axis| beside(&along(axis, 1)));
                Real::sqrt(ahead.map(|difference| difference * difference).sum::<f64>())
            }
            Prior::Sad => behind::<D>()
                .filter_map(|offset| beside(&offset))
                .map(f64::abs)
                .sum(),
        };
    }
    sum
}

/// One step along an axis.
fn along<const D: usize>(axis: usize, step: isize) -> [isize; D] {
    let mut offset = [0; D];
    offset[axis] = step;
    offset
}

/// Half of the offsets to the cells that touch one: of each pair one.
fn behind<const D: usize>() -> impl Iterator<Item = [isize; D]> {
    let all = 3_usize.pow(D as u32);
    (all / 2 + 1..all).map(|number| {
        let mut rest = number;
        [0; D].map(|_: isize| {
            let digit = rest % 3;
            rest /= 3;
            digit as isize - 1
        })
    })
}
