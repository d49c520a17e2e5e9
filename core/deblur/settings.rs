//! What is asked for.

use super::error::DeblurError;
use super::kernel::Kernels;
use super::plane::Frame;
use super::prior::{ImagePrior, MOST_COLOURS};
use crate::words::named;

/// How an image is restored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Restorer {
    /// The random walk.
    #[default]
    Walk,
    /// Richardson-Lucy, edges replicated.
    RichardsonLucy,
    /// Wiener's filter of constant noise, (F^T M F + k) p = F^T M q by conjugate gradients.
    Wiener,
    /// Chambolle and Pock's primal-dual method for `atv`.
    PrimalDual,
}

named!(Restorer {
    Walk = "walk",
    RichardsonLucy = "richardson_lucy",
    Wiener = "wiener",
    PrimalDual = "primal_dual",
});

/// What a mutation changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Moves {
    /// One pixel.
    #[default]
    Pixel,
    /// A rectangle of pixels at once, whose sides are 1, 2, 4 or 8: pixels of an even area cannot move one by one where a prior holds them
    /// together.
    Patch,
}

named!(Moves { Pixel = "pixel", Patch = "patch" });

/// The choices of a restoration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Walk or baseline.
    pub method: Restorer,
    /// What is charged beside the distance from the image.
    pub prior: ImagePrior,
    /// How much of it; of Wiener the noise k.
    pub gamma: f64,
    /// Whether no pixel may fall below 0.
    pub nonnegative: bool,
    /// Pixels of at least this are left out; `None` leaves out none.
    pub saturation: Option<f64>,
    /// What a mutation changes.
    pub moves: Moves,
    /// Standard deviation of a mutation in kernel widths.
    pub sigma: f64,
    /// Mutations for each pixel and channel.
    pub budget: f64,
    /// eps of the first chain,
    pub eps: f64,
    /// by what it is multiplied after a chain that recorded too little,
    pub tau: f64,
    /// and how small it gets.
    pub eps_min: f64,
    /// Colours of the prior `clusters`.
    pub colours: usize,
    /// What distance from them costs, in gamma.
    pub mu: f64,
    /// Iterations of a baseline.
    pub iterations: usize,
    /// Which random numbers.
    pub seed: u64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            method: Restorer::Walk,
            prior: ImagePrior::Tv,
            gamma: 3e-4,
            nonnegative: true,
            saturation: None,
            moves: Moves::Pixel,
            sigma: 0.75,
            budget: 100.0,
            eps: 0.1,
            tau: 0.5,
            eps_min: 1e-4,
            colours: 5,
            mu: 1.0,
            iterations: 30,
            seed: 1,
        }
    }
}

/// An image and its kernels.
#[derive(Clone, Copy, Debug)]
pub struct Deblur<'a> {
    /// Its sizes; the border is the kernels' radius.
    pub frame: Frame,
    /// The kernels.
    pub kernels: Kernels<'a>,
    /// How it is restored.
    pub tuning: Tuning,
}

impl Deblur<'_> {
    /// Refuses sizes, kernels and choices that cannot be.
    ///
    /// # Errors
    /// [`DeblurError`].
    pub fn check(&self) -> Result<(), DeblurError> {
        let Frame {
            width,
            height,
            channels,
            border,
        } = self.frame;
        let kernels = &self.kernels;
        if width == 0 || height == 0 || !(1..=3).contains(&channels) {
            return Err(DeblurError::Size);
        }
        let number = kernels.side() * kernels.side();
        if border != kernels.radius
            || kernels.values.is_empty()
            || !kernels.values.len().is_multiple_of(number)
        {
            return Err(DeblurError::Kernel);
        }
        if kernels.side() > width || kernels.side() > height {
            return Err(DeblurError::KernelTooLarge);
        }
        for kernel in kernels.values.chunks_exact(number) {
            let sum: f64 = kernel.iter().sum();
            if !kernel.iter().all(|value| value.is_finite()) || !((sum - 1.0).abs() < 1e-6) {
                return Err(DeblurError::KernelSum);
            }
        }
        let count = kernels.count();
        let each = kernels.which.is_empty() || kernels.which.len() == width * height;
        if !each || kernels.which.iter().any(|&which| usize::from(which) >= count) {
            return Err(DeblurError::Which);
        }
        self.tuning.check()
    }
}

impl Tuning {
    fn check(&self) -> Result<(), DeblurError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let rules = [
            ("gamma", self.gamma >= 0.0 && self.gamma.is_finite(), "at least 0"),
            ("sigma", positive(self.sigma), "above 0"),
            ("budget", positive(self.budget), "above 0"),
            ("eps", positive(self.eps), "above 0"),
            ("tau", self.tau > 0.0 && self.tau < 1.0, "above 0 and below 1"),
            ("eps_min", positive(self.eps_min), "above 0"),
            ("saturation", self.saturation.is_none_or(positive), "above 0"),
            (
                "colours",
                (1..=MOST_COLOURS).contains(&self.colours),
                "from 1 to 16",
            ),
            ("mu", self.mu >= 0.0 && self.mu.is_finite(), "at least 0"),
            ("iterations", self.iterations > 0, "above 0"),
        ];
        let wrong = rules.into_iter().find(|(_, holds, _)| !holds);
        wrong.map_or(Ok(()), |(name, _, allowed)| {
            Err(DeblurError::Setting { name, allowed })
        })
    }
}
