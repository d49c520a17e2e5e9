//! The templates of a result, as `report.json` has them.

use serde::Serialize;
use thurible_core::{Named, Real, Solver, Space, Template, TemplateKind};

/// A template as it was found, in the scene's units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TemplateRecord {
    /// What it does, by its name.
    pub kind: &'static str,
    /// Its middle.
    pub center: Vec<f64>,
    /// Its radius.
    pub radius: f64,
    /// The first force that it is part of.
    pub from: usize,
    /// The first that it is no part of any more.
    pub to: usize,
    /// How many steps share an amplitude.
    pub interval: usize,
    /// Whether middle and radius were searched for.
    #[serde(rename = "move")]
    pub moves: bool,
    /// Length of the waves of noise; other templates have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
    /// Which noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u32>,
    /// The amplitude of each interval.
    pub amplitude: Vec<Vec<f64>>,
}

/// The templates of `solver`, where it has any.
pub(crate) fn templates<T: Real, S: Space>(solver: &Solver<'_, T, S>) -> Vec<TemplateRecord> {
    let all = (0..).map_while(|index| Some((index, solver.template(index)?)));
    all.map(|(index, found)| {
        let amplitudes = (0..found.intervals(found.to)).map(|interval| solver.amplitude(index, interval));
        record(&found, S::DIM, amplitudes)
    })
    .collect()
}

/// A template with the amplitude of each of its intervals.
pub(crate) fn record(
    found: &Template,
    dims: usize,
    amplitudes: impl Iterator<Item = [f64; 3]>,
) -> TemplateRecord {
    let Template {
        kind,
        center,
        radius,
        from,
        to,
        interval,
        moves,
        size,
        seed,
        ..
    } = *found;
    let numbers = kind.numbers(dims);
    let noise = kind == TemplateKind::Noise;
    TemplateRecord {
        kind: kind.name(),
        center: center.into_iter().take(dims).collect(),
        radius,
        from,
        to,
        interval,
        moves,
        size: noise.then_some(size),
        seed: noise.then_some(seed),
        amplitude: amplitudes
            .map(|amplitude| amplitude.into_iter().take(numbers).collect())
            .collect(),
    }
}
