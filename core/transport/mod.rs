//! Density transport rho' = A[rho, v] (paper eq. 4, mathematics section 3) and its exact discrete adjoints.
//!
//! A step is cut into m sub-steps of Courant number at most 1. In each, the face-flux schemes sum the Taylor series of
//! exp(tau L(v)), terms y_k = (tau / k) L y_{k-1}, to the first term below the cut; semi-Lagrangian traces back once.

mod flux;
mod semi_lagrangian;
mod series;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::grid::{Grid, Side};
use crate::observe::{Event, Observer};
use crate::plan::{Ledger, Pool, Sharing, pooled};
use crate::problem::Scheme;
use crate::real::Real;
use core::ops::ControlFlow;

/// Terms of a series at most, the first one included.
pub(crate) const MAX_TERMS: usize = 21;
/// Sub-step states that are kept at most; others are computed again.
const STATES: usize = 8;
/// Sub-steps of a step at most.
pub const MAX_SUBSTEPS: usize = 64;

/// Velocities of all steps: those of slots 1.. in trajectories, perhaps moved along a direction.
#[derive(Clone, Copy, Debug)]
pub struct Flow<'a, T> {
    /// v_0, a field of one slot.
    pub initial: Vector<'a, T>,
    /// v_1 .. v_{N-1}.
    pub v: Vector<'a, T>,
    /// A direction d and how far the flow goes along it: v + s d.
    pub along: Option<(Vector<'a, T>, T)>,
}

/// A step needs more than [`MAX_SUBSTEPS`], or its velocity is not finite.
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

/// One step's workspace. The `sums` of its methods hold two numbers a row.
#[derive(Debug)]
pub struct Transport<'a, T> {
    grid: &'a Grid,
    scheme: Scheme,
    /// Terms are summed until max |term| is below this.
    cut: f64,
    velocity: VectorMut<'a, T>,
    substeps: usize,
    states: &'a mut [T],
    terms: &'a mut [T],
    adjoint: [&'a mut [T]; 2],
    gradient: VectorMut<'a, T>,
    scratch: &'a mut [T],
}

impl<'a, T: Real> Transport<'a, T> {
    fn fields(grid: &Grid) -> usize {
        STATES + MAX_TERMS + 2 + 2 * grid.dims
    }

    fn scratch_len(grid: &Grid, threads: usize) -> usize {
        pooled(threads * flux::SCRATCH_ROWS * (grid.n[0] + flux::HALO))
    }

    /// Writes the ledger lines of [`Self::carve`].
    pub fn requirement(ledger: &mut Ledger, grid: &Grid, threads: usize) {
        ledger.group("density transport", Sharing::Together, |ledger| {
            let len = pooled(grid.cells());
            ledger.line("velocity and its gradient", 2 * grid.dims * len, T::BYTES);
            ledger.line("sub-step states", STATES * len, T::BYTES);
            ledger.line("terms of a sub-step, forward and backward", (Self::fields(grid) - STATES - 2 * grid.dims) * len, T::BYTES);
            ledger.line("rows", Self::scratch_len(grid, threads), T::BYTES);
        });
    }

    /// Takes its numbers from the shared pool. `largest` is max rho_0.
    pub fn carve(grid: &'a Grid, scheme: Scheme, tolerance: f64, largest: f64, threads: usize, pool: &mut Pool<'a, T>) -> Self {
        let len = grid.cells();
        Self {
            grid,
            scheme,
            cut: tolerance * largest,
            velocity: pool.take_vector(grid.dims, len),
            gradient: pool.take_vector(grid.dims, len),
            states: pool.take(STATES * pooled(len)),
            substeps: 1,
            terms: pool.take(MAX_TERMS * pooled(len)),
            adjoint: [pool.take(len), pool.take(len)],
            scratch: pool.take(Self::scratch_len(grid, threads)),
        }
    }

    /// Takes the velocity of step `step` out of `flow` and counts its sub-steps.
    ///
    /// # Errors
    /// [`TooFast`].
    pub fn load(&mut self, exec: &dyn Exec, flow: &Flow<'_, T>, slots: usize, step: usize, sums: &mut [f64]) -> Result<(), TooFast> {
        let (grid, nx) = (self.grid, self.grid.n[0]);
        let buffers = RowBuffers { fields: reborrow(&mut self.velocity), sums: &mut [], scratch: &mut [] };
        for_rows(exec, grid.rows(), 0..grid.rows(), buffers, |task| {
            for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                let (slots, slot) = if step == 0 { (1, 0) } else { (slots, step - 1) };
                let span = (task.row * slots + slot) * nx..(task.row * slots + slot + 1) * nx;
                let from = if step == 0 { flow.initial } else { flow.v };
                out.copy_from_slice(&from[axis][span.clone()]);
                if let (Some((direction, s)), true) = (flow.along, step > 0) {
                    rows::add_scaled(out, s, &direction[axis][span]);
                }
            }
        });
        let courant = self.courant(exec, sums);
        if !(courant <= MAX_SUBSTEPS as f64) {
            return Err(TooFast);
        }
        self.substeps = (libm::ceil(courant) as usize).max(1);
        Ok(())
    }

    /// The Courant number: max over cells of the sum of |v_f| over the cell's faces / (2 h).
    fn courant(&mut self, exec: &dyn Exec, sums: &mut [f64]) -> f64 {
        let (grid, v) = (self.grid, view(&self.velocity));
        let sums = &mut sums[..grid.rows()];
        for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: [], sums: &mut *sums, scratch: &mut *self.scratch }, |task| {
            let n = grid.n[0];
            let (total, shifted) = task.scratch.split_at_mut(n);
            total.fill(T::ZERO);
            for axis in 0..grid.dims {
                let s = T::from_f64(0.5 / grid.h[axis]);
                let low = &v[axis][task.row * n..(task.row + 1) * n];
                rows::add_scaled_abs(total, s, low);
                if axis == 0 {
                    rows::shift_high(&mut shifted[..n], low, n, grid.periodic[0]);
                    rows::add_scaled_abs(total, s, &shifted[..n]);
                } else if let Some(high) = grid.neighbour(task.row, axis, Side::High) {
                    rows::add_scaled_abs(total, s, &v[axis][high * n..(high + 1) * n]);
                }
            }
            task.sums[0] = rows::max_abs(total);
        });
        rows::largest(sums.iter().copied())
    }

    /// `to = A[from, v]` with the velocity that was loaded.
    pub fn forward(&mut self, exec: &dyn Exec, from: &[T], to: &mut [T], sums: &mut [f64]) {
        to.copy_from_slice(from);
        for _ in 0..self.substeps {
            self.substep(exec, to, sums);
        }
    }

    /// One sub-step in place.
    fn substep(&mut self, exec: &dyn Exec, rho: &mut [T], sums: &mut [f64]) {
        let tau = 1.0 / self.substeps as f64;
        if self.scheme == Scheme::SemiLagrangian {
            let len = self.grid.cells();
            self.terms[..len].copy_from_slice(rho);
            semi_lagrangian::trace(exec, self.grid, view(&self.velocity), tau, &self.terms[..len], rho);
        } else {
            let stride = pooled(self.grid.cells());
            self.terms[..rho.len()].copy_from_slice(rho);
            let sum = series::Series { grid: self.grid, velocity: view(&self.velocity), weights: flux::weights(self.scheme), tau, cut: self.cut };
            series::sum(exec, &sum, self.terms, stride, rho, self.scratch, sums);
        }
    }

    /// The adjoint of the step from `rho`: `mu` <- A_rho^T mu, and [`Self::gradient`] = A_v^T mu.
    pub fn backward(&mut self, exec: &dyn Exec, rho: &[T], mu: &mut [T], sums: &mut [f64]) {
        self.gradient.iter_mut().for_each(|component| component.fill(T::ZERO));
        let stride = pooled(self.grid.cells());
        for block in (0..self.substeps.div_ceil(STATES)).rev() {
            let first = block * STATES;
            let count = STATES.min(self.substeps - first);
            let states = core::mem::take(&mut self.states);
            states[..rho.len()].copy_from_slice(rho);
            for _ in 0..first {
                self.substep(exec, &mut states[..rho.len()], sums);
            }
            for state in 1..count {
                let (before, after) = states.split_at_mut(state * stride);
                after[..rho.len()].copy_from_slice(&before[(state - 1) * stride..][..rho.len()]);
                self.substep(exec, &mut after[..rho.len()], sums);
            }
            for state in (0..count).rev() {
                self.substep_backward(exec, &mut states[state * stride..][..rho.len()], mu, sums);
            }
            self.states = states;
        }
    }

    /// The adjoint of the sub-step from `rho` (which is overwritten): `mu` and the gradient.
    fn substep_backward(&mut self, exec: &dyn Exec, rho: &mut [T], mu: &mut [T], sums: &mut [f64]) {
        let tau = 1.0 / self.substeps as f64;
        if self.scheme == Scheme::SemiLagrangian {
            self.adjoint[0].copy_from_slice(mu);
            let step = semi_lagrangian::Step { grid: self.grid, velocity: view(&self.velocity), tau, rho, mu: self.adjoint[0] };
            semi_lagrangian::gradient(exec, &step, reborrow(&mut self.gradient));
            semi_lagrangian::adjoint(exec, &step, mu);
        } else {
            let stride = pooled(self.grid.cells());
            self.terms[..rho.len()].copy_from_slice(rho);
            let sum = series::Series { grid: self.grid, velocity: view(&self.velocity), weights: flux::weights(self.scheme), tau, cut: self.cut };
            let last = series::sum(exec, &sum, self.terms, stride, rho, self.scratch, sums);
            let backward = series::Backward { mu, work: self.adjoint.each_mut().map(|z| &mut **z), gradient: reborrow(&mut self.gradient) };
            series::adjoint(exec, &sum, self.terms, stride, last, backward, self.scratch);
        }
    }

    /// A_v^T mu of the last [`Self::backward`], at the faces.
    #[must_use]
    pub fn gradient(&self) -> Vector<'_, T> {
        view(&self.gradient)
    }

    /// Transports rho_0 through all steps: `rho` holds N + 1 fields of cells, the first of which is given.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn run(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, flow: &Flow<'_, T>, slots: usize, rho: &mut [T], sums: &mut [f64]) -> Result<(), Stop> {
        (0..=slots).try_for_each(|step| self.step(exec, observer, flow, slots, step, rho, sums))
    }

    /// Transports field `step` of `rho` to the next.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        flow: &Flow<'_, T>,
        slots: usize,
        step: usize,
        rho: &mut [T],
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let len = self.grid.cells();
        self.load(exec, flow, slots, step, sums).map_err(|TooFast| Stop::TooFast)?;
        let (before, after) = rho.split_at_mut((step + 1) * len);
        self.forward(exec, &before[step * len..], &mut after[..len], sums);
        if observer.on(Event::Work) == ControlFlow::Break(()) { Err(Stop::Cancelled) } else { Ok(()) }
    }
}
