//! A known flow taken to another grid or among other solid cells, step by step, and the density that it carries there.
//!
//! Memory is that of one step on the finer grid, whatever the number of steps. The flow of a step is doubled as often as it takes, keeping its
//! divergence ([`refine`]), and projected, which finds something to do among solid cells alone: theirs are drawn anew. In a box that is open and
//! has none that is left out. With an importance the rest of the flow gives way to solid cells first ([`Projection::project_weighted`],
//! [`yielding`]). What is too fine for the result's grid can be made up ([`turbulence`](crate::flow::turbulence)).

mod inputs;
mod make;

use super::InputError;
use super::layout::FileLayout;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::trajectory::{Shape, dot};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::flow::turbulence::{Detail, Turbulence};
use crate::flow::yielding::{self, Yielding};
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Refinement {
    /// How often cells are halved; 0 for a flow that stays on its grid.
    pub doublings: usize,
    /// How the flow gives way to solid cells where [`Refined::set_importance`] says where it should stay as it is; only among solid cells, between
    /// walls or on rings.
    pub weighted: Option<Yielding>,
    /// Turbulence that is added on cells halved once or more, between walls or on rings.
    pub turbulence: Option<Turbulence>,
    /// Threads that scratch is planned for.
    pub threads: usize,
}

/// What came of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Iterations in which a flow gave way, smoothly.
    pub iterations: usize,
    /// The kinetic energy of the flow without turbulence and with it, 1/2 the mean over cells of |v|^2, in the scene's units.
    pub energy: [f64; 2],
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
    weighted: Option<Yielding>,
    detail: Option<Detail<'m, T>>,
    /// What is said of the last step.
    effort: Effort,
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

    /// Makes the flow of the step that comes next, and carries the density by it.
    ///
    /// # Errors
    /// [`Stop::TooFast`], [`Stop::Cancelled`].
    pub fn advance(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        self.refine_flow(exec);
        self.add_turbulence(exec);
        self.project(exec, observer)?;
        if self.detail.is_some() {
            self.effort.energy[1] = self.energy(exec);
        }
        let last = self.grids.len().saturating_sub(1);
        let Some(flow) = self.flows.get(last) else {
            return Ok(());
        };
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
        if let (Some(detail), [captured, ..]) = (&mut self.detail, &self.flows) {
            let h = self.grids[0].h[0];
            detail.carry(exec, view(captured), h, &mut Pool::new(&mut *self.region));
        }
        Stop::heard(observer)
    }

    /// Takes the divergence off the finer flow, as far as there may be any.
    fn project(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        let last = self.grids.len().saturating_sub(1);
        let Some(flow) = self.flows.get_mut(last).filter(|_| self.projects) else {
            return Ok(());
        };
        let pool = &mut Pool::new(&mut *self.region);
        let (tolerance, sums) = (self.tolerance, &mut *self.sums);
        if let Some(how) = self.weighted.filter(|how| how.smoothness > 0.0) {
            let mut work = yielding::Work::carve(&self.levels, self.threads, pool);
            let given = (&*self.importance, how);
            self.effort.iterations = work.apply(exec, observer, flow, given, (tolerance, sums))?;
            return Ok(());
        }
        let mut projection = Projection::carve(&self.levels, 0, 1, self.threads, pool);
        let projected = if self.weighted.is_some() {
            projection.project_weighted(exec, observer, flow, self.importance, tolerance, sums)
        } else {
            projection.project(exec, observer, flow, None, tolerance, sums)
        };
        match projected {
            ControlFlow::Break(()) => Err(Stop::Cancelled),
            ControlFlow::Continue(_) => Ok(()),
        }
    }

    /// Adds what is too fine for the result's grid to the finer flow.
    fn add_turbulence(&mut self, exec: &dyn Exec) {
        if self.detail.is_some() {
            self.effort.energy[0] = self.energy(exec);
        }
        let (Some(detail), [captured, finer @ ..]) = (&mut self.detail, &mut self.flows) else {
            return;
        };
        let Some(flow) = finer.get_mut(self.grids.len().saturating_sub(2)) else {
            return;
        };
        let (fine, amplitude) = (&self.levels.finest, &mut *self.next);
        if self.step == 0 {
            detail.begin(exec, &mut Pool::new(&mut *self.region));
        }
        let captured = view(captured);
        detail.amplitude(exec, captured, fine, amplitude, &mut Pool::new(&mut *self.region));
        let pool = &mut Pool::new(&mut *self.region);
        detail.add(exec, fine, amplitude, flow, self.threads, pool);
    }

    /// The kinetic energy of the finer flow.
    fn energy(&mut self, exec: &dyn Exec) -> f64 {
        let (grid, last) = (&self.levels.finest, self.grids.len().saturating_sub(1));
        let Some(flow) = self.flows.get(last) else {
            return 0.0;
        };
        let squares = dot(exec, Shape { grid, slots: 1 }, view(flow), view(flow), self.sums);
        0.5 * self.unit * self.unit * squares / grid.cells() as f64
    }

    /// What came of the last step.
    #[must_use]
    pub fn effort(&self) -> Effort {
        self.effort
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
