//! The data of one grid of the nested iteration, in elements that it shares with all coarser ones.

use super::setup::{Setup, slots_on, stride};
use crate::field::VectorMut;
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::Pool;
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep::densities;
use crate::real::Real;

/// The data of one grid, and the numbers that its work or the coarser grids use.
pub struct LevelMut<'a, T> {
    pub initial: VectorMut<'a, T>,
    pub rho: &'a mut [T],
    pub v: VectorMut<'a, T>,
    pub keyframes: Keyframes<'a, T>,
    pub rest: &'a mut [T],
}

/// A coarser grid before its keyframes are there.
pub struct NextMut<'a, T> {
    pub initial: VectorMut<'a, T>,
    pub rho: &'a mut [T],
    pub v: VectorMut<'a, T>,
    pub densities: &'a mut [T],
    pub rest: &'a mut [T],
}

impl<'a, T: Real> NextMut<'a, T> {
    /// The data of a coarser grid, all but what is left of the pool.
    pub fn carve(grid: &Grid, slots: usize, keyframes: usize, pool: &mut Pool<'a, T>) -> Self {
        let cells = grid.cells();
        Self {
            densities: pool.take("keyframe densities", keyframes * cells),
            rho: pool.take("densities", densities(grid, slots)),
            initial: pool.take_vector("given velocity", grid.dims, cells),
            v: pool.take_vector("velocity", grid.dims, cells * slots),
            rest: &mut [],
        }
    }

    /// The same in the rest of the finer grid.
    pub fn within(grid: &Grid, slots: usize, keyframes: usize, rest: &'a mut [T]) -> Self {
        let mut pool = Pool::new(rest);
        let next = Self::carve(grid, slots, keyframes, &mut pool);
        Self {
            rest: pool.into_rest(),
            ..next
        }
    }

    /// With its keyframes, at the steps of those on another grid.
    pub fn complete(self, keyframes: &Keyframes<'a, T>, stride: u32) -> LevelMut<'a, T> {
        LevelMut {
            initial: self.initial,
            rho: self.rho,
            v: self.v,
            keyframes: keyframes.coarse(stride, self.densities),
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
    let keyframes = finest.keyframes;
    let grids = levels.grids.iter().enumerate().skip(1).take(level);
    grids.fold(finest, |at, (level, grid)| {
        NextMut::within(grid, slots_on(setup, level), keyframes.count(), at.rest)
            .complete(&keyframes, stride(setup, level))
    })
}
