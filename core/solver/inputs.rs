//! What a solve is given: densities and v_0.

use super::layout::FileLayout;
use super::{InputError, Solver};
use crate::checkpoint::Mix;
use crate::grid::Space;
use crate::grid::solids::SOLID;
use crate::real::Real;

/// A density of whose mass no more than this part is outside solid cells is refused.
const BURIED: f64 = 1e-2;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Sets which cells are solid, before any density: one flag for each cell, x fastest. Densities are 0 there, whatever is given.
    ///
    /// # Errors
    /// [`InputError::Length`]; [`InputError::NoFluid`] where all cells are solid; [`InputError::Index`] where the problem has no solid cells.
    pub fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        let expected = self.grid().cells();
        if !self.animation().levels.solids(0).there() {
            return Err(InputError::Index { given: 0, count: 0 });
        }
        if solid.len() != expected {
            return Err(InputError::Length {
                expected,
                given: solid.len(),
            });
        }
        if solid.iter().all(|&solid| solid) {
            return Err(InputError::NoFluid);
        }
        let levels = &mut self.engine.get_mut().parts().animation.levels;
        levels.set_solids(|cell| solid.get(cell).copied().unwrap_or(false));
        let mut mix = Mix::new();
        solid.iter().for_each(|&solid| mix.word(u64::from(solid)));
        self.solid_print = mix.finish();
        (self.prepared, self.finished) = (None, false);
        Ok(())
    }

    /// Whether cell `cell` is solid.
    #[must_use]
    pub fn is_solid(&self, cell: usize) -> bool {
        let n = self.grid().n[0];
        let row = self.animation().levels.solids(0).row(n, cell / n);
        row.get(cell % n).is_some_and(|bits| bits & SOLID != 0)
    }

    /// Sets rho_0: one density for each cell, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite, no mass.
    pub fn set_source(&mut self, density: &[T]) -> Result<(), InputError> {
        let mass = self.mass_of(density)?;
        let largest = density.iter().fold(0.0, |most: f64, &x| most.max(x.to_f64()));
        let emitters = 0..self.lists.spans.len() / 2;
        let largest = emitters.fold(largest, |most, index| most.max(self.emitted(index)));
        self.engine.get_mut().parts().set_source(density, largest);
        let parts = self.engine.get_mut().parts();
        let solids = parts.animation.levels.solids(0);
        solids.clear_cells(parts.animation.levels.finest.n[0], &mut *parts.animation.rho);
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
        self.mass_of(shape)?;
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
        self.mass_of(region)?;
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
        self.clear_field(index);
        self.finished = false;
    }

    /// Sets field `index` of the script to 0 in solid cells.
    fn clear_field(&mut self, index: usize) {
        let animation = self.engine.get().animation();
        let (grid, solids) = (animation.grid(), animation.levels.solids(0));
        let cells = grid.cells();
        if let Some(field) = self.fields.get_mut(index * cells..(index + 1) * cells) {
            solids.clear_cells(grid.n[0], field);
        }
    }

    /// The mass of a density outside solid cells, which must be finite and nowhere negative.
    fn mass_of(&self, density: &[T]) -> Result<f64, InputError> {
        let (grid, solids) = (self.grid(), self.animation().levels.solids(0));
        let n = grid.n[0];
        check(density, grid.cells())?;
        let rows = density.chunks_exact(n).enumerate();
        let mass = rows.fold(0.0, |sum, (row, values)| {
            let table = solids.row(n, row);
            let in_fluid = |&(x, _): &(usize, &T)| table.get(x).is_none_or(|bits| bits & SOLID == 0);
            values
                .iter()
                .enumerate()
                .filter(in_fluid)
                .fold(sum, |sum, (_, x)| sum + x.to_f64())
        });
        let whole: f64 = density.iter().map(|x| x.to_f64()).sum();
        match mass > BURIED * whole {
            true => Ok(mass),
            false if whole > 0.0 => Err(InputError::Buried),
            false => Err(InputError::Empty),
        }
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
        let mass = self.mass_of(density)?;
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
        self.clear_field(index);
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
        let field = &mut self.engine.get_mut().parts().animation.initial[axis];
        FileLayout::new(&grid, axis).read(faces, 1.0 / self.units.velocity, field)?;
        (self.prepared, self.finished) = (None, false);
        Ok(())
    }
}

/// Refuses a density of another length, or that is not finite or negative somewhere.
pub(super) fn check<T: Real>(density: &[T], cells: usize) -> Result<(), InputError> {
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
    Ok(())
}
