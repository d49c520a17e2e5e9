//! Even and odd eigenvectors.

/// The symmetry of an eigenvector about the middle of its axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// The same values on both sides.
    Even,
    /// Opposite values on both sides.
    Odd,
}

/// Both parities, in the order in which a transform stores their coefficients.
pub const PARITIES: [Parity; 2] = [Parity::Even, Parity::Odd];

impl Parity {
    /// The eigenvectors of this parity along an axis of `n` cells, each given by as many values, those of one half of the axis.
    #[must_use]
    pub const fn count(self, n: usize) -> usize {
        match self {
            Self::Even => n.div_ceil(2),
            Self::Odd => n / 2,
        }
    }
}
