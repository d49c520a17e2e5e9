//! What a solve is given: densities and v_0.

use super::layout::{FileLayout, Run, finite, put_solids};
use super::shared::Verb;
use super::{InputError, Solver};
use crate::checkpoint::Mix;
use crate::exec::ranks::Alone;
use crate::field::rows;
use crate::grid::Space;
use crate::grid::levels::Levels;
use crate::grid::solids::SOLID;
use crate::method::animation::Animation;
use crate::real::Real;

/// A density of whose mass no more than this part is outside solid cells is refused.
const BURIED: f64 = 1e-2;
/// And one of no more than this, where it is nowhere half as dense as inside them: what is left is the soft edge of a shape.
const EDGE: f64 = 0.25;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Sets which cells are solid, before any density: one flag for each cell, x fastest. Densities are 0 there, whatever is given.
    ///
    /// # Errors
    /// [`InputError::Length`]; [`InputError::NoFluid`] where all cells are solid; [`InputError::Index`] where the problem has no solid cells;
    /// [`InputError::SolidsLate`] after a source or a keyframe.
    pub fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        check_solids(&self.animation().levels, solid)?;
        if solid.iter().all(|&solid| solid) {
            return Err(InputError::NoFluid);
        }
        if self.mass > 0.0 || self.missing < self.lists.steps.len() {
            return Err(InputError::SolidsLate);
        }
        self.shared.ask(Verb::Solids, [0; 3]);
        self.take_solids(solid);
        Ok(())
    }

    /// Takes which cells are solid, which the first rank has checked.
    pub(super) fn take_solids(&mut self, solid: &[bool]) {
        let mut mix = Mix::new();
        solid.iter().for_each(|&solid| mix.word(u64::from(solid)));
        self.solid_print = self.shared.told(mix.finish());
        let levels = &mut self.engine.get_mut().parts().animation.levels;
        match self.shared.ranks {
            Some(ranks) => self.shared.put_solids(ranks, levels, solid),
            None => put_solids(&Alone, levels, solid),
        }
        self.prepared = None;
        self.changed();
    }

    /// Whether the cell at (x, y, z) is solid.
    #[must_use]
    pub fn is_solid(&self, at: [usize; 3]) -> bool {
        let whole = self.grid().whole();
        let inside = whole.inside();
        let at @ [x, y, z] = core::array::from_fn(|axis| inside[axis].start + at[axis]);
        if self.is_shared() {
            let place = FileLayout::of_cells(&whole).place(at);
            return place.is_some_and(|place| self.shared.is_solid(place));
        }
        let row = self.animation().levels.solids(0).row(whole.n[0], whole.row(y, z));
        row.get(x).is_some_and(|bits| bits & SOLID != 0)
    }

    /// Cells of a density that is given: those inside the box.
    #[must_use]
    pub fn cells(&self) -> usize {
        FileLayout::of_cells(&self.grid().whole()).len()
    }

    /// Sets rho_0: one density for each cell, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite, no mass.
    pub fn set_source(&mut self, density: &[T]) -> Result<(), InputError> {
        let mass = self.mass_of(density)?;
        let largest = density.iter().fold(0.0, |most: f64, &x| most.max(x.to_f64()));
        self.shared.ask(Verb::Source, [0; 3]);
        self.take_source(density, [mass, largest]);
        Ok(())
    }

    /// Takes rho_0, whose mass and largest value the first rank knows.
    pub(super) fn take_source(&mut self, density: &[T], [mass, largest]: [f64; 2]) {
        self.put_source(density, largest);
        self.mass = self.shared.told(mass);
    }

    /// Writes rho_0, of at most `largest`.
    pub(super) fn put_source(&mut self, density: &[T], largest: f64) {
        let emitters = 0..self.lists.spans.len() / 2;
        let largest = emitters.fold(largest, |most, index| most.max(self.emitted(index)));
        let largest = self.shared.told(largest);
        let parts = self.engine.get_mut().parts();
        parts.setup.sweep.largest = largest;
        let Animation { levels, rho, .. } = parts.animation;
        let grid = &levels.finest;
        let rho = rows::part_mut(rho, 0..grid.cells());
        self.shared.put((grid, None), density, T::ONE, rho);
        levels.solids(0).clear_cells(grid.n[0], rho);
        self.changed();
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
        self.shared.ask(Verb::Emitter, [index, 0, 0]);
        self.take_emitter(index, shape);
        Ok(())
    }

    /// Takes the shape of emitter `index`, which the first rank has checked.
    pub(super) fn take_emitter(&mut self, index: usize, shape: &[T]) {
        self.put_field(self.lists.emitters_begin() + index, shape);
        let added = self.emitted(index);
        let largest = &mut self.engine.get_mut().parts().setup.sweep.largest;
        *largest = largest.max(added);
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
        self.set_part(keyframes + index, region)
    }

    /// Sets where force may act, cell by cell: 1 everywhere, 0 nowhere, and between at 1 / mask^2 times the price.
    ///
    /// # Errors
    /// As [`Self::set_source`], or [`InputError::Index`] where the problem has no mask, [`InputError::AboveOne`].
    pub fn set_mask(&mut self, mask: &[T]) -> Result<(), InputError> {
        if !self.lists.mask {
            return Err(InputError::Index { given: 0, count: 0 });
        }
        let index = self.lists.mask_begins();
        self.set_part(index, mask)
    }

    /// Gives exits the mask of the cell inside.
    fn extend_mask(&mut self) {
        let (grid, cells, index) = (*self.grid(), self.grid().cells(), self.lists.mask_begins());
        let inside = grid.inside();
        if let Some(field) = self.fields.get_mut(index * cells..(index + 1) * cells) {
            for cell in 0..cells {
                let at = grid.cell_at(cell / grid.n[0], cell % grid.n[0]);
                let nearest = core::array::from_fn(|a| at[a].clamp(inside[a].start, inside[a].end - 1));
                field[cell] = field[grid.index(nearest)];
            }
        }
    }

    /// Writes field `index` of the script, of values from 0 to 1 that are not 0 everywhere.
    fn set_part(&mut self, index: usize, part: &[T]) -> Result<(), InputError> {
        self.mass_of(part)?;
        if let Some(index) = part.iter().position(|&x| x > T::ONE) {
            return Err(InputError::AboveOne { index });
        }
        self.shared.ask(Verb::Part, [index, 0, 0]);
        self.put_field(index, part);
        Ok(())
    }

    /// Writes field `index` of the script, which the first rank has checked.
    pub(super) fn put_field(&mut self, index: usize, values: &[T]) {
        let grid = *self.grid();
        let cells = grid.cells();
        if let Some(field) = self.fields.get_mut(index * cells..(index + 1) * cells) {
            self.shared.put((&grid, None), values, T::ONE, field);
        }
        self.clear_field(index);
        if grid.is_open() && self.lists.mask && index == self.lists.mask_begins() {
            self.extend_mask();
        }
        self.changed();
    }

    /// Sets field `index` of the script to 0 in solid cells.
    pub(super) fn clear_field(&mut self, index: usize) {
        let animation = self.engine.get().animation();
        let (grid, solids) = (animation.grid(), animation.levels.solids(0));
        let cells = grid.cells();
        if let Some(field) = self.fields.get_mut(index * cells..(index + 1) * cells) {
            solids.clear_cells(grid.n[0], field);
        }
    }

    /// The mass of a density outside solid cells, which must be finite and nowhere negative.
    pub(super) fn mass_of(&self, density: &[T]) -> Result<f64, InputError> {
        let (grid, solids) = (self.grid(), self.animation().levels.solids(0));
        let (n, whole) = (grid.n[0], grid.whole());
        let layout = FileLayout::of_cells(&whole);
        check(density, layout.len())?;
        let begin = (0.0, 0.0);
        let sum = |(sum, most): (f64, f64), x: &T| (sum + x.to_f64(), most.max(x.to_f64()));
        let (mass, densest) = layout.runs().fold(begin, |found, Run { row, x, file, count }| {
            let table = solids.row(n, row);
            let in_fluid = |&(at, _): &(usize, &T)| match self.is_shared() {
                true => !self.shared.is_solid(file + at),
                false => table.get(x + at).is_none_or(|bits| bits & SOLID == 0),
            };
            rows::part(density, file..file + count)
                .iter()
                .enumerate()
                .filter(in_fluid)
                .fold(found, |found, (_, x)| sum(found, x))
        });
        let (whole, most) = density.iter().fold(begin, sum);
        let is_edge = densest < 0.5 * most && mass <= EDGE * whole;
        match mass > BURIED * whole && !is_edge {
            true => Ok(mass),
            false if whole > 0.0 => Err(InputError::Buried),
            false => Err(InputError::Empty),
        }
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
        finite(faces, FileLayout::new(&grid.whole(), axis).len())?;
        self.shared.ask(Verb::Velocity, [axis, 0, 0]);
        self.take_velocity(axis, faces);
        Ok(())
    }

    /// Takes a component of v_0, which the first rank has checked.
    pub(super) fn take_velocity(&mut self, axis: usize, faces: &[T]) {
        let (grid, unit) = (*self.grid(), T::from_f64(1.0 / self.units.velocity));
        let Some(field) = self.engine.get_mut().parts().animation.initial.get_mut(axis) else {
            return;
        };
        self.shared.put((&grid, Some(axis)), faces, unit, field);
        self.prepared = None;
        self.changed();
    }
}

/// Refuses flags of solid cells where there is no room for them, or of another number than there are cells inside the box.
pub(crate) fn check_solids<T: Real>(levels: &Levels<'_, T>, solid: &[bool]) -> Result<(), InputError> {
    if !levels.solids(0).obstacles() {
        return Err(InputError::Index { given: 0, count: 0 });
    }
    let (expected, given) = (FileLayout::of_cells(&levels.finest.whole()).len(), solid.len());
    if given != expected {
        return Err(InputError::Length { expected, given });
    }
    Ok(())
}

/// Refuses a density of another length, or that is not finite or negative somewhere.
pub(crate) fn check<T: Real>(density: &[T], cells: usize) -> Result<(), InputError> {
    finite(density, cells)?;
    if let Some(index) = density.iter().position(|&x| x < T::ZERO) {
        return Err(InputError::Negative { index });
    }
    Ok(())
}
