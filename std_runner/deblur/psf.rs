//! Kernels: named shapes, an image or array, or several with an index image.

use super::light::failed;
use crate::exit::Failure;
use crate::keyframes::{ends_with, is_picture, measured};
use std::path::Path;
use thurible_core::deblur::{Blur, Frame};

/// Samples along a side of a number of a kernel.
const FINE: usize = 16;
/// Between its samples a narrower Gaussian is not seen.
const LEAST_SIGMA: f64 = 0.05;
/// Kernels of a greater radius are refused.
const MOST: usize = 127;
/// More kernels than a pixel's index can name.
const MANY: usize = 1 << 16;

/// Kernels as they are read.
pub(crate) struct Psf {
    pub radius: usize,
    /// (2R + 1)^2 numbers each, of sum 1.
    pub values: Vec<f64>,
    /// The kernel of each pixel, where there are several.
    pub which: Vec<u16>,
}

fn refuse(text: &str, why: impl core::fmt::Display) -> Failure {
    Failure::Input(format!("--psf {text}: {why}"))
}

impl Psf {
    /// `disc:R`, `motion:LENGTH,DEGREES`, `gaussian:SIGMA`, or a file; a `.npz` with `kernels` (K, s, s) and `index` (rows, columns) has
    /// one for each of the `size` pixels.
    pub fn read(text: &str, size: [usize; 2]) -> Result<Self, Failure> {
        match text.split_once(':') {
            Some(("disc", rest)) => {
                let radius = number(text, rest)?;
                shape(text, radius, move |x, y| {
                    f64::from(u8::from(x * x + y * y <= radius * radius))
                })
            }
            Some(("gaussian", rest)) => {
                let sigma = number(text, rest)?;
                gaussian(text, sigma)
            }
            Some(("motion", rest)) => {
                let (length, angle) = rest.split_once(',').unwrap_or((rest, "0"));
                motion(text, number(text, length)?, angle)
            }
            _ => Self::of_file(text, size),
        }
    }

    /// What it makes of planes of light whose border has the kernel's radius, for an image of so many pixels across and down and so many channels.
    pub fn blurred(&self, planes: &[f64], [width, height, channels]: [usize; 3]) -> Vec<f64> {
        let blur = Blur {
            frame: Frame {
                width,
                height,
                channels,
                border: self.radius,
            },
            values: &self.values,
            which: &self.which,
        };
        let mut image = vec![0.0; blur.frame.pixels() * channels];
        let planes = planes.chunks_exact(blur.frame.unknowns());
        let images = image.chunks_exact_mut(blur.frame.pixels());
        planes
            .zip(images)
            .for_each(|(plane, image)| blur.apply(plane, image));
        image
    }

    fn of_file(text: &str, size: [usize; 2]) -> Result<Self, Failure> {
        let path = Path::new(text);
        let ends = |end: &str| ends_with(path, end);
        if ends("npz") {
            return Self::field(text, path, size);
        }
        if !(ends("npy") || is_picture(path)) {
            let why = "is neither a shape nor a file of kernels; write disc:3, motion:11,30, gaussian:1.5, or name a picture, .npy or .npz";
            return Err(refuse(text, why));
        }
        let read = measured("psf", path, None).map_err(failed)?.grey();
        let [height, width] = read.shape[..] else {
            return Err(refuse(
                text,
                format!("has the shape {:?}; a kernel is rows x columns", read.shape),
            ));
        };
        let values = square(&read.values, width, height);
        Ok(Self {
            radius: width.max(height) / 2,
            values: normal(text, values)?,
            which: Vec::new(),
        })
    }

    fn field(text: &str, path: &Path, [width, height]: [usize; 2]) -> Result<Self, Failure> {
        let kernels = measured("psf", path, Some("kernels")).map_err(failed)?;
        let index = measured("psf", path, Some("index")).map_err(failed)?;
        let [count, high, wide] = kernels.shape[..] else {
            let why = format!(
                "`kernels` has the shape {:?}; it is count x rows x columns",
                kernels.shape
            );
            return Err(refuse(text, why));
        };
        if count * high * wide == 0 {
            let why = format!(
                "`kernels` has the shape {:?}, which holds no number; give at least one kernel of at least 1 x 1",
                kernels.shape
            );
            return Err(refuse(text, why));
        }
        if count > MANY {
            let why = format!(
                "`kernels` has {count} kernels, and there may be {MANY}; share those that are nearly the same"
            );
            return Err(refuse(text, why));
        }
        if index.shape != [height, width] {
            let why = format!(
                "`index` has the shape {:?}, and the image {height} x {width} pixels",
                index.shape
            );
            return Err(refuse(text, why));
        }
        if let Some(odd) = index
            .values
            .iter()
            .find(|&&which| !(which >= 0.0 && which.fract() == 0.0 && (which as usize) < count))
        {
            return Err(refuse(
                text,
                format!(
                    "`index` names the kernel {odd}; they are whole numbers from 0 to {}",
                    count - 1
                ),
            ));
        }
        let mut values = Vec::new();
        for kernel in kernels.values.chunks_exact(high * wide) {
            values.extend(normal(text, square(kernel, wide, high))?);
        }
        Ok(Self {
            radius: wide.max(high) / 2,
            values,
            which: index.values.iter().map(|&which| which as u16).collect(),
        })
    }
}

fn number(text: &str, found: &str) -> Result<f64, Failure> {
    match found.trim().parse() {
        Ok(number) if number > 0.0 && number < MOST as f64 => Ok(number),
        _ => Err(refuse(
            text,
            format!("found \"{found}\", allowed is a number of pixels above 0 and below {MOST}"),
        )),
    }
}

/// A kernel of odd sides, the smaller one in its middle.
fn square(values: &[f64], width: usize, height: usize) -> Vec<f64> {
    let radius = width.max(height) / 2;
    let side = 2 * radius + 1;
    let mut kernel = vec![0.0; side * side];
    for (number, &value) in values.iter().enumerate() {
        let (x, y) = (
            number % width + radius - width / 2,
            number / width + radius - height / 2,
        );
        if let Some(place) = kernel.get_mut(y * side + x) {
            *place = value;
        }
    }
    kernel
}

/// The kernel with sum 1.
fn normal(text: &str, mut values: Vec<f64>) -> Result<Vec<f64>, Failure> {
    if let Some(below) = values.iter().find(|value| **value < 0.0) {
        return Err(refuse(
            text,
            format!("holds {below}; a kernel spreads light and takes none: set what is below 0 to 0"),
        ));
    }
    let sum: f64 = values.iter().sum();
    if !(sum > 0.0) {
        return Err(refuse(
            text,
            "sums to nothing, so no light arrives; give a kernel with light in it",
        ));
    }
    values.iter_mut().for_each(|value| *value /= sum);
    Ok(values)
}

/// Pixels from the middle of a kernel to its border, where it reaches `reach` pixels.
fn radius_of(reach: f64) -> usize {
    (reach - 0.5).ceil().max(0.0) as usize
}

/// Where part `part` of [`FINE`] of pixel `number` of a row lies, from the middle.
fn place(radius: usize, number: usize, part: usize) -> f64 {
    number as f64 - radius as f64 + (part as f64 + 0.5) / FINE as f64 - 0.5
}

/// exp(-(x^2 + y^2) / (2 sigma^2)), a product of one for each axis, and so are its means.
fn gaussian(text: &str, sigma: f64) -> Result<Psf, Failure> {
    if sigma < LEAST_SIGMA {
        let why =
            format!("found \"{sigma}\", allowed is a standard deviation of {LEAST_SIGMA} pixels or more");
        return Err(refuse(text, why));
    }
    let radius = radius_of(3.0 * sigma);
    let density = |x: f64| (-0.5 * x * x / (sigma * sigma)).exp();
    let mean = |number: usize| -> f64 { (0..FINE).map(|part| density(place(radius, number, part))).sum() };
    let means: Vec<f64> = (0..=2 * radius).map(mean).collect();
    let rows = means
        .iter()
        .map(|down| means.iter().map(move |across| down * across));
    Ok(Psf {
        radius,
        values: normal(text, rows.flatten().collect())?,
        which: Vec::new(),
    })
}

/// The means of a density over the numbers of a kernel that reaches `reach` pixels.
fn shape(text: &str, reach: f64, density: impl Fn(f64, f64) -> f64) -> Result<Psf, Failure> {
    let radius = radius_of(reach);
    let side = 2 * radius + 1;
    let mean = |number: usize| -> f64 {
        (0..FINE * FINE)
            .map(|part| {
                density(
                    place(radius, number % side, part % FINE),
                    place(radius, number / side, part / FINE),
                )
            })
            .sum()
    };
    Ok(Psf {
        radius,
        values: normal(text, (0..side * side).map(mean).collect())?,
        which: Vec::new(),
    })
}

/// A straight way of `length` pixels, turned by some degrees from the right upwards, as wide as a pixel.
fn motion(text: &str, length: f64, angle: &str) -> Result<Psf, Failure> {
    let degrees: f64 = angle
        .trim()
        .parse()
        .ok()
        .filter(|degrees: &f64| degrees.is_finite())
        .ok_or_else(|| refuse(text, format!("found \"{angle}\", allowed is an angle in degrees")))?;
    let (turn, half) = (degrees.to_radians(), 0.5 * length);
    let (cos, sin) = (turn.cos(), -turn.sin());
    shape(text, half, move |x, y| {
        let (along, across) = (x * cos + y * sin, -x * sin + y * cos);
        f64::from(u8::from(along.abs() <= half && across.abs() <= 0.5))
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A Gaussian is a product of one for each axis.
    #[test]
    fn a_gaussian_has_the_means_of_its_density() {
        for sigma in [0.3, 1.5, 4.0] {
            let density = |x: f64, y: f64| (-0.5 * (x * x + y * y) / (sigma * sigma)).exp();
            let (one, other) = (
                gaussian("", sigma).unwrap(),
                shape("", 3.0 * sigma, density).unwrap(),
            );
            assert_eq!(one.radius, other.radius);
            let pairs = one.values.iter().zip(&other.values);
            assert!(
                pairs
                    .clone()
                    .all(|(one, other)| (one - other).abs() < 1e-14 * (1.0 + other))
            );
            assert!(pairs.len() == (2 * one.radius + 1).pow(2));
        }
    }
}
