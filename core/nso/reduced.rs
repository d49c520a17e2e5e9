//! NSO as a problem of the flow alone: its objective, gradient and Hessian over flows that are free of
//! divergence.
//!
//! ```text
//! phi(v) = kappa/2 sum |v_k - t_k|^2 + 1/2 sum |w_k(v)|^2
//!          over div v_k = 0, w_k = P[v_k - v_{k-1} + Adv(v_k) - B rho_k]
//! g_k    = kappa (v_k - t_k) + Q[w_k - w_{k+1} + J(v_k)^T w_k]
//! H d    = kappa d + Q[D^T P D d + J(d)^T w],  D d = d_k - d_{k-1} + J(v_k) d_k
//! ```

use super::params::Setup;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::force;
use crate::force::lift::Lift;
use crate::force::time_line::{TimeLine, drag};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::Pool;
use crate::observe::Observer;
use crate::operators::self_advection::Fluid;
use crate::poisson::Projection;
use crate::real::Real;

/// Takes the vector fields of a solve: step, residual of the system, direction, its image, work.
pub(super) fn take_fields<'a, T: Real>(
    grid: &Grid,
    slots: usize,
    pool: &mut Pool<'a, T>,
) -> [VectorMut<'a, T>; 5] {
    pool.line("step, residual, direction, image, work", |pool| {
        [(); 5].map(|()| pool.take_vector("trajectory", grid.dims, grid.cells() * slots))
    })
}

/// The fields of a call.
#[derive(Debug)]
pub struct Problem<'a, T> {
    /// v, free of divergence.
    pub v: VectorMut<'a, T>,
    /// The force of v.
    pub w: VectorMut<'a, T>,
    /// v_0.
    pub v0: Vector<'a, T>,
    /// The targets t_k.
    pub target: Vector<'a, T>,
    /// Buoyancy, by the densities rho_0 .. rho_N.
    pub lift: Lift<'a>,
    /// These densities.
    pub rho: &'a [T],
}

/// The problem at a flow v, with the fields of its solver.
pub(super) struct Reduced<'a, 'm, T> {
    levels: &'a Levels<'m, T>,
    setup: &'a Setup,
    pub(super) problem: Problem<'a, T>,
    pub(super) step: VectorMut<'a, T>,
    /// Minus the gradient, then what the system leaves of it.
    pub(super) residual: VectorMut<'a, T>,
    pub(super) direction: VectorMut<'a, T>,
    pub(super) image: VectorMut<'a, T>,
    pub(super) work: VectorMut<'a, T>,
    region: &'a mut [T],
    pub(super) sums: &'a mut [f64],
    line: TimeLine<'a>,
}

/// Where the force of v is.
#[derive(Clone, Copy)]
pub(super) enum Force {
    Accepted,
    OfTrial,
}

/// Which field an operation overwrites.
#[derive(Clone, Copy)]
enum Output {
    Residual,
    Image,
    Work,
}

impl<'a, 'm, T: Real> Reduced<'a, 'm, T> {
    /// Takes its fields from `pool`. `sums` holds two values a row and one a slot.
    pub(super) fn new(
        levels: &'a Levels<'m, T>,
        setup: &'a Setup,
        problem: Problem<'a, T>,
        mut pool: Pool<'a, T>,
        sums: &'a mut [f64],
    ) -> Self {
        let grid = &levels.finest;
        let (pivots, sums) = sums.split_at_mut(setup.slots);
        let [step, residual, direction, image, work] = take_fields(grid, setup.slots, &mut pool);
        Self {
            levels,
            setup,
            problem,
            step,
            residual,
            direction,
            image,
            work,
            region: pool.into_rest(),
            sums,
            line: TimeLine::new(setup.kappa, drag(grid, setup.viscosity), pivots),
        }
    }

    /// Grid and slots of all fields.
    pub(super) fn shape(&self) -> Shape<'a> {
        Shape {
            grid: &self.levels.finest,
            slots: self.setup.slots,
        }
    }

    fn fluid(&self) -> Fluid<'a> {
        Fluid {
            grid: &self.levels.finest,
            slots: self.setup.slots,
            viscosity: self.setup.viscosity,
            solids: self.levels.solids(0),
        }
    }

    /// residual = -g; max |g|, or `None` when it was stopped.
    pub(super) fn gradient<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<f64> {
        let (grid, slots) = (&self.levels.finest, self.setup.slots);
        let Problem { v, w, .. } = &self.problem;
        force::apply_adjoint::<T, S>(
            exec,
            self.fluid(),
            view(v),
            view(w),
            reborrow(&mut self.residual),
            self.region,
        );
        self.project(exec, observer, Output::Residual)?;
        let (v, target) = (view(&self.problem.v), self.problem.target);
        let kappa = T::from_f64(self.setup.kappa);
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(reborrow(&mut self.residual)),
            |task| {
                for (axis, out) in task.fields.into_iter().enumerate().take(S::DIM) {
                    let v = sums::row(grid, slots, v[axis], task.row);
                    let target = sums::row(grid, slots, target[axis], task.row);
                    rows::add_difference(out, kappa, v, target);
                    rows::scale_in_place(out, -T::ONE);
                }
            },
        );
        Some(sums::max_abs(exec, grid, slots, view(&self.residual), self.sums))
    }

    /// phi(v).
    pub(super) fn phi(&mut self, exec: &dyn Exec, force: Force) -> f64 {
        let (grid, slots) = (&self.levels.finest, self.setup.slots);
        let v = view(&self.problem.v);
        let target = self.problem.target;
        let off = sums::total(exec, grid, self.sums, |row| {
            (0..grid.dims)
                .map(|a| {
                    rows::sum_square_gaps(
                        sums::row(grid, slots, v[a], row),
                        sums::row(grid, slots, target[a], row),
                    )
                })
                .sum()
        });
        let w = match force {
            Force::Accepted => view(&self.problem.w),
            Force::OfTrial => view(&self.work),
        };
        0.5 * (self.setup.kappa * off + sums::sum_squares(exec, grid, slots, w, self.sums))
    }

    /// Projects a field; `None` when it was stopped.
    fn project(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, into: Output) -> Option<()> {
        let Setup {
            slots,
            threads,
            projection_tolerance,
            ..
        } = *self.setup;
        let field = match into {
            Output::Residual => &mut self.residual,
            Output::Image => &mut self.image,
            Output::Work => &mut self.work,
        };
        let mut projection =
            Projection::carve(self.levels, 0, slots, threads, &mut Pool::new(&mut *self.region));
        projection
            .project(exec, observer, field, None, projection_tolerance, self.sums)
            .is_continue()
            .then_some(())
    }

    /// image = H direction.
    pub(super) fn apply<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<()> {
        force::apply_derivative::<T, S>(
            exec,
            self.fluid(),
            view(&self.problem.v),
            view(&self.direction),
            reborrow(&mut self.work),
            self.region,
        );
        self.project(exec, observer, Output::Work)?;
        self.apply_transposed::<S>(exec);
        self.project(exec, observer, Output::Image)?;
        let shape = self.shape();
        let kappa = self.setup.kappa;
        trajectory::add(exec, shape, &mut self.image, 1.0, kappa, view(&self.direction));
        Some(())
    }

    /// image = D^T work + J(direction)^T w.
    fn apply_transposed<S: Space>(&mut self, exec: &dyn Exec) {
        force::apply_adjoint::<T, S>(
            exec,
            self.fluid(),
            view(&self.problem.v),
            view(&self.work),
            reborrow(&mut self.image),
            self.region,
        );
        force::add_curvature::<T, S>(
            exec,
            self.fluid(),
            view(&self.direction),
            view(&self.problem.w),
            reborrow(&mut self.image),
            self.region,
        );
    }

    /// work = (kappa + S)^-1 residual; <residual, work>.
    pub(super) fn precondition(&mut self, exec: &dyn Exec) -> f64 {
        let shape = self.shape();
        trajectory::add(exec, shape, &mut self.work, 0.0, 1.0, view(&self.residual));
        let grid = shape.grid;
        let line = self.line;
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(reborrow(&mut self.work)),
            |task| {
                task.fields
                    .into_iter()
                    .take(grid.dims)
                    .for_each(|out| line.solve(out, grid.n[0]));
            },
        );
        trajectory::dot(exec, shape, view(&self.residual), view(&self.work), self.sums)
    }

    /// work = the force of v.
    pub(super) fn force<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<()> {
        let Problem { v, v0, .. } = &self.problem;
        force::from_velocity::<T, S>(
            exec,
            self.fluid(),
            view(v),
            *v0,
            &[],
            reborrow(&mut self.work),
            self.region,
        );
        let Problem { lift, rho, .. } = self.problem;
        lift.add(exec, -1.0, rho, 0..lift.slots, &mut self.work);
        self.project(exec, observer, Output::Work)
    }
}
