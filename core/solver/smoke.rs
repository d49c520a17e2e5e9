//! The smoke that there is: a source, and what emitters make.

use super::shared::Verb;
use super::{InputError, Solver};
use crate::grid::Space;
use crate::objective::script::Script;
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Whether there is smoke to steer: a source or an emitter, and the shape of every emitter.
    pub(super) fn check_smoke(&self) -> Result<(), InputError> {
        let emitters = self.lists.spans.len() / 2;
        if self.mass <= 0.0 && emitters == 0 {
            return Err(InputError::NoSource);
        }
        match (0..emitters).find(|&index| self.emitter_mass(index) <= 0.0) {
            Some(index) => Err(InputError::NoEmitter { index }),
            None => Ok(()),
        }
    }

    /// The shape of emitter `index`.
    fn emitter_shape(&self, index: usize) -> &[T] {
        Script::new(self.lists, &*self.fields).shape(index, self.grid().cells())
    }

    /// The mass of that shape.
    fn emitter_mass(&self, index: usize) -> f64 {
        self.shared.mass(self.grid(), self.emitter_shape(index))
    }

    /// The largest density that emitter `index` adds at a step, or fills up to.
    pub(super) fn emitted(&self, index: usize) -> f64 {
        let most = Script::new(self.lists, &*self.fields).most_emitted(index, self.grid().cells());
        self.shared.largest(most)
    }

    /// The mass of the smoke at `step`: that of the source, and what emitters have added by their rates.
    #[must_use]
    pub fn mass_at(&self, step: usize) -> f64 {
        self.shared.ask(Verb::Mass, [step, 0, 0]);
        self.added_mass(step)
    }

    /// The same, of a rank whom all others follow in it.
    pub(super) fn added_mass(&self, step: usize) -> f64 {
        let spans = self.lists.spans.as_chunks().0;
        let supplies = spans.iter().zip(self.lists.supplies.as_chunks().0).enumerate();
        supplies.fold(self.mass, |mass, (index, (&[from, to], &[rate, _]))| {
            let steps = to.min(step as u32).saturating_sub(from);
            mass + rate * f64::from(steps) * self.emitter_mass(index)
        })
    }
}
