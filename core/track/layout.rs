//! The buffers of tracking, said once.

use super::force::Acting;
use super::params::Prediction;
use super::predict::{Carried, step_setup};
use super::{Capture, TrackParams, Tracker};
use crate::flow::pyramid::{self, Pyramid};
use crate::flow::warp::{Warp, transport_len};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Layout, Ledger, Pool, Sharing, TooSmall};
use crate::method::simulate::step::Step;
use crate::poisson::Projection;
use crate::real::Real;
use core::marker::PhantomData;

impl<'m, T: Real, S: Space> Tracker<'m, T, S> {
    /// A tracker without memory.
    #[inline(never)]
    pub(super) fn bare(capture: &Capture<'_>, params: &TrackParams) -> Self {
        let finest = Grid::in_cells(capture.cells, capture.boundary);
        let grids = pyramid::grids(&finest, &params.flow);
        Self {
            params: *params,
            density_scale: capture.density_scale,
            lift: capture.lift(),
            unit: capture.velocity_unit(),
            dt: capture.dt,
            levels: Levels::apart(&finest, &grids),
            frames: Default::default(),
            v: Default::default(),
            before: Default::default(),
            pyramid: Pyramid {
                frames: grids.iter().skip(1).map(|_| Default::default()).collect(),
                coarse: Default::default(),
            },
            whole: Default::default(),
            emission: capture.emission,
            carried: Default::default(),
            sums: &mut [],
            region: &mut [],
            given: 0,
            pairs: 0,
            space: PhantomData,
        }
    }

    /// Every buffer, in order.
    pub(super) fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let grid = *self.grid();
        let (dims, cells) = (grid.dims, grid.cells());
        layout.tables(|arena| self.levels.fill(arena))?;
        let [first, second, pulled] = &mut self.frames;
        layout.work("frame", first, cells)?;
        layout.work("next frame", second, cells)?;
        layout.work("next frame pulled back", pulled, cells)?;
        if self.emission {
            layout.work("next frame with what was made", &mut self.whole, cells)?;
        }
        layout.work_vector("flow", &mut self.v, dims, cells)?;
        let of_before = if self.params.forces { cells } else { 0 };
        layout.work_vector("flow of the pair before", &mut self.before, dims, of_before)?;
        for (grid, [one, other]) in self.levels.grids.iter().skip(1).zip(&mut self.pyramid.frames) {
            layout.work("frame on a coarser grid", one, grid.cells())?;
            layout.work("next frame on a coarser grid", other, grid.cells())?;
        }
        let coarse = self.levels.grids.get(1).map_or(0, Grid::cells);
        layout.work_vector("flow on a coarser grid", &mut self.pyramid.coarse, dims, coarse)?;
        let of_carried = if self.params.readvect { cells } else { 0 };
        for carried in &mut self.carried {
            layout.work("first frame carried by the flow", carried, of_carried)?;
        }
        layout.work("sums of rows", &mut self.sums, 2 * grid.rows())?;
        let (levels, params) = (&self.levels, &self.params);
        layout.in_turn(&mut self.region, 0, |ledger| uses(levels, params, ledger))
    }
}

/// What happens in turn.
fn uses<T: Real>(levels: &Levels<'_, T>, params: &TrackParams, ledger: &mut Ledger) {
    let (grid, threads) = (&levels.finest, params.threads);
    pyramid::measure(levels, &params.flow, threads, ledger);
    Warp::carve(grid, params.flow.warp, threads, &mut Pool::<T>::measuring(ledger));
    Projection::carve(levels, 0, 1, threads, &mut Pool::measuring(ledger));
    if params.predicts(Prediction::Implicit) {
        Step::carve(levels, 0, step_setup(threads), &mut Pool::measuring(ledger));
    }
    if params.predicts(Prediction::Bfecc) {
        Carried::carve(grid, &mut Pool::<T>::measuring(ledger));
    }
    if params.forces {
        Acting::carve(levels, threads, &mut Pool::<T>::measuring(ledger));
    }
    if params.readvect {
        ledger.group("re-advection", Sharing::Together, |ledger| {
            ledger.line("density transport", transport_len::<T>(grid, threads), T::BYTES);
        });
    }
}
