//! A result on a finer grid: its flow, step by step with as many cells more, and the density that this carries from the source on.
//!
//! Memory is that of one step on the finer grid, whatever the number of steps. The flow of a step is doubled as often as it takes, keeping its
//! divergence ([`refine`]), and projected, which finds something to do among solid cells alone: theirs are drawn anew. The density goes by
//! `limited` transport.

mod given;
mod problem;

use super::{SolverError, script};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{ALIGN, Arena, Layout, Ledger, Pool, Sharing, TooSmall};
use crate::method::refusal::{PlanError, count};
use crate::objective::script::{Lists, Script};
use crate::observe::Observer;
use crate::operators::refine;
use crate::poisson::Projection;
use crate::problem::{Advection, Problem, Scheme};
use crate::real::Real;
use crate::transport::{Flow, Stepping, Stop, TooFast, Transport};
use core::mem::MaybeUninit;
use core::ops::ControlFlow;
use problem::{check_problem, free, halved, longest_among_solids};

/// How often cells are halved, at most.
pub const MAX_DOUBLINGS: usize = 3;

/// A density that the flow of a coarser grid carries.
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
    sums: &'m mut [f64],
    /// What projection and transport use in turn.
    region: &'m mut [T],
    threads: usize,
    tolerance: f64,
    stepping: Stepping,
    largest: f64,
    /// The scene's unit of velocities.
    unit: f64,
    step: usize,
}

impl<'m, T: Real> Refined<'m, T> {
    /// Bytes that it takes: `problem` is that of the finer grid, which has `doublings` times twice the cells of the result's along every axis.
    ///
    /// # Errors
    /// [`PlanError`] where the problem is wrong, `doublings` is not from 1 to [`MAX_DOUBLINGS`], cells do not halve so often, or there are too
    /// many for this machine.
    pub fn bytes(problem: &Problem<'_>, doublings: usize, threads: usize) -> Result<usize, PlanError> {
        let problem = &free(problem);
        let mut ledger = Ledger::new();
        let mut arena = Arena::measuring(&mut ledger);
        let mut refined = Self::new(problem, doublings, threads)?;
        // An arena that measures is never too small.
        let _ = refined.layout(problem, &mut arena);
        drop(refined);
        ledger.bytes().ok_or(PlanError::TooLarge)
    }

    /// Carves `memory`, of at least [`Self::bytes`].
    ///
    /// # Errors
    /// [`SolverError`].
    pub fn carve(
        problem: &Problem<'_>,
        doublings: usize,
        threads: usize,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, SolverError> {
        let problem = &free(problem);
        let given = memory.len();
        if !memory.as_ptr().addr().is_multiple_of(ALIGN) {
            return Err(SolverError::Misaligned);
        }
        let mut refined = Self::new(problem, doublings, threads)?;
        let short = |TooSmall { needed, .. }: TooSmall| SolverError::TooSmall { needed, given };
        refined.layout(problem, &mut Arena::new(memory)).map_err(short)?;
        Ok(refined)
    }

    /// One without buffers.
    fn new(problem: &Problem<'_>, doublings: usize, threads: usize) -> Result<Self, PlanError> {
        check_problem(problem)?;
        count("doublings", doublings, MAX_DOUBLINGS)?;
        count("threads", threads, super::MAX_THREADS)?;
        let finest = problem.grid();
        let mut grids = heapless::Vec::new();
        for halvings in (0..=doublings).rev() {
            let grid = halved(&finest, halvings).ok_or(PlanError::OutOfRange {
                field: "doublings",
                given: doublings,
                most: halvings.saturating_sub(1),
            })?;
            // There is room for all of them.
            let _ = grids.push(grid);
        }
        Ok(Self {
            levels: if problem.solids {
                Levels::bare(&finest, 0)
                    .with_eigenvectors_up_to(longest_among_solids(finest.dims))
                    .walled(true)
            } else {
                Levels::bare(&finest, 0)
            },
            grids,
            flows: Default::default(),
            rho: &mut [],
            next: &mut [],
            lists: Lists::default(),
            fields: &mut [],
            sums: &mut [],
            region: &mut [],
            threads,
            tolerance: problem.projection_tolerance,
            stepping: Stepping::from(Advection {
                scheme: Scheme::Limited,
                ..problem.advection
            }),
            largest: 0.0,
            unit: problem.units().velocity,
            step: 0,
        })
    }

    fn layout(&mut self, problem: &Problem<'_>, arena: &mut Arena<'m>) -> Result<(), TooSmall> {
        let grid = self.levels.finest;
        self.levels.fill(arena)?;
        for (grid, flow) in self.grids.iter().zip(&mut self.flows) {
            *flow = arena.take_vector("flow of a step", grid.dims, grid.cells())?;
        }
        self.rho = arena.take("density", grid.cells())?;
        self.next = arena.take("density of the next step", grid.cells())?;
        self.sums = arena.take("sums of rows", 2 * grid.rows())?;
        (self.lists, self.fields) = script::carve(problem, arena)?;
        let (levels, stepping, threads) = (&self.levels, self.stepping, self.threads);
        let doubling = self.grids.iter().map(refine::scratch_per_thread).max();
        let mut layout = Layout::carve(arena);
        layout.in_turn(&mut self.region, 0, |ledger| {
            ledger.line("doubling", threads * doubling.unwrap_or(0), T::BYTES);
            Projection::carve(levels, 0, 1, threads, &mut Pool::measuring(ledger));
            carrier(levels, stepping, 1.0, threads, &mut Pool::measuring(ledger));
        })
    }

    /// The finer grid's cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.levels.finest.cells()
    }

    /// Carries the density to the next step by the flow that was set.
    ///
    /// # Errors
    /// [`Stop::TooFast`], [`Stop::Cancelled`].
    pub fn advance(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Stop> {
        self.refine_flow(exec);
        let last = self.grids.len().saturating_sub(1);
        let Some(flow) = self.flows.get_mut(last) else {
            return Ok(());
        };
        let mut projection = Projection::carve(
            &self.levels,
            0,
            1,
            self.threads,
            &mut Pool::new(&mut *self.region),
        );
        let projected = projection.project(exec, observer, flow, None, self.tolerance, self.sums);
        if let ControlFlow::Break(()) = projected {
            return Err(Stop::Cancelled);
        }
        drop(projection);
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

    /// The density, one number for each cell of the finer grid, x fastest.
    #[must_use]
    pub fn density(&self) -> &[T] {
        self.rho
    }

    /// The step of the density.
    #[must_use]
    pub fn step(&self) -> usize {
        self.step
    }

    /// `out` = the means of the density over each cell of the result's grid.
    pub fn means(&self, exec: &dyn Exec, out: &mut [T]) {
        let (fine, coarse) = (&self.levels.finest, &self.grids[0]);
        let by = fine.n[0] / coarse.n[0];
        let deep = if fine.dims == 3 { by } else { 1 };
        let share = T::from_f64(1.0 / (by * by * deep) as f64);
        let n = fine.n[0];
        for_rows(exec, coarse.rows(), RowBuffers::fields([out]), |task| {
            let ([out], [y, z]) = (task.fields, coarse.row_at(task.row));
            out.fill(T::ZERO);
            for child in 0..by * deep {
                let row = fine.row(by * y + child % by, deep * z + child / by);
                let children = rows::part(&*self.rho, row * n..(row + 1) * n);
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
