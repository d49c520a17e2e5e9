//! A grid as an array of voxels.

use std::path::Path;

use super::bytes::broken;
use super::container::{Grid, grid};
use super::tree::{Corner, Part, walk};
use crate::bytes::are_free;
use crate::keyframes::error::Fault;
use crate::keyframes::solid::soft;
use crate::keyframes::whole::whole;

/// Longest side in voxels that is read.
const LONGEST: i64 = 4096;

/// Lowest and highest voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::keyframes) struct Bounds {
    pub low: Corner,
    pub high: Corner,
}

impl Bounds {
    const NONE: Self = Self {
        low: [i64::MAX; 3],
        high: [i64::MIN; 3],
    };

    fn add(&mut self, low: Corner, high: Corner) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(low[axis]);
            self.high[axis] = self.high[axis].max(high[axis]);
        }
    }

    /// The bounds of both.
    pub fn and(mut self, other: Self) -> Self {
        self.add(other.low, other.high);
        self
    }

    /// One voxel more on every side.
    pub fn wider(self) -> Self {
        Self {
            low: self.low.map(|x| x - 1),
            high: self.high.map(|x| x + 1),
        }
    }

    /// The voxels from `low` to `high` along an axis that lie within, counted from the lowest.
    pub fn span(&self, axis: usize, low: i64, high: i64) -> Option<[usize; 2]> {
        let (low, high) = (low.max(self.low[axis]), high.min(self.high[axis]));
        let from_lowest = |voxel: i64| usize::try_from(voxel - self.low[axis]).ok();
        (low <= high).then_some([from_lowest(low)?, from_lowest(high)?])
    }

    /// Voxels along each axis.
    pub fn sides(&self) -> [usize; 3] {
        core::array::from_fn(|axis| usize::try_from(self.high[axis] - self.low[axis] + 1).unwrap_or(0))
    }
}

/// Which axis of the file becomes which one of the box: with y up, (x, y, z) becomes (x, -z, y).
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub y_up: bool,
}

impl Turn {
    /// The voxel of a leaf at `at` that is number `index`: z fastest.
    pub fn voxel(self, at: Corner, index: usize) -> (Corner, Corner) {
        let place = voxel(at, index);
        self.cube(place, place)
    }

    /// The box from `low` to `high`.
    pub fn cube(self, low: Corner, high: Corner) -> (Corner, Corner) {
        if self.y_up {
            ([low[0], -high[2], low[1]], [high[0], -low[2], high[1]])
        } else {
            (low, high)
        }
    }
}

/// What the values of a grid are as densities.
#[derive(Clone, Copy)]
pub(super) struct Density {
    level_set: bool,
    /// Side of a voxel.
    size: f64,
}

impl Density {
    pub fn of(grid: &Grid<'_>) -> Self {
        Self {
            level_set: grid.level_set,
            size: grid.scale.iter().product::<f64>().cbrt(),
        }
    }

    pub fn at(self, value: f32) -> f64 {
        match (self.level_set, f64::from(value)) {
            // What is no number stays none.
            (true, distance) => soft(distance / self.size),
            (false, density) => density,
        }
    }
}

/// The refusal of a value that is none.
pub(super) fn not_finite() -> Fault {
    Fault::content("holds a value that is not finite", "every value must be finite")
}

/// The bytes of a file that there is memory for.
pub(super) fn bytes_of(path: &Path) -> Result<Vec<u8>, Fault> {
    whole(path, 2, "make it coarser, or crop it")
}

/// The voxels of a grid that count.
pub(super) fn bounds_of(grid: &Grid<'_>, turn: Turn) -> Result<Bounds, Fault> {
    let mut bounds = Bounds::NONE;
    walk(grid, |_, part| {
        match part {
            Part::Tile { at, side, active, .. } if active => {
                let (low, high) = turn.cube(at, at.map(|x| x + side - 1));
                bounds.add(low, high);
            }
            Part::Leaf { at, active, .. } => {
                for index in active.all() {
                    let (low, high) = turn.voxel(at, index);
                    bounds.add(low, high);
                }
            }
            Part::Tile { .. } => {}
        }
        Ok(())
    })?;
    if bounds.low[0] > bounds.high[0] {
        return Err(Fault::content(
            format!("holds no active voxel in `{}`", grid.name),
            "name another grid by `name`, or save it again",
        ));
    }
    if (0..3).any(|axis| bounds.high[axis] - bounds.low[axis] >= LONGEST) {
        let [x, y, z] = bounds.sides();
        let found = format!("has active voxels over {x} x {y} x {z}");
        return Err(Fault::content(
            found,
            format!("make it coarser, or crop it to at most {LONGEST} along a side"),
        ));
    }
    Ok(bounds)
}

/// The voxel of a leaf that is number `index`: z fastest.
fn voxel(at: Corner, index: usize) -> Corner {
    [
        at[0] + (index >> 6) as i64,
        at[1] + (index >> 3 & 7) as i64,
        at[2] + (index & 7) as i64,
    ]
}

/// All voxels within `bounds`, x fastest; of a surface, what is inside.
pub(super) fn array(grid: &Grid<'_>, bounds: Bounds, turn: Turn) -> Result<Vec<f64>, Fault> {
    let [nx, ny, nz] = bounds.sides();
    let count = nx
        .checked_mul(ny)
        .and_then(|area| area.checked_mul(nz))
        .unwrap_or(usize::MAX);
    if !are_free(count.saturating_mul(2 * size_of::<f64>())) {
        return Err(Fault::content(
            format!("has active voxels over {nx} x {ny} x {nz}, more than there is memory for"),
            "make it coarser, or crop it",
        ));
    }
    let of_grid = Density::of(grid);
    let density = |value: f32| of_grid.at(value);
    let mut values: Vec<f64> = Vec::new();
    let mut odd = false;
    walk(grid, |background, part| {
        if values.is_empty() {
            values = vec![density(background); count];
        }
        let mut fill = |(low, high): (Corner, Corner), value: f32| {
            odd |= !value.is_finite();
            let span = |axis: usize| low[axis].max(bounds.low[axis])..=high[axis].min(bounds.high[axis]);
            for z in span(2) {
                for y in span(1) {
                    for x in span(0) {
                        let place = [x - bounds.low[0], y - bounds.low[1], z - bounds.low[2]]
                            .map(|part| part as usize);
                        if let Some(slot) = values.get_mut((place[2] * ny + place[1]) * nx + place[0]) {
                            *slot = density(value);
                        }
                    }
                }
            }
        };
        match part {
            Part::Tile { at, side, value, .. } => fill(turn.cube(at, at.map(|x| x + side - 1)), value),
            Part::Leaf { at, values, .. } => {
                for (index, value) in values.into_iter().enumerate() {
                    fill(turn.voxel(at, index), value);
                }
            }
        }
        Ok(())
    })?;
    if odd {
        return Err(not_finite());
    }
    if values.len() != count {
        return Err(broken("it has no values"));
    }
    Ok(values)
}

/// The active voxels of the grid `name` in the file at `path`.
pub(in crate::keyframes) fn bounds(path: &Path, name: Option<&str>) -> Result<Bounds, Fault> {
    let file = bytes_of(path)?;
    bounds_of(&grid(&file, name)?, Turn { y_up: false })
}

/// The voxels of that grid within `bounds`, x fastest.
pub(in crate::keyframes) fn frame(
    path: &Path,
    name: Option<&str>,
    bounds: Bounds,
) -> Result<Vec<f64>, Fault> {
    let file = bytes_of(path)?;
    array(&grid(&file, name)?, bounds, Turn { y_up: false })
}
