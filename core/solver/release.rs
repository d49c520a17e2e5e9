//! The flow after the release: simulated on from where the controlled part ends, without force.

use crate::exec::Exec;
use crate::field::rows;
use crate::field::slot::{self, Slot};
use crate::field::view;
use crate::grid::{Grid, Space};
use crate::memory::{Layout, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::Contract;
use crate::method::output::{Output, Stored};
use crate::method::params::{Method, Params};
use crate::method::simulate::forward::Simulation;
use crate::objective::script::Script;
use crate::observe::Silent;
use crate::problem::Problem;
use crate::progress::{Progress, Status};
use crate::real::Real;

/// The simulation from step R - 1 on, where R is the release: its step 1 is R, whose velocity no force has turned.
#[derive(Debug)]
pub(super) struct Release<'m, T, S> {
    /// R - 1.
    before: usize,
    tail: Simulation<'m, T, S>,
}

impl<'m, T: Real, S: Space> Release<'m, T, S> {
    /// That of `problem`, if it is released, without its buffers.
    #[inline(never)]
    pub fn new(problem: &Problem<'_>, params: &Params) -> Option<Self> {
        let before = problem.release? - 1;
        let after = Problem {
            steps: problem.steps - before,
            keyframes: &[],
            keyframe_weights: &[],
            templates: &[],
            release: None,
            schedule: &[],
            mask: false,
            smoothness: Some(0.0),
            ..*problem
        };
        let params = Params {
            method: Method::Simulate,
            ..*params
        };
        Some(Self {
            before,
            tail: Simulation::new(&after, &params),
        })
    }

    /// Its buffers.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        self.tail.layout(layout)
    }

    /// Simulates on from the last step of `controlled`.
    ///
    /// # Errors
    /// [`Status::NotFinite`] where the flow becomes too fast.
    pub fn follow(
        &mut self,
        exec: &dyn Exec,
        controlled: &Animation<'_, T>,
        largest: f64,
        script: &Script<'_, T>,
    ) -> Result<(), Status> {
        let (grid, before) = (controlled.grid(), self.before);
        self.take_box(controlled, largest);
        let Animation { rho, initial, .. } = self.tail.parts().animation;
        rows::part_mut(rho, 0..grid.cells()).copy_from_slice(controlled.density(before).components[0]);
        let last = Slot::at(
            before,
            view(&controlled.initial),
            view(&controlled.v),
            controlled.slots,
        );
        slot::combine(exec, grid, [(1.0, last)], initial);
        let script = script.after(before, grid.cells());
        match self
            .tail
            .step(exec, &mut Silent, &script, &mut Progress::default())
        {
            Ok(()) | Err(Status::Converged) => {
                self.tail.forget_forces();
                Ok(())
            }
            Err(status) => Err(status),
        }
    }

    /// Takes the solid cells of the controlled part, and the largest density that there may be: neither is kept in a state.
    fn take_box(&mut self, controlled: &Animation<'_, T>, largest: f64) {
        let parts = self.tail.parts();
        parts.setup.sweep.largest = largest;
        parts.animation.levels.take_solids(&controlled.levels, 0);
    }

    /// What emitters added after `step` of the whole.
    pub fn emission(
        &mut self,
        exec: &dyn Exec,
        (controlled, largest): (&Animation<'_, T>, f64),
        step: usize,
        script: &Script<'_, T>,
        take: &mut dyn FnMut(&Grid, &[T]),
    ) {
        self.take_box(controlled, largest);
        let (before, mut parts) = (self.before, self.tail.parts());
        let script = script.after(before, parts.animation.grid().cells());
        parts.emission(exec, step - before, &script, take);
    }

    /// Where step `step` of an output is, of which `controlled` steps are in the controlled part; `None` if that has it, or if a simulation
    /// has no such output.
    pub fn stored(&self, output: &Output, step: usize, controlled: usize) -> Option<Stored<'_, T>> {
        let here = step >= controlled && self.tail.outputs().contains(output);
        here.then(|| self.tail.stored(output, step - self.before))
    }
}
