//! What tells one solve from another.

use crate::checkpoint::Mix;
use crate::grid::Space;
use crate::method::params::Params;
use crate::method::registry;
use crate::problem::{Advection, Emitter, Problem, Supply, Template};
use crate::real::Real;

/// All that the bits of a step follow from, but for the densities, in one word.
pub fn fingerprint<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> u64 {
    let mut mix = of_problem::<T, S>(problem);
    // Threads and ceiling change no bit but by the choices that they come to; iterations only say when to stop.
    mix.word(params.method as u64);
    registry::mix::<T, S>(params, &mut mix);
    mix.finish()
}

/// Precision, dimension and problem; the choices of whoever solves it are mixed in next.
pub fn of_problem<T: Real, S: Space>(problem: &Problem<'_>) -> Mix {
    let mut mix = Mix::new();
    mix.word(T::BYTES as u64);
    mix.word(S::DIM as u64);
    mix_problem(&mut mix, problem);
    mix
}

fn mix_problem(mix: &mut Mix, problem: &Problem<'_>) {
    // Every field by name: a new one does not compile until it is mixed in.
    let Problem {
        cells,
        boundary,
        length,
        dt,
        steps,
        keyframes,
        keyframe_weights,
        keyframe_regions,
        emitters,
        solids,
        buoyancy,
        templates,
        release,
        schedule,
        mask,
        force_weight,
        viscosity,
        slip,
        smoothness,
        filters: _,
        match_mass,
        advection,
        projection_tolerance,
        share: _,
    } = problem;
    cells.iter().for_each(|&n| mix.word(n as u64));
    boundary.iter().for_each(|&end| mix.word(end as u64));
    mix.word(*steps as u64);
    mix.word(keyframes.len() as u64);
    keyframes.iter().for_each(|&step| mix.word(step as u64));
    mix.word(u64::from(*keyframe_regions));
    mix.word(u64::from(*solids));
    mix.word(u64::from(*slip));
    mix.word(u64::from(*mask));
    mix.word(keyframe_weights.len() as u64);
    mix.word(emitters.len() as u64);
    emitters.iter().for_each(|emitter| mix_emitter(mix, emitter));
    mix.word(schedule.len() as u64);
    for &(step, factor) in *schedule {
        mix.word(step as u64);
        mix.real(factor);
    }
    mix.word(templates.len() as u64);
    let numbers = templates.iter().flat_map(Template::pack);
    numbers.for_each(|number| mix.real(number));
    let reals = keyframe_weights.iter().chain(buoyancy);
    reals.for_each(|&number| mix.real(number));
    mix.word(release.map_or(0, |step| step as u64));
    mix.word(problem.filters() as u64);
    mix.word(u64::from(*match_mass));
    let Advection { scheme, tolerance } = advection;
    mix.word(*scheme as u64);
    [
        length,
        dt,
        force_weight,
        viscosity,
        tolerance,
        projection_tolerance,
        &smoothness.unwrap_or(0.0),
    ]
    .into_iter()
    .for_each(|&number| mix.real(number));
}

fn mix_emitter(mix: &mut Mix, emitter: &Emitter) {
    let Emitter {
        from,
        to,
        supply,
        velocity,
    } = *emitter;
    let (kind, number) = match supply {
        Supply::Rate(rate) => (0, rate),
        Supply::Target(target) => (1, target),
    };
    [from as u64, to as u64, kind, u64::from(velocity.is_some())]
        .into_iter()
        .for_each(|word| mix.word(word));
    let along = velocity.unwrap_or_default();
    along
        .into_iter()
        .chain([number])
        .for_each(|number| mix.real(number));
}
