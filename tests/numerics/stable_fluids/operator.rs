//! The simulation as an operator: <cotangents, J d> = <J^T cotangents, d> by differences, and the bits of every number of states.

use super::case::{Scene, built};
use crate::fields::Memory;
use crate::fields::random::Random;
use thurible_core::operator::{Given, Input as What, OperatorError, Show, Simulator, Start, View};
use thurible_core::solver::InputError;
use thurible_core::stable_fluids::{Controls, Slots};
use thurible_core::{D2, D3, Fluids, Problem, Serial, Silent, Space};

/// Start and pushes: density, velocity by axis, then force by step and axis, then the acceleration of buoyancy.
type Input = Vec<Vec<f64>>;

struct Operator {
    scene: Scene,
    cotangents: Vec<Vec<f64>>,
}

impl Operator {
    fn new(cells: &[usize], ends: &str, slots: Slots) -> Self {
        let mut scene = Scene::new(cells, ends, &[]).kept(slots);
        scene.params.controls = Controls::none();
        scene.params.diffusion = 1e-3;
        let mut random = Random::new(3);
        let parts = (1 + cells.len()) * (scene.steps + 1);
        let cotangents = (0..parts)
            .map(|_| (0..scene.count()).map(|_| random.signed()).collect())
            .collect();
        Operator { scene, cotangents }
    }

    fn with<S: Space, R>(&self, input: &Input, work: impl FnOnce(&mut Fluids<'_, f64, S>) -> R) -> R {
        let lift = &input[input.len() - 1];
        let problem = Problem {
            keyframes: &[],
            buoyancy: core::array::from_fn(|axis| lift.get(axis).copied().unwrap_or(0.0)),
            ..self.scene.problem()
        };
        let mut memory = Memory::new(built::<f64, S>(&problem, &self.scene.params).unwrap());
        let mut fluids = Fluids::<f64, S>::new(&problem, &self.scene.params, memory.block()).unwrap();
        work(&mut fluids)
    }

    /// <cotangents, states>.
    fn value<S: Space>(&self, input: &Input) -> f64 {
        self.with::<S, _>(input, |fluids| {
            let mut sum = 0.0;
            let mut field = vec![0.0; self.scene.count()];
            let show = &mut |step: usize, view: &View<'_, f64>| {
                let own = &self.cotangents[step * (1 + S::DIM)..];
                let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
                view.read_density(&mut field);
                sum += dot(&own[0], &field);
                for axis in 0..S::DIM {
                    view.read_vector(axis, &mut field);
                    sum += dot(&own[1 + axis], &field);
                    let lies = view.vector(axis);
                    let at = lies.numbers[lies.strides[0] + 2 * lies.strides[1]] * lies.unit;
                    assert_eq!(at, field[1 + 2 * lies.extent[0]]);
                }
            };
            simulate(fluids, input, show).unwrap();
            sum
        })
    }

    fn gradient<S: Space>(&self, input: &Input) -> Input {
        let mut gradient: Input = input.clone();
        self.with::<S, _>(input, |fluids| {
            simulate(fluids, input, &mut |_, _| {}).unwrap();
            let cotangent = &mut |step: usize, given: &mut Given<'_, f64>| {
                let own = &self.cotangents[step * (1 + S::DIM)..];
                given.density(&own[0]);
                (0..S::DIM).for_each(|axis| given.vector(axis, &own[1 + axis]));
            };
            let show = &mut |step: usize, view: &View<'_, f64>| {
                for axis in 0..S::DIM {
                    view.read_vector(axis, &mut gradient[1 + S::DIM + step * S::DIM + axis]);
                }
            };
            fluids
                .vjp(&Serial, &mut Silent, &mut forces::<S>(input), cotangent, show)
                .unwrap();
            let start = Simulator::gradient(fluids);
            start.read_density(&mut gradient[0]);
            for axis in 0..S::DIM {
                start.read_vector(axis, &mut gradient[1 + axis]);
            }
            let last = gradient.len() - 1;
            gradient[last] = fluids.buoyancy_gradient()[..S::DIM].to_vec();
        });
        gradient
    }
}

/// Gives the forces of an input.
fn forces<S: Space>(input: &Input) -> impl FnMut(usize, &mut Given<'_, f64>) + '_ {
    move |step, given| {
        for axis in 0..S::DIM {
            given.vector(axis, &input[1 + S::DIM + step * S::DIM + axis]);
        }
    }
}

fn simulate<S: Space>(
    fluids: &mut Fluids<'_, f64, S>,
    input: &Input,
    show: &mut Show<'_, f64>,
) -> Result<(), OperatorError> {
    let start = Start {
        density: &input[0],
        velocity: core::array::from_fn(|axis| if axis < S::DIM { &input[1 + axis][..] } else { &[] }),
    };
    fluids.simulate(&Serial, &mut Silent, &start, &mut forces::<S>(input), show)
}

fn agrees<S: Space>(cells: &[usize], ends: &str) {
    let operator = Operator::new(cells, ends, Slots::Tape);
    let mut random = Random::new(5);
    let count = operator.scene.count();
    let mut input: Input = vec![operator.scene.source.clone()];
    input.extend(operator.scene.velocity(0.7));
    let fields = operator.scene.steps * S::DIM;
    input.extend((0..fields).map(|_| (0..count).map(|_| 0.05 * random.signed()).collect()));
    input.push((0..S::DIM).map(|_| 0.1 * random.signed()).collect());
    let gradient = operator.gradient::<S>(&input);
    for slots in [1, 2, 5] {
        let other = Operator::new(cells, ends, Slots::States(slots));
        assert!(other.gradient::<S>(&input) == gradient, "{slots} slots");
    }
    let way: Input = input
        .iter()
        .map(|field| field.iter().map(|_| random.signed()).collect())
        .collect();
    let along: f64 = gradient
        .iter()
        .flatten()
        .zip(way.iter().flatten())
        .map(|(g, d)| g * d)
        .sum();
    let moved = |h: f64| -> Input {
        let add = |(x, d): (&Vec<f64>, &Vec<f64>)| x.iter().zip(d).map(|(x, d)| x + h * d).collect();
        input.iter().zip(&way).map(add).collect()
    };
    let gap = |h: f64| {
        let difference = (operator.value::<S>(&moved(h)) - operator.value::<S>(&moved(-h))) / (2.0 * h);
        (difference - along).abs() / along.abs()
    };
    let best = gap(1e-6).min(gap(1e-7));
    assert!(best < 1e-5, "{best:e}");
    let lift = gradient.len() - 1;
    let alone = |sign: f64| {
        let mut other = input.clone();
        other[lift][1] += sign * 1e-6;
        operator.value::<S>(&other)
    };
    let difference = (alone(1.0) - alone(-1.0)) / 2e-6;
    let gap = (difference - gradient[lift][1]).abs() / difference.abs();
    assert!(gap < 1e-5, "by buoyancy {gap:e}");
}

#[test]
fn the_product_back_is_the_transpose_of_the_way_forward() {
    agrees::<D2>(&[10, 9], "wp");
    agrees::<D3>(&[6, 5, 5], "www");
}

/// An operator in 2D, and what it begins with.
fn plane(slots: Slots) -> (Operator, Input) {
    let operator = Operator::new(&[8, 12], "wp", slots);
    let mut input: Input = vec![operator.scene.source.clone()];
    input.extend(operator.scene.velocity(0.7));
    input.extend(vec![vec![0.0; 96]; 2 * operator.scene.steps]);
    input.push(vec![0.0; 2]);
    (operator, input)
}

fn back(fluids: &mut Fluids<'_, f64, D2>, input: &Input, cotangent: f64) -> Result<(), OperatorError> {
    let wrong = &mut |_: usize, given: &mut Given<'_, f64>| given.density(&[cotangent; 96]);
    fluids.vjp(
        &Serial,
        &mut Silent,
        &mut forces::<D2>(input),
        wrong,
        &mut |_, _| {},
    )
}

#[test]
fn there_is_no_way_back_where_nothing_is_kept_or_simulated() {
    for (slots, error) in [
        (Slots::None, OperatorError::NothingKept),
        (Slots::Tape, OperatorError::NotSimulated),
    ] {
        let (operator, input) = plane(slots);
        let ended = operator.with::<D2, _>(&input, |fluids| back(fluids, &input, 1.0));
        assert_eq!(ended, Err(error));
    }
}

#[test]
fn a_new_simulation_has_repeated_nothing_yet() {
    let (operator, input) = plane(Slots::States(1));
    operator.with::<D2, _>(&input, |fluids| {
        simulate(fluids, &input, &mut |_, _| {}).unwrap();
        back(fluids, &input, 1.0).unwrap();
        assert!(Simulator::repeated(fluids) > 0);
        simulate(fluids, &input, &mut |_, _| {}).unwrap();
        assert_eq!(Simulator::repeated(fluids), 0);
    });
}

#[test]
fn what_is_given_is_refused_by_name() {
    let (operator, mut input) = plane(Slots::States(2));
    let refused = |what: What, error: InputError| Err(OperatorError::Input { what, error });
    let mut asked = 0;
    let ended = operator.with::<D2, _>(&input, |fluids| {
        simulate(fluids, &input, &mut |_, _| {}).unwrap();
        let wrong = &mut |_: usize, given: &mut Given<'_, f64>| {
            asked += 1;
            given.density(&[f64::NAN; 96]);
        };
        let forces = &mut forces::<D2>(&input);
        fluids.vjp(&Serial, &mut Silent, forces, wrong, &mut |_, _| {})
    });
    assert_eq!(asked, 1, "nothing is asked for after a refusal");
    let index = 0;
    let step = operator.scene.steps;
    assert_eq!(
        ended,
        refused(What::Cotangent { step }, InputError::NotFinite { index })
    );
    input[3 + 2 * 3 + 1][9] = f64::INFINITY;
    let mut shown = 0;
    let mut run = |input: &Input| {
        operator.with::<D2, _>(input, |fluids| {
            shown = 0;
            simulate(fluids, input, &mut |_, _| shown += 1)
        })
    };
    let index = 9;
    assert_eq!(
        run(&input),
        refused(What::Force { step: 3 }, InputError::NotFinite { index })
    );
    assert_eq!(shown, 4, "the states before the force");
    let run = |input: &Input| operator.with::<D2, _>(input, |fluids| simulate(fluids, input, &mut |_, _| {}));
    // Along a ring nothing holds it.
    for step in 0..step {
        input[3 + 2 * step + 1].fill(f64::MAX);
    }
    assert_eq!(run(&input), Err(OperatorError::TooFast { step: step - 1 }));
    input[0].pop();
    let (expected, given) = (96, 95);
    assert_eq!(
        run(&input),
        refused(What::Density, InputError::Length { expected, given })
    );
}
