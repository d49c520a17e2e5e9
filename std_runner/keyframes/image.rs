//! `image = "x.png"`: a silhouette from a picture of any kind, flat with y up in 2D, and in 3D upright as letters are, seen from -y.

use std::path::Path;

use super::decode::{self, Pixels};
use super::error::Fault;
use super::ink::Ink;
use super::mesh::Edge as BodyEdge;
use super::note::Note;
use super::resample::{Edge, along, windows};
use super::solid::soft;
use super::{Canvas, ShapeError, ShapeSpec, text};

/// Pixels a cell of drawings that have none of their own, and how many they have at least and at most along a side.
const FINER: usize = 4;
const DRAWN: [usize; 2] = [256, 4096];
/// Pixels along a side of such drawings where there are no cells yet.
pub(super) const USUAL_SIDE: usize = 1024;

/// Levels of numbers are told of where they are beyond black or white by more than this.
const BEYOND: f64 = 1e-3;

/// More than this part of a picture is rarely meant to be smoke.
const NEARLY_ALL: f64 = 0.5;

/// The picture at `path`, in its own proportions, as large as the box allows and centred in it; `ink` says which of its pixels are smoke, or the
/// `first` picture of a sequence does.
pub(super) fn draw(
    spec: &ShapeSpec,
    (path, first): (&Path, Option<&Path>),
    (canvas, edge): (&Canvas, BodyEdge),
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    let ink = spec.ink.as_deref().map(Ink::parse).transpose()?;
    let up = canvas.up();
    let across = [canvas.cells_3d()[0], canvas.cells_3d()[up]];
    let usual = text::USUAL_HEIGHT * canvas.extent()[up];
    let half_depth = text::half_depth(spec.depth, usual, canvas)?;
    let side = (FINER * across[0].max(across[1])).clamp(DRAWN[0], DRAWN[1]);
    let ink = match first.filter(|&first| ink.is_none() && first != path) {
        Some(first) => Some(
            opened(first, None, side)
                .map_err(|fault| fault.of("image", first))?
                .1,
        ),
        None => ink,
    };
    let (pixels, ink) = opened(path, ink, side).map_err(|fault| fault.of("image", path))?;
    let (flat, smoke) = fit(&pixels, ink, across).map_err(|fault| fault.of("image", path))?;
    let cells = match half_depth {
        None => flat,
        Some(half_depth) => extruded(&flat, across[0], &depths(half_depth, canvas, edge)),
    };
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

/// How much of each layer of cells along y belongs to a body in the middle of the box.
fn depths(half_depth: f64, canvas: &Canvas, edge: BodyEdge) -> Vec<f64> {
    let (h, middle) = (canvas.cell_size(), canvas.middle()[1]);
    let part = |layer: usize| {
        let outside = ((layer as f64 + 0.5) * h - middle).abs() - half_depth;
        match edge {
            BodyEdge::Soft => soft(outside / h),
            BodyEdge::Cut => f64::from(u8::from(outside <= 0.0)),
        }
    };
    (0..canvas.cells_3d()[1]).map(part).collect()
}

/// Rows of `width` values, each of them repeated along y by these parts.
fn extruded(flat: &[f64], width: usize, depths: &[f64]) -> Vec<f64> {
    let rows = flat.chunks_exact(width);
    let layers = rows.flat_map(|row| {
        depths
            .iter()
            .map(move |part| row.iter().map(move |value| part * value))
    });
    layers.flatten().collect()
}

/// Values 0 ..= 1, row by row from the bottom.
pub(super) struct Picture {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
}

/// The densities of the pixels on so many cells, and their mean. They are taken row by row: a picture has far more pixels than the grid cells.
fn fit(pixels: &Pixels, ink: Ink, cells: [usize; 2]) -> Result<(Vec<f64>, f64), Fault> {
    let shape = [pixels.width, pixels.height];
    let pixels_a_cell = shape
        .iter()
        .zip(&cells)
        .map(|(&pixels, &cells)| pixels as f64 / cells as f64);
    let step = pixels_a_cell.fold(0.0, f64::max);
    let taps: Vec<_> = shape
        .iter()
        .zip(&cells)
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
