//! A known flow taken to another grid or among other solid cells, step by step, and the density that it carries there.
//!
//! Memory is that of one step on the finer grid, whatever the number of steps. The flow of a step is doubled as often as it takes, keeping its
//! divergence ([`refine`]), and projected, which finds something to do among solid cells alone: theirs are drawn anew. In a box that is open and
//! has none that is left out. With an importance the rest of the flow gives way to solid cells first ([`Projection::project_weighted`]).

mod make;

use super::InputError;
use super::inputs::{check, put_solids};
use super::layout::FileLayout;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{Pool, Sharing};
use crate::objective::script::{Lists, Script};
use crate::observe::Observer;
use crate::operators::refine;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::{Flow, Stepping, Stop, TooFast, Transport};
use core::ops::ControlFlow;

/// How often cells are halved, at most.
pub const MAX_DOUBLINGS: usize = 3;

/// What is done to a flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refinement {
    /// How often cells are halved; 0 for a flow that stays on its grid.
    pub doublings: usize,
    /// Whether [`Refined::set_importance`] says where the flow should stay as it is; only among solid cells, between walls or on rings.
    pub weighted: bool,
    /// Threads that scratch is planned for.
    pub threads: usize,
}

/// A density that a known flow carries.
#[derive(Debug)]
pub struct Refined<'m, T> {
    /// The finer grid and those below it.
    levels: Levels<'m, T>,
    /// The grids from that of the result to the finer one, and the flow of a step on each.
    grids: heapless::Vec<Grid, { MAX_DOUBLINGS + 1 }>,
    flows: [VectorMut<'m, T>; MAX_DOUBLINGS + 1],
    /// The density, and that of the next step.
    rho: &'m mut [T],
    next: &'m mut [T],
    lists: Lists<'m>,
    /// The emitters' shapes.
    fields: &'m mut [T],
    /// How much the flow matters in each cell.
    importance: &'m mut [T],
    weighted: bool,
    sums: &'m mut [f64],
    /// What projection and transport use in turn.
    region: &'m mut [T],
    threads: usize,
    /// Whether the flow is projected on the finer grid.
    projects: bool,
    tolerance: f64,
    stepping: Stepping,
    largest: f64,
    /// The scene's unit of velocities.
    unit: f64,
    step: usize,
}

impl<T: Real> Refined<'_, T> {
    /// The finer grid's cells, inside the box.
    #[must_use]
    pub fn cells(&self) -> usize {
        FileLayout::of_cells(&self.levels.finest).len()
    }

    /// Sets which cells of the finer grid are solid, before any density: one flag for each, x fastest.
    ///
    /// # Errors
    /// [`InputError::Length`]; [`InputError::Index`] where the problem has no solid cells.
    pub fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        let expected = self.cells();
        if !self.levels.solids(0).obstacles() {
            return Err(InputError::Index { given: 0, count: 0 });
        }
        if solid.len() != expected {
            return Err(InputError::Length {
                expected,
                given: solid.len(),
            });
        }
        put_solids(&mut self.levels, solid);
        Ok(())
    }

    /// Sets the density, and that it is of step 0: one number for each cell of the finer grid, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite.
    pub fn set_density(&mut self, density: &[T]) -> Result<(), InputError> {
        check(density, self.cells())?;
        FileLayout::of_cells(&self.levels.finest).write(density, T::ONE, self.rho);
        let n = self.levels.finest.n[0];
        self.levels.solids(0).clear_cells(n, self.rho);
        self.largest = density.iter().fold(self.largest, |most, x| most.max(x.to_f64()));
        self.step = 0;
        Ok(())
    }

    /// Sets how much the flow matters in each cell, above 0: 1 where it does not.
    ///
    /// # Errors
    /// As [`Self::set_density`]; [`InputError::Index`] where none was planned for, [`InputError::Empty`] where a cell has 0.
    pub fn set_importance(&mut self, importance: &[T]) -> Result<(), InputError> {
        if !self.weighted {
            return Err(InputError::Index { given: 0, count: 0 });
        }
        check(importance, self.cells())?;
        if importance.contains(&T::ZERO) {
            return Err(InputError::Empty);
        }
        self.importance.copy_from_slice(importance);
        Ok(())
    }

    /// Sets the shape of emitter `index`.
    ///
    /// # Errors
    /// As [`Self::set_density`], or [`InputError::Index`].
    pub fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        check(shape, self.cells())?;
        let cells = self.levels.finest.cells();
        let count = self.lists.spans.len() / 2;
        let field = self.fields.get_mut(index * cells..(index + 1) * cells);
        let field = field.ok_or(InputError::Index { given: index, count })?;
        FileLayout::of_cells(&self.levels.finest).write(shape, T::ONE, field);
        let n = self.levels.finest.n[0];
        self.levels.solids(0).clear_cells(n, field);
        let supply = self.lists.supplies.get(2 * index..2 * index + 2).unwrap_or(&[]);
        let supply: f64 = supply.iter().sum();
        self.largest = shape
            .iter()
            .fold(self.largest, |most, x| most.max(supply * x.to_f64()));
        Ok(())
    }

    /// Sets a component of the flow of the step that comes next, on the result's grid, in the layout of a file (one more face than cells along a
    /// wall axis) and the scene's units.
    ///
    /// # Errors
    /// [`InputError`]: no such axis, wrong length, a value that is not finite.
    pub fn set_velocity(&mut self, axis: usize, faces: &[T]) -> Result<(), InputError> {
        let grid = self.grids[0];
        let count = grid.dims;
        let [flow, ..] = &mut self.flows;
        let Some(field) = flow.get_mut(axis).filter(|_| axis < count) else {
            return Err(InputError::Index { given: axis, count });
        };
        FileLayout::new(&grid, axis).take(faces, 1.0 / self.unit, field, [1, 0])
    }

    /// Makes the flow of the step that comes next, and carries the density by it.
    ///
    /// # Errors
    /// [`Stop::TooFast`], [`Stop::Cancelled`].
    pub fn advance(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        self.refine_flow(exec);
        let last = self.grids.len().saturating_sub(1);
        let Some(flow) = self.flows.get_mut(last) else {
            return Ok(());
        };
        if self.projects {
            let pool = &mut Pool::new(&mut *self.region);
            let mut projection = Projection::carve(&self.levels, 0, 1, self.threads, pool);
            let (tolerance, sums) = (self.tolerance, &mut *self.sums);
            let projected = if self.weighted {
                projection.project_weighted(exec, observer, flow, self.importance, tolerance, sums)
            } else {
                projection.project(exec, observer, flow, None, tolerance, sums)
            };
            if let ControlFlow::Break(()) = projected {
                return Err(Stop::Cancelled);
            }
        }
        let pool = &mut Pool::new(&mut *self.region);
        let mut transport = carrier(&self.levels, self.stepping, self.largest, self.threads, pool);
        let flow = Flow {
            initial: view(flow),
            v: view(flow),
            along: None,
        };
        transport
            .load(exec, &flow, 1, 0, self.sums)
            .map_err(|TooFast| Stop::TooFast)?;
        transport.forward(exec, self.rho, self.next);
        core::mem::swap(&mut self.rho, &mut self.next);
        self.step += 1;
        Script::new(self.lists, &*self.fields).emit(exec, &self.levels.finest, self.step, self.rho);
        Stop::heard(observer)
    }

    /// The flow on the finer grid from that on the result's.
    fn refine_flow(&mut self, exec: &dyn Exec) {
        let mut coarse: Option<Vector<'_, T>> = None;
        let pairs = self.grids.iter().zip(self.grids.iter().skip(1));
        let mut flows = self.flows.iter_mut();
        if let Some(first) = flows.next() {
            coarse = Some(view(first));
        }
        for (grids, fine) in pairs.zip(flows) {
            if let Some(coarse) = coarse {
                refine::double(exec, grids, coarse, reborrow(fine), self.region);
            }
            coarse = Some(view(fine));
        }
    }

    /// Adds smoke to the density: one number for each cell of the finer grid, x fastest.
    ///
    /// # Errors
    /// As [`Self::set_density`].
    pub fn add(&mut self, smoke: &[T]) -> Result<(), InputError> {
        check(smoke, self.cells())?;
        FileLayout::of_cells(&self.levels.finest).write(smoke, T::ONE, self.next);
        rows::add(self.rho, self.next);
        Ok(())
    }

    /// The density as it is stored: one number for each cell of the finer grid, those outside open sides, where it is 0, among them.
    #[must_use]
    pub fn density(&self) -> &[T] {
        self.rho
    }

    /// A component of the flow that carried the density here, in the layout of a file and the scene's units.
    ///
    /// # Errors
    /// [`InputError`]: no such axis, wrong length.
    pub fn velocity(&self, axis: usize, out: &mut [T]) -> Result<(), InputError> {
        let grid = &self.levels.finest;
        let flow = self.flows.get(self.grids.len().saturating_sub(1));
        let field = flow.and_then(|flow| flow.get(axis)).filter(|_| axis < grid.dims);
        let Some(field) = field else {
            let count = grid.dims;
            return Err(InputError::Index { given: axis, count });
        };
        let layout = FileLayout::new(grid, axis);
        let (expected, given) = (layout.len(), out.len());
        if expected != given {
            return Err(InputError::Length { expected, given });
        }
        layout.read(field, [1, 0], T::from_f64(self.unit), out);
        Ok(())
    }

    /// Numbers of a component of the flow, in the layout of a file.
    #[must_use]
    pub fn faces(&self, axis: usize) -> usize {
        FileLayout::new(&self.levels.finest, axis).len()
    }

    /// `out` = the density, one number for each of [`Self::cells`], x fastest.
    pub fn read_density(&self, out: &mut [T]) {
        FileLayout::of_cells(&self.levels.finest).read(self.rho, [1, 0], T::ONE, out);
    }

    /// The step of the density.
    #[must_use]
    pub fn step(&self) -> usize {
        self.step
    }

    /// `out` = the means of the density over each cell of the result's grid, inside the box.
    pub fn means(&self, exec: &dyn Exec, out: &mut [T]) {
        let (fine, coarse) = (&self.levels.finest, &self.grids[0]);
        let [from, to] = [fine, coarse].map(Grid::inside);
        let by = from[0].len() / to[0].len();
        let deep = if fine.dims == 3 { by } else { 1 };
        let share = T::from_f64(1.0 / (by * by * deep) as f64);
        let (n, ny) = (fine.n[0], to[1].len());
        for_rows(exec, ny * to[2].len(), RowBuffers::fields([out]), |task| {
            let ([out], [y, z]) = (task.fields, [task.row % ny, task.row / ny]);
            out.fill(T::ZERO);
            for child in 0..by * deep {
                let y = from[1].start + by * y + child % by;
                let first = fine.row(y, from[2].start + deep * z + child / by) * n + from[0].start;
                let children = rows::part(&*self.rho, first..first + from[0].len());
                for (out, children) in out.iter_mut().zip(children.chunks_exact(by)) {
                    children.iter().for_each(|&child| *out += share * child);
                }
            }
        });
    }
}

/// Limited transport forward among the solid cells of the finest grid.
fn carrier<'a, T: Real>(
    levels: &'a Levels<'_, T>,
    stepping: Stepping,
    largest: f64,
    threads: usize,
    pool: &mut Pool<'a, T>,
) -> Transport<'a, T> {
    pool.group("transport among solid cells", Sharing::Together, |pool| {
        Transport::one_way(&levels.finest, stepping, largest, threads, pool).among(levels.solids(0), pool)
    })
}
