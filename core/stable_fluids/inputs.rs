//! What a simulation is given: densities and the velocity at the start.

use super::Fluids;
use crate::field::rows;
use crate::grid::Space;
use crate::problem::{PACKED, Problem};
use crate::real::Real;
use crate::solver::{InputError, check_density, finite};

impl<T: Real, S: Space> Fluids<'_, T, S> {
    /// Writes what follows from the problem alone.
    pub(super) fn fill(&mut self, problem: &Problem<'_>) {
        let (weights, rest) = self.numbers.split_at_mut_checked(self.keys).unwrap_or_default();
        weights.fill(1.0);
        weights
            .iter_mut()
            .zip(problem.keyframe_weights)
            .for_each(|(weight, &given)| *weight = given);
        for (step, &at) in self.steps.iter_mut().zip(problem.keyframes) {
            *step = at as u32;
        }
        let unit = problem.units().force;
        for (packed, template) in rest.as_chunks_mut::<PACKED>().0.iter_mut().zip(problem.templates) {
            *packed = template.scaled(problem.length, unit).pack();
        }
    }

    pub(super) fn check(&self, field: &[T]) -> Result<(), InputError> {
        finite(field, self.cells())
    }

    fn mass_of(&self, density: &[T]) -> Result<f64, InputError> {
        check_density(density, self.cells())?;
        let mass: f64 = density.iter().map(|value| value.to_f64()).sum();
        if mass > 0.0 {
            Ok(mass)
        } else {
            Err(InputError::Empty)
        }
    }

    /// Sets rho_0: one density for each cell, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite, no mass.
    pub fn set_source(&mut self, density: &[T]) -> Result<(), InputError> {
        self.mass = self.mass_of(density)?;
        rows::part_mut(self.source, 0..density.len()).copy_from_slice(density);
        self.taped = false;
        Ok(())
    }

    /// Sets keyframe `index`, after the source: scaled to the source's mass where masses are matched. By how much it was scaled.
    ///
    /// # Errors
    /// As [`Self::set_source`], or [`InputError::Index`], [`InputError::NoSource`].
    pub fn set_keyframe(&mut self, index: usize, density: &[T]) -> Result<f64, InputError> {
        let count = self.keys;
        if index >= count {
            return Err(InputError::Index { given: index, count });
        }
        let mass = self.mass_of(density)?;
        if self.mass <= 0.0 {
            return Err(InputError::NoSource);
        }
        let pitch = self.keyframes.len() / count.max(1);
        let factor = if self.match_mass { self.mass / mass } else { 1.0 };
        let out = rows::part_mut(self.keyframes, index * pitch..index * pitch + density.len());
        rows::scale(out, T::from_f64(factor), density);
        Ok(factor)
    }

    /// Sets component `axis` of the velocity at the start, at the centres of cells, in the scene's units, where one was announced.
    ///
    /// # Errors
    /// [`InputError`].
    pub fn set_initial_velocity(&mut self, axis: usize, velocity: &[T]) -> Result<(), InputError> {
        self.check(velocity)?;
        let count = if self.params.initial_velocity { S::DIM } else { 0 };
        if axis >= count {
            return Err(InputError::Index { given: axis, count });
        }
        let unit = T::from_f64(1.0 / self.units.velocity);
        if let Some(out) = self.initial.get_mut(axis) {
            rows::scale(out, unit, velocity);
        }
        self.taped = false;
        Ok(())
    }

    /// Whether all that was announced was given.
    pub(super) fn is_ready(&self) -> bool {
        let pitch = (self.keyframes.len() / self.keys.max(1)).max(1);
        let mut keyframes = self.keyframes.chunks_exact(pitch);
        self.mass > 0.0 && keyframes.all(|keyframe| keyframe.iter().any(|&value| value != T::ZERO))
    }
}
