//! Self-advection Adv(v) = (curl v) x v with viscosity nu C^T C v (mathematics section 2), the derivative and its adjoint.
//!
//! Adv preserves energy, <v, Adv(v)> = 0, and is quadratic, Adv(v + t d) = Adv(v) + t J(v) d + t^2 Adv(d), both exactly. C v is the
//! vorticity at the plaquettes; C^T C is symmetric, and minus the Laplacian of a flow without divergence. Where the flow sticks to surfaces, nu C^T C
//! stands for that and what [`super::sticking`] adds.

use super::exits::{self, AtExits};
use super::plaquette::{Adjoint, Advection, Derivative, Rule, SCRATCH_ROWS, accumulate};
use super::sticking;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Block, Vector, VectorMut, borders, reborrow, rows};
use crate::grid::solids::Solids;
use crate::grid::{Grid, Space};
use crate::real::Real;

/// A fluid in a box, in one slot or more.
#[derive(Clone, Copy, Debug)]
pub struct Fluid<'a> {
    /// The grid.
    pub grid: &'a Grid,
    /// Slots.
    pub slots: usize,
    /// nu in box lengths squared a step, at least 0.
    pub viscosity: f64,
    /// The solid cells in it.
    pub solids: Solids<'a>,
}

impl Fluid<'_> {
    /// nu in the precision of the fields.
    pub(crate) fn nu<T: Real>(&self) -> T {
        T::from_f64(self.viscosity)
    }
}

/// The scratch of one thread on `grid`, in elements.
#[must_use]
pub fn scratch_per_thread(grid: &Grid, slots: usize) -> usize {
    SCRATCH_ROWS * Block::largest(grid.n[0], slots)
}

/// `out = Adv(v) + nu C^T C v` in every slot. Shapes: trajectories of faces. Units: velocity squared / length.
pub fn apply<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    v: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let reads = Reads::new(Advection(fluid.nu()), v, [&[]; 3]);
    for_blocks::<T, S, _, _>(exec, fluid, reads, Start::Zero, out, scratch, |_, _, _, _| {});
}

/// `out = J(v) d + nu C^T C d` in every slot.
pub fn apply_derivative<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    v: Vector<'_, T>,
    d: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let reads = Reads::new(Derivative(fluid.nu()), v, d);
    for_blocks::<T, S, _, _>(exec, fluid, reads, Start::Zero, out, scratch, |_, _, _, _| {});
}

/// `out = J(v)^T m + nu C^T C m` in every slot.
pub fn apply_adjoint<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    v: Vector<'_, T>,
    m: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let reads = Reads::new(Adjoint(fluid.nu()), v, m);
    for_blocks::<T, S, _, _>(exec, fluid, reads, Start::Zero, out, scratch, |_, _, _, _| {});
}

/// A rule of the plaquettes and the fields that it reads.
pub(crate) struct Reads<'a, T, R> {
    /// The rule.
    pub rule: R,
    /// The flow v.
    pub v: Vector<'a, T>,
    /// A second field in which the rule is linear, or empty.
    pub second: Vector<'a, T>,
}

impl<'a, T, R> Reads<'a, T, R> {
    /// What `rule` reads.
    pub fn new(rule: R, v: Vector<'a, T>, second: Vector<'a, T>) -> Self {
        Self { rule, v, second }
    }
}

/// What the contributions of plaquettes are added to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// 0.
    Zero,
    /// The values of the output.
    Kept,
}

/// Adds the contributions of all plaquettes to `out` in every slot, and then calls `then` with every block of a row: the block, the
/// row, the block's part of `out` and scratch.
pub(crate) fn for_blocks<
    T: Real,
    S: Space,
    R: Rule<T> + AtExits<T> + Sync,
    F: Fn(&Block<'_>, usize, &mut [&mut [T]; 3], &mut [T]) + Sync,
>(
    exec: &dyn Exec,
    Fluid {
        grid, slots, solids, ..
    }: Fluid<'_>,
    Reads { rule, v, second }: Reads<'_, T, R>,
    start: Start,
    mut out: VectorMut<'_, T>,
    scratch: &mut [T],
    then: F,
) {
    let buffers = RowBuffers::fields(reborrow(&mut out)).with_scratch(scratch);
    for_rows(exec, grid.rows(), buffers, |task| {
        let mut fields = task.fields;
        for block in Block::all(grid, slots) {
            let span = block.span_in_row();
            let mut parts = fields.each_mut().map(|field| rows::part_mut(field, span.clone()));
            if start == Start::Zero {
                parts.iter_mut().for_each(|part| part.fill(T::ZERO));
            }
            let place = (&block, task.row, solids);
            accumulate::<T, S, R>(place, rule, v, second, &mut parts, task.scratch);
            exits::add(place, rule, v, second, &mut parts);
            sticking::add(place, rule, v, second, &mut parts);
            then(&block, task.row, &mut parts, task.scratch);
        }
    });
    borders::refresh_faces(exec, grid, &mut out);
}
