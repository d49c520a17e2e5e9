//! Figures 3.8 to 3.13: smoke of our own, photographed all around.

use super::super::bench::{Bench, Halt, Made, at};
use super::super::pictures::{Frames, chart, last};
use super::super::plays;
use super::super::sheet::{Row, Sheet};
use super::super::truth::{Capture, Play};
use super::seen::{NEXT, Novel, photographs};
use super::shepp_logan::rig;
use crate::keyframes::Measurements;
use crate::report::{Block, product};
use crate::tomography::Rig;
use std::path::Path;
use std::rc::Rc;

/// Mutations for each cell and camera.
const BUDGET: f64 = 20.0;

/// A reconstruction: its name, its prior, the chains that share its mutations, and what the thesis says.
struct Way {
    name: &'static str,
    folder: &'static str,
    prior: &'static str,
    chains: f64,
    thesis: &'static [(&'static str, &'static str)],
}

/// What is photographed by how many cameras.
struct Stage<'a> {
    whose: &'a str,
    play: Play,
    /// The frame that is reconstructed.
    frame: usize,
    cameras: usize,
    /// Whether a view between the first two cameras is compared with what a camera there saw.
    between: bool,
}

const ACCEPTED: (&str, &str) = ("thesis: accepted, %", "5 to 10");

/// A tube of smoke by 16 cameras.
pub(super) fn figure_8(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let play = plays::tube(bench);
    let stage = Stage {
        whose: "tube",
        frame: play.frames - 1,
        play,
        cameras: 16,
        between: false,
    };
    let ways = [Way {
        name: "SAD, 65000 chains",
        folder: "sad",
        prior: "sad",
        chains: 65_000.0,
        thesis: &[
            ("thesis: seconds a frame", "360"),
            ("thesis: million mutations", "100"),
            ACCEPTED,
        ],
    }];
    bench.stage(sheet, &stage, &ways)
}

/// Smoke by 15 cameras, without a prior.
pub(super) fn figure_10(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let play = plays::smoke(bench);
    let stage = Stage {
        whose: "smoke",
        frame: play.frames / 2,
        play,
        cameras: 15,
        between: false,
    };
    let ways = [
        Way {
            name: "no prior, 10000 chains",
            folder: "long_chains",
            prior: "none",
            chains: 10_000.0,
            thesis: &[
                ("thesis: seconds a frame", "840"),
                ("thesis: million mutations", "200"),
                ACCEPTED,
            ],
        },
        Way {
            name: "no prior, 65000 chains",
            folder: "short_chains",
            prior: "none",
            chains: 65_000.0,
            thesis: &[("thesis: million mutations", "200"), ACCEPTED],
        },
    ];
    bench.stage(sheet, &stage, &ways)
}

/// A bloom of dye.
pub(super) fn figure_12(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let play = plays::bloom(bench);
    let stage = Stage {
        whose: "bloom",
        frame: play.frames / 2,
        play,
        cameras: 15,
        between: false,
    };
    let ways = [Way {
        name: "SAD, 10000 chains",
        folder: "sad",
        prior: "sad",
        chains: 10_000.0,
        thesis: &[
            ("thesis: seconds a frame", "1860"),
            ("thesis: million mutations", "400"),
            ACCEPTED,
        ],
    }];
    bench.stage(sheet, &stage, &ways)
}

/// Few cameras: what a prior is good for.
pub(super) fn figure_13(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let play = plays::bloom(bench);
    let stage = Stage {
        whose: "dye",
        frame: 3 * play.frames / 4,
        play,
        cameras: 5,
        between: true,
    };
    let way = |name, folder, prior| Way {
        name,
        folder,
        prior,
        chains: 10_000.0,
        thesis: &[],
    };
    bench.stage(
        sheet,
        &stage,
        &[
            way("no prior", "none", "none"),
            way("SAD of the volume", "sad", "sad"),
            way("SAD of the view between", "image_sad", "image_sad"),
        ],
    )
}

impl Bench<'_> {
    /// Rows, pictures and curves of a stage.
    fn stage(&mut self, sheet: &mut Sheet, stage: &Stage<'_>, ways: &[Way]) -> Result<(), Halt> {
        let capture = self.capture(&stage.play)?;
        let rig = Rig {
            frames: Some(stage.frame..=stage.frame),
            ..rig(&capture.archive(), "density", stage.cameras)
        };
        let views = self.photograph(&format!("{}/views_{}", stage.whose, stage.cameras), rig.clone())?;
        let novel = match stage.between {
            true => Some(self.between(stage.whose, &views, rig)?),
            false => None,
        };
        let truth = views.folder.join("truth.npz");
        let full = brightest(&truth)?;
        let frames = |archive: &Path, caption: &str| {
            let frames = Frames {
                archive,
                array: "density",
                cells: &capture.cells,
                full,
            };
            frames.strip(&[0], |_| caption.into())
        };
        let mut strips = vec![frames(&truth, "truth")?];
        let (mut seen, mut between, mut runs) = (Vec::new(), Vec::new(), Vec::new());
        for way in ways {
            let made = self.reconstructed(&views, stage, &capture, (way, novel.as_ref()));
            if let Ok(made) = &made {
                strips.push(frames(&made.archive(), way.name)?);
                let first = &views.folder.join("pictures.npz");
                seen.extend(photographs(
                    (first, "camera_0"),
                    (made, "reprojection_0"),
                    seen.is_empty(),
                    way.name,
                )?);
                if let Some(novel) = &novel {
                    let there = (novel.pictures.as_path(), NEXT);
                    between.extend(photographs(
                        there,
                        (made, "novel_0"),
                        between.is_empty(),
                        way.name,
                    )?);
                }
                runs.push((way.name, Rc::clone(made)));
            }
            sheet.row(way.name, made.map(|made| row(stage, &capture, way, full, &made)))?;
        }
        let shots = strips.into_iter().flat_map(|block| match block {
            Block::Strip(shots) => shots,
            _ => Vec::new(),
        });
        sheet.blocks.push(Block::Pictures(shots.collect()));
        sheet
            .blocks
            .push(Block::Part("What the first camera sees".into()));
        sheet.blocks.push(Block::Pictures(seen));
        if !between.is_empty() {
            let part = "What a camera between the first two would see, which measured nothing";
            sheet.blocks.push(Block::Part(part.into()));
            sheet.blocks.push(Block::Pictures(between));
        }
        let runs: Vec<_> = runs.iter().map(|(name, made)| (*name, made.history())).collect();
        let note = "|q - F p| in parts of |q|.";
        let curves = chart(
            "Residual",
            note,
            ("mutations", "mutations"),
            "residual_relative",
            &runs,
        );
        sheet.blocks.push(Block::Charts(curves.into_iter().collect()));
        Ok(())
    }

    fn reconstructed(
        &mut self,
        views: &Made,
        stage: &Stage<'_>,
        capture: &Capture,
        (way, novel): (&Way, Option<&Novel>),
    ) -> Result<Rc<Made>, Halt> {
        let cells = capture.cells.iter().product::<usize>() as f64;
        let budget = (BUDGET * cells * stage.cameras as f64).round();
        let length = (budget / way.chains).round().max(1.0);
        let sets = [
            format!("tomography.prior={}", way.prior),
            format!("tomography.budget={budget:?}"),
            format!("tomography.length={length:.0}"),
            "tomography.tolerance=0.0".into(),
            "tomography.volume=true".into(),
        ];
        let sets: Vec<String> = sets
            .into_iter()
            .chain(novel.map(|novel| novel.assignment.clone()))
            .collect();
        let name = format!("{}/{}_{}", stage.whose, way.folder, stage.cameras);
        self.tomography(&name, &views.folder, &sets)
    }
}

fn row(stage: &Stage<'_>, capture: &Capture, way: &Way, full: f64, made: &Made) -> Row {
    let history = made.history();
    let [mutations, accepted, seconds] = ["mutations", "accepted", "seconds"].map(|key| last(history, key));
    let rate = mutations
        .zip(seconds)
        .map(|(count, seconds)| 1e-6 * count / seconds);
    let part = accepted
        .zip(mutations)
        .map(|(accepted, count)| 100.0 * accepted / count);
    let residual = made
        .list("frames")
        .first()
        .and_then(|frame| at(frame, "residual_relative"));
    let size = format!("{}, {} views", product(&capture.cells), stage.cameras);
    let row = Row::new(way.name, size)
        .with(
            "RMS error, % of the densest",
            made.number("rms_error").map(|error| 100.0 * error / full),
        )
        .with("residual, %", residual.map(|residual| 100.0 * residual));
    let row = match made.list("novel").first() {
        Some(view) => {
            let off = at(view, "relative_error");
            row.with("view between, off by %", off.map(|off| 100.0 * off))
        }
        None => row,
    };
    let row = row
        .with("million mutations", mutations.map(|count| 1e-6 * count))
        .with("million a second", rate)
        .with("accepted, %", part)
        .with("seconds a frame", seconds)
        .of(made);
    way.thesis
        .iter()
        .fold(row, |row, (column, words)| row.thesis(column, words))
}

/// The largest density of the first frame of an archive.
fn brightest(archive: &Path) -> Result<f64, Halt> {
    let read = Measurements::open("truth", archive, Some("density")).and_then(|all| all.read(0));
    let values = read.map_err(super::super::truth::unread)?.values;
    Ok(values.into_iter().fold(f64::MIN_POSITIVE, f64::max))
}
