//! A box of smoke: absorption and scattered light along parallel rays, over a floor that catches the shadow.

use super::camera::{Camera, Ray, Vector};
use super::light::arriving;
use super::smoke::Smoke;
use super::upscale::enlarge;

/// Pixels a sample.
const FACTOR: usize = 2;
/// Cells a step along a ray.
const STRIDE: f32 = 0.7;
/// Absorption of density 1 over the longest side, towards the eye.
const OPACITY: f32 = 16.0;
/// Absorption of the lamp's light over the longest side.
const SHADE: f32 = 9.0;
/// What is seen where no light of the lamp arrives.
const AMBIENT: f32 = 0.20;
/// The brightness of smoke in full light.
const LIT: f32 = 1.05;
/// The brightness of the floor, and of the edges of the box.
const FLOOR: f32 = 0.15;
const EDGE: f32 = 0.13;
/// Difference of density along a ray that counts as much, in parts of the longest side.
const DIFFERENCE: f32 = 0.15;

/// Width, height and brightness 0 ..= 1 of each pixel, from the top.
pub(super) fn photograph(smoke: &Smoke) -> (usize, usize, Vec<f32>) {
    let light = arriving(smoke, SHADE);
    picture(smoke, |camera, ray| {
        let mut brightness = 0.0;
        let mut clear = 1.0_f32;
        let mut distance = ray.near + 0.5 * STRIDE;
        while distance < ray.far && clear > 0.01 {
            let (density, lit) = sample(smoke, &light, camera.along(ray, distance));
            if density > 1e-3 {
                let opacity = 1.0 - (-OPACITY * density * STRIDE / smoke.longest()).exp();
                brightness += clear * opacity * (AMBIENT + (LIT - AMBIENT) * lit);
                clear *= 1.0 - opacity;
            }
            distance += STRIDE;
        }
        let floor = camera.floor(ray).map_or(0.0, |point| {
            let (_, lit) = sample(smoke, &light, point);
            FLOOR * (0.25 + 0.75 * lit)
        });
        (brightness, clear, floor)
    })
}

/// Width, height and value -1 ..= 1 of each pixel, from the top.
pub(super) fn chart(smoke: &Smoke) -> (usize, usize, Vec<f32>) {
    let camera = Camera::new(smoke.cells);
    let sum = |column: usize, row: usize| {
        let Some(ray) = camera.ray(column, row) else {
            return 0.0;
        };
        let steps = ((ray.far - ray.near) / STRIDE) as usize;
        let at = |step: usize| {
            sample(
                smoke,
                &smoke.values,
                camera.along(&ray, ray.near + (step as f32 + 0.5) * STRIDE),
            )
            .0
        };
        let total: f32 = (0..steps).map(at).sum::<f32>() * STRIDE / smoke.longest();
        total.signum() * (1.0 - (-total.abs() / DIFFERENCE).exp())
    };
    enlarged(&camera, sum)
}

/// Smoke before the floor and the edges of the box; `look` gives brightness, clearness and the floor behind.
fn picture(smoke: &Smoke, look: impl Fn(&Camera, &Ray) -> (f32, f32, f32)) -> (usize, usize, Vec<f32>) {
    let camera = Camera::new(smoke.cells);
    let pixel = |column: usize, row: usize| {
        let edge = EDGE * (1.5 - camera.edge_distance(column, row)).clamp(0.0, 1.0);
        let (brightness, clear, floor) = camera
            .ray(column, row)
            .map_or((0.0, 1.0, 0.0), |ray| look(&camera, &ray));
        brightness + clear * (floor + edge)
    };
    enlarged(&camera, pixel)
}

/// Pixels of a picture of a box of `cells`.
pub(super) fn pixels(cells: [usize; 3]) -> usize {
    let camera = Camera::new(cells);
    camera.width * FACTOR * camera.height * FACTOR
}

fn enlarged(camera: &Camera, pixel: impl Fn(usize, usize) -> f32) -> (usize, usize, Vec<f32>) {
    let places = (0..camera.height).flat_map(|row| (0..camera.width).map(move |column| (column, row)));
    let small: Vec<f32> = places.map(|(column, row)| pixel(column, row)).collect();
    (
        camera.width * FACTOR,
        camera.height * FACTOR,
        enlarge(&small, camera.width, FACTOR),
    )
}

/// Density and `light` at a point, trilinear between cell centres; there is no smoke beyond the walls' cells.
fn sample(smoke: &Smoke, light: &[f32], point: Vector) -> (f32, f32) {
    let mut low = [0_usize; 3];
    let mut high = [0_usize; 3];
    let mut part = [0.0_f32; 3];
    for axis in 0..3 {
        let last = smoke.cells[axis] - 1;
        let place = (point[axis] - 0.5).clamp(0.0, last as f32);
        low[axis] = place as usize;
        high[axis] = (low[axis] + 1).min(last);
        part[axis] = place - low[axis] as f32;
    }
    let [nx, ny, _] = smoke.cells;
    let (mut density, mut lit) = (0.0, 0.0);
    for corner in 0..8 {
        let pick = |axis: usize| {
            if (corner >> axis) & 1 == 1 {
                (high[axis], part[axis])
            } else {
                (low[axis], 1.0 - part[axis])
            }
        };
        let [(x, wx), (y, wy), (z, wz)] = [pick(0), pick(1), pick(2)];
        let (cell, weight) = ((z * ny + y) * nx + x, wx * wy * wz);
        density += weight * smoke.values[cell];
        lit += weight * light[cell];
    }
    (density, lit)
}
