//! A plane of smoke, seen face on, y up.

use super::light::arriving;
use super::smoke::Smoke;
use super::upscale::enlarge;

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

/// Width, height and brightness 0 ..= 1 of each pixel, from the top.
pub(super) fn photograph(smoke: &Smoke) -> (usize, usize, Vec<f32>) {
    let light = arriving(smoke, SHADE);
    let (width, height, density) = from_the_top(smoke, &smoke.values);
    let (_, _, light) = from_the_top(smoke, &light);
    let whole = 1.0 - (-OPACITY).exp();
    let glow = |(density, light): (f32, f32)| {
        let opacity = (1.0 - (-OPACITY * density.max(0.0)).exp()) / whole;
        opacity * (AMBIENT + (1.0 - AMBIENT) * light.clamp(0.0, 1.0))
    };
    (width, height, density.into_iter().zip(light).map(glow).collect())
}

/// Width, height and value -1 ..= 1 of each pixel, from the top.
pub(super) fn chart(smoke: &Smoke) -> (usize, usize, Vec<f32>) {
    let (width, height, values) = from_the_top(smoke, &smoke.values);
    (
        width,
        height,
        values.into_iter().map(|value| value.clamp(-1.0, 1.0)).collect(),
    )
}

/// Pixels of a picture of `nx` by `ny` cells.
pub(super) fn pixels(nx: usize, ny: usize) -> usize {
    let factor = factor(nx, ny);
    nx * factor * ny * factor
}

fn factor(nx: usize, ny: usize) -> usize {
    WIDTH.div_ceil(nx.max(1)).min((HEIGHT / ny.max(1)).max(1))
}

fn from_the_top(smoke: &Smoke, values: &[f32]) -> (usize, usize, Vec<f32>) {
    let [nx, _, ny] = smoke.cells;
    let factor = factor(nx, ny);
    let turned: Vec<f32> = values.chunks_exact(nx.max(1)).rev().flatten().copied().collect();
    (nx * factor, ny * factor, enlarge(&turned, nx, factor))
}
