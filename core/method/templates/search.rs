//! One quasi-Newton iteration over the unknowns of templates.
//!
//! ```text
//! u = Q sum_t a_t f_t(c_t, s_t)        J(z) = J(u(z)), the objective of adjoint control
//! b = z_k + r f (1 + s^2 C^T C) u      its gradient by u
//! dJ/da = <Q b, f>,  dJ/dc = <Q b, a df/dc>,  dJ/d log s = <Q b, a df/d log s>
//! ```
//!
//! A part of a template that a pressure would undo does nothing, so the projection Q takes it out before it is paid for.

use super::sum::Sum;
use super::unknowns::places;
use crate::exec::Exec;
use crate::field::trajectory::{self, Shape};
use crate::field::{VectorMut, rows, sums, view};
use crate::grid::{Grid, Space};
use crate::memory::Pool;
use crate::method::lbfgs::evaluate::{Pull, Push, Simulated, Warm};
use crate::observe::Observer;
use crate::optimise::descent::Function;
use crate::optimise::quasi_newton::fields::{Fields, Initial};
use crate::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::Stop;

/// The largest change of an unknown in the first step that is tried.
const FIRST_STEP: f64 = 0.1;

/// The objective as a function of the unknowns, at a point that can be moved.
pub struct Search<'a, 'm, T> {
    /// That of the forces.
    pub simulated: Simulated<'a, 'm, T>,
    /// The unknowns as a grid of one row.
    pub unknowns: Grid,
    /// The unknowns.
    pub z: &'a mut [T],
    /// The force that they stand for.
    pub u: VectorMut<'a, T>,
    /// The flow at the last point that was accepted.
    pub v: VectorMut<'a, T>,
    /// The flow at the point that is tried.
    pub trial: VectorMut<'a, T>,
    /// The gradient by the force.
    pub gradient: VectorMut<'a, T>,
    /// Gradients, directions and pairs: one component, of the unknowns.
    pub fields: Fields<'a, T>,
    /// The first inverse Hessian: so many times the gradient by the unknowns.
    pub scale: &'a mut f64,
}

impl<'a, T: Real> Search<'a, '_, T> {
    /// What the unknowns stand for, by a copy of what they are read through.
    fn sum<'z>(&self, z: &'z [T]) -> Sum<'z, T>
    where
        'a: 'z,
    {
        let evaluation = &self.simulated.evaluation;
        Sum {
            shape: evaluation.shape(),
            solids: evaluation.levels.solids(evaluation.level),
            script: evaluation.script,
            z,
        }
    }

    /// The objective of the templates at the unknowns `z`.
    fn value_at<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        z: &[T],
        bound: f64,
    ) -> Result<Objective, Stop> {
        let sum = self.sum(z);
        self.u.iter_mut().for_each(|component| component.fill(T::ZERO));
        sum.add_to(exec, false, &[], &mut self.u);
        let tolerance = self.simulated.evaluation.setup.projection_tolerance;
        let Self {
            simulated,
            u,
            v,
            trial,
            ..
        } = self;
        simulated.evaluation.project(exec, observer, u, tolerance)?;
        let warm = Warm {
            v: view(v),
            change: (view(u), 0.0),
        };
        if !sum.pulls() {
            return simulated.value::<S>(exec, observer, view(u), warm, trial, bound);
        }
        // What the densities add is known after they are carried.
        let push = Push {
            u: view(u),
            pull: Some(&sum),
        };
        simulated.simulate::<S>(exec, observer, push, warm, trial)?;
        let evaluation = &mut simulated.evaluation;
        sum.add_to(exec, true, evaluation.rho, u);
        let force = evaluation.projected::<S>(exec, observer, u)?;
        let data = evaluation.data(exec, usize::MAX);
        Ok(Objective { data, ..force })
    }

    /// The gradient by the unknowns `z` into `out`.
    fn gradient_at<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        z: &[T],
        out: &mut [T],
    ) -> Result<(), Stop> {
        let sum = self.sum(z);
        let Self {
            simulated,
            u,
            v,
            trial,
            gradient,
            ..
        } = self;
        let pull: Option<&dyn Pull<T>> = if sum.pulls() { Some(&sum) } else { None };
        simulated.gradient::<S>(exec, observer, Push { u: view(u), pull }, view(trial), gradient)?;
        let evaluation = &mut simulated.evaluation;
        let tolerance = evaluation.setup.projection_tolerance;
        if !evaluation
            .project(exec, observer, gradient, tolerance)?
            .is_finite()
        {
            return Err(Stop::TooFast);
        }
        trajectory::add(exec, sum.shape, v, 0.0, 1.0, view(trial));
        for (place, placed) in sum.placed() {
            let own = out.get_mut(place.first..).unwrap_or_default();
            let each = &mut |which: usize, derivative: f64| {
                if let Some(out) = own.get_mut(which) {
                    *out = T::from_f64(derivative * place.slope(z, which));
                }
            };
            let amplitude = |interval| place.amplitude(z, interval);
            placed.adjoint(
                exec,
                &amplitude,
                evaluation.rho,
                view(gradient),
                evaluation.sums,
                each,
            );
        }
        Ok(())
    }
}

impl<T: Real, S: Space> Function<T, S> for Search<'_, '_, T> {
    fn direction(
        &mut self,
        exec: &dyn Exec,
        _observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop> {
        let shape = Shape {
            grid: &self.unknowns,
            slots: 1,
        };
        let slope = newton.descend(exec, shape, &mut self.fields);
        let largest = self.fields.get(newton.direction).map_or(0.0, |direction| {
            let sums = &mut *self.simulated.evaluation.sums;
            sums::max_abs(exec, shape.grid, shape.slots, view(direction), sums)
        });
        Ok(if largest.is_finite() { slope } else { f64::NAN })
    }

    fn move_along(&mut self, _: &dyn Exec, direction: usize, s: f64) {
        if let Some([direction, ..]) = self.fields.get(direction) {
            rows::add_scaled(self.z, T::from_f64(s), direction);
        }
    }

    fn retreat(&mut self, exec: &dyn Exec, keep: f64) {
        let evaluation = &self.simulated.evaluation;
        let Shape { grid, slots } = evaluation.shape();
        for place in places(evaluation.script.templates(), grid, slots) {
            place.weaken(self.z, keep);
        }
        evaluation.retreat(exec, &mut self.v, keep);
    }

    fn value(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        _work: usize,
        bound: f64,
    ) -> Result<Objective, Stop> {
        let z = core::mem::take(&mut self.z);
        let value = self.value_at::<S>(exec, observer, z, bound);
        self.z = z;
        value
    }

    fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        _work: usize,
        into: usize,
    ) -> Result<(), Stop> {
        let z = core::mem::take(&mut self.z);
        let mut field = self.fields.get_mut(into).map(core::mem::take).unwrap_or_default();
        let [out, ..] = &mut field;
        let done = self.gradient_at::<S>(exec, observer, z, out);
        if let Some(place) = self.fields.get_mut(into) {
            *place = field;
        }
        self.z = z;
        done
    }

    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let shape = Shape {
            grid: &self.unknowns,
            slots: 1,
        };
        let sums = &mut *self.simulated.evaluation.sums;
        if let (None, Some(gradient)) = (step, self.fields.get(borrowed.gradient)) {
            let largest = sums::max_abs(exec, shape.grid, shape.slots, view(gradient), sums);
            *self.scale = if largest > 0.0 { FIRST_STEP / largest } else { 1.0 };
        }
        let initial = Initial {
            line: None,
            scale: *self.scale,
            prepared: false,
        };
        newton.arrive(exec, shape, &mut self.fields, borrowed, step, &initial, sums);
    }
}

/// The flow that is tried, and the gradient by the force.
pub fn trajectories<'a, T: Real>(grid: &Grid, slots: usize, pool: &mut Pool<'a, T>) -> [VectorMut<'a, T>; 2] {
    ["flow that is tried", "gradient by the force"]
        .map(|name| pool.take_vector(name, grid.dims, grid.cells() * slots))
}
