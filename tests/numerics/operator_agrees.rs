//! The operator against what there was before it: the trajectory of `simulate` bit by bit, and the gradient of adjoint control.

use crate::fields::cases::StopOnce;
use crate::fields::control::Control;
use crate::fields::random::Random;
use crate::fields::{Components, Memory, boundaries, grid, to_file, zeros};
use crate::operator::{Case, Inputs, Trajectory, simulate};
use thurible_core::objective::script::Lists;
use thurible_core::operator::Start;
use thurible_core::output::{DENSITY, VELOCITY};
use thurible_core::{
    Advection, D2, D3, Method, Operator, OperatorParams, OperatorPlan, Params, Problem, Scheme, Serial,
    Silent, Solver, Space,
};

/// What `simulate` marches through, before its result is made feasible: it is stopped when the last density is there.
fn marched<S: Space>(case: &Case, inputs: &Inputs) -> Trajectory {
    let (boundary, emitters) = (boundaries(case.ends), case.emitters(inputs));
    let problem = case.problem(&boundary, &emitters, &inputs.buoyancy);
    let mut params = Params {
        method: Method::Simulate,
        ..Params::default()
    };
    params.simulation.tolerance = case.params.tolerance;
    let plan = thurible_core::Plan::new::<f64, S>(&problem, &params).unwrap();
    let mut events = usize::MAX;
    loop {
        let mut memory = Memory::new(plan.bytes());
        let mut solver = Solver::<f64, S>::new(&problem, &params, memory.block()).unwrap();
        if !case.solid.is_empty() {
            solver.set_solids(&case.solid).unwrap();
        }
        solver.set_source(&inputs.density).unwrap();
        for (index, shape) in inputs.shapes.iter().enumerate() {
            solver.set_emitter(index, shape).unwrap();
        }
        for (axis, v) in inputs.velocity.iter().enumerate() {
            solver.set_initial_velocity(axis, v).unwrap();
        }
        let mut stop = StopOnce { seen: 0, at: events };
        solver.step(&Serial, &mut stop);
        if events == usize::MAX {
            events = stop.seen;
            continue;
        }
        let read = |output, step, axis| {
            let mut out = vec![0.0; solver.elements(output, axis)];
            solver.read(output, step, axis, &mut out);
            out
        };
        let velocity = |step| (0..S::DIM).map(|axis| read(&VELOCITY, step, axis)).collect();
        return Trajectory {
            density: (0..=case.steps).map(|step| read(&DENSITY, step, 0)).collect(),
            velocity: (0..case.steps).map(velocity).collect(),
        };
    }
}

fn agrees<S: Space>(case: &Case) {
    let case = Case {
        params: OperatorParams {
            tolerance: 1e-5,
            ..case.params
        },
        ..case.clone()
    };
    let mut inputs = case.draw(41, 0.8);
    inputs
        .forces
        .iter_mut()
        .flatten()
        .flatten()
        .for_each(|x| *x = 0.0);
    inputs.density.iter_mut().for_each(|x| *x = x.abs());
    let expected = marched::<S>(&case, &inputs);
    let mut found = case.with::<f64, S, _>(&inputs, |operator| simulate(operator, &Serial, &inputs).unwrap());
    found.velocity.pop();
    assert!(
        found == expected,
        "{:?} {}: another trajectory",
        case.cells,
        case.ends
    );
}

#[test]
fn the_trajectory_is_that_of_simulate_bit_by_bit() {
    agrees::<D2>(&Case::new(&[12, 9], "wp", 5).emitting().with_templates());
    agrees::<D2>(&Case::new(&[9, 12], "oh", 4).among_solids().emitting());
    agrees::<D2>(&Case {
        scheme: Scheme::Quick,
        ..Case::new(&[10, 10], "pp", 4)
    });
    agrees::<D3>(&Case::new(&[6, 7, 5], "pww", 3).emitting());
}

/// 1/2 |rho_3 - rho*|^2 + 1/2 |rho_5 - rho*|^2 by the forces.
#[test]
fn the_gradient_is_that_of_adjoint_control() {
    let mut random = Random::new(43);
    let (cells, ends, steps) = ([10, 8], "wp", 5);
    let grid = grid(&cells, ends);
    let source: Vec<f64> = random.density(&grid);
    let targets = [random.density::<f64>(&grid), random.density(&grid)].concat();
    let rest: Components<f64> = zeros(&grid, 1);
    let u: Components<f64> = {
        let drawn: Components<f64> = random.faces(&grid, steps - 1);
        drawn.map(|c| c.iter().map(|x| 0.02 * x).collect())
    };
    let (advection, buoyancy, viscosity) = (
        Advection {
            scheme: Scheme::Central,
            tolerance: 1e-200,
        },
        [0.05, -0.1, 0.0],
        1e-3,
    );
    let control = Control {
        grid: &grid,
        steps,
        source: &source,
        lists: Lists {
            steps: &[3, 5],
            ..Lists::default()
        },
        fields: &targets,
        buoyancy,
        solid: &[],
        sticks: false,
        initial: &rest,
        advection,
        filters: 0,
        penalty: 1.0,
        viscosity,
        smoothing: 0.0,
    };
    let (value, expected, _) = control.simulated::<D2>(&u, 1e-300, 1e-13);
    let boundary = boundaries(ends);
    let problem = Problem {
        steps,
        buoyancy,
        viscosity,
        advection,
        ..Problem::new(&cells, &boundary, &[])
    };
    let params = OperatorParams {
        tolerance: 1e-13,
        ..OperatorParams::default()
    };
    let mut memory = Memory::new(OperatorPlan::new::<f64, D2>(&problem, &params).unwrap().bytes());
    let mut operator = Operator::<f64, D2>::new(&problem, &params, memory.block()).unwrap();
    let force = |step: usize, axis: usize| -> Vec<f64> {
        let slots = steps - 1;
        let slot: Vec<f64> = crate::fields::slot(&grid, slots, step, &u[axis]);
        to_file(&grid, axis, &slot)
    };
    let mut give = |step: usize, given: &mut thurible_core::operator::Given<'_, f64>| {
        if step + 1 < steps {
            (0..2).for_each(|axis| given.vector(axis, &force(step, axis)));
        }
    };
    let mut errors: Vec<Vec<f64>> = vec![Vec::new(); steps + 1];
    let start = Start {
        density: &source,
        velocity: [&[]; 3],
    };
    operator
        .simulate(&Serial, &mut Silent, &start, &mut give, &mut |step, view| {
            if let Some(at) = [3, 5].iter().position(|&k| k == step) {
                let mut rho = vec![0.0; 80];
                view.read_density(&mut rho);
                errors[step] = rho.iter().zip(&targets[at * 80..]).map(|(x, y)| x - y).collect();
            }
        })
        .unwrap();
    let data: f64 = errors.iter().flatten().map(|e| 0.5 * e * e).sum();
    assert!(
        (data - value.data).abs() < 1e-11 * data,
        "{data} against {}",
        value.data
    );
    let (mut far, mut size): (f64, f64) = (0.0, 0.0);
    operator
        .vjp(
            &Serial,
            &mut Silent,
            &mut give,
            &mut |step, given| {
                if !errors[step].is_empty() {
                    given.density(&errors[step]);
                }
            },
            &mut |step, view| {
                for axis in 0..2 {
                    let mut read = vec![0.0; if axis == 0 { 88 } else { 80 }];
                    view.read_vector(axis, &mut read);
                    let expected = if step + 1 < steps {
                        let slot: Vec<f64> = crate::fields::slot(&grid, steps - 1, step, &expected[axis]);
                        to_file(&grid, axis, &slot)
                    } else {
                        // The last velocity carries nothing.
                        vec![0.0; read.len()]
                    };
                    for (x, y) in read.iter().zip(&expected) {
                        far = far.max((x - y).abs());
                        size = size.max(y.abs());
                    }
                }
            },
        )
        .unwrap();
    assert!(size > 1e-3 && far < 1e-10 * size, "{far:e} of {size:e}");
}
