//! NSO without a multigrid in time: Newton's method on the flow alone, its systems by conjugate gradients.
//!
//! ```text
//! phi(v) = kappa/2 sum |v_k - t_k|^2 + 1/2 sum |w_k(v)|^2        over div v_k = 0, w_k = P[v_k - v_{k-1} + Adv(v_k)]
//! g_k    = kappa (v_k - t_k) + Q[w_k - w_{k+1} + J(v_k)^T w_k]
//! H d    = kappa d + Q[D^T P D d + J(d)^T w],  D d = d_k - d_{k-1} + J(v_k) d_k
//! ```
//!
//! preconditioned by (kappa + S)^-1, exact in time for a flow at rest (mathematics section 6). Systems are solved inexactly,
//! and left where the curvature is not positive (Nocedal & Wright, algorithm 7.1, Newton-CG with a line search).

use super::solve::{Ended, Info};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::force;
use crate::force::time_line::{TimeLine, drag};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Ledger, Pool, Sharing, pooled};
use crate::observe::{Event, Observer};
use crate::operators::self_advection::Fluid;
use crate::poisson::Projection;
use crate::real::Real;

/// Vector fields of work: step, residual of the system, direction, its image, work.
const FIELDS: usize = 5;
/// Conjugate gradients for one system at most.
const INNER: usize = 30;
/// A system is solved until its residual is at most this part of the gradient.
const INEXACT: f64 = 0.1;
/// Part of the decrease that the slope promises, which a step must keep (Armijo).
const ENOUGH: f64 = 1e-4;
/// Halvings of the step at most.
const HALVINGS: usize = 20;

/// What does not change from call to call.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// K / r in scaled numbers.
    pub kappa: f64,
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// Slots T.
    pub slots: usize,
    /// Threads that scratch was planned for.
    pub threads: usize,
    /// Stop at max |g| below this.
    pub tolerance: f64,
    /// Newton steps at most.
    pub steps: usize,
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
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
}

/// Writes the ledger lines of a call's work in the shared pool.
pub fn requirement<T: Real>(ledger: &mut Ledger, grid: &Grid, slots: usize, threads: usize) {
    ledger.group(
        "Navier-Stokes problem (NSO) by Newton's method",
        Sharing::Together,
        |ledger| {
            ledger.line(
                "step, residual, direction, image, work",
                FIELDS * grid.dims * pooled(grid.cells() * slots),
                T::BYTES,
            );
            ledger.group("projection or force", Sharing::InTurn, |ledger| {
                Projection::<T>::requirement(ledger, grid, slots, threads);
                ledger.line(
                    "force: rows of a block",
                    threads * force::scratch_per_thread(grid, slots),
                    T::BYTES,
                );
            });
        },
    );
}

/// Iterates from `problem.v` to the tolerance. `sums` holds two numbers a row and one a slot.
pub fn solve<T: Real, S: Space>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    levels: &Levels<'_, T>,
    setup: &Setup,
    problem: Problem<'_, T>,
    mut pool: Pool<'_, T>,
    sums: &mut [f64],
) -> Info {
    let mut info = Info {
        ended: Ended::Cycles,
        residuals: heapless::Vec::new(),
        damped: false,
    };
    let (pivots, sums) = sums.split_at_mut(setup.slots);
    let grid = &levels.finest;
    let mut take = || pool.take_vector(S::DIM, grid.cells() * setup.slots);
    let (step, residual, direction, image, work) = (take(), take(), take(), take(), take());
    let region = pool.into_rest();
    let line = TimeLine::new(setup.kappa, drag(grid, setup.viscosity), pivots);
    let mut newton = Newton {
        levels,
        setup,
        problem,
        step,
        residual,
        direction,
        image,
        work,
        region,
        sums,
        line,
    };
    for count in 0..=setup.steps {
        let (Some(gradient), phi) = (
            newton.gradient::<S>(exec, observer),
            newton.phi(exec, Force::Accepted),
        ) else {
            info.ended = Ended::Cancelled;
            return info;
        };
        let _ = info.residuals.push(gradient);
        if !gradient.is_finite() {
            info.ended = Ended::NotFinite;
            return info;
        }
        if count > 0
            && observer
                .on(Event::NsoCycle {
                    cycle: count,
                    residual: gradient,
                })
                .is_break()
        {
            info.ended = Ended::Cancelled;
            return info;
        }
        if gradient < setup.tolerance {
            info.ended = Ended::Converged;
            return info;
        }
        if count == setup.steps {
            return info;
        }
        match newton
            .conjugate_gradients::<S>(exec, observer)
            .and_then(|slope| newton.search::<S>(exec, observer, phi, slope))
        {
            Some(true) => {}
            Some(false) => return info,
            None => {
                info.ended = Ended::Cancelled;
                return info;
            }
        }
    }
    info
}

/// The state of a call.
struct Newton<'a, 'm, T> {
    levels: &'a Levels<'m, T>,
    setup: &'a Setup,
    problem: Problem<'a, T>,
    step: VectorMut<'a, T>,
    /// Minus the gradient, then what the system leaves of it.
    residual: VectorMut<'a, T>,
    direction: VectorMut<'a, T>,
    image: VectorMut<'a, T>,
    work: VectorMut<'a, T>,
    region: &'a mut [T],
    sums: &'a mut [f64],
    line: TimeLine<'a>,
}

fn shape<'a, T>(levels: &'a Levels<'_, T>, setup: &Setup) -> Shape<'a> {
    Shape {
        grid: &levels.finest,
        slots: setup.slots,
    }
}

/// Where the force of v is.
#[derive(Clone, Copy)]
enum Force {
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

impl<'a, T: Real> Newton<'a, '_, T> {
    fn fluid(&self) -> Fluid<'a> {
        Fluid {
            grid: &self.levels.finest,
            slots: self.setup.slots,
            viscosity: self.setup.viscosity,
        }
    }

    /// residual = -g; max |g|, or `None` when it was stopped.
    fn gradient<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<f64> {
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
        let (v, target, kappa) = (
            view(&self.problem.v),
            self.problem.target,
            T::from_f64(self.setup.kappa),
        );
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(reborrow(&mut self.residual)),
            |task| {
                for (axis, out) in task.fields.into_iter().enumerate().take(S::DIM) {
                    let (v, t) = (
                        sums::row(grid, slots, v[axis], task.row),
                        sums::row(grid, slots, target[axis], task.row),
                    );
                    rows::add_difference(out, kappa, v, t);
                    rows::scale_in_place(out, -T::ONE);
                }
            },
        );
        Some(sums::max_abs(exec, grid, slots, view(&self.residual), self.sums))
    }

    /// phi(v).
    fn phi(&mut self, exec: &dyn Exec, force: Force) -> f64 {
        let (grid, slots) = (&self.levels.finest, self.setup.slots);
        let (v, target) = (view(&self.problem.v), self.problem.target);
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
            .project(
                exec,
                observer,
                slots,
                field,
                None,
                projection_tolerance,
                self.sums,
            )
            .is_continue()
            .then_some(())
    }

    /// image = H direction.
    fn apply<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<()> {
        let (grid, slots) = (&self.levels.finest, self.setup.slots);
        let Problem { v, .. } = &self.problem;
        force::apply_derivative::<T, S>(
            exec,
            self.fluid(),
            view(v),
            view(&self.direction),
            reborrow(&mut self.work),
            self.region,
        );
        self.project(exec, observer, Output::Work)?;
        let Problem { v, .. } = &self.problem;
        force::apply_adjoint::<T, S>(
            exec,
            self.fluid(),
            view(v),
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
        self.project(exec, observer, Output::Image)?;
        trajectory::add(
            exec,
            Shape { grid, slots },
            &mut self.image,
            1.0,
            self.setup.kappa,
            view(&self.direction),
        );
        Some(())
    }

    /// work = (kappa + S)^-1 residual; <residual, work>.
    fn precondition(&mut self, exec: &dyn Exec) -> f64 {
        let shape = shape(self.levels, self.setup);
        trajectory::add(exec, shape, &mut self.work, 0.0, 1.0, view(&self.residual));
        let (grid, line) = (shape.grid, self.line);
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

    /// step = about -H^-1 g; <g, step>.
    fn conjugate_gradients<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<f64> {
        let mut left = self.precondition(exec);
        let enough = INEXACT * INEXACT * left;
        let mut slope = 0.0;
        let shape = shape(self.levels, self.setup);
        trajectory::add(exec, shape, &mut self.direction, 0.0, 1.0, view(&self.work));
        trajectory::add(exec, shape, &mut self.step, 0.0, 0.0, view(&self.work));
        for inner in 0..INNER {
            self.apply::<S>(exec, observer)?;
            let curvature = trajectory::dot(exec, shape, view(&self.direction), view(&self.image), self.sums);
            let negative = !(curvature > 0.0);
            if negative && inner > 0 {
                break;
            }
            // The first direction is that of steepest descent: where it curves down, it is the step.
            let length = if negative { 1.0 } else { left / curvature };
            trajectory::add(exec, shape, &mut self.step, 1.0, length, view(&self.direction));
            slope -= length * left;
            if negative {
                break;
            }
            trajectory::add(exec, shape, &mut self.residual, 1.0, -length, view(&self.image));
            let next = self.precondition(exec);
            if next <= enough {
                break;
            }
            trajectory::add(
                exec,
                shape,
                &mut self.direction,
                next / left,
                1.0,
                view(&self.work),
            );
            left = next;
        }
        Some(slope)
    }

    /// Moves v along the step by the first of 1, 1/2, 1/4, .. with which phi falls enough, w with it; false, with v where it was, if
    /// there is none.
    fn search<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        before: f64,
        slope: f64,
    ) -> Option<bool> {
        let (mut length, mut moved) = (1.0, 0.0);
        for _ in 0..HALVINGS {
            self.move_along(exec, length - moved);
            moved = length;
            self.force::<S>(exec, observer)?;
            if self.phi(exec, Force::OfTrial) <= before + ENOUGH * length * slope {
                let shape = shape(self.levels, self.setup);
                trajectory::add(exec, shape, &mut self.problem.w, 0.0, 1.0, view(&self.work));
                return Some(true);
            }
            length *= 0.5;
        }
        self.move_along(exec, -moved);
        Some(false)
    }

    /// v += `s` step.
    fn move_along(&mut self, exec: &dyn Exec, s: f64) {
        let shape = shape(self.levels, self.setup);
        trajectory::add(exec, shape, &mut self.problem.v, 1.0, s, view(&self.step));
    }

    /// work = the force of v.
    fn force<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<()> {
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
        self.project(exec, observer, Output::Work)
    }
}
