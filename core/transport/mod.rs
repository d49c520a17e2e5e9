//! Density transport rho' = A[rho, v] (paper eq. 4, mathematics section 3) and its exact discrete adjoints.
//!
//! A step is cut into m sub-steps of Courant number at most 1, or 3 while the direct method searches. In each, the linear face-flux
//! schemes sum the Taylor series of exp(tau L(v)), terms y_k = (tau / k) L y_{k-1}, to the first term below the cut. Limited fluxes
//! take three stages of Runge-Kutta, of Courant number at most 1/2; semi-Lagrangian traces back once.

mod courant;
mod flow;
mod held;
mod kernel;
mod limited;
mod rows;
mod runs;
mod semi_lagrangian;
mod series;
mod substeps;
mod terms;

pub use flow::{Flow, ROWS_AHEAD};

use crate::exec::Exec;
use crate::field::{VectorMut, reborrow, view};
use crate::grid::Grid;
use crate::grid::halo::{self, field_len};
use crate::grid::solids::{Solids, closed, exit};
use crate::memory::{Pool, Sharing, pooled};
use crate::observe::{Event, Observer};
use crate::problem::{Advection, Scheme};
use crate::progress::Status;
use crate::real::Real;
use core::ops::ControlFlow;
use held::{Held, STATES};
use rows::Velocity;
use series::MAX_TERMS;

/// The largest Courant number of a step: with sub-steps of Courant number 1 it has as many at most.
pub const MAX_SUBSTEPS: usize = 64;

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

/// The values of two cache lines, which processors fetch together: the scratch of two threads shares none.
const PAIR_OF_LINES: usize = 32;

/// The Courant number of a step is above [`MAX_SUBSTEPS`], or its velocity is not finite.
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

/// The workspace of one step.
#[derive(Debug)]
pub struct Transport<'a, T> {
    grid: &'a Grid,
    scheme: Scheme,
    /// Terms are summed until max |term| is below this.
    cut: f64,
    /// See [`Stepping::courant`].
    courant: f64,
    /// See [`rows::Velocity`].
    velocity: VectorMut<'a, T>,
    solids: Solids<'a>,
    /// 0 at closed faces and exits, across which nothing differs, and 1 elsewhere, as the velocity; empty without any.
    open: VectorMut<'a, T>,
    substeps: usize,
    /// Where the terms of the last sub-steps are, if they are there.
    held: Option<Held>,
    states: &'a mut [T],
    terms: &'a mut [T],
    /// See [`terms::Terms`].
    sizes: &'a mut [T],
    adjoint: [&'a mut [T]; 2],
    gradient: VectorMut<'a, T>,
    scratch: &'a mut [T],
}

impl<'a, T: Real> Transport<'a, T> {
    fn scratch_len(grid: &Grid, threads: usize) -> usize {
        threads * (rows::SCRATCH_ROWS * (grid.n[0] + halo::HALO)).next_multiple_of(PAIR_OF_LINES)
    }

    /// Takes its workspace from a pool. `largest` is max rho_0.
    pub fn carve(
        grid: &'a Grid,
        stepping: Stepping,
        largest: f64,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        pool.group("density transport", Sharing::Together, |pool| {
            let (len, stride) = (grid.cells(), Self::stride(grid));
            let (gradient, velocity) = pool.line("velocity and its gradient", |pool| {
                let gradient = pool.take_vector("gradient", grid.dims, len);
                let lengths = [field_len(grid), stride - field_len(grid)];
                let [x, _] = pool.take_split("velocity along x", halo::OFFSET, lengths);
                let [y, z, _] = pool.take_vector("velocity", grid.dims - 1, len);
                (gradient, [x, y, z])
            });
            let states = pool.take("sub-step states", STATES * pooled(len));
            let [terms, first, second] = pool.take_split(
                "terms of sub-steps, forward and backward",
                halo::OFFSET,
                [MAX_TERMS * stride, stride, stride],
            );
            Self {
                grid,
                scheme: stepping.scheme,
                cut: stepping.tolerance * largest,
                courant: stepping.courant(),
                velocity,
                solids: Solids::default(),
                open: Default::default(),
                substeps: 1,
                held: None,
                states,
                terms,
                sizes: pool.take("largest elements of their rows", MAX_TERMS * grid.rows()),
                adjoint: [first, second],
                gradient,
                scratch: pool.take("rows", Self::scratch_len(grid, threads)),
            }
        })
    }

    /// The same among solid cells, for which it takes more of the pool.
    #[must_use]
    pub fn among(self, solids: Solids<'a>, pool: &mut Pool<'a, T>) -> Self {
        if !solids.there() {
            return self;
        }
        let (grid, len) = (self.grid, self.grid.cells());
        let open = pool.line("open faces", |pool| {
            let [x, _] = pool.take_split("along x", halo::OFFSET, [field_len(grid), 0]);
            let [y, z, _] = pool.take_vector("open faces", grid.dims - 1, len);
            [x, y, z]
        });
        let mut transport = Self { solids, open, ..self };
        transport.open_faces();
        transport
    }

    /// Writes which faces are open: through an exit smoke goes as if what is outside were like what is inside.
    fn open_faces(&mut self) {
        let (grid, n) = (self.grid, self.grid.n[0]);
        if self.open[0].is_empty() {
            return;
        }
        for row in 0..grid.rows() {
            let table = self.solids.row(n, row);
            for (axis, open) in self.open.iter_mut().enumerate().take(grid.dims) {
                let stride = if axis == 0 { halo::stride(n) } else { n };
                let Some(faces) = open.get_mut(row * stride..(row + 1) * stride) else {
                    continue;
                };
                let inner = if axis == 0 {
                    halo::inner(faces, n)
                } else {
                    &mut *faces
                };
                for (face, bits) in inner.iter_mut().zip(table) {
                    *face = if bits & (closed(axis) | exit(axis)) == 0 {
                        T::ONE
                    } else {
                        T::ZERO
                    };
                }
                if axis == 0 {
                    grid.axis(0).surround_faces(faces);
                }
            }
        }
    }

    /// Numbers between fields whose rows have their neighbours.
    fn stride(grid: &Grid) -> usize {
        pooled(field_len(grid))
    }

    /// Takes the velocity of step `step` out of `flow` and counts its sub-steps. `sums` holds a value a row.
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
        let grid = self.grid;
        self.held = None;
        let sums = &mut sums[..grid.rows()];
        flow.copy_step(exec, grid, slots, step, reborrow(&mut self.velocity));
        // A pass of its own: in one pass with the copying, which reads again what was just written, loading took nearly twice as long.
        let courant = courant::largest(exec, grid, Velocity(view(&self.velocity)), sums);
        if !(courant <= MAX_SUBSTEPS as f64) {
            return Err(TooFast);
        }
        self.substeps = (libm::ceil(courant / self.courant) as usize).max(1);
        Ok(())
    }

    /// Transports field `step` of `rho` to the next.
    ///
    /// # Errors
    /// [`Stop::TooFast`].
    pub fn step(
        &mut self,
        exec: &dyn Exec,
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
        Ok(())
    }
}
