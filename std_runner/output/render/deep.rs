//! A box of smoke: pictures by rays from a camera.

use rayon::prelude::*;

use super::camera::{Angles, Camera};
use super::march::look;
use super::palette::{Palette, signed};
use super::smoke::Smoke;
use super::stage::{CUTS, Stage};
use super::tone::{developed, scatter};
use super::upscale::enlarge;
use super::volume::Volume;
use crate::output::picture::{Colours, Picture};

/// Samples across the pictures of a result, and from top to bottom at most.
const ACROSS: usize = 256;
const DOWN: usize = 512;
/// Pixels a sample of them.
const FACTOR: usize = 2;
/// Cells are cut so often for pictures of a result, at most.
const FEW_CUTS: usize = 2;
/// Cells a step along a ray through a difference.
const STRIDE: f32 = 0.7;
/// Difference of density along a ray that counts as much, in parts of the longest side.
const DIFFERENCE: f32 = 0.15;
/// Where in a pixel rays go at the edge of a body, in parts of it; elsewhere one goes through its middle.
const SPREAD: [[f32; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// How a picture is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    pub width: usize,
    pub height: usize,
    pub angles: Angles,
    /// By what light is multiplied.
    pub gain: f32,
    /// In 3D, how much detail finer than the cells is made up, 0 ..= 1.
    pub detail: f32,
}

/// The light of every pixel; with `even` all rays step in line, which leaves no grain.
pub(super) fn expose(smoke: &Smoke, camera: &Camera, gain: f32, even: bool) -> Vec<[f32; 3]> {
    let cuts = if even { FEW_CUTS } else { CUTS };
    let stage = Stage::new(smoke, camera, camera.width.min(camera.height), cuts);
    let width = camera.width;
    let at = |pixel: usize, [x, y]: [f32; 2], begin: f32| {
        let (column, row) = (pixel % width, pixel / width);
        let ray = camera.ray(column as f32 + x, row as f32 + y);
        let jitter = if even { 0.5 } else { scatter(column, row) };
        look(&stage, &ray, (jitter + begin).fract())
    };
    let middle = |pixel| at(pixel, [0.5; 2], 0.0);
    let seen: Vec<_> = (0..width * camera.height).into_par_iter().map(middle).collect();
    let smooth = |pixel: usize| {
        let (light, distance) = seen[pixel];
        if stage.body.is_none() || !is_edge(&seen, width, pixel, distance) {
            return light.map(|light| gain * light);
        }
        let mut sum = [0.0; 3];
        for (index, place) in SPREAD.into_iter().enumerate() {
            let (light, _) = at(pixel, place, 0.25 * index as f32);
            (0..3).for_each(|channel| sum[channel] += 0.25 * gain * light[channel]);
        }
        sum
    };
    (0..seen.len()).into_par_iter().map(smooth).collect()
}

/// Whether a body ends at a pixel: a neighbour's ray ends at least some cells nearer or further.
fn is_edge(seen: &[([f32; 3], f32)], width: usize, pixel: usize, distance: f32) -> bool {
    const STEP: f32 = 2.0;
    let column = pixel % width;
    let left = (column > 0).then(|| pixel - 1);
    let right = (column + 1 < width).then_some(pixel + 1);
    let neighbours = [left, right, pixel.checked_sub(width), Some(pixel + width)];
    let apart = |other: &([f32; 3], f32)| distance != other.1 && !((distance - other.1).abs() < STEP);
    neighbours
        .into_iter()
        .flatten()
        .filter_map(|other| seen.get(other))
        .any(apart)
}

/// The picture of a result.
pub(super) fn photograph(smoke: &Smoke) -> Picture {
    let camera = Camera::fitting(smoke.cells, Angles::default(), ACROSS, DOWN);
    let colours: Vec<[f32; 3]> = expose(smoke, &camera, 1.0, true)
        .into_iter()
        .map(developed)
        .collect();
    let channels = [0, 1, 2].map(|channel| {
        let small: Vec<f32> = colours.iter().map(|colour| colour[channel]).collect();
        enlarge(&small, camera.width, FACTOR)
    });
    let byte = |value: f32| (value * 255.0).round().clamp(0.0, 255.0) as u8;
    let [red, green, blue] = channels;
    let pixels = red.into_iter().zip(green).zip(blue);
    Picture {
        width: camera.width * FACTOR,
        height: camera.height * FACTOR,
        bytes: pixels
            .flat_map(|((red, green), blue)| [red, green, blue].map(byte))
            .collect(),
        colours: Colours::Each,
    }
}

/// The picture of a difference, which is summed along each ray as far as a body.
pub(super) fn chart(smoke: &Smoke) -> Picture {
    let camera = Camera::fitting(smoke.cells, Angles::default(), ACROSS, DOWN);
    let values = Volume::refined(&smoke.values, smoke.cells, 1);
    let body = smoke.body.as_ref();
    let body = body.map(|body| Volume::refined(&body.0, smoke.cells, 1));
    let is_body = |point| body.as_ref().is_some_and(|body| body.at(point) > 0.5);
    let difference = |sample: usize| {
        let (column, row) = (sample % camera.width, sample / camera.width);
        let ray = camera.ray(column as f32 + 0.5, row as f32 + 0.5);
        let steps = ((ray.far - ray.near) / STRIDE) as usize;
        let mut points = (0..steps).map(|step| ray.along(ray.near + (step as f32 + 0.5) * STRIDE));
        let mut sum = 0.0;
        let ended = points.find(|&point| {
            sum += values.at(point) * STRIDE / smoke.longest();
            is_body(point)
        });
        let value = f32::signum(sum) * (1.0 - (-sum.abs() / DIFFERENCE).exp());
        (value, ended.map_or(0.0, |_| 1.0 - value.abs()))
    };
    let (small, covered): (Vec<f32>, Vec<f32>) = (0..camera.width * camera.height).map(difference).unzip();
    let levels = enlarge(&small, camera.width, FACTOR).into_iter().map(signed);
    let (bytes, colours) = if body.is_some() {
        let parts = enlarge(&covered, camera.width, FACTOR).into_iter();
        let parts = parts.map(|part| part.clamp(0.0, 1.0));
        (Palette::Difference.behind(levels, parts), Colours::Each)
    } else {
        (levels.collect(), Colours::Of(Palette::Difference))
    };
    Picture {
        width: camera.width * FACTOR,
        height: camera.height * FACTOR,
        bytes,
        colours,
    }
}

/// Pixels of a picture of a result of `cells`.
pub(super) fn pixels(cells: [usize; 3]) -> usize {
    let camera = Camera::fitting(cells, Angles::default(), ACROSS, DOWN);
    camera.width * FACTOR * camera.height * FACTOR
}
