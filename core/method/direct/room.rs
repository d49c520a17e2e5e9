//! How much a search asks of a device, and what a device cannot do yet.

use super::setup::Setup;
use crate::exec::device::Room;
use crate::grid::Grid;
use crate::method::params::Params;
use crate::objective::flow;
use crate::problem::{Feature, Problem, Scheme};
use crate::words::Named;

/// What a device takes of what a problem may ask for; the release comes after the search.
const TAKEN: [Feature; 4] = [
    Feature::Smoothness,
    Feature::Schedule,
    Feature::Regions,
    Feature::Release,
];

/// How large the search of a problem on the finest grid is, or what of the problem a device cannot do yet, in a word.
pub fn room(problem: &Problem<'_>, params: &Params) -> Result<Room, &'static str> {
    if let Some(feature) = Feature::ALL
        .iter()
        .find(|feature| problem.asks_for(**feature) && !TAKEN.contains(feature))
    {
        return Err(feature.name());
    }
    if problem.is_shared() {
        return Err("box that ranks share");
    }
    if problem.advection.scheme != Scheme::Limited {
        return Err("other advection than limited");
    }
    let setup = Setup::new(problem, params);
    if setup.history.halves() {
        return Err("pairs in half the bytes");
    }
    let (flow, keyframes) = (&setup.flow, problem.keyframes.len());
    let regions = problem.asks_for(Feature::Regions);
    Ok(room_of(
        &setup.grid,
        flow,
        setup.history.fields(),
        keyframes,
        regions,
    ))
}

/// That of a search on `grid`, which has so many `fields` of L-BFGS and so many keyframes.
pub fn room_of(grid: &Grid, flow: &flow::Setup, fields: usize, keyframes: usize, regions: bool) -> Room {
    Room {
        dims: grid.dims,
        cells: grid.n,
        slots: flow.sweep.slots,
        fields,
        keyframes,
        regions,
        weighs: flow.weighs(),
        filters: flow.sweep.metric.filters,
    }
}
