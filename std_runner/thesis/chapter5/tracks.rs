//! The flow behind a capture by several methods, and its errors.

use super::super::bench::{Bench, Halt, Made};
use super::super::pictures::{Frames, chart, last, mean, some};
use super::super::plays;
use super::super::sheet::{Row, Sheet};
use super::super::truth::Capture;
use crate::report::Block;
use std::rc::Rc;

/// A method of Table 5.1, or ours.
pub(super) struct Way {
    pub name: &'static str,
    folder: &'static str,
    sets: &'static [&'static str],
}

const fn way(name: &'static str, folder: &'static str, sets: &'static [&'static str]) -> Way {
    Way { name, folder, sets }
}

/// Those of the thesis, and ours at the end.
pub(super) const WAYS: [Way; 5] = [
    way("ADMM, full", "admm", &["track.method=admm"]),
    way(
        "ADMM, no kinetic energy",
        "no_kinetic",
        &["track.method=admm", "track.beta=0.0"],
    ),
    way(
        "Horn-Schunck, price of divergence",
        "divergence",
        &["track.method=horn_schunck", "track.gamma=100.0"],
    ),
    way("Horn-Schunck", "horn_schunck", &["track.method=horn_schunck"]),
    way("direct (ours)", "direct", &[]),
];

/// Pairs from which on errors are counted: before, nobody has seen enough.
pub(super) fn counted(pairs: usize) -> impl Fn(usize) -> bool {
    move |pair| pair >= pairs / 3
}

impl Bench<'_> {
    /// A capture tracked by a method.
    pub(super) fn tracked(&mut self, capture: &Capture, whose: &str, way: &Way) -> Result<Rc<Made>, Halt> {
        let sets = way.sets.iter().map(|set| (*set).to_owned());
        let sets: Vec<String> = capture.sets().into_iter().chain(sets).collect();
        self.track(&format!("{whose}/{}", way.folder), &capture.archive(), &sets)
    }
}

/// The errors of a track as a row.
pub(super) fn errors(name: &str, capture: &Capture, made: &Made) -> Row {
    let history = made.history();
    let pairs = counted(capture.frames - 1);
    let row = Row::new(name, capture.size())
        .with("RMS, cells a frame", mean(history, "velocity_rms_error", &pairs))
        .with(
            "in parts of the true flow",
            mean(history, "velocity_relative_error", &pairs),
        )
        .with("angle, degrees", mean(history, "angular_error", &pairs))
        .with("re-advection", last(history, "readvection_error"));
    row.of(made)
}

/// Curves of RMS and angle over frames, of four methods and ours.
pub(super) fn figure_2(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let capture = bench.capture(&plays::smoke(bench))?;
    let mut tracks: Vec<(&str, Rc<Made>)> = Vec::new();
    for way in &WAYS {
        let made = bench.tracked(&capture, "smoke", way);
        sheet.row(
            way.name,
            made.clone().map(|made| errors(way.name, &capture, &made)),
        )?;
        tracks.extend(made.ok().map(|made| (way.name, made)));
    }
    let runs: Vec<_> = tracks
        .iter()
        .map(|(name, made)| (*name, made.history()))
        .collect();
    let frames = ("frame", "frame");
    let charts = [
        chart(
            "RMS error",
            "In cells a frame.",
            frames,
            "velocity_rms_error",
            &runs,
        ),
        chart(
            "Angle",
            "Weighted by the true speed, in degrees.",
            frames,
            "angular_error",
            &runs,
        ),
    ];
    sheet
        .blocks
        .push(Block::Charts(charts.into_iter().flatten().collect()));
    sheet.blocks.push(Block::Part("The capture".into()));
    let frames = Frames {
        archive: &capture.archive(),
        array: "density",
        cells: &capture.cells,
        full: 1.0,
    };
    let picked = some(capture.frames);
    sheet
        .blocks
        .push(frames.strip(&picked, |frame| format!("frame {frame}"))?);
    Ok(())
}
