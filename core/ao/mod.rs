//! AO, the advection problem of the paper (section 4.1, eq. 7, Algorithm 1): velocities v* near v + lambda/K that carry the
//! density to the keyframes.
//!
//! A fixed-point iteration: forward rho_{i+1} = A[rho_i, v*_i]; backward mu_{i-1} = A_rho^T mu_i - C_i e_i (mu_N = 0);
//! candidate Q(v_i + lambda_i/K + A_v^T mu_i / K); then v* moves a part alpha of the way, halved until the objective
//! 1/2 <e, C e> + K/2 sum |v* - v - lambda/K|^2 falls.
//!
//! From the second iteration of a call on, the direction is candidate - v* + beta (the direction before): the momentum of
//! Polyak's heavy ball, in the same bytes, since the projection is linear. beta = 0 is the paper's iteration.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, rows, sums, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::observe::{Event, Observer};
use crate::plan::{Ledger, Pool, Sharing, pooled};
use crate::poisson::Projection;
use crate::problem::Advection;
use crate::problem::keyframes::{DataTerm, Keyframes};
use crate::real::Real;
use crate::transport::{Flow, Stop, Transport};
use core::ops::ControlFlow;

/// The smallest blending step that is tried.
const SMALLEST_STEP: f64 = 1.0 / 1024.0;

/// What does not change from call to call.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// Penalty K in scaled numbers.
    pub penalty: f64,
    /// Fixed-point iterations of a call.
    pub iterations: usize,
    /// Momentum beta between the iterations of a call.
    pub momentum: f64,
    /// Slots T = N - 1.
    pub slots: usize,
    /// Filters of the metric.
    pub filters: usize,
    /// The transport.
    pub advection: Advection,
    /// max rho_0.
    pub largest: f64,
    /// Relative tolerance of the projection.
    pub projection_tolerance: f64,
    /// Threads that scratch was planned for.
    pub threads: usize,
}

/// The fields of a call.
#[derive(Debug)]
pub struct Fields<'a, T> {
    /// v of the Navier-Stokes problem.
    pub v: Vector<'a, T>,
    /// lambda / K.
    pub multiplier: Vector<'a, T>,
    /// v*, which begins as v.
    pub star: VectorMut<'a, T>,
    /// Work: the direction in which v* moves.
    pub direction: VectorMut<'a, T>,
    /// The given velocity v_0.
    pub initial: Vector<'a, T>,
    /// rho_0 .. rho_N of the last call, and of this one afterwards.
    pub rho: &'a mut [T],
    /// The keyframes.
    pub keyframes: &'a Keyframes<'a, T>,
}

/// What a call did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Info {
    /// The blending step of the last iteration.
    pub step: f64,
    /// Data term of v before the call.
    pub data_before: f64,
    /// Data term of v* after it.
    pub data: f64,
    /// AO objective after it.
    pub objective: f64,
    /// max |direction| of the last blend: without momentum the residual of the fixed point.
    pub residual: f64,
    /// max over cells and steps of the change of rho since the last call.
    pub density_change: f64,
}

/// Writes the ledger lines of a call's work in the shared pool.
pub fn requirement<T: Real>(ledger: &mut Ledger, grid: &Grid, setup: &Setup) {
    ledger.group("advection problem (AO)", Sharing::InTurn, |ledger| {
        ledger.group("transport and metric", Sharing::Together, |ledger| {
            ledger.line("densities of a trial and mu", pooled((setup.slots + 2) * grid.cells()) + pooled(grid.cells()), T::BYTES);
            Transport::<T>::requirement(ledger, grid, setup.threads);
            DataTerm::<T>::requirement(ledger, grid, setup.filters, setup.threads);
        });
        Projection::<T>::requirement(ledger, grid, setup.slots, setup.threads);
    });
}

/// Transport and metric of one call, carved from the shared pool.
pub struct Carrier<'a, T> {
    grid: &'a Grid,
    /// Densities of the flow that was run last.
    pub rho: &'a mut [T],
    mu: &'a mut [T],
    transport: Transport<'a, T>,
    data: DataTerm<'a, T>,
}

impl<'a, T: Real> Carrier<'a, T> {
    /// Takes its numbers.
    pub fn carve(grid: &'a Grid, setup: &Setup, pool: &mut Pool<'a, T>) -> Self {
        Self {
            grid,
            rho: pool.take((setup.slots + 2) * grid.cells()),
            mu: pool.take(grid.cells()),
            transport: Transport::carve(grid, setup.advection.scheme, setup.advection.tolerance, setup.largest, setup.threads, pool),
            data: DataTerm::carve(grid, setup.filters, setup.threads, pool),
        }
    }

    /// Transports `source` by `flow`; the data term of where it goes.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn carry(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        flow: &Flow<'_, T>,
        source: &[T],
        keyframes: &Keyframes<'_, T>,
        slots: usize,
        sums: &mut [f64],
    ) -> Result<f64, Stop> {
        self.rho[..source.len()].copy_from_slice(source);
        self.transport.run(exec, observer, flow, slots, self.rho, sums)?;
        Ok(self.data.total(exec, self.rho, keyframes, sums))
    }

    /// `direction` = v + lambda/K + A_v^T mu / K - v* + `momentum` direction, all at v* (paper Algorithm 1, lines 6 to 9), not
    /// projected yet.
    ///
    /// # Errors
    /// [`Stop`].
    fn sweep_back(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        setup: &Setup,
        fields: &mut Fields<'_, T>,
        momentum: f64,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let grid = self.grid;
        let (cells, slots, n) = (grid.cells(), setup.slots, grid.n[0]);
        let (scale, momentum) = (T::from_f64(1.0 / setup.penalty), T::from_f64(momentum));
        self.mu.fill(T::ZERO);
        for step in (1..=slots).rev() {
            if let Some(index) = fields.keyframes.at(step + 1) {
                self.data.evaluate(exec, &self.rho[(step + 1) * cells..][..cells], fields.keyframes.density(index, cells), sums);
                rows::sub(self.mu, self.data.image());
            }
            let flow = Flow { initial: fields.initial, v: view(&fields.star), along: None };
            self.transport.load(exec, &flow, slots, step, sums).map_err(|_| Stop::TooFast)?;
            self.transport.backward(exec, &self.rho[step * cells..][..cells], self.mu, sums);
            let gradient = self.transport.gradient();
            let (v, multiplier, star) = (fields.v, fields.multiplier, view(&fields.star));
            let buffers = RowBuffers { fields: crate::field::reborrow(&mut fields.direction), sums: &mut [], scratch: &mut [] };
            for_rows(exec, grid.rows(), 0..grid.rows(), buffers, |task| {
                let span = (task.row * slots + step - 1) * n..(task.row * slots + step) * n;
                for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                    let out = &mut out[(step - 1) * n..step * n];
                    rows::scale_in_place(out, momentum);
                    rows::add_scaled(out, scale, &gradient[axis][task.row * n..(task.row + 1) * n]);
                    rows::add(out, &v[axis][span.clone()]);
                    rows::add(out, &multiplier[axis][span.clone()]);
                    rows::sub(out, &star[axis][span.clone()]);
                }
            });
            if observer.on(Event::Work).is_break() {
                return Err(Stop::Cancelled);
            }
        }
        Ok(())
    }
}

/// One call (paper Algorithm 1): `setup.iterations` fixed-point iterations from v* = v. `step` is alpha, kept from call to call.
///
/// # Errors
/// [`Stop::Cancelled`]; [`Stop::TooFast`] when v itself cannot be transported.
pub fn solve<T: Real>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    levels: &Levels<'_, T>,
    setup: &Setup,
    mut fields: Fields<'_, T>,
    step: &mut f64,
    region: &mut [T],
    sums: &mut [f64],
) -> Result<Info, Stop> {
    let grid = &levels.grids[0];
    let mut info = Info::default();
    for iteration in 0..setup.iterations {
        let mut carrier = Carrier::carve(grid, setup, &mut Pool::new(&mut *region));
        if iteration == 0 {
            let flow = Flow { initial: fields.initial, v: view(&fields.star), along: None };
            info.data = carrier.carry(exec, observer, &flow, &fields.rho[..grid.cells()], fields.keyframes, setup.slots, sums)?;
            info.objective = info.data + distance(exec, grid, setup, &fields, 0.0, sums);
            info.data_before = info.data;
        }
        let before = info.objective;
        if iteration == 0 {
            fields.direction.iter_mut().for_each(|component| component.fill(T::ZERO));
        }
        carrier.sweep_back(exec, observer, setup, &mut fields, if info.step > 0.0 { setup.momentum } else { 0.0 }, sums)?;
        project(exec, observer, levels, setup, &mut fields.direction, region, sums)?;
        let slots = setup.slots;
        info.residual = sums::max_abs(exec, grid, slots, view(&fields.direction), sums);
        blend(exec, observer, grid, setup, &mut fields, step, before, region, sums, &mut info)?;
        if observer.on(Event::AoIteration { objective: info.objective, step: info.step }).is_break() {
            return Err(Stop::Cancelled);
        }
    }
    let carrier = Carrier::carve(grid, setup, &mut Pool::new(region));
    info.density_change = exchange(exec, grid, carrier.rho, fields.rho, sums);
    Ok(info)
}

fn project<T: Real>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    levels: &Levels<'_, T>,
    setup: &Setup,
    v: &mut VectorMut<'_, T>,
    region: &mut [T],
    sums: &mut [f64],
) -> Result<(), Stop> {
    let mut projection = Projection::carve(levels, setup.slots, setup.threads, &mut Pool::new(region));
    match projection.project(exec, observer, setup.slots, v, None, setup.projection_tolerance, sums) {
        ControlFlow::Continue(_) => Ok(()),
        ControlFlow::Break(()) => Err(Stop::Cancelled),
    }
}

/// K/2 sum |v* + s direction - v - lambda/K|^2.
fn distance<T: Real>(exec: &dyn Exec, grid: &Grid, setup: &Setup, fields: &Fields<'_, T>, s: f64, sums: &mut [f64]) -> f64 {
    let (star, direction, slots, s) = (view(&fields.star), view(&fields.direction), setup.slots, T::from_f64(s));
    let total = sums::total(exec, grid, sums, |row| {
        (0..grid.dims)
            .map(|a| {
                let [star, direction, v, multiplier] =
                    [star[a], direction[a], fields.v[a], fields.multiplier[a]].map(|field| sums::row(grid, slots, field, row));
                rows::distance(star, direction, s, v, multiplier)
            })
            .sum()
    });
    0.5 * setup.penalty * total
}

/// Moves v* along the direction, alpha halved until the objective falls below `before`; leaves v* where it is if it never does.
fn blend<T: Real>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    grid: &Grid,
    setup: &Setup,
    fields: &mut Fields<'_, T>,
    step: &mut f64,
    before: f64,
    region: &mut [T],
    sums: &mut [f64],
    info: &mut Info,
) -> Result<(), Stop> {
    let mut carrier = Carrier::carve(grid, setup, &mut Pool::new(region));
    info.step = 0.0;
    while *step >= SMALLEST_STEP {
        let flow = Flow { initial: fields.initial, v: view(&fields.star), along: Some((view(&fields.direction), T::from_f64(*step))) };
        let data = match carrier.carry(exec, observer, &flow, &fields.rho[..grid.cells()], fields.keyframes, setup.slots, sums) {
            Err(Stop::Cancelled) => return Err(Stop::Cancelled),
            Err(Stop::TooFast) => f64::INFINITY,
            Ok(data) => data,
        };
        let after = data + distance(exec, grid, setup, fields, *step, sums);
        if after < before {
            (info.step, info.data, info.objective) = (*step, data, after);
            break;
        }
        *step *= 0.5;
    }
    if info.step > 0.0 {
        let (direction, s, slots) = (view(&fields.direction), T::from_f64(info.step), setup.slots);
        let star = crate::field::reborrow(&mut fields.star);
        for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: star, sums: &mut [], scratch: &mut [] }, |task| {
            for (axis, star) in task.fields.into_iter().enumerate().take(grid.dims) {
                rows::add_scaled(star, s, sums::row(grid, slots, direction[axis], task.row));
            }
        });
    } else {
        let flow = Flow { initial: fields.initial, v: view(&fields.star), along: None };
        carrier.carry(exec, observer, &flow, &fields.rho[..grid.cells()], fields.keyframes, setup.slots, sums)?;
    }
    *step = (2.0 * *step).min(1.0);
    Ok(())
}

/// `to = from`; the largest change.
fn exchange<T: Real>(exec: &dyn Exec, grid: &Grid, from: &[T], to: &mut [T], sums: &mut [f64]) -> f64 {
    let cells = grid.cells();
    let fields = to.len() / cells;
    let (before, n) = (&*to, grid.n[0]);
    let change = sums::largest(exec, grid, sums, |row| {
        rows::largest((0..fields).map(|step| {
            let span = step * cells + row * n..step * cells + (row + 1) * n;
            rows::max_gap(&from[span.clone()], &before[span], T::ONE)
        }))
    });
    to.copy_from_slice(&from[..to.len()]);
    change
}
