//! Smoke as a photographer would light it: from density to colours.
//!
//! In a box of smoke, light of two lamps is absorbed on its way ([`lamp`]), each place scatters what arrives towards the eye
//! ([`stage`]), and rays gather it through the smoke before them ([`march`], [`deep`]). A plane is seen face on ([`flat`]).

mod arrows;
mod blocks;
mod camera;
mod deep;
mod flat;
mod grain;
mod lamp;
mod march;
mod mask;
pub(super) mod palette;
mod smoke;
mod stage;
mod streaks;
#[cfg(test)]
mod tests;
mod tone;
mod upscale;
mod volume;

pub(crate) use arrows::{Field, side as arrow_side};
pub(crate) use camera::Angles;
pub(crate) use deep::Shot;
pub(crate) use grain::Drift;
pub(crate) use smoke::{Body, DENSEST, Smoke};
pub(crate) use streaks::Streaks;

use rayon::prelude::*;

use super::picture::{Colours, Picture};

/// Bytes for each pixel: what its ray saw and its light, or its light, its colours and its file.
const PIXEL: usize = 28;
/// Bytes for each cell: density and body, and the density as it is drawn.
const CELL: usize = 12;
/// Bytes for each cell of the result: a field as it is read, in double precision and in single.
const READ: usize = 12;
/// Bytes for each of the cells that detail drifts on: two fields of it, the flow and one field that becomes another, or the copy that a picture has.
const DRIFT: usize = 48;

/// A picture before it becomes bytes: linear red, green and blue from the top, as a film would be lit.
pub(crate) struct Film {
    pub width: usize,
    pub height: usize,
    pub light: Vec<[f32; 3]>,
    /// Whether its colours are those of a map, which a screen shows as they are.
    flat: bool,
}

impl Film {
    /// What a screen shows.
    pub fn develop(&self) -> Picture {
        let mut bytes = vec![0; 3 * self.light.len()];
        let rows = bytes.par_chunks_mut(3 * self.width);
        let rows = rows.zip(self.light.par_chunks(self.width)).enumerate();
        rows.for_each(|(row, (bytes, light))| {
            let pixels = bytes.chunks_exact_mut(3).zip(light).enumerate();
            for (column, (bytes, light)) in pixels {
                // Rounding that differs from pixel to pixel shows no steps in the dark.
                let (shown, round) = if self.flat {
                    (light.map(tone::coded), 0.5)
                } else {
                    (tone::developed(*light), tone::scatter(column, row))
                };
                for (byte, shown) in bytes.iter_mut().zip(shown) {
                    *byte = (255.0 * shown + round).clamp(0.0, 255.0) as u8;
                }
            }
        });
        Picture {
            width: self.width,
            height: self.height,
            bytes,
            colours: Colours::Each,
        }
    }
}

/// What is drawn over a plane.
pub(crate) struct Over {
    pub streaks: Option<Streaks>,
    /// Arrows of a field, and the size of the longest one.
    pub arrows: Option<(Field, f32)>,
}

impl Smoke {
    /// Pixels of a picture of a grid of `cells`.
    pub fn pixels(cells: &[usize]) -> usize {
        match *cells {
            [nx, ny, nz] => deep::pixels([nx, ny, nz]),
            [nx, ny] => flat::pixels(nx, ny),
            _ => 0,
        }
    }

    /// Bytes that drawing a grid of `cells` takes at most, about: with `body` among solid cells, in 3D with detail that drifts on `coarse` cells.
    pub fn bytes(cells: &[usize], coarse: &[usize], body: bool, shot: &Shot) -> usize {
        let pixels = PIXEL.saturating_mul(shot.width * shot.height);
        let all = |cells: &[usize]| {
            cells
                .iter()
                .fold(1_usize, |all, &count| all.saturating_mul(count))
        };
        let drawn = match *cells {
            [nx, ny, nz] => {
                let detailed = shot.detail > 0.0;
                let drift = if detailed {
                    DRIFT.saturating_mul(all(coarse))
                } else {
                    0
                };
                stage::bytes([nx, ny, nz], shot.width.min(shot.height), detailed, body).saturating_add(drift)
            }
            _ => 0,
        };
        let fields = CELL
            .saturating_mul(all(cells))
            .saturating_add(READ.saturating_mul(all(coarse)));
        pixels.saturating_add(drawn).saturating_add(fields)
    }

    /// The smoke in its light, as a result shows it.
    pub fn photograph(&self) -> Picture {
        if self.flat {
            flat::photograph(self)
        } else {
            deep::photograph(self)
        }
    }

    /// Pixels of a cell of a plane which has so many `across`; nothing in a box.
    pub fn pixels_of(&self, across: usize, shot: &Shot) -> Option<f32> {
        self.flat.then(|| flat::stand(self, shot).pixels(across))
    }

    /// Draws over the picture of a plane.
    pub fn draw_over(&self, film: &mut Film, shot: &Shot, over: &Over) {
        let stand = flat::stand(self, shot);
        if let Some(streaks) = &over.streaks {
            streaks.draw(&mut film.light, &stand);
        }
        if let Some((field, strongest)) = &over.arrows {
            arrows::draw(&mut film.light, &stand, field, *strongest);
        }
    }

    /// The light of a picture as `shot` asks for it.
    pub fn expose(&self, shot: &Shot) -> Film {
        let light = if self.flat {
            flat::expose(self, shot)
        } else {
            let camera = camera::Camera::new(self.cells, shot.angles, shot.width, shot.height);
            deep::expose(self, &camera, shot.gain, false)
        };
        Film {
            width: shot.width,
            height: shot.height,
            flat: self.flat,
            light,
        }
    }

    /// The signed values themselves, for differences.
    pub fn chart(&self) -> Picture {
        if self.flat {
            flat::chart(self)
        } else {
            deep::chart(self)
        }
    }
}
