//! Where the outputs of a solution lie in its block, and NumPy's arrays over them.

use crate::block::Block;
use core::slice;
use numpy::ndarray::{ArrayView, IxDyn, ShapeBuilder};
use numpy::{Element, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use std::sync::OnceLock;
use thurible_core::grid::Side;
use thurible_core::memory::{Arena, footprint};
use thurible_core::solver::Strided;
use thurible_core::{Boundary, Exec, Output, Real, Solver, Space};

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
    /// One step of a component in a block that begins at address `start`.
    fn step<T: Real>(start: usize, step: &Strided<'_, T>, dims: usize) -> Self {
        let along = |first: usize, axes: [usize; 3]| {
            let reversed = axes.into_iter().take(dims).rev();
            [first].into_iter().chain(reversed).collect::<Vec<_>>()
        };
        Self {
            offset: step.numbers.as_ptr().addr() - start,
            shape: along(1, step.extent),
            strides: along(step.extent[0], step.strides),
            unit: step.unit,
        }
    }

    /// Takes `next`, one step, as its own next step, if that lies as far from its last as each of its steps from the one before.
    fn takes<T: Real>(&mut self, next: &Self) -> bool {
        let (count, own) = (self.shape[0], self.strides[0]);
        let numbers = next.offset.saturating_sub(self.offset) / T::BYTES;
        let apart = if count == 1 { numbers } else { own };
        let evenly = apart > 0 && numbers == count * apart;
        let alike = self.strides[1..] == next.strides[1..] && self.unit == next.unit;
        if evenly && alike {
            (self.shape[0], self.strides[0]) = (count + 1, apart);
        }
        evenly && alike
    }

    /// All but the first `count` steps.
    fn without<T: Real>(&self, count: usize) -> Self {
        let mut rest = self.clone();
        let count = count.min(rest.shape[0] - 1);
        rest.shape[0] -= count;
        rest.offset += count * rest.strides[0] * T::BYTES;
        rest
    }

    /// A whole block with the numbers of `shape`, one after the other.
    fn dense(shape: Vec<usize>) -> Self {
        Self {
            offset: 0,
            strides: dense(&shape),
            shape,
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

/// Strides of an array whose numbers lie one after the other.
fn dense(shape: &[usize]) -> Vec<usize> {
    let mut strides = vec![1; shape.len()];
    for axis in (1..shape.len()).rev() {
        strides[axis - 1] = strides[axis] * shape[axis];
    }
    strides
}

/// A component of an output.
pub struct Component {
    /// Its steps, as many together as lie evenly apart: a given v_0 lies elsewhere than the velocities that were found.
    runs: Vec<Place>,
    /// How many of its first steps are given.
    given: usize,
    /// The axis of the array along which walls add a face.
    wall: Option<usize>,
    /// The component as files have it, once somebody asked for it and it does not lie so.
    file: OnceLock<(Block, Place)>,
}

impl Component {
    /// The component as files have it, in the scene's units, with the faces on walls, and the block where that is: `block` itself, or
    /// one that is made the first time. `None` if the system has not the memory.
    pub fn filed<'a, T: Number>(&'a self, block: &'a Block) -> Option<(&'a Block, &'a Place)> {
        if let ([all], None) = (self.runs.as_slice(), self.wall)
            && all.unit == 1.0
            && all.strides == dense(&all.shape)
        {
            return Some((block, all));
        }
        let (file, place) = match self.file.get() {
            Some(file) => file,
            None => {
                let file = self.file::<T>(block)?;
                self.file.get_or_init(|| file)
            }
        };
        Some((file, place))
    }

    fn file<T: Number>(&self, block: &Block) -> Option<(Block, Place)> {
        let mut shape = self.runs.first()?.shape.clone();
        shape[0] = self.runs.iter().map(|run| run.shape[0]).sum();
        if let Some(axis) = self.wall {
            shape[axis] += 1;
        }
        let count = shape.iter().product::<usize>();
        let place = Place::dense(shape);
        let mut file = Block::new(footprint(count, T::BYTES)?)?;
        let mut rest = Arena::new(file.bytes_mut()).take::<T>("array", count).ok()?;
        for run in &self.runs {
            let (part, after) = rest.split_at_mut(run.shape[0] * place.strides[0]);
            run.scatter::<T>(block, &place.strides, part);
            rest = after;
        }
        Some((file, place))
    }

    /// What was found of it, as it lies in the block; in units of [`Self::unit`].
    pub fn in_place<T: Number>(&self) -> Option<Place> {
        let (last, before) = self.runs.split_last()?;
        let before: usize = before.iter().map(|run| run.shape[0]).sum();
        Some(last.without::<T>(self.given.saturating_sub(before)))
    }

    /// The scene's unit of the numbers in the block.
    pub fn unit(&self) -> f64 {
        self.runs.first().map_or(1.0, |run| run.unit)
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

/// What emitters added after each step, as files have it, in a block of its own; `shape` is that of a density. `None` if the system has
/// not the memory.
pub fn emission<T: Number, S: Space>(
    solver: &mut Solver<'_, T, S>,
    shape: &[usize],
    exec: &dyn Exec,
) -> Option<(Block, Place)> {
    made(solver.steps(), shape, |step, added| {
        solver.emission(exec, step, added)
    })
}

/// What emitters with a velocity added beside each force along `axis`, as [`emission`]; `shape` is that of such a force.
pub fn jets<T: Number, S: Space>(
    solver: &Solver<'_, T, S>,
    shape: &[usize],
    axis: usize,
) -> Option<(Block, Place)> {
    made(solver.steps() - 1, shape, |step, added| {
        solver.jet(step, axis, added)
    })
}

/// An array of `count` fields of this shape, each as `make` writes it.
fn made<T: Number>(
    count: usize,
    shape: &[usize],
    mut make: impl FnMut(usize, &mut [T]),
) -> Option<(Block, Place)> {
    let len = shape.iter().product::<usize>();
    let mut block = Block::new(footprint(count.checked_mul(len)?, T::BYTES)?)?;
    let fields = Arena::new(block.bytes_mut())
        .take::<T>("array", count * len)
        .ok()?;
    let fields = fields.chunks_exact_mut(len).enumerate();
    fields.for_each(|(step, field)| make(step, field));
    let shape = [count].into_iter().chain(shape.iter().copied());
    Some((block, Place::dense(shape.collect())))
}

/// Where an output lies in the block of a solver.
pub struct Field {
    /// What it is.
    pub output: Output,
    /// Its components: one, or those along x, y (and z).
    pub components: Vec<Component>,
}

/// All outputs of `solver`, which lives in a block that begins at address `start`; `boundary` says how each axis ends.
pub fn fields<T: Real, S: Space>(
    solver: &Solver<'_, T, S>,
    start: usize,
    boundary: &[Boundary],
) -> Vec<Field> {
    let dims = boundary.len();
    let component = |output: &Output, axis: usize| {
        let mut runs: Vec<Place> = Vec::new();
        for step in 0..output.count(solver.steps()) {
            let next = Place::step(start, &solver.in_place(output, step, axis), dims);
            if !runs.last_mut().is_some_and(|run| run.takes::<T>(&next)) {
                runs.push(next);
            }
        }
        let ends = boundary[axis];
        let stored = ends == Boundary::Periodic || ends.opens(Side::High);
        let walls = output.place == thurible_core::Place::Faces && !stored;
        Component {
            runs,
            given: output.given,
            wall: walls.then_some(dims - axis),
            file: OnceLock::new(),
        }
    };
    let field = |&output: &Output| Field {
        output,
        components: (0..output.components(dims))
            .map(|axis| component(&output, axis))
            .collect(),
    };
    solver.outputs().iter().map(field).collect()
}
