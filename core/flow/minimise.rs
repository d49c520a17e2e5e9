//! The correction w of a level: the four ways to the minimum of f.
//!
//! ```text
//! A = F^T F + alpha L + beta I,   b = F^T phi_t + alpha L Din + beta Din
//! direct         Q A Q w = -Q b by conjugate gradients from 0, every residual projected
//! ADMM           x = (I + lambda A)^-1 (z - y - lambda b),  z = Q (x + y),  y = y + x - z;  the result is z
//! Horn-Schunck   (A + gamma D^T D) w = -(b + gamma D^T D Din) by conjugate gradients; gamma = 0 without a price
//! ```

use super::conjugate::{self, Fields, Goal};
use super::data::{self, Weights};
use super::params::{FlowParams, Minimiser};
use crate::exec::Exec;
use crate::field::trajectory::{Shape, add, dot};
use crate::field::{Vector, VectorMut, view};
use crate::grid::Grid;
use crate::grid::solids::Solids;
use crate::memory::Pool;
use crate::observe::Observer;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

/// How much divergence a projection leaves of what there was.
const LEFT: f64 = 1e-4;
/// Where a projection leaves less than this part of |b|, it is done again: what it leaves of divergence is rounding in parts of |b|.
const LITTLE: f64 = 1e-2;
/// Rounding errors of |b| below which nothing of Q b is known.
const ROUNDINGS: f64 = 16.0;

/// What is minimised, and with what.
pub(super) struct Objective<'o, 'a, T> {
    pub grid: &'a Grid,
    pub params: &'o FlowParams,
    pub projection: Option<&'o mut Projection<'a, T>>,
    /// The estimate Din.
    pub estimate: Vector<'o, T>,
    /// g.
    pub g: Vector<'o, T>,
    /// phi_t.
    pub change: &'o [T],
    /// A field of cells.
    pub cells: &'o mut [T],
    /// Rows for each thread.
    pub scratch: &'o mut [T],
}

/// The fields of a minimiser.
pub(super) struct Work<'a, T> {
    /// The result.
    pub w: VectorMut<'a, T>,
    pub r: VectorMut<'a, T>,
    q: VectorMut<'a, T>,
    pub image: VectorMut<'a, T>,
    /// x, y and the right-hand side of ADMM, else empty.
    more: [VectorMut<'a, T>; 3],
}

/// What a minimiser did.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    /// Products by A.
    pub products: usize,
    /// |grad f(0)|, projected where flows have no divergence.
    pub first: f64,
}

impl<'a, T: Real> Work<'a, T> {
    pub fn carve(grid: &Grid, params: &FlowParams, pool: &mut Pool<'a, T>) -> Self {
        let of_admm = if params.fields() > 4 { grid.cells() } else { 0 };
        let mut take = |name, len| pool.take_vector(name, grid.dims, len);
        Self {
            w: take("correction", grid.cells()),
            r: take("residual", grid.cells()),
            q: take("direction", grid.cells()),
            image: take("its image", grid.cells()),
            more: ["x", "multiplier", "right-hand side"].map(|name| take(name, of_admm)),
        }
    }
}

impl<T: Real> Objective<'_, '_, T> {
    fn shape(&self) -> Shape<'_> {
        Shape {
            grid: self.grid,
            slots: 1,
        }
    }

    /// Q, where flows have no divergence.
    pub fn project(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        field: &mut VectorMut<'_, T>,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        match &mut self.projection {
            None => Stop::heard(observer),
            Some(projection) => {
                let done = projection.project(exec, observer, field, None, LEFT, sums);
                if done.is_break() {
                    Err(Stop::Cancelled)
                } else {
                    Ok(())
                }
            }
        }
    }

    /// `out` = kinetic w + scale (F^T F + alpha L) w, and with `priced` + gamma D^T D w.
    fn apply(
        &mut self,
        exec: &dyn Exec,
        (scale, kinetic): (f64, f64),
        priced: bool,
        w: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
    ) {
        data::apply(exec, self.grid, self.g, w, self.cells);
        let weights = Weights {
            data: scale,
            smooth: scale * self.params.alpha,
            kinetic,
        };
        data::combine(
            exec,
            self.grid,
            weights,
            (self.g, &*self.cells),
            w,
            out,
            self.scratch,
        );
        if priced {
            self.add_price(exec, w, out);
        }
    }

    /// `out += gamma D^T D w`, if divergence has a price.
    pub fn add_price(&mut self, exec: &dyn Exec, w: Vector<'_, T>, out: &mut VectorMut<'_, T>) {
        if self.params.gamma > 0.0 && !self.params.is_hard() {
            let work = (&mut *self.cells, &mut *self.scratch);
            data::add_divergence_price(
                exec,
                self.grid,
                Solids::default(),
                self.params.gamma,
                w,
                out,
                work,
            );
        }
    }

    /// `out` = scale b.
    fn gradient_at_zero(&mut self, exec: &dyn Exec, scale: f64, out: &mut VectorMut<'_, T>) {
        let weights = Weights {
            data: scale,
            smooth: scale * self.params.alpha,
            kinetic: scale * self.params.beta,
        };
        data::combine(
            exec,
            self.grid,
            weights,
            (self.g, self.change),
            self.estimate,
            out,
            self.scratch,
        );
    }

    /// Leaves w in `work`.
    pub fn minimise(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: &mut Work<'_, T>,
        sums: &mut [f64],
    ) -> Result<Effort, Stop> {
        work.w.iter_mut().for_each(|component| component.fill(T::ZERO));
        match self.params.minimiser {
            Minimiser::Admm => self.alternate(exec, observer, work, sums),
            Minimiser::Direct | Minimiser::HornSchunck => self.descend(exec, observer, work, sums),
        }
    }

    fn goal(&self, size: f64) -> Goal {
        Goal {
            tolerance: self.params.cg_tolerance,
            steps: self.params.cg_iterations,
            size,
            least: 0.0,
        }
    }

    /// The direct way and those of Horn & Schunck.
    fn descend(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: &mut Work<'_, T>,
        sums: &mut [f64],
    ) -> Result<Effort, Stop> {
        let Work { w, r, q, image, .. } = work;
        self.gradient_at_zero(exec, -1.0, r);
        if !self.params.is_hard() {
            let estimate = self.estimate;
            image.iter_mut().for_each(|component| component.fill(T::ZERO));
            self.add_price(exec, estimate, image);
            add(exec, self.shape(), r, 1.0, -1.0, view(image));
        }
        let whole = dot(exec, self.shape(), view(r), view(r), sums);
        self.project(exec, observer, r, sums)?;
        let mut size = dot(exec, self.shape(), view(r), view(r), sums);
        let hard = self.projection.is_some();
        if hard && size < LITTLE * LITTLE * whole {
            // A divergence that conjugate gradients do not see in A has no curvature, and steps along it no end.
            self.project(exec, observer, r, sums)?;
            size = dot(exec, self.shape(), view(r), view(r), sums);
        }
        let rounding = if hard { ROUNDINGS * T::EPSILON } else { 0.0 };
        let goal = Goal {
            least: rounding * rounding * whole,
            ..self.goal(size)
        };
        let (grid, beta) = (self.grid, self.params.beta);
        let fields = Fields { x: w, r, q, image };
        let products = conjugate::solve(exec, grid, fields, goal, sums, &mut |q, image, sums| {
            self.apply(exec, (1.0, beta), true, q, image);
            self.project(exec, observer, image, sums)
        })?;
        Ok(Effort {
            products,
            first: libm::sqrt(size),
        })
    }

    /// ADMM.
    fn alternate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: &mut Work<'_, T>,
        sums: &mut [f64],
    ) -> Result<Effort, Stop> {
        let Work {
            w: z,
            r,
            q,
            image,
            more: [x, y, right],
        } = work;
        let (grid, lambda) = (self.grid, self.params.lambda);
        let shape = Shape { grid, slots: 1 };
        let law = (lambda, 1.0 + lambda * self.params.beta);
        let mut effort = Effort::default();
        self.gradient_at_zero(exec, 1.0, r);
        self.project(exec, observer, r, sums)?;
        effort.first = libm::sqrt(dot(exec, shape, view(r), view(r), sums));
        [&mut *x, &mut *y]
            .into_iter()
            .flatten()
            .for_each(|component| component.fill(T::ZERO));
        for _ in 0..self.params.iterations {
            self.gradient_at_zero(exec, -lambda, right);
            add(exec, shape, right, 1.0, 1.0, view(z));
            add(exec, shape, right, 1.0, -1.0, view(y));
            let size = dot(exec, shape, view(right), view(right), sums);
            self.apply(exec, law, false, view(x), r);
            add(exec, shape, r, -1.0, 1.0, view(right));
            let fields = Fields { x, r, q, image };
            let goal = self.goal(size);
            effort.products += conjugate::solve(exec, grid, fields, goal, sums, &mut |q, image, _| {
                self.apply(exec, law, false, q, image);
                Stop::heard(observer)
            })?;
            // y takes x + y, and what the projection takes off it is the new y; r remembers the old z.
            add(exec, shape, y, 1.0, 1.0, view(x));
            add(exec, shape, r, 0.0, 1.0, view(z));
            add(exec, shape, z, 0.0, 1.0, view(y));
            self.project(exec, observer, z, sums)?;
            add(exec, shape, y, 1.0, -1.0, view(z));
            if self.is_settled(exec, [view(x), view(z)], r, sums) {
                break;
            }
        }
        Ok(effort)
    }

    /// Whether |x - z| and |z - before| are below the tolerance's part of |z|; `before` is lost.
    fn is_settled(
        &self,
        exec: &dyn Exec,
        [x, z]: [Vector<'_, T>; 2],
        before: &mut VectorMut<'_, T>,
        sums: &mut [f64],
    ) -> bool {
        if !(self.params.tolerance > 0.0) {
            return false;
        }
        let shape = self.shape();
        let enough = self.params.tolerance * self.params.tolerance * dot(exec, shape, z, z, sums);
        add(exec, shape, before, 1.0, -1.0, z);
        let moved = dot(exec, shape, view(before), view(before), sums);
        add(exec, shape, before, 0.0, 1.0, x);
        add(exec, shape, before, 1.0, -1.0, z);
        let apart = dot(exec, shape, view(before), view(before), sums);
        moved < enough && apart < enough
    }
}
