//! AO, the advection problem of the paper (section 4.1, eq. 7, Algorithm 1): velocities v* near v + lambda/K that carry the
//! density to the keyframes.
//!
//! A fixed-point iteration: forward and backward through the flow (see [`crate::objective::sweep`]); candidate
//! Q(v_i + lambda_i/K + A_v^T mu_i / K); then v* moves a part alpha of the way, halved until the objective
//! 1/2 <e, C e> + K/2 sum |v* - v - lambda/K|^2 falls, to which buoyancy adds a term (see `lifted`).
//!
//! From the second iteration of a call on, the direction is candidate - v* + beta (the direction before): the momentum of
//! Polyak's heavy ball, in the same bytes, since the projection is linear. beta = 0 is the paper's iteration.

mod call;
mod lifted;
mod trial;

pub use crate::progress::MAX_RESIDUALS;
pub use call::{Fields, Info, Setup};

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{VectorMut, reborrow, rows, sums, view};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Pool, Sharing};
use crate::observe::{Event, Observer, Phase};
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;
use core::ops::ControlFlow;
use trial::{Trial, distance};

/// How observers hear of a call.
pub const AO: Phase = Phase {
    name: "ao",
    words: "advection problem",
    measure: "objective",
};

/// The smallest blending step that is tried.
const SMALLEST_STEP: f64 = 1.0 / 1024.0;

/// What a call takes of a region in turn, for a pool that measures.
pub fn measure<'l, T: Real>(levels: &'l Levels<'_, T>, setup: &Setup, pool: &mut Pool<'l, T>) {
    pool.group("advection problem (AO)", Sharing::InTurn, |pool| {
        Trial::carve(levels, setup, pool);
        let sweep = &setup.flow.sweep;
        Projection::carve(levels, 0, sweep.slots, sweep.threads, pool);
    });
}

/// One call (paper Algorithm 1): `setup.iterations` fixed-point iterations from v* = v. `step` is alpha, kept from call to call.
///
/// # Errors
/// [`Stop::Cancelled`]; [`Stop::TooFast`] when v itself cannot be transported.
pub fn solve<T: Real, S: Space>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    levels: &Levels<'_, T>,
    setup: &Setup,
    mut fields: Fields<'_, T>,
    step: &mut f64,
    region: &mut [T],
    sums: &mut [f64],
) -> Result<Info, Stop> {
    let grid = &levels.finest;
    let slots = setup.flow.sweep.slots;
    let mut info = Info::default();
    for iteration in 0..setup.iterations {
        let mut trial = Trial::carve(levels, setup, &mut Pool::new(&mut *region));
        if iteration == 0 {
            info.data = trial.carry(exec, observer, &fields, 0.0, sums)?;
            info.objective = info.data
                + trial.price::<S>(exec, observer, &fields, sums)?
                + distance(exec, grid, setup, &fields, 0.0, sums);
            info.data_before = info.data;
            fields
                .direction
                .iter_mut()
                .for_each(|component| component.fill(T::ZERO));
        }
        let before = info.objective;
        let momentum = if info.step > 0.0 { setup.momentum } else { 0.0 };
        trial.sweep_back(exec, observer, setup, &mut fields, momentum, sums)?;
        project(exec, observer, levels, setup, &mut fields.direction, region, sums)?;
        let residual = sums::max_abs(exec, grid, slots, view(&fields.direction), sums);
        if let (Err(_), Some(last)) = (info.residuals.push(residual), info.residuals.last_mut()) {
            *last = residual;
        }
        blend::<T, S>(
            exec,
            observer,
            levels,
            setup,
            &mut fields,
            step,
            before,
            region,
            sums,
            &mut info,
        )?;
        let event = Event::PhaseStep {
            phase: AO,
            step: iteration + 1,
            value: info.objective,
            taken: info.step,
        };
        if observer.on(event).is_break() {
            return Err(Stop::Cancelled);
        }
    }
    let trial = Trial::carve(levels, setup, &mut Pool::new(region));
    info.density_change = exchange(exec, grid, trial.rho, fields.rho, sums);
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
    let slots = setup.flow.sweep.slots;
    let mut projection =
        Projection::carve(levels, 0, slots, setup.flow.sweep.threads, &mut Pool::new(region));
    match projection.project(exec, observer, v, None, setup.flow.projection_tolerance, sums) {
        ControlFlow::Continue(_) => Ok(()),
        ControlFlow::Break(()) => Err(Stop::Cancelled),
    }
}

/// Moves v* along the direction, alpha halved until the objective falls below `before`; leaves v* where it is if it never does.
fn blend<T: Real, S: Space>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    levels: &Levels<'_, T>,
    setup: &Setup,
    fields: &mut Fields<'_, T>,
    step: &mut f64,
    before: f64,
    region: &mut [T],
    sums: &mut [f64],
    info: &mut Info,
) -> Result<(), Stop> {
    let grid = &levels.finest;
    let mut trial = Trial::carve(levels, setup, &mut Pool::new(region));
    info.step = 0.0;
    while *step >= SMALLEST_STEP {
        let data = match trial.carry(exec, observer, fields, *step, sums) {
            Err(Stop::Cancelled) => return Err(Stop::Cancelled),
            Err(Stop::TooFast) => f64::INFINITY,
            Ok(data) => data,
        };
        let after = data + distance(exec, grid, setup, fields, *step, sums);
        let after = if after < before {
            after + trial.price::<S>(exec, observer, fields, sums)?
        } else {
            after
        };
        if after < before {
            (info.step, info.data, info.objective) = (*step, data, after);
            break;
        }
        *step *= 0.5;
    }
    if info.step > 0.0 {
        let direction = view(&fields.direction);
        let s = T::from_f64(info.step);
        let slots = setup.flow.sweep.slots;
        let star = reborrow(&mut fields.star);
        for_rows(exec, grid.rows(), RowBuffers::fields(star), |task| {
            for (axis, star) in task.fields.into_iter().enumerate().take(grid.dims) {
                rows::add_scaled(star, s, sums::row(grid, slots, direction[axis], task.row));
            }
        });
    } else {
        trial.carry(exec, observer, fields, 0.0, sums)?;
        trial.price::<S>(exec, observer, fields, sums)?;
    }
    *step = (2.0 * *step).min(1.0);
    Ok(())
}

/// `to = from`; the largest change.
fn exchange<T: Real>(exec: &dyn Exec, grid: &Grid, from: &[T], to: &mut [T], sums: &mut [f64]) -> f64 {
    let cells = grid.cells();
    let fields = to.len() / cells;
    let before = &*to;
    let n = grid.n[0];
    let change = sums::largest(exec, grid, sums, |row| {
        rows::largest((0..fields).map(|step| {
            let span = step * cells + row * n..step * cells + (row + 1) * n;
            rows::max_gap(&from[span.clone()], &before[span], T::ONE)
        }))
    });
    to.copy_from_slice(&from[..to.len()]);
    change
}
