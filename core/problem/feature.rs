//! What a problem may ask for that not every method can.

use super::Problem;
use crate::words::named;

/// What a problem may ask for that not every method can.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// A price of the force's curl: [`Problem::smoothness`].
    Smoothness,
    /// Densities that push the flow: [`Problem::buoyancy`].
    Buoyancy,
    /// Solid cells: [`Problem::solids`].
    Solids,
    /// A price of the force that changes: [`Problem::schedule`].
    Schedule,
    /// A price of the force that differs from place to place: [`Problem::mask`].
    Mask,
    /// Open sides of the box: [`Problem::boundary`].
    Open,
    /// A force made of templates: [`Problem::templates`].
    Templates,
    /// Smoke that is made on the way: [`Problem::emitters`].
    Emitters,
    /// Emitters whose smoke has a velocity: [`Emitter::velocity`](super::Emitter::velocity).
    Jets,
    /// Keyframes that matter here and there alone: [`Problem::keyframe_regions`].
    Regions,
    /// A force that ends before the end: [`Problem::release`].
    Release,
    /// Surfaces to which the flow sticks: [`Problem::slip`].
    Sticking,
}

named!(Feature {
    Smoothness = "smoothness",
    Buoyancy = "buoyancy",
    Solids = "solid cells",
    Schedule = "schedule",
    Mask = "mask",
    Open = "open sides",
    Templates = "templates",
    Emitters = "emitters",
    Jets = "velocity of emitters",
    Regions = "regions of keyframes",
    Release = "release",
    Sticking = "flow that sticks to surfaces"
});

impl Problem<'_> {
    /// Whether it asks for a feature.
    #[must_use]
    pub fn asks_for(&self, feature: Feature) -> bool {
        match feature {
            Feature::Smoothness => self.smoothness.is_some_and(|cells| cells > 0.0),
            Feature::Buoyancy => self.buoyancy != [0.0; 3],
            Feature::Solids => self.solids,
            Feature::Schedule => !self.schedule.is_empty(),
            Feature::Mask => self.mask,
            Feature::Open => self.is_open(),
            Feature::Templates => !self.templates.is_empty(),
            Feature::Emitters => !self.emitters.is_empty(),
            Feature::Regions => self.keyframe_regions,
            Feature::Release => self.release.is_some(),
            Feature::Sticking => !self.slip,
            Feature::Jets => self.emitters.iter().any(|emitter| emitter.velocity.is_some()),
        }
    }
}
