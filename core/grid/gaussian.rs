//! The Gaussians G_j of the metric (paper eq. 5, mathematics section 4), j = 1, 2, ..: sigma = 2^(j-1) cells, taps
//! exp(-o^2 / (2 sigma^2)) at offsets o up to ceil(3 sigma), normalised to a sum of 1.

/// The angles whose responses are computed together.
pub const ANGLES: usize = 64;

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
        Self::of((1u64 << (j - 1)) as f64)
    }

    /// Of any standard deviation above 0, in cells.
    #[must_use]
    pub fn of(sigma: f64) -> Self {
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
    pub fn taps(self) -> impl DoubleEndedIterator<Item = (usize, f64)> {
        let tap = move |offset: usize| {
            libm::exp(-0.5 * (offset as f64 / self.sigma) * (offset as f64 / self.sigma)) / self.total
        };
        (0..=self.radius).map(move |offset| (offset, tap(offset)))
    }

    /// What the Gaussian makes of waves: the sum over all taps w_o of w_o cos(angle o), for each angle from 0 to pi.
    ///
    /// Clenshaw's recurrence in Reinsch's form, which keeps its digits where the angle is nearly 0 (Oliver 1977, An error analysis
    /// of the modified Clenshaw method); there pi - angle stands for larger angles, which turns the sign of every second term.
    #[must_use]
    pub fn responses(self, angles: &[f64; ANGLES]) -> [f64; ANGLES] {
        let quarter = 0.5 * core::f64::consts::PI;
        let signs = angles.map(|angle| if angle > quarter { -1.0 } else { 1.0 });
        let steps: [f64; ANGLES] = core::array::from_fn(|i| {
            let angle = if angles[i] > quarter {
                2.0 * quarter - angles[i]
            } else {
                angles[i]
            };
            let half = libm::sin(0.5 * angle);
            -4.0 * half * half
        });
        let (mut sums, mut differences, mut before) = ([0.0; ANGLES], [0.0; ANGLES], [0.0; ANGLES]);
        for (offset, tap) in self.taps().rev() {
            let twice = if offset == 0 { tap } else { 2.0 * tap };
            before = sums;
            for i in 0..ANGLES {
                let term = if offset % 2 == 1 { twice * signs[i] } else { twice };
                differences[i] += steps[i] * sums[i] + term;
                sums[i] += differences[i];
            }
        }
        core::array::from_fn(|i| differences[i] - 0.5 * steps[i] * before[i])
    }
}
