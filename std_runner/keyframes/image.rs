//! `image = "x.png"`: a silhouette from a picture of any kind, y up.

use std::path::Path;

use super::decode;
use super::error::Fault;
use super::ink::Ink;
use super::note::Note;
use super::resample::{Edge, resample, windows};
use super::{Canvas, ShapeError};

/// Pixels a cell of drawings that have none of their own, and how many they have at least and at most along a side.
const FINER: usize = 4;
const DRAWN: [usize; 2] = [256, 4096];
/// Pixels along a side of such drawings where there are no cells yet.
pub(super) const USUAL_SIDE: usize = 1024;

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
    let (picture, ink) = read(path, ink, side).map_err(|fault| fault.of("image", path))?;
    let smoke = picture.values.iter().sum::<f64>() / picture.values.len().max(1) as f64;
    let shown = path.display();
    let percent = 100.0 * smoke;
    notes.push(Note::remark(format!(
        "smoke is the {} of `{shown}`, {percent:.1} % of the picture",
        ink.name()
    )));
    if let Some(said) = &picture.note {
        notes.push(Note::warning(format!("`{shown}` {said}")));
    }
    if let (0.0, Some(said)) = (smoke, &picture.note) {
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
    Ok(fit(picture, canvas))
}

/// Values 0 ..= 1, row by row from the bottom.
pub(super) struct Picture {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
    /// What the user should hear of it.
    pub note: Option<String>,
}

fn fit(picture: Picture, canvas: &Canvas) -> Vec<f64> {
    let shape = [picture.width, picture.height];
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
    resample(picture.values, &shape, &taps)
}

/// The picture, and which of its pixels are smoke: those that are `asked` for, or what they say themselves. A drawing without pixels gets
/// `side` of them along its longer side.
pub(super) fn read(path: &Path, asked: Option<Ink>, side: usize) -> Result<(Picture, Ink), Fault> {
    let pixels = decode::read(path, side)?;
    if asked == Some(Ink::Alpha) && !pixels.are_transparent() {
        return Err(Fault::content(
            "is opaque everywhere, and `ink` is \"alpha\"",
            "write ink = \"dark\" or \"light\"",
        ));
    }
    let ink = asked.unwrap_or_else(|| Ink::of(&pixels));
    let values = ink.densities(&pixels);
    if let Some(odd) = values.iter().find(|value| !value.is_finite()) {
        return Err(Fault::content(
            format!("holds {odd}"),
            "every value must be finite; save it again",
        ));
    }
    let picture = Picture {
        width: pixels.width,
        height: pixels.height,
        values,
        note: pixels.note,
    };
    Ok((picture, ink))
}
