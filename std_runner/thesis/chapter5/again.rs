//! Figures 5.4 to 5.7: captured smoke carried again by its flow, simulated on, carried on finer cells.

use super::super::bench::{Bench, Halt, Made, at};
use super::super::doors::Free;
use super::super::pictures::{Frames, chart, last, some};
use super::super::plays;
use super::super::sheet::{Row, Sheet};
use super::super::truth::{Capture, Play, size};
use super::tracks::{WAYS, Way};
use crate::flows::Deed;
use crate::report::Block;
use std::rc::Rc;
use thurible_core::Turbulence;

/// Frames between two beginnings of figure 5.5, and how long it is simulated on from each.
const EVERY: usize = 10;
const STEPS: usize = 10;

/// The methods of figure 5.4, among all.
const CARRIED: [usize; 4] = [3, 2, 0, 4];

/// The first frame, carried by the flows of several methods.
pub(super) fn figure_4(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let capture = bench.capture(&plays::smoke(bench))?;
    let picked = some(capture.frames);
    let archive = capture.archive();
    let strip = |archive: &std::path::Path, name: &str| {
        let frames = Frames {
            archive,
            array: "density",
            cells: &capture.cells,
            full: 1.0,
        };
        frames.strip(&picked, |frame| format!("{name}, frame {frame}"))
    };
    let (mut strips, mut runs) = (vec![strip(&archive, "captured")?], Vec::new());
    for way in CARRIED.into_iter().filter_map(|which| WAYS.get(which)) {
        let made = bench.tracked(&capture, "smoke", way);
        if let Ok(made) = &made {
            strips.push(strip(&made.archive(), way.name)?);
            runs.push((way.name, Rc::clone(made)));
        }
        let row = made.map(|made| {
            let half = made
                .history()
                .get((capture.frames / 2).saturating_sub(1))
                .and_then(|pair| at(pair, "readvection_error"));
            Row::new(way.name, capture.size())
                .with("off at half of the frames", half)
                .with("off at the end", last(made.history(), "readvection_error"))
                .of(&made)
        });
        sheet.row(way.name, row)?;
    }
    sheet.blocks.extend(strips);
    let runs: Vec<_> = runs.iter().map(|(name, made)| (*name, made.history())).collect();
    let note = "Distance from the captured frame, in parts of it.";
    let curves = chart(
        "Re-advection",
        note,
        ("frame", "frame"),
        "readvection_error",
        &runs,
    );
    sheet.blocks.push(Block::Charts(curves.into_iter().collect()));
    Ok(())
}

impl Bench<'_> {
    /// A capture of `play` tracked by our own method.
    pub(super) fn known(&mut self, play: &Play) -> Result<(Capture, Rc<Made>), Halt> {
        let capture = self.capture(play)?;
        let [.., ours]: &[Way; 5] = &WAYS;
        let made = self.tracked(&capture, play.name, ours)?;
        Ok((capture, made))
    }
}

/// Simulated on from the state of every tenth frame.
pub(super) fn figure_5(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let mut charts = Vec::new();
    for play in [plays::bloom(bench), plays::smoke(bench)] {
        let (capture, track) = bench.known(&play)?;
        let mut runs = Vec::new();
        let begins = (EVERY..capture.frames - STEPS).step_by(EVERY);
        for begin in begins {
            let name = format!("{} from frame {begin}", play.name);
            let free = Free {
                text: capture.scene(STEPS, ""),
                beside: &track.folder,
                from: Some((&track.folder, begin)),
                reference: None,
            };
            let made = bench.simulate(&format!("{}/resimulated_{begin}", play.name), &free);
            if let Ok(made) = &made {
                runs.push((name.clone(), Rc::clone(made)));
            }
            let row = made.map(|made| {
                let after = |step: usize| {
                    made.list("frames")
                        .get(step - 1)
                        .and_then(|frame| at(frame, "relative_l2"))
                };
                Row::new(&name, size(&capture.cells, STEPS))
                    .with("off after 1 frame", after(1))
                    .with("after 5", after(STEPS / 2))
                    .with("after 10", after(STEPS))
                    .of(&made)
            });
            sheet.row(&name, row)?;
        }
        let runs: Vec<_> = runs
            .iter()
            .map(|(name, made)| (name.as_str(), made.list("frames")))
            .collect();
        let title = if play.name == "bloom" { "Bloom" } else { "Smoke" };
        let note = "Distance from the captured frame, in parts of it.";
        charts.extend(chart(title, note, ("frames since", "step"), "relative_l2", &runs));
    }
    sheet.blocks.push(Block::Charts(charts));
    Ok(())
}

/// Smoke on finer cells.
pub(super) fn figure_6(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    finer(bench, sheet, &plays::smoke(bench), [16, 28, 40, 52])
}

/// The bloom on finer cells.
pub(super) fn figure_7(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    finer(bench, sheet, &plays::bloom(bench), [10, 20, 30, 38])
}

/// Captured frames, and the first one carried on cells as they are, twice as fine, and those with turbulence.
fn finer(bench: &mut Bench<'_>, sheet: &mut Sheet, play: &Play, picked: [usize; 4]) -> Result<(), Halt> {
    let capture = bench.capture(play)?;
    // The weights of the thesis' own captures.
    let sets = ["track.alpha=0.005", "track.beta=2.5"].map(str::to_owned);
    let sets: Vec<String> = capture.sets().into_iter().chain(sets).collect();
    let track = bench.track(&format!("{}/captured", play.name), &capture.archive(), &sets)?;
    let strip = |archive: &std::path::Path, cells: &[usize], name: &str| {
        let frames = Frames {
            archive,
            array: "density",
            cells,
            full: 1.0,
        };
        frames.strip(&picked, |frame| format!("{name}, frame {frame}"))
    };
    sheet
        .blocks
        .push(strip(&capture.archive(), &capture.cells, "captured")?);
    let turbulent = Deed::Upsample {
        factor: 2,
        turbulence: Turbulence {
            strength: 1.0,
            seed: 1,
        },
    };
    let deeds = [
        ("re-advection", "carried", Deed::Readvect { scale: 1 }),
        (
            "re-advection on cells twice as fine",
            "finer",
            Deed::Readvect { scale: 2 },
        ),
        ("the same with synthetic turbulence", "turbulent", turbulent),
    ];
    for (name, folder, deed) in deeds {
        let folder = format!("{}/{folder}", play.name);
        let made = bench.take(&folder, (&track.folder, 0), deed);
        if let Ok(made) = &made {
            sheet.blocks.push(strip(&made.archive(), &made.cells(), name)?);
        }
        let row = made.map(|made| {
            let half = made
                .history()
                .get((capture.frames / 2).saturating_sub(1))
                .and_then(|step| at(step, "relative_l2"));
            Row::new(name, size(&made.cells(), capture.frames))
                .with("off at half of the frames", half)
                .with("off at the end", last(made.history(), "relative_l2"))
                .of(&made)
        });
        sheet.row(name, row)?;
    }
    Ok(())
}
