//! The numbers of a solve by ADMM.

use super::ao;
use super::params::AdmmParams;
use crate::grid::Grid;
use crate::method::params::Params;
use crate::nso::damping::LocalDamping;
use crate::nso::surroundings::Surroundings;
use crate::nso::{self, SmootherMemory};
use crate::objective::flow;
use crate::problem::Problem;

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The finest grid.
    pub grid: Grid,
    /// AO's numbers, the objective among them; max rho_0 is set with the source.
    pub ao: ao::Setup,
    /// The caller's choices.
    pub params: AdmmParams,
    /// How the smoother uses memory.
    pub memory: SmootherMemory,
    /// Fields of the script.
    pub fields: usize,
    /// Outer iterations at most.
    pub iterations: usize,
}

impl Setup {
    /// That of `problem`.
    #[must_use]
    pub fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let admm = params.admm;
        let units = problem.units();
        Self {
            grid: problem.grid(),
            ao: ao::Setup {
                penalty: admm.penalty * units.velocity * units.velocity,
                iterations: admm.ao_iterations,
                momentum: admm.ao_momentum,
                flow: flow::Setup::new(problem, params.threads),
            },
            params: admm,
            memory: admm.memory.unwrap_or(SmootherMemory::LEAST),
            fields: problem.fields(),
            iterations: params.iterations,
        }
    }

    /// How the Navier-Stokes problem of an iteration is posed and solved.
    pub fn nso(&self) -> nso::Setup {
        let flow::Setup {
            sweep,
            viscosity,
            force_weight,
            projection_tolerance,
            ..
        } = self.ao.flow;
        nso::Setup {
            kappa: self.ao.penalty / force_weight,
            viscosity,
            slots: sweep.slots,
            threads: sweep.threads,
            params: self.params.nso,
            damping: LocalDamping::USUAL,
            surroundings: Surroundings::WITH_MASS,
            memory: self.memory,
            projection_tolerance,
        }
    }
}
