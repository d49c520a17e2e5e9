//! The flow of a search under way, for its page: run once more, since none of its steps is held.

use crate::live::Played;
use crate::output::{Body, OutputError};
use crate::problem::OwnedProblem;
use core::ops::ControlFlow;
use std::collections::BTreeSet;
use thurible_core::stable_fluids::Moment;
use thurible_core::{Exec, Fluids, Real, Silent, Space};

/// A search between two iterations.
pub(super) struct Replayed<'a, 'm, T, S> {
    pub fluids: &'a mut Fluids<'m, T, S>,
    pub exec: &'a dyn Exec,
    pub problem: &'a OwnedProblem,
}

impl<T: Real, S: Space> Replayed<'_, '_, T, S> {
    /// Runs forward until `each` has seen enough.
    fn run(&mut self, each: &mut dyn FnMut(Moment<'_, '_, T>) -> ControlFlow<()>) {
        // It ends early where nothing more is to be seen.
        let _ = self.fluids.replay(self.exec, &mut Silent, each);
    }
}

impl<T: Real, S: Space> Played for Replayed<'_, '_, T, S> {
    fn cells(&self) -> Vec<usize> {
        self.problem.cells.clone()
    }

    fn keyframe_steps(&self) -> Vec<usize> {
        self.problem.keyframes.clone()
    }

    fn body(&mut self) -> Option<Body> {
        None
    }

    /// The largest density at the start, where there is always some.
    fn full(&mut self, _: usize) -> f32 {
        let mut full = 0.0;
        self.run(&mut |mut moment| {
            let densities = moment.density().iter();
            full = densities.map(|rho| rho.to_f64() as f32).fold(0.0, f32::max);
            ControlFlow::Break(())
        });
        full
    }

    fn play(
        &mut self,
        chosen: &BTreeSet<usize>,
        each: &mut dyn FnMut(usize, Vec<f32>) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        let (last, mut done) = (chosen.last().copied().unwrap_or(0), Ok(()));
        self.run(&mut |mut moment| {
            let step = moment.step;
            if chosen.contains(&step) {
                let densities = moment.density().iter();
                done = each(step, densities.map(|rho| rho.to_f64() as f32).collect());
            }
            if done.is_err() || step >= last {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        done
    }
}
