//! Smoke as a photographer would light it: from density to levels of light.
//!
//! A plane and a box of smoke take the same path: light falls from above and is absorbed on its way
//! ([`light`]), then the eye sees what each cell scatters, attenuated by the smoke before it ([`flat`], [`deep`]).

mod camera;
mod deep;
mod flat;
mod light;
pub(super) mod palette;
mod smoke;
mod upscale;

pub(super) use smoke::Smoke;

use super::picture::Picture;
use palette::Palette;

impl Smoke {
    /// Pixels of a picture of a grid of `cells`.
    pub fn pixels(cells: &[usize]) -> usize {
        match *cells {
            [nx, ny, nz] => deep::pixels([nx, ny, nz]),
            [nx, ny] => flat::pixels(nx, ny),
            _ => 0,
        }
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
}
