//! The facts of iterations and windows, as `report.json` holds them.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use thurible_core::{Fact, Kind, Named, Objective, Progress, Status};

/// Writes a choice as the word that stands for it.
pub(crate) fn by_name<T: Named, S: Serializer>(choice: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(choice.name())
}

/// The objective, its two parts, and what of the second is not for curls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectiveRecord {
    /// Distance from the keyframes.
    pub data: f64,
    /// The price of the forces, r/2 sum <u, (1 + s^2 C^T C) u>.
    pub force: f64,
    /// r/2 times the squared forces.
    pub plain: f64,
    /// The price of the velocity at the start, of methods that have one.
    pub initial: Option<f64>,
}

impl From<Objective> for ObjectiveRecord {
    fn from(
        Objective {
            data,
            force,
            plain,
            initial,
        }: Objective,
    ) -> Self {
        Self {
            data,
            force,
            plain,
            initial: (initial != 0.0).then_some(initial),
        }
    }
}

impl ObjectiveRecord {
    /// The sum.
    pub fn total(&self) -> f64 {
        self.data + self.force + self.initial.unwrap_or(0.0)
    }
}

impl Serialize for ObjectiveRecord {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Parts {
            data: f64,
            force: f64,
            force_plain: f64,
            #[serde(skip_serializing_if = "Option::is_none")]
            initial: Option<f64>,
            total: f64,
        }
        Parts {
            data: self.data,
            force: self.force,
            force_plain: self.plain,
            initial: self.initial,
            total: self.total(),
        }
        .serialize(serializer)
    }
}

/// One outer iteration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IterationRecord {
    /// Number of the iteration, from 1.
    pub iteration: usize,
    /// The window that it was of, from 0, where there are windows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<usize>,
    /// Since the solve began.
    pub seconds: f64,
    /// What was still to come, by the pace so far, where there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds_left: Option<f64>,
    /// The objective after the iteration.
    #[serde(flatten)]
    pub objective: ObjectiveRecord,
    /// Cells of the grid that it worked on, where the method tells it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<Vec<usize>>,
    /// What the method has to tell beside that, by name.
    #[serde(flatten)]
    pub facts: Facts,
}

impl IterationRecord {
    /// Of an iteration that ended `seconds` after the solve began, when about `seconds_left` were left.
    pub(crate) fn new(seconds: f64, seconds_left: Option<f64>, progress: &Progress) -> Self {
        Self {
            iteration: progress.iteration,
            window: None,
            seconds,
            seconds_left,
            objective: progress.objective.into(),
            level: (progress.level_iteration > 0).then(|| cells(progress)),
            facts: Facts::of(progress),
        }
    }
}

impl Default for WindowRecord {
    fn default() -> Self {
        Self {
            start: 0,
            steps: 0,
            kept: 0,
            keyframes: Vec::new(),
            ahead: None,
            continued: false,
            iterations: 0,
            status: Status::Converged,
            objective: Objective::default().into(),
            seconds: 0.0,
        }
    }
}

/// One window of a scene that is solved in windows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WindowRecord {
    /// The step of the scene that it begins at.
    pub start: usize,
    /// Its steps.
    pub steps: usize,
    /// How many of them are in the result.
    pub kept: usize,
    /// The steps of the keyframes that it was searched for; none where it was simulated.
    pub keyframes: Vec<usize>,
    /// The step of the keyframe beyond it, on the way to which it was kept.
    pub ahead: Option<usize>,
    /// Whether the search began with what was left of the window before, not on coarser grids.
    pub continued: bool,
    /// Its iterations.
    pub iterations: usize,
    /// How it ended.
    #[serde(serialize_with = "by_name")]
    pub status: Status,
    /// The objective of all of its steps, of which those that are not kept were searched again.
    pub objective: ObjectiveRecord,
    /// Seconds that it took.
    pub seconds: f64,
}

/// Cells of the grid that an iteration worked on.
pub(crate) fn cells(progress: &Progress) -> Vec<usize> {
    progress.cells.into_iter().filter(|&count| count > 1).collect()
}

/// What a method tells of an iteration, each fact with its values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts(pub Vec<(Fact, Vec<f64>)>);

impl Facts {
    fn of(progress: &Progress) -> Self {
        let facts = progress.report.iter();
        Self(facts.map(|(fact, values)| (fact, values.to_vec())).collect())
    }

    /// The values of the fact with this name, or none.
    pub fn series(&self, name: &str) -> &[f64] {
        let found = self.0.iter().find(|(fact, _)| fact.name == name);
        found.map_or(&[], |(_, values)| values)
    }

    /// The last value of the fact with this name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.series(name).last().copied()
    }
}

impl Serialize for Facts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (fact, values) in &self.0 {
            let value = values.first().copied().unwrap_or(f64::NAN);
            match fact.kind {
                Kind::Number => map.serialize_entry(fact.name, &value)?,
                Kind::Count => map.serialize_entry(fact.name, &(value as u64))?,
                Kind::Flag => map.serialize_entry(fact.name, &(value != 0.0))?,
                Kind::Series => map.serialize_entry(fact.name, values)?,
            }
        }
        map.end()
    }
}
