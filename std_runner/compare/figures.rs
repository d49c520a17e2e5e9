//! The figures of one method in a comparison, from the record of its run alone.

use super::staggered::Staggered;
use crate::report::{
    IterationRecord, KeyframeRecord, ObjectiveRecord, RunRecord, SolvedBy, by_grid, by_name,
};
use serde::Serialize;
use thurible_core::Status;

/// An objective up to this times the best counts as having reached it.
pub const NEAR: f64 = 1.01;

/// One row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// The method.
    pub method: SolvedBy,
    /// How it ended.
    #[serde(serialize_with = "by_name")]
    pub status: Status,
    /// Number of threads.
    pub threads: usize,
    /// Iterations on the finest grid.
    pub iterations: usize,
    /// Iterations on coarser grids before.
    pub coarser_iterations: usize,
    /// Seconds from the first iteration, which may be on a coarser grid, to the last.
    pub seconds: f64,
    /// Seconds until the objective was within 1 % of the best that any method found; absent if it never was.
    pub seconds_to_best: Option<f64>,
    /// Seconds until the objective was at most the largest final objective of the methods that descend.
    pub seconds_to_worst: Option<f64>,
    /// Seconds of an iteration on the finest grid, on average.
    pub iteration_average: f64,
    /// Seconds of an advection problem, on average; ADMM only.
    pub ao_average: Option<f64>,
    /// Seconds of a Navier-Stokes problem, on average; ADMM only.
    pub nso_average: Option<f64>,
    /// The objective of the feasible result, on the staggered grid.
    pub objective: ObjectiveRecord,
    /// Of another simulator the objective that it searched by, on its own grid.
    pub own_objective: Option<ObjectiveRecord>,
    /// The largest relative distance from a keyframe.
    pub keyframe_error: f64,
    /// The same of the source held still.
    pub keyframe_error_before: f64,
    /// What the status alone does not say.
    pub remarks: Vec<String>,
    /// Bytes of the block of memory.
    pub planned_bytes: usize,
    /// The paper's bound M for ADMM, in values of this precision.
    pub paper_bound_bytes: usize,
}

impl Figures {
    /// The figures of `record`, and what it comes to on the staggered grid where it is of another; `best` is the least final objective, `worst` the
    /// largest of the methods that descend.
    pub(crate) fn of(record: &RunRecord, staggered: Option<&Staggered>, (best, worst): (f64, f64)) -> Self {
        let iterations = record
            .history
            .iter()
            .filter(|entry| is_finest(record, entry))
            .count();
        let coarser_iterations = record.history.len() - iterations;
        // The way of another objective says nothing of this one.
        let way = if staggered.is_none() { way(record) } else { &[] };
        let seconds = record.history.last().map_or(0.0, |entry| entry.seconds);
        Self {
            method: record.method,
            status: record.status,
            threads: record.threads,
            iterations,
            coarser_iterations,
            seconds,
            seconds_to_best: reached(way, record.objective.total(), NEAR * best),
            seconds_to_worst: reached(way, record.objective.total(), worst),
            iteration_average: (seconds - record.seconds.nested) / iterations.max(1) as f64,
            ao_average: spent(record.seconds.ao_average),
            nso_average: spent(record.seconds.nso_average),
            objective: staggered.map_or(record.objective, |found| found.objective),
            own_objective: staggered.map(|_| record.objective),
            keyframe_error: staggered.map_or_else(
                || largest(record, |keyframe| keyframe.relative_l2),
                |found| found.keyframe_error,
            ),
            keyframe_error_before: largest(record, |keyframe| keyframe.relative_l2_before),
            remarks: record.remarks.clone(),
            planned_bytes: record.memory.planned_bytes,
            paper_bound_bytes: record.memory.paper_bound_bytes,
        }
    }
}

fn largest(record: &RunRecord, of: fn(&KeyframeRecord) -> f64) -> f64 {
    record.keyframes.iter().map(of).fold(0.0, f64::max)
}

/// Seconds of a phase, if the method has it.
fn spent(seconds: f64) -> Option<f64> {
    (seconds > 0.0).then_some(seconds)
}

/// Whether an iteration is on the grid of the scene itself.
fn is_finest(record: &RunRecord, entry: &IterationRecord) -> bool {
    entry.level.as_ref().is_none_or(|cells| *cells == record.cells)
}

/// The iterations whose objectives are that of the result: those on the grid of the scene itself, since those of coarser grids cannot be compared,
/// and none of a window, whose objective is that of its own steps.
pub fn way(record: &RunRecord) -> &[IterationRecord] {
    let is_whole = |piece: &&[IterationRecord]| {
        let level = |entry: &IterationRecord| is_finest(record, entry) && entry.window.is_none();
        piece.first().is_some_and(level)
    };
    by_grid(&record.history).last().filter(is_whole).unwrap_or(&[])
}

/// Seconds until the objective was at most `target`, if it also ended there: an objective on the way may be that of a flow that is
/// not feasible yet.
fn reached(history: &[IterationRecord], end: f64, target: f64) -> Option<f64> {
    let last = history.last()?;
    let entry = history
        .iter()
        .find(|entry| entry.objective.total() <= target && entry.objective.total() > 0.0);
    (end <= target).then(|| entry.unwrap_or(last).seconds)
}

/// Whether the method made more than one iteration on the finest grid, so that its objective can be plotted.
pub fn descends(record: &RunRecord) -> bool {
    way(record).len() > 1
}

/// The least of the objectives that methods ended with, and the largest of those that descend, of objectives and whether they do.
pub(crate) fn ends(totals: impl Iterator<Item = (f64, bool)>) -> (f64, f64) {
    let widened = |(least, largest): (f64, f64), (total, descends): (f64, bool)| {
        let largest = if descends { largest.max(total) } else { largest };
        (least.min(total), largest)
    };
    totals.fold((f64::INFINITY, f64::NEG_INFINITY), widened)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Facts;

    fn history(totals: &[f64]) -> Vec<IterationRecord> {
        let entry = |(index, &data): (usize, &f64)| IterationRecord {
            iteration: index + 1,
            window: None,
            seconds: index as f64 + 1.0,
            seconds_left: None,
            objective: ObjectiveRecord {
                data,
                force: 0.0,
                plain: 0.0,
                initial: None,
            },
            level: None,
            facts: Facts::default(),
        };
        totals.iter().enumerate().map(entry).collect()
    }

    #[test]
    fn the_target_counts_only_for_who_ends_there() {
        assert_eq!(reached(&history(&[9.0, 2.0, 1.0]), 1.0, 2.0), Some(2.0));
        assert_eq!(reached(&history(&[9.0, 2.0, 3.0]), 3.0, 2.0), None);
        assert_eq!(reached(&history(&[9.0, 0.0, 3.0]), 2.0, 2.0), Some(3.0));
        assert_eq!(reached(&[], 1.0, 2.0), None);
    }
}
