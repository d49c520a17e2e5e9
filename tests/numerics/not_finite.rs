//! Control so strong that trial steps leave the finite numbers, or are too fast to follow: they are taken back, and the last good flow is
//! the result.

use crate::fields::cases::{Scene, Solved};
use crate::fields::grid;
use core::cell::Cell;
use core::ops::ControlFlow;
use thurible_core::exec::Exec;
use thurible_core::field::trajectory::Shape;
use thurible_core::optimise::descent::{Course, Descent, Function, Outcome};
use thurible_core::optimise::quasi_newton::fields::{Fields, Initial};
use thurible_core::optimise::quasi_newton::history::History;
use thurible_core::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use thurible_core::transport::Stop;
use thurible_core::{D2, Event, Method, Objective, Observer, Params, Real, Serial, Silent, Status};

/// Two steps, in which a ball is to cross most of the box, at hardly any price.
fn violent(method: Method) -> Scene {
    let cells = [32, 32];
    let ball = |at: f64| crate::fields::cases::balls(&grid(&cells, "ww"), &[[at, at, 0.5]], 0.12);
    Scene {
        force_weight: 1e-3,
        densities: vec![ball(0.2), ball(0.8)],
        params: Params {
            method,
            iterations: 40,
            ..Params::default()
        },
        ..Scene::small(&cells, "ww", 2)
    }
}

fn check_finite(solved: &Solved) {
    let fields = solved.velocity.iter().chain(&solved.force).flatten();
    assert!(
        solved
            .density
            .iter()
            .chain(fields)
            .flatten()
            .chain(&solved.objective)
            .all(|x| x.is_finite())
    );
}

fn a_result_is_left<T: Real>() {
    for method in [Method::Direct, Method::Lbfgs, Method::Admm, Method::Pd] {
        let scene = violent(method);
        let solved = scene.solve_alone::<T, D2>();
        assert_ne!(solved.status, Status::NotFinite, "{method:?} in {}", T::NAME);
        check_finite(&solved);
        // Only the direct method and L-BFGS go down all the way.
        if matches!(method, Method::Direct | Method::Lbfgs) {
            // Objectives of coarser grids cannot be compared.
            let first = solved
                .history
                .iter()
                .find(|progress| progress.level == 0)
                .unwrap();
            assert!(
                solved.objective[0] < first.objective.total(),
                "{method:?} in {}",
                T::NAME
            );
        }
    }
}

#[test]
fn a_result_is_left_in_single_precision() {
    a_result_is_left::<f32>();
}

#[test]
fn a_result_is_left_in_double_precision() {
    a_result_is_left::<f64>();
}

/// Two circles by forces that blow up at once: what was simulated before is the result.
#[test]
fn a_flow_that_becomes_too_fast_is_kept_up_to_there() {
    for drive in [1e3, 1e6, 1e12] {
        let mut scene = Scene::small(&[16, 12], "wp", 6);
        scene.params.method = Method::Pd;
        scene.params.pd.drive = drive;
        for solved in [scene.solve_alone::<f32, D2>(), scene.solve_alone::<f64, D2>()] {
            assert_ne!(solved.status, Status::NotFinite, "drive {drive}");
            check_finite(&solved);
        }
    }
}

const HISTORY: History = History::full(4);

/// 1/2 |x - a|^2 over a trajectory, whose gradient is said to be not finite beyond a distance from the start.
struct Bowl<'g> {
    shape: Shape<'g>,
    x: Vec<f64>,
    goal: Vec<f64>,
    fields: Fields<'g, f64>,
    /// Beyond this |x| the value is not finite.
    edge_of_value: f64,
    /// Beyond this |x| the gradient is not finite.
    edge_of_gradient: f64,
    retreats: Vec<f64>,
    gradients: Cell<usize>,
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl Function<f64, D2> for Bowl<'_> {
    fn direction(
        &mut self,
        exec: &dyn Exec,
        _observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop> {
        Ok(newton.descend(exec, self.shape, &mut self.fields))
    }

    fn move_along(&mut self, _exec: &dyn Exec, direction: usize, s: f64) {
        for (x, d) in self.x.iter_mut().zip(&*self.fields[direction][0]) {
            *x += s * d;
        }
    }

    fn retreat(&mut self, _exec: &dyn Exec, keep: f64) {
        self.retreats.push(keep);
        self.x.iter_mut().for_each(|x| *x *= keep);
    }

    fn value(
        &mut self,
        _exec: &dyn Exec,
        _observer: &mut dyn Observer,
        _work: usize,
        _bound: f64,
    ) -> Result<Objective, Stop> {
        let data = if norm(&self.x) <= self.edge_of_value {
            let gap: Vec<f64> = self.x.iter().zip(&self.goal).map(|(x, a)| x - a).collect();
            0.5 * norm(&gap).powi(2)
        } else {
            f64::NAN
        };
        Ok(Objective::of_data(data))
    }

    fn gradient(
        &mut self,
        _exec: &dyn Exec,
        _observer: &mut dyn Observer,
        _work: usize,
        into: usize,
    ) -> Result<(), Stop> {
        self.gradients.set(self.gradients.get() + 1);
        if norm(&self.x) > self.edge_of_gradient {
            return Err(Stop::TooFast);
        }
        self.fields[into]
            .iter_mut()
            .for_each(|component| component.fill(0.0));
        for ((out, x), a) in self.fields[into][0].iter_mut().zip(&self.x).zip(&self.goal) {
            *out = x - a;
        }
        Ok(())
    }

    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let initial = Initial {
            line: None,
            scale: 1.0,
            prepared: false,
        };
        let mut sums = vec![0.0; HISTORY.sums_per_row() * self.shape.grid.rows() + 8];
        newton.arrive(
            exec,
            self.shape,
            &mut self.fields,
            borrowed,
            step,
            &initial,
            &mut sums,
        );
    }
}

/// The point that a descent comes to, how it ended, and the retreats of its first point.
fn descend(
    from: f64,
    [edge_of_value, edge_of_gradient]: [f64; 2],
) -> (Vec<f64>, Result<Outcome, Stop>, Vec<f64>) {
    let grid = grid(&[4, 4], "ww");
    let (len, slots) = (grid.cells(), 1);
    let mut memory: Vec<Vec<f64>> = vec![vec![0.0; len]; 2 * HISTORY.fields()];
    let mut places = memory.iter_mut().map(Vec::as_mut_slice);
    let mut fields = Fields::new();
    while let (Some(x), Some(y)) = (places.next(), places.next()) {
        assert!(fields.push([x, y, &mut []]).is_ok());
    }
    let mut bowl = Bowl {
        shape: Shape { grid: &grid, slots },
        x: vec![from; len],
        goal: vec![1.0; len],
        fields,
        edge_of_value,
        edge_of_gradient,
        retreats: Vec::new(),
        gradients: Cell::new(0),
    };
    let mut descent = Descent::new(HISTORY);
    let mut outcome = Ok(Outcome::Goes);
    for _ in 0..30 {
        let step = descent.iterate::<f64, D2>(&Serial, &mut Silent, &mut bowl, 1e-12, &mut Course::default());
        outcome = step.map(|(outcome, _)| outcome);
        if outcome != Ok(Outcome::Goes) {
            break;
        }
    }
    (bowl.x, outcome, bowl.retreats)
}

#[test]
fn a_step_whose_gradient_is_not_finite_is_taken_back() {
    // |goal| is 4. The first step leads there at once; with an edge at 3 the search stops short of it.
    let (x, outcome, _) = descend(0.0, [f64::INFINITY; 2]);
    assert!((norm(&x) - 4.0).abs() < 1e-9, "{outcome:?}");
    for edges in [[f64::INFINITY, 3.0], [3.0, f64::INFINITY], [3.0, 3.0]] {
        let (x, outcome, retreats) = descend(0.0, edges);
        let size = norm(&x);
        assert!((2.0..=3.0).contains(&size), "{size} after {outcome:?}");
        assert!(x.iter().all(|x| x.is_finite()) && retreats.is_empty());
        assert_eq!(outcome, Ok(Outcome::NotFinite), "nothing finite is left");
    }
}

#[test]
fn a_first_point_that_is_not_finite_is_taken_back() {
    for edges in [[f64::INFINITY, 3.0], [3.0, f64::INFINITY]] {
        // |x| is 4 times the number.
        let (x, outcome, retreats) = descend(-2.0, edges);
        assert!(outcome.is_ok() && norm(&x) <= 3.0);
        assert_eq!(retreats, [0.5, 0.5]);
        let (_, _, retreats) = descend(1e30, edges);
        assert_eq!(retreats.last(), Some(&0.0), "in the end nothing of it is left");
    }
    // Where not even the start is finite there is no result.
    let (_, outcome, _) = descend(1.0, [-1.0; 2]);
    assert_eq!(outcome, Err(Stop::TooFast));
}

/// A stop is not mistaken for a step that is not finite.
#[test]
fn a_stop_in_a_violent_solve_is_a_stop() {
    struct After(usize);
    impl Observer for After {
        fn on(&mut self, _event: Event) -> ControlFlow<()> {
            self.0 = self.0.saturating_sub(1);
            if self.0 == 0 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        }
    }
    for method in [Method::Direct, Method::Lbfgs, Method::Admm, Method::Pd] {
        for count in [3, 40, 150] {
            let solved = violent(method).solve::<f32, D2>(&Serial, &mut After(count));
            if solved.status == Status::Cancelled {
                check_finite(&solved);
            }
            assert_ne!(solved.status, Status::NotFinite, "{method:?} stopped at {count}");
        }
    }
}
