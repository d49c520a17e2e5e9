//! The buffers of an operator, said once.

use super::setup::Setup;
use super::{Operator, OperatorParams, Phase};
use crate::force::lift::Lift;
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Arena, Layout, Ledger, Pool, Sharing, TooSmall};
use crate::method::simulate::step::Step;
use crate::objective::script::emitted::NUMBERS;
use crate::objective::script::{Lists, Script};
use crate::poisson::Projection;
use crate::problem::Problem;
use crate::real::Real;
use crate::reversal::Reversal;
use crate::solver::carve_script;
use crate::transport::Transport;
use core::marker::PhantomData;

/// What of `problem` an operator has: no control, and lists up to the last step.
pub(super) fn bare_problem<'p>(problem: &Problem<'p>) -> Problem<'p> {
    Problem {
        // Lists of forces end one step before the steps of a problem do.
        steps: problem.steps + 1,
        keyframes: &[],
        keyframe_weights: &[],
        keyframe_regions: false,
        release: None,
        schedule: &[],
        mask: false,
        ..*problem
    }
}

impl<'m, T: Real, S: Space> Operator<'m, T, S> {
    /// An operator without memory.
    #[inline(never)]
    pub(super) fn bare(problem: &Problem<'_>, params: &OperatorParams, slots: usize) -> Self {
        let grid = problem.grid();
        Self {
            setup: Setup::new(problem, params, slots),
            levels: Levels::alone(&grid).with_surfaces(problem.surfaces()),
            lists: Lists::default(),
            shapes: &mut [],
            largest: 1.0,
            rho: &mut [],
            v: Default::default(),
            force: Default::default(),
            mu: &mut [],
            covector: Default::default(),
            z: Default::default(),
            known: 0,
            of_buoyancy: [0.0; 3],
            numbers: &mut [],
            of_shapes: &mut [],
            sums: &mut [],
            kept: &mut [],
            reversal: Reversal::new(0, &mut [], false),
            phase: Phase::Nothing,
            repeated: 0,
            region: &mut [],
            space: PhantomData,
        }
    }

    /// Every buffer, in order.
    pub(super) fn layout(&mut self, problem: &Problem<'_>, arena: &mut Arena<'m>) -> Result<(), TooSmall> {
        let grid = self.levels.finest;
        let (dims, cells, setup) = (grid.dims, grid.cells(), self.setup);
        let mut steps: &mut [usize] = &mut [];
        {
            let mut layout = Layout::<T>::carve(arena);
            layout.tables(|arena| self.levels.fill(arena))?;
            layout.work("densities before and after a step", &mut self.rho, 2 * cells)?;
            let names = ["velocity before", "velocity", "velocity after"];
            for (name, v) in names.into_iter().zip(&mut self.v) {
                layout.work_vector(name, v, dims, cells)?;
            }
            layout.work_vector("force of a step", &mut self.force, dims, cells)?;
            layout.work("covector of the density", &mut self.mu, cells)?;
            layout.work_vector("covector of the velocity", &mut self.covector, dims, cells)?;
            for z in &mut self.z {
                layout.work_vector("covector of a force", z, dims, cells)?;
            }
            if setup.emitters > 0 {
                layout.work("numbers of emitters", &mut self.numbers, setup.emitters * NUMBERS)?;
                layout.work(
                    "covectors of emitters",
                    &mut self.of_shapes,
                    setup.emitters * cells,
                )?;
            }
            layout.work("sums of rows", &mut self.sums, 3 * grid.rows())?;
            layout.work("steps of kept states", &mut steps, setup.slots)?;
            layout.work("kept states", &mut self.kept, setup.slots * state_len(&grid))?;
            let levels = &self.levels;
            layout.in_turn(&mut self.region, 0, |ledger| uses(levels, &setup, ledger))?;
        }
        self.reversal = Reversal::new(0, steps, false);
        (self.lists, self.shapes) = carve_script(&bare_problem(problem), arena)?;
        Ok(())
    }

    /// The lists of the scene.
    pub(super) fn script(&self) -> Script<'_, T> {
        Script::new(self.lists, self.shapes)
    }

    /// Buoyancy in a field of one step.
    pub(super) fn lift(&self) -> Lift<'_> {
        Lift {
            grid: &self.levels.finest,
            slots: 1,
            solids: self.levels.solids(0),
            acceleration: self.setup.buoyancy,
        }
    }
}

/// Numbers of a state between two steps: rho_k, v_k, and v_{k-1}, by which the next step guesses.
pub(super) fn state_len(grid: &Grid) -> usize {
    (1 + 2 * grid.dims) * grid.cells()
}

/// What happens in turn.
fn uses<T: Real>(levels: &Levels<'_, T>, setup: &Setup, ledger: &mut Ledger) {
    let (grid, threads, solids) = (&levels.finest, setup.params.threads, levels.solids(0));
    let mut pool = Pool::<T>::measuring(ledger);
    let pool = &mut pool;
    pool.group("step forward", Sharing::Together, |pool| {
        let _ = Transport::one_way(grid, setup.stepping, 1.0, threads, pool).among(solids, pool);
    });
    Step::carve(levels, 0, setup.step(), pool);
    pool.group("step back", Sharing::Together, |pool| {
        let _ = Transport::carve(grid, setup.stepping, 1.0, threads, pool).among(solids, pool);
    });
    Projection::carve(levels, 0, 1, threads, pool);
}
