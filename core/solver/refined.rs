//! A result on a finer grid: its flow, step by step with as many cells more, and the density that this carries from the source on.
//!
//! Memory is that of one step on the finer grid, whatever the number of steps. The flow of a step is doubled as often as it takes, keeping its
//! divergence ([`refine`]), and projected, which finds something to do among solid cells alone: theirs are drawn anew. The density goes by
//! `limited` transport.

use super::inputs::check;
use super::layout::FileLayout;
use super::{InputError, SolverError, script};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::grid::spectrum::LONGEST;
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

    /// Sets which cells of the finer grid are solid, before any density: one flag for each, x fastest.
    ///
    /// # Errors
    /// [`InputError::Length`]; [`InputError::Index`] where the problem has no solid cells.
    pub fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        let expected = self.cells();
        if !self.levels.solids(0).there() {
            return Err(InputError::Index { given: 0, count: 0 });
        }
        if solid.len() != expected {
            return Err(InputError::Length {
                expected,
                given: solid.len(),
            });
        }
        self.levels
            .set_solids(|cell| solid.get(cell).copied().unwrap_or(false));
        Ok(())
    }

    /// Sets the density, and that it is of step 0: one number for each cell of the finer grid, x fastest.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is negative or not finite.
    pub fn set_density(&mut self, density: &[T]) -> Result<(), InputError> {
        check(density, self.cells())?;
        self.rho.copy_from_slice(density);
        let n = self.levels.finest.n[0];
        self.levels.solids(0).clear_cells(n, self.rho);
        self.largest = density.iter().fold(self.largest, |most, x| most.max(x.to_f64()));
        self.step = 0;
        Ok(())
    }

    /// Sets the shape of emitter `index`.
    ///
    /// # Errors
    /// As [`Self::set_density`], or [`InputError::Index`].
    pub fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        let cells = self.cells();
        check(shape, cells)?;
        let count = self.lists.spans.len() / 2;
        let field = self.fields.get_mut(index * cells..(index + 1) * cells);
        let field = field.ok_or(InputError::Index { given: index, count })?;
        field.copy_from_slice(shape);
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
        FileLayout::new(&grid, axis).read(faces, 1.0 / self.unit, field)
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

/// The longest axis among solid cells. A plane is projected by longer eigenvectors than a search has, which take longer than their many cells.
const fn longest_among_solids(dims: usize) -> usize {
    if dims == 2 { 1024 } else { LONGEST }
}

fn check_problem(problem: &Problem<'_>) -> Result<(), PlanError> {
    let longest = longest_among_solids(problem.cells.len());
    let fits = problem.cells.iter().all(|&n| n <= longest);
    let solids = problem.solids && !fits;
    Problem { solids, ..*problem }.check().map_err(PlanError::from)
}

/// What is left of a problem that nobody steers.
fn free<'a>(problem: &Problem<'a>) -> Problem<'a> {
    Problem {
        keyframes: &[],
        keyframe_weights: &[],
        keyframe_regions: false,
        schedule: &[],
        release: None,
        advection: Advection {
            scheme: Scheme::Limited,
            ..problem.advection
        },
        ..*problem
    }
}

/// The grid whose cells are as often twice as long; `None` if there is none.
fn halved(grid: &Grid, halvings: usize) -> Option<Grid> {
    let mut coarse = *grid;
    let by = 1 << halvings;
    for axis in 0..grid.dims {
        if !grid.n[axis].is_multiple_of(by) {
            return None;
        }
        coarse.n[axis] /= by;
        coarse.h[axis] *= by as f64;
    }
    Some(coarse)
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
