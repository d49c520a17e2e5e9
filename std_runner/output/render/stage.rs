//! A step of smoke as it stands in the light: everything that a ray asks for.

use rayon::prelude::*;

use super::blocks::Blocks;
use super::camera::{Camera, Vector, dot};
use super::grain::curl;
use super::lamp::{LAMPS, shade};
use super::smoke::Smoke;
use super::volume::Volume;

/// Extinction of density 1 over the longest side.
const THICKNESS: f32 = 13.0;
/// Light is absorbed so many times as much on its way from a lamp: thick smoke has shaded sides.
const SHADING: f32 = 2.6;
/// Henyey and Greenstein's g: smoke scatters forward.
const FORWARD: f32 = 0.45;
/// Orders of scattering, as Wrenninge, Kulla and Lundqvist (2013) stand in for them: each has half the light of the one before,
/// comes through half the smoke and is half as directed.
const ORDERS: usize = 3;
const SHARE: f32 = 0.4;
/// The share of light that is not absorbed, by colour: thick smoke is a little warm.
const ALBEDO: [f32; 3] = [0.97, 0.95, 0.925];
/// Cells a step along a ray, and with detail or a body.
const STRIDES: [f32; 2] = [0.5, 0.3];
/// Cells are cut so often, at most.
pub(super) const CUTS: usize = 4;
/// Light from everywhere.
const AROUND: [f32; 3] = [0.020, 0.023, 0.030];
/// Cells along the longest side of the volumes, at most, unless the smoke has more.
const FINEST_DENSITY: usize = 256;
const FINEST_LIGHT: usize = 128;

/// Lit smoke and bodies.
pub(super) struct Stage {
    pub cells: [usize; 3],
    /// Extinction of density 1, per cell.
    pub extinction: f32,
    /// Cells a step along a ray.
    pub stride: f32,
    pub density: Volume,
    /// Of bodies; above 1/2 inside.
    pub body: Option<Volume>,
    /// What smoke at a place sends to the camera, linear red, green and blue; the fourth number pads.
    glow: Vec<[f32; 4]>,
    /// How much of each lamp's light arrives.
    pub clear: [Volume; 2],
    pub blocks: Blocks,
}

impl Stage {
    /// `smoke` for a camera whose picture has about `across` samples from side to side; cells are cut at most `most` times.
    pub fn new(smoke: &Smoke, camera: &Camera, across: usize, most: usize) -> Self {
        let (fine, coarse) = factors(smoke.cells, across, most);
        let blocks = Blocks::new(smoke);
        let positive: Vec<f32> = smoke.values.iter().map(|value| value.max(0.0)).collect();
        let mut density = Volume::refined(&positive, smoke.cells, fine);
        if let Some((drift, amount)) = &smoke.detail {
            density = curl(&density, drift, *amount, |place| blocks.at(place).1);
        }
        let body = smoke.body.as_ref();
        let body = body.map(|body| Volume::refined(&body.0, smoke.cells, fine));
        let extinction = THICKNESS / smoke.longest();
        let clear = arriving(&density, body.as_ref(), fine / coarse, SHADING * extinction);
        let [plain, detailed] = STRIDES;
        let careful = smoke.detail.is_some() || body.is_some();
        Self {
            cells: smoke.cells,
            extinction,
            stride: if careful { detailed } else { plain },
            density,
            body,
            glow: glow(&clear, camera),
            clear,
            blocks,
        }
    }

    /// What smoke at `point` sends to the camera, if it were thick.
    #[inline]
    pub fn glow(&self, point: Vector) -> [f32; 3] {
        let [red, green, blue, _] = self.clear[0].corners(point).of(&self.glow);
        [red, green, blue]
    }
}

/// Bytes of a stage while it is set up, about, for smoke of `cells` in a picture of `across` samples from side to side.
pub(super) fn bytes(cells: [usize; 3], across: usize, detail: bool, body: bool) -> usize {
    const NUMBER: usize = size_of::<f32>();
    let (fine, coarse) = factors(cells, across, CUTS);
    let cut = |factor: usize| {
        cells
            .iter()
            .fold(NUMBER, |all, &count| all.saturating_mul(count * factor))
    };
    // Of light two lamps, and four colours of what smoke sends to the camera.
    let (whole, light) = (cut(fine), cut(coarse).saturating_mul(6));
    // Beside the density: what it was cut from along two axes, or curled from; then a body, and what that was cut from, or light.
    let curled = if detail { whole } else { whole / fine };
    let beside = if body {
        whole.saturating_add(light.max(whole / fine))
    } else {
        light
    };
    whole.saturating_add(curled.max(beside))
}

/// How often cells are cut for density and for light, the one a multiple of the other.
fn factors(cells: [usize; 3], across: usize, most: usize) -> (usize, usize) {
    let longest = cells.into_iter().max().unwrap_or(1);
    let cut = |samples: usize, cells: usize| (across / (samples * longest)).min(cells / longest);
    let fine = cut(2, FINEST_DENSITY).clamp(1, most);
    let coarse = cut(4, FINEST_LIGHT).clamp(1, (most / 2).max(1)).min(fine);
    (fine, if fine % coarse == 0 { coarse } else { 1 })
}

/// How much light of each lamp arrives, on a grid `by` times as coarse as that of the density.
fn arriving(density: &Volume, body: Option<&Volume>, by: usize, extinction: f32) -> [Volume; 2] {
    let lit = density.coarser(by);
    let arrives = |toward| {
        let mut values = shade(lit.cells, lit.factor, &lit.values, body, toward);
        values
            .par_iter_mut()
            .for_each(|way| *way = (-extinction * *way).exp());
        Volume {
            cells: lit.cells,
            factor: lit.factor,
            values,
        }
    };
    let [key, fill] = &LAMPS;
    let (key, fill) = rayon::join(|| arrives(key.toward), || arrives(fill.toward));
    [key, fill]
}

/// Single scattering of each lamp's light towards the camera, and what stands for further orders.
fn glow(clear: &[Volume; 2], camera: &Camera) -> Vec<[f32; 4]> {
    let [nx, ny, _] = clear[0].cells;
    let factor = clear[0].factor as f32;
    let mut glow = vec![[0.0; 4]; clear[0].values.len()];
    glow.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
        for (x, out) in out.iter_mut().enumerate() {
            let place = [x, row % ny, row / ny].map(|place| (place as f32 + 0.5) / factor);
            let eye = camera.toward_eye(place);
            let mut sum = AROUND;
            for (lamp, clear) in LAMPS.iter().zip(clear) {
                let light = orders(-dot(lamp.toward, eye), clear.values[row * nx + x]);
                for (sum, colour) in sum.iter_mut().zip(lamp.colour) {
                    *sum += light * colour;
                }
            }
            for channel in 0..3 {
                out[channel] = ALBEDO[channel] * sum[channel];
            }
        }
    });
    glow
}

/// The sum over orders of what arrives, `clear` of the light in the first one, turned by an angle of this `cosine`.
fn orders(cosine: f32, clear: f32) -> f32 {
    let (mut sum, mut share, mut clear, mut forward) = (0.0, 1.0, clear, FORWARD);
    for _ in 0..ORDERS {
        sum += share * clear * phase(cosine, forward);
        share *= SHARE;
        clear = clear.sqrt();
        forward *= 0.5;
    }
    sum
}

/// Henyey and Greenstein's phase function, 1 where it is even.
fn phase(cosine: f32, g: f32) -> f32 {
    let base = 1.0 + g * g - 2.0 * g * cosine;
    (1.0 - g * g) / (base * base.sqrt())
}
