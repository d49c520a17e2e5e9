//! A price of the force and of its curl, r/2 sum <u, B u> with B = 1 + s^2 C^T C: forces finer than s are dear.
//!
//! C u is the curl at the plaquettes, so C^T C is minus the Laplacian of a field without divergence. B is symmetric, has eigenvalues
//! from 1 to 1 + s^2 sum_a 4 / h_a^2, and keeps fields free of divergence.

use crate::exec::Exec;
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::grid::{Grid, Space};
use crate::operators::drag::combine;
use crate::operators::self_advection::Fluid;
use crate::real::Real;

/// What of B B^-1 - 1 may be left by [`solve`].
const LEFT: f64 = 0.6;
/// Steps of [`solve`] at most: beyond a smoothness of 17 cells in 3D and 20 in 2D more is left.
const MOST_STEPS: usize = 32;

/// `out = B w` in every slot; s^2 is the fluid's viscosity. Shapes: trajectories of faces.
pub fn apply<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    w: Vector<'_, T>,
    out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    combine::<T, S>(exec, fluid, [1.0, 1.0, 0.0], w, w, out, scratch);
}

/// The steps of [`solve`], of which number `step` goes so far; `None` after the last. `smoothing` is s^2.
#[must_use]
pub fn length(grid: &Grid, smoothing: f64, step: usize) -> Option<f64> {
    let largest = 1.0 + smoothing * grid.h.iter().take(grid.dims).map(|h| 4.0 / (h * h)).sum::<f64>();
    let (middle, half) = (0.5 * (largest + 1.0), 0.5 * (largest - 1.0));
    let steps = libm::ceil(libm::acosh(1.0 / LEFT) / libm::acosh(middle / half)) as usize;
    let steps = steps.clamp(1, MOST_STEPS);
    (step < steps).then(|| {
        let angle = core::f64::consts::PI * (alternating(step, steps) as f64 + 0.5) / steps as f64;
        1.0 / (middle + half * libm::cos(angle))
    })
}

/// `x = q(B) y` in every slot, the polynomial of lowest degree with |q(t) t - 1| <= 0.6 wherever B has eigenvalues: B^-1, roughly, but
/// symmetric and positive, by Richardson's steps at the roots of Chebyshev's polynomial. `work` is a field like them.
pub fn solve<'a, T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    y: Vector<'_, T>,
    x: VectorMut<'a, T>,
    work: VectorMut<'a, T>,
    scratch: &mut [T],
) {
    let Fluid {
        grid,
        slots,
        viscosity,
        ..
    } = fluid;
    let shape = Shape { grid, slots };
    let lengths = (0..).map_while(|step| length(grid, viscosity, step));
    // The first step from 0 is a multiple of y. So many more that the last ends in x.
    let (mut now, mut next) = if lengths.clone().count().is_multiple_of(2) {
        (work, x)
    } else {
        (x, work)
    };
    for (step, length) in lengths.enumerate() {
        if step == 0 {
            trajectory::add(exec, shape, &mut now, 0.0, length, y);
            continue;
        }
        let factors = [1.0 - length, -length, length];
        combine::<T, S>(exec, fluid, factors, view(&now), y, reborrow(&mut next), scratch);
        core::mem::swap(&mut now, &mut next);
    }
}

/// Root `step` of `count`, from both ends in turn, so that no step undoes what others gained by much.
fn alternating(step: usize, count: usize) -> usize {
    if step.is_multiple_of(2) {
        step / 2
    } else {
        count - 1 - step / 2
    }
}
