//! How much of the lamp's light arrives at each cell.

use super::smoke::Smoke;

/// Where the lamp stands, seen from the smoke: to the left, a little to the front, and above. The sweep goes down
/// layer by layer, so these are cells per layer.
const LEFT: f32 = -0.55;
const FRONT: f32 = -0.40;

/// The part of the light that arrives, 0 ..= 1, at every cell; `strength` is the absorption over the longest side.
pub(super) fn arriving(smoke: &Smoke, strength: f32) -> Vec<f32> {
    let [nx, ny, nz] = smoke.cells;
    let front = if smoke.flat { 0.0 } else { FRONT };
    let way = (1.0 + LEFT * LEFT + front * front).sqrt();
    let absorption = strength * way / smoke.longest();
    let layer = nx * ny;
    let mut light = vec![1.0; smoke.values.len()];
    // What passes through a layer downwards; above the box all of it does.
    let mut passing = vec![1.0; layer];
    for z in (0..nz).rev() {
        let density = &smoke.values[z * layer..][..layer];
        let here = &mut light[z * layer..][..layer];
        for y in 0..ny {
            for x in 0..nx {
                let from_above = sample(&passing, [nx, ny], x as f32 + LEFT, y as f32 + front);
                let cell = y * nx + x;
                here[cell] = from_above * (-0.5 * absorption * density[cell].max(0.0)).exp();
            }
        }
        for ((passing, light), density) in passing.iter_mut().zip(here.iter()).zip(density) {
            *passing = light * (-0.5 * absorption * density.max(0.0)).exp();
        }
    }
    light
}

/// Bilinear; beyond the box the light is full.
fn sample(layer: &[f32], [nx, ny]: [usize; 2], x: f32, y: f32) -> f32 {
    let (x0, y0) = (x.floor(), y.floor());
    let (right, back) = (x - x0, y - y0);
    let at = |x: f32, y: f32| {
        let inside = x >= 0.0 && y >= 0.0 && x < nx as f32 && y < ny as f32;
        if inside {
            layer[y as usize * nx + x as usize]
        } else {
            1.0
        }
    };
    let front_row = at(x0, y0) * (1.0 - right) + at(x0 + 1.0, y0) * right;
    if back == 0.0 {
        return front_row;
    }
    let back_row = at(x0, y0 + 1.0) * (1.0 - right) + at(x0 + 1.0, y0 + 1.0) * right;
    front_row * (1.0 - back) + back_row * back
}
