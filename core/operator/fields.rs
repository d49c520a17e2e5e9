//! What an operator is given at a step, and what it shows there: a density at cells and a vector field at faces, without copies.

use crate::field::{Vector, VectorMut};
use crate::grid::Grid;
use crate::real::Real;
use crate::solver::{FileLayout, InputError, Strided};

/// Where a caller adds what it has for a step: a force, or covectors of density and velocity. What it does not add is 0.
pub struct Given<'a, T> {
    pub(super) grid: &'a Grid,
    /// Empty where no density is asked for.
    pub(super) density: &'a mut [T],
    pub(super) vector: VectorMut<'a, T>,
    /// What the vector field is multiplied by.
    pub(super) unit: f64,
    /// The first that was refused.
    pub(super) refused: Option<InputError>,
}

impl<T: Real> Given<'_, T> {
    /// Adds a field of cells, x fastest.
    pub fn density(&mut self, cells: &[T]) {
        let done = if self.density.is_empty() {
            Err(InputError::Index { given: 0, count: 0 })
        } else {
            FileLayout::of_cells(self.grid).add(cells, 1.0, self.density)
        };
        self.keep(done);
    }

    /// Adds component `axis`, in the scene's units and the layout of a file: one more face than cells along an axis between walls. What it
    /// has on walls counts for nothing.
    pub fn vector(&mut self, axis: usize, faces: &[T]) {
        let count = self.grid.dims;
        let done = match self.vector.get_mut(axis) {
            Some(field) if axis < count => FileLayout::new(self.grid, axis).add(faces, self.unit, field),
            _ => Err(InputError::Index { given: axis, count }),
        };
        self.keep(done);
    }

    fn keep(&mut self, done: Result<(), InputError>) {
        self.refused = self.refused.or(done.err());
    }
}

/// A density and a vector field of a step, borrowed: rho_k and v_k, or gradients. Of a force's gradient the density is empty.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, T> {
    pub(super) grid: &'a Grid,
    pub(super) density: &'a [T],
    pub(super) vector: Vector<'a, T>,
    /// What the vector field is in the scene's units where it is 1.
    pub(super) unit: f64,
}

impl<'a, T: Real> View<'a, T> {
    /// The field of cells as it lies in memory.
    #[must_use]
    pub fn density(&self) -> Strided<'a, T> {
        Strided::slot(self.grid, self.density, [1, 0], 1.0, None)
    }

    /// A component as it lies in memory.
    #[must_use]
    pub fn vector(&self, axis: usize) -> Strided<'a, T> {
        let field = self.vector.get(axis).copied().unwrap_or_default();
        Strided::slot(self.grid, field, [1, 0], self.unit, Some(axis))
    }

    /// Copies the field of cells, x fastest.
    pub fn read_density(&self, out: &mut [T]) {
        FileLayout::of_cells(self.grid).read(self.density, [1, 0], T::ONE, out);
    }

    /// Copies component `axis`, in the scene's units and the layout of a file.
    pub fn read_vector(&self, axis: usize, out: &mut [T]) {
        let field = self.vector.get(axis).copied().unwrap_or_default();
        FileLayout::new(self.grid, axis).read(field, [1, 0], T::from_f64(self.unit), out);
    }
}

/// Asked for what there is of a step.
pub type Ask<'a, T> = dyn FnMut(usize, &mut Given<'_, T>) + 'a;
/// Shown what there is of a step.
pub type Show<'a, T> = dyn FnMut(usize, &View<'_, T>) + 'a;

/// Where a simulation begins.
#[derive(Clone, Copy, Debug)]
pub struct Start<'a, T> {
    /// rho_0, x fastest; it may be 0 everywhere, and negative.
    pub density: &'a [T],
    /// The components of v_0, in the scene's units and the layout of a file; one that is empty is 0. It is projected.
    pub velocity: Vector<'a, T>,
}
