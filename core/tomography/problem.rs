//! What is asked for: box, cameras, prior, walk.

use super::camera::Camera;
use super::error::TomographyError;
use super::rays::sees_box;
use crate::real::Real;
use crate::walk::{Cells, Prior, Rule};
use crate::words::named;

/// How a frame is reconstructed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The random walk.
    #[default]
    Walk,
    /// Simultaneous algebraic reconstruction, camera after camera.
    Sart,
}

named!(Method { Walk = "walk", Sart = "sart" });

/// The choices of a reconstruction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Walk or SART.
    pub method: Method,
    /// What is charged beside the distance from the pictures.
    pub prior: Prior,
    /// How much of it.
    pub gamma: f64,
    /// Whether no cell may fall below 0; where no cells are kept, no pixel of a novel view.
    pub nonnegative: bool,
    /// Whether the density is kept even where nothing needs it but the caller.
    pub volume: bool,
    /// Standard deviation of a mutation, in parts of the box's diagonal.
    pub sigma: f64,
    /// Mutations of a chain.
    pub length: u64,
    /// Mutations of a frame.
    pub budget: u64,
    /// Mass of a sample, or `None` for total / (accept x budget).
    pub eps: Option<f64>,
    /// The part of the mutations that is expected to be recorded.
    pub accept: f64,
    /// A frame ends when a tenth of the budget lowered E by less than this part of it; 0 never.
    pub tolerance: f64,
    /// When a chain walks and records.
    pub rule: Rule,
    /// Pixels of at most this are dark: places that they see are empty.
    pub hull_threshold: f64,
    /// Which random numbers.
    pub seed: u64,
    /// Whether a frame begins with the one before.
    pub warm: bool,
    /// The part of the budget of a frame that does.
    pub warm_budget: f64,
    /// Passes over all cameras, of SART.
    pub sweeps: usize,
    /// How far SART goes at a time.
    pub relax: f64,
}

/// Mutations of a frame for each cell and camera, where nobody says how many.
const A_CELL_AND_CAMERA: f64 = 20.0;

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Walk,
            prior: Prior::Sad,
            gamma: 0.15,
            nonnegative: true,
            volume: true,
            sigma: 0.07,
            length: 2000,
            budget: 6_000_000,
            eps: None,
            accept: 0.05,
            tolerance: 1e-4,
            rule: Rule::Patient,
            hull_threshold: 0.0,
            seed: 1,
            warm: false,
            warm_budget: 0.2,
            sweeps: 10,
            relax: 0.5,
        }
    }
}

impl Settings {
    /// Whether the density is kept: pictures of priors on pictures may be all that is.
    #[must_use]
    pub fn keeps_cells(&self) -> bool {
        let needed = self.prior.on_cells() || (self.nonnegative && self.prior.on_images().is_none());
        self.volume || needed || self.method == Method::Sart
    }

    /// Mutations of a frame where nobody says how many.
    #[must_use]
    pub fn automatic_budget(cells: usize, cameras: usize) -> u64 {
        (A_CELL_AND_CAMERA * cells as f64 * cameras as f64).max(1e6) as u64
    }

    /// gamma where nobody says how much: that of a density whose brightest ray is a quarter of the box long, or, on pictures, a part of
    /// the brightest pixel.
    #[must_use]
    pub fn automatic_gamma(prior: Prior, dims: usize, longest: usize, brightest: f64) -> f64 {
        let density = 4.0 * brightest / longest as f64;
        let ([plane, volume], unit) = match prior {
            Prior::None => ([0.0, 0.0], density),
            Prior::L2 => ([1.0, 0.1], density),
            Prior::Tv => ([0.5, 0.03], density),
            Prior::Sad => ([0.15, 0.01], density),
            Prior::ImageTv => ([0.002, 0.002], brightest),
            Prior::ImageSad => ([0.001, 0.001], brightest),
        };
        unit * if dims > 2 { volume } else { plane }
    }

    /// Refuses what is out of range.
    ///
    /// # Errors
    /// [`TomographyError::Setting`].
    pub fn check(&self) -> Result<(), TomographyError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let not_negative = |x: f64| x >= 0.0 && x.is_finite();
        let part = |x: f64| x > 0.0 && x <= 1.0;
        let wanted = "above 0";
        let rules = [
            ("gamma", not_negative(self.gamma), "at least 0"),
            ("sigma", positive(self.sigma), wanted),
            ("length", self.length > 0, wanted),
            ("budget", self.budget > 0, wanted),
            ("eps", self.eps.is_none_or(positive), wanted),
            ("accept", part(self.accept), "above 0 and at most 1"),
            ("tolerance", not_negative(self.tolerance), "at least 0"),
            ("hull_threshold", self.hull_threshold.is_finite(), "finite"),
            ("warm_budget", part(self.warm_budget), "above 0 and at most 1"),
            (
                "warm",
                !self.warm || self.keeps_cells(),
                "false where no volume is kept",
            ),
            ("sweeps", self.sweeps > 0, wanted),
            (
                "relax",
                positive(self.relax) && self.relax < 2.0,
                "above 0 and below 2",
            ),
        ];
        let wrong = rules.into_iter().find(|(_, holds, _)| !holds);
        wrong.map_or(Ok(()), |(name, _, allowed)| {
            Err(TomographyError::Setting { name, allowed })
        })
    }
}

/// A box seen by cameras.
#[derive(Clone, Copy, Debug)]
pub struct Tomography<'a, const D: usize> {
    /// The cells of the box.
    pub cells: Cells<D>,
    /// The cameras.
    pub cameras: &'a [Camera<D>],
    /// Cameras that measured nothing: what they would see is kept, sample by sample.
    pub novel: &'a [Camera<D>],
    /// How it is reconstructed.
    pub settings: Settings,
}

impl<const D: usize> Tomography<'_, D> {
    /// Pixels of all cameras.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.cameras.iter().map(Camera::len).sum()
    }

    /// Pixels of all novel views.
    #[must_use]
    pub fn novel_pixels(&self) -> usize {
        self.novel.iter().map(Camera::len).sum()
    }

    /// Refuses boxes, cameras and settings that cannot be.
    ///
    /// # Errors
    /// [`TomographyError`].
    pub fn check(&self) -> Result<(), TomographyError> {
        if let Some(axis) = self.cells.counts.iter().position(|&count| count < 2) {
            return Err(TomographyError::Cells { axis });
        }
        product(&self.cells.counts).ok_or(TomographyError::TooLarge)?;
        for cameras in [self.cameras, self.novel] {
            let mut each = cameras.iter().map(|camera| product(&camera.pixels));
            each.try_fold(0, |sum: usize, pixels| sum.checked_add(pixels?))
                .ok_or(TomographyError::TooLarge)?;
        }
        if self.cameras.is_empty() {
            return Err(TomographyError::NoCamera);
        }
        for (number, camera) in self.cameras.iter().enumerate() {
            match sight(&self.cells, camera) {
                Sight::Clear => {}
                Sight::Blind => return Err(TomographyError::Blind { camera: number }),
                Sight::Wrong => return Err(TomographyError::Camera { camera: number }),
                Sight::Uncounted => return Err(TomographyError::TooLarge),
            }
        }
        for (view, camera) in self.novel.iter().enumerate() {
            let blind = match sight(&self.cells, camera) {
                Sight::Clear => continue,
                Sight::Blind => true,
                Sight::Wrong => false,
                Sight::Uncounted => return Err(TomographyError::TooLarge),
            };
            return Err(TomographyError::Novel { view, blind });
        }
        let walks = self.settings.method == Method::Walk;
        if walks && self.settings.prior.on_images().is_some() && self.novel.is_empty() {
            return Err(TomographyError::NoNovel);
        }
        self.settings.check()
    }
}

fn product(counts: &[usize]) -> Option<usize> {
    let mut counts = counts.iter();
    counts.try_fold(1_usize, |product, &count| product.checked_mul(count))
}

/// How a camera stands to the box.
enum Sight {
    Clear,
    /// It sees nothing of it.
    Blind,
    /// It has no pixels, or a number that is not finite.
    Wrong,
    /// It has too many pixels.
    Uncounted,
}

fn sight<const D: usize>(cells: &Cells<D>, camera: &Camera<D>) -> Sight {
    let centre = cells.counts.map(|count| 0.5 * count as f64);
    let finite = camera
        .see(&centre)
        .is_none_or(|seen| seen.at.iter().all(|x| x.is_finite()) && Real::is_finite(seen.weight));
    match product(&camera.pixels) {
        None => Sight::Uncounted,
        Some(pixels) if pixels == 0 || !finite || (D == 2 && camera.pixels[1] != 1) => Sight::Wrong,
        _ if !sees_box(cells, camera) => Sight::Blind,
        _ => Sight::Clear,
    }
}
