//! Figure 5.3: a capture at half its size, blurred before, whose smoke goes round a ball.

use super::super::bench::{Bench, Halt, Made};
use super::super::fields::{blurred, half_of_cells, half_of_faces};
use super::super::pictures::{Frames, chart, mean, some};
use super::super::plays;
use super::super::sheet::{Row, Sheet};
use super::super::truth::{Capture, Film, array, flow, read};
use super::tracks::{WAYS, Way, counted};
use crate::report::Block;
use std::rc::Rc;

/// Blurs before a frame is made smaller, in cells, and their folders.
const BLURS: [(f64, &str, &str); 3] = [
    (0.0, "half", "half size"),
    (0.5, "half_blurred", "half size, blur 0.5"),
    (1.0, "half_very_blurred", "half size, blur 1"),
];

/// Native and half size.
pub(super) fn figure_3(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let capture = bench.capture(&plays::ball(bench))?;
    let [way, .., ours] = &WAYS;
    let mut runs: Vec<(&str, Rc<Made>)> = Vec::new();
    let mut take = |sheet: &mut Sheet, name, made: Result<(Capture, Rc<Made>), Halt>, size| {
        let row = made.map(|(capture, made)| {
            let row = errors(name, &capture, &made, size);
            runs.push((name, made));
            row
        });
        sheet.row(name, row)
    };
    let native = bench.tracked(&capture, "ball", way);
    take(
        sheet,
        "native, ADMM",
        native.map(|made| (capture.clone(), made)),
        1.0,
    )?;
    let direct = bench.tracked(&capture, "ball", ours);
    take(
        sheet,
        "native, direct (ours)",
        direct.map(|made| (capture.clone(), made)),
        1.0,
    )?;
    for (blur, folder, name) in BLURS {
        let made = bench.halved(&capture, blur, folder, way);
        take(sheet, name, made, 2.0)?;
    }
    let runs: Vec<_> = runs.iter().map(|(name, made)| (*name, made.history())).collect();
    let frames = ("frame", "frame");
    let note = "In parts of the true flow of the same size.";
    let charts = [
        chart("Error", note, frames, "velocity_relative_error", &runs),
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
    let strip = Frames {
        archive: &capture.archive(),
        array: "density",
        cells: &capture.cells,
        full: 1.0,
    };
    sheet
        .blocks
        .push(strip.strip(&some(capture.frames), |frame| format!("frame {frame}"))?);
    Ok(())
}

/// Errors in native cells, of frames that are `times` smaller.
fn errors(name: &str, capture: &Capture, made: &Made, times: f64) -> Row {
    let (history, pairs) = (made.history(), counted(capture.frames - 1));
    let rms = mean(history, "velocity_rms_error", &pairs).map(|error| times * error);
    let late = mean(history, "velocity_rms_error", |pair| pair + 10 >= history.len());
    let row = Row::new(name, capture.size())
        .with("RMS, native cells a frame", rms)
        .with(
            "in parts of the true flow",
            mean(history, "velocity_relative_error", &pairs),
        )
        .with("angle, degrees", mean(history, "angular_error", &pairs))
        .with("RMS of the last ten pairs", late.map(|error| times * error));
    row.of(made)
}

impl Bench<'_> {
    /// A capture on half as many cells along every axis, blurred before, and its track.
    fn halved(
        &mut self,
        capture: &Capture,
        blur: f64,
        folder: &str,
        way: &Way,
    ) -> Result<(Capture, Rc<Made>), Halt> {
        let cells: Vec<usize> = capture.cells.iter().map(|count| count / 2).collect();
        let made = self.once(&format!("ball/{folder}/truth"), |_, folder| {
            let mut film = Film::begin(&cells, folder)?;
            let archive = capture.archive();
            let mut density = array(&archive, "density")?;
            let mut flow = flow(&archive)?;
            for frame in 0..capture.frames {
                let values = blurred(&read(&mut density, frame)?, &capture.cells, blur);
                let mut halves = Vec::new();
                if frame + 1 < capture.frames {
                    for (axis, series) in flow.iter_mut().enumerate() {
                        halves.push(half_of_faces(&read(series, frame)?, &capture.cells, axis));
                    }
                }
                film.push(&half_of_cells(&values, &capture.cells), &halves)?;
            }
            film.end()
        })?;
        let half = Capture {
            made,
            cells,
            ..capture.clone()
        };
        let track = self.tracked(&half, &format!("ball/{folder}"), way)?;
        Ok((half, track))
    }
}
