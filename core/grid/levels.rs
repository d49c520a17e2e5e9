//! Coarser grids, what fields pass between two of them by, and the eigenvectors of each.
//!
//! An axis of n > 2 cells coarsens to n / 2, and where n is odd to the even one of the two lengths beside that, so that the
//! next grid halves exactly. 5 coarsens to 3: two cells would be too few.

use super::Grid;
use super::solids::{self, Solids, Surfaces};
use super::spectrum::Spectrum;
use super::tables::Tables;
use crate::exec::Ranks;
use crate::exec::ranks::Alone;
use crate::memory::{Arena, TooSmall};
use crate::real::Real;

/// Most levels: 4096 cells halve eleven times.
pub const MAX_LEVELS: usize = 12;

/// The next coarser grid, or `None` when no axis has more than two cells.
#[must_use]
pub fn coarsen(grid: &Grid) -> Option<Grid> {
    let inside = grid.inside().map(|inside| inside.len());
    let n = inside.map(|n| {
        if n > 2 {
            n.div_ceil(2) - usize::from(n % 4 == 1 && n > 5)
        } else {
            n
        }
    });
    let h = core::array::from_fn(|a| grid.h[a] * inside[a] as f64 / n[a] as f64);
    (n != inside).then_some(Grid { h, ..*grid }.with_inside(n))
}

/// The grids of a hierarchy, finest first. Of a box that ranks share every rank has a part of those that have planes and rows enough for all of them, and
/// the whole of the coarser ones.
#[must_use]
pub fn hierarchy(finest: &Grid) -> heapless::Vec<Grid, MAX_LEVELS> {
    let parts = finest.parts();
    let enough = |grid: &Grid| {
        let has = |axis: usize| {
            let part = finest.part_along(axis);
            part.is_none_or(|part| grid.axis(axis).inside().len() >= part.reach * part.line.count)
        };
        parts.filter(|_| (0..grid.dims).all(has)).map(|parts| parts.share)
    };
    core::iter::successors(Some(finest.whole()), coarsen)
        .take(MAX_LEVELS)
        .map(|grid| grid.shared(enough(&grid)))
        .collect()
}

/// The grids of a hierarchy, finest first, with the weights between neighbours.
#[derive(Debug)]
pub struct Levels<'m, T> {
    /// The first of them.
    pub finest: Grid,
    /// The grids.
    pub grids: heapless::Vec<Grid, MAX_LEVELS>,
    /// The weights between grid l and grid l + 1.
    pub tables: heapless::Vec<Tables<'m, T>, MAX_LEVELS>,
    /// The eigenvectors of every grid, see [`Self::spectrum`].
    eigenvectors: &'m [T],
    /// Gaussians that are known in their terms.
    filters: usize,
    /// Whether there are no tables yet, only what workspaces are measured by.
    bare: bool,
    /// What the flow meets, and the table of all grids: see [`Self::solids`].
    surfaces: Surfaces,
    solids: &'m mut [u16],
}

impl<'m, T: Real> Levels<'m, T> {
    fn taps(grids: &[Grid]) -> usize {
        grids
            .windows(2)
            .map(|pair| Tables::<T>::len(&pair[0], &pair[1]))
            .sum()
    }

    /// The grids alone, by which workspaces can be measured; `filters` is that of the finest metric.
    #[must_use]
    pub fn bare(finest: &Grid, filters: usize) -> Self {
        let grids = hierarchy(finest);
        Self {
            finest: *finest,
            tables: grids.windows(2).map(|_| Tables::default()).collect(),
            grids,
            eigenvectors: &[],
            filters,
            bare: true,
            surfaces: Surfaces::default(),
            solids: &mut [],
        }
    }

    /// One grid without coarser ones.
    #[must_use]
    pub fn alone(grid: &Grid) -> Self {
        Self::apart(grid, core::slice::from_ref(grid))
    }

    /// Grids of which `finest` is the first, and between which nothing is passed.
    #[must_use]
    pub fn apart(finest: &Grid, grids: &[Grid]) -> Self {
        Self {
            grids: grids.iter().take(MAX_LEVELS).copied().collect(),
            tables: heapless::Vec::new(),
            ..Self::bare(finest, 0)
        }
    }

    /// The same with room for obstacles, where there may be any.
    #[must_use]
    pub fn with_surfaces(self, surfaces: Surfaces) -> Self {
        Self { surfaces, ..self }
    }

    /// Whether cells have a table: where there are obstacles or open sides.
    fn has_table(&self) -> bool {
        self.surfaces.obstacles || self.finest.is_open()
    }

    /// Takes its buffers and fills them; `filters` is that of the finest metric.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn carve(arena: &mut Arena<'m>, finest: &Grid, filters: usize) -> Result<Self, TooSmall> {
        let mut levels = Self::bare(finest, filters);
        levels.fill(arena)?;
        Ok(levels)
    }

    /// Takes the buffers of levels that are bare, and fills them. In place, since they take much of a stack.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn fill(&mut self, arena: &mut Arena<'m>) -> Result<(), TooSmall> {
        let filters = self.filters;
        let grids = &self.grids;
        let taps = if self.tables.is_empty() {
            0
        } else {
            Self::taps(grids)
        };
        let (mut index, mut weight): (&mut [u16], &mut [T]) = (&mut [], &mut []);
        if taps > 0 {
            index = arena.take("transfer positions", taps)?;
            weight = arena.take("transfer weights", taps)?;
        }
        let spectra = grids.iter().map(|grid| Spectrum::<T>::len(grid, filters));
        let eigenvectors = arena.take::<T>("eigenvectors", spectra.sum())?;
        let cells = grids.iter().map(Grid::cells).sum::<usize>();
        let solids = if self.has_table() {
            arena.take::<u16>("solid cells", cells)?
        } else {
            &mut []
        };
        if arena.ledger().is_some() {
            return Ok(());
        }
        for (pair, tables) in grids.windows(2).zip(&mut self.tables) {
            let len = Tables::<T>::len(&pair[0], &pair[1]);
            let (these_index, rest_index) = core::mem::take(&mut index).split_at_mut(len);
            let (these_weight, rest_weight) = core::mem::take(&mut weight).split_at_mut(len);
            (index, weight) = (rest_index, rest_weight);
            *tables = Tables::new(&pair[0], &pair[1], these_index, these_weight);
        }
        let mut rest = &mut *eigenvectors;
        for grid in grids {
            let len = Spectrum::<T>::len(grid, filters);
            let (these, after) = rest.split_at_mut(len);
            if len > 0 {
                Spectrum::fill(grid, filters, these);
            }
            rest = after;
        }
        (self.eigenvectors, self.solids, self.bare) = (eigenvectors, solids, false);
        // Ranks that share the box do it together: see `Solver::share`.
        if !self.finest.is_part() {
            self.set_solids(&Alone, |_| false);
        }
        Ok(())
    }

    /// Gaussians of the finest metric.
    #[must_use]
    pub fn filters(&self) -> usize {
        self.filters
    }

    /// The solid cells of grid `level`.
    #[must_use]
    pub fn solids(&self, level: usize) -> Solids<'_> {
        if !self.has_table() {
            return Solids::none(self.surfaces.stick);
        }
        let begin: usize = self.grids.iter().take(level).map(Grid::cells).sum();
        let end = begin + self.grids.get(level).map_or(0, Grid::cells);
        Solids::new(self.solids.get(begin..end).unwrap_or(&[]), self.surfaces)
    }

    /// Sets which cells of the finest grid are solid, of a part of it the rank's own, and what follows for the coarser ones.
    pub fn set_solids(&mut self, ranks: &dyn Ranks, solid: impl Fn(usize) -> bool) {
        let finest = self.finest.cells();
        let Some((mut fine, mut rest)) = self.solids.split_at_mut_checked(finest) else {
            return;
        };
        for (cell, bits) in fine.iter_mut().enumerate() {
            *bits = if solid(cell) { solids::SOLID } else { 0 };
        }
        solids::fill(ranks, &self.finest, fine);
        for pair in self.grids.windows(2) {
            let Some((coarse, after)) = rest.split_at_mut_checked(pair[1].cells()) else {
                return;
            };
            solids::coarsen(ranks, &pair[0], fine, &pair[1], coarse);
            (fine, rest) = (coarse, after);
        }
    }

    /// Takes over the solid cells of `fine`, whose grids from `level` on are these.
    pub fn take_solids(&mut self, fine: &Levels<'_, T>, level: usize) {
        let above: usize = fine.grids.iter().take(level).map(Grid::cells).sum();
        let below = fine.solids.get(above..).unwrap_or(&[]);
        self.solids
            .iter_mut()
            .zip(below)
            .for_each(|(bits, &of_fine)| *bits = of_fine);
    }

    /// The eigenvectors of grid `level`.
    #[must_use]
    pub fn spectrum(&self, level: usize) -> Spectrum<'_, T> {
        if self.bare {
            return Spectrum::default();
        }
        let before = self.grids.iter().take(level);
        let start = before.map(|grid| Spectrum::<T>::len(grid, self.filters)).sum();
        Spectrum::view(
            &self.grids[level],
            self.filters,
            self.eigenvectors.get(start..).unwrap_or(&[]),
        )
    }
}
