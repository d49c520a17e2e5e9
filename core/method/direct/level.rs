//! The data of one grid of the nested iteration, in elements that it shares with all coarser ones.

use super::setup::{Setup, slots_on, stride};
use crate::field::VectorMut;
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::Pool;
use crate::objective::script::Script;
use crate::objective::sweep::densities;
use crate::real::Real;

/// The data of one grid, and the numbers that its work or the coarser grids use.
pub struct LevelMut<'a, T> {
    pub initial: VectorMut<'a, T>,
    pub rho: &'a mut [T],
    pub v: VectorMut<'a, T>,
    pub script: Script<'a, T>,
    pub rest: &'a mut [T],
}

/// A coarser grid before its script is there.
pub struct NextMut<'a, T> {
    pub initial: VectorMut<'a, T>,
    pub rho: &'a mut [T],
    pub v: VectorMut<'a, T>,
    pub fields: &'a mut [T],
    pub rest: &'a mut [T],
}

impl<'a, T: Real> NextMut<'a, T> {
    /// The data of a coarser grid, all but what is left of the pool.
    pub fn carve(grid: &Grid, slots: usize, fields: usize, pool: &mut Pool<'a, T>) -> Self {
        let cells = grid.cells();
        Self {
            fields: pool.take("fields of the script", fields * cells),
            rho: pool.take("densities", densities(grid, slots)),
            initial: pool.take_vector("given velocity", grid.dims, cells),
            v: pool.take_vector("velocity", grid.dims, cells * slots),
            rest: &mut [],
        }
    }

    /// The same in the rest of the finer grid.
    pub fn within(grid: &Grid, slots: usize, fields: usize, rest: &'a mut [T]) -> Self {
        let mut pool = Pool::new(rest);
        let next = Self::carve(grid, slots, fields, &mut pool);
        Self {
            rest: pool.into_rest(),
            ..next
        }
    }

    /// With its script, that of another grid in its own fields.
    pub fn complete(self, script: &Script<'a, T>, stride: u32) -> LevelMut<'a, T> {
        LevelMut {
            initial: self.initial,
            rho: self.rho,
            v: self.v,
            script: script.coarse(stride, self.fields),
            rest: self.rest,
        }
    }
}

/// Grid `level` from the finest one, all in between carved one in the rest of the other.
pub fn down<'a, T: Real>(
    levels: &Levels<'_, T>,
    setup: &Setup,
    finest: LevelMut<'a, T>,
    level: usize,
) -> LevelMut<'a, T> {
    let script = finest.script;
    let grids = levels.grids.iter().enumerate().skip(1).take(level);
    grids.fold(finest, |at, (level, grid)| {
        NextMut::within(grid, slots_on(setup, level), script.fields(), at.rest)
            .complete(&script, stride(setup, level))
    })
}
