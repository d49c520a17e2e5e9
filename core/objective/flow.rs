//! The objective as a function of the flow (mathematics section 6): one sweep forward, one projection. Its gradient is in `gradient.rs`.

use crate::exec::{Exec, Serial, join};
use crate::field::{Vector, VectorMut, reborrow};
use crate::force;
use crate::force::lift::Lift;
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Pool, Sharing};
use crate::objective::script::Script;
use crate::objective::sweep::{self, DensitySweep};
use crate::observe::{Event, Observer, Silent};
use crate::operators::self_advection::Fluid;
use crate::poisson::Projection;
use crate::problem::Problem;
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::{Flow, Stop};

/// What does not change from flow to flow.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// Transport and metric.
    pub sweep: sweep::Setup,
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// r in scaled numbers.
    pub force_weight: f64,
    /// s^2 of the price of a force's curl, in box lengths squared.
    pub smoothing: f64,
    /// Whether the price of the force changes from step to step.
    pub scheduled: bool,
    /// Whether force may act only here and there.
    pub masked: bool,
    /// b in scaled numbers: the acceleration of buoyancy where the density is 1.
    pub buoyancy: [f64; 3],
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
}

/// F(v) = 1/2 <e, C e> + r/2 sum_k f_k <w_k(v), (1 + s^2 C^T C) w_k(v)> on one grid of a hierarchy; the second C^T C is that of curls.
pub struct Evaluation<'a, 'm, T> {
    /// The hierarchy.
    pub levels: &'a Levels<'m, T>,
    /// Number of the grid.
    pub level: usize,
    /// The weights.
    pub setup: Setup,
    /// v_0.
    pub initial: Vector<'a, T>,
    /// rho_0, and after [`Self::value`] rho_1 .. rho_N of that flow.
    pub rho: &'a mut [T],
    /// What is given for the steps.
    pub script: Script<'a, T>,
    /// z = f D (1 + s^2 C^T C) D w for the force of [`Self::value`], or empty where that is w: from [`priced`].
    pub priced: VectorMut<'a, T>,
    /// D w, or empty where there is no mask: from [`priced`] too.
    pub divided: VectorMut<'a, T>,
    /// What the parts of an evaluation use in turn.
    pub region: &'a mut [T],
    /// See [`History::sums_per_row`](crate::optimise::quasi_newton::history::History::sums_per_row).
    pub sums: &'a mut [f64],
}

impl Setup {
    /// That of `problem` on its own grid, for rho_0 of at most 1.
    #[must_use]
    pub fn new(problem: &Problem<'_>, threads: usize) -> Self {
        Self {
            sweep: sweep::Setup::new(problem, threads),
            viscosity: problem.scaled_viscosity(),
            force_weight: problem.scaled_force_weight(),
            smoothing: problem.scaled_smoothing(),
            scheduled: !problem.schedule.is_empty(),
            masked: problem.mask,
            buoyancy: problem.scaled_buoyancy(),
            projection_tolerance: problem.projection_tolerance,
        }
    }
}

impl Setup {
    /// Whether the price of a force is another than r/2 |w|^2.
    #[must_use]
    pub fn weighs(&self) -> bool {
        self.smoothing > 0.0 || self.scheduled || self.masked
    }

    /// A fluid in all slots of the finest grid.
    #[must_use]
    pub fn fluid<'a, T: Real>(&self, levels: &'a Levels<'_, T>) -> Fluid<'a> {
        Fluid {
            grid: &levels.finest,
            slots: self.sweep.slots,
            viscosity: self.viscosity,
            solids: levels.solids(0),
        }
    }

    /// Buoyancy on the finest grid.
    #[must_use]
    pub fn lift<'a, T: Real>(&self, levels: &'a Levels<'_, T>) -> Lift<'a> {
        Lift {
            grid: &levels.finest,
            slots: self.sweep.slots,
            solids: levels.solids(0),
            acceleration: self.buoyancy,
        }
    }

    /// Whether the densities push the flow.
    #[must_use]
    pub fn lifts(&self) -> bool {
        self.buoyancy != [0.0; 3]
    }
}

/// Takes what [`Evaluation::priced`] and [`Evaluation::divided`] need.
pub fn priced<'a, T: Real>(grid: &Grid, setup: &Setup, pool: &mut Pool<'a, T>) -> [VectorMut<'a, T>; 2] {
    let fields = [
        (setup.weighs(), "force times its price"),
        (setup.masked, "force divided by its mask"),
    ];
    let len = grid.cells() * setup.sweep.slots;
    fields.map(|(there, name)| match there {
        true => pool.take_vector(name, grid.dims, len),
        false => Default::default(),
    })
}

impl<T: Real> Evaluation<'_, '_, T> {
    /// What an evaluation on grid `level` takes of a region beside [`priced`], for a pool that measures.
    pub fn measure<'l>(
        levels: &'l Levels<'_, T>,
        level: usize,
        setup: &sweep::Setup,
        pool: &mut Pool<'l, T>,
    ) {
        let grid = &levels.grids[level];
        let rows = setup.threads * force::scratch_per_thread(grid, setup.slots);
        let force = |pool: &mut Pool<'l, T>| {
            Projection::carve(levels, level, setup.slots, setup.threads, pool);
            pool.take("force: rows of a block", rows);
        };
        let overlaps = setup.overlaps(grid);
        let sharing = if overlaps {
            Sharing::Together
        } else {
            Sharing::InTurn
        };
        pool.group("evaluation", sharing, |pool| {
            DensitySweep::carve(levels, level, setup, pool);
            if overlaps {
                pool.group("force and projection", Sharing::InTurn, force);
            } else {
                force(pool);
            }
        });
    }

    /// F(v), with rho carried by v and its force in `w`; without the force where the data term alone is above `bound`.
    ///
    /// # Errors
    /// [`Stop`].
    pub fn value<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        w: &mut VectorMut<'_, T>,
        bound: f64,
    ) -> Result<Objective, Stop> {
        let grid = self.levels.grids.get(self.level);
        // Buoyancy needs the densities before the force.
        if grid.is_some_and(|grid| self.setup.sweep.overlaps(grid)) && !self.setup.lifts() {
            return self.value_in_overlap::<S>(exec, observer, v, w, bound);
        }
        let flow = Flow {
            initial: self.initial,
            v,
            along: None,
        };
        let mut pool = Pool::new(&mut *self.region);
        let mut sweep = DensitySweep::carve(self.levels, self.level, &self.setup.sweep, &mut pool);
        let data = sweep.carry(exec, observer, &flow, self.rho, &self.script, self.sums)?;
        let force = if data > bound {
            Objective::default()
        } else {
            self.force::<S>(exec, observer, v, w)?
        };
        Ok(Objective { data, ..force })
    }

    /// [`Self::value`] by two threads: one carries the density while the other projects the force.
    fn value_in_overlap<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        w: &mut VectorMut<'_, T>,
        bound: f64,
    ) -> Result<Objective, Stop> {
        let flow = Flow {
            initial: self.initial,
            v,
            along: None,
        };
        let mut pool = Pool::new(&mut *self.region);
        let mut sweep = DensitySweep::carve(self.levels, self.level, &self.setup.sweep, &mut pool);
        let Self {
            levels,
            level,
            setup,
            initial,
            ref mut rho,
            script,
            ref mut sums,
            ref mut priced,
            ref mut divided,
            ..
        } = *self;
        let (of_data, of_force) = sums
            .split_at_mut_checked(sweep.grid().rows())
            .unwrap_or((&mut [], &mut []));
        let mut rest = Evaluation {
            levels,
            level,
            setup,
            initial,
            rho: &mut [],
            script,
            priced: reborrow(priced),
            divided: reborrow(divided),
            region: pool.into_rest(),
            sums: of_force,
        };
        let (mut data, mut force) = (Ok(0.0), Ok(Objective::default()));
        let mut carry = || data = sweep.carry(&Serial, &mut Silent, &flow, rho, &script, of_data);
        // Together, so that what is left of the force takes about as long as the density.
        rest.acceleration::<S>(exec, v, w);
        join(exec, &mut carry, &mut || {
            force = rest.projected::<S>(&Serial, &mut Silent, w)
        });
        if observer.on(Event::Work).is_break() {
            return Err(Stop::Cancelled);
        }
        let data = data?;
        let force = if data > bound {
            Objective::default()
        } else {
            force?
        };
        Ok(Objective { data, ..force })
    }

    /// The data term of densities that were carried already, of the keyframes at `last` or before.
    pub fn data(&mut self, exec: &dyn Exec, last: usize) -> f64 {
        let mut pool = Pool::new(&mut *self.region);
        let mut sweep = DensitySweep::carve(self.levels, self.level, &self.setup.sweep, &mut pool);
        sweep.data(exec, self.rho, &self.script, last, self.sums)
    }
}
