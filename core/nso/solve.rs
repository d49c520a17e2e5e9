//! V-cycles to a tolerance, with Levenberg-Marquardt damping when a cycle fails to reduce the residual.
//!
//! The paper's remedy for large r (its section 6): kappa grows to kappa + mu with the target pulled towards
//! the flow that damping began from, (kappa t + mu v) / (kappa + mu). At that flow the damped problem has the
//! residual of the true one, so moving the centre after every good cycle and letting mu shrink ends at the
//! solution of the true problem.

use super::info::{Ended, Info, cycle_event};
use super::multigrid::Nso;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::grid::Space;
use crate::observe::Observer;
use crate::operators::self_advection::Fluid;
use crate::real::Real;

/// A cycle that leaves more than this of the residual has failed.
const FAILED: f64 = 0.9;
/// First damping, in units of kappa.
const FIRST_DAMPING: f64 = 1.0;
/// Factors by which damping grows after a failure and shrinks after a good cycle.
const GROWTH: f64 = 4.0;
const SHRINKAGE: f64 = 0.25;
/// Damping below this, in units of kappa, is dropped.
const NEGLIGIBLE: f64 = 1e-2;

impl<T: Real, S: Space> Nso<'_, T, S> {
    /// Solves to the tolerance, from the state as it is.
    pub fn solve(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Info {
        let mut info = Info::default();
        let mut damping = Damping::default();
        let mut residual = self.residual(exec);
        let _ = info.residuals.push(residual);
        for cycle in 1..=self.setup.params.cycles {
            if residual < self.setup.params.tolerance {
                break;
            }
            if self.vcycle(exec, observer).is_break() {
                info.ended = Ended::Cancelled;
                break;
            }
            let after = self.residual(exec);
            residual = self.damp(exec, &mut damping, residual, after);
            info.damped |= damping.mu > 0.0;
            let _ = info.residuals.push(residual);
            if observer.on(cycle_event(cycle, residual)).is_break() {
                info.ended = Ended::Cancelled;
                break;
            }
        }
        if damping.mu > 0.0 {
            self.undamp(&mut damping);
        }
        self.judge(info, residual)
    }

    /// How a solve ended that left this residual.
    fn judge(&self, info: Info, residual: f64) -> Info {
        if !residual.is_finite() {
            info.ended(Ended::NotFinite)
        } else if residual < self.setup.params.tolerance && info.ended != Ended::Cancelled {
            info.ended(Ended::Converged)
        } else {
            info
        }
    }

    /// Judges a cycle that changed the residual of the damped problem from `before` to `after`; the residual
    /// of the true one.
    fn damp(&mut self, exec: &dyn Exec, damping: &mut Damping, before: f64, after: f64) -> f64 {
        let kappa = self.setup.kappa;
        let good = after < FAILED * before;
        if good && damping.mu == 0.0 {
            return after;
        }
        if !good {
            let lost = !(after < 2.0 * before);
            if lost && damping.mu > 0.0 {
                self.return_to_centre(exec, damping.mu);
            } else if lost && !after.is_finite() {
                self.state_to_rest(exec);
            }
            damping.mu = if damping.mu == 0.0 {
                FIRST_DAMPING * kappa
            } else {
                GROWTH * damping.mu
            };
        } else {
            damping.mu *= SHRINKAGE;
        }
        if damping.mu < NEGLIGIBLE * kappa {
            self.undamp(damping);
        } else {
            self.centre(exec, damping);
        }
        self.residual(exec)
    }

    /// Moves the centre to the current flow: `spare` = (kappa t + mu v) / (kappa + mu), with which equation a
    /// is damped.
    fn centre(&mut self, exec: &dyn Exec, damping: &mut Damping) {
        if damping.swapped {
            core::mem::swap(&mut self.levels[0].a, &mut self.spare);
        }
        let (kappa, mu) = (self.setup.kappa, damping.mu);
        let level = &self.levels[0];
        blend(
            exec,
            &mut self.spare,
            kappa / (kappa + mu),
            view(&level.a),
            mu / (kappa + mu),
            view(&level.state.v),
        );
        core::mem::swap(&mut self.levels[0].a, &mut self.spare);
        damping.swapped = true;
        self.set_kappa(kappa + mu);
    }

    /// The true problem again.
    fn undamp(&mut self, damping: &mut Damping) {
        if damping.swapped {
            core::mem::swap(&mut self.levels[0].a, &mut self.spare);
        }
        *damping = Damping::default();
        self.set_kappa(self.setup.kappa);
    }

    fn set_kappa(&mut self, kappa: f64) {
        self.coefficients.kappa = T::from_f64(kappa);
        self.coefficients.damping = self.setup.damping.at(kappa);
        self.levels[0].scale = T::from_f64(kappa);
    }

    /// v = the centre that damping pulls to, which the damped target still holds; pressures from zero.
    fn return_to_centre(&mut self, exec: &dyn Exec, mu: f64) {
        let kappa = self.setup.kappa;
        let level = &mut self.levels[0];
        blend(
            exec,
            &mut level.state.v,
            (kappa + mu) / mu,
            view(&level.a),
            -kappa / mu,
            view(&self.spare),
        );
        self.rest_of_state(exec);
    }

    /// v = t, the start of the very first solve: for a cycle that went astray before there was a centre.
    fn state_to_rest(&mut self, exec: &dyn Exec) {
        let level = &mut self.levels[0];
        blend(exec, &mut level.state.v, 1.0, view(&level.a), 0.0, view(&level.a));
        self.rest_of_state(exec);
    }

    /// w from v, pressures zero.
    fn rest_of_state(&mut self, exec: &dyn Exec) {
        let level = &mut self.levels[0];
        level.state.p.fill(T::ZERO);
        level.state.pbar.fill(T::ZERO);
        self.force_of_state(exec, false);
    }

    /// w from v by equation c, with or without a pressure.
    pub(super) fn force_of_state(&mut self, exec: &dyn Exec, with_pressure: bool) {
        let level = &mut self.levels[0];
        let p = if with_pressure { &*level.state.p } else { &[] };
        crate::force::from_velocity::<T, S>(
            exec,
            Fluid {
                grid: level.grid,
                slots: self.coefficients.slots,
                viscosity: self.setup.viscosity,
                solids: level.solids,
            },
            view(&level.state.v),
            view(&level.v0),
            p,
            reborrow(&mut level.state.w),
            self.scratch,
        );
        for (w, lift) in level.state.w.iter_mut().zip(&level.c) {
            if !lift.is_empty() {
                rows::sub(w, lift);
            }
        }
    }
}

/// The state of the damping.
#[derive(Clone, Copy, Debug, Default)]
struct Damping {
    mu: f64,
    /// Whether level 0 reads the damped target, and `spare` holds the true one.
    swapped: bool,
}

/// `out = s x + t y` at all faces.
fn blend<T: Real>(
    exec: &dyn Exec,
    out: &mut VectorMut<'_, T>,
    s: f64,
    x: Vector<'_, T>,
    t: f64,
    y: Vector<'_, T>,
) {
    /// Values of one task.
    const CHUNK: usize = 4096;
    for axis in 0..3 {
        let whole = out[axis].len() / CHUNK * CHUNK;
        let (chunks, tail) = out[axis].split_at_mut(whole);
        let combine = |out: &mut [T], at: usize| {
            let range = at..at + out.len();
            rows::scale(out, T::from_f64(s), &x[axis][range.clone()]);
            rows::add_scaled(out, T::from_f64(t), &y[axis][range]);
        };
        for_rows(exec, whole / CHUNK, RowBuffers::fields([chunks]), |task| {
            let [out] = task.fields;
            combine(out, task.row * CHUNK);
        });
        combine(tail, whole);
    }
}
