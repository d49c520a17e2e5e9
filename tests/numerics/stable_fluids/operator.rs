//! The simulation as an operator: <cotangents, J d> = <J^T cotangents, d> by differences, and the bits of every number of states.

use super::case::{Scene, built};
use crate::fields::Memory;
use crate::fields::random::Random;
use core::ops::ControlFlow;
use thurible_core::stable_fluids::{Controls, Part, Slots};
use thurible_core::{D2, D3, Fluids, Problem, Serial, Silent, Space};

/// Start and forces: density, velocity by axis, then force by step and axis.
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
        let problem = Problem {
            keyframes: &[],
            templates: &[],
            ..self.scene.problem()
        };
        let mut memory = Memory::new(built::<f64, S>(&problem, &self.scene.params).unwrap());
        let mut fluids = Fluids::<f64, S>::new(&problem, &self.scene.params, memory.block()).unwrap();
        fluids.set_density(&input[0]).unwrap();
        for axis in 0..S::DIM {
            fluids.set_initial_velocity(axis, &input[1 + axis]).unwrap();
        }
        work(&mut fluids)
    }

    /// <cotangents, states after the start>.
    fn value<S: Space>(&self, input: &Input) -> f64 {
        self.with::<S, _>(input, |fluids| {
            let mut sum = 0.0;
            let forces = &mut |step: usize, axis: usize, out: &mut [f64]| {
                out.copy_from_slice(&input[1 + S::DIM + step * S::DIM + axis]);
            };
            let each = &mut |mut moment: thurible_core::stable_fluids::Moment<'_, '_, f64>| {
                let step = moment.step;
                let own = &self.cotangents[step * (1 + S::DIM)..];
                let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
                if step > 0 {
                    sum += dot(&own[0], moment.density());
                    for axis in 0..S::DIM {
                        sum += dot(&own[1 + axis], moment.velocity(axis));
                    }
                }
                ControlFlow::Continue(())
            };
            fluids.simulate(&Serial, &mut Silent, forces, each).unwrap();
            sum
        })
    }

    fn gradient<S: Space>(&self, input: &Input) -> Input {
        let mut gradient: Input = input.clone();
        self.with::<S, _>(input, |fluids| {
            let mut start = vec![vec![0.0; self.scene.count()]; 1 + S::DIM];
            let (mut forces, mut cotangents, mut gradients) = (
                |step: usize, axis: usize, out: &mut [f64]| {
                    out.copy_from_slice(&input[1 + S::DIM + step * S::DIM + axis]);
                },
                |step: usize, part: Part, out: &mut [f64]| {
                    let which = match part {
                        Part::Density => 0,
                        Part::Velocity(axis) => 1 + axis,
                    };
                    out.copy_from_slice(&self.cotangents[step * (1 + S::DIM) + which]);
                    true
                },
                |step: usize, axis: usize, own: &[f64]| {
                    gradient[1 + S::DIM + step * S::DIM + axis].copy_from_slice(own);
                },
            );
            fluids
                .vjp(&Serial, &mut Silent, &mut forces, &mut cotangents, &mut gradients)
                .unwrap();
            fluids.cotangent(Part::Density, &mut start[0]);
            for axis in 0..S::DIM {
                fluids.cotangent(Part::Velocity(axis), &mut start[1 + axis]);
            }
            gradient[..=S::DIM].clone_from_slice(&start);
        });
        gradient
    }
}

fn agrees<S: Space>(cells: &[usize], ends: &str) {
    let operator = Operator::new(cells, ends, Slots::Tape);
    let mut random = Random::new(5);
    let count = operator.scene.count();
    let mut input: Input = vec![operator.scene.source.clone()];
    input.extend(operator.scene.velocity(0.7));
    let fields = operator.scene.steps * S::DIM;
    input.extend((0..fields).map(|_| (0..count).map(|_| 0.05 * random.signed()).collect()));
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
}

#[test]
fn the_product_back_is_the_transpose_of_the_way_forward() {
    agrees::<D2>(&[10, 9], "wp");
    agrees::<D3>(&[6, 5, 5], "www");
}

#[test]
fn there_is_no_way_back_where_nothing_is_kept() {
    let operator = Operator::new(&[8, 8], "ww", Slots::None);
    let mut input: Input = vec![operator.scene.source.clone()];
    input.extend(operator.scene.velocity(0.7));
    let ended = operator.with::<D2, _>(&input, |fluids| {
        let (mut forces, mut cotangents, mut gradients) = (
            |_: usize, _: usize, _: &mut [f64]| {},
            |_: usize, _: Part, _: &mut [f64]| false,
            |_: usize, _: usize, _: &[f64]| {},
        );
        fluids.vjp(&Serial, &mut Silent, &mut forces, &mut cotangents, &mut gradients)
    });
    assert_eq!(ended, Err(thurible_core::Status::NotReady));
}
