//! Where the fields of a solution lie in its block, and NumPy's arrays over them.

use crate::block::Block;
use core::slice;
use numpy::ndarray::{ArrayView, IxDyn, ShapeBuilder};
use numpy::{Element, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use thurible_core::memory::{Arena, footprint};
use thurible_core::output::{DENSITY, FORCE, VELOCITY};
use thurible_core::solver::Strided;
use thurible_core::{Real, Solver, Space};

/// A number of the core that NumPy knows too.
pub trait Number: Real + Element {}

impl Number for f32 {}
impl Number for f64 {}

/// An array in a block; all its bytes have been written.
#[derive(Clone, Debug)]
pub struct Place {
    offset: usize,
    /// From the slowest axis to the fastest, as NumPy has it.
    shape: Vec<usize>,
    /// Numbers from one to the next along each axis.
    strides: Vec<usize>,
    /// The scene's unit of the numbers.
    pub unit: f64,
}

impl Place {
    /// `count` fields from `first` on, `apart` numbers from one to the next, in a block that begins at address `start`.
    fn series<T: Real>(
        start: usize,
        first: &Strided<'_, T>,
        count: usize,
        apart: usize,
        dims: usize,
    ) -> Self {
        let reversed = |axes: [usize; 3]| axes.into_iter().take(dims).rev();
        let shape = [count].into_iter().chain(reversed(first.extent)).collect();
        let strides = [apart].into_iter().chain(reversed(first.strides)).collect();
        Self {
            offset: first.numbers.as_ptr().addr() - start,
            shape,
            strides,
            unit: first.unit,
        }
    }

    /// A whole block with the numbers of `shape`, one after the other.
    fn dense(shape: Vec<usize>) -> Self {
        let mut strides = vec![1; shape.len()];
        for axis in (1..shape.len()).rev() {
            strides[axis - 1] = strides[axis] * shape[axis];
        }
        Self {
            offset: 0,
            shape,
            strides,
            unit: 1.0,
        }
    }

    /// Numbers from the first to the last.
    fn span(&self) -> usize {
        1 + self
            .shape
            .iter()
            .zip(&self.strides)
            .map(|(count, stride)| (count - 1) * stride)
            .sum::<usize>()
    }

    /// The numbers from the first to the last, those of other fields between them included.
    fn numbers<'b, T: Real>(&self, block: &'b Block) -> &'b [T] {
        let (count, start) = (self.span(), block.start(self.offset, self.span()));
        // SAFETY: `start` checks bounds and alignment; the bytes are initialised, since the core zeroes every buffer that it carves and
        // files are filled when they are made; nobody writes to a block that can be shared.
        unsafe { slice::from_raw_parts(start, count) }
    }

    /// An array that borrows `block`, which `owner` keeps alive, and that cannot be written to.
    pub fn array<'py, T: Number>(
        &self,
        block: &Block,
        owner: &Bound<'py, PyAny>,
    ) -> Bound<'py, PyArrayDyn<T>> {
        let shape = IxDyn(&self.shape).strides(IxDyn(&self.strides));
        let start = self.numbers::<T>(block).as_ptr();
        // SAFETY: `numbers` has the whole span of the shape; strides are those of fields that do not overlap.
        let view = unsafe { ArrayView::from_shape_ptr(shape, start) };
        // SAFETY: `owner` is a frozen solution that owns the block, so the numbers live and do not move as long as it does.
        let array = unsafe { PyArrayDyn::borrow_from_array(&view, owner.clone()) };
        drop(array.readwrite().make_nonwriteable());
        array
    }
}

/// A component of a velocity or force.
#[derive(Clone, Debug)]
pub struct Component {
    /// v_0, which lies apart from the others; a force has none.
    first: Option<Place>,
    /// All entries but v_0.
    pub rest: Place,
    /// The axis of the array along which walls add a face.
    wall: Option<usize>,
}

impl Component {
    /// The component as files have it, in the scene's units, with the faces on walls; `None` if the system has not the memory.
    pub fn filed<T: Number>(&self, block: &Block) -> Option<(Block, Place)> {
        let mut shape = self.rest.shape.clone();
        shape[0] += usize::from(self.first.is_some());
        if let Some(axis) = self.wall {
            shape[axis] += 1;
        }
        let count = shape.iter().product::<usize>();
        let place = Place::dense(shape);
        let mut file = Block::new(footprint(count, T::BYTES)?)?;
        let numbers = Arena::new(file.bytes_mut()).take::<T>("array", count).ok()?;
        let (first, rest) = numbers.split_at_mut(self.first.iter().len() * place.strides[0]);
        if let Some(part) = &self.first {
            part.scatter::<T>(block, &place.strides, first);
        }
        self.rest.scatter::<T>(block, &place.strides, rest);
        Some((file, place))
    }
}

impl Place {
    /// Writes every number in the scene's units to its place in `out`, an array with `strides`.
    fn scatter<T: Number>(&self, block: &Block, strides: &[usize], out: &mut [T]) {
        let (numbers, unit) = (self.numbers::<T>(block), T::from_f64(self.unit));
        let row = self.shape.last().copied().unwrap_or(0);
        let rows: usize = self.shape.iter().rev().skip(1).product();
        for index in 0..rows {
            let (mut rest, mut from, mut to) = (index, 0, 0);
            for axis in (0..self.shape.len() - 1).rev() {
                let along = rest % self.shape[axis];
                rest /= self.shape[axis];
                (from, to) = (from + along * self.strides[axis], to + along * strides[axis]);
            }
            out[to..to + row]
                .iter_mut()
                .zip(&numbers[from..from + row])
                .for_each(|(out, &number)| *out = number * unit);
        }
    }
}

/// Where everything lies in the block of a solver.
#[derive(Clone, Debug)]
pub struct Places {
    /// rho_0 .. rho_N.
    pub density: Place,
    /// Velocities along x, y (and z).
    pub velocity: Vec<Component>,
    /// Forces along x, y (and z).
    pub force: Vec<Component>,
}

impl Places {
    /// The places of `solver`, which lives in `block`.
    pub fn of<T: Real, S: Space>(solver: &Solver<'_, T, S>, start: usize, sizes: &Sizes<'_>) -> Self {
        let Sizes { steps, periodic } = *sizes;
        let dims = periodic.len();
        let series = |first: &Strided<'_, T>, count, apart| Place::series(start, first, count, apart, dims);
        let density = solver.in_place(&DENSITY, 0, 0);
        let cells = solver.density(0).len();
        let component = |axis: usize, first: Option<Strided<'_, T>>, rest: Strided<'_, T>| Component {
            first: first.map(|first| series(&first, 1, 1)),
            rest: series(&rest, steps - 1, rest.extent[0]),
            wall: (!periodic[axis]).then_some(dims - axis),
        };
        let velocity = |axis| {
            component(
                axis,
                Some(solver.in_place(&VELOCITY, 0, axis)),
                solver.in_place(&VELOCITY, 1, axis),
            )
        };
        let force = |axis| component(axis, None, solver.in_place(&FORCE, 0, axis));
        Self {
            density: series(&density, steps + 1, cells),
            velocity: (0..dims).map(velocity).collect(),
            force: (0..dims).map(force).collect(),
        }
    }
}

/// What a solver does not tell of its problem.
#[derive(Clone, Copy, Debug)]
pub struct Sizes<'a> {
    /// N.
    pub steps: usize,
    /// Whether each axis wraps around.
    pub periodic: &'a [bool],
}
