//! The Gaussians G_j of the metric (paper eq. 5, mathematics section 4), j = 1, 2, ..: sigma = 2^(j-1) cells, taps
//! exp(-o^2 / (2 sigma^2)) at offsets o up to ceil(3 sigma), normalised to a sum of 1.

/// One Gaussian along an axis.
#[derive(Clone, Copy, Debug)]
pub struct Gaussian {
    /// Standard deviation, in cells.
    sigma: f64,
    /// The number of taps on one side of the centre.
    pub radius: usize,
    /// The sum of all taps before they are normalised.
    total: f64,
}

impl Gaussian {
    /// G_j; `j` counts from 1.
    #[must_use]
    pub fn new(j: usize) -> Self {
        let sigma = (1u64 << (j - 1)) as f64;
        let unscaled = Self {
            sigma,
            radius: libm::ceil(3.0 * sigma) as usize,
            total: 1.0,
        };
        let total = unscaled
            .taps()
            .map(|(offset, tap)| if offset == 0 { tap } else { 2.0 * tap })
            .sum();
        Self { total, ..unscaled }
    }

    /// The taps at the centre and on one side of it, with their offsets.
    pub fn taps(self) -> impl Iterator<Item = (usize, f64)> {
        let tap = move |offset: usize| {
            libm::exp(-0.5 * (offset as f64 / self.sigma) * (offset as f64 / self.sigma)) / self.total
        };
        (0..=self.radius).map(move |offset| (offset, tap(offset)))
    }
}
