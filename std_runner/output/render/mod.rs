//! Smoke as a photographer would light it: from density to levels of light.
//!
//! A plane and a box of smoke take the same path: light falls from above and is absorbed on its way
//! ([`light`]), then the eye sees what each cell scatters, attenuated by the smoke before it ([`flat`], [`deep`]).

mod camera;
mod deep;
mod flat;
mod light;
pub(super) mod palette;
mod upscale;

use super::picture::Picture;
use palette::Palette;

/// Densities as they are drawn, 1 where the source is densest. In 2D there is one cell along y, and z is up.
pub(super) struct Smoke {
    cells: [usize; 3],
    values: Vec<f32>,
    flat: bool,
}

impl Smoke {
    /// `density` of a grid of `cells`, divided by `full`.
    pub fn new(cells: &[usize], density: Vec<f32>, full: f32) -> Self {
        let scale = if full > 0.0 { 1.0 / full } else { 1.0 };
        let drawn = |value: f32| {
            if value.is_finite() {
                (value * scale).clamp(-2.0, 2.0)
            } else {
                0.0
            }
        };
        let values = density.into_iter().map(drawn).collect();
        match *cells {
            [nx, ny, nz] => Self {
                cells: [nx, ny, nz],
                values,
                flat: false,
            },
            [nx, ny] => Self {
                cells: [nx, 1, ny],
                values,
                flat: true,
            },
            _ => Self {
                cells: [values.len(), 1, 1],
                values,
                flat: true,
            },
        }
    }

    /// Pixels of a picture of a grid of `cells`.
    pub fn pixels(cells: &[usize]) -> usize {
        match *cells {
            [nx, ny, nz] => deep::pixels([nx, ny, nz]),
            [nx, ny] => flat::pixels(nx, ny),
            _ => 0,
        }
    }

    /// What `self` has more than `other`, negative where it has less.
    pub fn minus(&self, other: &Self) -> Self {
        let values = self
            .values
            .iter()
            .zip(&other.values)
            .map(|(mine, theirs)| mine - theirs)
            .collect();
        Self { values, ..*self }
    }

    /// The smoke in its light.
    pub fn photograph(&self) -> Picture {
        let (width, height, brightness) = if self.flat {
            flat::photograph(self)
        } else {
            deep::photograph(self)
        };
        let levels = brightness
            .into_iter()
            .map(|value| (value * 255.0).round().clamp(0.0, 255.0) as u8)
            .collect();
        Picture {
            width,
            height,
            levels,
            palette: Palette::Smoke,
        }
    }

    /// The signed values themselves, for differences.
    pub fn chart(&self) -> Picture {
        let (width, height, values) = if self.flat {
            flat::chart(self)
        } else {
            deep::chart(self)
        };
        let levels = values
            .into_iter()
            .map(|value| (128.0 + value * 127.0).round().clamp(0.0, 255.0) as u8)
            .collect();
        Picture {
            width,
            height,
            levels,
            palette: Palette::Difference,
        }
    }

    /// Cells of the longest side.
    fn longest(&self) -> f32 {
        self.cells.iter().copied().max().unwrap_or(1) as f32
    }
}
