//! The numbers of a simulation.

use super::guide::GuideParams;
use super::params::{PdParams, SimulationParams};
use super::step;
use crate::grid::Grid;
use crate::method::params::{Method, Params};
use crate::objective::flow;
use crate::problem::Problem;

/// What pushes the smoke.
#[derive(Clone, Copy, Debug)]
pub enum Push {
    /// Nothing but buoyancy, if there is any.
    Nothing,
    /// The next keyframe.
    Target(PdParams),
    /// A given flow, which stands in the slots of v until they are simulated.
    Reference(GuideParams),
}

/// All that a simulation follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The grid.
    pub grid: Grid,
    /// The objective of a flow; max rho_0 is set with the source.
    pub flow: flow::Setup,
    /// Relative tolerance of a step.
    pub tolerance: f64,
    /// What pushes.
    pub push: Push,
}

impl Setup {
    /// That of `problem`.
    #[must_use]
    pub fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let SimulationParams { tolerance } = params.simulation;
        Self {
            grid: problem.grid(),
            flow: flow::Setup::new(problem, params.threads),
            tolerance,
            push: match params.method {
                Method::Pd => Push::Target(params.pd),
                Method::Guide => Push::Reference(params.guide),
                _ => Push::Nothing,
            },
        }
    }

    /// What guides, if anything does.
    pub fn guide(&self) -> Option<GuideParams> {
        match self.push {
            Push::Reference(params) => Some(params),
            _ => None,
        }
    }

    /// That of a step.
    pub fn step(&self) -> step::Setup {
        step::Setup::both_ways(self.flow.viscosity, self.tolerance, self.flow.sweep.threads)
    }
}
