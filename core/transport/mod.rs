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
mod stepping;
mod substeps;
mod terms;

pub use flow::{Flow, ROWS_AHEAD};
pub use limited::KEEP;
pub use stepping::{Stepping, Stop, TooFast};
pub use substeps::negligible;

use crate::exec::Exec;
use crate::field::{VectorMut, reborrow, view};
use crate::grid::Grid;
use crate::grid::halo::{self, field_len};
use crate::grid::solids::{Solids, closed, exit};
use crate::memory::{Pool, Sharing, pooled};
use crate::problem::Scheme;
use crate::real::Real;
use held::{Held, STATES};
use rows::Velocity;
use series::MAX_TERMS;

/// The largest Courant number of a step: with sub-steps of Courant number 1 it has as many at most.
pub const MAX_SUBSTEPS: usize = 64;

/// The values of two cache lines, which processors fetch together: the scratch of two threads shares none.
const PAIR_OF_LINES: usize = 32;

/// Which ways a transport goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ways {
    /// Forward alone.
    Forward,
    /// Forward and back.
    Both,
}

impl Ways {
    /// Terms of sub-steps for which there is room: on the way forward each takes the place of the one before the last.
    const fn terms(self, scheme: Scheme) -> usize {
        match (self, scheme) {
            (Self::Forward, Scheme::Limited) => limited::KEPT,
            (Self::Forward, _) => series::ROLLING,
            (Self::Both, _) => MAX_TERMS,
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
    /// Whether the way back passes over nothing: see [`Self::everywhere`].
    everywhere: bool,
    /// Whether there is room for the last two terms alone.
    rolling: bool,
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
        Self::carve_with(grid, stepping, largest, threads, Ways::Both, pool)
    }

    /// As [`Self::carve`], for the way forward alone: there is no [`Self::backward`], and little memory is taken.
    pub fn one_way(
        grid: &'a Grid,
        stepping: Stepping,
        largest: f64,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        Self::carve_with(grid, stepping, largest, threads, Ways::Forward, pool)
    }

    fn carve_with(
        grid: &'a Grid,
        stepping: Stepping,
        largest: f64,
        threads: usize,
        ways: Ways,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        pool.group("density transport", Sharing::Together, |pool| {
            let (len, stride) = (grid.cells(), Self::stride(grid));
            let back = usize::from(ways == Ways::Both);
            let (gradient, velocity) = pool.line("velocity and its gradient", |pool| {
                let gradient = pool.take_vector("gradient", grid.dims, back * len);
                let lengths = [field_len(grid), stride - field_len(grid)];
                let [x, _] = pool.take_split("velocity along x", halo::OFFSET, lengths);
                let [y, z, _] = pool.take_vector("velocity", grid.dims - 1, len);
                (gradient, [x, y, z])
            });
            let states = if back > 0 { STATES } else { 1 };
            let states = pool.take("sub-step states", states * pooled(len));
            let kept = ways.terms(stepping.scheme);
            let [terms, first, second] = pool.take_split(
                "terms of sub-steps, forward and backward",
                halo::OFFSET,
                [kept * stride, back * stride, back * stride],
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
                everywhere: false,
                rolling: back == 0,
                held: None,
                states,
                terms,
                sizes: pool.take("largest elements of their rows", kept * grid.rows()),
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

    /// The same, whose way back leaves out no cell: mu is A_rho^T mu also where there is no smoke, which a gradient by the velocities alone
    /// never asks for.
    #[must_use]
    pub fn everywhere(self) -> Self {
        Self {
            everywhere: true,
            ..self
        }
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
