//! The memory of STFAS besides the finest level.

use super::level::LevelMut;
use super::params::{Setup, SmootherMemory};
use super::{local, smoother, transfer};
use crate::field::VectorMut;
use crate::grid::levels::{self, Levels, MAX_LEVELS};
use crate::grid::{Grid, Space};
use crate::memory::{Arena, Pool, Sharing, TooSmall, pooled};
use crate::poisson::Projection;
use crate::real::Real;
use core::marker::PhantomData;

/// The smoother's bases on every grid, which last for a whole solve.
#[derive(Debug)]
pub struct Bases<'m, T> {
    pub(super) tables: heapless::Vec<&'m mut [T], MAX_LEVELS>,
}

impl<'m, T: Real> Bases<'m, T> {
    /// Without elements: enough to measure a [`Workspace`].
    #[must_use]
    pub fn bare(grids: &[Grid]) -> Self {
        Self {
            tables: grids.iter().map(|_| Default::default()).collect(),
        }
    }

    /// Takes its elements and fills them.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn carve<S: Space>(arena: &mut Arena<'m>, levels: &Levels<'_, T>) -> Result<Self, TooSmall> {
        let grids = &levels.grids;
        let among_solids = levels.solids(0).there();
        let elements = arena.take::<T>("smoother bases", pooled(local::table_len::<S>()) * grids.len())?;
        if arena.ledger().is_some() {
            return Ok(Self::bare(grids));
        }
        let mut pool = Pool::new(elements);
        let fill = |grid: &Grid| {
            let table = pool.take("basis", local::table_len::<S>());
            local::fill_table::<T, S>(grid.h, among_solids, table);
            table
        };
        Ok(Self {
            tables: grids.iter().map(fill).collect(),
        })
    }
}

/// What ends a cycle among solid cells: see [`closing`](super::closing).
pub(super) struct Closing<'a, T> {
    /// Equation a, left-hand side minus right-hand side.
    pub(super) excess: VectorMut<'a, T>,
    pub(super) projection: Projection<'a, T>,
}

impl<'a, T: Real> Closing<'a, T> {
    /// Takes it from a pool where there are solids.
    fn carve(levels: &'a Levels<'_, T>, setup: &Setup, pool: &mut Pool<'a, T>) -> Option<Self> {
        let (grid, slots) = (&levels.finest, setup.slots);
        levels.solids(0).there().then(|| {
            pool.line("end of a cycle among solids", |pool| Self {
                excess: pool.take_vector("equation a", grid.dims, grid.cells() * slots),
                projection: Projection::carve(levels, 0, slots, setup.threads, pool),
            })
        })
    }
}

/// Elements of the parts of the scratch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts {
    /// Changes that other threads read.
    pub(super) waiting: usize,
    /// The smoother's scratch of all threads.
    pub(super) lines: usize,
    /// Any transfer, which has the same elements in turn.
    transfer: usize,
}

impl Parts {
    fn new<S: Space>(finest: &Grid, slots: usize, threads: usize, memory: SmootherMemory) -> Self {
        let grids = levels::hierarchy(finest);
        let most = |len: &dyn Fn(&Grid) -> usize| pooled(grids.iter().map(len).max().unwrap_or(0));
        Self {
            waiting: most(&|grid| smoother::waiting_len::<S>(grid, slots, threads, memory.split)),
            lines: pooled(threads * smoother::scratch_len::<S>(finest, slots, memory)),
            transfer: most(&|grid| transfer::scratch_len::<S>(grid, slots, threads, memory.split)),
        }
    }
}

/// The coarse levels of STFAS and its scratch.
pub struct Workspace<'a, T, S> {
    pub(super) coarse: heapless::Vec<LevelMut<'a, T>, MAX_LEVELS>,
    pub(super) scratch: &'a mut [T],
    pub(super) parts: Parts,
    pub(super) closing: Option<Closing<'a, T>>,
    space: PhantomData<S>,
}

impl<'a, T: Real, S: Space> Workspace<'a, T, S> {
    /// Takes them from a pool.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        bases: &'a Bases<'_, T>,
        setup: &Setup,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let slots = setup.slots;
        let parts = Parts::new::<S>(&hierarchy.finest, slots, setup.threads, setup.memory);
        pool.group("Navier-Stokes problem (NSO)", Sharing::Together, |pool| {
            let grids = hierarchy.grids.iter().zip(&bases.tables).enumerate().skip(1);
            let coarse = pool.line("coarse levels", |pool| {
                grids
                    .map(|(level, (grid, base))| {
                        LevelMut::coarse::<S>((grid, hierarchy.solids(level)), base, slots, pool)
                    })
                    .collect()
            });
            let uses = [
                (
                    "smoother: waiting changes, lines in time",
                    parts.waiting + parts.lines,
                ),
                ("transfer: rows of a block, residuals that wait", parts.transfer),
            ];
            Self {
                coarse,
                scratch: pool.take_longest("smoothing or transfer", &uses),
                parts,
                closing: Closing::carve(hierarchy, setup, pool),
                space: PhantomData,
            }
        })
    }
}
