//! Where a flow carries the density: the data term of a trajectory, and its gradient by one sweep back in time.
//!
//! Forward rho_{i+1} = A[rho_i, v_i]; backward mu_{i-1} = A_rho^T mu_i - C_i e_i with mu_N = 0. The data term's derivative by v_i
//! is -A_v^T mu_{i+1}: what the advection problem (paper Algorithm 1) and the direct method (mathematics section 6) move along.

use crate::exec::Exec;
use crate::field::{Vector, rows};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::observe::{Event, Observer};
use crate::operators::blur::Metric;
use crate::plan::{Ledger, Pool, Sharing, pooled};
use crate::problem::keyframes::{DataTerm, Keyframes};
use crate::real::Real;
use crate::transport::{Flow, Stepping, Stop, Transport};

/// What does not change from flow to flow.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// Slots T = N - 1.
    pub slots: usize,
    /// The metric.
    pub metric: Metric,
    /// How transport takes a step.
    pub stepping: Stepping,
    /// max rho_0.
    pub largest: f64,
    /// Threads that scratch was planned for.
    pub threads: usize,
}

/// Densities of a trajectory: rho_0 .. rho_N.
#[must_use]
pub fn densities(grid: &Grid, slots: usize) -> usize {
    (slots + 2) * grid.cells()
}

/// Transport and metric, carved from a shared pool.
pub struct Carrier<'a, T> {
    grid: &'a Grid,
    slots: usize,
    mu: &'a mut [T],
    transport: Transport<'a, T>,
    data: DataTerm<'a, T>,
}

impl<'a, T: Real> Carrier<'a, T> {
    /// Writes the ledger lines of [`Self::carve`].
    pub fn requirement(ledger: &mut Ledger, grid: &Grid, setup: &Setup) {
        ledger.group("transport and metric", Sharing::Together, |ledger| {
            ledger.line("mu", pooled(grid.cells()), T::BYTES);
            Transport::<T>::requirement(ledger, grid, setup.threads);
            DataTerm::<T>::requirement(ledger, grid, setup.metric.filters, setup.threads);
        });
    }

    /// Takes its numbers. The grid is number `level` of the hierarchy.
    pub fn carve(hierarchy: &'a Levels<'_, T>, level: usize, setup: &Setup, pool: &mut Pool<'a, T>) -> Self {
        let data = DataTerm::carve(hierarchy, level, setup.metric, setup.threads, pool);
        let grid = data.grid();
        Self {
            grid,
            slots: setup.slots,
            mu: pool.take(grid.cells()),
            transport: Transport::carve(grid, setup.stepping, setup.largest, setup.threads, pool),
            data,
        }
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &'a Grid {
        self.grid
    }

    /// Transports the first field of `rho` by `flow` through all the others; the data term of where it goes.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn carry(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        flow: &Flow<'_, T>,
        rho: &mut [T],
        keyframes: &Keyframes<'_, T>,
        sums: &mut [f64],
    ) -> Result<f64, Stop> {
        self.transport.run(exec, observer, flow, self.slots, rho, sums)?;
        Ok(self.data.total(exec, rho, keyframes, sums))
    }

    /// Transports the density of `step` to the next one.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn carry_step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        flow: &Flow<'_, T>,
        rho: &mut [T],
        step: usize,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        self.transport.step(exec, observer, flow, self.slots, step, rho, sums)
    }

    /// The data term of densities that were carried.
    pub fn data(&mut self, exec: &dyn Exec, rho: &[T], keyframes: &Keyframes<'_, T>, sums: &mut [f64]) -> f64 {
        self.data.total(exec, rho, keyframes, sums)
    }

    /// Backwards through the flow that carried `rho`: `each` receives every slot, last first, and A_v^T mu at its faces,
    /// minus the derivative of the data term.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn sweep_back(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        flow: &Flow<'_, T>,
        rho: &[T],
        keyframes: &Keyframes<'_, T>,
        sums: &mut [f64],
        each: &mut dyn FnMut(usize, Vector<'_, T>),
    ) -> Result<(), Stop> {
        let cells = self.grid.cells();
        self.mu.fill(T::ZERO);
        for step in (1..=self.slots).rev() {
            if let Some(index) = keyframes.at(step + 1) {
                self.data.evaluate(exec, &rho[(step + 1) * cells..][..cells], keyframes.density(index, cells), sums);
                rows::sub(self.mu, self.data.image());
            }
            self.transport.load(exec, flow, self.slots, step, sums).map_err(|_| Stop::TooFast)?;
            self.transport.backward(exec, &rho[step * cells..][..cells], self.mu);
            each(step - 1, self.transport.gradient());
            if observer.on(Event::Work).is_break() {
                return Err(Stop::Cancelled);
            }
        }
        Ok(())
    }
}
