//! Where a flow carries the density: the data term of a trajectory, and its gradient by one sweep back in time.
//!
//! Forward rho_{i+1} = A[rho_i, v_i] + s_i with what emitters add; backward mu_{i-1} = A_rho^T mu_i - C_i e_i with mu_N = 0. The data term's derivative by v_i
//! is -A_v^T mu_{i+1}: what the advection problem (paper Algorithm 1) and the direct method (mathematics section 6) move along.

use crate::exec::{Exec, Serial, join};
use crate::field::{Vector, rows};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::grid::solids::Surfaces;
use crate::memory::{Pool, Sharing};
use crate::objective::data_term::DataTerm;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::operators::blur::Metric;
use crate::problem::Problem;
use crate::real::Real;
use crate::transport::{Flow, Stepping, Stop, TooFast, Transport};

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
    /// What the flow meets.
    pub surfaces: Surfaces,
    /// Whether there is memory for two threads to do different works where fields are small.
    pub overlap: bool,
}

/// Cells up to which two of so many threads gain more by different works than by sharing the rows of every term, wherever their caches are.
/// All others wait meanwhile.
const fn most_overlapped(threads: usize) -> usize {
    match threads {
        0 | 1 => 0,
        2 => 1 << 15,
        _ => 1 << 12,
    }
}

impl Setup {
    /// That of `problem` on its own grid, for rho_0 of at most 1.
    #[must_use]
    pub fn new(problem: &Problem<'_>, threads: usize) -> Self {
        let metric = Metric {
            filters: problem.filters(),
            identity: 1.0,
        };
        Self {
            slots: problem.slots(),
            metric,
            stepping: problem.advection.into(),
            largest: 1.0,
            threads,
            surfaces: problem.surfaces(),
            overlap: false,
        }
    }

    /// Whether two threads do different works on a grid: each every other step on the way back, and one projects the force while the other
    /// carries the density. Ranks exchange what one thread says, in its order.
    #[must_use]
    pub fn overlaps(&self, grid: &Grid) -> bool {
        self.overlap && !grid.is_part() && grid.cells() <= most_overlapped(self.threads)
    }
}

/// Densities of a trajectory: rho_0 .. rho_N.
#[must_use]
pub fn densities(grid: &Grid, slots: usize) -> usize {
    (slots + 2) * grid.cells()
}

/// The density of a step among those of all.
fn density_of<T>(rho: &[T], cells: usize, step: usize) -> &[T] {
    rows::part(rho, step * cells..(step + 1) * cells)
}

/// Who goes along with a sweep back, last step first.
pub trait Companion<T>: Send {
    /// At the density of `step`, before the way back from there: mu, minus the derivative of what comes later by that density, to which what
    /// else depends on it can be added.
    fn at_density(&mut self, exec: &dyn Exec, step: usize, mu: &mut [T]) {
        let _ = (exec, step, mu);
    }

    /// At the flow in `slot`: A_v^T mu at its faces, minus the derivative of what comes later by that velocity, with threads to use.
    fn at_flow(&mut self, exec: &dyn Exec, slot: usize, gradient: Vector<'_, T>);
}

/// One that is told of flows alone.
impl<T, F: FnMut(&dyn Exec, usize, Vector<'_, T>) + Send> Companion<T> for F {
    fn at_flow(&mut self, exec: &dyn Exec, slot: usize, gradient: Vector<'_, T>) {
        self(exec, slot, gradient);
    }
}

/// Transport and metric, carved from a shared pool.
pub struct DensitySweep<'a, T> {
    grid: &'a Grid,
    slots: usize,
    mu: &'a mut [T],
    transport: Transport<'a, T>,
    /// That of every other step on the way back.
    other: Option<Transport<'a, T>>,
    data: DataTerm<'a, T>,
}

impl<'a, T: Real> DensitySweep<'a, T> {
    /// Takes its workspace from a pool. The grid is number `level` of the hierarchy.
    pub fn carve(hierarchy: &'a Levels<'_, T>, level: usize, setup: &Setup, pool: &mut Pool<'a, T>) -> Self {
        pool.group("transport and metric", Sharing::Together, |pool| {
            let data = DataTerm::carve(hierarchy, level, setup.metric, setup.threads, pool);
            let grid = data.grid();
            let mu = pool.take("mu", grid.cells());
            let solids = hierarchy.solids(level);
            let mut transport = || {
                Transport::carve(grid, setup.stepping, setup.largest, setup.threads, pool).among(solids, pool)
            };
            Self {
                grid,
                slots: setup.slots,
                mu,
                transport: transport(),
                other: setup.overlaps(grid).then(transport),
                data,
            }
        })
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
        script: &Script<'_, T>,
        sums: &mut [f64],
    ) -> Result<f64, Stop> {
        for step in 0..=self.slots {
            self.carry_step(exec, observer, flow, rho, step, script, sums)?;
        }
        Ok(self.data.total(exec, rho, script, usize::MAX, sums))
    }

    /// Transports the density of `step` to the next one, and adds what is emitted on the way.
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
        script: &Script<'_, T>,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        self.transport.step(exec, flow, self.slots, step, rho, sums)?;
        let cells = self.grid.cells();
        script.emit(
            exec,
            self.grid,
            step + 1,
            rows::part_mut(rho, (step + 1) * cells..(step + 2) * cells),
        );
        Stop::heard(observer)
    }

    /// What is emitted after `step`, whose density is `rho`.
    ///
    /// # Errors
    /// [`TooFast`].
    pub fn emission(
        &mut self,
        exec: &dyn Exec,
        flow: &Flow<'_, T>,
        (step, rho): (usize, &[T]),
        script: &Script<'_, T>,
        sums: &mut [f64],
    ) -> Result<&[T], TooFast> {
        self.transport.load(exec, flow, self.slots, step, sums)?;
        self.transport.forward(exec, rho, self.mu);
        let out = self.data.field();
        out.copy_from_slice(self.mu);
        script.emit(exec, self.grid, step + 1, out);
        rows::sub(out, self.mu);
        Ok(out)
    }

    /// The data term of densities that were carried, of the keyframes at `last` or before.
    pub fn data(
        &mut self,
        exec: &dyn Exec,
        rho: &[T],
        script: &Script<'_, T>,
        last: usize,
        sums: &mut [f64],
    ) -> f64 {
        self.data.total(exec, rho, script, last, sums)
    }

    /// Backwards through the flow that carried `rho`, with a companion.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn sweep_back(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        flow: &Flow<'_, T>,
        rho: &[T],
        script: &Script<'_, T>,
        sums: &mut [f64],
        companion: &mut dyn Companion<T>,
    ) -> Result<(), Stop> {
        let cells = self.grid.cells();
        self.mu.fill(T::ZERO);
        for step in (1..=self.slots).rev() {
            let after = density_of(rho, cells, step + 1);
            if let Some(index) = script.at(step + 1) {
                self.data
                    .evaluate(exec, after, &script.wanted(index, cells), sums);
                rows::sub(self.mu, self.data.image());
            }
            companion.at_density(exec, step + 1, self.mu);
            script.forget(exec, self.grid, step + 1, after, self.mu);
            self.back_through(exec, flow, rho, step, sums, companion)
                .map_err(|TooFast| Stop::TooFast)?;
            Stop::heard(observer)?;
        }
        Ok(())
    }

    /// Back through a step: the companion receives its gradient now, or in overlap while the step before is gone through.
    fn back_through(
        &mut self,
        exec: &dyn Exec,
        flow: &Flow<'_, T>,
        rho: &[T],
        step: usize,
        sums: &mut [f64],
        companion: &mut dyn Companion<T>,
    ) -> Result<(), TooFast> {
        let (slots, cells) = (self.slots, self.grid.cells());
        let rho_of = |step: usize| density_of(rho, cells, step);
        let Some(other) = &mut self.other else {
            self.transport.load(exec, flow, slots, step, sums)?;
            self.transport.backward(exec, rho_of(step), self.mu);
            companion.at_flow(exec, step - 1, self.transport.gradient());
            return Ok(());
        };
        // One thread goes back through the step while the other hands on the gradient of the step after, through which it went back, and
        // prepares the one before, through which it will: what a step holds stays in the cache of one core.
        let even = step.is_multiple_of(2);
        let (now, next) = if even {
            (&mut self.transport, other)
        } else {
            (other, &mut self.transport)
        };
        if step == slots {
            now.load(exec, flow, slots, step, sums)?;
            now.prepare(exec, rho_of(step));
        }
        let mu = &mut *self.mu;
        let mut loaded = Ok(());
        let mut go_back = || now.backward(&Serial, rho_of(step), mu);
        let mut prepare = || {
            if step < slots {
                companion.at_flow(&Serial, step, next.gradient());
            }
            if step > 1 {
                loaded = next
                    .load(&Serial, flow, slots, step - 1, sums)
                    .map(|()| next.prepare(&Serial, rho_of(step - 1)));
            }
        };
        if even {
            join(exec, &mut go_back, &mut prepare);
        } else {
            join(exec, &mut prepare, &mut go_back);
        }
        if step == 1 {
            companion.at_flow(exec, 0, now.gradient());
        }
        loaded
    }
}
