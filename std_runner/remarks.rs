//! What is said of a result beside its numbers: how near it came to each keyframe, and what a reader of its status alone would miss.

use crate::stay::Stay;
use std::borrow::Cow;
use thurible_core::method::registry::{simulates, steers};
use thurible_core::output::DENSITY;
use thurible_core::{Method, Params, Problem, Real, Solver, Space, Status};

/// How far a density is from a keyframe: |R (rho - rho*)| / |R rho*|, Euclidean norms over all cells; R is the keyframe's region, 1 everywhere where
/// it has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyframeError {
    /// Where the keyframe stands; of several steps, the errors are the largest.
    pub stay: Stay,
    /// Of the source, as if it had been held still.
    pub before: f64,
    /// Of the result.
    pub after: f64,
    /// How many times as dense the keyframe is, where it is densest in its region, as the smoke that there is: the source, or with emitters the densest of
    /// all steps.
    pub denser: f64,
}

/// Those of a finished result of `problem`, for each step at which a keyframe stands.
pub fn keyframe_errors<T: Real, S: Space>(
    solver: &Solver<'_, T, S>,
    problem: &Problem<'_>,
) -> Vec<KeyframeError> {
    let steps = problem.keyframes;
    let last = if problem.emitters.is_empty() {
        0
    } else {
        solver.steps()
    };
    let there = (0..=last).map(|step| densest(&density(solver, step)));
    let there = there.fold(0.0, f64::max);
    let first = density(solver, 0);
    let mut region = Vec::new();
    let error = |(index, &step): (usize, &usize)| {
        if problem.keyframe_regions {
            region.resize(solver.cells(), T::ZERO);
            solver.read_region(index, &mut region);
        }
        let wanted = Wanted {
            target: &keyframe(solver, index),
            region: &region,
        };
        KeyframeError {
            stay: Stay::at(step),
            before: wanted.distance(&first),
            after: wanted.distance(&density(solver, step)),
            denser: wanted.densest() / there,
        }
    };
    steps.iter().enumerate().map(error).collect()
}

/// The density of a step in the layout of a file: as it is stored, where that is the same.
pub(crate) fn density<'s, T: Real, S: Space>(solver: &'s Solver<'_, T, S>, step: usize) -> Cow<'s, [T]> {
    let stored = solver.density(step);
    if !solver.is_shared() && stored.len() == solver.cells() {
        return Cow::Borrowed(stored);
    }
    let mut density = vec![T::ZERO; solver.cells()];
    solver.read(&DENSITY, step, 0, &mut density);
    Cow::Owned(density)
}

/// The mass of the smoke at a step.
#[cfg(feature = "std")]
pub(crate) fn mass<T: Real, S: Space>(solver: &Solver<'_, T, S>, step: usize) -> f64 {
    density(solver, step).iter().map(|x| x.to_f64()).sum()
}

/// A keyframe's target as [`density`].
fn keyframe<'s, T: Real, S: Space>(solver: &'s Solver<'_, T, S>, index: usize) -> Cow<'s, [T]> {
    let stored = solver.keyframe(index);
    if !solver.is_shared() && stored.len() == solver.cells() {
        return Cow::Borrowed(stored);
    }
    let mut density = vec![T::ZERO; solver.cells()];
    solver.read_keyframe(index, &mut density);
    Cow::Owned(density)
}

/// Where a region is below this, or as little of a target lies in it, hardly any smoke is asked for there: its edge is soft and ends nowhere.
const HARDLY: f64 = 0.1;

/// What a keyframe asks for.
pub(crate) struct Wanted<'a, T> {
    /// Its target.
    pub target: &'a [T],
    /// What its error is multiplied by; empty for 1 everywhere.
    pub region: &'a [T],
}

impl<T: Real> Wanted<'_, T> {
    /// The target and the region, cell by cell.
    fn cells(&self) -> impl Iterator<Item = [f64; 2]> {
        let region = |cell: usize| self.region.get(cell).map_or(1.0, |part: &T| part.to_f64());
        let target = self.target.iter().enumerate();
        target.map(move |(cell, target)| [target.to_f64(), region(cell)])
    }

    /// How far `found` is from it; see [`KeyframeError`]. Where its region asks for hardly any smoke, in parts of the whole target.
    pub fn distance(&self, found: &[T]) -> f64 {
        let (mut off, mut size, mut whole) = (0.0, 0.0, 0.0);
        for (found, [target, region]) in found.iter().zip(self.cells()) {
            let error = region * (found.to_f64() - target);
            off += error * error;
            size += region * region * target * target;
            whole += target * target;
        }
        let asks = size >= HARDLY * HARDLY * whole;
        (off / if asks { size } else { whole }).sqrt()
    }

    /// The largest density that it asks for.
    pub fn densest(&self) -> f64 {
        let asked = self.cells().filter(|[_, region]| *region >= HARDLY);
        asked.map(|[target, _]| target).fold(0.0, f64::max)
    }
}

/// The largest density.
pub(crate) fn densest<T: Real>(density: &[T]) -> f64 {
    density.iter().map(|density| density.to_f64()).fold(0.0, f64::max)
}

/// The names under which a user knows what is to be changed.
#[derive(Clone, Copy, Debug)]
pub struct Names {
    force_weight: &'static str,
    penalty: &'static str,
    drive: &'static str,
    steps: &'static str,
    match_mass: &'static str,
    double: &'static str,
}

/// Keys of a scene file.
pub const OF_SCENES: Names = Names {
    force_weight: "`control.force_weight`",
    penalty: "`method.admm.penalty`",
    drive: "`method.pd.drive`",
    steps: "`time.steps`",
    match_mass: "`control.match_mass = false`",
    double: "--precision f64",
};

/// Arguments in Python.
pub const OF_PYTHON: Names = Names {
    force_weight: "force_weight",
    penalty: "options[\"penalty\"]",
    drive: "options[\"drive\"]",
    steps: "steps",
    match_mass: "match_mass=False",
    double: "float64",
};

/// Of an error that falls by less than this part of itself one says that the smoke came no nearer.
const MOVED: f64 = 0.05;
/// Errors below this need no control.
const THERE: f64 = 1e-3;
/// A keyframe that is missed by more than this is not reached, whatever the status says.
pub const MISSED: f64 = 0.2;
/// A gradient above this part of the largest is worth a sentence.
const GRADIENT: f64 = 0.01;
/// A keyframe so many times as dense as the source cannot be met: an incompressible flow makes no smoke denser.
const DENSER: f64 = 1.2;
/// Weight of the force and penalty of ADMM, in units of box and step, of all scenes in examples/.
const USUAL: f64 = 1e3;
/// A keyframe of less than this part of its mass is hardly to be seen.
const FAINT: f64 = 0.2;
/// A weight is called unusual when it is so many times less or more.
const UNUSUAL: [f64; 2] = [1e4, 10.0];

/// What there is to say of a solve whose last step ended with `ended` and whose result could be finished.
pub fn remarks(
    problem: &Problem<'_>,
    params: &Params,
    ended: Status,
    errors: &[KeyframeError],
    is_double: bool,
    names: &Names,
) -> Vec<String> {
    let mut remarks = Vec::new();
    if ended == Status::NotFinite {
        remarks.push(last_flow(params, is_double, names));
    }
    let [before, after] = largest(errors);
    let nearer = after < (1.0 - MOVED) * before;
    if before > THERE && !nearer && ended != Status::Cancelled && steers(params) {
        remarks.push(no_nearer(problem, params, [before, after], names));
    } else if after > MISSED && ended == Status::Converged && steers(params) {
        remarks.push(missed(problem, params, errors, names));
    }
    if after > MISSED && problem.mask && params.method == Method::Direct {
        let alone = if problem.share.is_some() {
            " on one rank"
        } else {
            ""
        };
        remarks.push(format!(
            "the direct method is slow to find flows that a mask leaves alone; try the method lbfgs{alone}"
        ));
    }
    remarks
}

/// That a keyframe is hardly to be seen, since it was multiplied by the least of `factors`, which are those of all keyframes of `problem`. In a closed
/// box without emitters it has what mass there is, as the user drew it.
pub fn faint(problem: &Problem<'_>, factors: &[f64], names: &Names) -> Option<String> {
    let keyframes = problem.keyframes.iter().zip(factors);
    let (step, &factor) = keyframes.min_by(|(_, one), (_, other)| one.total_cmp(other))?;
    let may_differ = problem.is_open() || !problem.emitters.is_empty();
    (may_differ && factor < FAINT).then(|| {
        format!(
            "the keyframe at step {step} has {} of its mass, since no more smoke is there by then where nothing steers; {} asks for all of it",
            percent(factor),
            names.match_mass
        )
    })
}

/// That a solve of which nothing else is to be said ended by its tolerance well before its gradient is 0, whose norms on the finest grid are
/// `gradients`; none where they are not known.
pub fn still_falls(ended: Status, mut gradients: impl Iterator<Item = f64>) -> Option<String> {
    let first = gradients.next()?;
    let (largest, last) = gradients.fold((first, first), |(largest, _), norm| (norm.max(largest), norm));
    let left = last / largest;
    (ended == Status::Converged && left > GRADIENT).then(|| {
        format!(
            "it converged by its tolerance, but the gradient is still {} of what it was at most on this grid; a smaller `tolerance` of the \
             method goes on",
            percent(left)
        )
    })
}

/// `said`, or where nothing is said `otherwise`.
pub fn or_else(mut said: Vec<String>, otherwise: Option<String>) -> Vec<String> {
    if said.is_empty() {
        said.extend(otherwise);
    }
    said
}

/// The largest error of the source held still and of the result.
pub fn largest(errors: &[KeyframeError]) -> [f64; 2] {
    let largest = |of: fn(&KeyframeError) -> f64| errors.iter().map(of).fold(0.0, f64::max);
    [largest(|error| error.before), largest(|error| error.after)]
}

/// The errors of all keyframes, or the largest where there are many; `None` where there are none.
pub fn in_words(errors: &[KeyframeError]) -> Option<String> {
    /// Keyframes that fit into a line or two.
    const FEW: usize = 6;
    let one = |error: &KeyframeError| {
        let most = if error.stay.is_held() { "at most " } else { "" };
        format!(
            "{} {most}{} (before {})",
            error.stay,
            percent(error.after),
            percent(error.before)
        )
    };
    match errors {
        [] => None,
        few if few.len() <= FEW => Some(few.iter().map(one).collect::<Vec<_>>().join(", ")),
        many => many
            .iter()
            .max_by(|one, other| one.after.total_cmp(&other.after))
            .map(|worst| format!("{}, the largest of {}", one(worst), many.len())),
    }
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

fn last_flow(params: &Params, is_double: bool, names: &Names) -> String {
    let double = if is_double {
        String::new()
    } else {
        format!("{}, ", names.double)
    };
    if simulates(params) {
        format!(
            "the simulated flow became too fast to follow: from that step on the initial velocity stands; try {double}more {}, or a weaker drive or \
             buoyancy",
            names.steps
        )
    } else {
        format!(
            "every further step left the finite numbers or was too fast to follow: the result is the last flow that was good; try {double}more \
             {} or a larger {}",
            names.steps, names.force_weight
        )
    }
}

/// That the smoke is where it was, and what to change.
fn no_nearer(problem: &Problem<'_>, params: &Params, [before, after]: [f64; 2], names: &Names) -> String {
    let found = format!(
        "the smoke came no nearer to its keyframes: the largest keyframe error is {}, and {} {}",
        percent(after),
        percent(before),
        held_still(problem)
    );
    if params.method == Method::Pd {
        return format!("{found}; try another {} than {}", names.drive, params.pd.drive);
    }
    let unit = problem.units();
    let weight = advice(names.force_weight, problem.force_weight, unit.force * unit.force);
    let penalty = advice(names.penalty, params.admm.penalty, unit.velocity * unit.velocity);
    let advice = match (weight, penalty) {
        (Some(weight), Some(penalty)) if params.method == Method::Admm => format!("{weight}, and {penalty}"),
        (None, Some(penalty)) if params.method == Method::Admm => penalty,
        (Some(weight), _) => weight,
        (None, _) if problem.force_weight * unit.force * unit.force < USUAL / 10.0 => {
            format!(
                "force is cheap already; try more iterations or more {}",
                names.steps
            )
        }
        (None, _) => format!(
            "try a smaller {}, say {:.1e}, or more iterations",
            names.force_weight,
            problem.force_weight / 100.0
        ),
    };
    format!("{found}; {advice}")
}

/// That the least J leaves a keyframe far away, and what to change.
fn missed(problem: &Problem<'_>, params: &Params, errors: &[KeyframeError], names: &Names) -> String {
    let [before, after] = largest(errors);
    let found = format!(
        "it converged, but a keyframe is missed by {}, and by {} {}",
        percent(after),
        percent(before),
        held_still(problem)
    );
    let farthest = errors
        .iter()
        .max_by(|one, other| one.after.total_cmp(&other.after));
    if let Some(error) = farthest.filter(|error| error.denser >= DENSER) {
        let scaled = if problem.match_mass {
            "scaled to the mass of the source, "
        } else {
            ""
        };
        return format!(
            "{found}: {scaled}the keyframe at {} is {:.1} times as dense as it, and no flow makes smoke denser; try a \
             smaller source or a larger shape there",
            error.stay, error.denser
        );
    }
    if params.method == Method::Pd {
        return format!("{found}; try a larger {} than {}", names.drive, params.pd.drive);
    }
    format!(
        "{found}: to come nearer costs more than it brings; try a smaller {}, say {:.1e}, or more {}",
        names.force_weight,
        problem.force_weight / 100.0,
        names.steps
    )
}

/// What is not moved where a keyframe error is that of before.
fn held_still(problem: &Problem<'_>) -> &'static str {
    if problem.emitters.is_empty() {
        "with the source held still"
    } else {
        "with the smoke of step 0 held still"
    }
}

/// What to make of a weight that is `scale` times larger in units of box and step, if it is unusual there.
fn advice(name: &str, weight: f64, scale: f64) -> Option<String> {
    let scaled = weight * scale;
    let [less, more] = UNUSUAL;
    let usual = (USUAL / less..=USUAL * more).contains(&scaled);
    (!usual).then(|| {
        format!(
            "in units of box and step {name} is {scaled:.1e}, and {USUAL} in the examples: try {:.2e}",
            USUAL / scale
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use thurible_core::Boundary;

    const WALLS: [Boundary; 2] = [Boundary::Wall; 2];

    fn said(problem: &Problem<'_>, method: Method, ended: Status, [before, after]: [f64; 2]) -> Vec<String> {
        let params = Params {
            method,
            ..Params::default()
        };
        let error = KeyframeError {
            stay: Stay::at(12),
            before,
            after,
            denser: 1.0,
        };
        remarks(problem, &params, ended, &[error], false, &OF_SCENES)
    }

    /// A box of ten metres, 24 steps a second: a weight of 1000 is three billions in units of box and step.
    fn metres() -> Problem<'static> {
        Problem {
            length: 10.0,
            dt: 1.0 / 24.0,
            ..Problem::new(&[24, 24], &WALLS, &[12])
        }
    }

    #[test]
    fn a_weight_in_other_units_is_named_with_one_to_try() {
        let said = said(&metres(), Method::Direct, Status::Converged, [0.717, 0.716]);
        assert_eq!(said.len(), 1, "{said:?}");
        let sentence = &said[0];
        assert_eq!(
            sentence,
            "the smoke came no nearer to its keyframes: the largest keyframe error is 71.6 %, and 71.7 % with the source held still; in units of box and step \
             `control.force_weight` is 3.3e10, and 1000 in the examples: try 3.01e-5"
        );
    }

    #[test]
    fn a_mask_is_better_met_over_forces() {
        let problem = Problem {
            mask: true,
            ..Problem::new(&[24, 24], &WALLS, &[12])
        };
        let said = said(&problem, Method::Direct, Status::MaxIterations, [1.4, 0.5]);
        assert!(
            said.len() == 1 && said[0].contains("try the method lbfgs"),
            "{said:?}"
        );
    }

    #[test]
    fn the_penalty_is_named_too_where_there_is_one() {
        let said = said(&metres(), Method::Admm, Status::Stalled, [0.7, 0.7]);
        assert!(
            said[0].contains("`method.admm.penalty` is 5.8e7, and 1000 in the examples: try 1.74e-2"),
            "{said:?}"
        );
    }

    #[test]
    fn what_moved_or_had_not_to_needs_no_words() {
        let problem = metres();
        for errors in [[0.7, 0.2], [0.0, 0.0], [1e-4, 1e-4]] {
            assert!(said(&problem, Method::Direct, Status::Converged, errors).is_empty());
        }
        assert!(said(&problem, Method::Direct, Status::Cancelled, [0.7, 0.7]).is_empty());
        assert!(said(&problem, Method::Simulate, Status::Converged, [0.7, 0.7]).is_empty());
    }

    #[test]
    fn a_keyframe_that_is_missed_is_said_where_the_status_praises() {
        let problem = metres();
        let said_of = |ended| said(&problem, Method::Direct, ended, [0.7, 0.3]);
        assert_eq!(
            said_of(Status::Converged),
            [
                "it converged, but a keyframe is missed by 30.0 %, and by 70.0 % with the source held still: to come nearer costs more than it \
              brings; try a smaller `control.force_weight`, say 1.0e1, or more `time.steps`"
            ]
        );
        assert!(said_of(Status::MaxIterations).is_empty());
    }

    #[test]
    fn a_faint_keyframe_is_said_to_be() {
        let closed = Problem::new(&[24, 24], &WALLS, &[12, 20]);
        assert_eq!(faint(&closed, &[1.0, 0.028], &OF_SCENES), None);
        let problem = Problem::new(&[24, 24], &[Boundary::Wall, Boundary::OpenHigh], &[12, 20]);
        assert_eq!(faint(&problem, &[1.0, 0.3], &OF_SCENES), None);
        let left = faint(&problem, &[1.0, 0.028], &OF_SCENES).unwrap_or_default();
        assert!(
            left.starts_with("the keyframe at step 20 has 2.8 % of its mass"),
            "{left}"
        );
    }

    #[test]
    fn what_lies_outside_of_a_region_does_not_count() {
        let wanted = |region: &'static [f64]| Wanted {
            target: &[1.0, 2.0, 0.0, 4.0],
            region,
        };
        let found = [1.0, 1.0, 5.0, 4.0];
        assert_eq!(
            wanted(&[1.0, 1.0, 0.0, 0.0]).distance(&found),
            (1.0_f64 / 5.0).sqrt()
        );
        assert_eq!(wanted(&[0.2, 0.2, 0.0, 0.01]).densest(), 2.0);
        // Where no smoke is asked for, that counts beside the whole target.
        for least in [0.0, 1e-9] {
            let Wanted { target, .. } = wanted(&[]);
            let region = &[0.0, 0.0, 1.0, least][..];
            let distance = Wanted { target, region }.distance(&found);
            assert_eq!(distance, (25.0_f64 / 21.0).sqrt());
        }
        assert_eq!(wanted(&[]).distance(&found), (26.0_f64 / 21.0).sqrt());
    }

    #[test]
    fn a_gradient_that_is_left_is_said() {
        let said = |ended, gradients: &[f64]| still_falls(ended, gradients.iter().copied());
        assert_eq!(said(Status::Converged, &[3.0, 4.0, 0.04]), None);
        assert_eq!(said(Status::MaxIterations, &[4.0, 2.0]), None);
        assert_eq!(said(Status::Converged, &[]), None);
        let left = said(Status::Converged, &[3.0, 4.0, 0.1]).unwrap_or_default();
        assert!(left.contains("is still 2.5 % of what it was at most"), "{left}");
    }

    #[test]
    fn a_keyframe_denser_than_the_source_is_said_to_be() {
        let error = |denser| KeyframeError {
            stay: Stay::at(12),
            before: 0.7,
            after: 0.3,
            denser,
        };
        let params = Params::default();
        let said_of = |denser| {
            let errors = [error(denser)];
            remarks(&metres(), &params, Status::Converged, &errors, false, &OF_SCENES)
        };
        assert_eq!(
            said_of(1.43),
            [
                "it converged, but a keyframe is missed by 30.0 %, and by 70.0 % with the source held still: scaled to the mass of the source, the \
              keyframe at step 12 is 1.4 times as dense as it, and no flow makes smoke denser; try a smaller source or a larger shape there"
            ]
        );
        assert!(said_of(1.1)[0].contains("force_weight"));
    }

    #[test]
    fn errors_of_few_keyframes_are_listed() {
        let error = |step| KeyframeError {
            stay: Stay::at(step),
            before: 0.9,
            after: 0.01 * step as f64,
            denser: 1.0,
        };
        assert_eq!(in_words(&[]), None);
        assert_eq!(
            in_words(&[error(4), error(8)]).as_deref(),
            Some("step 4 4.0 % (before 90.0 %), step 8 8.0 % (before 90.0 %)")
        );
        let held = KeyframeError {
            stay: Stay { first: 4, last: 7 },
            ..error(4)
        };
        assert_eq!(
            in_words(&[held, error(8)]).as_deref(),
            Some("steps 4 to 7 at most 4.0 % (before 90.0 %), step 8 8.0 % (before 90.0 %)")
        );
        let many: Vec<_> = (1..=9).map(error).collect();
        assert_eq!(
            in_words(&many).as_deref(),
            Some("step 9 9.0 % (before 90.0 %), the largest of 9")
        );
    }
}
