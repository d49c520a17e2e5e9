//! What an operator is given at a step, and what it shows there: a density at cells and a vector field at faces, without copies.

use super::error::{Input, OperatorError};
use crate::field::{Vector, VectorMut, rows};
use crate::grid::Grid;
use crate::real::Real;
use crate::solver::{FileLayout, InputError, Strided, finite};
use crate::stable_fluids::cells::Cells;

/// Where what is given for a step is added, and how that lies.
#[derive(Clone, Copy, Debug)]
pub(super) enum Room<'a> {
    /// Densities at cells, components at the faces across their axis.
    Faces(&'a Grid),
    /// All at the centres of cells, with a layer of ghosts.
    Padded(&'a Cells),
    /// All at the centres of cells, without ghosts.
    Plain(&'a Cells),
}

impl Room<'_> {
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
                FileLayout::of(grid, axis).add(given, unit, field)?;
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
}

/// Where what is shown of a step lies, and how.
#[derive(Clone, Copy, Debug)]
pub(super) enum Places<'a> {
    /// Densities at cells, components at the faces across their axis.
    Faces(&'a Grid),
    /// All at the centres of cells, with a layer of ghosts.
    Padded(&'a Cells),
}

impl Places<'_> {
    /// Copies a field of cells, or component `axis`, times `unit`.
    fn read<T: Real>(self, axis: Option<usize>, field: &[T], unit: f64, out: &mut [T]) {
        match self {
            Self::Faces(grid) => {
                FileLayout::of(grid, axis).read(field, [1, 0], T::from_f64(unit), out);
            }
            Self::Padded(cells) => {
                cells.pack(field, out);
                rows::scale_in_place(out, T::from_f64(unit));
            }
        }
    }

    /// A field of cells, or component `axis`, as it lies in memory.
    fn lies<'f, T>(self, axis: Option<usize>, field: &'f [T], unit: f64) -> Strided<'f, T> {
        match self {
            Self::Faces(grid) => Strided::slot(grid, field, [1, 0], unit, axis),
            Self::Padded(cells) => Strided {
                numbers: field.get(cells.row(0).start..).unwrap_or(&[]),
                extent: cells.n,
                strides: cells.stride,
                unit,
            },
        }
    }
}

/// Where a caller adds what it has for a step: a force, or covectors of density and velocity. What it does not add is 0.
pub struct Given<'a, T> {
    room: Room<'a>,
    /// Empty where no density is asked for.
    density: &'a mut [T],
    vector: VectorMut<'a, T>,
    /// What the vector field is multiplied by.
    unit: f64,
    /// The first that was refused.
    refused: Option<InputError>,
}

impl<'a, T: Real> Given<'a, T> {
    /// Room for a density, which is empty where none is asked for, and for a vector field that is multiplied by `unit`.
    pub(super) fn new(room: Room<'a>, density: &'a mut [T], vector: VectorMut<'a, T>, unit: f64) -> Self {
        Self {
            room,
            density,
            vector,
            unit,
            refused: None,
        }
    }

    /// Asks for `what` of a step.
    pub(super) fn ask(mut self, ask: &mut Ask<'_, T>, step: usize, what: Input) -> Result<(), OperatorError> {
        ask(step, &mut self);
        self.refused.map_or(Ok(()), |error| Err(what.refused()(error)))
    }

    /// Adds a field of cells, x fastest.
    pub fn density(&mut self, cells: &[T]) {
        let done = if self.density.is_empty() {
            Err(InputError::Index { given: 0, count: 0 })
        } else {
            self.room.add(None, cells, 1.0, self.density)
        };
        self.keep(done);
    }

    /// Adds component `axis`, in the scene's units and the layout of a file: one more face than cells along an axis between walls, of Stable
    /// Fluids one number a cell. What it has on walls counts for nothing.
    pub fn vector(&mut self, axis: usize, faces: &[T]) {
        let count = self.room.dims();
        let done = match self.vector.get_mut(axis) {
            Some(field) if axis < count => self.room.add(Some(axis), faces, self.unit, field),
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
