//! Self-advection Adv(v) = (curl v) x v with viscosity nu C^T C v (mathematics section 2), the derivative and its adjoint.
//!
//! Adv is energy preserving, <v, Adv(v)> = 0, and quadratic, Adv(v + t d) = Adv(v) + t J(v) d + t^2 Adv(d), exactly. With C v the
//! vorticity at the plaquettes, C^T C is symmetric, and minus the Laplacian of a flow that is free of divergence.

use super::plaquette::{Adjoint, Advection, Derivative, Rule, SCRATCH_ROWS, accumulate};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Block, Vector, VectorMut};
use crate::grid::{Grid, Space};
use crate::real::Real;

/// A fluid in a box, in one slot or more.
#[derive(Clone, Copy, Debug)]
pub struct Fluid<'a> {
    /// The grid.
    pub grid: &'a Grid,
    /// Slots.
    pub slots: usize,
    /// nu in scaled numbers, at least 0.
    pub viscosity: f64,
}

/// Numbers of scratch that one thread needs on `grid`.
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
    for_blocks::<T, S, _, _>(
        exec,
        fluid,
        (
            Advection {
                viscosity: T::from_f64(fluid.viscosity),
            },
            v,
            [&[]; 3],
        ),
        (Start::Zero, out),
        scratch,
        |_, _, _, _| {},
    );
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
    for_blocks::<T, S, _, _>(
        exec,
        fluid,
        (
            Derivative {
                viscosity: T::from_f64(fluid.viscosity),
            },
            v,
            d,
        ),
        (Start::Zero, out),
        scratch,
        |_, _, _, _| {},
    );
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
    for_blocks::<T, S, _, _>(
        exec,
        fluid,
        (
            Adjoint {
                viscosity: T::from_f64(fluid.viscosity),
            },
            v,
            m,
        ),
        (Start::Zero, out),
        scratch,
        |_, _, _, _| {},
    );
}

/// What plaquettes are added to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// 0.
    Zero,
    /// What is there.
    Kept,
}

/// Adds what all plaquettes do by `rule` at v and `second` to `out`, in every slot, and hands every block of a row to `then`.
pub(crate) fn for_blocks<
    T: Real,
    S: Space,
    R: Rule<T> + Sync,
    F: Fn(&Block<'_>, usize, &mut [&mut [T]; 3], &mut [T]) + Sync,
>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    (rule, v, second): (R, Vector<'_, T>, Vector<'_, T>),
    (start, out): (Start, VectorMut<'_, T>),
    scratch: &mut [T],
    then: F,
) {
    let Fluid { grid, slots, .. } = fluid;
    for_rows(
        exec,
        grid.rows(),
        RowBuffers::fields(out).with_scratch(scratch),
        |task| {
            let mut fields = task.fields;
            for block in Block::all(grid, slots) {
                let mut parts = fields.each_mut().map(|field| {
                    if field.is_empty() {
                        &mut [][..]
                    } else {
                        &mut field[block.span_in_row()]
                    }
                });
                if start == Start::Zero {
                    parts.iter_mut().for_each(|part| part.fill(T::ZERO));
                }
                accumulate::<T, S, R>(&block, task.row, rule, v, second, &mut parts, task.scratch);
                then(&block, task.row, &mut parts, task.scratch);
            }
        },
    );
}
