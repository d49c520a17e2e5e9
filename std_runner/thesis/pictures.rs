//! Pictures and curves of figures: smoke as a result shows it, planes of numbers, what runs say of their way.

use super::bench::{Halt, at};
use super::truth::{array, read, single};
use crate::keyframes::has_array;
use crate::output::{Body, OutputError, Picture, Smoke, Tone, plate};
use crate::report::{Block, Chart, Curve, Shot, evenly};
use serde_json::Value;
use std::path::Path;

/// Pictures in a row, at most.
const SHOWN: usize = 6;

/// Some of `count` frames, first and last among them.
pub(super) fn some(count: usize) -> Vec<usize> {
    evenly(count, SHOWN).collect()
}

/// Frames of an array of densities.
pub(super) struct Frames<'a> {
    pub archive: &'a Path,
    pub array: &'a str,
    pub cells: &'a [usize],
    /// The density that is drawn brightest.
    pub full: f64,
}

impl Frames<'_> {
    /// The frames `picked`, each with the words that `caption` has for it; the first row's name stands before them.
    pub fn strip(&self, picked: &[usize], caption: impl Fn(usize) -> String) -> Result<Block, Halt> {
        let mut series = array(self.archive, self.array)?;
        let body = self.body()?;
        let shots = picked.iter().map(|&frame| {
            let values = single(&read(&mut series, frame)?);
            shown(
                &caption(frame),
                &Smoke::new(self.cells, values, self.full as f32, body.clone()).photograph(),
            )
        });
        Ok(Block::Strip(shots.collect::<Result<_, Halt>>()?))
    }

    /// The solid cells, where the result has some.
    fn body(&self) -> Result<Option<Body>, Halt> {
        if !has_array(self.archive, "solid") {
            return Ok(None);
        }
        let mut solid = array(self.archive, "solid")?;
        let mut all = Vec::new();
        for plane in 0..solid.count() {
            all.extend(single(&read(&mut solid, plane)?));
        }
        Ok(Body::new(self.cells, &all))
    }
}

/// A picture with its words.
pub(super) fn shown(caption: &str, picture: &Picture) -> Result<Shot, Halt> {
    let png = picture
        .to_png()
        .map_err(OutputError::of(Path::new("thesis.html")))?;
    Ok(Shot {
        caption: caption.into(),
        png,
    })
}

/// Numbers as a picture of `width` across, the last row at the bottom where y goes up.
pub(super) fn plane(
    caption: &str,
    values: &[f64],
    width: usize,
    full: f64,
    tone: Tone,
) -> Result<Shot, Halt> {
    let rows = values.chunks_exact(width.max(1)).rev();
    let scaled: Vec<f32> = rows.flatten().map(|value| (value / full) as f32).collect();
    Ok(Shot {
        caption: caption.into(),
        png: plate(&scaled, width, tone)?,
    })
}

/// A curve of a number of each entry of a history.
pub(super) fn curve(name: &str, colour: usize, history: &[Value], across: &str, key: &str) -> Curve {
    let points = history
        .iter()
        .filter_map(|entry| Some((at(entry, across)?, at(entry, key))));
    Curve::above_zero(name, colour, points)
}

/// Curves of counts, one for each of `runs`; nothing where none has any.
pub(super) fn chart(
    title: &'static str,
    note: &str,
    (across, count): (&'static str, &str),
    key: &str,
    runs: &[(&str, &[Value])],
) -> Option<Chart> {
    let curves = runs.iter().enumerate();
    let curves = curves.map(|(index, (name, history))| curve(name, index % 4 + 1, history, count, key));
    Chart::of_counts(title, note, across, curves.collect())
}

/// The mean of a number over the entries of a history that `counts`.
pub(super) fn mean(history: &[Value], key: &str, counts: impl Fn(usize) -> bool) -> Option<f64> {
    let values: Vec<f64> = history
        .iter()
        .enumerate()
        .filter(|(index, _)| counts(*index))
        .filter_map(|(_, entry)| at(entry, key))
        .collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The last number of that name in a history.
pub(super) fn last(history: &[Value], key: &str) -> Option<f64> {
    history.last().and_then(|entry| at(entry, key))
}
