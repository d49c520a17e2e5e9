//! `report.html` of a reconstruction: what the cameras saw, what they would see of the result, and the result.

use super::written::Outcome;
use crate::output::{Densities, Gallery, OutputError, Tone, plate};
use crate::report::{self, Block, Chart, Curve, Document, Scale, Shot, Table, bytes, number, seconds};
use std::path::Path;
use thurible_core::{Named, Real};

/// Cameras that are shown, at most.
const CAMERAS: usize = 8;

/// Draws frames, animation and page into `folder`, from the result in `result`.
pub(super) fn draw<T: Real>(
    result: &Path,
    folder: &Path,
    outcome: &Outcome<'_, T>,
) -> Result<(), OutputError> {
    if !outcome.views.settings.keeps_cells() {
        return page(outcome, Gallery::default())?.write(folder, "report");
    }
    let steps = outcome.frames.len().saturating_sub(1);
    let cells = outcome.views.cells.clone();
    let densities = Densities::open(&result.join(report::ARCHIVE), cells, steps, Vec::new(), None)?;
    let gallery = Gallery::has_room(&densities, true)
        .then(|| Gallery::draw(folder, densities, true))
        .transpose()?
        .unwrap_or_default();
    page(outcome, gallery)?.write(folder, "report")
}

fn page<T: Real>(outcome: &Outcome<'_, T>, gallery: Gallery) -> Result<Document, OutputError> {
    let views = outcome.views;
    let mut blocks = vec![facts(outcome)];
    if views.settings.keeps_cells() {
        density(outcome, gallery, &mut blocks)?;
    }
    let shown = outcome.frames.len() / 2;
    if !views.novel.is_empty() {
        blocks.push(Block::Heading(format!(
            "Novel views in frame {}",
            views.first + shown
        )));
        blocks.push(Block::Pictures(novel(outcome, shown)?));
    }
    blocks.push(Block::Heading(format!(
        "What the cameras saw in frame {}",
        views.first + shown
    )));
    blocks.push(Block::Text(
        "Measured, what the reconstruction would show, and what is left: blue where it shows too little, orange too much.".into(),
    ));
    blocks.push(Block::Pictures(seen(outcome, shown)?));
    blocks.push(Block::Heading("The way there".into()));
    blocks.push(Block::Charts(charts(outcome)));
    blocks.push(Block::Heading("The file of views".into()));
    blocks.push(Block::Code(views.document.text().trim_end().into()));
    Ok(Document {
        title: "Tomography".into(),
        lead: format!(
            "{} frames of {} cells from {} cameras, {}.",
            outcome.frames.len(),
            crate::plan::size_in_words(&views.cells),
            views.cameras.len(),
            outcome.status()
        ),
        blocks,
        pictures: false,
    })
}

/// The frames, and slices of a box.
fn density<T: Real>(
    outcome: &Outcome<'_, T>,
    gallery: Gallery,
    blocks: &mut Vec<Block>,
) -> Result<(), OutputError> {
    let views = outcome.views;
    let strip = gallery.strip.into_iter().map(|(step, png)| Shot {
        caption: format!("frame {}", views.first + step),
        png,
    });
    blocks.push(Block::Heading("The density".into()));
    blocks.push(Block::Pictures(strip.collect()));
    if let [nx, ny, nz] = views.cells[..] {
        blocks.push(Block::Heading("Slices through the middle".into()));
        blocks.push(Block::Pictures(slices(outcome, [nx, ny, nz])?));
    }
    Ok(())
}

/// What novel views show, and beside it what was seen there, where that is known.
fn novel<T: Real>(outcome: &Outcome<'_, T>, frame: usize) -> Result<Vec<Shot>, OutputError> {
    let views = outcome.views;
    let mut shots = Vec::new();
    let Some(found) = outcome.frames.get(frame) else {
        return Ok(shots);
    };
    for (view, shown) in views.novel.iter().zip(&found.novel).take(CAMERAS) {
        let shown: Vec<f64> = shown.iter().map(|pixel| pixel.to_f64()).collect();
        let seen = views.compared(view, frame);
        let all = seen.iter().flatten().chain(&shown);
        let full = all.copied().fold(f64::MIN_POSITIVE, f64::max);
        let light = |values: &[f64]| values.iter().map(|x| (x / full) as f32).collect::<Vec<f32>>();
        let width = view.pixels[0];
        shots.push(Shot {
            caption: format!("{}: reconstructed", view.name),
            png: plate(&light(&shown), width, Tone::Light)?,
        });
        if let Some(seen) = seen {
            shots.push(Shot {
                caption: format!("{}: as it was photographed", view.name),
                png: plate(&light(&seen), width, Tone::Light)?,
            });
        }
    }
    Ok(shots)
}

fn facts<T: Real>(outcome: &Outcome<'_, T>) -> Block {
    let settings = outcome.views.settings;
    let worst = outcome
        .frames
        .iter()
        .map(|frame| frame.residual_relative)
        .fold(0.0, f64::max);
    let mut rows = vec![
        ("residual, at most", format!("{:.2} %", 100.0 * worst)),
        ("method", settings.method.name().into()),
        (
            "prior, gamma",
            format!("{}, {}", settings.prior.name(), number(settings.gamma)),
        ),
        ("mutations a frame, at most", number(settings.budget as f64)),
        ("seconds", seconds(outcome.seconds)),
        ("memory", bytes(outcome.plan.block())),
    ];
    if let Some(error) = outcome.rms_error() {
        rows.insert(0, ("RMS error against the truth, mean", format!("{error:.4}")));
    }
    Block::Table(Table::of_facts(rows))
}

fn curve(history: &[serde_json::Value], name: &str, colour: usize, key: &str) -> Curve {
    let points = history.iter().filter_map(|entry| {
        let at = |key: &str| entry.get(key).and_then(serde_json::Value::as_f64);
        Some((at("mutations")?, at(key)?))
    });
    Curve::new(name, colour, points)
}

fn charts<T: Real>(outcome: &Outcome<'_, T>) -> Vec<Chart> {
    let history: Vec<_> = outcome
        .frames
        .first()
        .map(|frame| frame.history.clone())
        .unwrap_or_default();
    let mut charts = vec![Chart {
        title: "The objective",
        note: "Of the first frame: distance from the pictures, and the prior.".into(),
        across: "mutations",
        scale: Scale::Counts,
        curves: vec![
            curve(&history, "data", 1, "data"),
            curve(&history, "prior", 2, "prior"),
        ],
    }];
    let mut errors = vec![curve(&history, "residual", 1, "residual_relative")];
    if outcome.rms_error().is_some() {
        errors.push(curve(&history, "RMS error", 2, "rms_error"));
    }
    charts.push(Chart {
        title: "The error",
        note: "Of the first frame: |q - F p| / |q|, and against the truth where that is known.".into(),
        across: "mutations",
        scale: Scale::Counts,
        curves: errors,
    });
    charts
}

/// Three pictures for each camera; in a plane, three with a row for each camera.
fn seen<T: Real>(outcome: &Outcome<'_, T>, frame: usize) -> Result<Vec<Shot>, OutputError> {
    let views = outcome.views;
    let mut shots = Vec::new();
    let Some(found) = outcome.frames.get(frame) else {
        return Ok(shots);
    };
    let mut rows: [Vec<f32>; 3] = Default::default();
    let flat = views.cells.len() == 2;
    let same = views
        .cameras
        .iter()
        .all(|view| Some(view.pixels) == views.cameras.first().map(|view| view.pixels));
    for (number, view) in views.cameras.iter().enumerate() {
        let Ok(measured) = views.picture(view, frame) else {
            continue;
        };
        let shown: Vec<f64> = found
            .reprojected
            .get(number)
            .into_iter()
            .flatten()
            .map(|x| x.to_f64())
            .collect();
        let full = measured.values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let light = |values: &[f64]| values.iter().map(|x| (x / full) as f32).collect::<Vec<f32>>();
        let left = |(shown, measured): (&f64, &f64)| (5.0 * (shown - measured) / full) as f32;
        let left: Vec<f32> = shown.iter().zip(&measured.values).map(left).collect();
        let trio = [light(&measured.values), light(&shown), left];
        if flat && same {
            rows.iter_mut()
                .zip(&trio)
                .for_each(|(rows, values)| rows.extend(values));
        } else if number < CAMERAS {
            shots.extend(three(&trio, view.pixels[0], &view.name)?);
        }
    }
    if flat && same {
        let width = views.cameras.first().map_or(1, |view| view.pixels[0]);
        shots.extend(three(&rows, width, "all cameras, a row each")?);
    }
    Ok(shots)
}

fn three(values: &[Vec<f32>; 3], width: usize, name: &str) -> Result<Vec<Shot>, OutputError> {
    let kinds = [
        ("measured", Tone::Light),
        ("reconstructed", Tone::Light),
        ("what is left, five times", Tone::Difference),
    ];
    let shot = |(values, (word, tone)): (&Vec<f32>, (&str, Tone))| {
        Ok(Shot {
            caption: format!("{name}: {word}"),
            png: plate(values, width, tone)?,
        })
    };
    values.iter().zip(kinds).map(shot).collect()
}

/// Through the middle of the box, across each axis.
fn slices<T: Real>(outcome: &Outcome<'_, T>, [nx, ny, nz]: [usize; 3]) -> Result<Vec<Shot>, OutputError> {
    let Some(frame) = outcome.frames.get(outcome.frames.len() / 2) else {
        return Ok(Vec::new());
    };
    let full = frame
        .density
        .iter()
        .map(|x| x.to_f64())
        .fold(f64::MIN_POSITIVE, f64::max);
    let at = |[x, y, z]: [usize; 3]| {
        let value = frame.density.get((z * ny + y) * nx + x);
        value.map_or(0.0, |value| (value.to_f64() / full) as f32)
    };
    // Name, sides, and the cell of a pixel across and up.
    type Cut<'a> = (&'a str, usize, usize, &'a dyn Fn(usize, usize) -> [usize; 3]);
    let cuts: [Cut<'_>; 3] = [
        ("across x", ny, nz, &|across, up| [nx / 2, across, up]),
        ("across y", nx, nz, &|across, up| [across, ny / 2, up]),
        ("across z", nx, ny, &|across, up| [across, up, nz / 2]),
    ];
    let shot = |(name, width, height, cell): Cut<'_>| {
        let values: Vec<f32> = (0..width * height)
            .map(|pixel| at(cell(pixel % width, height - 1 - pixel / width)))
            .collect();
        Ok(Shot {
            caption: name.into(),
            png: plate(&values, width, Tone::Light)?,
        })
    };
    cuts.into_iter().map(shot).collect()
}
