//! The numbers of an operator that do not change.

use super::params::OperatorParams;
use crate::method::simulate::step;
use crate::problem::Problem;
use crate::transport::Stepping;

/// The numbers of an operator that do not change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    pub params: OperatorParams,
    /// N.
    pub steps: usize,
    pub stepping: Stepping,
    pub viscosity: f64,
    /// b in scaled numbers.
    pub buoyancy: [f64; 3],
    /// Velocities and forces of the scene in scaled ones.
    pub velocity_unit: f64,
    pub force_unit: f64,
    pub projection_tolerance: f64,
    pub emitters: usize,
    /// States that are kept.
    pub slots: usize,
}

impl Setup {
    /// Those of `problem`, with so many kept states.
    pub fn new(problem: &Problem<'_>, params: &OperatorParams, slots: usize) -> Self {
        let units = problem.units();
        Self {
            params: *params,
            steps: problem.steps,
            stepping: problem.advection.into(),
            viscosity: problem.scaled_viscosity(),
            buoyancy: problem.scaled_buoyancy(),
            velocity_unit: units.velocity,
            force_unit: units.force,
            projection_tolerance: problem.projection_tolerance.min(params.tolerance),
            emitters: problem.emitters.len(),
            slots,
        }
    }

    /// Those of an implicit step.
    pub fn step(&self) -> step::Setup {
        step::Setup::both_ways(self.viscosity, self.params.tolerance, self.params.threads)
    }
}
