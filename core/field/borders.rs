//! The copies that a rank has of its neighbours' planes, brought up to date. Whoever writes rows by what is beside them calls this when it is
//! done, so that every field has right copies; where nobody shares the box nothing happens.

use super::VectorMut;
use super::rows::part_mut;
use super::transfer::Place;
use crate::exec::{Exec, ranks};
use crate::grid::Grid;
use crate::memory::part::cut;
use crate::memory::{Held, Plain};
use core::ops::Range;

/// Brings the copies in a field up to date, which holds as many values in each of its rows.
pub fn refresh<T: Plain + Default>(exec: &dyn Exec, grid: &Grid, field: &mut [T]) {
    ranks::refresh(exec.ranks(), Held::of(grid.part(), grid.dims, None), field);
}

/// Brings the copies in a field of faces up to date. On the lowest faces of the copies stands 0, as on a wall: there a stencil looks that
/// reaches beyond the high wall of the box.
pub fn refresh_faces<T: Plain + Default>(exec: &dyn Exec, grid: &Grid, field: &mut VectorMut<'_, T>) {
    for (axis, component) in field.iter_mut().enumerate().take(grid.dims) {
        ranks::refresh(
            exec.ranks(),
            Held::of(grid.part(), grid.dims, Some(axis)),
            component,
        );
    }
}

/// Brings a field up to date that was passed from grid `source` to grid `target`: the copies of its neighbours' planes; or where a rank has all of
/// the coarser grid and a part of the finer one, what the others have [made](made_here).
pub fn settle<T: Plain + Default>(
    exec: &dyn Exec,
    [source, target]: [&Grid; 2],
    place: Place,
    field: &mut [T],
) {
    let (Some(part), None) = (source.part(), target.part()) else {
        let axis = match place {
            Place::Cell => None,
            Place::Face(axis) => Some(axis),
        };
        return ranks::refresh(exec.ranks(), Held::of(target.part(), target.dims, axis), field);
    };
    let plane = field.len() / target.planes().max(1);
    for rank in 0..part.share.ranks {
        let planes = cut(target.planes(), 1, rank, part.share.ranks);
        let made = part_mut(field, planes.start * plane..planes.end * plane);
        ranks::tell(exec.ranks(), rank, made);
    }
}

/// The planes of `target` that this rank makes of what it has of `source`.
#[must_use]
pub fn made_here(source: &Grid, target: &Grid) -> Range<usize> {
    match (source.part(), target.part()) {
        (Some(part), None) => cut(target.planes(), 1, part.share.rank, part.share.ranks),
        _ => target.own_planes(),
    }
}
