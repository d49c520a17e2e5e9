//! Density transport rho' = A[rho, v] (paper eq. 4, mathematics section 3) and its exact discrete adjoints.
//!
//! A step is cut into m sub-steps of Courant number at most 1, or 3 while the direct method searches. In each, the face-flux schemes
//! sum the Taylor series of exp(tau L(v)), terms y_k = (tau / k) L y_{k-1}, to the first term below the cut; semi-Lagrangian traces
//! back once.

mod flux;
mod semi_lagrangian;
mod series;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::grid::Grid;
use crate::memory::{Ledger, Pool, Sharing, pooled};
use crate::observe::{Event, Observer};
use crate::problem::{Advection, Scheme};
use crate::real::Real;
use crate::simd::{Cache, prefetch};
use core::ops::ControlFlow;
use flux::{Around, Velocity, faces, with_halo};

/// Terms of a series at most, besides the first one.
pub(crate) const MAX_TERMS: usize = 20;
/// Sub-step states that are kept at most; others are computed again.
const STATES: usize = 8;
/// Sub-steps of Courant number 1 of a step at most.
pub const MAX_SUBSTEPS: usize = 64;

/// How a step is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepping {
    /// The operator.
    pub scheme: Scheme,
    /// The series is cut at the first term below this times max rho_0.
    pub tolerance: f64,
    /// Courant number of a series' sub-step at most. Semi-Lagrangian's, whose adjoint looks for smoke in the next cells, are of at most 1.
    pub courant: f64,
}

impl From<Advection> for Stepping {
    /// What results are promised by (mathematics section 3): sub-steps of Courant number at most 1.
    fn from(Advection { scheme, tolerance }: Advection) -> Self {
        Self {
            scheme,
            tolerance,
            courant: 1.0,
        }
    }
}

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

impl<T: Real> Flow<'_, T> {
    /// One component of the velocity of step `step` at a row of faces.
    fn row(&self, axis: usize, slots: usize, step: usize, row: usize, out: &mut [T]) {
        let n = out.len();
        let (from, place) = if step == 0 {
            (self.initial, row)
        } else {
            (self.v, row * slots + step - 1)
        };
        out.copy_from_slice(&from[axis][place * n..(place + 1) * n]);
        if let (Some((direction, s)), true) = (self.along, step > 0) {
            rows::add_scaled(out, s, &direction[axis][place * n..(place + 1) * n]);
        }
    }

    /// Asks for what [`Self::row`] will read: the rows of a step are far apart.
    fn prefetch_row(&self, axis: usize, slots: usize, step: usize, row: usize, n: usize) {
        let Some(slot) = step.checked_sub(1) else { return };
        for field in [Some(self.v), self.along.map(|(direction, _)| direction)]
            .into_iter()
            .flatten()
        {
            prefetch(Cache::First, field[axis], (row * slots + slot) * n, n);
        }
    }
}

/// Rows between the one that is read and the one that is asked for.
pub const ROWS_AHEAD: usize = 4;

/// Numbers in two cache lines, which processors fetch together: scratch of two threads shares none.
const PAIR_OF_LINES: usize = 32;

/// Where the terms of sub-steps are held: those of the latest ones, as many as there is room for.
#[derive(Debug, Default)]
struct Held {
    /// First field and number of the terms of each sub-step of a block, in order.
    terms: heapless::Vec<(usize, usize), STATES>,
    /// The first sub-step whose terms were not overwritten.
    oldest: usize,
}

impl Held {
    /// Runs the next sub-step, which is told where its terms begin and says how many there are, or `None` if they find no room
    /// behind those before: then it runs again and overwrites them.
    fn push(&mut self, mut substep: impl FnMut(usize) -> Option<usize>) {
        let (begin, as_many) = self
            .terms
            .last()
            .map_or((0, 0), |&(at, terms)| (at + terms, terms));
        let beside = if begin + as_many <= MAX_TERMS {
            substep(begin)
        } else {
            None
        };
        let held = match beside {
            Some(terms) => (begin, terms),
            None => {
                self.oldest = self.terms.len();
                (0, substep(0).unwrap_or_default())
            }
        };
        let _ = self.terms.push(held);
    }

    /// Those of a sub-step, if they are there.
    fn get(&self, substep: usize) -> Option<(usize, usize)> {
        self.terms
            .get(substep)
            .copied()
            .filter(|_| substep >= self.oldest)
    }
}

/// A step would need more than [`MAX_SUBSTEPS`], or its velocity is not finite.
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

/// One step's workspace.
#[derive(Debug)]
pub struct Transport<'a, T> {
    grid: &'a Grid,
    scheme: Scheme,
    /// Terms are summed until max |term| is below this.
    cut: f64,
    /// See [`Stepping::courant`].
    courant: f64,
    /// See [`flux::Velocity`].
    velocity: VectorMut<'a, T>,
    substeps: usize,
    /// Where the terms of the last sub-steps are, if they are there.
    held: Option<Held>,
    states: &'a mut [T],
    terms: &'a mut [T],
    /// See [`series::Terms`].
    sizes: &'a mut [T],
    adjoint: [&'a mut [T]; 2],
    gradient: VectorMut<'a, T>,
    scratch: &'a mut [T],
}

impl<'a, T: Real> Transport<'a, T> {
    fn scratch_len(grid: &Grid, threads: usize) -> usize {
        threads * (flux::SCRATCH_ROWS * (grid.n[0] + flux::HALO)).next_multiple_of(PAIR_OF_LINES)
    }

    /// Writes the ledger lines of [`Self::carve`].
    pub fn requirement(ledger: &mut Ledger, grid: &Grid, threads: usize) {
        ledger.group("density transport", Sharing::Together, |ledger| {
            let (len, with_halo) = (pooled(grid.cells()), Self::stride(grid));
            ledger.line(
                "velocity and its gradient",
                pooled(flux::OFFSET + with_halo) + (2 * grid.dims - 1) * len,
                T::BYTES,
            );
            ledger.line("sub-step states", STATES * len, T::BYTES);
            ledger.line(
                "terms of sub-steps, forward and backward",
                pooled(flux::OFFSET + (MAX_TERMS + 2) * with_halo),
                T::BYTES,
            );
            ledger.line(
                "largest numbers of their rows",
                pooled(MAX_TERMS * grid.rows()),
                T::BYTES,
            );
            ledger.line("rows", Self::scratch_len(grid, threads), T::BYTES);
        });
    }

    /// Takes its numbers from the shared pool. `largest` is max rho_0.
    pub fn carve(
        grid: &'a Grid,
        stepping: Stepping,
        largest: f64,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let (len, stride, with_halo) = (grid.cells(), Self::stride(grid), with_halo(grid));
        let gradient = pool.take_vector(grid.dims, len);
        let velocity = &mut pool.take(flux::OFFSET + stride)[flux::OFFSET..][..with_halo];
        let [y, z, _] = pool.take_vector(grid.dims - 1, len);
        let states = pool.take(STATES * pooled(len));
        let (terms, adjoint) = pool.take(flux::OFFSET + (MAX_TERMS + 2) * stride)[flux::OFFSET..]
            .split_at_mut(MAX_TERMS * stride);
        let (first, second) = adjoint.split_at_mut(stride);
        Self {
            grid,
            scheme: stepping.scheme,
            cut: stepping.tolerance * largest,
            courant: if stepping.scheme == Scheme::SemiLagrangian {
                1.0
            } else {
                stepping.courant
            },
            velocity: [velocity, y, z],
            substeps: 1,
            held: None,
            states,
            terms,
            sizes: pool.take(MAX_TERMS * grid.rows()),
            adjoint: [first, second],
            gradient,
            scratch: pool.take(Self::scratch_len(grid, threads)),
        }
    }

    /// Numbers between fields whose rows have their neighbours.
    fn stride(grid: &Grid) -> usize {
        pooled(with_halo(grid))
    }

    /// Takes the velocity of step `step` out of `flow` and counts its sub-steps. `sums` holds a number a row.
    ///
    /// The Courant number is the maximum over cells of the sum of |v_f| over the cell's faces / (2 h).
    ///
    /// # Errors
    /// [`TooFast`].
    pub fn load(
        &mut self,
        exec: &dyn Exec,
        flow: &Flow<'_, T>,
        slots: usize,
        step: usize,
        sums: &mut [f64],
    ) -> Result<(), TooFast> {
        let (grid, n) = (self.grid, self.grid.n[0]);
        self.held = None;
        let sums = &mut sums[..grid.rows()];
        let [v0, v1, v2] = reborrow(&mut self.velocity);
        for_rows(exec, grid.rows(), RowBuffers::fields([v0, v1, v2]), move |task| {
            for (axis, faces) in task.fields.into_iter().enumerate().take(grid.dims) {
                flow.row(
                    axis,
                    slots,
                    step,
                    task.row,
                    if axis == 0 {
                        flux::inner(faces, n)
                    } else {
                        &mut *faces
                    },
                );
                flow.prefetch_row(axis, slots, step, task.row + ROWS_AHEAD, n);
                if axis == 0 {
                    flux::surround_faces(faces, n, grid.periodic[0]);
                }
            }
        });
        // In a pass of its own: together with the copying, reading again what was just written, loading took nearly twice as long.
        let (velocity, scales) = (
            Velocity(view(&self.velocity)),
            grid.h.map(|h| T::from_f64(0.5 / h)),
        );
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::<T, 0>::sums(&mut *sums),
            move |task| {
                task.sums[0] = flux::largest_courant(
                    &faces(&Around::new(grid, task.row), velocity),
                    n,
                    grid.dims,
                    scales,
                );
            },
        );
        let courant = rows::largest(sums.iter().copied());
        if !(courant <= MAX_SUBSTEPS as f64) {
            return Err(TooFast);
        }
        self.substeps = (libm::ceil(courant / self.courant) as usize).max(1);
        Ok(())
    }

    /// `to = A[from, v]` with the velocity that was loaded.
    pub fn forward(&mut self, exec: &dyn Exec, from: &[T], to: &mut [T]) {
        let states = core::mem::take(&mut self.states);
        self.carry(exec, self.substeps, from, [to, &mut states[..from.len()]]);
        self.states = states;
    }

    /// `count` sub-steps, at least one, from `from` to `to`, by way of a field of work.
    fn carry(&mut self, exec: &dyn Exec, count: usize, from: &[T], [mut to, mut other]: [&mut [T]; 2]) {
        if count.is_multiple_of(2) {
            core::mem::swap(&mut to, &mut other);
        }
        self.substep(exec, from, to, 0);
        for _ in 1..count {
            self.substep(exec, to, other, 0);
            core::mem::swap(&mut to, &mut other);
        }
    }

    /// One sub-step; `to` may be empty. The series' terms go to `terms` from field `at` on: how many there are, or `None` where they
    /// find no room.
    fn substep(&mut self, exec: &dyn Exec, from: &[T], to: &mut [T], at: usize) -> Option<usize> {
        let Self {
            grid,
            scheme,
            substeps,
            cut,
            velocity,
            terms,
            sizes,
            scratch,
            ..
        } = self;
        let (velocity, tau, stride) = (
            Velocity(view(velocity)),
            1.0 / *substeps as f64,
            Self::stride(grid),
        );
        if *scheme == Scheme::SemiLagrangian {
            if !to.is_empty() {
                semi_lagrangian::trace(exec, grid, velocity, tau, from, to);
            }
            return Some(0);
        }
        let series = series::Series {
            grid,
            velocity,
            weights: flux::weights(*scheme),
            tau,
            cut: *cut,
        };
        let terms = series::Terms {
            fields: &mut terms[at * stride..],
            stride,
            sizes: sizes.get_mut(at * grid.rows()..).unwrap_or_default(),
        };
        series::sum(exec, &series, from, terms, to, scratch)
    }

    /// The terms of the step's last sub-steps from `rho`, which [`Self::backward`] begins with: it does this itself unless it was done before.
    pub fn prepare(&mut self, exec: &dyn Exec, rho: &[T]) {
        self.held = Some(self.hold(exec, rho, (self.substeps - 1) / STATES * STATES));
    }

    /// The terms of as many sub-steps from number `first` on as there are states for.
    fn hold(&mut self, exec: &dyn Exec, rho: &[T], first: usize) -> Held {
        let (len, stride, count) = (rho.len(), pooled(rho.len()), STATES.min(self.substeps - first));
        let states = core::mem::take(&mut self.states);
        if first > 0 {
            let (begin, work) = states.split_at_mut(stride);
            self.carry(exec, first, rho, [&mut begin[..len], &mut work[..len]]);
        }
        let mut held = Held::default();
        for state in 0..count {
            let (before, after) = states.split_at_mut((state + 1) * stride);
            let from = if first + state == 0 {
                rho
            } else {
                &before[state * stride..][..len]
            };
            let to = if state + 1 < count {
                &mut after[..len]
            } else {
                &mut []
            };
            held.push(|at| self.substep(exec, from, to, at));
        }
        self.states = states;
        held
    }

    /// The adjoint of the step from `rho`: `mu` <- A_rho^T mu where there is smoke (elsewhere it may stay as it is, which no gradient
    /// depends on), and [`Self::gradient`] = A_v^T mu.
    pub fn backward(&mut self, exec: &dyn Exec, rho: &[T], mu: &mut [T]) {
        let (len, stride) = (rho.len(), pooled(rho.len()));
        for first in (0..self.substeps).step_by(STATES).rev() {
            let held = match self.held.take() {
                Some(held) => held,
                None => self.hold(exec, rho, first),
            };
            let states = core::mem::take(&mut self.states);
            for state in (0..STATES.min(self.substeps - first)).rev() {
                let from = if first + state == 0 {
                    rho
                } else {
                    &states[state * stride..][..len]
                };
                let terms = match held.get(state) {
                    Some(held) => held,
                    None => (0, self.substep(exec, from, &mut [], 0).unwrap_or_default()),
                };
                self.substep_backward(exec, from, terms, mu, first + state + 1 == self.substeps);
            }
            self.states = states;
        }
    }

    /// The adjoint of the sub-step from `rho`, whose `terms` begin at field `at`: `mu` and the gradient, which begins with the `first`.
    fn substep_backward(
        &mut self,
        exec: &dyn Exec,
        rho: &[T],
        (at, terms): (usize, usize),
        mu: &mut [T],
        first: bool,
    ) {
        let Self {
            grid,
            scheme,
            substeps,
            cut,
            velocity,
            terms: fields,
            sizes,
            adjoint,
            gradient,
            scratch,
            ..
        } = self;
        let (velocity, tau, stride) = (
            Velocity(view(velocity)),
            1.0 / *substeps as f64,
            Self::stride(grid),
        );
        if *scheme == Scheme::SemiLagrangian {
            if first {
                gradient.iter_mut().for_each(|component| component.fill(T::ZERO));
            }
            adjoint[0][..mu.len()].copy_from_slice(mu);
            let step = semi_lagrangian::Step {
                grid,
                velocity,
                tau,
                rho,
                mu: &adjoint[0][..mu.len()],
            };
            semi_lagrangian::gradient(exec, &step, reborrow(gradient));
            semi_lagrangian::adjoint(exec, &step, mu);
        } else {
            let series = series::Series {
                grid,
                velocity,
                weights: flux::weights(*scheme),
                tau,
                cut: *cut,
            };
            let backward = series::Backward {
                mu,
                work: adjoint.each_mut().map(|z| &mut **z),
                gradient: reborrow(gradient),
                first,
            };
            let held = series::Terms {
                fields: &fields[at * stride..],
                stride,
                sizes: sizes.get(at * grid.rows()..).unwrap_or_default(),
            };
            series::adjoint(exec, &series, rho, held, terms, backward, scratch);
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
    pub fn run(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        flow: &Flow<'_, T>,
        slots: usize,
        rho: &mut [T],
        sums: &mut [f64],
    ) -> Result<(), Stop> {
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
        self.load(exec, flow, slots, step, sums)
            .map_err(|TooFast| Stop::TooFast)?;
        let (before, after) = rho.split_at_mut((step + 1) * len);
        self.forward(exec, &before[step * len..], &mut after[..len]);
        if observer.on(Event::Work) == ControlFlow::Break(()) {
            Err(Stop::Cancelled)
        } else {
            Ok(())
        }
    }
}
