//! The lamps, and how much of their light arrives at each cell.

use super::camera::Vector;
use super::volume::Volume;

/// A lamp far away.
pub(super) struct Lamp {
    /// The way to it, of length 1.
    pub toward: Vector,
    /// Its light, linear red, green and blue.
    pub colour: [f32; 3],
}

/// A warm one to the left, above and a little behind, and a cool one to the right in front.
pub(super) const LAMPS: [Lamp; 2] = [
    Lamp {
        toward: [-0.736, 0.140, 0.662],
        colour: [1.30, 1.03, 0.74],
    },
    Lamp {
        toward: [0.80, -0.50, 0.332],
        colour: [0.12, 0.18, 0.30],
    },
];

/// What a cell of a body adds to the way of light, in cells of density 1.
const SOLID: f32 = 40.0;

/// Density along the way of light from each cell to the lamp, in cells of the smoke, on a grid of cells cut `factor` times. Layer
/// by layer away from the lamp, each taking from the one before where its ray came through, so that shadows grow softer with distance.
pub(super) fn shade(
    cells: [usize; 3],
    factor: usize,
    density: &[f32],
    body: Option<&Volume>,
    toward: Vector,
) -> Vec<f32> {
    let strides = [1, cells[0], cells[0] * cells[1]];
    let main = (0..3).max_by(|&a, &b| toward[a].abs().total_cmp(&toward[b].abs()));
    let main = main.unwrap_or(2);
    let [across, along] = [(main + 1) % 3, (main + 2) % 3];
    let shift = [across, along].map(|axis| toward[axis] / toward[main].abs());
    let way = (1.0 + shift[0] * shift[0] + shift[1] * shift[1]).sqrt() / factor as f32;
    let size = [cells[across], cells[along]];
    let step = [strides[across], strides[along]];
    let thick = |cell: usize| {
        let solid = body.map_or(0.0, |body| {
            let place = [0, 1, 2].map(|axis| ((cell / strides[axis]) % cells[axis]) as f32 + 0.5);
            SOLID * (2.0 * body.at(place.map(|place| place / factor as f32)) - 0.8).max(0.0)
        });
        density[cell].max(0.0) + solid
    };
    let mut shade = vec![0.0; density.len()];
    // What a layer hands to the next one: the way through all before it and through itself.
    let mut passed = vec![0.0; size[0] * size[1]];
    for layer in 0..cells[main] {
        let layer = if toward[main] > 0.0 {
            cells[main] - 1 - layer
        } else {
            layer
        };
        let first = layer * strides[main];
        let mut next = vec![0.0; passed.len()];
        for (row, next) in next.chunks_exact_mut(size[0].max(1)).enumerate() {
            let start = first + row * step[1];
            for (column, next) in next.iter_mut().enumerate() {
                let cell = start + column * step[0];
                let own = 0.5 * way * thick(cell);
                let before = came(&passed, size, column as f32 + shift[0], row as f32 + shift[1]);
                shade[cell] = before + own;
                *next = before + 2.0 * own;
            }
        }
        passed = next;
    }
    shade
}

/// Bilinear; from beyond the box light comes freely.
fn came(layer: &[f32], size: [usize; 2], x: f32, y: f32) -> f32 {
    let (left, low) = (x.floor(), y.floor());
    let (right, high) = (x - left, y - low);
    let at = |x: f32, y: f32| {
        let inside = x >= 0.0 && y >= 0.0 && x < size[0] as f32 && y < size[1] as f32;
        if inside {
            layer[y as usize * size[0] + x as usize]
        } else {
            0.0
        }
    };
    let below = at(left, low) * (1.0 - right) + at(left + 1.0, low) * right;
    if high == 0.0 {
        return below;
    }
    below * (1.0 - high) + (at(left, low + 1.0) * (1.0 - right) + at(left + 1.0, low + 1.0) * right) * high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_through_even_smoke_is_its_length() {
        for (toward, cell) in [
            ([0.0, 0.0, 1.0], 0),
            ([0.0, 0.0, -1.0], 215),
            ([1.0, 0.0, 0.0], 0),
        ] {
            let shade = shade([6; 3], 1, &[1.0; 216], None, toward);
            assert!((shade[cell] - 5.5).abs() < 1e-5, "{toward:?}: {}", shade[cell]);
        }
    }
}
