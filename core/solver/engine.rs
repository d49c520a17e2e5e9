//! The methods behind one face.

use super::plan::{Choice, admm_settings, direct_settings, forward_settings, lbfgs_settings};
use super::{Method, Params};
use crate::checkpoint::{Damaged, Record};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut};
use crate::grid::{Grid, Space};
use crate::memory::Ledger;
use crate::memory::{Arena, TooSmall};
use crate::method::admm::Admm;
use crate::method::direct::Direct;
use crate::method::lbfgs::Lbfgs;
use crate::method::simulate::forward::Forward;
use crate::objective::keyframes::Keyframes;
use crate::observe::Observer;
use crate::problem::Problem;
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;

/// The state of a method: every buffer but the keyframes.
#[derive(Debug)]
pub(super) enum Engine<'m, T, S> {
    Admm(Admm<'m, T, S>),
    Direct(Direct<'m, T, S>),
    Forward(Forward<'m, T, S>),
    Lbfgs(Lbfgs<'m, T, S>),
}

/// Calls the same method of whichever it is.
macro_rules! each {
    ($engine:expr, $inner:ident => $call:expr) => {
        match $engine {
            Engine::Admm($inner) => $call,
            Engine::Direct($inner) => $call,
            Engine::Forward($inner) => $call,
            Engine::Lbfgs($inner) => $call,
        }
    };
}

impl<'m, T: Real, S: Space> Engine<'m, T, S> {
    pub fn requirement(ledger: &mut Ledger, problem: &Problem<'_>, params: &Params, choice: Choice) {
        match params.method {
            Method::Admm => Admm::<T, S>::requirement(ledger, &admm_settings(problem, params, choice)),
            Method::Direct => Direct::<T, S>::requirement(ledger, &direct_settings(problem, params, choice)),
            Method::Lbfgs => Lbfgs::<T, S>::requirement(ledger, &lbfgs_settings(problem, params)),
            Method::Pd | Method::Simulate => {
                Forward::<T, S>::requirement(ledger, &forward_settings(problem, params))
            }
        }
    }

    pub fn carve(
        arena: &mut Arena<'m>,
        problem: &Problem<'_>,
        params: &Params,
        choice: Choice,
    ) -> Result<Self, TooSmall> {
        match params.method {
            Method::Admm => {
                in_its_frame(|| Admm::carve(arena, &admm_settings(problem, params, choice)).map(Self::Admm))
            }
            Method::Direct => in_its_frame(|| {
                Direct::carve(arena, &direct_settings(problem, params, choice)).map(Self::Direct)
            }),
            Method::Lbfgs => {
                in_its_frame(|| Lbfgs::carve(arena, &lbfgs_settings(problem, params)).map(Self::Lbfgs))
            }
            Method::Pd | Method::Simulate => {
                in_its_frame(|| Forward::carve(arena, &forward_settings(problem, params)).map(Self::Forward))
            }
        }
    }

    /// Numbers that [`Self::record`] passes over.
    pub fn live(problem: &Problem<'_>, params: &Params, choice: Choice) -> usize {
        match params.method {
            Method::Admm => Admm::<T, S>::live(&admm_settings(problem, params, choice)),
            Method::Direct => Direct::<T, S>::live(&direct_settings(problem, params, choice)),
            Method::Lbfgs => Lbfgs::<T, S>::live(&lbfgs_settings(problem, params)),
            Method::Pd | Method::Simulate => Forward::<T, S>::live(&forward_settings(problem, params)),
        }
    }

    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        each!(self, inner => inner.record(record))
    }

    pub fn grid(&self) -> &Grid {
        each!(self, inner => inner.grid())
    }

    pub fn slots(&self) -> usize {
        each!(self, inner => inner.slots())
    }

    pub fn set_source(&mut self, density: &[T], largest: f64) {
        each!(self, inner => inner.set_source(density, largest));
    }

    pub fn initial_mut(&mut self) -> &mut VectorMut<'m, T> {
        each!(self, inner => &mut inner.initial)
    }

    pub fn project_initial(&mut self, exec: &dyn Exec) -> f64 {
        each!(self, inner => inner.project_initial(exec))
    }

    pub fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
    ) -> Progress {
        each!(self, inner => inner.step(exec, observer, keyframes))
    }

    pub fn make_feasible(
        &mut self,
        exec: &dyn Exec,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<Objective, Status> {
        each!(self, inner => inner.make_feasible(exec, keyframes))
    }

    /// rho_0 .. rho_N.
    pub fn rho(&self) -> &[T] {
        each!(self, inner => inner.rho)
    }

    /// v_0, a field of one slot.
    pub fn initial(&self) -> Vector<'_, T> {
        each!(self, inner => crate::field::view(&inner.initial))
    }

    /// v_1 .. v_{N-1}.
    pub fn velocity(&self) -> Vector<'_, T> {
        each!(self, inner => crate::field::view(&inner.v))
    }

    /// The forces of these velocities, after [`Self::make_feasible`].
    pub fn force(&self) -> Vector<'_, T> {
        each!(self, inner => inner.force())
    }
}

/// Calls `make` in a function of its own, so that the stack never holds what another method would need.
#[inline(never)]
fn in_its_frame<R>(make: impl FnOnce() -> R) -> R {
    make()
}
