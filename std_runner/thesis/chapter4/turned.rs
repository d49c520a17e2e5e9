//! The kernels of a camera that was turned while its shutter was open.

use super::super::bench::{Bench, Halt};
use super::super::doors::put;
use std::path::PathBuf;

/// Kernels along a side of the image.
const PARTS: usize = 12;
/// By how much the image moves in its corner, in pixels, and the radius of the kernels.
const FARTHEST: f64 = 9.0;
const RADIUS: usize = 5;
/// Places along the way of a pixel.
const FINE: usize = 64;

/// The file of kernels for an image of `side` x `side`: one for each of its parts.
pub(super) fn kernels(bench: &mut Bench<'_>, side: usize) -> Result<PathBuf, Halt> {
    let kernels: Vec<f64> = (0..PARTS * PARTS)
        .flat_map(|part| kernel((part % PARTS) as f64, (part / PARTS) as f64))
        .collect();
    let index: Vec<f64> = (0..side * side)
        .map(|pixel| {
            let part = |at: usize| at * PARTS / side;
            (part(pixel / side) * PARTS + part(pixel % side)) as f64
        })
        .collect();
    let wide = 2 * RADIUS + 1;
    let made = bench.files("turned/kernels", &["kernels.npz"], |folder| {
        put(
            &folder.join("kernels.npz"),
            &[
                ("kernels", &[wide, wide, PARTS * PARTS], &kernels),
                ("index", &[side, side], &index),
            ],
        )
    })?;
    Ok(made.folder.join("kernels.npz"))
}

/// The way of the middle of a part about the middle of the image, spread over the pixels that it touches.
fn kernel(across: f64, down: f64) -> Vec<f64> {
    let middle = 0.5 * PARTS as f64;
    let [x, y] = [across, down].map(|part| (part + 0.5 - middle) / (middle * core::f64::consts::SQRT_2));
    // A turn moves what is at (x, y) along (-y, x).
    let way = [-y * FARTHEST, x * FARTHEST];
    let wide = 2 * RADIUS + 1;
    let mut values = vec![0.0; wide * wide];
    for place in 0..FINE {
        let part = (place as f64 + 0.5) / FINE as f64 - 0.5;
        let [right, below] = way.map(|way| part * way + RADIUS as f64);
        for corner in 0..4 {
            let (column, row) = (
                right.floor() as usize + corner % 2,
                below.floor() as usize + corner / 2,
            );
            let weight = (1.0 - (right - column as f64).abs()) * (1.0 - (below - row as f64).abs());
            if let Some(value) = values.get_mut(row * wide + column).filter(|_| column < wide) {
                *value += weight / FINE as f64;
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_keep_all_light_and_grow_outwards() {
        let reach = |values: &[f64]| values.iter().filter(|value| **value > 0.0).count();
        for part in 0..PARTS * PARTS {
            let kernel = kernel((part % PARTS) as f64, (part / PARTS) as f64);
            assert!((kernel.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert!(reach(&kernel(0.0, 0.0)) > 2 * reach(&kernel(5.0, 5.0)));
    }
}
