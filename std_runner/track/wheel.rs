//! A flow in colours: the hue is where it goes, the brightness how fast.

use crate::output::{Colours, Picture};

/// The side of the wheel's own picture, in pixels.
const WHEEL: usize = 120;
/// The longer side of a picture of a flow, about, in pixels.
const LONGEST: usize = 320;

/// A flow at the centres of the cells of a plane, x fastest, rows from the bottom.
pub(crate) struct Plane {
    /// Cells across and up.
    pub cells: [usize; 2],
    pub flow: Vec<[f32; 2]>,
}

impl Plane {
    /// The largest speed.
    pub fn fastest(&self) -> f32 {
        self.flow.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f32::max)
    }

    /// The flow in colours, brightest at the speed `full`.
    pub fn picture(&self, full: f32) -> Picture {
        let [nx, ny] = self.cells;
        let pixels = (LONGEST / nx.max(ny).max(1)).max(1);
        let (width, height) = (nx * pixels, ny * pixels);
        let colour = |index: usize| {
            let (column, row) = (index % width, index / width);
            let cell = (ny - 1 - row / pixels) * nx + column / pixels;
            let [x, y] = self.flow.get(cell).copied().unwrap_or_default();
            of_flow([x / full.max(f32::MIN_POSITIVE), y / full.max(f32::MIN_POSITIVE)])
        };
        Picture {
            width,
            height,
            bytes: (0..width * height).flat_map(colour).collect(),
            colours: Colours::Each,
        }
    }
}

/// What the colours mean: every direction around the middle, faster outwards.
pub(crate) fn wheel() -> Picture {
    let middle = 0.5 * (WHEEL - 1) as f32;
    let colour = |index: usize| {
        let (column, row) = ((index % WHEEL) as f32, (index / WHEEL) as f32);
        let at = [(column - middle) / middle, (middle - row) / middle];
        if at[0].hypot(at[1]) > 1.0 {
            [255; 3]
        } else {
            of_flow(at)
        }
    };
    Picture {
        width: WHEEL,
        height: WHEEL,
        bytes: (0..WHEEL * WHEEL).flat_map(colour).collect(),
        colours: Colours::Each,
    }
}

/// The colour of a flow whose speed is in parts of the brightest.
fn of_flow([x, y]: [f32; 2]) -> [u8; 3] {
    let speed = x.hypot(y).min(1.0).sqrt();
    let turn = (y.atan2(x) / core::f32::consts::TAU).rem_euclid(1.0) * 6.0;
    let channel = |shift: f32| {
        let place = (turn + shift).rem_euclid(6.0);
        (2.0 - (place - 3.0).abs()).clamp(0.0, 1.0)
    };
    [3.0, 1.0, 5.0].map(|shift| (255.0 * speed * channel(shift)) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_colours() {
        assert_eq!(of_flow([0.0, 0.0]), [0, 0, 0]);
        assert_eq!(of_flow([1.0, 0.0]), [255, 0, 0]);
        let [red, green, blue] = of_flow([-1.0, 0.0]);
        assert!(red == 0 && green == 255 && blue == 255);
        let [red, green, blue] = of_flow([0.0, 1.0]);
        assert!((120..=135).contains(&red) && green == 255 && blue == 0);
    }
}
