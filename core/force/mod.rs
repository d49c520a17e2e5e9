//! The force that produces a given flow (mathematics section 6), its derivative, the adjoint of that, and the
//! second derivative of its square.
//!
//! ```text
//! w_k = v_k - v_{k-1} + Adv(v_k) + nu C^T C v_k + grad p_k
//! ```
//!
//! J(v) below is the derivative of Adv(v) + nu C^T C v.

pub mod lift;
pub mod mask;
pub mod price;
pub mod template;
pub mod time_line;

pub use crate::operators::self_advection::scratch_per_thread;

use crate::exec::Exec;
use crate::field::{Vector, VectorMut, rows, subtract_next, subtract_previous};
use crate::grid::Space;
use crate::operators::divergence::add_gradient;
use crate::operators::plaquette::{Adjoint, Advection, Bend, Derivative};
use crate::operators::self_advection::{Fluid, Reads, Start, for_blocks};
use crate::real::Real;

/// `w_k = v_k - v_{k-1} + Adv(v_k) + nu C^T C v_k + grad p_k` in every slot; without the gradient where `p` is empty.
pub fn from_velocity<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    v: Vector<'_, T>,
    v0: Vector<'_, T>,
    p: &[T],
    w: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let reads = Reads::new(Advection(fluid.nu()), v, [&[]; 3]);
    for_blocks::<T, S, _, _>(
        exec,
        fluid,
        reads,
        Start::Zero,
        w,
        scratch,
        |block, row, parts, scratch| {
            for (axis, part) in parts.iter_mut().enumerate().take(S::DIM) {
                rows::add(part, block.of(v[axis], row));
                subtract_previous(block, row, v[axis], v0[axis], part);
                if !p.is_empty() {
                    add_gradient(block, row, axis, T::ONE, p, part, &mut scratch[..block.len()]);
                }
            }
        },
    );
}

/// `out_k = d_k - d_{k-1} + J(v_k) d_k` in every slot, d_0 = 0: the derivative of [`from_velocity`] along d, without a gradient.
pub fn apply_derivative<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    v: Vector<'_, T>,
    d: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let reads = Reads::new(Derivative(fluid.nu()), v, d);
    for_blocks::<T, S, _, _>(
        exec,
        fluid,
        reads,
        Start::Zero,
        out,
        scratch,
        |block, row, parts, _| {
            for (axis, part) in parts.iter_mut().enumerate().take(S::DIM) {
                rows::add(part, block.of(d[axis], row));
                subtract_previous(block, row, d[axis], &[], part);
            }
        },
    );
}

/// `out_k = w_k - w_{k+1} + J(v_k)^T w_k` in every slot, w_{T+1} = 0: the derivative of 1/2 sum |w(v)|^2, not projected yet.
///
/// It is the adjoint of [`apply_derivative`], applied to w.
pub fn apply_adjoint<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    v: Vector<'_, T>,
    w: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let reads = Reads::new(Adjoint(fluid.nu()), v, w);
    for_blocks::<T, S, _, _>(
        exec,
        fluid,
        reads,
        Start::Zero,
        out,
        scratch,
        |block, row, parts, _| {
            for (axis, part) in parts.iter_mut().enumerate().take(S::DIM) {
                rows::add(part, block.of(w[axis], row));
                subtract_next(block, row, w[axis], part);
            }
        },
    );
}

/// `out_k += J(d_k)^T w_k` in every slot, without viscosity: with the derivative and its adjoint, D^T D d + J(d)^T w is the
/// second derivative of 1/2 sum |w(v)|^2 along d, since J is linear in v but for a constant. What happens at exits is left out: there J has a kink.
pub fn add_curvature<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    d: Vector<'_, T>,
    w: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let reads = Reads::new(Bend, d, w);
    for_blocks::<T, S, _, _>(exec, fluid, reads, Start::Kept, out, scratch, |_, _, _, _| {});
}
