//! What an outer iteration reports, and how a solve ends: data, not errors.

use crate::checkpoint::{Damaged, Record};
use crate::observe::{Event, Observer};
use crate::words::named;

/// Most cycles of one Navier-Stokes problem whose residuals are reported, the first residual included.
pub const MAX_CYCLES: usize = 64;
/// Most iterations of one advection problem whose residuals are reported.
pub const MAX_RESIDUALS: usize = 16;

/// Data and force terms of the objective J (paper eq. 5).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Objective {
    /// 1/2 sum over keyframes of <e, C e>.
    pub data: f64,
    /// r/2 sum of <u, (1 + s^2 C^T C) u>, the price of the force and of its curl.
    pub force: f64,
    /// r/2 sum of |u|^2, which is `force` where s is 0.
    pub plain: f64,
    /// r_v/2 |v_0|^2, where a method searches for the velocity at the start; 0 elsewhere.
    pub initial: f64,
}

impl Objective {
    /// That of a data term alone.
    #[must_use]
    pub fn of_data(data: f64) -> Self {
        Self {
            data,
            ..Self::default()
        }
    }

    /// That of a force alone.
    #[must_use]
    pub fn of_force(force: f64, plain: f64) -> Self {
        Self {
            force,
            plain,
            ..Self::default()
        }
    }

    /// All terms in a checkpoint.
    ///
    /// # Errors
    /// [`Damaged`].
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        record.real(&mut self.data)?;
        record.real(&mut self.force)?;
        record.real(&mut self.plain)?;
        record.real(&mut self.initial)
    }

    /// J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.data + self.force + self.initial
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The method's own rule says so.
    Converged,
    /// The iterations were used up.
    MaxIterations,
    /// It no longer moves, but does not satisfy the rule of convergence.
    Stalled,
    /// Of a step: nothing that it tries is finite, or slow enough to be transported; what
    /// [`Solver::finish`](crate::Solver::finish) gives is the last flow that was. Of a solve: there is no such flow.
    NotFinite,
    /// The observer said stop.
    Cancelled,
    /// The source or a keyframe is missing.
    NotReady,
}

named!(Status {
    Converged = "converged",
    MaxIterations = "max_iterations",
    Stalled = "stalled",
    NotFinite = "not_finite",
    Cancelled = "cancelled",
    NotReady = "not_ready",
});

impl Status {
    /// How a solve ended whose last step ended so, where its result could be made feasible or not.
    #[must_use]
    pub fn of_result(self, feasible: bool) -> Self {
        match self {
            _ if !feasible => Self::NotFinite,
            Self::NotFinite => Self::Stalled,
            status => status,
        }
    }
}

/// Whether a fact is a number, a count, yes or no, or a series of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Number,
    /// A whole number from 0.
    Count,
    /// 1 for yes, 0 for no.
    Flag,
    /// Any number of numbers, in order.
    Series,
}

/// Something that a method reports of every iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fact {
    /// Its key in reports: lower case, with underscores.
    pub name: &'static str,
    /// What it is, in a few words.
    pub words: &'static str,
    /// What its values are.
    pub kind: Kind,
    /// The chart that it is drawn in, together with the other facts of that chart; none where it is `None`.
    pub chart: Option<&'static str>,
}

impl Fact {
    /// A fact that is drawn in no chart.
    #[must_use]
    pub const fn new(name: &'static str, kind: Kind, words: &'static str) -> Self {
        Self {
            name,
            words,
            kind,
            chart: None,
        }
    }

    /// The same, drawn in the chart of this title.
    #[must_use]
    pub const fn in_chart(self, title: &'static str) -> Self {
        Self {
            chart: Some(title),
            ..self
        }
    }
}

/// Most facts of an iteration.
pub const MAX_FACTS: usize = 12;
/// Most values of all facts of an iteration together.
pub const MAX_VALUES: usize = MAX_CYCLES + MAX_RESIDUALS + MAX_FACTS;

/// The facts of an iteration, in the order in which a method tells them.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Each with the place in `values` where it ends.
    facts: heapless::Vec<(Fact, usize), MAX_FACTS>,
    values: heapless::Vec<f64, MAX_VALUES>,
}

impl Report {
    /// Tells a fact: one value, or those of a series. What finds no room is left out.
    pub fn tell(&mut self, fact: Fact, values: &[f64]) {
        if self.values.extend_from_slice(values).is_ok() {
            let _ = self.facts.push((fact, self.values.len()));
        }
    }

    /// All facts with their values.
    pub fn iter(&self) -> impl Iterator<Item = (Fact, &[f64])> {
        let mut begin = 0;
        self.facts.iter().map(move |&(fact, end)| {
            let values = self.values.get(begin..end).unwrap_or(&[]);
            begin = end;
            (fact, values)
        })
    }

    /// The values of the fact with this name; none where the method does not tell it.
    #[must_use]
    pub fn series(&self, name: &str) -> &[f64] {
        self.iter()
            .find(|(fact, _)| fact.name == name)
            .map_or(&[], |(_, values)| values)
    }

    /// The last value of the fact with this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        self.series(name).last().copied()
    }

    /// Whether nothing was told.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.facts.is_empty()
    }
}

/// A rule of convergence: a search ends where the value is, and stays for as long as the method asks for, below the bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// The value after the iteration.
    pub value: f64,
    /// The bound.
    pub bound: f64,
    /// How it falls.
    pub falls: Falls,
}

/// How a number that tells of convergence falls from iteration to iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Falls {
    /// By about the same factor: what is left of an error.
    Geometrically,
    /// As a power of the number of iterations: what a descent still gains.
    AsPower,
}

/// What one outer iteration did.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// Outer iteration, from 1.
    pub iteration: usize,
    /// Set when the solve is over.
    pub status: Option<Status>,
    /// The objective of the current velocities and forces.
    pub objective: Objective,
    /// Cells of the grid that the iteration worked on, where the method tells it.
    pub cells: [usize; 3],
    /// That grid, 0 for the finest.
    pub level: usize,
    /// Iteration on that grid, from 1; 0 where the method does not count them.
    pub level_iteration: usize,
    /// The number that the method's rule of convergence looks at, where it looks at one.
    pub rule: Option<Rule>,
    /// What the method has to tell beside that.
    pub report: Report,
}

impl Progress {
    /// Outer iteration `iteration` begins, and the observer hears of it.
    ///
    /// # Errors
    /// [`Status::Cancelled`] where the observer stops the solve.
    pub fn begin(&mut self, iteration: usize, observer: &mut dyn Observer) -> Result<(), Status> {
        self.iteration = iteration;
        if observer.on(Event::IterationBegin { iteration }).is_break() {
            return Err(Status::Cancelled);
        }
        Ok(())
    }
}
