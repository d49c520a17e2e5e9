//! Photographs of sharp images: blurred, with noise, in files that `thurible deblur` reads; and what it is asked for.

use super::super::bench::{Bench, Halt, Made};
use super::super::doors::put;
use super::super::truth::unread;
use super::images::Sharp;
use crate::deblur::{Light, Psf, Request, interleaved};
use crate::keyframes::measured;
use crate::output::colour_plate;
use crate::problem::Precision;
use crate::progress::Mode;
use crate::report::{Shot, product};
use std::path::PathBuf;
use std::rc::Rc;
use thurible_core::deblur::Tuning;
use thurible_core::walk::Random;

/// Standard deviation of the noise of a photograph.
const NOISE: f64 = 0.005;

/// A blurred photograph, and the sharp image.
pub(super) struct Photograph {
    pub made: Rc<Made>,
    pub psf: String,
    pub side: usize,
    pub channels: usize,
    /// The blurred image and the sharp one, the channel last.
    pictures: [Vec<f64>; 2],
}

impl Photograph {
    /// What was photographed, and the photograph.
    pub fn shots(&self) -> Result<Vec<Shot>, Halt> {
        let [seen, truth] = &self.pictures;
        let shot = |(caption, light): (&str, &Vec<f64>)| shot(caption, light, self.side, self.channels);
        [("sharp", truth), ("photograph", seen)]
            .into_iter()
            .map(shot)
            .collect()
    }

    /// A file of it: `blurred.npz` or `sharp.npz`.
    pub fn file(&self, name: &str) -> PathBuf {
        self.made.folder.join(name)
    }

    /// Its size as rows have it.
    pub fn size(&self) -> String {
        let pixels = product(&[self.side, self.side]);
        let colour = if self.channels > 1 { ", colour" } else { "" };
        format!("{pixels} pixels{colour}")
    }

    /// What `thurible deblur` is asked for.
    pub fn request(&self, tuning: Tuning, precision: Precision) -> Request {
        Request {
            image: self.file("blurred.npz"),
            psf: self.psf.clone(),
            light: Some(Light::Linear),
            truth: Some(self.file("sharp.npz")),
            folder: PathBuf::new(),
            tuning,
            precision,
            limit: None,
            plan: false,
            mode: Mode::Quiet,
        }
    }
}

impl Bench<'_> {
    /// Takes the photograph `name` through `psf` of what `light` has at each place, of `channels` colours, which is `white` at most.
    pub(super) fn blur(
        &mut self,
        name: &str,
        (side, channels): (usize, usize),
        psf: String,
        (light, white): (&dyn Fn(usize, f64, f64) -> f64, f64),
    ) -> Result<Photograph, Halt> {
        let lens = Psf::read(&psf, [side, side])?;
        let sharp = Sharp::draw(side, lens.radius, channels, light);
        let mut seen = lens.blurred(&sharp.planes, [side, side, channels]);
        let mut random = Random::new(7, 0, 0);
        for value in &mut seen {
            *value = (*value + NOISE * random.normal()).clamp(0.0, white);
        }
        let colour = [channels, side, side];
        let counts = if channels == 1 { &colour[1..] } else { &colour };
        let [seen, truth] = [seen, sharp.inner()].map(|planes| interleaved(&planes, channels));
        let made = self.files(
            &format!("{name}/photograph"),
            &["blurred.npz", "sharp.npz"],
            |folder| {
                put(&folder.join("blurred.npz"), &[("image", counts, &seen)])?;
                put(&folder.join("sharp.npz"), &[("image", counts, &truth)])
            },
        )?;
        Ok(Photograph {
            made,
            psf,
            side,
            channels,
            pictures: [seen, truth],
        })
    }
}

/// The restored image of a run, as screens show light.
pub(super) fn restored(caption: &str, made: &Made) -> Result<Shot, Halt> {
    let image = measured("result", &made.archive(), Some("image")).map_err(unread)?;
    let width = image.shape.get(1).copied().unwrap_or(1);
    shot(
        caption,
        &image.values,
        width,
        image.shape.get(2).copied().unwrap_or(1),
    )
}

/// Light, the channel last, as a picture.
fn shot(caption: &str, light: &[f64], width: usize, channels: usize) -> Result<Shot, Halt> {
    let levels = light
        .iter()
        .map(|&light| Light::Srgb.coded(light.clamp(0.0, 1.0)) as f32);
    Ok(Shot {
        caption: caption.into(),
        png: colour_plate(&levels.collect::<Vec<_>>(), width, channels)?,
    })
}
