//! The targets of keyframes, scaled to the mass that there is.

use super::shared::Verb;
use super::{InputError, Solver};
use crate::grid::Space;
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Sets the target of keyframe `index`, after the source and all emitters; the factor by which it was scaled to the mass of the smoke at
    /// its step.
    ///
    /// # Errors
    /// As [`Self::set_source`], also of what the target is scaled to, or [`InputError::NoSource`] where there is no smoke yet at its step, [`InputError::NoEmitter`],
    /// [`InputError::Index`].
    pub fn set_keyframe(&mut self, index: usize, density: &[T]) -> Result<f64, InputError> {
        let count = self.lists.steps.len();
        if index >= count {
            return Err(InputError::Index { given: index, count });
        }
        self.shared.ask(Verb::Keyframe, [index, 0, 0]);
        self.take_keyframe(index, density)
    }

    /// Takes the target of keyframe `index`, which the first rank knows.
    pub(super) fn take_keyframe(&mut self, index: usize, density: &[T]) -> Result<f64, InputError> {
        self.check_smoke()?;
        let own = if self.shared.is_first() {
            self.mass_of(density)
        } else {
            Ok(0.0)
        };
        let mass = self.shared.told(*own.as_ref().unwrap_or(&f64::NAN));
        own?;
        if mass.is_nan() {
            // The first rank says why.
            return Err(InputError::NoSource);
        }
        let grid = *self.grid();
        let cells = grid.cells();
        let step = self.lists.steps.get(index).map_or(0, |&step| step as usize);
        let factor = self.factor(step, mass);
        let held = if self.shared.is_first() {
            self.holds(density, factor)
        } else {
            Ok(())
        };
        let told = self.shared.told(if held.is_ok() { 0.0 } else { f64::NAN });
        held?;
        if told.is_nan() {
            return Err(InputError::NoSource);
        }
        if factor <= 0.0 {
            return Err(InputError::NoSource);
        }
        let was_unset = self.is_unset(index);
        let target = &mut self.fields[index * cells..(index + 1) * cells];
        self.missing = self.missing.saturating_sub(usize::from(was_unset));
        self.finished = false;
        self.shared.put((&grid, None), density, T::ONE, target);
        target
            .iter_mut()
            .for_each(|target| *target = T::from_f64(target.to_f64() * factor));
        self.clear_field(index);
        Ok(factor)
    }

    /// What a target of this mass at a step is multiplied by.
    fn factor(&self, step: usize, mass: f64) -> f64 {
        if self.match_mass {
            self.added_mass(step) / mass
        } else {
            1.0
        }
    }

    /// Refuses a target of which the precision of the solve does not hold the multiple.
    fn holds(&self, density: &[T], factor: f64) -> Result<(), InputError> {
        let scaled = |value: T| T::from_f64(value.to_f64() * factor);
        if let Some(index) = density.iter().position(|&value| !scaled(value).is_finite()) {
            return Err(InputError::NotFinite { index });
        }
        if factor > 0.0 && density.iter().all(|&value| !(scaled(value) > T::ZERO)) {
            return Err(InputError::Empty);
        }
        Ok(())
    }

    /// Whether keyframe `index` has no target yet: all of it, that of other ranks too, is 0.
    pub(super) fn is_unset(&self, index: usize) -> bool {
        let given = self.keyframe(index).iter().any(|&x| x != T::ZERO);
        self.shared.largest(f64::from(u8::from(given))) == 0.0
    }
}
