//! Every way in which a solve by ADMM ends.

use crate::fields::cases::{Scene, Solved, admm};
use core::ops::ControlFlow;
use thurible_core::{D2, Event, Observer, Params, Serial, Silent, Solver, Status};

pub type Small<'m> = Solver<'m, f64, D2>;

pub fn scene() -> Scene {
    Scene::small(&[12, 10], "wp", 5)
}

/// Stops at the `left`-th event that `counts`, and counts how many come after it all the same.
struct Stop<F> {
    left: usize,
    after: usize,
    counts: F,
}

impl<F: Fn(Event) -> bool> Stop<F> {
    fn at(left: usize, counts: F) -> Self {
        Stop {
            left,
            after: 0,
            counts,
        }
    }
}

impl<F: Fn(Event) -> bool> Observer for Stop<F> {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        if (self.counts)(event) {
            self.after += usize::from(self.left == 0);
            self.left = self.left.saturating_sub(1);
        }
        if self.left == 0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// How many events of one iteration `counts`.
fn events(scene: &Scene, counts: impl Fn(Event) -> bool) -> usize {
    let mut observer = Stop::at(usize::MAX, counts);
    scene.with::<f64, D2, _>(|solver| solver.step(&Serial, &mut observer));
    usize::MAX - observer.left
}

/// A finite, feasible-looking result.
fn check_finite(solved: &Solved) {
    let numbers = solved
        .density
        .iter()
        .flatten()
        .chain(solved.velocity.iter().chain(&solved.force).flatten().flatten());
    assert!(
        numbers.chain(&solved.objective).all(|x| x.is_finite()),
        "a number is not finite"
    );
}

#[test]
fn max_iterations() {
    for iterations in [1, 2] {
        let scene = Scene {
            params: Params { iterations, ..admm() },
            ..scene()
        };
        let solved = scene.solve_alone::<f64, D2>();
        assert_eq!(
            (solved.status, solved.history.len()),
            (Status::MaxIterations, iterations)
        );
        let numbers: Vec<usize> = solved.history.iter().map(|progress| progress.iteration).collect();
        assert_eq!(numbers, (1..=iterations).collect::<Vec<_>>());
        assert!(
            solved.history[..iterations - 1]
                .iter()
                .all(|progress| progress.status.is_none())
        );
        check_finite(&solved);
    }
}

#[test]
fn converged_only_when_both_halves_agree() {
    // With a tolerance that every change satisfies, only disagreement of v and v* is left to say no.
    let mut scene = Scene {
        params: Params {
            iterations: 40,
            ..admm()
        },
        ..scene()
    };
    scene.params.admm.density_tolerance = 1e9;
    let solved = scene.solve_alone::<f64, D2>();
    match solved.status {
        Status::Converged => assert!(solved.history.last().unwrap().report.get("gap").unwrap() <= 0.01),
        status => assert_eq!(status, Status::Stalled),
    }
}

#[test]
fn nothing_to_do_ends_early_and_at_rest() {
    let mut scene = Scene {
        params: Params {
            iterations: 40,
            ..admm()
        },
        ..scene()
    };
    scene.densities[1] = scene.densities[0].clone();
    let solved = scene.solve_alone::<f64, D2>();
    assert!(
        solved.status == Status::Converged && solved.history.len() < 6,
        "{:?}",
        solved.status
    );
    assert_eq!(solved.objective, [0.0, 0.0]);
    assert!(solved.velocity.iter().flatten().flatten().all(|&x| x == 0.0));
}

#[test]
fn stalled() {
    let mut scene = Scene {
        params: Params {
            iterations: 40,
            ..admm()
        },
        ..Scene::two_circles()
    };
    // Every change of the density is small, but the first iterations leave v and v* far apart.
    (scene.params.admm.density_tolerance, scene.force_weight) = (1e9, 1e5);
    let solved = scene.solve_alone::<f64, D2>();
    assert_eq!(solved.status, Status::Stalled);
    assert!(solved.history.len() < 10);
    check_finite(&solved);
}

#[test]
fn not_finite_when_a_flow_is_too_fast() {
    let scene = scene();
    for speed in [7.0, 1e20] {
        let (status, iterations) = scene.with::<f64, D2, _>(|solver| {
            solver
                .set_initial_velocity(1, &vec![speed; solver.faces(1)])
                .unwrap();
            let mut count = 0;
            (solver.solve(&Serial, &mut Silent, &mut |_| count += 1), count)
        });
        assert_eq!((status, iterations), (Status::NotFinite, 1), "at speed {speed}");
    }
}

/// Stops at many events of the first iteration; what is left must be finite and can be made feasible.
fn cancelled_at(scene: &Scene, counts: impl Fn(Event) -> bool + Copy, most: usize, after: usize) {
    let count = events(scene, counts);
    assert!(count > 0);
    for left in (1..=count).step_by(count.div_ceil(most)) {
        let solved = scene.with::<f64, D2, _>(|solver| {
            let mut observer = Stop::at(left, counts);
            let progress = solver.step(&Serial, &mut observer);
            assert_eq!(
                progress.status,
                Some(Status::Cancelled),
                "at event {left} of {count}"
            );
            assert!(
                observer.left == 0 && observer.after <= after,
                "{} events after the stop at {left}",
                observer.after
            );
            let objective = solver.finish(&Serial).unwrap();
            assert!(objective.total().is_finite());
            Solved::read(scene, solver, Status::Cancelled, Vec::new())
        });
        check_finite(&solved);
    }
}

#[test]
fn cancelled_within_a_sweep() {
    cancelled_at(&scene(), |event| event == Event::Work, 40, 0);
    // This one begins on a coarser grid, all events of which are told as work, the end of AO or NSO too.
    cancelled_at(
        &Scene::small(&[32, 16], "ww", 4),
        |event| event == Event::Work,
        60,
        1,
    );
}

#[test]
fn cancelled_at_every_other_event() {
    // The end of AO or NSO is still told, once.
    cancelled_at(&scene(), |event| event != Event::Work, 40, 1);
}

#[test]
fn cancelled_by_solve_is_made_feasible() {
    let scene = scene();
    let solved = scene.solve::<f64, D2>(&Serial, &mut Stop::at(60, |event| event == Event::Work));
    assert_eq!(solved.status, Status::Cancelled);
    check_finite(&solved);
    let mass = |rho: &[f64]| rho.iter().sum::<f64>();
    assert!((mass(&solved.density[5]) - mass(&solved.density[0])).abs() < 1e-6 * mass(&solved.density[0]));
}
