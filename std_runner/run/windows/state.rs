//! The state of windows in a checkpoint: what is remembered as words, what is kept of all steps in files of its own, what the last window left.

use super::kept::Kept;
use super::walk::{Inside, Walk};
use crate::checkpoint::{Keeper, Saving, Words, is_state_or_lock};
use crate::exit::Failure;
use crate::output::{Sample, Samples, Series};
use crate::progress::Watch;
use crate::remarks::KeyframeError;
use crate::run::saved::{Progressed, Reading};
use crate::run::stages::Stage;
use crate::stay::Stay;
use core::mem::MaybeUninit;
use std::io;
use std::time::Instant;
use thurible_core::checkpoint::{Damaged, Refused};
use thurible_core::{Output, Real, Space};

/// The files of fields: name, numbers of a field, fields, and a word of all their bits.
type Files = Vec<(String, (usize, usize, u64))>;

const NO_ERROR: KeyframeError = KeyframeError {
    stay: Stay { first: 0, last: 0 },
    before: 0.0,
    after: 0.0,
    denser: 0.0,
};

/// The files of what is kept, and the sizes of what is left.
type InFiles<'a> = (&'a mut Files, &'a mut Vec<(usize, usize)>);

impl Walk<'_> {
    /// Passes over all that is remembered; what of it is in files is left to the caller.
    fn record(
        &mut self,
        words: &mut Words,
        watch: &mut Watch,
        (files, left): InFiles<'_>,
    ) -> Result<(), Damaged> {
        words.count(&mut self.number)?;
        words.real(&mut self.nested)?;
        words.named(&mut self.ended)?;
        words.flag(&mut self.over)?;
        words.option(&mut self.inside, |words, inside| {
            words.flag(&mut inside.aimed)?;
            words.flag(&mut inside.continued)?;
            words.real(&mut inside.second)?;
            words.count(&mut inside.iteration)
        })?;
        words.option(&mut self.masses, Words::reals)?;
        self.sum.record(words)?;
        self.kept.record(words, files, self.over)?;
        self.left.record(words, left)?;
        let mut so_far = Progressed {
            mass_factors: core::mem::take(&mut self.mass_factors),
            ended: None,
        };
        let recorded = so_far.record(words, watch);
        self.mass_factors = so_far.mass_factors;
        recorded?;
        if self.is_of_the_scene(watch.history.len()) {
            Ok(())
        } else {
            Err(Damaged)
        }
    }

    /// Whether the windows so far, and the one under way, can be those of the scene after so many iterations.
    fn is_of_the_scene(&self, iterations: usize) -> bool {
        let windows = self.job.planned.windows();
        let so_far = &self.sum.windows;
        let are_its = so_far
            .iter()
            .zip(&windows)
            .all(|(record, window)| (record.start, record.steps) == (window.start, window.steps));
        let is_inside = |inside: Inside| self.number < windows.len() && inside.iteration <= iterations;
        self.number == so_far.len()
            && self.number <= windows.len()
            && are_its
            && self.inside.is_none_or(is_inside)
    }

    /// What is remembered now, its files synced; `None` where they cannot be.
    pub(super) fn words(&mut self, watch: &mut Watch) -> Option<Words> {
        self.kept.sync().ok()?;
        let mut words = Words::default();
        let recorded = self.record(&mut words, watch, (&mut Vec::new(), &mut Vec::new()));
        recorded.ok().map(|()| words)
    }

    /// Writes what the last window left into a checkpoint.
    pub(super) fn write(&mut self, saving: &mut Saving<'_>) -> Result<(), Refused> {
        self.left.write(saving.file)
    }

    /// Keeps the state, with what `solver` adds of a window that is under way.
    pub(super) fn keep(
        &mut self,
        watch: &mut Watch,
        keeper: &mut Keeper,
        solver: &mut dyn FnMut(&mut Saving<'_>) -> Result<(), Refused>,
    ) {
        if let Some(words) = self.words(watch) {
            keeper.keep(Instant::now(), watch, &words, &mut |saving| {
                self.write(saving)?;
                solver(saving)
            });
        }
    }

    /// Goes on from a state, but for the solver of a window that was under way.
    pub(super) fn go_on<T: Real + Sample, S: Space>(
        &mut self,
        block: &mut [MaybeUninit<u8>],
        reading: &mut Reading<'_>,
        watch: &mut Watch,
    ) -> Result<(), Failure> {
        let (mut files, mut left) = (Vec::new(), Vec::new());
        let recorded = self.record(&mut reading.words, watch, (&mut files, &mut left));
        recorded
            .and_then(|()| reading.words.end())
            .map_err(|Damaged| reading.damaged())?;
        // The solver of the last window says what there is of it.
        let windows = self.job.planned.windows();
        let last = windows.get(self.number.saturating_sub(1));
        let last = last.ok_or_else(|| reading.damaged())?;
        let stage = Stage::Window(self.number.saturating_sub(1), true);
        let outputs = self.job.lead::<T, S>(stage, block)?.0.outputs();
        let there = self.kept.go_on(files, outputs)?;
        there.ok_or_else(|| reading.damaged())?;
        let taken = self.left.go_on(&mut reading.file, &left, last.steps);
        taken.map_err(|error| error.map_or_else(|| reading.damaged(), Failure::from))
    }
}

impl Kept {
    /// Passes over all but the fields themselves, which stay in their files; whether all windows are over.
    fn record(&mut self, words: &mut Words, files: &mut Files, over: bool) -> Result<(), Damaged> {
        if !words.reads() {
            let states = self
                .series
                .iter()
                .map(|(name, series)| (name.clone(), series.state()));
            *files = states.collect();
        }
        words.list(
            files,
            Default::default(),
            |words, (name, (len, count, digest))| {
                words.text(name)?;
                words.count(len)?;
                words.count(count)?;
                words.word(digest)
            },
        )?;
        words.list(&mut self.errors, NO_ERROR, |words, error| {
            words.count(&mut error.stay.first)?;
            words.count(&mut error.stay.last)?;
            let numbers = [&mut error.before, &mut error.after, &mut error.denser];
            numbers.into_iter().try_for_each(|number| words.real(number))
        })?;
        words.real(&mut self.emitted)?;
        words.reals(&mut self.factors)?;
        let problem = &mut self.problem;
        let whole = (problem.steps, problem.release);
        let all = [problem.keyframes.len(), problem.keyframe_weights.len()];
        let mut lengths = all;
        words.count(&mut problem.steps)?;
        words.option(&mut problem.release, Words::count)?;
        lengths.iter_mut().try_for_each(|length| words.count(length))?;
        let is_whole = (problem.steps, problem.release) == whole && lengths == all;
        // A solve that was stopped has fewer steps, and may end before its release.
        let is_part = (2..=whole.0).contains(&problem.steps)
            && problem.release.is_none_or(|_| problem.release == whole.1);
        if !(is_whole || over && is_part) || self.errors.len() > lengths[0] {
            return Err(Damaged);
        }
        problem.keyframes.truncate(lengths[0]);
        problem.keyframe_weights.truncate(lengths[1]);
        Ok(())
    }

    /// Makes sure that all fields are on the disc.
    fn sync(&self) -> io::Result<()> {
        self.series.values().try_for_each(Series::sync)
    }

    /// Goes on with the `files` of an earlier run, and the `outputs` that they are of. `None` if one is not what it was.
    fn go_on(&mut self, files: Files, outputs: &'static [Output]) -> Result<Option<()>, Failure> {
        self.outputs = outputs;
        // Each once, as the map has them; one that leads elsewhere, or to a state, is none of them, and there are no more fields than frames.
        let ascend = files.iter().is_sorted_by(|(one, _), (next, _)| one < next);
        let is_ours = |name: &str| !is_state_or_lock(name) && !name.contains(['/', '\\']);
        let most = self.problem.steps.saturating_add(1);
        let are_ours = files
            .iter()
            .all(|(name, (_, count, _))| is_ours(name) && (1..=most).contains(count));
        if !(ascend && are_ours) {
            return Ok(None);
        }
        for (name, state) in files {
            let mut samples = Samples::new(self.precision);
            let series = Series::go_on(&self.scratch.file(&name), state, &mut samples);
            let Some(series) = series? else {
                return Ok(None);
            };
            self.series.insert(name, series);
        }
        Ok(Some(()))
    }
}
