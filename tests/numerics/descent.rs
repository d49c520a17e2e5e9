//! The rules by which a descent takes a step, tries a shorter one and ends, on functions of one number.

use core::ops::ControlFlow;
use thurible_core::observe::{Event, Observer};
use thurible_core::optimise::descent::{Course, Descent, Function, Outcome};
use thurible_core::optimise::line_search::SMALLEST_STEP;
use thurible_core::optimise::quasi_newton::history::{History, Kept};
use thurible_core::optimise::quasi_newton::recursion::{Borrowed, GradientProducts, Products, QuasiNewton};
use thurible_core::transport::Stop;
use thurible_core::{Exec, Objective, Progress, Serial, Silent, Status};

const HISTORY: History = History::full(3);

/// A function of x with its derivative, in fields of one number; P = 1.
struct Line<F, G> {
    x: f64,
    value: F,
    slope: G,
    fields: Vec<f64>,
    /// All x at which it was asked for its value.
    asked: Vec<f64>,
    /// Slopes that it tells instead of the first ones.
    told: Vec<f64>,
    retreats: Vec<f64>,
}

impl<F: Fn(f64) -> f64, G: Fn(f64) -> f64> Line<F, G> {
    fn new(x: f64, value: F, slope: G) -> Self {
        Self {
            x,
            value,
            slope,
            fields: vec![f64::NAN; HISTORY.fields()],
            asked: Vec::new(),
            told: Vec::new(),
            retreats: Vec::new(),
        }
    }

    fn pair(&self, kept: Kept) -> [f64; 2] {
        match kept {
            Kept::Full(fields) => fields.map(|field| self.fields[field]),
            Kept::Halves(_) => unreachable!("pairs are kept in full"),
        }
    }
}

impl<F: Fn(f64) -> f64, G: Fn(f64) -> f64> Function<f64, ()> for Line<F, G> {
    fn direction(
        &mut self,
        _: &dyn Exec,
        _: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop> {
        let (combination, slope) = newton.combine();
        let first = combination.preconditioned * self.fields[newton.preconditioned];
        let pairs = combination.pairs.iter();
        let direction = pairs.fold(first, |sum, &(kept, [of_s, of_z])| {
            let [s, z] = self.pair(kept);
            sum + of_s * s + of_z * z
        });
        self.fields[newton.direction] = direction;
        Ok(self.told.pop().unwrap_or(slope))
    }

    fn move_along(&mut self, _: &dyn Exec, direction: usize, s: f64) {
        self.x += s * self.fields[direction];
    }

    fn retreat(&mut self, _: &dyn Exec, keep: f64) {
        self.x *= keep;
        self.retreats.push(keep);
    }

    fn value(
        &mut self,
        _: &dyn Exec,
        observer: &mut dyn Observer,
        _: usize,
        _: f64,
    ) -> Result<Objective, Stop> {
        // The first point is not interrupted.
        if !self.asked.is_empty() && observer.on(Event::IterationBegin { iteration: 1 }).is_break() {
            return Err(Stop::Cancelled);
        }
        self.asked.push(self.x);
        let data = (self.value)(self.x);
        Ok(Objective {
            data,
            ..Objective::default()
        })
    }

    fn gradient(&mut self, _: &dyn Exec, _: &mut dyn Observer, _: usize, into: usize) -> Result<(), Stop> {
        self.fields[into] = (self.slope)(self.x);
        Ok(())
    }

    fn arrive(&mut self, _: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let gradient = self.fields[borrowed.gradient];
        let of_pairs = newton.kept().map(|kept| {
            let [s, z] = self.pair(kept).map(|x| x * gradient);
            Products { s, z }
        });
        let (direction, before) = (newton.direction, newton.preconditioned);
        let products = GradientProducts {
            pairs: of_pairs.collect(),
            norm: gradient * gradient,
            step: step.map_or(Products::default(), |length| Products {
                s: length * self.fields[direction] * gradient,
                z: self.fields[before] * gradient,
            }),
        };
        if let Some(length) = step {
            self.fields[direction] *= length;
            self.fields[before] = gradient - self.fields[before];
        }
        self.fields[borrowed.work] = gradient;
        newton.move_to(borrowed, step, &products);
    }
}

/// One iteration.
fn iterate<F: Fn(f64) -> f64, G: Fn(f64) -> f64>(
    descent: &mut Descent,
    line: &mut Line<F, G>,
    tolerance: f64,
) -> (Outcome, Course) {
    let mut course = Course::default();
    let ended = descent.iterate(&Serial, &mut Silent, line, tolerance, &mut course);
    (ended.unwrap().0, course)
}

/// From x = 1 with f' = 1 the first direction is -1. A value at x = 0 that is lower by less than 1e-4 of what the slope promises is not enough (Armijo), one
/// that is lower by more is.
#[test]
fn a_step_has_to_gain_a_part_of_what_the_slope_promises() {
    for (gain, taken) in [(1.1e-4, true), (0.9e-4, false), (-0.5e-4, false)] {
        let value = |x: f64| match x {
            1.0 => 5.0,
            0.0 => 5.0 - gain,
            // What is tried next falls by enough.
            _ => 4.0,
        };
        let mut line = Line::new(1.0, value, |_| 1.0);
        let (outcome, course) = iterate(&mut Descent::new(HISTORY), &mut line, 0.0);
        assert_eq!(outcome, Outcome::Goes);
        assert_eq!(course.slope, -1.0);
        assert_eq!(course.evaluations, if taken { 2 } else { 3 }, "{gain}");
        assert_eq!(course.step == 1.0, taken, "{gain}");
        assert_eq!(course.gradient, 1.0);
    }
}

/// f = 2 x^2 from x = 1: the direction is -4, the step 1 leads to -3, and the parabola through both values and the slope is f itself, lowest at the step 1/4.
#[test]
fn too_long_a_step_is_shortened_by_a_parabola() {
    let mut line = Line::new(1.0, |x| 2.0 * x * x, |x| 4.0 * x);
    let mut descent = Descent::new(HISTORY);
    let (outcome, course) = iterate(&mut descent, &mut line, 1e-9);
    assert_eq!((outcome, course.step), (Outcome::Goes, 0.25));
    assert_eq!(line.asked, [1.0, -3.0, 0.0]);
    assert!(descent.newton.has_pairs() && descent.has_begun());
    // The gradient is 0 there.
    let (outcome, course) = iterate(&mut descent, &mut line, 1e-9);
    assert_eq!(
        (outcome, course.step, course.gradient),
        (Outcome::Converged, 0.0, 0.0)
    );
    assert_eq!((descent.iterations, course.iteration), (2, 2));
}

/// A value that is no number has no parabola: half of the step is tried; and at least a tenth of it, whatever the parabola says.
#[test]
fn a_step_to_nowhere_is_halved() {
    let nowhere = |x: f64| if x < 0.3 { f64::NAN } else { x };
    let mut line = Line::new(1.0, nowhere, |_| 1.0);
    let (_, course) = iterate(&mut Descent::new(HISTORY), &mut line, 0.0);
    assert_eq!((course.step, line.asked), (0.5, vec![1.0, 0.0, 0.5]));
    for wall in [1e9, f64::INFINITY] {
        let steep = |x: f64| if x < 0.3 { wall } else { x };
        let mut line = Line::new(1.0, steep, |_| 1.0);
        let (_, course) = iterate(&mut Descent::new(HISTORY), &mut line, 0.0);
        assert_eq!((course.step, line.asked), (0.1, vec![1.0, 0.0, 0.9]));
    }
}

/// The value falls by a thousandth in each iteration: a tolerance above that ends the second of them, one below none.
#[test]
fn it_converges_when_little_is_gained_twice() {
    let falls = || Line::new(0.0, |x: f64| 1000.0 + x, |_| 1.0);
    let (mut line, mut descent) = (falls(), Descent::new(HISTORY));
    assert_eq!(iterate(&mut descent, &mut line, 2e-3).0, Outcome::Goes);
    assert_eq!(iterate(&mut descent, &mut line, 2e-3).0, Outcome::Converged);
    let (mut line, mut descent) = (falls(), Descent::new(HISTORY));
    for _ in 0..5 {
        assert_eq!(iterate(&mut descent, &mut line, 0.5e-3).0, Outcome::Goes);
    }
    // A good iteration in between begins the count anew.
    let (mut line, mut descent) = (falls(), Descent::new(HISTORY));
    for tolerance in [2e-3, 0.5e-3, 2e-3] {
        assert_eq!(iterate(&mut descent, &mut line, tolerance).0, Outcome::Goes);
    }
    assert_eq!(iterate(&mut descent, &mut line, 2e-3).0, Outcome::Converged);
}

/// Where no step gains anything pairs are dropped first; without any it has stalled, or came to no finite number.
#[test]
fn without_a_step_it_stalls() {
    let stuck = |x: f64| if x == 1.0 { 0.0 } else { 1.0 };
    let mut line = Line::new(1.0, stuck, |_| 1.0);
    let (outcome, course) = iterate(&mut Descent::new(HISTORY), &mut line, 0.0);
    assert_eq!((outcome, course.step, line.x), (Outcome::Stalled, 0.0, 1.0));
    let nowhere = |x: f64| if x == 1.0 { 0.0 } else { f64::NAN };
    let mut line = Line::new(1.0, nowhere, |_| 1.0);
    let (outcome, course) = iterate(&mut Descent::new(HISTORY), &mut line, 0.0);
    assert_eq!((outcome, course.step, line.x), (Outcome::NotFinite, 0.0, 1.0));
    // Half of the steps from 1 to the smallest.
    assert_eq!(line.asked.len(), 2 + SMALLEST_STEP.recip().log2() as usize);

    // From x = 1 to 0 by one step, and no farther.
    let wall = |x: f64| if x < 0.0 { 2.0 } else { 1.0 + x * x / 2.0 };
    let slope = |x: f64| if x > 0.5 { x } else { 0.25 };
    let (mut line, mut descent) = (Line::new(1.0, wall, slope), Descent::new(HISTORY));
    assert_eq!(iterate(&mut descent, &mut line, 0.0).0, Outcome::Goes);
    assert!(descent.newton.has_pairs());
    assert_eq!(iterate(&mut descent, &mut line, 0.0).0, Outcome::Goes);
    assert!(!descent.newton.has_pairs());
    // The fields of a trial are given back: however often it tries, there are some.
    for _ in 0..HISTORY.fields() {
        let (outcome, course) = iterate(&mut descent, &mut line, 0.0);
        assert_eq!(outcome, Outcome::Stalled);
        assert!(course.evaluations > 1);
    }
}

/// A direction that does not descend is minus the gradient, once the pairs are dropped; without pairs a slope of 0 is the end.
#[test]
fn a_direction_that_does_not_descend_is_not_taken() {
    for told in [0.0, 1.0, f64::NAN, f64::NEG_INFINITY] {
        let mut line = Line::new(1.0, |x| x * x / 4.0, |x| x / 2.0);
        let mut descent = Descent::new(HISTORY);
        assert_eq!(iterate(&mut descent, &mut line, 0.0).0, Outcome::Goes);
        assert!(descent.newton.has_pairs());
        line.told.push(told);
        let (outcome, course) = iterate(&mut descent, &mut line, 0.0);
        assert_eq!(outcome, Outcome::Goes, "{told}");
        // At x = 1/2, minus the square of the gradient.
        assert_eq!(course.slope, -1.0 / 16.0, "{told}");
    }
    for (told, expected) in [(0.0, Outcome::Converged), (f64::NAN, Outcome::NotFinite)] {
        let mut line = Line::new(1.0, |x| x * x, |x| 2.0 * x);
        line.told.push(told);
        let (outcome, course) = iterate(&mut Descent::new(HISTORY), &mut line, 0.0);
        assert_eq!((outcome, course.evaluations), (expected, 1));
    }
}

/// A first point without a value is taken back until there is one.
#[test]
fn it_begins_where_there_is_a_value() {
    let far = |x: f64| if x > 0.3 { f64::INFINITY } else { x };
    let (mut line, mut descent) = (Line::new(1.0, far, |_| 1.0), Descent::new(HISTORY));
    assert!(!descent.has_begun());
    iterate(&mut descent, &mut line, 0.0);
    assert!(!line.retreats.is_empty() && descent.has_begun());
    let mut line = Line::new(1.0, |_| f64::NAN, |_| 1.0);
    let mut descent = Descent::new(HISTORY);
    let ended = descent.iterate(&Serial, &mut Silent, &mut line, 0.0, &mut Course::default());
    assert!(matches!(ended, Err(Stop::TooFast)));
    assert!(!descent.has_begun());
}

/// What an iteration tells, and when a search goes on.
#[test]
fn an_iteration_tells_how_it_went() {
    let mut line = Line::new(1.0, |x| 1.0 + 2.0 * x * x, |x| 4.0 * x);
    let step = |descent: Descent, line: &mut Line<_, _>| {
        let mut progress = Progress::default();
        let ended = descent.step(&Serial, &mut Silent, line, 1e-9, &mut progress);
        let (descent, outcome) = ended.unwrap();
        (descent, outcome, progress)
    };
    let (descent, outcome, progress) = step(Descent::new(HISTORY), &mut line);
    let told = ["step", "slope", "gradient_norm", "evaluations"].map(|fact| progress.report.get(fact));
    assert_eq!(told, [Some(0.25), Some(-16.0), Some(0.0), Some(3.0)]);
    assert_eq!((progress.level_iteration, progress.objective.data), (1, 1.0));
    // There was no value before.
    assert!(progress.rule.is_none() && !progress.report.is_empty());
    assert_eq!(descent.goes_on(outcome, 2), Ok(()));
    assert_eq!(descent.goes_on(outcome, 1), Err(Status::MaxIterations));
    for (ended, status) in [
        (Outcome::Converged, Status::Converged),
        (Outcome::Stalled, Status::Stalled),
        (Outcome::NotFinite, Status::NotFinite),
    ] {
        assert_eq!(descent.goes_on(ended, 2), Err(status));
    }
    assert!(Progress::default().report.is_empty());
    let mut nothing = Progress::default();
    Course::default().tell(&mut nothing);
    assert!(nothing.report.is_empty());

    let mut falls = Line::new(0.0, |x: f64| 1000.0 + x, |_| 1.0);
    let (descent, _, first) = {
        let mut progress = Progress::default();
        let ended = Descent::new(HISTORY).step(&Serial, &mut Silent, &mut falls, 1e-9, &mut progress);
        let (descent, outcome) = ended.unwrap();
        (descent, outcome, progress)
    };
    assert!(first.rule.is_none());
    let mut second = Progress::default();
    descent
        .step(&Serial, &mut Silent, &mut falls, 1e-9, &mut second)
        .unwrap();
    let rule = second.rule.unwrap();
    assert_eq!((rule.value, rule.bound), (1.0 / 998.0, 1e-9));
}

/// Says stop at every event.
struct Stops;

impl Observer for Stops {
    fn on(&mut self, _: Event) -> ControlFlow<()> {
        ControlFlow::Break(())
    }
}

/// A step that is interrupted leaves the point where it was.
#[test]
fn a_step_that_is_stopped_is_taken_back() {
    let mut line = Line::new(1.0, |x| x, |_| 1.0);
    let mut descent = Descent::new(HISTORY);
    let ended = descent.iterate(&Serial, &mut Stops, &mut line, 0.0, &mut Course::default());
    assert!(matches!(ended, Err(Stop::Cancelled)));
    assert_eq!((line.x, line.asked.len()), (1.0, 1));
}
