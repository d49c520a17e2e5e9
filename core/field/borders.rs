//! The copies that a rank has of its neighbours' planes and rows, brought up to date. Whoever writes rows by what is beside them calls this when it is
//! done, so that every field has right copies; where nobody shares the box nothing happens.

use super::VectorMut;
use super::transfer::Place;
use crate::exec::{Exec, ranks};
use crate::grid::{Grid, part};
use crate::memory::{Held, Plain};

/// Brings the copies in a field up to date, which holds as many values in each of its rows.
pub fn refresh<T: Plain + Default>(exec: &dyn Exec, grid: &Grid, field: &mut [T]) {
    ranks::refresh(exec.ranks(), Held::of(grid.parts(), grid.dims, None), field);
}

/// Brings the copies in a field of faces up to date. On the lowest faces of the copies stands 0, as on a wall: there a stencil looks that
/// reaches beyond the high wall of the box.
pub fn refresh_faces<T: Plain + Default>(exec: &dyn Exec, grid: &Grid, field: &mut VectorMut<'_, T>) {
    for (axis, component) in field.iter_mut().enumerate().take(grid.dims) {
        ranks::refresh(
            exec.ranks(),
            Held::of(grid.parts(), grid.dims, Some(axis)),
            component,
        );
    }
}

/// Brings a field up to date that was passed from one grid to another: see [`part::settle`].
pub fn settle<T: Plain + Default>(exec: &dyn Exec, grids: [&Grid; 2], place: Place, field: &mut [T]) {
    let axis = match place {
        Place::Cell => None,
        Place::Face(axis) => Some(axis),
    };
    part::settle(exec.ranks(), grids, axis, field);
}
