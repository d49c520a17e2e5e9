//! The copies that a rank has of its neighbours' planes, brought up to date. Whoever writes rows by what is beside them calls this when it is
//! done, so that every field has right copies; where nobody shares the box nothing happens.

use super::VectorMut;
use crate::exec::{Exec, ranks::swap};
use crate::grid::Grid;
use crate::grid::part::REACH;
use crate::memory::Plain;

/// Brings the copies in a field up to date, which holds as many values in each of its rows.
pub fn refresh<T: Plain>(exec: &dyn Exec, grid: &Grid, field: &mut [T]) {
    if !grid.is_part() {
        return;
    }
    let plane = field.len() / grid.planes().max(1);
    let (ranks, own, reach) = (exec.ranks(), grid.own_planes(), REACH * plane);
    let [below, above] = grid.neighbours();
    let (rest, high) = field.split_at_mut(own.end * plane);
    let (low, rest) = rest.split_at_mut(own.start * plane);
    let copied = |neighbour: Option<usize>| if neighbour.is_some() { reach } else { 0 };
    let first = rest.get(..copied(below)).unwrap_or(&[]);
    swap(ranks, below, first, above, high);
    let last = rest
        .get(rest.len().saturating_sub(copied(above))..)
        .unwrap_or(&[]);
    swap(ranks, above, last, below, low);
}

/// Brings the copies in a field of faces up to date. On the lowest faces of the copies stands 0, as on a wall: there a stencil looks that
/// reaches beyond the high wall of the box.
pub fn refresh_faces<T: Plain + Default>(exec: &dyn Exec, grid: &Grid, field: &mut VectorMut<'_, T>) {
    if !grid.is_part() {
        return;
    }
    for component in field.iter_mut().take(grid.dims) {
        refresh(exec, grid, component);
    }
    if let ([Some(_), _], Some(across)) = (grid.neighbours(), field.get_mut(grid.dims - 1)) {
        let plane = across.len() / grid.planes().max(1);
        across
            .iter_mut()
            .take(plane)
            .for_each(|face| *face = T::default());
    }
}
