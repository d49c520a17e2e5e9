//! What a solve is given: densities and v_0.

use super::layout::FileLayout;
use super::{InputError, Solver};
use crate::grid::Space;
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Sets rho_0: one density for each cell, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite, no mass.
    pub fn set_source(&mut self, density: &[T]) -> Result<(), InputError> {
        let cells = self.grid().cells();
        let mass = mass(density, cells)?;
        let largest = density.iter().fold(0.0, |most: f64, &x| most.max(x.to_f64()));
        let emitters = 0..self.lists.spans.len() / 2;
        let largest = emitters.fold(largest, |most, index| most.max(self.emitted(index)));
        self.engine.get_mut().parts().set_source(density, largest);
        self.mass = mass;
        self.finished = false;
        Ok(())
    }

    /// Sets the shape of emitter `index`: where it adds smoke, and how much of its rate or target there.
    ///
    /// # Errors
    /// As [`Self::set_source`], or [`InputError::Index`].
    pub fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        let count = self.lists.spans.len() / 2;
        if index >= count {
            return Err(InputError::Index { given: index, count });
        }
        mass(shape, self.grid().cells())?;
        self.put_field(self.lists.emitters_begin() + index, shape);
        let added = self.emitted(index);
        let largest = &mut self.engine.get_mut().parts().setup.sweep.largest;
        *largest = largest.max(added);
        Ok(())
    }

    /// Sets the region of keyframe `index`: what its error is multiplied by, from 0 to 1, cell by cell.
    ///
    /// # Errors
    /// As [`Self::set_source`], or [`InputError::Index`], [`InputError::AboveOne`].
    pub fn set_region(&mut self, index: usize, region: &[T]) -> Result<(), InputError> {
        let keyframes = self.lists.steps.len();
        let count = if self.lists.regions { keyframes } else { 0 };
        if index >= count {
            return Err(InputError::Index { given: index, count });
        }
        mass(region, self.grid().cells())?;
        if let Some(index) = region.iter().position(|&x| x > T::ONE) {
            return Err(InputError::AboveOne { index });
        }
        self.put_field(keyframes + index, region);
        Ok(())
    }

    /// Writes field `index` of the script.
    fn put_field(&mut self, index: usize, values: &[T]) {
        let cells = self.grid().cells();
        if let Some(field) = self.fields.get_mut(index * cells..(index + 1) * cells) {
            field.copy_from_slice(values);
        }
        self.finished = false;
    }

    /// Sets the target of keyframe `index`, after the source and all emitters; the factor by which it was scaled to the mass of the smoke at
    /// its step.
    ///
    /// # Errors
    /// As [`Self::set_source`], or [`InputError::NoSource`] where there is no smoke yet at its step, [`InputError::NoEmitter`],
    /// [`InputError::Index`].
    pub fn set_keyframe(&mut self, index: usize, density: &[T]) -> Result<f64, InputError> {
        let (cells, count) = (self.grid().cells(), self.lists.steps.len());
        if index >= count {
            return Err(InputError::Index { given: index, count });
        }
        self.check_smoke()?;
        let mass = mass(density, cells)?;
        let step = self.lists.steps.get(index).map_or(0, |&step| step as usize);
        let factor = if self.match_mass {
            self.mass_at(step) / mass
        } else {
            1.0
        };
        if factor <= 0.0 {
            return Err(InputError::NoSource);
        }
        let target = &mut self.fields[index * cells..(index + 1) * cells];
        self.missing = self
            .missing
            .saturating_sub(usize::from(target.iter().all(|&x| x == T::ZERO)));
        self.finished = false;
        target
            .iter_mut()
            .zip(density)
            .for_each(|(target, &x)| *target = T::from_f64(x.to_f64() * factor));
        Ok(factor)
    }

    /// Sets a component of v_0, in the layout of a file (one more face than cells along a wall axis), in the scene's units.
    ///
    /// # Errors
    /// [`InputError`]: no such axis, wrong length, a value that is not finite.
    pub fn set_initial_velocity(&mut self, axis: usize, faces: &[T]) -> Result<(), InputError> {
        let grid = *self.grid();
        if axis >= grid.dims {
            return Err(InputError::Index {
                given: axis,
                count: grid.dims,
            });
        }
        let layout = FileLayout::new(&grid, axis);
        if faces.len() != layout.len() {
            return Err(InputError::Length {
                expected: layout.len(),
                given: faces.len(),
            });
        }
        if let Some(index) = faces.iter().position(|x| !x.is_finite()) {
            return Err(InputError::NotFinite { index });
        }
        let scale = T::from_f64(1.0 / self.units.velocity);
        let field = &mut self.engine.get_mut().parts().animation.initial[axis];
        layout.each_row(|row, file, wall| {
            let at = &mut field[row * grid.n[0]..(row + 1) * grid.n[0]];
            for (x, value) in at.iter_mut().enumerate() {
                *value = if wall || layout.wall_face(x) {
                    T::ZERO
                } else {
                    faces[file + x] * scale
                };
            }
        });
        (self.prepared, self.finished) = (None, false);
        Ok(())
    }
}

/// The sum of a density that is finite and nowhere negative.
fn mass<T: Real>(density: &[T], cells: usize) -> Result<f64, InputError> {
    if density.len() != cells {
        return Err(InputError::Length {
            expected: cells,
            given: density.len(),
        });
    }
    if let Some(index) = density.iter().position(|x| !x.is_finite()) {
        return Err(InputError::NotFinite { index });
    }
    if let Some(index) = density.iter().position(|&x| x < T::ZERO) {
        return Err(InputError::Negative { index });
    }
    let mass: f64 = density.iter().map(|x| x.to_f64()).sum();
    if mass > 0.0 {
        Ok(mass)
    } else {
        Err(InputError::Empty)
    }
}
