//! What one iteration finds of what the one before left in the finest grid's rest, on whichever grid that is: the data of the grids down to it,
//! and quasi-Newton's fields on it. Behind them is work.

use super::level::NextMut;
use super::setup::{Setup, slots_on};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{Held, Pool, Visit};
use crate::objective::sweep::densities;
use crate::optimise::quasi_newton;
use crate::real::Real;

/// Elements of it at most, on the grids down to `coarsest`, where one program has all of each.
pub fn len<T: Real>(levels: &Levels<'_, T>, setup: &Setup, coarsest: usize) -> usize {
    let grids = levels.grids.iter().take(coarsest + 1).enumerate();
    let (mut above, mut most) = (0, 0);
    for (level, grid) in grids {
        let (grid, slots) = (grid.whole(), slots_on(setup, level));
        let (cells, vector) = (grid.cells(), grid.dims * grid.cells());
        if level > 0 {
            above += setup.fields * cells + densities(&grid, slots) + vector + vector * slots;
        }
        most = most.max(above + setup.history.fields() * vector * slots);
    }
    most
}

/// Shows it to `visit` on grid `level`.
pub fn show<T: Real>(
    levels: &Levels<'_, T>,
    setup: &Setup,
    level: usize,
    rest: &mut [T],
    visit: &mut dyn Visit<T>,
) {
    let mut at = rest;
    for (level, grid) in levels.grids.iter().enumerate().skip(1).take(level) {
        let next = NextMut::within(grid, slots_on(setup, level), setup.fields, at);
        let held = Held::of(grid.parts(), grid.dims, None);
        let cells = grid.cells().max(1);
        for field in next
            .fields
            .chunks_exact_mut(cells)
            .chain(next.rho.chunks_exact_mut(cells))
        {
            visit.field(field, held);
        }
        for field in [next.initial, next.v] {
            show_vector(grid, field, visit);
        }
        at = next.rest;
    }
    let Some(grid) = levels.grids.get(level) else {
        return;
    };
    let mut pool = Pool::new(at);
    let fields = quasi_newton::fields::take(grid, slots_on(setup, level), setup.history, &mut pool);
    fields
        .into_iter()
        .for_each(|field| show_vector(grid, field, visit));
}

fn show_vector<T>(grid: &Grid, field: [&mut [T]; 3], visit: &mut dyn Visit<T>) {
    for (axis, component) in field.into_iter().enumerate().take(grid.dims) {
        visit.field(component, Held::of(grid.parts(), grid.dims, Some(axis)));
    }
}
