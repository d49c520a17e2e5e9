//! `text = "F"`: letters that stand upright, flat in 2D, extruded along y in 3D (read in the x-z plane from -y).

use std::borrow::Cow;
use std::path::Path;

use super::font::{self, Lettering, Trouble};
use super::outline::Point;
use super::solid::Solid;
use super::whole::whole;
use super::{Canvas, ShapeError, ShapeSpec, check};

/// Height of a capital letter if none is given, in heights of the box.
pub(super) const USUAL_HEIGHT: f64 = 0.5;
/// Text of the usual height is shrunk until its ink fills at most this part of the box.
const WIDEST: f64 = 0.8;
/// Thickness along y if none is given, in heights of a capital letter.
const USUAL_DEPTH: f64 = 0.3;
/// What to write where a font cannot be used.
const FONTS: &str = "name a .ttf or .otf file, or leave `font` out";
/// Distances beyond this many cells need not be exact: tanh is 1 there.
const REACH: f64 = 24.0;

/// Letters as a solid.
pub(super) struct Letters {
    lettering: Lettering,
    /// Middle of the ink, in em.
    ink_middle: Point,
    /// Middle of the ink in the box.
    center: [f64; 3],
    /// Size of an em in the box.
    em: f64,
    /// Half the thickness along y; `None` in 2D.
    half_depth: Option<f64>,
    /// How far the outline is moved outwards.
    thicker: f64,
    /// Distances up to here are exact, in em.
    reach: f64,
}

impl Solid for Letters {
    fn distance(&self, point: [f64; 3]) -> f64 {
        let up = if self.half_depth.is_some() { 2 } else { 1 };
        let place = [
            (point[0] - self.center[0]) / self.em + self.ink_middle[0],
            (point[up] - self.center[up]) / self.em + self.ink_middle[1],
        ];
        let glyphs = self.lettering.outlines.iter();
        let nearest = glyphs
            .map(|outline| outline.distance(place, self.reach))
            .fold(f64::INFINITY, f64::min);
        let flat = nearest * self.em - self.thicker;
        let Some(half_depth) = self.half_depth else {
            return flat;
        };
        let deep = (point[1] - self.center[1]).abs() - half_depth;
        flat.max(0.0).hypot(deep.max(0.0)) + flat.max(deep).min(0.0)
    }
}

impl Letters {
    /// The same with its ink from the left side of a box that is so wide, made smaller if it is wider than that.
    pub(super) fn at_the_left(mut self, width: f64) -> Self {
        let (low, high) = ink(&self.lettering);
        let wide = self.em * (high[0] - low[0]);
        if wide > width {
            self.em *= width / wide;
        }
        self.center[0] = 0.5 * wide.min(width);
        self
    }
}

/// The letters that `spec` asks for.
pub(super) fn solid(spec: &ShapeSpec, canvas: &Canvas, base: &Path) -> Result<Letters, ShapeError> {
    let text = spec.text.as_deref().unwrap_or("");
    let lettering = lettering(text, spec.font.as_deref(), base)?;
    let (low, high) = ink(&lettering);
    let center = match &spec.center {
        Some(given) => check::point("center", given, canvas)?,
        None => canvas.middle(),
    };
    let box_height = canvas.extent()[canvas.up()];
    let height = match spec.height {
        Some(height) => check::positive("height", height, canvas)?,
        None => {
            let ink_size = [
                (high[0] - low[0]) / lettering.capital,
                (high[1] - low[1]) / lettering.capital,
            ];
            let widest = WIDEST * canvas.extent()[0] / ink_size[0].max(1e-9);
            (USUAL_HEIGHT * box_height)
                .min(widest)
                .min(WIDEST * box_height / ink_size[1].max(1e-9))
        }
    };
    let em = height / lettering.capital;
    Ok(Letters {
        ink_middle: [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])],
        center,
        em,
        half_depth: half_depth(spec.depth, height, canvas)?,
        thicker: 0.5 * height * weight(spec.weight)?,
        reach: REACH * canvas.cell_size() / em + 0.5 * lettering.capital,
        lettering,
    })
}

fn lettering(text: &str, file: Option<&Path>, base: &Path) -> Result<Lettering, ShapeError> {
    let path = file.map(|file| base.join(file));
    let font: Cow<'_, [u8]> = match &path {
        None => font::built_in().into(),
        Some(path) => whole(path, 1, FONTS)
            .map_err(|fault| fault.of("font", path))?
            .into(),
    };
    font::set(text, &font).map_err(|trouble| match trouble {
        Trouble::Text(found, remedy) => ShapeError::key("text", found, remedy),
        Trouble::Font(found) => ShapeError::File {
            key: "font".into(),
            path: path.unwrap_or_default(),
            found,
            remedy: FONTS.into(),
        },
    })
}

/// The corners of all the ink, in em.
fn ink(lettering: &Lettering) -> (Point, Point) {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for (near, far) in lettering.outlines.iter().map(|outline| outline.bounds()) {
        low = core::array::from_fn(|axis| low[axis].min(near[axis]));
        high = core::array::from_fn(|axis| high[axis].max(far[axis]));
    }
    (low, high)
}

/// Half the thickness along y of what is so high, in 3D.
pub(super) fn half_depth(
    depth: Option<f64>,
    height: f64,
    canvas: &Canvas,
) -> Result<Option<f64>, ShapeError> {
    match (depth, canvas.dimensions()) {
        (Some(depth), 3) => Ok(Some(0.5 * check::positive("depth", depth, canvas)?)),
        (None, 3) => Ok(Some(0.5 * USUAL_DEPTH * height)),
        (Some(_), _) => Err(ShapeError::key(
            "depth",
            "is given, and the grid is 2D",
            "remove it: what is flat has no depth",
        )),
        (None, _) => Ok(None),
    }
}

fn weight(weight: Option<f64>) -> Result<f64, ShapeError> {
    match weight {
        None => Ok(0.0),
        Some(weight) if (-0.2..=0.5).contains(&weight) => Ok(weight),
        Some(weight) => {
            let remedy =
                "it must be from -0.2 to 0.5: the part of the height by which every stroke is thickened";
            Err(ShapeError::key("weight", format!("is {weight}"), remedy))
        }
    }
}
