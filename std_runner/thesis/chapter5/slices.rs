//! Figure 5.1: the flow in the middle of the box, and how far it is from the true one.

use super::super::bench::{Bench, Halt};
use super::super::pictures::shown;
use super::super::plays;
use super::super::sheet::{Row, Sheet};
use super::super::truth::{Capture, flow};
use super::tracks::{WAYS, errors};
use crate::output::{Tone, plate};
use crate::report::{Block, Shot, number};
use crate::track::{Middle, Plane, wheel};
use std::path::Path;
use thurible_core::Boundary;

/// The methods of the figure, among all.
const SHOWN: [usize; 4] = [0, 1, 3, 4];

/// Direction, error and angle of several methods in a slice.
pub(super) fn figure_1(bench: &mut Bench<'_>, sheet: &mut Sheet) -> Result<(), Halt> {
    let capture = bench.capture(&plays::smoke(bench))?;
    let pair = 3 * (capture.frames - 1) / 4;
    let middle = Middle {
        cells: &capture.cells,
        boundary: &[Boundary::Wall; 3],
        unit: capture.unit(),
    };
    let plane = |archive: &Path| Ok(middle.plane(&mut flow(archive)?, pair));
    let truth = plane(&capture.archive())?;
    let fastest = truth.fastest();
    let mut directions = vec![shown("true flow", &truth.picture(fastest))?];
    let (mut gaps, mut angles) = (Vec::new(), Vec::new());
    for way in SHOWN.into_iter().filter_map(|which| WAYS.get(which)) {
        let made = bench.tracked(&capture, "smoke", way);
        let row = made.and_then(|made| {
            let found: Result<Plane, Halt> = plane(&made.archive());
            let found = found?;
            directions.push(shown(way.name, &found.picture(fastest))?);
            gaps.push(map(way.name, &found, &truth, |gap, _| gap / 0.6)?);
            angles.push(map(way.name, &found, &truth, |_, angle| angle / 90.0)?);
            Ok(in_slice(errors(way.name, &capture, &made), &found, &truth))
        });
        sheet.row(way.name, row)?;
    }
    let rim = format!("the rim is {} cells a frame", number(f64::from(fastest)));
    directions.push(shown(&rim, &wheel())?);
    let blocks = [
        (
            format!("Direction and speed in the middle plane, pair {pair}"),
            directions,
        ),
        ("Error, white at 0.6 cells a frame".into(), gaps),
        ("Angle, white at 90 degrees".into(), angles),
    ];
    for (title, shots) in blocks {
        sheet.blocks.push(Block::Part(title));
        sheet.blocks.push(Block::Pictures(shots));
    }
    Ok(())
}

/// The distance of a flow from the true one, in cells a frame, and the angle between them in degrees.
fn apart([x, y]: [f32; 2], [u, v]: [f32; 2]) -> (f32, f32) {
    let angle = if x.hypot(y) == 0.0 {
        90.0
    } else {
        (x * v - y * u).abs().atan2(x * u + y * v).to_degrees()
    };
    ((x - u).hypot(y - v), angle)
}

/// What `of` makes of both, as a picture.
fn map(name: &str, found: &Plane, truth: &Plane, of: impl Fn(f32, f32) -> f32) -> Result<Shot, Halt> {
    let [width, _] = truth.cells;
    let pairs = found.flow.iter().zip(&truth.flow);
    let values: Vec<f32> = pairs
        .map(|(&found, &truth)| {
            let (gap, angle) = apart(found, truth);
            of(gap, angle)
        })
        .collect();
    let upright: Vec<f32> = values.chunks_exact(width).rev().flatten().copied().collect();
    Ok(Shot {
        caption: name.into(),
        png: plate(&upright, width, Tone::Light)?,
    })
}

/// The error in the slice, beside that in the whole box.
fn in_slice(row: Row, found: &Plane, truth: &Plane) -> Row {
    let squares = found.flow.iter().zip(&truth.flow);
    let squares = squares.map(|(&found, &truth)| f64::from(apart(found, truth).0).powi(2));
    let mean = squares.sum::<f64>() / truth.flow.len().max(1) as f64;
    row.with("RMS in the slice", Some(mean.sqrt()))
}

impl Capture {
    /// Cells a frame that a velocity of 1 is.
    fn unit(&self) -> f64 {
        super::super::truth::STEPS as f64 / self.cell()
    }
}
