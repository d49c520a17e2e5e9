//! The templates of a result: as a search has found them, or as they were given where none was made.

use super::Solver;
use crate::grid::Space;
use crate::method::templates::unknowns::{Place, places};
use crate::problem::Template;
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    fn place(&self, index: usize) -> Option<Place> {
        let animation = self.animation();
        places(self.lists.templates(), animation.grid(), animation.slots).nth(index)
    }

    /// Template `index` in the scene's units with its middle and radius as they are now, and its first amplitude; `None` where there is none.
    #[must_use]
    pub fn template(&self, index: usize) -> Option<Template> {
        let place = self.place(index)?;
        let length = self.units.velocity * self.units.velocity / self.units.force;
        let now = match self.engine.get().unknowns() {
            [] => place.given,
            z => place.template(z),
        };
        let amplitude = self.amplitude(index, 0);
        Some(Template {
            amplitude,
            ..now.scaled(1.0 / length, 1.0)
        })
    }

    /// The amplitude of template `index` in its interval `interval`, in the scene's unit of a force; 0 where there is none.
    #[must_use]
    pub fn amplitude(&self, index: usize, interval: usize) -> [f64; 3] {
        let Some(place) = self.place(index) else {
            return [0.0; 3];
        };
        let scaled = match self.engine.get().unknowns() {
            [] => place.given.amplitude,
            z => place.amplitude(z, interval),
        };
        scaled.map(|a| a * self.units.force)
    }
}
