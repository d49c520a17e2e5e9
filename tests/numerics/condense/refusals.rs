//! What is refused, by name.

use super::bench::Bench;
use crate::fields::Memory;
use thurible_core::condense::{
    Basis, Block, CondenseError, CondenseParams, CondensePlan, Condenser, Mesh, Order, Spring, Step,
    Topology, Update,
};
use thurible_core::{Serial, Silent};

fn refused(mesh: Mesh<'_>, params: CondenseParams) -> CondenseError {
    let mut words = vec![0; Topology::words(&mesh)];
    match Topology::new(&mesh, params.radius, &mut words) {
        Err(error) => error,
        Ok(topology) => CondensePlan::new::<f64>(&mesh, &topology, &params).unwrap_err(),
    }
}

/// What `change` makes of a square is refused.
fn changed(change: impl FnOnce(&mut Bench)) -> CondenseError {
    let mut bench = Bench::stretch(2, 2);
    change(&mut bench);
    refused(bench.mesh(), CondenseParams::default())
}

#[test]
fn meshes_that_are_none_are_refused() {
    let turned = changed(|bench| bench.elements[9..12].reverse());
    assert_eq!(turned, CondenseError::Inverted { element: 3 });
    assert!(turned.to_string().contains("element 3 is inverted"));
    assert_eq!(
        changed(|bench| bench.elements[4] = bench.elements[3]),
        CondenseError::Inverted { element: 1 }
    );
    assert_eq!(
        changed(|bench| bench.elements[7] = 9),
        CondenseError::Corner { element: 2 }
    );
    assert_eq!(
        changed(|bench| bench.rest[5] = f64::NAN),
        CondenseError::Position { vertex: 2 }
    );
    assert_eq!(
        changed(|bench| assert!(bench.rest.pop().is_some())),
        CondenseError::Lengths
    );
    assert_eq!(
        changed(|bench| assert!(bench.elements.pop().is_some())),
        CondenseError::Lengths
    );
    assert_eq!(changed(|bench| bench.held.fill(true)), CondenseError::AllHeld);
    assert_eq!(changed(|bench| bench.held.fill(false)), CondenseError::NoneHeld);
    for (poisson, wrong) in [
        (0.5, true),
        (-1.0, true),
        (f64::NAN, true),
        (0.49, false),
        (-0.99, false),
    ] {
        let mut bench = Bench::stretch(2, 2);
        bench.material.poisson = poisson;
        let expected = CondenseError::Setting {
            name: "poisson",
            allowed: "above -1 and below 1/2",
        };
        assert_eq!(bench.mesh().check().err(), wrong.then_some(expected), "{poisson}");
    }
    for name in ["young", "density"] {
        let error = changed(|bench| {
            *(if name == "young" {
                &mut bench.material.young
            } else {
                &mut bench.material.density
            }) = 0.0;
        });
        assert_eq!(
            error,
            CondenseError::Setting {
                name,
                allowed: "above 0"
            }
        );
    }
}

#[test]
fn parts_that_nothing_holds_are_refused() {
    let loose = changed(|bench| {
        bench.rest.extend([3.0, 3.0]);
        bench.held.push(false);
        bench.regular = [0; 3];
    });
    assert_eq!(loose, CondenseError::Loose { vertex: 9 });
    // A triangle beside the square.
    let unheld = changed(|bench| {
        bench.rest.extend([3.0, 3.0, 4.0, 3.0, 3.0, 4.0]);
        bench.held.extend([false; 3]);
        bench.elements.extend([9, 10, 11]);
        bench.regular = [0; 3];
    });
    assert_eq!(unheld, CondenseError::Unheld { vertex: 9 });
    // Joined by a spring to what is held, or with inertia, it is not.
    let mut bench = Bench::stretch(2, 2);
    bench.rest.extend([3.0, 3.0, 4.0, 3.0, 3.0, 4.0]);
    bench.held.extend([false; 3]);
    bench.elements.extend([9, 10, 11]);
    bench.regular = [0; 3];
    bench.run::<f64, 2, _>(
        CondenseParams {
            dt: Some(0.1),
            ..CondenseParams::default()
        },
        |_| (),
    );
    bench.springs.push(Spring {
        ends: [9, 0],
        stiffness: 1.0,
        rest_length: 1.0,
        in_basis: true,
    });
    bench.run::<f64, 2, _>(CondenseParams::default(), |_| ());
    for (ends, stiffness, rest_length) in [
        ([9, 9], 1.0, 1.0),
        ([0, 90], 1.0, 1.0),
        ([0, 9], 0.0, 1.0),
        ([0, 9], 1.0, -1.0),
    ] {
        bench.springs[0] = Spring {
            ends,
            stiffness,
            rest_length,
            in_basis: true,
        };
        assert_eq!(bench.mesh().check(), Err(CondenseError::Spring { spring: 0 }));
    }
}

#[test]
fn choices_that_do_not_go_together_are_refused() {
    let base = CondenseParams::default();
    let check = |params: CondenseParams| params.check(2).unwrap_err();
    for method in [Update::Newton, Update::Plain] {
        let name = thurible_core::Named::name(method);
        assert_eq!(
            check(CondenseParams {
                method,
                basis: Basis::Rebuilt,
                ..base
            }),
            CondenseError::NoBasis { method: name }
        );
        assert_eq!(
            check(CondenseParams {
                method,
                radius: Some(2),
                ..base
            }),
            CondenseError::NoBasis { method: name }
        );
    }
    assert_eq!(
        check(CondenseParams {
            method: Update::Chord,
            basis: Basis::Corotated,
            ..base
        }),
        CondenseError::NoTurn { with: "chord" }
    );
    for basis in [
        Basis::Corotated,
        Basis::CorotatedRebuilt,
        Basis::CorotatedAdaptive,
    ] {
        assert_eq!(
            check(CondenseParams {
                basis,
                block: Block::Scalar,
                ..base
            }),
            CondenseError::NoTurn { with: "scalar" }
        );
    }
    for method in [
        Update::Cc,
        Update::Newton,
        Update::Jgs2,
        Update::Projected,
        Update::Chord,
        Update::Warped,
    ] {
        let name = thurible_core::Named::name(method);
        assert_eq!(
            check(CondenseParams {
                method,
                order: Order::Colours,
                ..base
            }),
            CondenseError::Colours { method: name }
        );
    }
    assert!(
        CondenseParams {
            method: Update::Plain,
            order: Order::Colours,
            ..base
        }
        .check(2)
        .is_ok()
    );
    assert!(
        CondenseParams {
            method: Update::Jgs2,
            order: Order::Colours,
            ..base
        }
        .check(1)
        .is_ok()
    );
    let wrong = [
        (
            "tolerance",
            CondenseParams {
                tolerance: 0.0,
                ..base
            },
        ),
        ("cap", CondenseParams { cap: 0, ..base }),
        ("rebuild", CondenseParams { rebuild: 0, ..base }),
        ("threads", CondenseParams { threads: 0, ..base }),
        ("noise", CondenseParams { noise: -1.0, ..base }),
        (
            "dt",
            CondenseParams {
                dt: Some(0.0),
                ..base
            },
        ),
    ];
    for (name, params) in wrong {
        let error = check(params);
        assert!(
            matches!(error, CondenseError::Setting { name: found, .. } if found == name),
            "{error}"
        );
        assert!(error.to_string().contains(name));
    }
}

#[test]
fn a_byte_too_little_and_values_that_do_not_fit_are_refused() {
    let bench = Bench::stretch(2, 3);
    let mesh = bench.mesh();
    let mut words = vec![0; Topology::words(&mesh)];
    let params = CondenseParams::default();
    let error = Topology::new(&mesh, None, &mut words[1..]).unwrap_err();
    assert_eq!(
        error,
        CondenseError::Memory {
            needed: 4 * Topology::words(&mesh)
        }
    );
    let topology = Topology::new(&mesh, None, &mut words).unwrap();
    let needed = CondensePlan::new::<f64>(&mesh, &topology, &params)
        .unwrap()
        .bytes();
    let error = |by: usize, less: usize| {
        let mut memory = Memory::new(needed - less);
        Condenser::<f64, 2>::new(mesh, topology, params, memory.shifted(by)).err()
    };
    assert_eq!(error(0, 1), Some(CondenseError::Memory { needed }));
    assert_eq!(error(0, 0), None);
    let mut memory = Memory::new(needed + 8);
    let off = Condenser::<f64, 2>::new(mesh, topology, params, memory.shifted(8)).err();
    assert_eq!(off, Some(CondenseError::Memory { needed }));
    let mut memory = Memory::new(needed);
    assert_eq!(
        Condenser::<f64, 3>::new(mesh, topology, params, memory.block()).err(),
        Some(CondenseError::Lengths)
    );
    bench.run::<f64, 2, _>(params, |run| {
        let mut shift = vec![0.0; bench.rest.len()];
        assert_eq!(run.shift(&shift[1..]), Err(CondenseError::Values));
        assert_eq!(run.set_velocity(&shift), Err(CondenseError::Values));
        shift[3] = f64::INFINITY;
        let step = Step {
            shift: &shift,
            ..Step::default()
        };
        assert_eq!(
            run.step(&Serial, &step, &mut Silent, &mut |_| {}).err(),
            Some(CondenseError::Values)
        );
        assert_eq!((run.steps(), run.builds()), (0, 0));
    });
}
