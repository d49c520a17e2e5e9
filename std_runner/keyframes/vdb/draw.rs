//! A volume on the cells of a box.

use std::path::Path;

use super::container::{self, Grid};
use super::dense::{Bounds, Turn, bounds_of, bytes_of};
use super::gather::gather;
use crate::keyframes::error::Fault;
use crate::keyframes::mesh::{Fit, Placed, Up};
use crate::keyframes::note::Note;
use crate::keyframes::resample::{Edge, Taps, windows};
use crate::keyframes::{Canvas, ShapeError};
use crate::undershoot::Undershoot;

/// The grid `name` of the file at `path`, placed as a mesh is; what was found of it is added to `notes`.
pub(in crate::keyframes) fn draw(
    path: &Path,
    name: Option<&str>,
    placed: &Placed<'_>,
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    if canvas.dimensions() != 3 {
        let remedy = "use `image`, `text`, an array or the flat shapes in 2D";
        return Err(ShapeError::key(
            "file",
            "is a volume in space, and the grid is 2D",
            remedy,
        ));
    }
    let up = placed.up.map_or(Ok(Up::Z), Up::parse)?;
    let turn = Turn { y_up: up == Up::Y };
    let of = |fault: Fault| fault.of("file", path);
    let file = bytes_of(path).map_err(of)?;
    let grid = container::grid(&file, name).map_err(of)?;
    let active = bounds_of(&grid, turn).map_err(of)?;
    let (scale, origin) = steps(&grid, turn);
    let around = match placed.first {
        Some(first) if first != path => {
            let found = || -> Result<[[f64; 3]; 2], Fault> {
                let file = bytes_of(first)?;
                let grid = container::grid(&file, name)?;
                Ok(corners(&grid, bounds_of(&grid, turn)?, turn))
            };
            found().map_err(|fault| fault.of("file", first))?
        }
        _ => corners(&grid, active, turn),
    };
    let fit = Fit::of(placed.fit, around, canvas)?;
    let bounds = active.wider();
    let shape = bounds.sides();
    let taps = core::array::from_fn(|axis| {
        let (size, middle) = (
            fit.scale * scale[axis],
            fit.scale * origin[axis] + fit.shift[axis],
        );
        let start = -middle / size - bounds.low[axis] as f64 + 0.5;
        let cells = canvas.cells.get(axis).copied().unwrap_or(1);
        let step = canvas.cell_size() / size;
        let mut taps = windows(cells, shape[axis], start, step, Edge::Empty);
        if canvas.repeats(axis) {
            for image in [-1.0, 1.0] {
                let start = start + image * cells as f64 * step;
                let more = windows(cells, shape[axis], start, step, Edge::Empty);
                taps.iter_mut()
                    .zip(more)
                    .for_each(|(taps, more)| taps.extend(within(more, shape[axis])));
            }
        }
        taps
    });
    let gathered = gather(&grid, bounds, turn, &taps).map_err(of)?;
    let below = gathered.below.as_ref();
    if let Some(found) = below.filter(|found| !found.is_small()) {
        let [x, y, z] = shape;
        let [found, remedy] = found.refused(&[z, y, x]);
        return Err(of(Fault::content(found, remedy)));
    }
    let clipped = below.map(Undershoot::taken);
    let [x, y, z] = active.sides();
    let (shown, said) = (
        path.display(),
        clipped.map_or(String::new(), |text| format!("; it {text}")),
    );
    if let Some(sides) = canvas.left(corners(&grid, active, turn).map(|corner| fit.of_point(corner))) {
        notes.push(Note::warning(format!(
            "a part of the volume `{shown}` lies outside of the box, {sides}, and is cut off; move it inwards, or make it smaller"
        )));
    }
    notes.push(Note::remark(format!(
        "grid `{}` of `{shown}`, {} up, has {x} x {y} x {z} voxels{said}",
        grid.name,
        up.name()
    )));
    Ok(gathered.cells)
}

/// Taps of the voxels themselves, without those of the layer that was put around them.
fn within(taps: Taps, voxels: usize) -> impl Iterator<Item = (usize, f64)> {
    taps.into_iter()
        .filter(move |&(voxel, _)| voxel > 0 && voxel + 1 < voxels)
}

/// Side of a voxel along each axis, and the middle of voxel 0, z up.
fn steps(grid: &Grid<'_>, turn: Turn) -> ([f64; 3], [f64; 3]) {
    let ([sx, sy, sz], [ox, oy, oz]) = (grid.scale, grid.origin);
    if turn.y_up {
        ([sx, sz, sy], [ox, -oz, oy])
    } else {
        (grid.scale, grid.origin)
    }
}

/// Lowest and highest corner of the voxels within `bounds`.
fn corners(grid: &Grid<'_>, bounds: Bounds, turn: Turn) -> [[f64; 3]; 2] {
    let (scale, origin) = steps(grid, turn);
    let side = |voxel: [i64; 3], half: f64| {
        core::array::from_fn(|axis| origin[axis] + scale[axis] * (voxel[axis] as f64 + half))
    };
    [side(bounds.low, -0.5), side(bounds.high, 0.5)]
}
