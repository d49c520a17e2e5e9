//! How bright the pictures of several cameras are, and whether smoke can be reconstructed from them.

use core::ops::RangeInclusive;

/// The brightest pixels that can be reconstructed.
pub const RECONSTRUCTED: RangeInclusive<f64> = 1e-30..=1e30;

/// What is known of pictures, frame by frame.
#[derive(Clone, Copy, Debug)]
pub struct Brightness {
    /// What a pixel has to be above to be smoke.
    threshold: f64,
    brightest: f64,
}

/// Why there is nothing to reconstruct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dim {
    /// All pictures are zeros.
    Zeros,
    /// The brightest pixel is out of [`RECONSTRUCTED`].
    Beyond(f64),
    /// The brightest pixel is not above the threshold.
    Below(f64),
}

impl Brightness {
    /// Of no picture yet.
    #[must_use]
    pub fn new(threshold: f64) -> Self {
        Self {
            threshold,
            brightest: 0.0,
        }
    }

    /// Adds a frame by the brightest pixel of each camera. Returns the first camera that sees no smoke where others see some: nothing can be where
    /// a camera sees nothing.
    pub fn add(&mut self, cameras: impl IntoIterator<Item = f64>) -> Option<usize> {
        let (mut dark, mut is_lit) = (None, false);
        for (camera, brightest) in cameras.into_iter().enumerate() {
            self.brightest = self.brightest.max(brightest);
            if brightest > self.threshold {
                is_lit = true;
            } else {
                dark = dark.or(Some(camera));
            }
        }
        dark.filter(|_| is_lit)
    }

    /// The brightest pixel of all frames.
    ///
    /// # Errors
    /// Why smoke cannot be reconstructed.
    pub fn brightest(&self) -> Result<f64, Dim> {
        match self.brightest {
            brightest if !(brightest > 0.0) => Err(Dim::Zeros),
            brightest if !RECONSTRUCTED.contains(&brightest) => Err(Dim::Beyond(brightest)),
            brightest if brightest <= self.threshold => Err(Dim::Below(brightest)),
            brightest => Ok(brightest),
        }
    }
}
