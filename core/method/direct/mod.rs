//! The direct method (mathematics section 6): no splitting. For any flow free of divergence the force that produces it is
//! w_k = P[v_k - v_{k-1} + Adv(v_k)], so the objective is a function of the flow alone, without constraints:
//!
//! ```text
//! F(v) = 1/2 <e, C e>(v) + r/2 sum <w_k(v), z_k(v)>,   z = (1 + s^2 C^T C) w with the second C the curl
//! g_k  = Q[r (z_k - z_{k+1} + (J(v_k)^T + nu C^T C) z_k) - A_v^T mu_k]
//! ```
//!
//! Every iterate is a feasible animation and no flow is ever simulated. F is minimised by L-BFGS, whose first inverse Hessian is
//! exact in time for a flow at rest; it begins on coarser grids (see [`crate::objective::coarse`]) in the bytes of the finest grid's work.

mod descend;
mod kept;
mod level;
pub mod params;
pub mod room;
mod setup;
mod sizes;
mod start;
pub mod there;
mod work;

use crate::checkpoint::{Damaged, MANY, Mix, Record};
use crate::exec::Exec;
use crate::field::Vector;
use crate::grid::{Grid, Space};
use crate::memory::part::REACH;
use crate::memory::{Layout, TooSmall, Visit};
use crate::method::animation::Animation;
use crate::method::contract::{Contract, Measure, Parts, fits, pairs_that_fit};
use crate::method::params::Params;
use crate::method::refusal::PlanError;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::optimise::descent::{Descent, Outcome};
use crate::optimise::quasi_newton;
use crate::problem::Problem;
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use core::marker::PhantomData;
use params::{DirectParams, coarse_iterations};
use setup::Setup;
use sizes::{Sizes, Threads, coarser};

/// Their tolerance in parts of the finest grid's: a plateau there is seldom the end, and to go on costs little.
const COARSE_TOLERANCE: f64 = 1e-2;

/// The direct method's state.
#[derive(Debug)]
pub struct Direct<'m, T, S> {
    animation: Animation<'m, T>,
    /// Gradients, directions, pairs and work of the finest grid, or the coarser grids before it.
    rest: &'m mut [T],
    pivots: &'m mut [f64],
    setup: Setup,
    /// Threads on each grid that takes part, finest first.
    threads: Threads,
    /// The grid that is worked on, or `None` before the first iteration.
    level: Option<usize>,
    /// Whether a device can search it.
    goes_there: bool,
    /// The grid that a device has the fields of, if any has.
    there: Option<usize>,
    descent: Descent,
    iteration: usize,
    space: PhantomData<S>,
}

impl<T: Real, S: Space> Direct<'_, T, S> {
    /// Iterations on grid `level` at most.
    fn iterations_on(&self, level: usize) -> usize {
        if level == 0 {
            self.setup.iterations
        } else {
            coarse_iterations(level, self.threads.len() - 1, self.setup.coarse_iterations)
        }
    }

    /// What an iteration on grid `level` must gain, in parts of the objective.
    fn tolerance_on(&self, level: usize) -> f64 {
        let tolerance = self.setup.tolerance;
        if level == 0 {
            tolerance
        } else {
            COARSE_TOLERANCE * tolerance
        }
    }
}

impl<'m, T: Real, S: Space> Contract<'m, T, S> for Direct<'m, T, S> {
    #[inline(never)]
    fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let setup = Setup::new(problem, params);
        let sweep = &setup.flow.sweep;
        let animation = Animation::new(&setup.grid, sweep);
        Self {
            threads: Threads::new(&animation.levels, &setup),
            animation,
            rest: &mut [],
            pivots: &mut [],
            level: None,
            // A device computes in single precision.
            goes_there: T::BYTES == size_of::<f32>() && room::room(problem, params).is_ok(),
            there: None,
            descent: Descent::new(setup.history),
            iteration: 0,
            setup,
            space: PhantomData,
        }
    }

    /// As many pairs as are asked for, or as many as the ceiling allows on one thread, so that results do not depend on threads. Two
    /// threads overlap different tasks where the ceiling allows the memory for that too.
    ///
    /// Ranks take the same pairs whatever their memory: as many as are asked for, or as one program takes where it has enough.
    fn fit(problem: &Problem<'_>, params: &Params, measure: &Measure<'_>) -> Result<Params, PlanError> {
        let with = |history: usize, overlap: bool, threads: usize| {
            let direct = DirectParams {
                history: Some(history),
                overlap: Some(overlap),
                ..params.direct
            };
            Params {
                direct,
                threads,
                ..*params
            }
        };
        let alone = |pairs: usize| fits(&with(pairs, false, 1), measure);
        if problem.is_shared() {
            let pairs = params.direct.history.unwrap_or(DirectParams::MOST_BY_DEFAULT);
            return Ok(with(pairs, false, params.threads));
        }
        let pairs = pairs_that_fit(params.direct.history, DirectParams::MOST_BY_DEFAULT, alone)?;
        let overlapped = with(pairs, true, params.threads);
        if params.direct.overlap != Some(false) && fits(&overlapped, measure)? {
            Ok(overlapped)
        } else {
            Ok(with(pairs, false, params.threads))
        }
    }

    fn reach(_: &Params) -> Option<usize> {
        Some(REACH)
    }

    fn most_iterations(problem: &Problem<'_>, params: &Params) -> usize {
        params.direct.most_iterations(problem, params.iterations)
    }

    fn mix(params: &Params, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let DirectParams {
            history,
            history_precision,
            tolerance,
            nested,
            coarse_iterations,
            coarse_force_weight,
            overlap: _,
        } = params.direct;
        mix.word(history.unwrap_or(DirectParams::MOST_BY_DEFAULT) as u64);
        mix.word(history_precision as u64);
        mix.real(tolerance);
        mix.word(u64::from(nested));
        mix.word(coarse_iterations.map_or(0, |most| most as u64));
        mix.real(coarse_force_weight);
    }

    fn animation(&self) -> &Animation<'m, T> {
        &self.animation
    }

    fn parts(&mut self) -> Parts<'_, 'm, T> {
        Parts {
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
            region: self.rest,
        }
    }

    fn idle_parts(&mut self) -> Parts<'_, 'm, T> {
        let (slots, history) = (self.animation.slots, self.setup.history);
        Parts {
            region: quasi_newton::fields::behind(&self.setup.grid, slots, history, self.rest),
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
        }
    }

    fn spent(&mut self) -> Option<(Parts<'_, 'm, T>, Vector<'_, T>)> {
        let (slots, history) = (self.animation.slots, self.setup.history);
        let which = (history, self.descent.newton.direction);
        let (force, region) =
            quasi_newton::fields::view_and_behind(&self.setup.grid, slots, which, self.rest);
        let parts = Parts {
            region,
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
        };
        Some((parts, force))
    }

    fn begin_at(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> bool {
        self.begin_on_finest(exec, script)
    }

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let Self {
            animation,
            rest,
            pivots,
            setup,
            threads,
            level,
            ..
        } = self;
        // A grid that a rank has all of may have more rows than its part of the finest.
        let rows = animation.levels.grids.iter().take(threads.len()).map(Grid::rows);
        let sums = setup.history.sums_per_row() * rows.max().unwrap_or(0);
        animation.layout(layout, sums)?;
        layout.work("pivots in time", pivots, animation.slots)?;
        let levels = &animation.levels;
        let (len, level) = (kept::len(levels, setup, threads.len() - 1), *level);
        let show = |rest: &mut [T], visit: &mut dyn Visit<T>| {
            // Before the first iteration nothing is there.
            if let Some(level) = level {
                kept::show(levels, setup, level, rest, visit);
            }
        };
        layout.in_turn_with(rest, (len, show), |ledger| {
            let finest = setup.flow.sweep.threads;
            Sizes::<T>::measure(levels, setup, 0, finest, ledger);
            if threads.len() > 1 {
                let coarser = coarser(levels, setup, threads.len(), 0);
                ledger.line("coarser grids before", coarser, T::BYTES);
            }
            animation.measure_initial(finest, ledger);
        })
    }

    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut level, mut descent) = (self.level, self.descent.clone());
        let mut iteration = self.iteration;
        let coarsest = self.threads.len() - 1;
        record.option(&mut level, |record, level| record.count(level, coarsest))?;
        record.count(&mut iteration, MANY)?;
        descent.record(record)?;
        if record.is_read() {
            self.there = None;
        }
        (self.level, self.descent, self.iteration) = (level, descent, iteration);
        Ok(())
    }

    fn fetch(&mut self, exec: &dyn Exec, script: &Script<'_, T>, all: bool) {
        self.fetch_flow(exec, script);
        if all {
            self.fetch_fields(exec, script);
        }
    }

    /// One iteration, on the grid that the solve has come to.
    fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        let level = match self.level {
            Some(level) => level,
            None => self.begin(exec, script),
        };
        self.iteration += 1;
        progress.begin(self.iteration, observer)?;
        let outcome = self.descend(exec, observer, script, progress)?;
        match outcome {
            Outcome::Goes if self.descent.iterations < self.iterations_on(level) => Ok(()),
            _ if level > 0 => self.ascend(exec, observer, script),
            ended => Err(ended.status()),
        }
    }

    fn finish(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> Result<Objective, Status> {
        self.make_feasible(exec, script)
    }

    fn force(&self) -> Vector<'_, T> {
        let Animation { levels, slots, .. } = &self.animation;
        quasi_newton::fields::view(&levels.finest, *slots, self.descent.newton.direction, self.rest)
    }
}
