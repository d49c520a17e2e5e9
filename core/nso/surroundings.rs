//! What the block of a cell knows of its surroundings, where nothing else changes in a pass.
//!
//! A change of the cell's own faces stirs up forces on faces outside it: the outside-face term O. And it upsets
//! the divergence of the cells beside. What comes in through one face of a cell has to go out through its other
//! 2d - 1, which takes 1 / (2d - 1) of the energy of the change again: with those cells eliminated, at rest, each
//! of the cell's own faces has the mass 1 + 1 / (2d - 1) instead of 1. `docs/convergence.md` has what was measured.

use super::colours::Colours;
use crate::grid::Space;
use crate::real::Real;

/// The weight of O and the mass of the cell's own faces.
///
/// A block is divided by the mass: its Jacobian and the residuals of its momentum equations are multiplied by the
/// `mobility`, and its pressures by the mass in the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings<T> {
    /// The weight of O made of a Jacobian that is multiplied by the mobility: omega times the mass.
    pub outside: T,
    /// 1 / mass.
    pub mobility: T,
    /// The mass of the cell's own faces.
    pub mass: T,
}

impl Surroundings<f64> {
    /// With the mass of 2D in 3D too, where 6/5 does less.
    pub const WITH_MASS: Self = Self::new(1.5, 4.0 / 3.0);

    /// With the weight omega of O, and this mass.
    #[must_use]
    pub const fn new(omega: f64, mass: f64) -> Self {
        Self {
            outside: omega * mass,
            mobility: 1.0 / mass,
            mass,
        }
    }

    /// The outside-face term alone.
    #[must_use]
    pub fn outside_alone<S: Space>(colours: Colours) -> Self {
        let omega = if S::DIM == 3 && colours == Colours::RedBlack {
            3.0
        } else {
            2.0
        };
        Self::new(omega, 1.0)
    }

    /// The same in another precision.
    #[must_use]
    pub fn to<T: Real>(self) -> Surroundings<T> {
        let [outside, mobility, mass] = [self.outside, self.mobility, self.mass].map(T::from_f64);
        Surroundings {
            outside,
            mobility,
            mass,
        }
    }
}
