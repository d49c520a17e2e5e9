//! What a [`Refined`] density is given: solid cells, densities, importance, emitters, and the flow of a step.

use super::Refined;
use crate::exec::Exec;
use crate::exec::ranks::Alone;
use crate::field::rows;
use crate::flow::resample::{Kind, resample};
use crate::memory::Pool;
use crate::real::Real;
use crate::solver::InputError;
use crate::solver::inputs::{check, check_solids};
use crate::solver::layout::FileLayout;
use crate::solver::layout::put_solids;

impl<T: Real> Refined<'_, T> {
    /// Sets which cells of the finer grid are solid, before any density: one flag for each, x fastest.
    ///
    /// # Errors
    /// [`InputError::Length`]; [`InputError::Index`] where the problem has no solid cells.
    pub fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        check_solids(&self.levels, solid)?;
        put_solids(&Alone, &mut self.levels, solid);
        Ok(())
    }

    /// Sets the density, and that it is of step 0: one number for each cell of the finer grid, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite.
    pub fn set_density(&mut self, density: &[T]) -> Result<(), InputError> {
        check(density, self.cells())?;
        FileLayout::of_cells(&self.levels.finest).write(density, T::ONE, self.rho);
        self.begin();
        Ok(())
    }

    /// Sets the density from that of the result's grid, doubled as often as the flow by cubics; where those go below 0 it is 0.
    ///
    /// # Errors
    /// As [`Self::set_density`].
    pub fn set_density_of_result(&mut self, exec: &dyn Exec, density: &[T]) -> Result<(), InputError> {
        self.double_cells(exec, density)?;
        self.rho.copy_from_slice(self.next);
        self.begin();
        Ok(())
    }

    /// Adds smoke of the result's grid to the density, by cubics.
    ///
    /// # Errors
    /// As [`Self::set_density`].
    pub fn add_of_result(&mut self, exec: &dyn Exec, smoke: &[T]) -> Result<(), InputError> {
        self.double_cells(exec, smoke)?;
        let n = self.levels.finest.n[0];
        self.levels.solids(0).clear_cells(n, self.next);
        self.add_next();
        Ok(())
    }

    /// The density of the next step becomes the field `given` of the result's cells, doubled as often as the flow by cubics, 0 where those go
    /// below it.
    fn double_cells(&mut self, exec: &dyn Exec, given: &[T]) -> Result<(), InputError> {
        let (finest, cells) = (&self.levels.finest, self.levels.finest.cells());
        let coarsest = FileLayout::of_cells(self.grids.first().unwrap_or(finest)).len();
        check(given, coarsest)?;
        if self.grids.len() < 2 {
            FileLayout::of_cells(finest).write(given, T::ONE, self.next);
            return Ok(());
        }
        let pool = &mut Pool::new(&mut *self.region);
        let [mut now, work, more] = [(); 3].map(|()| pool.take("cubics", cells));
        let mut next = &mut *self.next;
        rows::part_mut(now, 0..given.len()).copy_from_slice(given);
        for (coarse, fine) in self.grids.iter().zip(self.grids.iter().skip(1)) {
            let grids = [&coarse.closed(), &fine.closed()];
            let (from, to) = (rows::part(&*now, 0..grids[0].cells()), &mut *next);
            resample(
                exec,
                grids,
                (Kind::Cells, 1.0),
                from,
                to,
                [&mut *work, &mut *more],
            );
            core::mem::swap(&mut now, &mut next);
        }
        // What was found is in `now`, which may be either.
        let layout = FileLayout::of_cells(finest);
        let found = rows::part_mut(work, 0..layout.len());
        for (found, &x) in found.iter_mut().zip(&*now) {
            *found = if x > T::ZERO { x } else { T::ZERO };
        }
        layout.write(found, T::ONE, self.next);
        Ok(())
    }

    /// The density is that of step 0, but in solid cells.
    fn begin(&mut self) {
        let n = self.levels.finest.n[0];
        self.levels.solids(0).clear_cells(n, self.rho);
        self.look();
        self.step = 0;
    }

    /// Adds the field of the next step to the density.
    fn add_next(&mut self) {
        rows::add(self.rho, self.next);
        self.look();
    }

    /// What transport leaves out is measured by the densest smoke that there was.
    fn look(&mut self) {
        self.largest = self.rho.iter().fold(self.largest, |most, x| most.max(x.to_f64()));
    }

    /// Sets how much the flow matters in each cell, above 0: 1 where it does not.
    ///
    /// # Errors
    /// As [`Self::set_density`]; [`InputError::Index`] where none was planned for, [`InputError::Empty`] where a cell has 0.
    pub fn set_importance(&mut self, importance: &[T]) -> Result<(), InputError> {
        if self.weighted.is_none() {
            return Err(InputError::Index { given: 0, count: 0 });
        }
        check(importance, self.cells())?;
        if importance.contains(&T::ZERO) {
            return Err(InputError::Empty);
        }
        self.importance.copy_from_slice(importance);
        Ok(())
    }

    /// Sets the shape of emitter `index`.
    ///
    /// # Errors
    /// As [`Self::set_density`], or [`InputError::Index`].
    pub fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        check(shape, self.cells())?;
        let cells = self.levels.finest.cells();
        let count = self.lists.spans.len() / 2;
        let field = self.fields.get_mut(index * cells..(index + 1) * cells);
        let field = field.ok_or(InputError::Index { given: index, count })?;
        FileLayout::of_cells(&self.levels.finest).write(shape, T::ONE, field);
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
        FileLayout::new(&grid, axis).take(faces, 1.0 / self.unit, field, [1, 0])
    }

    /// Adds smoke to the density: one number for each cell of the finer grid, x fastest.
    ///
    /// # Errors
    /// As [`Self::set_density`].
    pub fn add(&mut self, smoke: &[T]) -> Result<(), InputError> {
        check(smoke, self.cells())?;
        FileLayout::of_cells(&self.levels.finest).write(smoke, T::ONE, self.next);
        self.add_next();
        Ok(())
    }
}
