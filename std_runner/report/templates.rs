//! The templates of a result: in `report.json`, as a table of the page, and in lines for a terminal.

use super::document::Table;
use super::record::{RunRecord, by_name};
use super::words::number;
use serde::Serialize;
use thurible_core::{Named, Real, Solver, Space, Template, TemplateKind};

/// A template as it was found, in the scene's units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TemplateRecord {
    /// What it does; in the file its name.
    #[serde(serialize_with = "by_name")]
    pub kind: TemplateKind,
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
        } = found;
        let numbers = kind.numbers(S::DIM);
        let amplitude = |interval| solver.amplitude(index, interval)[..numbers].to_vec();
        let noise = kind == TemplateKind::Noise;
        TemplateRecord {
            kind,
            center: center[..S::DIM].to_vec(),
            radius,
            from,
            to,
            interval,
            moves,
            size: noise.then_some(size),
            seed: noise.then_some(seed),
            amplitude: (0..found.intervals(to)).map(amplitude).collect(),
        }
    })
    .collect()
}

/// Numbers side by side.
fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", ")
}

impl TemplateRecord {
    /// The steps that share an amplitude, and that.
    fn intervals(&self) -> impl Iterator<Item = (String, String)> {
        let steps = (self.from..self.to).step_by(self.interval.max(1));
        steps.zip(&self.amplitude).map(|(first, amplitude)| {
            let last = (first + self.interval).min(self.to) - 1;
            (format!("{first} to {last}"), list(amplitude))
        })
    }
}

/// A row for each amplitude.
pub(super) fn table(record: &RunRecord) -> Option<Table> {
    let rows = record.templates.iter().enumerate().flat_map(|(index, template)| {
        let place = [list(&template.center), number(template.radius)];
        template
            .intervals()
            .enumerate()
            .map(move |(interval, (steps, amplitude))| {
                let name = format!("template[{index}] {}", template.kind.name());
                let shown = |text: &String| {
                    if interval == 0 {
                        text.clone()
                    } else {
                        String::new()
                    }
                };
                let [center, radius] = &place;
                vec![shown(&name), shown(center), shown(radius), steps, amplitude]
            })
    });
    let rows: Vec<Vec<String>> = rows.collect();
    (!rows.is_empty()).then(|| Table {
        head: vec!["Template", "Center", "Radius", "Steps", "Amplitude"],
        names: 1,
        ours: 5,
        rows,
    })
}

/// A line for each template.
pub(crate) fn lines(record: &RunRecord) -> impl Iterator<Item = String> {
    record.templates.iter().enumerate().map(|(index, template)| {
        let amplitudes: Vec<String> = template
            .intervals()
            .map(|(steps, amplitude)| format!("{amplitude} in steps {steps}"))
            .collect();
        format!(
            "template[{index}] {}: center {}, radius {}, amplitude {}",
            template.kind.name(),
            list(&template.center),
            number(template.radius),
            amplitudes.join("; ")
        )
    })
}
