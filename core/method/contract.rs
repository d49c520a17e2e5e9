//! What a method is: the buffers that it needs, how it steps, what it gives and what it reports.
//!
//! [`Solver`](crate::Solver), plans, checkpoints, the C interface and every runner know methods by this contract alone. A method
//! that fulfils it joins them by one line in the registry (see [`super`]).

use super::animation::Animation;
use super::output::{CONTROLLED_FLOW, DENSITY, FORCE, Output, Stored, VELOCITY};
use super::params::Params;
use super::refusal::PlanError;
use crate::checkpoint::{Damaged, Mix, Record};
use crate::exec::Exec;
use crate::field::{Vector, rows, view};
use crate::grid::{Grid, Space};
use crate::memory::{Layout, Pool, TooSmall};
use crate::objective::flow;
use crate::objective::script::Script;
use crate::objective::sweep::DensitySweep;
use crate::observe::Observer;
use crate::problem::{Feature, Problem};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use crate::transport::Flow;

/// How far a method has gone over the flow that it follows, in whose place it puts what it finds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Followed {
    /// Not yet.
    #[default]
    Not,
    /// To the end.
    Whole,
    /// To a stop: what is there is a mixture.
    InPart,
}

impl Followed {
    /// Passes over it as a checkpoint keeps it.
    ///
    /// # Errors
    /// [`Damaged`].
    pub fn pass(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let all = [Self::Not, Self::Whole, Self::InPart];
        let mut number = all.iter().position(|one| one == self).unwrap_or(0);
        record.count(&mut number, all.len() - 1)?;
        *self = all.get(number).copied().unwrap_or_default();
        Ok(())
    }
}

/// A method with its state: how it solves one problem.
///
/// It is made without buffers. [`Self::layout`] then counts them, or carves them out of the block; nothing else is called before.
pub trait Contract<'m, T: Real, S: Space> {
    /// The method for `problem`, without its buffers.
    fn new(problem: &Problem<'_>, params: &Params) -> Self
    where
        Self: Sized;

    /// The choices that `params` come to within their ceiling: what the caller left open is chosen by what `measure` says of it.
    ///
    /// # Errors
    /// [`PlanError`].
    fn fit(problem: &Problem<'_>, params: &Params, measure: &Measure<'_>) -> Result<Params, PlanError>
    where
        Self: Sized,
    {
        let _ = (problem, measure);
        Ok(*params)
    }

    /// Whether it steers to keyframes, so that there must be some.
    fn steers(params: &Params) -> bool
    where
        Self: Sized,
    {
        let _ = params;
        true
    }

    /// Whether it can do what a problem may ask for: all but templates, where a method says nothing else.
    fn takes(params: &Params, feature: Feature) -> bool
    where
        Self: Sized,
    {
        let _ = params;
        feature != Feature::Templates
    }

    /// Whether it follows a flow that must be given, step by step, in the place of v.
    fn follows(params: &Params) -> bool
    where
        Self: Sized,
    {
        let _ = params;
        false
    }

    /// Whether it simulates the flow forwards, so that a flow too fast to follow ends what can be known of it.
    fn simulates() -> bool
    where
        Self: Sized,
    {
        false
    }

    /// Planes, or rows, beside its own that a rank needs copies of, or `None` where ranks cannot share it.
    fn reach(params: &Params) -> Option<usize>
    where
        Self: Sized,
    {
        let _ = params;
        None
    }

    /// Iterations at most, those on coarser grids included.
    fn most_iterations(problem: &Problem<'_>, params: &Params) -> usize
    where
        Self: Sized,
    {
        let _ = problem;
        params.iterations
    }

    /// Mixes in all choices that its results follow from, for the fingerprint of a checkpoint.
    fn mix(params: &Params, mix: &mut Mix)
    where
        Self: Sized;

    /// The animation that it works on.
    fn animation(&self) -> &Animation<'m, T>;

    /// The same, to write, with the scaled numbers of the problem and the elements that everything uses in turn.
    fn parts(&mut self) -> Parts<'_, 'm, T>;

    /// The same, where the elements are only those that hold nothing of the result, after [`Self::finish`].
    fn idle_parts(&mut self) -> Parts<'_, 'm, T> {
        self.parts()
    }

    /// Goes over every buffer, in the order of the block: name, place and length, and whether a checkpoint keeps it.
    ///
    /// # Errors
    /// [`TooSmall`].
    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall>;

    /// Passes over every scalar that a checkpoint keeps. All are read before any is changed.
    ///
    /// # Errors
    /// [`Damaged`] where one is out of its range.
    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged>;

    /// What became of the flow that it follows; `None` where it follows none.
    fn followed(&mut self) -> Option<&mut Followed> {
        None
    }

    /// Takes back what of its buffers a device has: the flow and its densities, or for a checkpoint all; nothing, where none has.
    fn fetch(&mut self, exec: &dyn Exec, script: &Script<'_, T>, all: bool) {
        let _ = (exec, script, all);
    }

    /// One outer iteration, told in `progress`.
    ///
    /// # Errors
    /// How the solve ended, when it did.
    fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status>;

    /// Makes the result feasible (mathematics section 5): v is projected, the forces are taken from it, and the densities carried by
    /// it; the objective of that.
    ///
    /// # Errors
    /// [`Status::NotFinite`].
    fn finish(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> Result<Objective, Status>;

    /// The forces u_0 .. u_{N-2} of the result, after [`Self::finish`]; empty where a method has none.
    fn force(&self) -> Vector<'_, T> {
        [&[]; 3]
    }

    /// The forces beside what [`Self::idle_parts`] gives; `None` where a method has none, or its work needs the elements that hold them.
    fn spent(&mut self) -> Option<(Parts<'_, 'm, T>, Vector<'_, T>)> {
        None
    }

    /// Begins the search at v as it stands in the animation, which is projected, instead of where the method begins by itself; whether it can.
    fn begin_at(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> bool {
        let _ = (exec, script);
        false
    }

    /// The unknowns of templates, where it searches for them: see [`Place`](super::templates::unknowns::Place).
    fn unknowns(&self) -> &[T] {
        &[]
    }

    /// What it gives, after [`Self::finish`]: the density among it, which keyframes and pictures are compared with.
    fn outputs(&self) -> &'static [Output] {
        CONTROLLED_FLOW
    }

    /// Where step `step` of an output of its own is, one that this contract does not know.
    fn own(&self, output: &Output, step: usize) -> Stored<'_, T> {
        let _ = (output, step);
        Stored::default()
    }

    /// Where step `step` of one of its outputs is.
    fn stored<'a>(&'a self, output: &Output, step: usize) -> Stored<'a, T>
    where
        'm: 'a,
    {
        let animation = self.animation();
        match *output {
            DENSITY => animation.density(step),
            VELOCITY => animation.velocity(step),
            FORCE => Stored {
                components: self.force(),
                slots: animation.slots,
                slot: step,
            },
            _ => self.own(output, step),
        }
    }
}

/// What choices come to in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Of the whole block.
    pub bytes: usize,
    /// Of the method alone, without keyframes.
    pub method: usize,
    /// The paper's bound for its method.
    pub paper_bound: usize,
}

/// Tells the size of choices.
pub type Measure<'a> = dyn Fn(&Params) -> Result<Size, PlanError> + 'a;

/// The most pairs of L-BFGS up to `asked`, or up to `by_default` where nothing is asked, with which `fits` is true. Fewer than were
/// asked for are never chosen; one is, whether it fits or not.
///
/// # Errors
/// Those of `fits`.
pub fn pairs_that_fit(
    asked: Option<usize>,
    by_default: usize,
    fits: impl Fn(usize) -> Result<bool, PlanError>,
) -> Result<usize, PlanError> {
    let mut pairs = asked.unwrap_or(by_default);
    while pairs > asked.unwrap_or(1) && !fits(pairs)? {
        pairs -= 1;
    }
    Ok(pairs)
}

/// Whether choices fit their ceiling.
///
/// # Errors
/// Those of `measure`.
pub fn fits(params: &Params, measure: &Measure<'_>) -> Result<bool, PlanError> {
    match params.ceiling {
        Some(ceiling) => measure(params).map(|size| size.bytes <= ceiling),
        None => Ok(true),
    }
}

/// The parts of a method that its host prepares a solve by.
pub struct Parts<'a, 'm, T> {
    /// Densities and velocities.
    pub animation: &'a mut Animation<'m, T>,
    /// The problem in scaled numbers; max rho_0 is set with the source.
    pub setup: &'a mut flow::Setup,
    /// Elements that everything uses in turn.
    pub region: &'a mut [T],
}

impl<T: Real> Parts<'_, '_, T> {
    /// Calls `take` with what emitters added after `step`, unless the flow was too fast to carry anything.
    pub fn emission(
        &mut self,
        exec: &dyn Exec,
        step: usize,
        script: &Script<'_, T>,
        take: &mut dyn FnMut(&Grid, &[T]),
    ) {
        let Animation {
            levels,
            rho,
            v,
            initial,
            sums,
            ..
        } = &mut *self.animation;
        let flow = Flow {
            initial: view(initial),
            v: view(v),
            along: None,
        };
        let cells = levels.finest.cells();
        let density = rows::part(rho, step * cells..(step + 1) * cells);
        let mut sweep = DensitySweep::carve(levels, 0, &self.setup.sweep, &mut Pool::new(self.region));
        if let Ok(added) = sweep.emission(exec, &flow, (step, density), script, sums) {
            take(&levels.finest, added);
        }
    }

    /// Projects v_0; the change relative to max |v_0|.
    pub fn project_initial(self, exec: &dyn Exec) -> f64 {
        self.animation.project_initial(exec, self.setup, self.region)
    }
}
