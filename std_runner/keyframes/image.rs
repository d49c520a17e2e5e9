//! `image = "x.png"`: a silhouette from a picture of any kind, y up.

use std::path::Path;

use super::decode::{self, Pixels};
use super::error::Fault;
use super::ink::Ink;
use super::note::Note;
use super::resample::{Edge, along, windows};
use super::{Canvas, ShapeError};

/// Pixels a cell of drawings that have none of their own, and how many they have at least and at most along a side.
const FINER: usize = 4;
const DRAWN: [usize; 2] = [256, 4096];
/// Pixels along a side of such drawings where there are no cells yet.
pub(super) const USUAL_SIDE: usize = 1024;

/// Levels of numbers are told of where they are beyond black or white by more than this.
const BEYOND: f64 = 1e-3;

/// More than this part of a picture is rarely meant to be smoke.
const NEARLY_ALL: f64 = 0.5;

/// The picture, in its own proportions, as large as the box allows and centred in it; `ink` says which of its pixels are smoke.
pub(super) fn draw(
    path: &Path,
    ink: Option<&str>,
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    if canvas.dimensions() != 2 {
        let remedy = "use `text`, `file` or the solid shapes in 3D";
        return Err(ShapeError::key("image", "is flat, and the grid is 3D", remedy));
    }
    let ink = ink.map(Ink::parse).transpose()?;
    let longest = canvas.cells.iter().copied().max().unwrap_or(1);
    let side = (FINER * longest).clamp(DRAWN[0], DRAWN[1]);
    let (pixels, ink) = opened(path, ink, side).map_err(|fault| fault.of("image", path))?;
    let (cells, smoke) = fit(&pixels, ink, canvas).map_err(|fault| fault.of("image", path))?;
    let shown = path.display();
    let percent = 100.0 * smoke;
    notes.push(Note::remark(format!(
        "smoke is the {} of `{shown}`, {percent:.1} % of the picture",
        ink.name()
    )));
    if let Some([low, high]) = pixels.range()
        && (low < -BEYOND || high > 1.0 + BEYOND)
    {
        notes.push(Note::warning(format!(
            "the levels of `{shown}` go from {low:.3} to {high:.3}; below 0 they count as 0 and above 1 as 1: divide them in the file, and write what they were divided by as `density` beside `image`"
        )));
    }
    if let Some(said) = &pixels.note {
        notes.push(Note::warning(format!("`{shown}` {said}")));
    }
    if let (0.0, Some(said)) = (smoke, &pixels.note) {
        let remedy = "save it again, or say by `ink` what of it is smoke";
        return Err(
            Fault::content(format!("{said}, and nothing else of it is smoke"), remedy).of("image", path),
        );
    }
    if smoke > NEARLY_ALL {
        let other = ink.other();
        notes.push(Note::warning(format!(
            "{percent:.0} % of the picture `{shown}` becomes smoke; {other}"
        )));
    }
    Ok(cells)
}

/// Values 0 ..= 1, row by row from the bottom.
pub(super) struct Picture {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
}

/// The densities of the pixels on the cells, and their mean. They are taken row by row: a picture has far more pixels than the grid cells.
fn fit(pixels: &Pixels, ink: Ink, canvas: &Canvas) -> Result<(Vec<f64>, f64), Fault> {
    let shape = [pixels.width, pixels.height];
    let pixels_a_cell = shape
        .iter()
        .zip(&canvas.cells)
        .map(|(&pixels, &cells)| pixels as f64 / cells as f64);
    let step = pixels_a_cell.fold(0.0, f64::max);
    let taps: Vec<_> = shape
        .iter()
        .zip(&canvas.cells)
        .map(|(&pixels, &cells)| {
            let start = 0.5 * (pixels as f64 - cells as f64 * step);
            windows(cells, pixels, start, step, Edge::Empty)
        })
        .collect();
    let [across, up] = taps.as_slice() else {
        return Ok((Vec::new(), 0.0));
    };
    let (mut rows, mut row, mut sum) = (Vec::with_capacity(across.len() * shape[1]), Vec::new(), 0.0);
    for number in 0..pixels.height {
        row.clear();
        row.extend(ink.row(pixels, number));
        refuse_not_finite(&row)?;
        sum = row.iter().fold(sum, |sum, value| sum + value);
        rows.extend(along(&row, 1, pixels.width, across));
    }
    let mean = sum / (shape[0] * shape[1]).max(1) as f64;
    Ok((along(&rows, across.len(), shape[1], up), mean))
}

fn refuse_not_finite(values: &[f64]) -> Result<(), Fault> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(odd) => Err(Fault::content(
            format!("holds {odd}"),
            "every value must be finite; save it again",
        )),
    }
}

/// The pixels of a picture, and which of them are smoke: those that are `asked` for, or what they say themselves. A drawing without pixels
/// gets `side` of them along its longer side.
fn opened(path: &Path, asked: Option<Ink>, side: usize) -> Result<(Pixels, Ink), Fault> {
    let pixels = decode::read(path, side)?;
    if asked == Some(Ink::Alpha) && !pixels.are_transparent() {
        return Err(Fault::content(
            "is opaque everywhere, and `ink` is \"alpha\"",
            "write ink = \"dark\" or \"light\"",
        ));
    }
    let ink = asked.unwrap_or_else(|| Ink::of(&pixels));
    Ok((pixels, ink))
}

/// The densities of all pixels, as they are.
pub(super) fn read(path: &Path, asked: Option<Ink>, side: usize) -> Result<(Picture, Ink), Fault> {
    let (pixels, ink) = opened(path, asked, side)?;
    let values = ink.densities(&pixels);
    refuse_not_finite(&values)?;
    let picture = Picture {
        width: pixels.width,
        height: pixels.height,
        values,
    };
    Ok((picture, ink))
}
