//! How much a search asks of a device, and what a device cannot do yet.

use super::setup::Setup;
use crate::exec::device::Room;
use crate::grid::Grid;
use crate::method::params::Params;
use crate::objective::flow;
use crate::problem::{Feature, Problem, Scheme};
use crate::words::Named;

/// What a device takes of what a problem may ask for; the release comes after the search.
const TAKEN: [Feature; 10] = [
    Feature::Open,
    Feature::Solids,
    Feature::Smoothness,
    Feature::Buoyancy,
    Feature::Mask,
    Feature::Emitters,
    Feature::Jets,
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
    let given = Given {
        keyframes: problem.keyframes.len(),
        regions: problem.asks_for(Feature::Regions),
        emitters: problem.emitters.len(),
    };
    Ok(room_of(&setup.grid, &setup.flow, setup.history.fields(), given))
}

/// Fields of cells that a search is given.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    /// Keyframes.
    pub keyframes: usize,
    /// Whether they have regions.
    pub regions: bool,
    /// Emitters.
    pub emitters: usize,
}

/// That of a search on `grid`, which has so many `fields` of L-BFGS.
pub fn room_of(grid: &Grid, flow: &flow::Setup, fields: usize, given: Given) -> Room {
    Room {
        dims: grid.dims,
        cells: grid.n,
        slots: flow.sweep.slots,
        fields,
        keyframes: given.keyframes,
        regions: given.regions,
        emitters: given.emitters,
        solids: flow.sweep.surfaces.obstacles || grid.is_open(),
        obstacles: flow.sweep.surfaces.obstacles,
        masked: flow.masked,
        weighs: flow.weighs(),
        filters: flow.sweep.metric.filters,
    }
}
