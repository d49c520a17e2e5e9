//! The pictures of a result's page: frames, arrows and colours.

use super::middle::Middle;
use super::record::TrackRecord;
use super::wheel::{self, Plane};
use crate::keyframes::{Series, ShapeError};
use crate::output::{Angles, Field, OutputError, Over, Picture, Shot, Smoke, arrow_side};
use crate::report::{Block, Shot as Shown, evenly, number};
use std::path::Path;

/// Pictures in a row, at most.
const SHOWN: usize = 6;
/// The longer side of a picture with arrows, in pixels.
const LONGEST: usize = 420;
/// The ends of the names of components.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The arrays of a result, from which pictures are drawn: of a box its middle plane, x across and z up.
pub(super) struct Album<'a> {
    record: &'a TrackRecord,
    captured: Series,
    density: Option<Series>,
    velocity: Vec<Series>,
    truth: Vec<Series>,
    /// The density that is drawn brightest.
    full: f32,
}

impl<'a> Album<'a> {
    pub fn open(result: &Path, record: &'a TrackRecord) -> Result<Self, OutputError> {
        let archive = result.join("result.npz");
        let open = |name: &str| Series::open(&archive, Some(name), "result");
        let flows = |name: &str| -> Result<Vec<Series>, ShapeError> {
            let axes = AXES.iter().take(record.cells.len());
            axes.map(|axis| open(&format!("{name}_{axis}"))).collect()
        };
        let mut captured = open("captured").map_err(OutputError::unusable)?;
        let mut full = 0.0f64;
        for index in evenly(record.steps + 1, SHOWN) {
            full = captured
                .read(index)
                .map_err(OutputError::unusable)?
                .into_iter()
                .fold(full, f64::max);
        }
        Ok(Self {
            record,
            captured,
            density: open("density").ok(),
            velocity: flows("velocity").map_err(OutputError::unusable)?,
            truth: flows("truth").unwrap_or_default(),
            full: full as f32,
        })
    }

    /// Some frames, and below them the first one carried by the flow.
    pub fn frames(&mut self, blocks: &mut Vec<Block>) -> Result<(), OutputError> {
        let (cells, full) = (self.record.cells.clone(), self.full);
        let rows = [
            (Some(&mut self.captured), "frame"),
            (self.density.as_mut(), "carried to frame"),
        ];
        for (series, name) in rows {
            let Some(series) = series else { continue };
            let mut shots = Vec::new();
            for index in evenly(self.record.steps + 1, SHOWN) {
                let values = series.read(index).unwrap_or_default();
                let values = values.into_iter().map(|value| value as f32).collect();
                let smoke = Smoke::new(&cells, values, full, None);
                shots.push(shown(format!("{name} {index}"), &smoke.photograph())?);
            }
            blocks.push(Block::Strip(shots));
        }
        Ok(())
    }

    /// Some flows: arrows over the frame, colours, and the true ones.
    pub fn flows(&mut self, blocks: &mut Vec<Block>) -> Result<(), OutputError> {
        let picked: Vec<usize> = evenly(self.record.steps, SHOWN).collect();
        let own: Vec<Plane> = picked
            .iter()
            .map(|&index| middle(self.record).plane(&mut self.velocity, index))
            .collect();
        let truth: Vec<Plane> = if self.truth.is_empty() {
            Vec::new()
        } else {
            picked
                .iter()
                .map(|&index| middle(self.record).plane(&mut self.truth, index))
                .collect()
        };
        let fastest = own.iter().chain(&truth).map(Plane::fastest).fold(0.0, f32::max);
        let mut arrows = Vec::new();
        for (&index, plane) in picked.iter().zip(&own) {
            arrows.push(shown(
                format!("flow from frame {index}"),
                &self.arrows(index, plane, fastest)?,
            )?);
        }
        blocks.push(Block::Strip(arrows));
        for (planes, name) in [(&own, "flow from frame"), (&truth, "true flow from frame")] {
            let mut shots = Vec::new();
            for (&index, plane) in picked.iter().zip(planes) {
                shots.push(shown(format!("{name} {index}"), &plane.picture(fastest))?);
            }
            if !shots.is_empty() {
                blocks.push(Block::Strip(shots));
            }
        }
        let legend = format!(
            "direction and speed; the rim is {} cells a frame",
            number(f64::from(fastest))
        );
        blocks.push(Block::Strip(vec![shown(legend, &wheel::wheel())?]));
        Ok(())
    }

    /// Arrows over the frame that they start from.
    fn arrows(&mut self, index: usize, plane: &Plane, fastest: f32) -> Result<Picture, OutputError> {
        let values = self.captured.read(index).unwrap_or_default();
        let smoke = Smoke::new(&plane.cells, middle(self.record).slice(&values), self.full, None);
        let [nx, ny] = plane.cells;
        let pixels = (LONGEST / nx.max(ny)).max(2);
        let shot = Shot {
            width: nx * pixels,
            height: ny * pixels,
            angles: Angles::default(),
            gain: 1.0,
            detail: 0.0,
        };
        let mut film = smoke.expose(&shot);
        let field = Field {
            cells: plane.cells,
            values: plane.flow.clone(),
        };
        if fastest > 0.0 {
            let strongest = field.strongest(arrow_side(plane.cells, pixels as f32));
            let over = Over {
                streaks: None,
                arrows: (strongest > 0.0).then_some((field, strongest)),
            };
            smoke.draw_over(&mut film, &shot, &over);
        }
        Ok(film.develop())
    }
}

fn shown(caption: String, picture: &Picture) -> Result<Shown, OutputError> {
    let png = picture
        .to_png()
        .map_err(OutputError::of(Path::new("report.html")))?;
    Ok(Shown { caption, png })
}

/// The plane that is shown.
fn middle(record: &TrackRecord) -> Middle<'_> {
    let longest = record.cells.iter().copied().max().unwrap_or(1) as f64;
    Middle {
        cells: &record.cells,
        boundary: &record.boundary,
        unit: record.dt * longest / record.length,
    }
}
