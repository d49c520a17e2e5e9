//! Every input that is refused, and what may be set again.

use crate::admm_statuses::{Small, scene};
use crate::fields::Memory;
use thurible_core::{D2, InputError, Real, Scheme, Serial, Silent, Solver, Status};

fn with_empty<R>(work: impl FnOnce(&mut Small<'_>) -> R) -> R {
    let mut scene = scene();
    scene.keyframes = vec![3, 5];
    let mut memory = Memory::new(scene.plan::<f64, D2>().bytes());
    work(&mut Solver::new(&scene.problem(), &scene.params, memory.block()).unwrap())
}

#[test]
fn not_ready_until_all_densities_are_there() {
    with_empty(|solver| {
        let (good, one) = (scene().densities[0].clone(), vec![1.0; 120]);
        assert_eq!(solver.prepare(&Serial), Err(InputError::NoSource));
        assert_eq!(solver.solve(&Serial, &mut Silent, &mut |_| {}), Status::NotReady);
        assert_eq!(solver.set_keyframe(0, &good), Err(InputError::NoSource));
        solver.set_source(&good).unwrap();
        assert_eq!(solver.prepare(&Serial), Err(InputError::NoKeyframe { index: 0 }));
        solver.set_keyframe(1, &one).unwrap();
        assert_eq!(solver.prepare(&Serial), Err(InputError::NoKeyframe { index: 0 }));
        assert_eq!(solver.step(&Serial, &mut Silent).status, Some(Status::NotReady));
        solver.set_keyframe(1, &good).unwrap();
        assert_eq!(solver.prepare(&Serial), Err(InputError::NoKeyframe { index: 0 }));
        assert_eq!(
            solver.set_keyframe(2, &good),
            Err(InputError::Index { given: 2, count: 2 })
        );
        let factor = solver.set_keyframe(0, &one).unwrap();
        assert!(
            (factor - good.iter().sum::<f64>() / 120.0).abs() < 1e-12,
            "scaled to the mass of the source"
        );
        assert_eq!(solver.prepare(&Serial), Ok(0.0));
        assert_eq!(solver.step(&Serial, &mut Silent).status, None);
    });
}

/// A target that would be scaled beyond what the precision holds.
#[test]
fn targets_that_no_number_holds_are_refused() {
    with_empty(|solver| {
        let mut source = scene().densities[0].clone();
        source.iter_mut().for_each(|x| *x *= 1e200);
        solver.set_source(&source).unwrap();
        let mut faint = vec![0.0; 120];
        faint[7] = 1e-200;
        assert_eq!(
            solver.set_keyframe(0, &faint),
            Err(InputError::NotFinite { index: 0 })
        );
        assert_eq!(solver.prepare(&Serial), Err(InputError::NoKeyframe { index: 0 }));
    });
}

/// Solid cells come first: a density that was given before may lie in them.
#[test]
fn solid_cells_after_a_density_are_refused() {
    let mut scene = scene();
    scene.scheme = Scheme::Limited;
    scene.effects.solid = (0..120).map(|cell| cell == 119).collect();
    scene.with::<f64, D2, _>(|solver| {
        assert_eq!(
            solver.set_solids(&scene.effects.solid),
            Err(InputError::SolidsLate)
        );
    });
}

#[test]
fn densities_that_are_refused() {
    with_empty(|solver| {
        let good = scene().densities[0].clone();
        solver.set_source(&good).unwrap();
        let broken = |at: usize, value: f64| {
            let mut density = good.clone();
            density[at] = value;
            density
        };
        let list = [
            (broken(7, f64::NAN), InputError::NotFinite { index: 7 }),
            (broken(119, f64::INFINITY), InputError::NotFinite { index: 119 }),
            (broken(0, f64::NEG_INFINITY), InputError::NotFinite { index: 0 }),
            (broken(60, -1e-9), InputError::Negative { index: 60 }),
            (vec![0.0; 120], InputError::Empty),
            (
                vec![1.0; 119],
                InputError::Length {
                    expected: 120,
                    given: 119,
                },
            ),
            (
                vec![1.0; 121],
                InputError::Length {
                    expected: 120,
                    given: 121,
                },
            ),
            (
                Vec::new(),
                InputError::Length {
                    expected: 120,
                    given: 0,
                },
            ),
        ];
        for (density, error) in list {
            assert_eq!(solver.set_source(&density), Err(error));
            assert_eq!(solver.set_keyframe(0, &density), Err(error));
        }
    });
}

#[test]
fn velocities_that_are_refused() {
    with_empty(|solver| {
        assert_eq!((solver.faces(0), solver.faces(1)), (130, 120));
        assert_eq!(
            solver.set_initial_velocity(2, &[0.0; 120]),
            Err(InputError::Index { given: 2, count: 2 })
        );
        assert_eq!(
            solver.set_initial_velocity(0, &[0.0; 120]),
            Err(InputError::Length {
                expected: 130,
                given: 120
            })
        );
        for value in [f64::NAN, f64::INFINITY] {
            let mut faces = [0.0; 130];
            faces[99] = value;
            assert_eq!(
                solver.set_initial_velocity(0, &faces),
                Err(InputError::NotFinite { index: 99 })
            );
        }
        solver.set_initial_velocity(0, &[0.0; 130]).unwrap();
    });
}

/// A target so small that it underflows when scaled is still a target.
#[test]
fn a_keyframe_may_be_set_again() {
    with_empty(|solver| {
        let good = scene().densities[0].clone();
        solver.set_source(&good).unwrap();
        for index in [0, 1, 0, 1, 1] {
            solver.set_keyframe(index, &good).unwrap();
        }
        solver.prepare(&Serial).unwrap();
        solver
            .set_source(&good.iter().map(|x| 2.0 * x).collect::<Vec<_>>())
            .unwrap();
        assert!(
            solver
                .keyframe(0)
                .iter()
                .zip(&good)
                .all(|(x, y)| (x - y).abs() < 1e-12),
            "a new source leaves the targets"
        );
        assert_eq!(<f64 as Real>::NAME, "f64");
    });
}
