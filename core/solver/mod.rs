//! The front door: how many bytes a solve needs, and a solver that lives in them.

mod block;
mod errors;
mod fingerprint;
mod follow;
mod inputs;
mod keyframes;
mod layout;
mod plan;
mod reference;
mod refined;
mod release;
mod results;
mod saved;
mod script;
mod shared;
mod smoke;
mod templates;
mod window;

pub use crate::checkpoint::SavedError;
pub use crate::method::params::{MAX_ITERATIONS, MAX_THREADS, Method, Params};
pub use crate::method::refusal::PlanError;
pub(crate) use block::block;
pub use errors::{InputError, SolverError};
pub(crate) use fingerprint::of_problem;
pub(crate) use inputs::{check as check_density, check_solids};
pub use layout::Strided;
pub(crate) use layout::{FileLayout, finite, put_solids};
pub use plan::{Plan, room};
pub use reference::Elsewhere;
pub use refined::{MAX_DOUBLINGS, Refined, Refinement};
pub(crate) use script::carve as carve_script;

use crate::exec::Exec;
use crate::field::borders;
use crate::grid::{Grid, Space};
use crate::memory::{Layout, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::Followed;
use crate::method::registry::{self, Engine};
use crate::objective::script::{Lists, Script};
use crate::observe::Observer;
use crate::problem::{Problem, Units};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use core::mem::MaybeUninit;
use fingerprint::fingerprint;
use release::Release;
use shared::{Heard, Shared, Verb};

/// A solve in one block of memory.
#[derive(Debug)]
pub struct Solver<'m, T, S> {
    engine: Engine<'m, T, S>,
    release: Option<Release<'m, T, S>>,
    /// N.
    steps: usize,
    lists: Lists<'m>,
    /// The fields of the script.
    fields: &'m mut [T],
    units: Units,
    match_mass: bool,
    mass: f64,
    missing: usize,
    /// Whether a flow was given to follow, where the method follows one.
    reference: Option<bool>,
    prepared: Option<f64>,
    objective: Objective,
    finished: bool,
    fingerprint: u64,
    /// What the solid cells add to it.
    solid_print: u64,
    saved_bytes: usize,
    shared: Shared<'m, T>,
}

impl<'m, T: Real, S: Space> Solver<'m, T, S> {
    /// Carves `memory`, of at least [`Plan::bytes`]; nothing is allocated afterwards.
    ///
    /// # Errors
    /// [`SolverError`].
    pub fn new(
        problem: &Problem<'_>,
        params: &Params,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, SolverError> {
        let plan = Plan::new::<T, S>(problem, params)?;
        let problem = &registry::resolved(problem, params);
        let given = memory.len();
        let mut arena = block(memory, plan.bytes())?;
        let short = |TooSmall { .. }: TooSmall| SolverError::TooSmall {
            needed: plan.bytes(),
            given,
        };
        let mut engine = Engine::new(&problem.controlled(), &plan.params);
        engine
            .get_mut()
            .layout(&mut Layout::carve(&mut arena))
            .map_err(short)?;
        let mut release = Release::new(problem, &plan.params);
        if let Some(release) = &mut release {
            release.layout(&mut Layout::carve(&mut arena)).map_err(short)?;
        }
        let (lists, fields) = script::carve(problem, &mut arena).map_err(short)?;
        let (piece, solid) = script::carve_shared(problem, &mut arena).map_err(short)?;
        debug_assert_eq!(arena.left(), 0, "planned and carved bytes differ");
        Ok(Self {
            engine,
            release,
            steps: problem.steps,
            lists,
            fields,
            units: problem.units(),
            match_mass: problem.match_mass,
            mass: 0.0,
            missing: problem.keyframes.len(),
            reference: registry::follows(params).then_some(false),
            prepared: None,
            objective: Objective::default(),
            finished: false,
            fingerprint: fingerprint::<T, S>(problem, &plan.params),
            solid_print: 0,
            saved_bytes: plan.saved_bytes(),
            shared: Shared {
                ranks: None,
                piece,
                solid,
            },
        })
    }

    fn animation(&self) -> &Animation<'m, T> {
        self.engine.get().animation()
    }

    fn grid(&self) -> &Grid {
        self.animation().grid()
    }

    /// Checks that all densities are there and projects v_0; by how much that changed it, relative to max |v_0|.
    ///
    /// # Errors
    /// [`InputError::NoSource`], [`InputError::NoEmitter`], [`InputError::NoKeyframe`], [`InputError::NoReference`].
    pub fn prepare(&mut self, exec: &dyn Exec) -> Result<f64, InputError> {
        self.shared.ask(Verb::Prepare, [0; 3]);
        self.prepared(exec)
    }

    fn prepared(&mut self, exec: &dyn Exec) -> Result<f64, InputError> {
        self.check_smoke()?;
        if self.missing > 0 {
            let unset = (0..self.lists.steps.len()).find(|&index| self.is_unset(index));
            return Err(InputError::NoKeyframe {
                index: unset.unwrap_or(0),
            });
        }
        let followed = self.engine.get_mut().followed().map(|followed| *followed);
        if self.reference == Some(false) || followed == Some(Followed::InPart) {
            return Err(InputError::NoReference);
        }
        Ok(match self.prepared {
            Some(change) => change,
            None => {
                let parts = self.engine.get_mut().parts();
                let Animation { levels, initial, .. } = &mut *parts.animation;
                borders::refresh_faces(exec, &levels.finest, initial);
                *self.prepared.insert(parts.project_initial(exec))
            }
        })
    }

    /// One outer iteration.
    pub fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        self.shared.ask(Verb::Step, [0; 3]);
        if self.prepared(exec).is_err() {
            return Progress {
                status: Some(Status::NotReady),
                ..Progress::default()
            };
        }
        let script = Script::new(self.lists, self.fields);
        self.finished = false;
        let mut progress = Progress::default();
        let ranks = self.shared.ranks;
        let observer = &mut Heard { observer, ranks };
        let ended = self.engine.get_mut().step(exec, observer, &script, &mut progress);
        progress.status = ended.err();
        progress
    }

    /// What was given is another: a result is none any more, nor is the flow to follow, where it was gone over.
    fn changed(&mut self) {
        self.finished = false;
        if let Some(followed) = self.engine.get_mut().followed()
            && core::mem::take(followed) != Followed::Not
        {
            self.reference = Some(false);
        }
    }

    /// Takes back the flow and its densities from the device of `exec`, if there is one and it searches: before they are read between two
    /// steps.
    pub fn fetch(&mut self, exec: &dyn Exec) {
        let script = Script::new(self.lists, self.fields);
        self.engine.get_mut().fetch(exec, &script, false);
    }

    /// As [`Self::fetch`], with all that a state has: before [`Self::save`], which otherwise saves what there was before the device began.
    pub fn fetch_all(&mut self, exec: &dyn Exec) {
        let script = Script::new(self.lists, self.fields);
        self.engine.get_mut().fetch(exec, &script, true);
    }

    /// Iterates to the end and makes the result feasible; `each` hears every iteration. Where the last step was not finite but a flow before
    /// it was, that is the result and the solve has stalled: see [`Status::of_result`].
    pub fn solve(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        each: &mut dyn FnMut(&Progress),
    ) -> Status {
        loop {
            let progress = self.step(exec, observer);
            each(&progress);
            if let Some(status) = progress.status {
                return if status == Status::NotReady {
                    status
                } else {
                    status.of_result(self.finish(exec).is_ok())
                };
            }
        }
    }

    /// Makes the result feasible (mathematics section 5): projects v, takes the force from it, transports rho_0 by it,
    /// and simulates what comes after the release.
    ///
    /// # Errors
    /// [`Status::NotFinite`] when a number is not finite or the flow is too fast to be transported.
    pub fn finish(&mut self, exec: &dyn Exec) -> Result<Objective, Status> {
        self.shared.ask(Verb::Finish, [0; 3]);
        let script = Script::new(self.lists, self.fields);
        self.finished = false;
        let method = self.engine.get_mut();
        self.objective = method.finish(exec, &script)?;
        if let Some(release) = &mut self.release {
            let largest = method.parts().setup.sweep.largest;
            release.follow(exec, method.animation(), largest, &script)?;
        }
        self.finished = true;
        Ok(self.objective)
    }

    /// Whether densities, velocities and forces are those of the last [`Self::finish`]: nothing was changed since.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.finished
    }

    /// The objective of the result, after [`Self::finish`].
    #[must_use]
    pub fn objective(&self) -> Objective {
        self.objective
    }
}
