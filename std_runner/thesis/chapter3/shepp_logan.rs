//! Figure 3.7: a phantom from 16 views.

use super::super::bench::{Bench, Halt, Made};
use super::super::pictures::{last, plane};
use super::super::sheet::{Row, Sheet};
use super::super::truth::{open, read};
use super::phantom::phantom;
use crate::output::Tone;
use crate::quoted::Scale;
use crate::report::{Block, product};
use crate::tomography::Rig;
use std::path::Path;

/// Cells along a side.
const SIDE: usize = 256;
const VIEWS: usize = 16;

/// How it is reconstructed, and the thesis' RMS error.
struct Way {
    name: &'static str,
    folder: &'static str,
    sets: &'static [&'static str],
    /// Of the prior, at the full size; it is in proportion to the side.
    gamma: f64,
    thesis: Option<&'static str>,
}

const SIGNED: &str = "tomography.nonnegative=false";
const WAYS: [Way; 6] = [
    Way {
        name: "SART",
        folder: "sart",
        sets: &["tomography.method=sart", "tomography.sweeps=30"],
        gamma: 0.0,
        thesis: Some("0.104"),
    },
    Way {
        name: "walk",
        folder: "walk",
        sets: &["tomography.prior=none", SIGNED],
        gamma: 0.0,
        thesis: Some("0.090"),
    },
    Way {
        name: "walk, L2",
        folder: "l2",
        sets: &["tomography.prior=l2", SIGNED],
        gamma: 0.4,
        thesis: Some("0.085"),
    },
    Way {
        name: "walk, TV",
        folder: "tv",
        sets: &["tomography.prior=tv", SIGNED],
        gamma: 1.0,
        thesis: Some("0.085"),
    },
    Way {
        name: "walk, SAD",
        folder: "sad",
        sets: &["tomography.prior=sad", SIGNED],
        gamma: 0.3,
        thesis: Some("0.080"),
    },
    Way {
        name: "walk, SAD, p >= 0 (ours)",
        folder: "sad_nonnegative",
        sets: &["tomography.prior=sad"],
        gamma: 0.3,
        thesis: None,
    },
];

/// What cameras all around are told of a result.
pub(super) fn rig(result: &Path, array: &str, views: usize) -> Rig {
    Rig {
        result: result.to_owned(),
        array: array.into(),
        views,
        folder: Default::default(),
        pinhole: false,
        elevation: None,
        size: None,
        frames: None,
        noise: 0.0,
        seed: 1,
        force: true,
    }
}

/// RMS errors of SART and of the walk with several priors, beside the thesis'.
pub(super) fn figure_7(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let cells = bench.cells(&[SIDE, SIDE]);
    let side = cells.first().copied().unwrap_or(SIDE);
    let truth = phantom(side);
    let counts = [side, side, 1];
    let file = bench.write_arrays("phantom/truth", "phantom.npz", &[("density", &counts, &truth)])?;
    let views = rig(&file.folder.join("phantom.npz"), "density", VIEWS);
    let views = bench.photograph("phantom/views", views)?;
    let mut shots = vec![plane("truth", &truth, side, SHADE, Tone::Light)?];
    let part = (side * side) as f64 / (SIDE * SIDE) as f64;
    for way in &WAYS {
        let made = run(bench, &views, way, part);
        if let Ok(made) = &made {
            let found = read(&mut open(made, "density")?, 0)?;
            shots.push(plane(way.name, &found, side, SHADE, Tone::Light)?);
        }
        let row = made.map(|made| row(way, &made, &cells, bench.scale));
        sheet.row(way.name, row)?;
    }
    sheet.blocks.push(Block::Pictures(shots));
    Ok(())
}

/// The brightest value that is told from brighter ones: the skull is 1, and what matters is inside.
const SHADE: f64 = 0.6;

fn run(bench: &mut Bench<'_>, views: &Made, way: &Way, part: f64) -> Result<std::rc::Rc<Made>, Halt> {
    let mut sets: Vec<String> = way.sets.iter().map(|set| (*set).to_owned()).collect();
    sets.push(format!("tomography.gamma={:?}", way.gamma * part.sqrt()));
    sets.push(format!("tomography.budget={:?}", (1e7 * part).round()));
    sets.push("tomography.tolerance=0.0".into());
    bench.tomography(&format!("phantom/{}", way.folder), &views.folder, &sets)
}

fn row(way: &Way, made: &Made, cells: &[usize], scale: Scale) -> Row {
    let history = made.history();
    let best = history
        .iter()
        .filter_map(|entry| super::super::bench::at(entry, "rms_error"));
    let best = best.reduce(f64::min);
    let error = made.number("rms_error");
    let row = Row::new(way.name, format!("{}, {VIEWS} views", product(cells)))
        .with("RMS error", error)
        .with("the least on the way", best)
        .of(made);
    let mutations = last(history, "mutations").map(|count| count * 1e-6);
    let walks = way.gamma > 0.0 || way.name == "walk";
    let row = if walks {
        row.with("million mutations", mutations)
    } else {
        row
    };
    let Some(thesis) = way.thesis else { return row };
    let row = row
        .thesis("thesis: RMS error", thesis)
        .thesis("thesis: seconds", "47 to 55");
    let worse = thesis
        .parse()
        .ok()
        .zip(error)
        .filter(|(theirs, ours): &(f64, f64)| ours > theirs);
    match worse {
        Some(_) if scale.divisor() == 1 => row.fail(format!("above the thesis' {thesis}")),
        _ => row,
    }
}
