//! What an operator is given at a step, and what it shows there: a density at cells and a vector field at faces, without copies.

use crate::field::{Vector, VectorMut, rows};
use crate::grid::Grid;
use crate::real::Real;
use crate::solver::{FileLayout, InputError, Strided, finite};
use crate::stable_fluids::cells::Cells;

/// Where the numbers of a step live, and how they lie.
#[derive(Clone, Copy, Debug)]
pub(super) enum Places<'a> {
    /// Densities at cells, components at the faces across their axis.
    Faces(&'a Grid),
    /// All at the centres of cells, with a layer of ghosts.
    Padded(&'a Cells),
    /// All at the centres of cells, without ghosts.
    Plain(&'a Cells),
}

impl Places<'_> {
    fn dims(&self) -> usize {
        match self {
            Self::Faces(grid) => grid.dims,
            Self::Padded(cells) | Self::Plain(cells) => cells.dims,
        }
    }

    /// Adds a field of cells, or component `axis`, that has the right length and finite numbers.
    fn add<T: Real>(
        self,
        axis: Option<usize>,
        given: &[T],
        unit: f64,
        field: &mut [T],
    ) -> Result<(), InputError> {
        match self {
            Self::Faces(grid) => {
                let layout =
                    axis.map_or_else(|| FileLayout::of_cells(grid), |axis| FileLayout::new(grid, axis));
                layout.add(given, unit, field)?;
            }
            Self::Padded(cells) => {
                finite(given, cells.count())?;
                cells.add(given, unit, field);
            }
            Self::Plain(cells) => {
                finite(given, cells.count())?;
                rows::add_scaled(rows::part_mut(field, 0..given.len()), T::from_f64(unit), given);
            }
        }
        Ok(())
    }

    /// Copies a field of cells, or component `axis`, times `unit`.
    fn read<T: Real>(self, axis: Option<usize>, field: &[T], unit: f64, out: &mut [T]) {
        match self {
            Self::Faces(grid) => {
                let layout =
                    axis.map_or_else(|| FileLayout::of_cells(grid), |axis| FileLayout::new(grid, axis));
                layout.read(field, [1, 0], T::from_f64(unit), out);
            }
            Self::Padded(cells) => {
                cells.pack(field, out);
                rows::scale_in_place(out, T::from_f64(unit));
            }
            Self::Plain(_) => rows::scale(out, T::from_f64(unit), rows::part(field, 0..out.len())),
        }
    }

    /// A field of cells, or component `axis`, as it lies in memory.
    fn lies<'f, T>(self, axis: Option<usize>, field: &'f [T], unit: f64) -> Strided<'f, T> {
        let centers = |cells: &Cells, first: usize, strides: [usize; 3]| Strided {
            numbers: field.get(first..).unwrap_or(&[]),
            extent: cells.n,
            strides,
            unit,
        };
        match self {
            Self::Faces(grid) => Strided::slot(grid, field, [1, 0], unit, axis),
            Self::Padded(cells) => centers(cells, cells.row(0).start, cells.stride),
            Self::Plain(cells) => centers(cells, 0, [1, cells.n[0], cells.n[0] * cells.n[1]]),
        }
    }
}

/// Where a caller adds what it has for a step: a force, or covectors of density and velocity. What it does not add is 0.
pub struct Given<'a, T> {
    pub(super) places: Places<'a>,
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
            self.places.add(None, cells, 1.0, self.density)
        };
        self.keep(done);
    }

    /// Adds component `axis`, in the scene's units and the layout of a file: one more face than cells along an axis between walls, of Stable
    /// Fluids one number a cell. What it has on walls counts for nothing.
    pub fn vector(&mut self, axis: usize, faces: &[T]) {
        let count = self.places.dims();
        let done = match self.vector.get_mut(axis) {
            Some(field) if axis < count => self.places.add(Some(axis), faces, self.unit, field),
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
    pub(super) places: Places<'a>,
    pub(super) density: &'a [T],
    pub(super) vector: Vector<'a, T>,
    /// What the vector field is in the scene's units where it is 1.
    pub(super) unit: f64,
}

impl<'a, T: Real> View<'a, T> {
    /// The field of cells as it lies in memory.
    #[must_use]
    pub fn density(&self) -> Strided<'a, T> {
        self.places.lies(None, self.density, 1.0)
    }

    /// A component as it lies in memory.
    #[must_use]
    pub fn vector(&self, axis: usize) -> Strided<'a, T> {
        let field = self.vector.get(axis).copied().unwrap_or_default();
        self.places.lies(Some(axis), field, self.unit)
    }

    /// Copies the field of cells, x fastest.
    pub fn read_density(&self, out: &mut [T]) {
        self.places.read(None, self.density, 1.0, out);
    }

    /// Copies component `axis`, in the scene's units and the layout of a file.
    pub fn read_vector(&self, axis: usize, out: &mut [T]) {
        let field = self.vector.get(axis).copied().unwrap_or_default();
        self.places.read(Some(axis), field, self.unit, out);
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
