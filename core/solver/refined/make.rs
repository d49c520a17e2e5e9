//! The memory of a [`Refined`] density: how many bytes, and what lies where.

use super::{Effort, MAX_DOUBLINGS, Refined, Refinement, carrier};
use crate::flow::turbulence::Detail;
use crate::flow::yielding;
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::{Arena, Layout, Ledger, Pool, TooSmall};
use crate::method::refusal::{PlanError, count};
use crate::objective::script::Lists;
use crate::operators::refine;
use crate::poisson::Projection;
use crate::problem::{Problem, ProblemError, not_negative};
use crate::real::Real;
use crate::solver::{MAX_THREADS, SolverError, block, script};
use crate::transport::Stepping;
use core::mem::MaybeUninit;

impl<'m, T: Real> Refined<'m, T> {
    /// Bytes that it takes: `problem` is that of the finer grid.
    ///
    /// # Errors
    /// [`PlanError`] where the problem is wrong, there are more than [`MAX_DOUBLINGS`], cells do not halve so often, or there are too
    /// many for this machine.
    pub fn bytes(problem: &Problem<'_>, refinement: Refinement) -> Result<usize, PlanError> {
        let problem = &free(problem);
        let mut ledger = Ledger::new();
        let mut arena = Arena::measuring(&mut ledger);
        let mut refined = Self::new(problem, refinement)?;
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
        refinement: Refinement,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, SolverError> {
        let problem = &free(problem);
        let given = memory.len();
        let mut arena = block(memory, given)?;
        let mut refined = Self::new(problem, refinement)?;
        let short = |TooSmall { needed, .. }: TooSmall| SolverError::TooSmall { needed, given };
        refined.layout(problem, &mut arena).map_err(short)?;
        Ok(refined)
    }

    /// One without buffers.
    fn new(problem: &Problem<'_>, refinement: Refinement) -> Result<Self, PlanError> {
        let Refinement {
            doublings,
            threads,
            turbulence,
            weighted,
            ..
        } = refinement;
        match problem.check() {
            // What is refined has no divergence: only obstacles ask for a projection.
            Err(ProblemError::OpenCells { .. }) if !problem.solids => {}
            checked => checked?,
        }
        if doublings > MAX_DOUBLINGS {
            return Err(PlanError::OutOfRange {
                field: "doublings",
                given: doublings,
                most: MAX_DOUBLINGS,
            });
        }
        count("threads", threads, MAX_THREADS)?;
        if let Some(how) = weighted {
            count("iterations", how.iterations, usize::MAX)?;
            not_negative("smoothness", how.smoothness)?;
        }
        not_negative("turbulence", turbulence.map_or(0.0, |given| given.strength))?;
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
        let on_grid = |grid: &Grid| turbulence.map(|given| Detail::new(grid, doublings, given));
        let detail = grids.first().filter(|_| doublings > 0 && !finest.is_open());
        Ok(Self {
            detail: detail.and_then(on_grid),
            effort: Effort::default(),
            levels: Levels::bare(&finest, 0).with_surfaces(problem.surfaces()),
            grids,
            flows: Default::default(),
            rho: &mut [],
            next: &mut [],
            lists: Lists::default(),
            fields: &mut [],
            importance: &mut [],
            weighted: refinement
                .weighted
                .filter(|_| problem.solids && !finest.is_open()),
            sums: &mut [],
            region: &mut [],
            threads,
            // A flow that stays on its grid is carried as it is, with whatever divergence it has.
            projects: problem.solids || (doublings > 0 && !finest.is_open()),
            tolerance: problem.projection_tolerance,
            stepping: Stepping::from(problem.advection),
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
        let weights = self.weighted.map_or(0, |_| grid.cells());
        self.importance = arena.take("importance", weights)?;
        if let Some(detail) = &mut self.detail {
            detail.layout(arena)?;
        }
        self.sums = arena.take("sums of rows", 2 * grid.rows())?;
        (self.lists, self.fields) = script::carve(problem, arena)?;
        let (levels, stepping, threads, projects) =
            (&self.levels, self.stepping, self.threads, self.projects);
        let doubles = self.grids.len() > 1;
        let (detail, smooth) = (&self.detail, self.weighted.filter(|how| how.smoothness > 0.0));
        let doubling = self.grids.iter().map(refine::scratch_per_thread).max();
        let mut layout = Layout::carve(arena);
        layout.in_turn(&mut self.region, 0, |ledger| {
            if doubles {
                let pool = &mut Pool::<T>::measuring(ledger);
                pool.line("cubics", |pool| {
                    let _ = [(); 3].map(|()| pool.take("cubics", grid.cells()));
                });
            }
            ledger.line("doubling", threads * doubling.unwrap_or(0), T::BYTES);
            if let Some(detail) = detail {
                detail.measure(&grid, threads, ledger);
            }
            if smooth.is_some() {
                yielding::Work::carve(levels, threads, &mut Pool::measuring(ledger));
            } else if projects {
                Projection::carve(levels, 0, 1, threads, &mut Pool::measuring(ledger));
            }
            carrier(levels, stepping, 1.0, threads, &mut Pool::measuring(ledger));
        })
    }
}

/// What is left of a problem that nobody steers.
fn free<'a>(problem: &Problem<'a>) -> Problem<'a> {
    Problem {
        // Where nobody steers a single step will do, and takes what two do.
        steps: if problem.steps == 1 { 2 } else { problem.steps },
        keyframes: &[],
        keyframe_weights: &[],
        keyframe_regions: false,
        schedule: &[],
        mask: false,
        release: None,
        ..*problem
    }
}

/// The grid whose cells are as often twice as long; `None` if there is none.
fn halved(grid: &Grid, halvings: usize) -> Option<Grid> {
    let by = 1 << halvings;
    let (mut h, mut inside) = (grid.h, grid.counts_inside());
    for (n, h) in inside.iter_mut().zip(&mut h).take(grid.dims) {
        if !n.is_multiple_of(by) {
            return None;
        }
        *n /= by;
        *h *= by as f64;
    }
    let mut coarse = grid.with_inside(inside);
    coarse.h = h;
    Some(coarse)
}
