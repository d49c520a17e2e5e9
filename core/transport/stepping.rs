//! How a step is taken, and why one is not.

use super::limited;
use crate::observe::{Event, Observer};
use crate::problem::{Advection, Scheme};
use crate::progress::Status;
use core::ops::ControlFlow;

/// How a step is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepping {
    /// The operator.
    pub scheme: Scheme,
    /// The series is cut at the first term below this times max rho_0.
    pub tolerance: f64,
    /// The largest Courant number of a sub-step of the series; [`Self::courant`] is that of the scheme.
    pub courant: f64,
}

impl Stepping {
    /// The largest Courant number of a sub-step. Limited ones have at most 1/2 in a result, or values could leave those around them, and at
    /// most 1 in a search; semi-Lagrangian ones at most 1, since their adjoint looks for smoke in the cells beside.
    #[must_use]
    pub fn courant(&self) -> f64 {
        match self.scheme {
            Scheme::Quick | Scheme::Central => self.courant,
            Scheme::Limited => limited::COURANT * self.courant.min(limited::LONGER),
            Scheme::SemiLagrangian => 1.0,
        }
    }
}

impl From<Advection> for Stepping {
    /// Steps as results are defined by (mathematics section 3): sub-steps of Courant number at most 1.
    fn from(Advection { scheme, tolerance }: Advection) -> Self {
        Self {
            scheme,
            tolerance,
            courant: 1.0,
        }
    }
}

/// The Courant number of a step is above [`MAX_SUBSTEPS`](super::MAX_SUBSTEPS), or its velocity is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooFast;

/// Why a transport did not reach the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// See [`TooFast`].
    TooFast,
    /// The observer said stop.
    Cancelled,
}

impl Stop {
    /// Tells `observer` that work was done.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn heard(observer: &mut dyn Observer) -> Result<(), Self> {
        match observer.on(Event::Work) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Self::Cancelled),
        }
    }
}

impl From<Stop> for Status {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::TooFast => Self::NotFinite,
            Stop::Cancelled => Self::Cancelled,
        }
    }
}
