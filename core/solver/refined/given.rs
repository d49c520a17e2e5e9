//! What a finer picture is made from: solid cells, densities, and the flow of a step.

use super::Refined;
use crate::real::Real;
use crate::solver::InputError;
use crate::solver::inputs::check;
use crate::solver::layout::FileLayout;

impl<T: Real> Refined<'_, T> {
    /// Sets which cells of the finer grid are solid, before any density: one flag for each, x fastest.
    ///
    /// # Errors
    /// [`InputError::Length`]; [`InputError::Index`] where the problem has no solid cells.
    pub fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        let expected = self.cells();
        if !self.levels.solids(0).there() {
            return Err(InputError::Index { given: 0, count: 0 });
        }
        if solid.len() != expected {
            return Err(InputError::Length {
                expected,
                given: solid.len(),
            });
        }
        self.levels
            .set_solids(|cell| solid.get(cell).copied().unwrap_or(false));
        Ok(())
    }

    /// Sets the density, and that it is of step 0: one number for each cell of the finer grid, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite.
    pub fn set_density(&mut self, density: &[T]) -> Result<(), InputError> {
        check(density, self.cells())?;
        self.rho.copy_from_slice(density);
        let n = self.levels.finest.n[0];
        self.levels.solids(0).clear_cells(n, self.rho);
        self.largest = density.iter().fold(self.largest, |most, x| most.max(x.to_f64()));
        self.step = 0;
        Ok(())
    }

    /// Sets the shape of emitter `index`.
    ///
    /// # Errors
    /// As [`Self::set_density`], or [`InputError::Index`].
    pub fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        let cells = self.cells();
        check(shape, cells)?;
        let count = self.lists.spans.len() / 2;
        let field = self.fields.get_mut(index * cells..(index + 1) * cells);
        let field = field.ok_or(InputError::Index { given: index, count })?;
        field.copy_from_slice(shape);
        let n = self.levels.finest.n[0];
        self.levels.solids(0).clear_cells(n, field);
        let supply = self.lists.supplies.get(2 * index..2 * index + 2).unwrap_or(&[]);
        let supply: f64 = supply.iter().sum();
        self.largest = shape
            .iter()
            .fold(self.largest, |most, x| most.max(supply * x.to_f64()));
        Ok(())
    }

    /// Sets a component of the flow of the step that comes next, on the result's grid, in the layout of a file (one more face than cells along a
    /// wall axis) and the scene's units.
    ///
    /// # Errors
    /// [`InputError`]: no such axis, wrong length, a value that is not finite.
    pub fn set_velocity(&mut self, axis: usize, faces: &[T]) -> Result<(), InputError> {
        let grid = self.grids[0];
        let count = grid.dims;
        let [flow, ..] = &mut self.flows;
        let Some(field) = flow.get_mut(axis).filter(|_| axis < count) else {
            return Err(InputError::Index { given: axis, count });
        };
        FileLayout::new(&grid, axis).read(faces, 1.0 / self.unit, field)
    }
}
