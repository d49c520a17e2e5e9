//! The rows of cells and faces that a flux through faces reads, along any axis.

use crate::field::Vector;
use crate::grid::Grid;
use crate::grid::halo::{BEFORE, HALO, inner, stride};
use crate::grid::stencil::Stencil;
use crate::real::Real;

/// Rows of scratch of a task.
pub const SCRATCH_ROWS: usize = 2;

/// Velocity at faces; the rows of the component along x have halos.
#[derive(Clone, Copy, Debug)]
pub struct Velocity<'a, T>(pub Vector<'a, T>);

impl<'a, T: Real> Velocity<'a, T> {
    /// The low faces of a row of `n` cells.
    #[inline(always)]
    pub fn low(&self, n: usize, axis: usize, row: usize) -> &'a [T] {
        if axis == 0 {
            &self.0[0][row * stride(n) + BEFORE..][..n]
        } else {
            &self.0[axis][row * n..][..n]
        }
    }
}

/// A field of cells.
#[derive(Clone, Copy, Debug)]
pub enum Cells<'a, T> {
    /// Row after row.
    Plain(&'a [T]),
    /// Rows with halos.
    WithHalo(&'a [T]),
}

impl<'a, T> Cells<'a, T> {
    /// The values, the distance between the beginnings of rows of `n`, and where the first of them begins.
    #[inline(always)]
    pub fn layout(self, n: usize) -> (&'a [T], usize, usize) {
        match self {
            Self::Plain(values) => (values, n, 0),
            Self::WithHalo(values) => (values, stride(n), BEFORE),
        }
    }
}

/// The rows of a run and the rows around them, by where they begin: slices that go through memory would be waited for.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, T> {
    /// The rows with their halos, from the first on.
    own: &'a [T],
    /// The distance between their beginnings.
    own_stride: usize,
    /// The fields that hold the rows beside them along y and along z.
    fields: [&'a [T]; 2],
    /// Where the rows beside the first one begin.
    beside: [[usize; 4]; 2],
    /// The distance to those beside the next one.
    stride: usize,
}

impl<'a, T> Rows<'a, T> {
    /// The first `len` values of a row with its halo.
    #[inline(always)]
    pub fn own(&self, row: usize, len: usize) -> &'a [T] {
        let begin = row * self.own_stride;
        &self.own[begin..begin + len]
    }

    /// The `n` values of each of the four rows beside a row along y or z.
    #[inline(always)]
    pub fn along(&self, axis: usize, row: usize, n: usize) -> [&'a [T]; 4] {
        let field = self.fields[axis - 1];
        let [a, b, c, d] = self.beside[axis - 1];
        let further = row * self.stride;
        let of = |begin: usize| &field[begin + further..begin + further + n];
        [of(a), of(b), of(c), of(d)]
    }
}

/// The cells of `field` around a run: at offsets -2 .. 2 along x, at -2, -1, 1, 2 along y and z. Where rows have no halos, that
/// of the run's only row is written to `scratch`.
#[inline(always)]
pub fn cells<'a, T: Real>(
    grid: &Grid,
    stencil: &Stencil,
    field: Cells<'a, T>,
    scratch: &'a mut [T],
) -> Rows<'a, T> {
    let n = grid.n[0];
    let (values, stride, before) = field.layout(n);
    let own = match field {
        Cells::Plain(_) => {
            inner(scratch, n).copy_from_slice(&values[stencil.row * n..][..n]);
            grid.axis(0).surround_cells(scratch);
            &scratch[..n + HALO]
        }
        Cells::WithHalo(_) => &values[stencil.row * stride..],
    };
    Rows {
        own,
        own_stride: stride,
        fields: [values; 2],
        beside: begins(&stencil.cells, stride, before),
        stride,
    }
}

/// The faces -1, 0, 1, 2 around a run: face 0 is the low one of its cells, face 1 the high one.
#[inline(always)]
pub fn faces<'a, T: Real>(grid: &Grid, stencil: &Stencil, v: Velocity<'a, T>) -> Rows<'a, T> {
    let n = grid.n[0];
    let Velocity([x, y, z]) = v;
    Rows {
        own: &x[stencil.row * stride(n) + 1..],
        own_stride: stride(n),
        fields: [y, z],
        beside: begins(&stencil.faces, n, 0),
        stride: n,
    }
}

/// Where rows of a field begin.
#[inline(always)]
fn begins([y, z]: &[[usize; 4]; 2], stride: usize, before: usize) -> [[usize; 4]; 2] {
    let begin = |row: usize| row * stride + before;
    [
        [begin(y[0]), begin(y[1]), begin(y[2]), begin(y[3])],
        [begin(z[0]), begin(z[1]), begin(z[2]), begin(z[3])],
    ]
}
