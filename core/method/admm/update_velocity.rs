//! The second half of an iteration: NSO with targets t = v* - lambda/K.

use super::Admm;
use super::report::Course;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{VectorMut, reborrow, rows, sums, view};
use crate::force;
use crate::force::time_line::{TimeLine, drag};
use crate::grid::Space;
use crate::memory::Pool;
use crate::method::animation::Animation;
use crate::nso::level::State;
use crate::nso::{Ended, Finest, Info, NSO, Nso, NsoSolver, Workspace, newton};
use crate::observe::{Event, Observer};
use crate::poisson::Projection;
use crate::progress::Status;
use crate::real::Real;

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// v, w, p, pbar by NSO.
    pub(super) fn update_velocity(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        course: &mut Course,
    ) -> Result<(), Status> {
        if observer.on(Event::PhaseBegin(NSO)).is_break() {
            return Err(Status::Cancelled);
        }
        let kappa = self.setup.ao.penalty / self.setup.ao.flow.force_weight;
        self.predict(exec, kappa);
        self.consistent_force(exec, observer)?;
        let info = match self.setup.params.nso.solver {
            NsoSolver::Stfas => self.by_stfas(exec, observer),
            NsoSolver::NewtonCg => self.by_newton(exec, observer),
        };
        self.history.damped = info.damped;
        course.nso_residuals = info.residuals;
        if observer.on(Event::PhaseEnd(NSO)).is_break() {
            return Err(Status::Cancelled);
        }
        match info.ended {
            Ended::Cancelled => Err(Status::Cancelled),
            Ended::NotFinite => Err(Status::NotFinite),
            Ended::Converged | Ended::Cycles => Ok(()),
        }
    }

    fn by_stfas(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Info {
        let setup = self.setup.nso();
        let spare = if self.spare[0].is_empty() {
            &mut self.multiplier
        } else {
            &mut self.spare
        };
        let Animation {
            levels,
            v,
            rho,
            initial,
            sums,
            ..
        } = &mut self.animation;
        let mut pool = Pool::new(&mut *self.region);
        let lift = self.setup.ao.flow.lift(levels);
        let mut lifted = lift.take(&mut pool);
        lifted.iter_mut().for_each(|component| component.fill(T::ZERO));
        lift.add(exec, 1.0, rho, 0..lift.slots, &mut lifted);
        let finest = Finest {
            state: State {
                v: reborrow(v),
                w: reborrow(&mut self.w),
                p: self.p,
                pbar: self.pbar,
            },
            v0: reborrow(initial),
            target: reborrow(&mut self.target),
            lift: lifted,
            spare: reborrow(spare),
        };
        let workspace = Workspace::carve(levels, &self.bases, &setup, &mut pool);
        Nso::<T, S>::new(levels, &self.bases, finest, &setup, workspace, sums).solve(exec, observer)
    }

    fn by_newton(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Info {
        let setup = self.setup.nso();
        let problem = newton::Problem {
            v: reborrow(&mut self.animation.v),
            w: reborrow(&mut self.w),
            v0: view(&self.animation.initial),
            target: view(&self.target),
            lift: self.setup.ao.flow.lift(&self.animation.levels),
            rho: self.animation.rho,
        };
        newton::solve::<T, S>(
            exec,
            observer,
            &self.animation.levels,
            &setup,
            problem,
            Pool::new(&mut *self.region),
            self.animation.sums,
        )
    }

    /// t = v* - lambda/K in place of v*, and v moved to where the new targets would take it if the flow were at rest.
    ///
    /// A change d = v* - v of the targets changes equation a by kappa d, free of divergence. Without self-advection v answers
    /// with (kappa + S)^-1 kappa d (see [`TimeLine`]). Smoothing from there need not trade momentum for divergence.
    fn predict(&mut self, exec: &dyn Exec, kappa: f64) {
        let (grid, slots) = (&self.animation.levels.finest, self.slots());
        let nx = grid.n[0];
        let drag = drag(grid, self.setup.ao.flow.viscosity);
        let line = TimeLine::new(kappa, drag, &mut self.animation.sums[..slots]);
        let first = self.iteration == 1;
        let kappa = T::from_f64(kappa);
        for axis in 0..S::DIM {
            let fields = [
                &mut *self.animation.v[axis],
                &mut *self.w[axis],
                &mut *self.target[axis],
            ];
            let multiplier = &*self.multiplier[axis];
            for_rows(exec, grid.rows(), RowBuffers::fields(fields), |task| {
                let [v, work, target] = task.fields;
                if first {
                    v.copy_from_slice(target);
                } else {
                    rows::scale(work, T::ONE, target);
                    rows::sub(work, v);
                    rows::scale_in_place(work, kappa);
                    line.solve(work, nx);
                    rows::add(v, work);
                }
                rows::sub(target, sums::row(grid, slots, multiplier, task.row));
            });
        }
    }

    /// w = P[v_k - v_{k-1} + Adv(v_k) + nu C^T C v_k - B rho_k] with its pressure, so that equations b, c and d hold before the first cycle.
    pub(crate) fn consistent_force(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
    ) -> Result<(), Status> {
        let (grid, slots, threads) = (&self.animation.levels.finest, self.slots(), self.threads());
        let scratch = &mut self.region[..threads * force::scratch_per_thread(grid, slots)];
        let (fluid, lift) = (
            self.setup.ao.flow.fluid(&self.animation.levels),
            self.setup.ao.flow.lift(&self.animation.levels),
        );
        force::from_velocity::<T, S>(
            exec,
            fluid,
            view(&self.animation.v),
            view(&self.animation.initial),
            self.p,
            reborrow(&mut self.w),
            scratch,
        );
        lift.add(exec, -1.0, self.animation.rho, 0..slots, &mut self.w);
        let mut projection = Projection::carve(
            &self.animation.levels,
            0,
            slots,
            threads,
            &mut Pool::new(&mut *self.region),
        );
        let w: &mut VectorMut<'_, T> = &mut self.w;
        let projected = projection.project(
            exec,
            observer,
            w,
            Some(self.p),
            self.setup.ao.flow.projection_tolerance,
            self.animation.sums,
        );
        if projected.is_break() {
            Err(Status::Cancelled)
        } else {
            Ok(())
        }
    }
}
