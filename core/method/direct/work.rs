//! One grid of the nested iteration, to iterate on.

use super::Direct;
use super::level::{LevelMut, down};
use super::setup::{slots_on, stride, sweep_setup, weights};
use crate::field::trajectory::Shape;
use crate::field::{VectorMut, reborrow};
use crate::force::time_line::{TimeLine, drag};
use crate::grid::Space;
use crate::grid::levels::Levels;
use crate::memory::Pool;
use crate::method::animation::Animation;
use crate::objective::flow::{self, Evaluation};
use crate::objective::script::Script;
use crate::optimise::line_search::SMALLEST_STEP;
use crate::optimise::quasi_newton;
use crate::optimise::quasi_newton::fields::Fields;
use crate::real::Real;
use crate::transport::MAX_SUBSTEPS;

/// max |d| of a direction above which the shortest step along it is faster than transport can follow on any grid, whose cells are at most a
/// quarter of the box: to move there and back would only cost the flow its digits.
const FASTEST: f64 = MAX_SUBSTEPS as f64 / SMALLEST_STEP;

/// Whether a direction is of use, of which so much divergence is left and which is so fast.
pub(super) fn is_usable([divergence, speed]: [f64; 2]) -> bool {
    divergence.is_finite() && speed <= FASTEST
}

/// One grid with all that an iteration on it uses.
pub(super) struct Work<'a, 'm, T> {
    pub evaluation: Evaluation<'a, 'm, T>,
    pub v: VectorMut<'a, T>,
    pub fields: Fields<'a, T>,
    pub line: TimeLine<'a>,
}

impl<'a, T: Real> Work<'a, '_, T> {
    /// Where its trajectories live.
    pub fn shape(&self) -> Shape<'a> {
        self.evaluation.shape()
    }
}

impl<'m, T: Real, S: Space> Direct<'m, T, S> {
    /// The hierarchy, and the finest grid with everything else in its rest.
    pub(super) fn finest<'a>(&'a mut self, script: &Script<'a, T>) -> (&'a Levels<'m, T>, LevelMut<'a, T>) {
        let script = *script;
        let Animation {
            levels,
            initial,
            rho,
            v,
            ..
        } = &mut self.animation;
        let at = LevelMut {
            initial: reborrow(initial),
            rho,
            v: reborrow(v),
            script,
            rest: self.rest,
        };
        (levels, at)
    }

    /// Grid `level`, to iterate on.
    pub(super) fn work<'a>(&'a mut self, level: usize, script: &Script<'a, T>) -> Work<'a, 'm, T> {
        let (count, threads) = (self.threads.len(), self.threads.on(level));
        let Self {
            animation,
            rest,
            pivots,
            setup,
            ..
        } = self;
        let Animation {
            levels,
            v,
            initial,
            rho,
            sums,
            ..
        } = animation;
        let finest = LevelMut {
            initial: reborrow(initial),
            rho,
            v: reborrow(v),
            script: *script,
            rest,
        };
        let LevelMut {
            initial: [x, y, z],
            rho,
            v,
            script,
            rest,
        } = down(levels, setup, finest, level);
        let (grid, slots) = (&levels.grids[level], slots_on(setup, level));
        let mut pool = Pool::new(rest);
        let fields = quasi_newton::fields::take(grid, slots, setup.history, &mut pool);
        let [stiffness, viscosity, force_weight] = weights(setup, level);
        let s = f64::from(stride(setup, level));
        let flow = flow::Setup {
            sweep: sweep_setup(setup, level, count, threads),
            viscosity,
            force_weight,
            buoyancy: setup.flow.buoyancy.map(|b| b * s * s),
            ..setup.flow
        };
        let [priced, divided] = flow::priced(grid, &flow, &mut pool);
        let evaluation = Evaluation {
            levels,
            level,
            setup: flow,
            priced,
            divided,
            initial: [&*x, &*y, &*z],
            rho,
            script,
            region: pool.into_rest(),
            sums,
        };
        let line = TimeLine::new(
            stiffness / force_weight,
            drag(grid, viscosity),
            &mut pivots[..slots],
        );
        Work {
            evaluation,
            v,
            fields,
            line,
        }
    }
}
