//! What a solve came to, of a solver or of all its windows.

use crate::problem::OwnedProblem;
use crate::remarks::{KeyframeError, density, keyframe_errors, mass, still_falls};
use crate::report::{IterationRecord, TemplateRecord, WindowRecord, templates};
use thurible_core::{Emitter, Objective, Real, Solver, Space, Supply};

/// What a solve came to.
pub(super) struct Found {
    /// How well keyframes were reached, at each of their steps.
    pub errors: Vec<KeyframeError>,
    /// The smallest and the largest density of all steps.
    pub densities: [f64; 2],
    /// The mass that left by open sides, if it is known.
    pub outflow: Option<f64>,
    /// The objective of the result.
    pub objective: Objective,
    /// The templates as they were found.
    pub templates: Vec<TemplateRecord>,
    /// The windows, where it was solved in them.
    pub windows: Vec<WindowRecord>,
}

impl Found {
    /// What `solver` came to, which has solved `problem`.
    pub fn of<T: Real, S: Space>(solver: &Solver<'_, T, S>, problem: &OwnedProblem) -> Self {
        let left = mass(solver, solver.steps());
        Self {
            errors: keyframe_errors(solver, &problem.problem()),
            densities: density_range(solver, 0..=solver.steps()),
            outflow: leaves(problem).then(|| solver.mass_at(solver.steps()) - left),
            objective: solver.objective(),
            templates: templates(solver),
            windows: Vec::new(),
        }
    }
}

/// Whether smoke leaves, and how much can be known of it.
pub(super) fn leaves(problem: &OwnedProblem) -> bool {
    let fills = |emitter: &Emitter| matches!(emitter.supply, Supply::Target(_));
    problem.problem().is_open() && !problem.emitters.iter().any(fills)
}

/// The smallest and the largest density of some steps.
pub(super) fn density_range<T: Real, S: Space>(
    solver: &Solver<'_, T, S>,
    steps: impl Iterator<Item = usize>,
) -> [f64; 2] {
    let wider = |[least, most]: [f64; 2], density: &T| {
        let density = density.to_f64();
        [least.min(density), most.max(density)]
    };
    steps.fold([f64::INFINITY, f64::NEG_INFINITY], |range, step| {
        density(solver, step).iter().fold(range, wider)
    })
}

/// The norms of the gradient on the finest grid.
pub(super) fn gradients<'h>(
    history: &'h [IterationRecord],
    cells: &'h [usize],
) -> impl Iterator<Item = f64> + 'h {
    let of_finest =
        move |record: &&IterationRecord| record.level.as_ref().is_none_or(|level| *level == cells);
    let finest = history.iter().filter(of_finest);
    finest.filter_map(|record| record.facts.get("gradient_norm"))
}

/// Of how many windows there is to say that they ended well before their gradient was 0, and what of the first of them.
pub(super) fn windows_fall(
    windows: &[WindowRecord],
    history: &[IterationRecord],
    cells: &[usize],
) -> Option<String> {
    let of = |number: usize| history.partition_point(|record| record.window < Some(number));
    let said = windows.iter().enumerate().filter_map(|(number, window)| {
        let own = history.get(of(number)..of(number + 1))?;
        let sentence = still_falls(window.status, gradients(own, cells))?;
        Some((number, sentence))
    });
    let said: Vec<(usize, String)> = said.collect();
    let (first, sentence) = said.first()?;
    Some(format!(
        "of {} of {} windows, first of number {first}: {sentence}",
        said.len(),
        windows.len()
    ))
}
