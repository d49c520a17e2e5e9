//! Figures 5.8 to 5.10: captured smoke that meets a new ball, and smoke that is stirred with and without guidance.

use super::super::bench::{Bench, Halt, Made, at};
use super::super::doors::Free;
use super::super::fields::{blurred, faces};
use super::super::pictures::{Frames, chart, mean};
use super::super::plays;
use super::super::sheet::{Row, Sheet};
use super::super::truth::{Capture, open, read, size};
use crate::flows::Deed;
use crate::keyframes::VELOCITY;
use crate::output::write_bytes;
use crate::report::{Block, evenly};
use std::path::Path;
use std::rc::Rc;

/// Pictures in a row.
const SHOWN: usize = 5;
/// The frame from which on things change, in parts of all.
const FROM: f64 = 0.25;

/// A capture whose smoke is changed from a frame on.
struct Change {
    capture: Capture,
    track: Rc<Made>,
    begin: usize,
    steps: usize,
}

impl Change {
    fn of(bench: &mut Bench<'_>) -> Result<Self, Halt> {
        let (capture, track) = bench.known(&plays::smoke(bench))?;
        let begin = (FROM * capture.frames as f64) as usize;
        Ok(Self {
            steps: capture.frames - 2 - begin,
            capture,
            track,
            begin,
        })
    }

    /// A ball that the smoke rises against.
    fn ball(&self) -> String {
        let side =
            |axis: usize| self.capture.cells.get(axis).copied().unwrap_or(1) as f64 * self.capture.cell();
        plays::solid_ball([0.52 * side(0), 0.5 * side(1), 0.56 * side(2)], 0.17 * side(0))
    }

    fn scene(&self, tables: &str) -> String {
        self.capture.scene(self.steps, tables)
    }

    /// A row of pictures of `count` frames of an archive, the first of which is `first` of the capture.
    fn strip(&self, archive: &Path, array: &str, name: &str, first: usize) -> Result<Block, Halt> {
        let frames = Frames {
            archive,
            array,
            cells: &self.capture.cells,
            full: 1.0,
        };
        let shift = self.begin - first;
        let picked: Vec<usize> = evenly(self.steps + 1, SHOWN).map(|step| step + shift).collect();
        frames.strip(&picked, |frame| format!("{name}, frame {}", frame + first))
    }

    fn captured(&self) -> Result<Block, Halt> {
        self.strip(&self.capture.archive(), "density", "captured", 0)
    }

    fn size(&self) -> String {
        size(&self.capture.cells, self.steps)
    }
}

/// Simulated on with a new ball in the way.
pub(super) fn figure_8(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let change = Change::of(bench)?;
    sheet.blocks.push(change.captured()?);
    for (name, folder, tables) in [
        ("simulated on, as it was", "smoke/restarted", String::new()),
        (
            "simulated on, with a ball",
            "smoke/restarted_with_a_ball",
            change.ball(),
        ),
    ] {
        let free = Free {
            text: change.scene(&tables),
            beside: &change.track.folder,
            from: Some((&change.track.folder, change.begin)),
            reference: None,
        };
        let made = bench.simulate(folder, &free);
        if let Ok(made) = &made {
            sheet
                .blocks
                .push(change.strip(&made.archive(), "density", name, change.begin)?);
        }
        sheet.row(name, made.map(|made| off(name, &change, &made)))?;
    }
    Ok(())
}

/// How far the smoke of a run is from the captured one.
fn off(name: &str, change: &Change, made: &Made) -> Row {
    let frames = made.list("frames");
    let after = |step: usize| frames.get(step).and_then(|frame| at(frame, "relative_l2"));
    Row::new(name, change.size())
        .with(
            "off the captured smoke at half of the frames",
            after((frames.len() / 2).saturating_sub(1)),
        )
        .with("at the end", after(frames.len().saturating_sub(1)))
        .of(made)
}

/// The captured flow put round the ball, which keeps it where there is smoke, or alike everywhere.
pub(super) fn figure_9(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let change = Change::of(bench)?;
    let text = change.scene(&change.ball());
    let scene = bench.files("smoke/ball", &["ball.toml"], |folder| {
        write_bytes(&folder.join("ball.toml"), text.as_bytes())
    })?;
    sheet.blocks.push(change.captured()?);
    for (name, folder, weighted) in [
        ("remapped, by importance", "smoke/remapped", true),
        ("remapped, alike everywhere", "smoke/remapped_plain", false),
    ] {
        let deed = Deed::Remap {
            solid: scene.folder.join("ball.toml"),
            weighted,
            smoothness: 0.0,
        };
        let made = bench.take(folder, (&change.track.folder, change.begin), deed);
        if let Ok(made) = &made {
            sheet
                .blocks
                .push(change.strip(&made.archive(), "density", name, change.begin)?);
        }
        let row = made.map(|made| {
            let changed = |which: usize| {
                let steps = made
                    .history()
                    .iter()
                    .filter_map(|step| step.get("changed")?.get(which)?.as_f64());
                let all: Vec<f64> = steps.collect();
                (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
            };
            Row::new(name, change.size())
                .with(
                    "change of the flow in parts of it, where there is smoke",
                    changed(1),
                )
                .with("everywhere", changed(0))
                .of(&made)
        });
        sheet.row(name, row)?;
    }
    Ok(())
}

/// Waves as fine as the smoke's edges, others every few steps.
fn noise(change: &Change) -> String {
    let cell = change.capture.cell();
    let middle: Vec<f64> = change
        .capture
        .cells
        .iter()
        .map(|&count| 0.5 * cell * count as f64)
        .collect();
    let last = change.steps;
    let each = last.div_ceil(6).max(1);
    let one = |(seed, from): (usize, usize)| {
        format!(
            "[[template]]\nkind = \"noise\"\ncenter = {middle:?}\nradius = {:?}\nsize = {:?}\nseed = {seed}\nfrom = {from}\nto = {}\namplitude = {:?}\n",
            4.0 * change.capture.length,
            4.0 * cell,
            (from + each).min(last),
            NOISE * change.capture.length
        )
    };
    (0..last.saturating_sub(1))
        .step_by(each)
        .enumerate()
        .map(one)
        .collect()
}

/// Acceleration by the noise, in boxes and steps of the truth: about a quarter of the speed of rising smoke comes of it.
const NOISE: f64 = 2e-5;
/// The radius of the guidance, in cells.
const RADIUS: f64 = 2.0;

/// A resimulation that is stirred by curl noise, free and guided.
pub(super) fn figure_10(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let change = Change::of(bench)?;
    sheet.blocks.push(change.captured()?);
    let guide = format!("[method.guide]\nradius = {RADIUS:?}\nsmoothness = 0.001\nkinetic = 0.0\n");
    let from = (change.track.folder.as_path(), change.begin);
    let mut runs = Vec::new();
    for (name, folder, tables, reference) in [
        ("simulated on", "smoke/restarted", String::new(), None),
        ("curl noise, free", "smoke/noisy", noise(&change), None),
        (
            "curl noise, guided",
            "smoke/noisy_guided",
            noise(&change) + &guide,
            Some(from),
        ),
    ] {
        let free = Free {
            text: change.scene(&tables),
            beside: &change.track.folder,
            from: Some(from),
            reference,
        };
        let made = bench.simulate(folder, &free);
        if let Ok(made) = &made {
            sheet
                .blocks
                .push(change.strip(&made.archive(), "density", name, change.begin)?);
            runs.push((name, Rc::clone(made)));
        }
        let row = made.and_then(|made| {
            let [low, high] = bands(&change, &made)?;
            let frames = made.list("frames");
            Ok(Row::new(name, change.size())
                .with("low band off the reference", Some(low))
                .with("high band, in parts of the reference's", Some(high))
                .with("smoke off, mean", mean(frames, "relative_l2", |_| true))
                .of(&made))
        });
        sheet.row(name, row)?;
    }
    let runs: Vec<_> = runs
        .iter()
        .map(|(name, made)| (*name, made.list("frames")))
        .collect();
    let note = "Distance from the captured frame, in parts of it.";
    let curves = chart("Smoke", note, ("frames since", "step"), "relative_l2", &runs);
    sheet.blocks.push(Block::Charts(curves.into_iter().collect()));
    Ok(())
}

/// How far what is larger than the guidance's radius is from the reference's in the last flow, in parts of that; and what is smaller, in parts
/// of what that has.
fn bands(change: &Change, made: &Made) -> Result<[f64; 2], Halt> {
    let cells = &change.capture.cells;
    let mut sums = [0.0; 4];
    for (axis, name) in VELOCITY.iter().enumerate().take(cells.len()) {
        let step = change.steps - 1;
        let ours = read(&mut open(made, name)?, step)?;
        let theirs = read(&mut open(&change.track, name)?, change.begin + step)?;
        let counts = faces(cells, axis);
        let [low, other] = [&ours, &theirs].map(|values| blurred(values, &counts, RADIUS));
        for (((ours, theirs), low), other) in ours.iter().zip(&theirs).zip(&low).zip(&other) {
            let parts = [low - other, *other, ours - low, theirs - other];
            sums.iter_mut()
                .zip(parts)
                .for_each(|(sum, part)| *sum += part * part);
        }
    }
    let part = |above: f64, below: f64| (above / below.max(f64::MIN_POSITIVE)).sqrt();
    Ok([part(sums[0], sums[1]), part(sums[2], sums[3])])
}
