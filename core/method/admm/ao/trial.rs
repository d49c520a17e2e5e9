//! A flow that AO tries: where it carries the density, the way back, and how far it is from where it should stay.

use super::call::{Fields, Setup};
use super::lifted::{Lifted, WithLift};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, borders, reborrow, rows, sums, view};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Pool, Sharing};
use crate::objective::sweep::{DensitySweep, densities};
use crate::observe::Observer;
use crate::real::Real;
use crate::transport::{Flow, Stop};

/// A flow that is tried, in the shared pool: its densities, what carries them, and the force that v needs among them where they push it.
pub struct Trial<'a, T> {
    /// Its densities.
    pub rho: &'a mut [T],
    sweep: DensitySweep<'a, T>,
    lifted: Option<Lifted<'a, T>>,
}

impl<'a, T: Real> Trial<'a, T> {
    /// Takes it from a pool.
    pub fn carve(levels: &'a Levels<'_, T>, setup: &Setup, pool: &mut Pool<'a, T>) -> Self {
        let sweep = &setup.flow.sweep;
        pool.group("forward and backward", Sharing::Together, |pool| Self {
            rho: pool.take("densities of a trial", densities(&levels.finest, sweep.slots)),
            sweep: DensitySweep::carve(levels, 0, sweep, pool),
            lifted: Lifted::carve(levels, setup, pool),
        })
    }

    /// The data term of v* + `s` direction.
    pub fn carry(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        fields: &Fields<'_, T>,
        s: f64,
        sums: &mut [f64],
    ) -> Result<f64, Stop> {
        let cells = self.sweep.grid().cells();
        self.rho[..cells].copy_from_slice(&fields.rho[..cells]);
        let along = (s != 0.0).then(|| (view(&fields.direction), T::from_f64(s)));
        let flow = Flow {
            initial: fields.initial,
            v: view(&fields.star),
            along,
        };
        self.sweep
            .carry(exec, observer, &flow, self.rho, fields.script, sums)
    }

    /// What the force of v costs by the densities that were carried last: nothing but where they push the flow.
    pub fn price<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        fields: &Fields<'_, T>,
        sums: &mut [f64],
    ) -> Result<f64, Stop> {
        match &mut self.lifted {
            Some(lifted) => lifted.price::<S>(exec, observer, fields, self.rho, sums),
            None => Ok(0.0),
        }
    }

    /// `direction` = v + lambda/K + A_v^T mu / K - v* + `momentum` direction, all at v* (paper Algorithm 1, lines 6 to 9), not
    /// projected yet.
    pub fn sweep_back(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        setup: &Setup,
        fields: &mut Fields<'_, T>,
        momentum: f64,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let (grid, slots) = (self.sweep.grid(), setup.flow.sweep.slots);
        let n = grid.n[0];
        let (scale, momentum) = (T::from_f64(1.0 / setup.penalty), T::from_f64(momentum));
        let Fields {
            v,
            multiplier,
            star,
            direction,
            initial,
            script,
            ..
        } = fields;
        let star = view(star);
        let flow = Flow {
            initial: *initial,
            v: star,
            along: None,
        };
        self.sweep.sweep_back(
            exec,
            observer,
            &flow,
            self.rho,
            script,
            sums,
            &mut WithLift {
                lifted: self.lifted.as_ref(),
                at_flow: |exec: &dyn Exec, slot: usize, gradient: Vector<'_, T>| {
                    let buffers = RowBuffers::fields(reborrow(direction));
                    for_rows(exec, grid.rows(), buffers, |task| {
                        let span = (task.row * slots + slot) * n..(task.row * slots + slot + 1) * n;
                        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                            let out = &mut out[slot * n..(slot + 1) * n];
                            rows::scale_in_place(out, momentum);
                            rows::add_scaled(out, scale, &gradient[axis][task.row * n..(task.row + 1) * n]);
                            rows::add(out, &v[axis][span.clone()]);
                            rows::add(out, &multiplier[axis][span.clone()]);
                            rows::sub(out, &star[axis][span.clone()]);
                        }
                    });
                },
            },
        )?;
        borders::refresh_faces(exec, grid, direction);
        Ok(())
    }
}

/// K/2 sum |v* + s direction - v - lambda/K|^2.
pub fn distance<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    setup: &Setup,
    fields: &Fields<'_, T>,
    s: f64,
    sums: &mut [f64],
) -> f64 {
    let (star, direction) = (view(&fields.star), view(&fields.direction));
    let slots = setup.flow.sweep.slots;
    let s = T::from_f64(s);
    let total = sums::total(exec, grid, sums, |row| {
        (0..grid.dims)
            .map(|a| {
                let [star, direction, v, multiplier] =
                    [star[a], direction[a], fields.v[a], fields.multiplier[a]]
                        .map(|field| sums::row(grid, slots, field, row));
                rows::distance(star, direction, s, v, multiplier)
            })
            .sum()
    });
    0.5 * setup.penalty * total
}
