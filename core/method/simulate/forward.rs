//! The flow simulated forwards: free, with buoyancy perhaps, or driven from keyframe to keyframe. One pass is the whole solve.
//!
//! For k = 1 .. N-1: carry rho_{k-1} by v_{k-1}, take a force from rho_k, solve v_k - a v_{k-1} + Adv(v_k) + grad p = force with
//! a = 1, or less where momentum is attenuated. The forces of the result are what makes the equation hold with a = 1, so that it
//! is a result like any other; only gathered densities are not those that the flow alone would carry.

use super::drive::Drive;
use super::guide::Guide;
use super::setup::{Push, Setup};
use super::step::Step;
use crate::checkpoint::{Damaged, Mix, Record};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, view};
use crate::grid::Space;
use crate::memory::part::REACH;
use crate::memory::{Layout, Pool, Sharing, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::{Contract, Followed, Parts};
use crate::method::params::{Method, Params};
use crate::objective::flow::{self, Evaluation};
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::problem::{Feature, Problem};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use core::marker::PhantomData;

/// The state of a simulation.
#[derive(Debug)]
pub struct Simulation<'m, T, S> {
    pub(super) animation: Animation<'m, T>,
    /// The forces.
    pub(super) w: VectorMut<'m, T>,
    pub(super) region: &'m mut [T],
    pub(super) setup: Setup,
    /// How far the steps were simulated: a flow that is guided by another takes its place on the way.
    pub(super) marched: Followed,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Contract<'m, T, S> for Simulation<'m, T, S> {
    #[inline(never)]
    fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let setup = Setup::new(problem, params);
        let sweep = &setup.flow.sweep;
        Self {
            animation: Animation::new(&setup.grid, sweep),
            w: Default::default(),
            region: &mut [],
            setup,
            marched: Followed::Not,
            space: PhantomData,
        }
    }

    fn steers(params: &Params) -> bool {
        params.method == Method::Pd
    }

    /// Smoke that is driven is not driven by templates too, and guidance knows the eigenvectors of closed boxes alone.
    fn takes(params: &Params, feature: Feature) -> bool {
        match feature {
            Feature::Templates => params.method != Method::Pd,
            Feature::Open => params.method != Method::Guide,
            _ => true,
        }
    }

    fn follows(params: &Params) -> bool {
        params.method == Method::Guide
    }

    fn simulates() -> bool {
        true
    }

    /// One pass is all there is.
    fn most_iterations(_: &Problem<'_>, _: &Params) -> usize {
        1
    }

    /// What pushes smoke to a keyframe, and guidance, read further than ranks have copies.
    fn reach(params: &Params) -> Option<usize> {
        (params.method == Method::Simulate).then_some(REACH)
    }

    fn mix(params: &Params, mix: &mut Mix) {
        match params.method {
            Method::Pd => params.pd.mix(mix),
            Method::Guide => params.guide.mix(mix),
            _ => {}
        }
        params.simulation.mix(mix);
    }

    fn animation(&self) -> &Animation<'m, T> {
        &self.animation
    }

    fn parts(&mut self) -> Parts<'_, 'm, T> {
        Parts {
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
            region: self.region,
        }
    }

    fn spent(&mut self) -> Option<(Parts<'_, 'm, T>, Vector<'_, T>)> {
        let parts = Parts {
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
            region: self.region,
        };
        Some((parts, view(&self.w)))
    }

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let Self {
            animation,
            w,
            region,
            setup,
            ..
        } = self;
        animation.layout(layout, 2 * setup.grid.rows())?;
        let grid = &setup.grid;
        layout.keep_vector("force", w, (S::DIM, grid.cells() * animation.slots), grid.parts())?;
        layout.in_turn(region, 0, |ledger| {
            let (levels, sweep) = (&animation.levels, &setup.flow.sweep);
            let mut pool = Pool::measuring(ledger);
            if setup.flow.weighs() {
                pool.group("price and evaluation", Sharing::Together, |pool| {
                    flow::priced(&levels.finest, &setup.flow, pool);
                    Evaluation::measure(levels, 0, sweep, pool);
                });
            } else {
                Evaluation::measure(levels, 0, sweep, &mut pool);
            }
            match setup.guide() {
                Some(guide) => pool.group("guided step", Sharing::Together, |pool| {
                    Step::carve(levels, 0, setup.step(), pool);
                    Guide::carve(levels, guide, sweep.threads, pool);
                }),
                None => {
                    Step::carve(levels, 0, setup.step(), &mut pool);
                }
            }
            if let Push::Target(_) = setup.push {
                Drive::carve(levels, sweep.metric, sweep.threads, &mut pool);
            }
            animation.measure_initial(sweep.threads, ledger);
        })
    }

    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        self.marched.pass(record)
    }

    fn followed(&mut self) -> Option<&mut Followed> {
        let follows = self.setup.guide().is_some();
        follows.then_some(&mut self.marched)
    }

    /// The whole pass: one iteration is all.
    fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        progress.iteration = 1;
        if self.marched == Followed::Whole && self.setup.guide().is_some() {
            // The given flow is no more.
            return Err(Status::Converged);
        }
        self.march(exec, observer, script)?;
        progress.objective = self.make_feasible(exec, script)?;
        Err(Status::Converged)
    }

    fn finish(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> Result<Objective, Status> {
        self.make_feasible(exec, script)
    }

    fn force(&self) -> Vector<'_, T> {
        view(&self.w)
    }
}
