//! The residual f of the Navier-Stokes problem (paper eq. 13, mathematics section 5): right-hand side minus
//! left-hand side.
//!
//! ```text
//! a:  kappa v_k - w_{k+1} + (1 + J(v_k)^T + nu C^T C) w_k + grad pbar_k = ra_k      at faces
//! b:  div v_k = rb_k                                                                 at cells
//! c:  v_k - v_{k-1} + Adv(v_k) + nu C^T C v_k - w_k + grad p_k = rc_k                at faces
//! d:  div w_k = rd_k                                                                 at cells
//! ```

use super::level::{Coefficients, LevelMut, System};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Block, Vector, rows, subtract_next, subtract_previous, sums};
use crate::grid::solids::closed;
use crate::grid::{Grid, Space};
use crate::operators::divergence::{add_divergence, add_gradient};
use crate::operators::plaquette::{self, Adjoint, Advection, accumulate};
use crate::real::Real;

/// Rows of scratch that [`of_block`] needs.
const WORK_ROWS: usize = plaquette::SCRATCH_ROWS;

/// The residual of one row of a block.
pub struct Rows<'a, T> {
    /// Equation a, by component.
    pub a: [&'a mut [T]; 3],
    /// Equation b.
    pub b: &'a mut [T],
    /// Equation c, by component.
    pub c: [&'a mut [T]; 3],
    /// Equation d.
    pub d: &'a mut [T],
}

/// Rows of a [`Rows`].
#[must_use]
pub const fn rows_of<S: Space>() -> usize {
    2 * (1 + S::DIM)
}

/// Which places of [`Rows::list`] have a row: those of z have none in 2D.
fn used<S: Space>() -> impl Iterator<Item = usize> {
    (0..8).filter(|&index| index % 3 < S::DIM || index > 5)
}

impl<'a, T: Real> Rows<'a, T> {
    /// From [`rows_of`] rows of `len` values each: equation a, then c, by component, b and d.
    pub fn new<S: Space>(len: usize, values: &'a mut [T]) -> Self {
        debug_assert!(values.len() >= rows_of::<S>() * len);
        let mut list: [&mut [T]; 8] = Default::default();
        for (index, part) in used::<S>().zip(values.chunks_exact_mut(len)) {
            list[index] = part;
        }
        let [a0, a1, a2, c0, c1, c2, b, d] = list;
        Self {
            a: [a0, a1, a2],
            b,
            c: [c0, c1, c2],
            d,
        }
    }

    /// The residuals that [`Self::new`] laid out in `values`, in the order of [`Self::list`].
    pub fn written<S: Space>(len: usize, values: &'a [T]) -> [&'a [T]; 8] {
        debug_assert!(values.len() >= rows_of::<S>() * len);
        let mut list: [&[T]; 8] = Default::default();
        for (index, part) in used::<S>().zip(values.chunks_exact(len)) {
            list[index] = part;
        }
        list
    }

    /// Equations a, c (by component), b, d.
    pub fn list(&mut self) -> [&mut [T]; 8] {
        let [a0, a1, a2] = self.a.each_mut().map(|c| &mut **c);
        let [c0, c1, c2] = self.c.each_mut().map(|c| &mut **c);
        [a0, a1, a2, c0, c1, c2, self.b, self.d]
    }
}

/// Values of scratch that a thread needs for [`norm`].
#[must_use]
pub fn norm_scratch<S: Space>(grid: &Grid, slots: usize) -> usize {
    (rows_of::<S>() + WORK_ROWS) * Block::largest(grid.n[0], slots)
}

/// Values of scratch that [`of_block`] needs for a block.
#[must_use]
pub fn work_len(block: &Block<'_>) -> usize {
    WORK_ROWS * block.len()
}

/// `out` = residual of `row` in the slots of `block`.
pub fn of_block<T: Real, S: Space>(
    system: &System<'_, T>,
    block: &Block<'_>,
    row: usize,
    out: &mut Rows<'_, T>,
    work: &mut [T],
) {
    let minus = -T::ONE;
    // Left-hand sides of the nonlinear parts first, with their sign turned at once.
    out.list().into_iter().for_each(|row| row.fill(T::ZERO));
    accumulate::<T, S, _>(
        (block, row, system.solids),
        Adjoint(system.viscosity),
        system.v,
        system.w,
        &mut out.a.each_mut().map(|c| &mut **c),
        work,
    );
    accumulate::<T, S, _>(
        (block, row, system.solids),
        Advection(system.viscosity),
        system.v,
        [&[]; 3],
        &mut out.c.each_mut().map(|c| &mut **c),
        work,
    );
    for axis in 0..S::DIM {
        let (v, w) = (block.of(system.v[axis], row), block.of(system.w[axis], row));
        let a = &mut *out.a[axis];
        add_gradient(block, row, axis, T::ONE, system.pbar, a, &mut work[..block.len()]);
        rows::add_scaled(a, system.kappa, v);
        rows::add(a, w);
        subtract_next(block, row, system.w[axis], a);
        rows::scale_in_place(a, minus);
        rows::add_scaled(a, system.rhs.scale, target(system.rhs.a, axis, block, row));
        let c = &mut *out.c[axis];
        add_gradient(block, row, axis, T::ONE, system.p, c, &mut work[..block.len()]);
        rows::add(c, v);
        rows::sub(c, w);
        subtract_previous(block, row, system.v[axis], system.v0[axis], c);
        rows::scale_in_place(c, minus);
        rows::add(c, target(system.rhs.c, axis, block, row));
        for equation in [a, c] {
            block.clear_closed(axis, row, equation);
            if system.solids.there() {
                system.solids.clear(block.grid.n[0], row, closed(axis), equation);
            }
        }
    }
    for (equation, field, rhs) in [
        (&mut *out.b, system.v, system.rhs.b),
        (&mut *out.d, system.w, system.rhs.d),
    ] {
        add_divergence(block, row, minus, field, equation, &mut work[..block.len()]);
        if !rhs.is_empty() {
            rows::add(equation, block.of(rhs, row));
        }
    }
}

/// A row of a right-hand side, empty where all of it is 0.
fn target<'a, T>(rhs: Vector<'a, T>, axis: usize, block: &Block<'_>, row: usize) -> &'a [T] {
    if rhs[axis].is_empty() {
        &[]
    } else {
        block.of(rhs[axis], row)
    }
}

/// max |f| over all equations, cells and slots, b and d counted times `unit` (h / dt: then all are
/// accelerations).
///
/// NaN when any value is not finite. `of_rows` holds one value a row, `scratch` [`norm_scratch`] a thread.
pub fn norm<T: Real, S: Space>(
    exec: &dyn Exec,
    level: &LevelMut<'_, T>,
    coefficients: &Coefficients<T>,
    unit: f64,
    of_rows: &mut [f64],
    scratch: &mut [T],
) -> f64 {
    let grid = level.grid;
    let system = level.system(coefficients);
    let of_rows = &mut of_rows[..grid.rows()];
    for_rows(
        exec,
        grid.rows(),
        RowBuffers::sums(&mut *of_rows).with_scratch(scratch),
        |task| {
            let blocks = Block::all(grid, coefficients.slots);
            let of = |block| largest_in_block::<T, S>(&system, &block, task.row, unit, task.scratch);
            task.sums[0] = rows::largest(blocks.map(of));
        },
    );
    sums::most(exec, grid, of_rows.iter().copied())
}

/// [`norm`] in a row of a block.
fn largest_in_block<T: Real, S: Space>(
    system: &System<'_, T>,
    block: &Block<'_>,
    row: usize,
    unit: f64,
    scratch: &mut [T],
) -> f64 {
    let (values, work) = scratch.split_at_mut(rows_of::<S>() * block.len());
    let mut out = Rows::new::<S>(block.len(), values);
    of_block::<T, S>(system, block, row, &mut out, work);
    let maxima = out.list().map(|row| rows::max_abs(row));
    let (momentum, divergence) = maxima.split_at(6);
    rows::largest(
        momentum
            .iter()
            .copied()
            .chain(divergence.iter().map(|m| m * unit)),
    )
}
