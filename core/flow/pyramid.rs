//! The grids of a pyramid, and how frames come to the coarser ones.

use super::level::{Level, Terms};
use super::params::FlowParams;
use super::resample::{Kind, across_rows, along_rows};
use crate::exec::Exec;
use crate::field::{VectorMut, rows, view};
use crate::grid::Grid;
use crate::grid::gaussian::Gaussian;
use crate::grid::levels::Levels;
use crate::grid::spectrum::LONGEST;
use crate::memory::{Ledger, Pool, Sharing, measured, pooled};
use crate::observe::Observer;
use crate::operators::blur;
use crate::real::Real;
use crate::transport::Stop;

/// Grids at most.
pub const MAX_LEVELS: usize = 8;
/// Cells of a coarser grid along an axis at least.
const FEWEST: f64 = 8.0;
/// Cells beside a grid with a longer axis than [`LONGEST`] are a multiple of this.
const WHOLE: f64 = 16.0;

/// Products by A on each grid, finest first.
pub type Efforts = heapless::Vec<usize, MAX_LEVELS>;

/// The next coarser grid, or `None` where no axis would shrink.
fn coarser(grid: &Grid, eta: f64) -> Option<Grid> {
    let long = grid.n.iter().any(|&n| n > LONGEST);
    let whole = if long { WHOLE } else { 1.0 };
    let n = core::array::from_fn(|axis| {
        let cells = grid.n[axis];
        if axis >= grid.dims {
            return cells;
        }
        let fewer = whole * libm::floor(eta * cells as f64 / whole + 0.5);
        cells.min(fewer.max(FEWEST) as usize)
    });
    (n != grid.n).then(|| grid.of_cells(n))
}

/// The grids, finest first.
#[must_use]
pub fn grids(finest: &Grid, params: &FlowParams) -> heapless::Vec<Grid, MAX_LEVELS> {
    core::iter::successors(Some(*finest), |grid| coarser(grid, params.eta))
        .take(params.levels.min(MAX_LEVELS))
        .collect()
}

/// The workspace of the way down from a grid.
pub struct Descent<'a, T> {
    grid: &'a Grid,
    sigma: f64,
    fields: [&'a mut [T]; 2],
    scratch: &'a mut [T],
}

impl<'a, T: Real> Descent<'a, T> {
    /// Takes its workspace from a pool.
    pub fn carve(grid: &'a Grid, params: &FlowParams, threads: usize, pool: &mut Pool<'a, T>) -> Self {
        let blurred = params.sigma > 0.0;
        let radius = if blurred {
            Gaussian::of(params.sigma).radius
        } else {
            0
        };
        pool.group("frames of the next coarser grid", Sharing::Together, |pool| {
            Self {
                grid,
                sigma: params.sigma,
                fields: [(); 2].map(|()| pool.take("blurred", grid.cells())),
                scratch: pool.take("rows", pooled(blur::along_len(grid, radius, threads))),
            }
        })
    }

    /// `to` on the grid `coarse` = `from`, blurred and resampled.
    pub fn go(self, exec: &dyn Exec, coarse: &Grid, from: &[T], to: &mut [T]) {
        let Self {
            grid,
            sigma,
            fields: [mut blurred, mut next],
            scratch,
        } = self;
        blurred.copy_from_slice(from);
        if sigma > 0.0 {
            for axis in 0..grid.dims {
                blur::along(exec, (grid, axis), Gaussian::of(sigma), blurred, next, scratch);
                core::mem::swap(&mut blurred, &mut next);
            }
        }
        let grids = [grid, coarse];
        along_rows(exec, grids, Kind::Cells, blurred, next);
        across_rows(exec, grids, (Kind::Cells, 1.0), [next, blurred], to);
    }
}

/// Both frames on the grids below the finest, and a flow there.
#[derive(Debug, Default)]
pub struct Pyramid<'m, T> {
    /// The frames, from grid 1 on.
    pub frames: heapless::Vec<[&'m mut [T]; 2], MAX_LEVELS>,
    /// The flow of the grid that was solved last, while it goes to the next finer one.
    pub coarse: VectorMut<'m, T>,
}

/// What a flow between two frames is found with.
pub struct Search<'s, 'm, T> {
    /// The grids, finest first.
    pub levels: &'s Levels<'m, T>,
    /// What is chosen.
    pub params: &'s FlowParams,
    /// Threads that scratch was planned for.
    pub threads: usize,
    /// The coarser frames.
    pub pyramid: &'s mut Pyramid<'m, T>,
    /// Sums: two values a row of the finest grid.
    pub sums: &'s mut [f64],
}

impl<T: Real> Search<'_, '_, T> {
    /// The flow that carries the first frame to the second: the level that holds it, what is said of it, and how many products by A each
    /// grid took. `region` holds what [`measure`] says.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn find<'r>(
        &'r mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        frames: [&[T]; 2],
        region: &'r mut [T],
    ) -> Result<(Level<'r, T>, Terms, Efforts), Stop> {
        let Self {
            levels,
            params,
            threads,
            pyramid,
            sums,
        } = self;
        descend(exec, (&levels.grids, params, *threads), frames, pyramid, region);
        let mut efforts = Efforts::new();
        let grids = &levels.grids;
        efforts.resize(grids.len(), 0).unwrap_or(());
        for depth in (1..grids.len()).rev() {
            let Some(mut level) =
                Level::carve((levels, depth), params, *threads, &mut Pool::new(&mut *region))
            else {
                continue;
            };
            let coarser = grids.get(depth + 1).map(|grid| (grid, view(&pyramid.coarse)));
            level.estimate(exec, observer, coarser, sums)?;
            let own = pyramid.frames.get(depth - 1);
            let own = own.map_or([&[][..]; 2], |[first, second]| [&**first, &**second]);
            let begins = depth + 1 == grids.len();
            let products = level.correct(exec, observer, own, begins, None, sums)?;
            efforts
                .iter_mut()
                .skip(depth)
                .take(1)
                .for_each(|effort| *effort = products);
            for (to, from) in pyramid.coarse.iter_mut().zip(&level.flow) {
                rows::part_mut(to, 0..from.len()).copy_from_slice(from);
            }
        }
        let level = Level::carve((levels, 0), params, *threads, &mut Pool::new(region));
        let mut level = level.ok_or(Stop::Cancelled)?;
        let coarser = grids.get(1).map(|grid| (grid, view(&pyramid.coarse)));
        level.estimate(exec, observer, coarser, sums)?;
        let mut terms = Terms::default();
        let begins = grids.len() == 1;
        let products = level.correct(exec, observer, frames, begins, Some(&mut terms), sums)?;
        efforts.iter_mut().take(1).for_each(|effort| *effort = products);
        Ok((level, terms, efforts))
    }
}

/// Brings both frames to the coarser grids.
fn descend<T: Real>(
    exec: &dyn Exec,
    (grids, params, threads): (&[Grid], &FlowParams, usize),
    frames: [&[T]; 2],
    pyramid: &mut Pyramid<'_, T>,
    region: &mut [T],
) {
    for (depth, pair) in grids.windows(2).enumerate() {
        let [fine, coarse] = pair else { continue };
        let (known, next) = pyramid.frames.split_at_mut(depth);
        let Some(next) = next.first_mut() else { continue };
        for (which, to) in next.iter_mut().enumerate() {
            let above = known
                .last()
                .and_then(|frames| frames.get(which))
                .map(|frame| &**frame);
            let Some(from) = above.or_else(|| frames.get(which).copied()) else {
                continue;
            };
            let descent = Descent::carve(fine, params, threads, &mut Pool::new(&mut *region));
            descent.go(exec, coarse, from, to);
        }
    }
}

/// Counts what [`Search::find`] uses in turn.
pub fn measure<T: Real>(levels: &Levels<'_, T>, params: &FlowParams, threads: usize, ledger: &mut Ledger) {
    Descent::carve(&levels.finest, params, threads, &mut Pool::<T>::measuring(ledger));
    Level::carve((levels, 0), params, threads, &mut Pool::measuring(ledger));
    for (depth, grid) in levels.grids.iter().enumerate().skip(1) {
        let descent = measured::<T>(|pool| {
            let mut pool = pool;
            Descent::carve(grid, params, threads, &mut pool);
        });
        let own = measured::<T>(|pool| {
            let mut pool = pool;
            Level::carve((levels, depth), params, threads, &mut pool);
        });
        ledger.line("a coarser level of the pyramid", own.max(descent), T::BYTES);
    }
}
