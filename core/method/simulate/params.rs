//! What a caller chooses for simulations, free or driven.

use crate::checkpoint::Mix;
use crate::method::choices::{Kind, Numbers, choices};

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

choices!(PdParams, "pd" {
    drive: drive, Kind::Number(Numbers::NotNegative),
        "weight of the driving force, in lengths of the box and times between keyframes";
    attenuation: attenuation, Kind::Number(Numbers::NotNegative),
        "rate at which momentum is lost, per time between keyframes";
    gathering: gathering, Kind::Number(Numbers::NotNegative),
        "weight of the gathering term; 0.01 is strong";
});

impl PdParams {
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
    /// Residual of an implicit step, relative to the largest velocity.
    pub tolerance: f64,
}

impl Default for SimulationParams {
    fn default() -> Self {
        Self { tolerance: 1e-5 }
    }
}

choices!(SimulationParams, "simulation" {
    tolerance: tolerance, Kind::Number(Numbers::Below(1.0)),
        "of every method that simulates: residual of a step, in parts of the largest velocity";
});

impl SimulationParams {
    /// Mixes every number into the fingerprint of a checkpoint.
    pub fn mix(&self, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let Self { tolerance } = *self;
        mix.real(tolerance);
    }
}
