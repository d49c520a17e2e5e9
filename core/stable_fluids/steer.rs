//! The search, and its objective and gradient at given unknowns.

use super::{Controls, Fluids, Search, Slots};
use crate::exec::Exec;
use crate::grid::Space;
use crate::observe::Observer;
use crate::optimise::descent::Descent;
use crate::optimise::quasi_newton::history::History;
use crate::progress::{Fact, Kind, Objective, Progress, Status};
use crate::real::Real;
use crate::transport::Stop;

const REPEATED: Fact = Fact::new(
    "recomputed_steps",
    Kind::Count,
    "steps that the gradient repeated, beside those that were run once more to be taken back",
);

impl<T: Real, S: Space> Fluids<'_, T, S> {
    /// Sets the unknowns to where a search begins: 0, and the amplitudes of templates as they are given.
    fn begin(&mut self) {
        if !self.begun {
            let search = self.search();
            search.z.fill(T::ZERO);
            for placed in search.given.unknowns.placed(search.given.templates) {
                if search.given.unknowns.controls.has(super::Control::Templates) {
                    placed.begin(search.z);
                }
            }
            self.begun = true;
        }
    }

    /// The unknowns z, of which the velocity at the start comes first, component after component, then forces step after step, then the
    /// numbers of each template.
    #[must_use]
    pub fn unknowns(&mut self) -> &[T] {
        self.begin();
        self.z.get(..self.unknowns.total()).unwrap_or_default()
    }

    /// Goes to other unknowns; a search begins anew there.
    pub fn unknowns_mut(&mut self) -> &mut [T] {
        self.begin();
        self.taped = false;
        self.descent = Descent::new(History::full(self.params.history));
        self.z.get_mut(..self.unknowns.total()).unwrap_or_default()
    }

    /// J at the unknowns.
    ///
    /// # Errors
    /// [`Stop`]: cancelled.
    pub fn value(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<Objective, Stop> {
        self.begin();
        let mut search = self.search();
        let value = search.value(exec, observer);
        let taped = search.kept.taped;
        self.taped = taped;
        value
    }

    /// The gradient of J by the unknowns, of which there must be as many in `out`; steps that were repeated.
    ///
    /// # Errors
    /// [`Stop`]: cancelled.
    pub fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        out: &mut [T],
    ) -> Result<usize, Stop> {
        self.begin();
        let mut search = self.search();
        search.gradient(exec, observer, out)?;
        Ok(search.kept.repeated)
    }

    /// One iteration of L-BFGS.
    pub fn step(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Progress {
        let mut progress = Progress {
            cells: self.flow.cells.n,
            objective: self.objective,
            ..Progress::default()
        };
        let searches = self.params.controls != Controls::none() && self.params.slots != Slots::None;
        if !self.is_ready() || !searches {
            progress.status = Some(Status::NotReady);
            return progress;
        }
        self.begin();
        self.iteration += 1;
        let ended = match progress.begin(self.iteration, observer) {
            Ok(()) => self.descend(exec, observer, &mut progress),
            Err(status) => Err(status),
        };
        progress.status = ended.err();
        progress
    }

    fn descend(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        let descent = core::mem::replace(
            &mut self.descent,
            Descent::new(History::full(self.params.history)),
        );
        let (tolerance, most) = (self.params.tolerance, self.params.iterations);
        let mut search = self.search();
        let stepped = descent.step::<T, S>(exec, observer, &mut search, tolerance, progress);
        let Search { kept, .. } = search;
        let (taped, repeated) = (kept.taped, kept.repeated);
        (self.taped, self.repeated) = (taped, repeated);
        let (descent, outcome) = stepped?;
        self.objective = progress.objective;
        progress.report.tell(REPEATED, &[self.repeated as f64]);
        self.descent = descent;
        self.descent.goes_on(outcome, most)
    }

    /// Iterates until the search ends. `each` hears of every iteration.
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
                return status;
            }
        }
    }

    /// The objective after the last iteration.
    #[must_use]
    pub fn objective(&self) -> Objective {
        self.objective
    }
}
