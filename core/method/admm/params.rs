//! What a caller chooses for ADMM.

use crate::checkpoint::Mix;
use crate::method::refusal::{PlanError, count};
use crate::nso::{NsoParams, SmootherMemory};
use crate::problem::{ProblemError, positive};
use crate::progress::MAX_CYCLES;

/// What a caller chooses for ADMM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdmmParams {
    /// Penalty K, in the scene's units.
    pub penalty: f64,
    /// Relaxation beta.
    pub relaxation: f64,
    /// Fixed-point iterations of AO in each outer iteration.
    pub ao_iterations: usize,
    /// Momentum between the iterations of one AO, at least 0 and below 1; 0 is the paper's AO.
    pub ao_momentum: f64,
    /// Stop when rho changes less than this times max rho_0 in an outer iteration.
    pub density_tolerance: f64,
    /// Whether the flow begins as that of the same scene on a grid of half as many cells an axis, solved first.
    pub nested: bool,
    /// The Navier-Stokes problem.
    pub nso: NsoParams,
    /// How the smoother uses memory; by default the fastest way within the ceiling and the paper's bound. Changes no result.
    pub memory: Option<SmootherMemory>,
}

impl Default for AdmmParams {
    fn default() -> Self {
        Self {
            penalty: 1e3,
            relaxation: 1.0,
            ao_iterations: 2,
            ao_momentum: 0.0,
            density_tolerance: 0.01,
            nested: true,
            nso: NsoParams::default(),
            memory: None,
        }
    }
}

impl AdmmParams {
    /// Most fixed-point iterations of AO.
    pub const MOST_AO_ITERATIONS: usize = 1000;

    /// Checks every number.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self) -> Result<(), PlanError> {
        positive("admm.penalty", self.penalty)?;
        positive("admm.relaxation", self.relaxation)?;
        positive("admm.ao_iterations", self.ao_iterations as f64)?;
        if !(0.0..1.0).contains(&self.ao_momentum) {
            return Err(ProblemError::Momentum {
                given: self.ao_momentum,
            }
            .into());
        }
        positive("admm.density_tolerance", self.density_tolerance)?;
        positive("admm.nso_tolerance", self.nso.tolerance)?;
        positive("admm.nso_cycles", self.nso.cycles as f64)?;
        count("admm.ao_iterations", self.ao_iterations, Self::MOST_AO_ITERATIONS)?;
        count("admm.nso_cycles", self.nso.cycles, MAX_CYCLES - 1)
    }

    /// Mixes in every number that results follow from, for the fingerprint of a checkpoint.
    pub fn mix(&self, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let Self {
            penalty,
            relaxation,
            ao_iterations,
            ao_momentum,
            density_tolerance,
            nested,
            nso,
            memory: _,
        } = *self;
        let NsoParams {
            solver,
            tolerance,
            cycles,
            colours,
            norm,
        } = nso;
        let numbers = [penalty, relaxation, ao_momentum, density_tolerance, tolerance];
        numbers.into_iter().for_each(|number| mix.real(number));
        let words = [
            ao_iterations as u64,
            u64::from(nested),
            solver as u64,
            cycles as u64,
            colours as u64,
            norm as u64,
        ];
        words.into_iter().for_each(|word| mix.word(word));
    }
}
