//! A plane of smoke, seen face on, y up.

use super::deep::Shot;
use super::lamp::shade;
use super::palette::{Palette, covered, signed};
use super::smoke::Smoke;
use super::tone::linear;
use super::upscale::enlarge;
use crate::output::picture::{Colours, Picture};

/// Pictures are at least about this wide, in pixels,
const WIDTH: usize = 384;
/// unless that would make them higher than this.
const HEIGHT: usize = 2048;
/// How opaque density 1 is.
const OPACITY: f32 = 2.6;
/// Absorption of the lamp's light over the longest side.
const SHADE: f32 = 5.0;
/// What is seen where no light of the lamp arrives.
const AMBIENT: f32 = 0.34;
/// The way to the lamp, to the left and above.
const LAMP: [f32; 3] = [-0.4819, 0.0, 0.8762];

/// The picture of a result.
pub(super) fn photograph(smoke: &Smoke) -> Picture {
    let [nx, _, ny] = smoke.cells;
    enlarged(smoke, factor(nx, ny))
}

/// A picture in which a cell is `factor` pixels wide and high.
fn enlarged(smoke: &Smoke, factor: usize) -> Picture {
    let levels = glowing(smoke, factor).map(|glow| (glow * 255.0).round() as u8);
    shown(smoke, factor, levels, Palette::Smoke)
}

/// How bright the smoke is in every pixel, 0 ..= 1.
fn glowing(smoke: &Smoke, factor: usize) -> impl Iterator<Item = f32> {
    let [nx, _, _] = smoke.cells;
    let strength = SHADE / smoke.longest();
    let light = shade(smoke.cells, 1, &smoke.values, None, LAMP)
        .into_iter()
        .map(|way| (-strength * way).exp());
    let light = from_the_top(nx, factor, &light.collect::<Vec<f32>>());
    let density = from_the_top(nx, factor, &smoke.values);
    let whole = 1.0 - (-OPACITY).exp();
    let glow = move |(density, light): (f32, f32)| {
        let opacity = (1.0 - (-OPACITY * density.max(0.0)).exp()) / whole;
        (opacity * (AMBIENT + (1.0 - AMBIENT) * light.clamp(0.0, 1.0))).clamp(0.0, 1.0)
    };
    density.into_iter().zip(light).map(glow)
}

/// What part of every pixel a body covers.
fn parts(body: &[f32], nx: usize, factor: usize) -> impl Iterator<Item = f32> {
    // The edge is where it is 1/2 and about a pixel wide: from cell to cell it changes by some 1/3.
    let part = move |body: f32| ((body - 0.5) * 3.0 * factor as f32 + 0.5).clamp(0.0, 1.0);
    from_the_top(nx, factor, body).into_iter().map(part)
}

/// Levels of pixels, with the body before them if there is one.
fn shown(smoke: &Smoke, factor: usize, levels: impl Iterator<Item = u8>, palette: Palette) -> Picture {
    let [nx, _, ny] = smoke.cells;
    let (bytes, colours) = match &smoke.body {
        None => (levels.collect(), Colours::Of(palette)),
        Some(body) => (palette.behind(levels, parts(&body.0, nx, factor)), Colours::Each),
    };
    Picture {
        width: nx * factor,
        height: ny * factor,
        bytes,
        colours,
    }
}

/// Where a plane stands in a picture whose cells are as large as they can be by a whole factor.
#[derive(Clone, Copy)]
pub(super) struct Stand {
    /// Pixels of the picture.
    pub width: usize,
    pub height: usize,
    /// Pixels before the plane.
    left: usize,
    above: usize,
    /// Pixels of the plane.
    wide: usize,
    high: usize,
}

impl Stand {
    fn new(nx: usize, ny: usize, factor: usize, shot: &Shot) -> Self {
        let (wide, high) = (nx * factor, ny * factor);
        Self {
            width: shot.width,
            height: shot.height,
            left: shot.width.saturating_sub(wide) / 2,
            above: shot.height.saturating_sub(high) / 2,
            wide,
            high,
        }
    }

    /// Pixels of a cell, of which there are `across` along x.
    pub fn pixels(&self, across: usize) -> f32 {
        self.wide as f32 / across as f32
    }

    /// The place in the picture of one in the plane, in cells of which there are `across` along x.
    pub fn spot(&self, across: usize, [x, y]: [f32; 2]) -> [f32; 2] {
        let pixels = self.pixels(across);
        [
            self.left as f32 + pixels * x,
            (self.above + self.high) as f32 - pixels * y,
        ]
    }
}

/// Pixels along a side of a cell.
fn magnified(smoke: &Smoke, shot: &Shot) -> usize {
    let [nx, _, ny] = smoke.cells;
    (shot.width / nx).min(shot.height / ny).max(1)
}

/// Where the plane stands.
pub(super) fn stand(smoke: &Smoke, shot: &Shot) -> Stand {
    let [nx, _, ny] = smoke.cells;
    Stand::new(nx, ny, magnified(smoke, shot), shot)
}

/// The light of a picture on the ground of the palette.
pub(super) fn expose(smoke: &Smoke, shot: &Shot) -> Vec<[f32; 3]> {
    let (factor, [nx, _, _]) = (magnified(smoke, shot), smoke.cells);
    let stand = stand(smoke, shot);
    let light = |colour: [f32; 3]| colour.map(|code| shot.gain * linear(code / 255.0));
    let mut seen: Vec<[f32; 3]> = glowing(smoke, factor)
        .map(|glow| Palette::Smoke.at(glow))
        .collect();
    if let Some(body) = &smoke.body {
        let pixels = seen.iter_mut().zip(parts(&body.0, nx, factor));
        pixels.for_each(|(colour, part)| *colour = covered(*colour, part));
    }
    let mut film = vec![light(Palette::Smoke.at(0.0)); shot.width * shot.height];
    let lines = film.chunks_exact_mut(shot.width).skip(stand.above);
    for (film, seen) in lines.zip(seen.chunks_exact(stand.wide.max(1))) {
        let film = film.iter_mut().skip(stand.left);
        film.zip(seen).for_each(|(film, &colour)| *film = light(colour));
    }
    film
}

/// The picture of a difference.
pub(super) fn chart(smoke: &Smoke) -> Picture {
    let [nx, _, ny] = smoke.cells;
    let factor = factor(nx, ny);
    let levels = from_the_top(nx, factor, &smoke.values).into_iter().map(signed);
    shown(smoke, factor, levels, Palette::Difference)
}

/// Pixels of a picture of `nx` by `ny` cells.
pub(super) fn pixels(nx: usize, ny: usize) -> usize {
    let factor = factor(nx, ny);
    nx * factor * ny * factor
}

fn factor(nx: usize, ny: usize) -> usize {
    WIDTH.div_ceil(nx.max(1)).min((HEIGHT / ny.max(1)).max(1))
}

fn from_the_top(nx: usize, factor: usize, values: &[f32]) -> Vec<f32> {
    let turned: Vec<f32> = values.chunks_exact(nx.max(1)).rev().flatten().copied().collect();
    enlarge(&turned, nx, factor)
}
