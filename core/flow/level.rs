//! One grid of the pyramid: the estimate from the coarser one, the warp, the correction, and what is said of it.

use super::data::{self, Weights};
use super::minimise::{Effort, Objective, Work};
use super::params::FlowParams;
use super::resample::{Kind, resample};
use super::warp::Warp;
use crate::exec::Exec;
use crate::field::trajectory::{Shape, add, dot};
use crate::field::{Vector, VectorMut, rows, sums, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{Pool, Sharing, measured, pooled};
use crate::observe::Observer;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

/// How much divergence a projection leaves of what there was.
const LEFT: f64 = 1e-4;

/// The workspace of a level.
#[derive(Debug)]
pub struct Level<'a, T> {
    grid: &'a Grid,
    params: FlowParams,
    threads: usize,
    projection: Option<Projection<'a, T>>,
    /// The estimate Din; at the end the flow.
    pub flow: VectorMut<'a, T>,
    g: VectorMut<'a, T>,
    /// phi_2*, then phi_t.
    change: &'a mut [T],
    cells: &'a mut [T],
    /// What is used in turn: by resampling, warp and minimiser.
    turn: &'a mut [T],
    scratch: &'a mut [T],
}

/// What is said of the flow on the finest grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// 1/2 |phi_t + F w|^2.
    pub data: f64,
    /// alpha/2 <Din + w, L (Din + w)>.
    pub smoothness: f64,
    /// beta/2 |Din + w|^2.
    pub kinetic: f64,
    /// |grad f(w)| in parts of |grad f(0)|, both projected where flows have no divergence.
    pub optimality: f64,
}

impl<'a, T: Real> Level<'a, T> {
    fn turn_len(grid: &Grid, params: &FlowParams, threads: usize) -> [(&'static str, usize); 3] {
        let minimiser = measured::<T>(|pool| {
            let mut pool = pool;
            Work::carve(grid, params, &mut pool);
        });
        let warp = measured::<T>(|pool| {
            let mut pool = pool;
            Warp::carve(grid, params.warp, threads, &mut pool);
        });
        [
            ("the minimiser's fields", minimiser),
            ("a warp's", warp),
            ("a resampling's", 2 * pooled(grid.cells())),
        ]
    }

    /// Takes its workspace from a pool, on grid `depth` of `levels`, if there is one.
    pub fn carve(
        (levels, depth): (&'a Levels<'_, T>, usize),
        params: &FlowParams,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Option<Self> {
        let grid = levels.grids.get(depth)?;
        let cells = grid.cells();
        let level = pool.group("a level of the pyramid", Sharing::Together, |pool| Self {
            grid,
            params: *params,
            threads,
            projection: params
                .is_hard()
                .then(|| Projection::carve(levels, depth, 1, threads, pool)),
            flow: pool.take_vector("estimate", grid.dims, cells),
            g: pool.take_vector("gradient of the mean frame", grid.dims, cells),
            change: pool.take("warped frame and change", cells),
            cells: pool.take("F w", cells),
            turn: pool.take_longest("in turn", &Self::turn_len(grid, params, threads)),
            scratch: pool.take("rows", data::scratch_len(grid, threads)),
        });
        Some(level)
    }

    /// The estimate from the flow on a coarser grid, which begins as 0.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn estimate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        coarser: Option<(&Grid, Vector<'_, T>)>,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let grid = self.grid;
        let Some((coarse, flow)) = coarser else {
            self.flow.iter_mut().for_each(|component| component.fill(T::ZERO));
            return Ok(());
        };
        for (axis, out) in self.flow.iter_mut().enumerate().take(grid.dims) {
            let mut pool = Pool::new(&mut *self.turn);
            let work = [(); 2].map(|()| pool.take("between axes", grid.cells()));
            let scale = grid.n[axis] as f64 / coarse.n[axis] as f64;
            resample(
                exec,
                [coarse, grid],
                (Kind::Faces(axis), scale),
                flow[axis],
                out,
                work,
            );
        }
        match &mut self.projection {
            None => Ok(()),
            Some(projection) => {
                let done = projection.project(exec, observer, &mut self.flow, None, LEFT, sums);
                if done.is_break() {
                    Err(Stop::Cancelled)
                } else {
                    Ok(())
                }
            }
        }
    }

    /// Adds the correction that makes the first frame the second to the estimate, `warps` times. How many products by A it took; and with
    /// `told` what is said of the last.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn correct(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        frames: [&[T]; 2],
        begins: bool,
        told: Option<&mut Terms>,
        sums: &mut [f64],
    ) -> Result<usize, Stop> {
        let (mut products, mut effort) = (0, Effort::default());
        for round in 0..self.params.warps {
            if round > 0 {
                self.accept(exec);
            }
            self.load(exec, frames, begins && round == 0, sums)?;
            let (mut objective, mut work) = self.objective();
            effort = objective.minimise(exec, observer, &mut work, sums)?;
            products += effort.products;
        }
        match told {
            None => self.accept(exec),
            Some(terms) => *terms = self.describe(exec, observer, effort, sums)?,
        }
        Ok(products)
    }

    /// phi_t and g.
    fn load(
        &mut self,
        exec: &dyn Exec,
        [first, second]: [&[T]; 2],
        still: bool,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let grid = self.grid;
        if still {
            self.change.copy_from_slice(second);
        } else {
            let warp = Warp::carve(
                grid,
                self.params.warp,
                self.threads,
                &mut Pool::new(&mut *self.turn),
            );
            warp.apply(exec, second, view(&self.flow), self.change, sums)?;
        }
        data::gradient_of_mean(exec, grid, [first, &*self.change], &mut self.g, self.scratch);
        rows::sub(self.change, first);
        Ok(())
    }

    fn objective(&mut self) -> (Objective<'_, 'a, T>, Work<'_, T>) {
        let work = Work::carve(self.grid, &self.params, &mut Pool::new(&mut *self.turn));
        let objective = Objective {
            grid: self.grid,
            params: &self.params,
            projection: self.projection.as_mut(),
            estimate: view(&self.flow),
            g: view(&self.g),
            change: &*self.change,
            cells: &mut *self.cells,
            scratch: &mut *self.scratch,
        };
        (objective, work)
    }

    /// Adds the correction to the estimate.
    fn accept(&mut self, exec: &dyn Exec) {
        let grid = self.grid;
        let work = Work::carve(grid, &self.params, &mut Pool::new(&mut *self.turn));
        add(
            exec,
            Shape { grid, slots: 1 },
            &mut self.flow,
            1.0,
            1.0,
            view(&work.w),
        );
    }

    /// Adds the correction to the estimate, and the terms of f there.
    fn describe(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        effort: Effort,
        sums: &mut [f64],
    ) -> Result<Terms, Stop> {
        let (grid, params) = (self.grid, self.params);
        let shape = Shape { grid, slots: 1 };
        let work = Work::carve(grid, &self.params, &mut Pool::new(&mut *self.turn));
        // phi_t + F w takes the place of phi_t.
        data::apply(exec, grid, view(&self.g), view(&work.w), self.cells);
        rows::add(self.change, self.cells);
        self.accept(exec);
        let change = &*self.change;
        let n = grid.n[0];
        let squares = sums::total(exec, grid, sums, |row| {
            rows::sum_squares(rows::part(change, row * n..(row + 1) * n))
        });
        let Work { mut r, mut image, .. } = Work::carve(grid, &params, &mut Pool::new(&mut *self.turn));
        let (flow, g) = (view(&self.flow), view(&self.g));
        let law = |data: f64, smooth: f64, kinetic: f64| Weights {
            data,
            smooth,
            kinetic,
        };
        data::combine(
            exec,
            grid,
            law(0.0, 1.0, 0.0),
            (g, change),
            flow,
            &mut image,
            self.scratch,
        );
        let smoothness = dot(exec, shape, flow, view(&image), sums);
        let kinetic = dot(exec, shape, flow, flow, sums);
        let all = law(1.0, params.alpha, params.beta);
        data::combine(exec, grid, all, (g, change), flow, &mut r, self.scratch);
        let mut objective = Objective {
            grid,
            params: &params,
            projection: self.projection.as_mut(),
            estimate: flow,
            g,
            change,
            cells: &mut *self.cells,
            scratch: &mut *self.scratch,
        };
        objective.add_price(exec, flow, &mut r);
        objective.project(exec, observer, &mut r, sums)?;
        let left = libm::sqrt(dot(exec, shape, view(&r), view(&r), sums));
        Ok(Terms {
            data: 0.5 * squares,
            smoothness: 0.5 * params.alpha * smoothness,
            kinetic: 0.5 * params.beta * kinetic,
            optimality: if effort.first > 0.0 {
                left / effort.first
            } else {
                0.0
            },
        })
    }
}
