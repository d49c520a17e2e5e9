//! Descent by quasi-Newton directions: a line search, a gradient, a pair, until there is nothing to gain.

use crate::checkpoint::{Damaged, MANY, Record};
use crate::exec::Exec;
use crate::field::slot::RETREATS;
use crate::observe::Observer;
use crate::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::progress::{Fact, Kind, Objective, Progress};
use crate::real::Real;
use crate::transport::Stop;

/// Part of the decrease that the slope promises, which a step must keep (Armijo).
const ENOUGH: f64 = 1e-4;
/// The smallest step that is tried.
pub const SMALLEST_STEP: f64 = 1.0 / (1 << 20) as f64;
/// Part of a step that is tried next when it is too long, at least and at most.
const SHRINK: [f64; 2] = [0.1, 0.5];
/// Iterations in a row that may gain less than the tolerance.
const PATIENCE: usize = 2;

/// A function of a trajectory of faces, at a point that can be moved.
pub trait Function<T: Real, S> {
    /// Writes the direction's field; <gradient, direction>, which is not finite where the direction is of no use.
    ///
    /// # Errors
    /// [`Stop`].
    fn direction(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop>;
    /// Moves the point by `s` times field `direction`.
    fn move_along(&mut self, exec: &dyn Exec, direction: usize, s: f64);
    /// Takes the point back towards where a solve begins: `keep` of the way from there is left.
    fn retreat(&mut self, exec: &dyn Exec, keep: f64);
    /// The value, with what the gradient needs of it in field `work`; perhaps not all of it where a part is above `bound`.
    ///
    /// # Errors
    /// [`Stop`].
    fn value(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: usize,
        bound: f64,
    ) -> Result<Objective, Stop>;
    /// The gradient into field `into`, from field `work`: the point is the new one from here on.
    ///
    /// # Errors
    /// [`Stop`], where the gradient is not finite too: the point is then taken back.
    fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: usize,
        into: usize,
    ) -> Result<(), Stop>;
    /// Calls [`QuasiNewton::arrive`] with its fields.
    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>);
}

const STEP: Fact = Fact::new(
    "step",
    Kind::Number,
    "step along the direction, 0 when none gained anything",
);
const SLOPE: Fact = Fact::new(
    "slope",
    Kind::Number,
    "the objective's derivative along the direction",
);
const EVALUATIONS: Fact = Fact::new("evaluations", Kind::Count, "how often the objective was computed");

/// How one iteration went.
#[derive(Clone, Copy, Debug, Default)]
pub struct Course {
    /// Its number, from 1.
    pub iteration: usize,
    /// Step along the direction, 0 when none gained anything.
    pub step: f64,
    /// <gradient, direction>: the objective's derivative along the direction.
    pub slope: f64,
    /// How often the objective was computed.
    pub evaluations: usize,
}

impl Course {
    /// Tells it, if an iteration was begun.
    pub fn tell(&self, progress: &mut Progress) {
        progress.level_iteration = self.iteration;
        if self.iteration > 0 {
            progress.report.tell(STEP, &[self.step]);
            progress.report.tell(SLOPE, &[self.slope]);
            progress.report.tell(EVALUATIONS, &[self.evaluations as f64]);
        }
    }
}

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

/// What a line search found.
enum Found {
    /// A step of this length, with the value there and the gradient in its field.
    Step(f64, Objective),
    /// No step; whether the shortest one was finite. The point is where it was.
    Nothing { finite: bool },
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
    /// Not begun, with so many pairs at most.
    #[must_use]
    pub fn new(history: usize) -> Self {
        Self {
            newton: QuasiNewton::new(history),
            objective: None,
            iterations: 0,
            slow: 0,
        }
    }

    /// Its state in a checkpoint, the fields' numbers aside.
    ///
    /// # Errors
    /// [`Damaged`].
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        record.option(&mut self.objective, |record, objective| objective.record(record))?;
        record.count(&mut self.iterations, MANY)?;
        record.count(&mut self.slow, MANY)?;
        self.newton.record(record)
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
        let newton = &mut self.newton;
        self.iterations += 1;
        course.iteration = self.iterations;
        let mut slope = function.direction(exec, observer, newton)?;
        if !(slope < 0.0 && slope.is_finite()) && newton.has_pairs() {
            newton.forget();
            slope = function.direction(exec, observer, newton)?;
        }
        course.slope = slope;
        if !slope.is_finite() {
            return Ok((Outcome::NotFinite, before));
        }
        if slope >= 0.0 {
            return Ok((Outcome::Converged, before));
        }
        let Some(borrowed) = newton.borrow() else {
            return Ok((Outcome::Stalled, before));
        };
        let found = search(
            exec,
            observer,
            function,
            newton,
            borrowed,
            before.total(),
            slope,
            course,
        )?;
        let (length, after) = match found {
            Found::Step(length, after) => (length, after),
            Found::Nothing { finite } => {
                newton.give_back(borrowed);
                let again = newton.has_pairs();
                newton.forget();
                return Ok((Outcome::of_nothing(again, finite), before));
            }
        };
        function.arrive(exec, newton, borrowed, Some(length));
        self.objective = Some(after);
        course.step = length;
        let slow = before.total() - after.total() < tolerance * after.total();
        self.slow = if slow { self.slow + 1 } else { 0 };
        Ok((
            if self.slow >= PATIENCE {
                Outcome::Converged
            } else {
                Outcome::Goes
            },
            after,
        ))
    }
}

impl Outcome {
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

/// Moves the point along the direction by the first step, 1 or shorter, with which the value falls enough and the gradient is finite
/// (Nocedal & Wright, section 3.5). Leaves the point where it was if there is none.
fn search<T: Real, S>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    function: &mut impl Function<T, S>,
    newton: &QuasiNewton,
    borrowed: Borrowed,
    before: f64,
    slope: f64,
    course: &mut Course,
) -> Result<Found, Stop> {
    let (mut length, mut moved) = (1.0, 0.0);
    let mut finite = true;
    while length >= SMALLEST_STEP {
        function.move_along(exec, newton.direction, length - moved);
        moved = length;
        let bound = before + ENOUGH * length * slope;
        course.evaluations += 1;
        let tried = match function.value(exec, observer, borrowed.work, bound) {
            Ok(after) if after.total() <= bound => function
                .gradient(exec, observer, borrowed.work, borrowed.gradient)
                .map(|()| Found::Step(length, after)),
            Ok(after) => {
                finite = after.total().is_finite();
                length = shorter(length, after.total() - before, slope);
                continue;
            }
            Err(stop) => Err(stop),
        };
        match tried {
            Err(Stop::TooFast) => (length, finite) = (SHRINK[1] * length, false),
            ended => return ended,
        }
    }
    function.move_along(exec, newton.direction, -moved);
    Ok(Found::Nothing { finite })
}

/// The step to try after one of `length` that changed the value by `change`: where the parabola through the value and the slope before
/// and the value there is lowest.
fn shorter(length: f64, change: f64, slope: f64) -> f64 {
    let lowest = -0.5 * slope * length * length / (change - slope * length);
    if lowest.is_finite() {
        lowest.clamp(SHRINK[0] * length, SHRINK[1] * length)
    } else {
        SHRINK[1] * length
    }
}
