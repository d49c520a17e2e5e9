//! Descent by quasi-Newton directions: a line search, a gradient, a pair, until there is nothing to gain.

pub use super::course::Course;
pub use super::function::Function;

use super::line_search::{Found, search};
use super::quasi_newton::history::History;
use super::quasi_newton::recursion::QuasiNewton;
use crate::checkpoint::{Damaged, MANY, Record};
use crate::exec::Exec;
use crate::field::slot::RETREATS;
use crate::observe::Observer;
use crate::progress::{Falls, Objective, Progress, Rule, Status};
use crate::real::Real;
use crate::transport::Stop;

/// Iterations in a row that may gain less than the tolerance.
const PATIENCE: usize = 2;

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// There is more to gain.
    Goes,
    /// The gain has been below the tolerance for a while, or the gradient is 0.
    Converged,
    /// No step along the preconditioned gradient gains anything.
    Stalled,
    /// No step that is tried is finite. The point is the last one that was.
    NotFinite,
}

/// The state of a minimisation.
#[derive(Clone, Debug)]
pub struct Descent {
    /// The pairs.
    pub newton: QuasiNewton,
    /// The value, once it is known with its gradient.
    objective: Option<Objective>,
    /// Iterations so far.
    pub iterations: usize,
    slow: usize,
}

impl Descent {
    /// Not begun, with no pairs yet.
    #[must_use]
    pub fn new(history: History) -> Self {
        Self {
            newton: QuasiNewton::new(history),
            objective: None,
            iterations: 0,
            slow: 0,
        }
    }

    /// Whether the value and the gradient at the point are known.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.objective.is_some()
    }

    /// Its state in a checkpoint, the fields' numbers aside.
    ///
    /// # Errors
    /// [`Damaged`], also where there are pairs of points before the first one.
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        record.option(&mut self.objective, |record, objective| objective.record(record))?;
        record.count(&mut self.iterations, MANY)?;
        record.count(&mut self.slow, MANY)?;
        self.newton.record(record)?;
        if self.newton.has_pairs() && !self.has_begun() {
            return Err(Damaged);
        }
        Ok(())
    }

    /// The value and the gradient at the first point, which is taken back until both are finite.
    ///
    /// # Errors
    /// [`Stop`]: [`Stop::TooFast`] where not even the point that a solve begins with is finite.
    fn begin<T: Real, S>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        function: &mut impl Function<T, S>,
        course: &mut Course,
    ) -> Result<Objective, Stop> {
        let first = self.newton.first();
        let mut retreats = RETREATS.iter();
        loop {
            course.evaluations += 1;
            let value = function.value(exec, observer, first.work, f64::INFINITY);
            let reached = match value {
                Ok(objective) if objective.total().is_finite() => function
                    .gradient(exec, observer, first.work, first.gradient)
                    .map(|()| objective),
                Ok(_) => Err(Stop::TooFast),
                Err(stop) => Err(stop),
            };
            match (reached, retreats.next()) {
                (Ok(objective), _) => {
                    function.arrive(exec, &mut self.newton, first, None);
                    return Ok(*self.objective.insert(objective));
                }
                (Err(Stop::TooFast), Some(&keep)) => function.retreat(exec, keep),
                (Err(stop), _) => return Err(stop),
            }
        }
    }

    /// [`Self::iterate`], told in `progress`; the descent after it and how it ended.
    ///
    /// # Errors
    /// Those of [`Self::iterate`].
    pub fn step<T: Real, S>(
        mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        function: &mut impl Function<T, S>,
        tolerance: f64,
        progress: &mut Progress,
    ) -> Result<(Self, Outcome), Status> {
        let mut course = Course::default();
        let before = self.objective;
        let ended = self.iterate(exec, observer, function, tolerance, &mut course);
        course.tell(progress);
        let (outcome, objective) = ended?;
        // Where no step was taken the gain says nothing.
        progress.rule = before.filter(|_| course.step > 0.0).map(|before| Rule {
            value: (before.total() - objective.total()) / objective.total(),
            bound: tolerance,
            falls: Falls::AsPower,
        });
        progress.objective = objective;
        Ok((self, outcome))
    }

    /// Whether there is more to gain after an iteration with this outcome, of `most` at most.
    ///
    /// # Errors
    /// How the search ended.
    pub fn goes_on(&self, outcome: Outcome, most: usize) -> Result<(), Status> {
        match outcome {
            Outcome::Goes if self.iterations < most => Ok(()),
            ended => Err(ended.status()),
        }
    }

    /// One iteration. It converges where the value falls by less than `tolerance` times itself twice in a row.
    ///
    /// # Errors
    /// [`Stop`]; the state is then that of a descent to begin anew.
    pub fn iterate<T: Real, S>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        function: &mut impl Function<T, S>,
        tolerance: f64,
        course: &mut Course,
    ) -> Result<(Outcome, Objective), Stop> {
        let before = match self.objective {
            Some(objective) => objective,
            None => self.begin(exec, observer, function, course)?,
        };
        self.iterations += 1;
        course.iteration = self.iterations;
        let slope = self.direction(exec, observer, function)?;
        course.slope = slope;
        course.gradient = self.newton.gradient_norm();
        if !slope.is_finite() {
            return Ok((Outcome::NotFinite, before));
        }
        if slope >= 0.0 {
            return Ok((Outcome::Converged, before));
        }
        let newton = &mut self.newton;
        let Some(borrowed) = newton.borrow() else {
            return Ok((Outcome::Stalled, before));
        };
        let value = before.total();
        match search(exec, observer, function, newton, borrowed, value, slope, course)? {
            Found::Step(length, after) => {
                function.arrive(exec, newton, borrowed, Some(length));
                course.step = length;
                course.gradient = newton.gradient_norm();
                Ok((self.accept(before, after, tolerance), after))
            }
            Found::Nothing { finite } => {
                newton.give_back(borrowed);
                let again = newton.has_pairs();
                newton.forget();
                Ok((Outcome::of_nothing(again, finite), before))
            }
        }
    }

    /// Writes the direction; its slope. Where it does not descend all pairs are dropped, and it is minus the preconditioned gradient.
    fn direction<T: Real, S>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        function: &mut impl Function<T, S>,
    ) -> Result<f64, Stop> {
        let newton = &mut self.newton;
        let slope = function.direction(exec, observer, newton)?;
        if !(slope < 0.0 && slope.is_finite()) && newton.has_pairs() {
            newton.forget();
            return function.direction(exec, observer, newton);
        }
        Ok(slope)
    }

    /// Takes the value after a step; whether that was enough.
    fn accept(&mut self, before: Objective, after: Objective, tolerance: f64) -> Outcome {
        self.objective = Some(after);
        let slow = before.total() - after.total() < tolerance * after.total();
        self.slow = if slow { self.slow + 1 } else { 0 };
        if self.slow >= PATIENCE {
            Outcome::Converged
        } else {
            Outcome::Goes
        }
    }
}

impl Outcome {
    /// How a solve ends with it; that goes on no longer where there is more to gain.
    #[must_use]
    pub fn status(self) -> Status {
        match self {
            Self::Goes => Status::MaxIterations,
            Self::Converged => Status::Converged,
            Self::Stalled => Status::Stalled,
            Self::NotFinite => Status::NotFinite,
        }
    }

    /// Of an iteration that found no step: whether there are other directions to try, and whether the shortest step was finite.
    fn of_nothing(again: bool, finite: bool) -> Self {
        if again {
            Self::Goes
        } else if finite {
            Self::Stalled
        } else {
            Self::NotFinite
        }
    }
}
