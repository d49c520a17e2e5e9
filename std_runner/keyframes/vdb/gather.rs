//! A grid on the cells of a box, part by part. No voxel is kept: a file of few bytes can say that a tile fills thousands of them a side, and
//! what it takes of memory is that of the cells alone.

use super::container::Grid;
use super::dense::{Bounds, Density, Turn};
use super::tree::{Corner, Part, walk};
use crate::keyframes::error::Fault;
use crate::keyframes::resample::Taps;
use crate::undershoot::Undershoot;
use std::borrow::Cow;

/// Cells along an axis by the voxels that they take.
struct Axis {
    /// The cells that each voxel goes to, with its weights there.
    cells: Vec<Vec<(usize, f64)>>,
    /// The sum of the weights of each cell.
    sums: Vec<f64>,
}

impl Axis {
    fn new(taps: &[Taps], voxels: usize) -> Self {
        let mut cells = vec![Vec::new(); voxels];
        for (cell, taps) in taps.iter().enumerate() {
            for &(voxel, weight) in taps {
                if let Some(found) = cells.get_mut(voxel) {
                    found.push((cell, weight));
                }
            }
        }
        let sum = |taps: &Taps| taps.iter().map(|&(_, weight)| weight).sum();
        Self {
            cells,
            sums: taps.iter().map(sum).collect(),
        }
    }

    /// The cells that the voxels from `low` to `high` go to, with the sums of their weights.
    fn of(&self, [low, high]: [usize; 2]) -> Cow<'_, [(usize, f64)]> {
        let voxels = self.cells.get(low..=high).unwrap_or_default();
        if let [one] = voxels {
            return Cow::from(one);
        }
        let mut found: Vec<(usize, f64)> = Vec::new();
        for &(cell, weight) in voxels.iter().flatten() {
            // Cells follow each other: the one that is looked for is among the last.
            match found.iter_mut().rev().find(|(known, _)| *known == cell) {
                Some((_, sum)) => *sum += weight,
                None => found.push((cell, weight)),
            }
        }
        Cow::from(found)
    }
}

/// What is on the cells, and what of the voxels was below 0.
pub(super) struct Gathered {
    pub cells: Vec<f64>,
    pub below: Option<Undershoot>,
}

/// What voxels sum to, above 0 and below.
struct Sums {
    above: f64,
    below: f64,
    found: Undershoot,
}

impl Sums {
    /// Counts `count` voxels of a value, of which the first one has the index `at`.
    fn add(&mut self, value: f64, count: usize, at: usize) {
        let sum = value * count as f64;
        if value < 0.0 {
            self.below -= sum;
            self.found.count += count;
        } else {
            self.above += sum;
        }
        if value < self.found.least {
            (self.found.least, self.found.at) = (value, at);
        }
    }
}

/// The voxels of `grid` within `bounds` on cells that take them by `taps`, an entry an axis, x fastest; what is below 0 counts as 0.
pub(super) fn gather(
    grid: &Grid<'_>,
    bounds: Bounds,
    turn: Turn,
    taps: &[Vec<Taps>; 3],
) -> Result<Gathered, Fault> {
    let shape = bounds.sides();
    let axes: [Axis; 3] = core::array::from_fn(|axis| Axis::new(&taps[axis], shape[axis]));
    let [nx, ny, nz] = taps.each_ref().map(Vec::len);
    let density = Density::of(grid);
    let mut cells = vec![0.0; nx * ny * nz];
    let mut sums = Sums {
        above: 0.0,
        below: 0.0,
        found: Undershoot {
            count: 0,
            least: 0.0,
            at: 0,
            part: 0.0,
        },
    };
    let (mut covered, mut outside, mut odd) = (0_usize, 0.0, false);
    walk(grid, |background, part| {
        outside = density.at(background);
        let rest = outside.max(0.0);
        let mut put = |(low, high): (Corner, Corner), value: f32| {
            let value = density.at(value);
            odd |= !value.is_finite();
            let span = |axis: usize| bounds.span(axis, low[axis], high[axis]);
            let (Some(x), Some(y), Some(z)) = (span(0), span(1), span(2)) else {
                return;
            };
            let count = (x[1] - x[0] + 1) * (y[1] - y[0] + 1) * (z[1] - z[0] + 1);
            covered += count;
            sums.add(value, count, (z[0] * shape[1] + y[0]) * shape[0] + x[0]);
            let more = value.max(0.0) - rest;
            if more == 0.0 {
                return;
            }
            let [of_x, of_y, of_z] = &axes;
            let (along_x, along_y) = (of_x.of(x), of_y.of(y));
            for &(k, wz) in of_z.of(z).iter() {
                for &(j, wy) in along_y.iter() {
                    for &(i, wx) in along_x.iter() {
                        if let Some(cell) = cells.get_mut((k * ny + j) * nx + i) {
                            *cell += more * wx * wy * wz;
                        }
                    }
                }
            }
        };
        match part {
            Part::Tile { at, side, value, .. } => put(turn.cube(at, at.map(|x| x + side - 1)), value),
            Part::Leaf { at, values, .. } => {
                for (index, value) in values.into_iter().enumerate() {
                    put(turn.voxel(at, index), value);
                }
            }
        }
        Ok(())
    })?;
    if odd || !outside.is_finite() {
        return Err(super::dense::not_finite());
    }
    // What no part covers is as the background.
    sums.add(
        outside,
        shape.iter().product::<usize>().saturating_sub(covered),
        0,
    );
    if outside > 0.0 {
        let weights = |cell: usize| {
            let [i, j, k] = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            let at = |axis: usize, cell: usize| axes[axis].sums.get(cell).copied().unwrap_or(0.0);
            at(0, i) * at(1, j) * at(2, k)
        };
        cells
            .iter_mut()
            .enumerate()
            .for_each(|(cell, value)| *value += outside * weights(cell));
    }
    sums.found.part = sums.below / sums.above;
    Ok(Gathered {
        cells,
        below: (sums.found.count > 0).then_some(sums.found),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keyframes::resample::{Edge, resample, windows};
    use crate::keyframes::vdb::container::grid;
    use crate::keyframes::vdb::dense::{array, bounds_of};

    /// What is gathered from a file, and what all its voxels give that are laid out first.
    fn both(file: &[u8], turn: Turn) -> Result<(Gathered, Vec<f64>, Option<Undershoot>), Fault> {
        let grid = grid(file, None)?;
        let bounds = bounds_of(&grid, turn)?.wider();
        let shape = bounds.sides();
        let taps = core::array::from_fn(|axis| {
            let step = shape[axis] as f64 / [7.0, 31.0, 12.0][axis];
            windows([7, 31, 12][axis], shape[axis], 0.0, step, Edge::Empty)
        });
        let mut voxels = array(&grid, bounds, turn)?;
        let below = Undershoot::of(&voxels);
        voxels.iter_mut().for_each(|value| *value = value.max(0.0));
        Ok((
            gather(&grid, bounds, turn, &taps)?,
            resample(voxels, &shape, &taps),
            below,
        ))
    }

    #[test]
    fn parts_give_what_all_voxels_would() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/program/volumes");
        for (name, class) in [
            ("blosc_float", "fog"),
            ("level_set", "level set"),
            ("level_set", "level_set"),
        ] {
            let file = std::fs::read(format!("{folder}/{name}.vdb")).unwrap_or_default();
            // What is no level set any more has distances for densities, which are negative inside.
            let held = "level set".as_bytes();
            let mut file = file;
            if let Some(at) = file.windows(held.len()).position(|part| part == held) {
                file[at..at + held.len()].copy_from_slice(class.as_bytes());
            }
            for y_up in [false, true] {
                let Ok((gathered, expected, below)) = both(&file, Turn { y_up }) else {
                    unreachable!("{name} was refused");
                };
                let most = expected.iter().copied().fold(0.0, f64::max);
                assert!(most > 0.0);
                for (found, expected) in gathered.cells.iter().zip(&expected) {
                    assert!(
                        (found - expected).abs() <= 1e-12 * most,
                        "{name} {class}: {found} {expected}"
                    );
                }
                assert_eq!(below.is_some(), class == "level_set", "{name} {class}");
                match (gathered.below, below) {
                    (Some(found), Some(expected)) => {
                        assert_eq!((found.count, found.least), (expected.count, expected.least));
                        assert!((found.part - expected.part).abs() < 1e-9 * expected.part);
                    }
                    (found, expected) => assert_eq!(found, expected),
                }
            }
        }
    }
}
