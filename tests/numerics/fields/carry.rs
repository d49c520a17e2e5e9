//! One step of density transport by the core, with its adjoint.

use super::{Components, view};
use thurible_core::grid::Grid;
use thurible_core::memory::{Ledger, Pool};
use thurible_core::transport::{Flow, Stepping, TooFast, Transport};
use thurible_core::{Advection, Real, Scheme, Serial};

/// How a step is taken.
#[derive(Clone, Copy)]
pub struct Carry<'g> {
    pub grid: &'g Grid,
    /// Scheme, cut relative to a density of at most 1, and sub-steps.
    pub stepping: Stepping,
}

impl<'g> Carry<'g> {
    /// In sub-steps of Courant number at most 1.
    pub fn new(grid: &'g Grid, scheme: Scheme, tolerance: f64) -> Self {
        Self {
            grid,
            stepping: Advection { scheme, tolerance }.into(),
        }
    }

    /// In sub-steps of Courant number at most `courant`.
    pub fn in_substeps_of(mut self, courant: f64) -> Self {
        self.stepping.courant = courant;
        self
    }

    /// A transport with `v` loaded.
    fn with<T: Real, R>(
        &self,
        v: &Components<T>,
        work: impl FnOnce(&mut Transport<'_, T>) -> R,
    ) -> Result<R, TooFast> {
        let mut ledger = Ledger::new();
        Transport::<T>::carve(
            self.grid,
            self.stepping,
            1.0,
            1,
            &mut Pool::measuring(&mut ledger),
        );
        let mut numbers = vec![T::from_f64(f64::NAN); ledger.bytes().unwrap() / T::BYTES];
        let mut sums = vec![0.0; self.grid.rows()];
        let mut transport = Transport::carve(self.grid, self.stepping, 1.0, 1, &mut Pool::new(&mut numbers));
        let flow = Flow {
            initial: view(v),
            v: view(v),
            along: None,
        };
        transport.load(&Serial, &flow, 1, 0, &mut sums)?;
        Ok(work(&mut transport))
    }

    /// A[rho, v]: the density one step later.
    pub fn forward<T: Real>(&self, v: &Components<T>, rho: &[T]) -> Result<Vec<T>, TooFast> {
        self.with(v, |transport| {
            let mut to = rho.to_vec();
            transport.forward(&Serial, rho, &mut to);
            to
        })
    }

    /// A_rho^T mu and A_v^T mu.
    pub fn backward<T: Real>(
        &self,
        v: &Components<T>,
        rho: &[T],
        mu: &[T],
    ) -> Result<(Vec<T>, Components<T>), TooFast> {
        self.with(v, |transport| {
            let mut mu = mu.to_vec();
            transport.backward(&Serial, rho, &mut mu);
            (mu, transport.gradient().map(<[T]>::to_vec))
        })
    }
}
