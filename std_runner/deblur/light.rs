//! Images as linear light, planes of the channels one after the other.

use crate::exit::Failure;
use crate::keyframes::{Measured, Series, ShapeError, ends_with, is_picture, measured};
use clap::ValueEnum;
use std::path::Path;

/// How an image stores light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Light {
    /// As screens show it, by the curve of sRGB.
    Srgb,
    /// As it is.
    Linear,
}

impl Light {
    /// What a file holds where nothing is said: pictures sRGB, EXR and arrays light as it is.
    pub fn of(path: &Path) -> Self {
        if is_picture(path) && !ends_with(path, "exr") {
            Self::Srgb
        } else {
            Self::Linear
        }
    }

    /// From a stored level to light.
    pub fn decoded(self, level: f64) -> f64 {
        match self {
            Self::Linear => level,
            Self::Srgb if level <= 0.04045 => level / 12.92,
            Self::Srgb => ((level + 0.055) / 1.055).powf(2.4),
        }
    }

    /// From light to a stored level.
    pub fn coded(self, light: f64) -> f64 {
        match self {
            Self::Linear => light,
            Self::Srgb if light <= 0.003_130_8 => 12.92 * light,
            Self::Srgb => 1.055 * light.powf(1.0 / 2.4) - 0.055,
        }
    }
}

/// An image in linear light.
pub(super) struct Image {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    /// Planes of the channels one after the other, row 0 at the top.
    pub values: Vec<f64>,
}

pub(super) fn failed(error: ShapeError) -> Failure {
    error.failure(error.to_string())
}

impl Image {
    /// Reads `path`, which `key` names.
    pub fn read(key: &str, path: &Path, light: Light) -> Result<Self, Failure> {
        let name = ends_with(path, "npz").then_some("image");
        let Measured {
            shape, mut values, ..
        } = measured(key, path, name).map_err(failed)?;
        if !is_picture(path) {
            whiten(key, path, name, &mut values)?;
        }
        let (height, width, channels) = match *shape {
            [height, width] => (height, width, 1),
            [height, width, channels @ (1 | 3)] => (height, width, channels),
            _ => {
                return Err(Failure::Input(format!(
                    "{key} `{}` has the shape {shape:?}; an image is rows x columns, or rows x columns x 3",
                    path.display()
                )));
            }
        };
        let pixels = width * height;
        let plane = |channel: usize| values.iter().skip(channel).step_by(channels);
        let image = Self {
            width,
            height,
            channels,
            values: (0..channels)
                .flat_map(plane)
                .map(|&level| light.decoded(level))
                .collect(),
        };
        let below = image.values.iter().position(|&value| value < 0.0);
        if let Some(at) = below {
            return Err(Failure::Input(format!(
                "{key} `{}` holds {} at row {}, column {}: light is at least 0; take off less of its background, or set what is below 0 to 0",
                path.display(),
                image.values.get(at).copied().unwrap_or_default(),
                at % pixels / width,
                at % width
            )));
        }
        Ok(image)
    }
}

/// Makes 1 the white of an array: bytes and words are parts of the largest that they can be, as in pictures, and of other whole numbers
/// nobody knows what white is.
fn whiten(key: &str, path: &Path, name: Option<&str>, values: &mut [f64]) -> Result<(), Failure> {
    // An array whose axes are reversed is no series; then its numbers have to tell.
    let kind = Series::open(path, name, key).map(|series| series.kind()).ok();
    let white = match kind.as_deref() {
        Some("u1") => 255.0,
        Some("u2") => 65535.0,
        _ => 1.0,
    };
    values.iter_mut().for_each(|value| *value /= white);
    let whole = match kind.as_deref() {
        Some(kind) => kind.starts_with(['i', 'u']),
        None => values.iter().all(|value| value.fract() == 0.0),
    };
    let largest = values.iter().copied().fold(0.0, f64::max);
    if whole && largest > 1.0 {
        return Err(Failure::Input(format!(
            "{key} `{}` holds whole numbers up to {largest}, and white is 1: divide them by the number that is white, as in image / 255.0",
            path.display()
        )));
    }
    Ok(())
}

/// Planes of the channels as values with the channel last.
pub(crate) fn interleaved(values: &[f64], channels: usize) -> Vec<f64> {
    let pixels = values.len() / channels.max(1);
    (0..values.len())
        .filter_map(|place| values.get(place % channels * pixels + place / channels).copied())
        .collect()
}
