//! What the bits of a search follow from.

use super::params::{FluidsParams, NAME};
use crate::grid::Space;
use crate::problem::Problem;
use crate::real::Real;
use crate::solver::of_problem;

/// All that the bits of a search follow from, but for its densities and velocity, in one word.
pub(super) fn fingerprint<T: Real, S: Space>(problem: &Problem<'_>, params: &FluidsParams) -> u64 {
    // Every field by name: a new one does not compile until it is mixed in.
    let FluidsParams {
        controls,
        pressure,
        sweeps,
        cg_iterations,
        cg_tolerance,
        adjoint,
        diffusion,
        initial_weight,
        // What is kept for the way back changes no bit, nor do threads; iterations only say when to stop.
        slots: _,
        history,
        tolerance,
        iterations: _,
        threads: _,
        initial_velocity,
    } = *params;
    let mut mix = of_problem::<T, S>(problem);
    mix.bytes(NAME.as_bytes());
    controls.list().for_each(|control| mix.word(1 + control as u64));
    mix.word(pressure as u64);
    mix.word(adjoint as u64);
    [sweeps, cg_iterations, history]
        .into_iter()
        .for_each(|count| mix.word(count as u64));
    [cg_tolerance, diffusion, initial_weight, tolerance]
        .into_iter()
        .for_each(|number| mix.real(number));
    mix.word(u64::from(initial_velocity));
    mix.finish()
}
