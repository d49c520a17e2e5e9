//! Runs of the operator: the same bits whatever is kept and however many threads there are, its memory, long horizons, and what it refuses.

use crate::fields::{Memory, boundaries, with_threads};
use crate::operator::{Case, Covectors, Inputs, Trajectory, simulate, vjp};
use thurible_core::memory::Sharing;
use thurible_core::operator::{Input, OperatorError, Start};
use thurible_core::problem::MAX_STEPS;
use thurible_core::reversal::repeated_steps;
use thurible_core::{D2, D3, Operator, OperatorParams, OperatorPlan, Problem, Scheme, Serial, Silent, Space};

fn with_params(case: &Case, slots: Option<usize>, threads: usize) -> Case {
    Case {
        params: OperatorParams {
            slots,
            threads,
            ..case.params
        },
        ..case.clone()
    }
}

/// The trajectory, the gradient twice, and the steps that the second and the first repeated.
fn run<S: Space>(case: &Case, threads: usize) -> (Trajectory, [Inputs; 2], [usize; 2]) {
    let inputs = case.draw(11, 0.8);
    let covectors = Covectors::draw(case, &inputs, 13);
    case.with::<f64, S, _>(&inputs, |operator| {
        with_threads(threads, |exec| {
            let trajectory = simulate(operator, exec, &inputs).unwrap();
            let first = vjp(operator, exec, &inputs, &covectors).unwrap();
            let of_first = operator.repeated();
            let again = vjp(operator, exec, &inputs, &covectors).unwrap();
            (trajectory, [first, again], [of_first, operator.repeated()])
        })
    })
}

fn same_bits<S: Space>(case: &Case) {
    let steps = case.steps;
    let (trajectory, gradients, _) = run::<S>(case, 1);
    assert_eq!(gradients[0], gradients[1], "the second gradient is another one");
    for slots in [1, 2, 5, steps] {
        let plan = case.plan::<f64, S>(&with_params(case, Some(slots), 1).params);
        assert_eq!(
            (plan.slots(), plan.repeated_steps()),
            (slots, repeated_steps(steps, slots))
        );
        let (other, found, repeated) = run::<S>(&with_params(case, Some(slots), 1), 1);
        assert!(other == trajectory && found == gradients, "{slots} slots");
        assert_eq!(repeated, [repeated_steps(steps, slots); 2], "{slots} slots");
    }
    for threads in [2, 3] {
        let (other, found, _) = run::<S>(&with_params(case, None, threads), threads);
        assert!(other == trajectory && found == gradients, "{threads} threads");
    }
}

#[test]
fn neither_slots_nor_threads_change_a_bit() {
    same_bits::<D2>(&Case::new(&[12, 9], "wp", 7).emitting().with_templates());
    same_bits::<D3>(&Case::new(&[6, 5, 7], "wpw", 6).among_solids().emitting());
}

/// The gradient by smoke where there is none yet: `central` is linear in the density.
#[test]
fn cells_without_smoke_have_their_gradient() {
    let case = Case::new(&[24, 20], "ww", 3).smooth();
    let mut inputs = case.draw(17, 0.9);
    let far = |at: usize| at / 24 > 4;
    for (at, x) in inputs.density.iter_mut().enumerate() {
        if far(at) {
            *x = 0.0;
        }
    }
    let covectors = Covectors::draw(&case, &inputs, 19);
    let gradient = case.with::<f64, D2, _>(&inputs, |operator| {
        simulate(operator, &Serial, &inputs).unwrap();
        vjp(operator, &Serial, &inputs, &covectors).unwrap()
    });
    for at in [10 * 24 + 7, 19 * 24 + 23, 6 * 24] {
        let value = |t: f64| {
            let mut moved = inputs.clone();
            moved.density[at] += t;
            case.with::<f64, D2, _>(&moved, |operator| {
                simulate(operator, &Serial, &moved).unwrap().with(&covectors)
            })
        };
        let slope = (value(1e-4) - value(-1e-4)) / 2e-4;
        assert!(
            (slope - gradient.density[at]).abs() < 1e-6 * slope.abs().max(1.0),
            "cell {at}: {slope} by differences, {} by the adjoint",
            gradient.density[at]
        );
    }
}

/// Where the shape of an emitter that pushes is even, its part at a face is at a kink, as it is where the shape is 1: the gradient is the mean of both
/// sides, which central differences have too.
#[test]
fn even_shapes_have_the_mean_of_both_sides() {
    let case = Case::new(&[12, 10], "wp", 3).smooth().emitting();
    for part in [0.6, 1.0] {
        let mut inputs = case.draw(23, 0.5);
        for (at, x) in inputs.shapes[0].iter_mut().enumerate() {
            *x = if (3..8).contains(&(at % 12)) { part } else { 0.0 };
        }
        let covectors = Covectors::draw(&case, &inputs, 29);
        let gradient = case.with::<f64, D2, _>(&inputs, |operator| {
            simulate(operator, &Serial, &inputs).unwrap();
            vjp(operator, &Serial, &inputs, &covectors).unwrap()
        });
        for at in [3 * 12 + 5, 7 * 12 + 3, 9 * 12 + 7, 6] {
            let value = |t: f64| {
                let mut moved = inputs.clone();
                moved.shapes[0][at] += t;
                case.with::<f64, D2, _>(&moved, |operator| {
                    simulate(operator, &Serial, &moved).unwrap().with(&covectors)
                })
            };
            let slope = (value(1e-5) - value(-1e-5)) / 2e-5;
            let own = gradient.shapes[0][at];
            assert!(
                (slope - own).abs() < 1e-4 * slope.abs().max(1e-2),
                "{part}, cell {at}: {slope} by differences, {own} by the adjoint"
            );
        }
    }
}

#[test]
fn plans_are_exact_and_one_byte_less_is_refused() {
    for (case, dims) in [
        (Case::new(&[12, 9], "wp", 7).emitting(), 2),
        (Case::new(&[9, 12], "ow", 4).among_solids(), 2),
        (Case::new(&[6, 5, 7], "ppp", 5), 3),
    ] {
        if dims == 2 {
            plan_of::<D2>(&case);
        } else {
            plan_of::<D3>(&case);
        }
    }
}

fn plan_of<S: Space>(case: &Case) {
    let boundary = boundaries(case.ends);
    let problem = Problem {
        steps: case.steps,
        emitters: &case.emitters,
        solids: !case.solid.is_empty(),
        ..Problem::new(&case.cells, &boundary, &[])
    };
    let whole = OperatorPlan::new::<f64, S>(&problem, &case.params).unwrap();
    assert_eq!((whole.slots(), whole.next_slot()), (case.steps, None));
    let sum: usize = whole
        .entries()
        .iter()
        .filter(|entry| entry.depth == 0)
        .map(|entry| entry.bytes)
        .sum();
    assert_eq!(sum, whole.bytes());
    assert!(
        whole
            .entries()
            .iter()
            .any(|entry| entry.name == "kept states" && entry.sharing == Sharing::Buffer)
    );
    let mut memory = Memory::new(whole.bytes() - 1);
    assert!(Operator::<f64, S>::new(&problem, &case.params, memory.block()).is_err());
    // Every ceiling from that of one state on holds as many as there is room for.
    let with = |slots, ceiling| {
        OperatorPlan::new::<f64, S>(
            &problem,
            &OperatorParams {
                slots,
                ceiling,
                ..case.params
            },
        )
    };
    for slots in 1..case.steps {
        let plan = with(Some(slots), None).unwrap();
        let next = plan.next_slot().unwrap();
        assert!(next > plan.bytes());
        for (ceiling, fits) in [(plan.bytes(), slots), (next - 1, slots), (next, slots + 1)] {
            let fitted = with(None, Some(ceiling)).unwrap();
            assert_eq!(fitted.slots(), fits);
            assert!(fitted.bytes() <= ceiling);
        }
        let refused = with(Some(slots), Some(plan.bytes() - 1)).unwrap_err().to_string();
        assert!(refused.contains("bytes are needed at least"), "{refused}");
    }
    let least = with(Some(1), None).unwrap().bytes();
    assert!(with(None, Some(least - 1)).is_err());
}

#[test]
fn single_precision_is_close() {
    let case = Case::new(&[12, 10], "wp", 6).emitting();
    let inputs = case.draw(3, 0.7);
    let covectors = Covectors::draw(&case, &inputs, 5);
    let exact = case.with::<f64, D2, _>(&inputs, |operator| {
        simulate(operator, &Serial, &inputs).unwrap();
        vjp(operator, &Serial, &inputs, &covectors).unwrap()
    });
    let found = case.with::<f32, D2, _>(&inputs, |operator| {
        simulate(operator, &Serial, &inputs).unwrap();
        vjp(operator, &Serial, &inputs, &covectors).unwrap()
    });
    let apart = found.plus(-1.0, &exact);
    let [far, size] = [&apart, &exact].map(|x| x.dot(x, |_| true).sqrt());
    assert!(far < 1e-3 * size, "{far:e} of {size:e}");
}

/// A thousand steps of a flow that turns in a ring: all numbers stay finite, the gradient is that of differences, and 30 states are enough.
#[test]
fn a_thousand_steps_stay_finite() {
    let case = Case {
        viscosity: 2e-3,
        params: OperatorParams {
            slots: Some(30),
            ..Case::new(&[8, 8, 8], "ppp", 1000).params
        },
        ..Case::new(&[8, 8, 8], "ppp", 1000).smooth()
    };
    let mut inputs = case.draw(23, 0.3);
    inputs.density.fill(0.0);
    inputs
        .forces
        .iter_mut()
        .flatten()
        .flatten()
        .for_each(|x| *x = 0.0);
    inputs.buoyancy.fill(0.0);
    let mut covectors = Covectors::draw(&case, &inputs, 29);
    covectors.density.iter_mut().flatten().for_each(|x| *x = 0.0);
    let last = covectors.velocity.len() - 1;
    covectors
        .velocity
        .iter_mut()
        .take(last)
        .flatten()
        .flatten()
        .for_each(|x| *x = 0.0);
    let of_end = |found: &Trajectory| -> f64 {
        let ends = found.velocity[last].iter().flatten();
        ends.zip(covectors.velocity[last].iter().flatten())
            .map(|(x, y)| x * y)
            .sum()
    };
    let gradient = case.with::<f64, D3, _>(&inputs, |operator| {
        simulate(operator, &Serial, &inputs).unwrap();
        vjp(operator, &Serial, &inputs, &covectors).unwrap()
    });
    let finite = gradient
        .velocity
        .iter()
        .flatten()
        .chain(gradient.forces.iter().flatten().flatten());
    assert!(finite.clone().all(|x| x.is_finite()) && finite.clone().any(|&x| x != 0.0));
    let mut along = case.direction(&inputs, 31);
    along.forces.iter_mut().flatten().flatten().for_each(|x| *x = 0.0);
    let slope = gradient.dot(&along, |kind| kind == 1);
    let value = |t: f64| {
        let moved = inputs.plus(t, &along);
        case.with::<f64, D3, _>(&moved, |operator| {
            of_end(&simulate(operator, &Serial, &moved).unwrap())
        })
    };
    let found = (value(1e-4) - value(-1e-4)) / 2e-4;
    assert!(
        (found - slope).abs() < 1e-4 * slope.abs(),
        "{slope:e} by the adjoint, {found:e} by differences"
    );
}

#[test]
fn what_is_wrong_is_refused() {
    let case = Case::new(&[8, 7], "wp", 3).emitting();
    let inputs = case.draw(3, 0.5);
    let covectors = Covectors::draw(&case, &inputs, 5);
    case.with::<f64, D2, _>(&inputs, |operator| {
        assert_eq!(
            vjp(operator, &Serial, &inputs, &covectors),
            Err(OperatorError::NotSimulated)
        );
        let mut wrong = inputs.clone();
        wrong.density.pop();
        let refused = simulate(operator, &Serial, &wrong).unwrap_err();
        assert!(
            matches!(
                refused,
                OperatorError::Input {
                    what: Input::Density,
                    ..
                }
            ),
            "{refused}"
        );
        wrong = inputs.clone();
        wrong.velocity[1][3] = f64::NAN;
        let refused = simulate(operator, &Serial, &wrong).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "the velocity at the start is refused: value 3 is not finite"
        );
        wrong = inputs.clone();
        wrong.forces[1][0][0] = f64::INFINITY;
        let refused = simulate(operator, &Serial, &wrong).unwrap_err();
        assert!(
            matches!(
                refused,
                OperatorError::Input {
                    what: Input::Force { step: 1 },
                    ..
                }
            ),
            "{refused}"
        );
        assert_eq!(
            vjp(operator, &Serial, &inputs, &covectors),
            Err(OperatorError::NotSimulated)
        );
        wrong = inputs.clone();
        wrong.velocity[0].iter_mut().for_each(|x| *x *= 1e6);
        let refused = simulate(operator, &Serial, &wrong).unwrap_err();
        assert_eq!(refused, OperatorError::TooFast { step: 0 });
        simulate(operator, &Serial, &inputs).unwrap();
        let mut other = covectors.clone();
        other.density[2][1] = f64::NAN;
        let refused = vjp(operator, &Serial, &inputs, &other).unwrap_err();
        assert!(
            matches!(
                refused,
                OperatorError::Input {
                    what: Input::Cotangent { step: 2 },
                    ..
                }
            ),
            "{refused}"
        );
        // What was simulated is still there.
        let gradient = vjp(operator, &Serial, &inputs, &covectors).unwrap();
        simulate(operator, &Serial, &inputs).unwrap();
        assert_eq!(vjp(operator, &Serial, &inputs, &covectors).unwrap(), gradient);
        assert!(operator.set_emitter(9, &inputs.density).is_err());
        assert!(operator.set_solids(&[true; 56]).is_err());
    });
}

#[test]
fn emitters_must_be_shaped_and_plans_checked() {
    let case = Case::new(&[8, 7], "wp", 3).emitting();
    let mut inputs = case.draw(3, 0.5);
    inputs.shapes.clear();
    case.with::<f64, D2, _>(&inputs, |operator| {
        let refused = simulate(operator, &Serial, &inputs).unwrap_err();
        assert!(
            matches!(
                refused,
                OperatorError::Input {
                    what: Input::Emitter { index: 0 },
                    ..
                }
            ),
            "{refused}"
        );
    });
    let boundary = boundaries("wp");
    let problem = Problem {
        steps: 3,
        ..Problem::new(&[8, 7], &boundary, &[])
    };
    let params = OperatorParams::default();
    let refused = |problem: &Problem<'_>, params: &OperatorParams| {
        OperatorPlan::new::<f64, D2>(problem, params)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        refused(
            &problem,
            &OperatorParams {
                slots: Some(4),
                ..params
            }
        ),
        "operator.slots is 4; it must be from 1 to 3"
    );
    assert_eq!(
        refused(
            &problem,
            &OperatorParams {
                tolerance: 0.0,
                ..params
            }
        ),
        "operator.tolerance is 0; it must be positive and finite"
    );
    assert!(refused(&problem, &OperatorParams { threads: 0, ..params }).contains("threads"));
    assert_eq!(
        refused(&Problem { steps: 0, ..problem }, &params),
        format!("steps is 0; it must be from 1 to {}", MAX_STEPS - 1)
    );
    let open = boundaries("ow");
    let problem = Problem {
        boundary: &open,
        advection: thurible_core::Advection {
            scheme: Scheme::Quick,
            tolerance: 1e-5,
        },
        ..problem
    };
    assert!(refused(&problem, &params).contains("limited"));
    let mut memory = Memory::new(1 << 20);
    let start = Start {
        density: &[0.0; 56],
        velocity: [&[]; 3],
    };
    let walls = boundaries("ww");
    let problem = Problem {
        steps: 2,
        ..Problem::new(&[8, 7], &walls, &[])
    };
    let mut operator = Operator::<f64, D2>::new(&problem, &params, memory.block()).unwrap();
    // Nothing moves at rest, and nothing that is not given is read.
    operator
        .simulate(&Serial, &mut Silent, &start, &mut |_, _| {}, &mut |_, view| {
            assert!(
                view.vector(0)
                    .numbers
                    .iter()
                    .chain(view.density().numbers)
                    .all(|&x| x == 0.0)
            );
        })
        .unwrap();
}
