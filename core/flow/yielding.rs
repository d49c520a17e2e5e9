//! A flow among solid cells whose change is small where the flow matters, and smooth (Gregson 2015, eq. 5.21, Algorithm 5; mathematics section 11).
//!
//! ```text
//! Delta = argmin 1/2 |W Delta|^2 + alpha/2 <Delta, L Delta>    over div (v + Delta) = 0, v + Delta = 0 at closed faces
//! x <- (1 + lambda (W^2 + alpha L))^-1 (z - y)     z <- Q (v + x + y) - v     y <- y + x - z
//! ```
//!
//! L = C^T C + D^T D in cells, C without the plaquettes at closed faces, D in fluid cells, where it finds nothing at the end. So alpha weighs the
//! vorticity of the change: a large one leads to the plain projection. For alpha = 0 see [`Projection::project_weighted`].

use super::conjugate::{self, Fields, Goal};
use super::data::add_divergence_price;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows::part;
use crate::field::trajectory::{Shape, add, dot};
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::grid::levels::Levels;
use crate::grid::solids::Solids;
use crate::grid::{D2, D3, Grid, Side, Space};
use crate::memory::{Pool, Sharing};
use crate::observe::Observer;
use crate::operators::drag::combine;
use crate::operators::self_advection::{Fluid, scratch_per_thread};
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

/// lambda: 1 and 100 take five times as many iterations.
const PENALTY: f64 = 10.0;
/// Of the conjugate gradients, in parts of the right-hand side.
const LEFT: f64 = 1e-4;
/// Steps of them at most.
const STEPS: usize = 1000;

/// How a flow gives way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yielding {
    /// alpha: how dear the vorticity of the change is, at least 0.
    pub smoothness: f64,
    /// It ends when x and z are no farther apart than this part of z.
    pub tolerance: f64,
    /// Iterations at most.
    pub iterations: usize,
}

impl Default for Yielding {
    fn default() -> Self {
        Self {
            smoothness: 0.0,
            tolerance: 1e-3,
            iterations: 100,
        }
    }
}

/// The workspace.
pub struct Work<'a, T> {
    grid: &'a Grid,
    solids: Solids<'a>,
    projection: Projection<'a, T>,
    x: VectorMut<'a, T>,
    y: VectorMut<'a, T>,
    z: VectorMut<'a, T>,
    r: VectorMut<'a, T>,
    q: VectorMut<'a, T>,
    image: VectorMut<'a, T>,
    cells: &'a mut [T],
    scratch: &'a mut [T],
}

impl<'a, T: Real> Work<'a, T> {
    /// Takes it from a pool, for the finest grid.
    pub fn carve(levels: &'a Levels<'_, T>, threads: usize, pool: &mut Pool<'a, T>) -> Self {
        let grid = &levels.finest;
        pool.group("giving way", Sharing::Together, |pool| {
            let projection = Projection::carve(levels, 0, 1, threads, pool);
            let mut take = |name| pool.take_vector(name, grid.dims, grid.cells());
            let [x, y, z, r, q, image] =
                ["x", "multiplier", "change", "residual", "direction", "its image"].map(&mut take);
            Self {
                grid,
                solids: levels.solids(0),
                projection,
                x,
                y,
                z,
                r,
                q,
                image,
                cells: pool.take("divergence", grid.cells()),
                scratch: pool.take("rows", threads * scratch_per_thread(grid, 1)),
            }
        })
    }

    /// v becomes v + Delta, by an `importance` of cells; how many iterations it took. `tolerance` is that of the projection.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn apply(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: &mut VectorMut<'_, T>,
        (importance, how): (&[T], Yielding),
        (tolerance, sums): (f64, &mut [f64]),
    ) -> Result<usize, Stop> {
        let Self {
            grid,
            solids,
            projection,
            x,
            y,
            z,
            r,
            q,
            image,
            cells,
            scratch,
        } = self;
        let (grid, shape) = (*grid, Shape { grid, slots: 1 });
        let law = Law {
            grid,
            solids: *solids,
            importance,
            smoothness: how.smoothness,
        };
        for field in [&mut *x, &mut *y, &mut *z].into_iter().flatten() {
            field.fill(T::ZERO);
        }
        for iteration in 1..=how.iterations {
            add(exec, shape, r, 0.0, 1.0, view(z));
            add(exec, shape, r, 1.0, -1.0, view(y));
            let size = dot(exec, shape, view(r), view(r), sums);
            law.apply(exec, view(x), image, (cells, scratch));
            add(exec, shape, r, 1.0, -1.0, view(image));
            let goal = Goal {
                tolerance: LEFT.min(0.1 * how.tolerance),
                steps: STEPS,
                size,
                least: 0.0,
            };
            let fields = Fields {
                x: &mut *x,
                r: &mut *r,
                q: &mut *q,
                image: &mut *image,
            };
            conjugate::solve(exec, grid, fields, goal, sums, &mut |q, image, _| {
                law.apply(exec, q, image, (cells, scratch));
                Stop::heard(observer)
            })?;
            // y holds x + y until z is known.
            add(exec, shape, y, 1.0, 1.0, view(x));
            add(exec, shape, z, 0.0, 1.0, view(y));
            add(exec, shape, z, 1.0, 1.0, view(v));
            let projected = projection.project(exec, observer, z, None, tolerance, sums);
            if projected.is_break() {
                return Err(Stop::Cancelled);
            }
            add(exec, shape, z, 1.0, -1.0, view(v));
            add(exec, shape, y, 1.0, -1.0, view(z));
            add(exec, shape, r, 0.0, 1.0, view(x));
            add(exec, shape, r, 1.0, -1.0, view(z));
            let [apart, size] = [&*r, &*z].map(|field| dot(exec, shape, view(field), view(field), sums));
            if iteration == how.iterations || apart <= how.tolerance * how.tolerance * size {
                add(exec, shape, v, 1.0, 1.0, view(z));
                return Ok(iteration);
            }
        }
        Ok(0)
    }
}

/// 1 + lambda (W^2 + alpha L).
#[derive(Clone, Copy)]
struct Law<'a, T> {
    grid: &'a Grid,
    solids: Solids<'a>,
    importance: &'a [T],
    smoothness: f64,
}

impl<T: Real> Law<'_, T> {
    fn apply(
        &self,
        exec: &dyn Exec,
        w: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
        (cells, scratch): (&mut [T], &mut [T]),
    ) {
        if self.grid.dims == 2 {
            self.curls::<D2>(exec, w, out, scratch);
        } else {
            self.curls::<D3>(exec, w, out, scratch);
        }
        let work = (cells, scratch);
        add_divergence_price(exec, self.grid, self.solids, self.weight(), w, out, work);
    }

    /// lambda alpha h^2: L is in cells.
    fn weight(&self) -> f64 {
        PENALTY * self.smoothness * self.grid.h[0] * self.grid.h[0]
    }

    /// `out` = w + lambda (W^2 + alpha C^T C) w.
    fn curls<S: Space>(
        &self,
        exec: &dyn Exec,
        w: Vector<'_, T>,
        out: &mut VectorMut<'_, T>,
        scratch: &mut [T],
    ) {
        let (grid, importance) = (self.grid, self.importance);
        let fluid = Fluid {
            grid,
            slots: 1,
            viscosity: self.weight(),
            solids: self.solids,
        };
        combine::<T, S>(exec, fluid, [1.0, 1.0, 0.0], w, w, reborrow(out), scratch);
        let quarter = T::from_f64(0.25 * PENALTY);
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
            for (axis, out) in task.fields.into_iter().enumerate().take(S::DIM) {
                let first = task.row * grid.n[0];
                let w = part(w[axis], first..first + grid.n[0]);
                for (x, (out, &w)) in out.iter_mut().zip(w).enumerate() {
                    let here = grid.cell_at(task.row, x);
                    let low = grid.beside(here, axis, Side::Low).unwrap_or(here);
                    let of = |at| importance.get(grid.index(at)).copied().unwrap_or(T::ONE);
                    let twice = of(low) + of(here);
                    *out += quarter * (twice * twice) * w;
                }
            }
        });
    }
}
