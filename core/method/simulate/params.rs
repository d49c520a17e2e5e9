//! What a caller chooses for simulations, free or driven.

use crate::checkpoint::Mix;
use crate::method::refusal::PlanError;
use crate::problem::{ProblemError, not_negative, positive};

/// What a caller chooses for target-driven smoke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdParams {
    /// Weight of the driving force, in squared lengths of the box per squared time between keyframes.
    pub drive: f64,
    /// Rate at which momentum is lost, per time between keyframes.
    pub attenuation: f64,
    /// Weight of the gathering term, in squared lengths of the box per time between keyframes; 0 for none.
    pub gathering: f64,
}

impl Default for PdParams {
    fn default() -> Self {
        Self {
            drive: 10.0,
            attenuation: 20.0,
            gathering: 0.0,
        }
    }
}

impl PdParams {
    /// Checks every number.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self) -> Result<(), PlanError> {
        not_negative("pd.drive", self.drive)?;
        not_negative("pd.attenuation", self.attenuation)?;
        not_negative("pd.gathering", self.gathering)?;
        Ok(())
    }

    /// What one of `steps` steps from keyframe to keyframe keeps of momentum, and the impulse that it gets from a force of 1:
    /// v' = F - a v, solved exactly for one step.
    #[must_use]
    pub fn step(&self, steps: usize) -> [f64; 2] {
        let rate = self.attenuation / steps as f64;
        let impulse = if rate > 0.0 {
            -libm::expm1(-rate) / rate
        } else {
            1.0
        };
        [libm::exp(-rate), impulse * self.drive / (steps * steps) as f64]
    }

    /// Mixes every number into the fingerprint of a checkpoint.
    pub fn mix(&self, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let Self {
            drive,
            attenuation,
            gathering,
        } = *self;
        [drive, attenuation, gathering]
            .into_iter()
            .for_each(|number| mix.real(number));
    }
}

/// What a caller chooses for every simulation of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationParams {
    /// Upward acceleration of a free flow where the density is 1, in the scene's units; downward when negative.
    pub buoyancy: f64,
    /// Residual of an implicit step, relative to the largest velocity.
    pub tolerance: f64,
}

impl Default for SimulationParams {
    fn default() -> Self {
        Self {
            buoyancy: 0.0,
            tolerance: 1e-5,
        }
    }
}

impl SimulationParams {
    /// Checks every number.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self) -> Result<(), PlanError> {
        positive("simulation.tolerance", self.tolerance)?;
        if self.buoyancy.is_finite() {
            Ok(())
        } else {
            Err(ProblemError::NotFinite {
                field: "simulation.buoyancy",
                given: self.buoyancy,
            }
            .into())
        }
    }

    /// Mixes every number into the fingerprint of a checkpoint.
    pub fn mix(&self, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let Self { buoyancy, tolerance } = *self;
        [buoyancy, tolerance]
            .into_iter()
            .for_each(|number| mix.real(number));
    }
}
