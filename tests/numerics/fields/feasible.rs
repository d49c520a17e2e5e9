//! That a result is feasible: every fact checked with the second implementation.

use crate::fields::cases::{Scene, Solved};
use crate::fields::naive::Naive;
use crate::fields::{Components, add_scaled_all, assert_close, dot, gap, largest, largest_of, places};
use thurible_core::Advection;
use thurible_core::grid::Grid;

/// A component of a file as the core keeps it: the high wall face left out. Panics if a wall face is not 0.
pub fn faces(grid: &Grid, file: &[Vec<f64>]) -> Components<f64> {
    let component = |axis: usize| {
        let extent = |a: usize| grid.n[a] + usize::from(a == axis && !grid.axis(a).is_ring());
        let number = |at: [usize; 3]| file[axis][(at[2] * extent(1) + at[1]) * extent(0) + at[0]];
        assert_eq!(file[axis].len(), (0..3).map(extent).product::<usize>());
        for at in places(grid).filter(|at| !grid.axis(axis).is_ring() && at[axis] == 0) {
            let mut high = at;
            high[axis] = grid.n[axis];
            assert_eq!(
                (number(at), number(high)),
                (0.0, 0.0),
                "flow through a wall at {at:?}, axis {axis}"
            );
        }
        places(grid).map(number).collect()
    };
    core::array::from_fn(|axis| {
        if axis < grid.dims {
            component(axis)
        } else {
            Vec::new()
        }
    })
}

/// Every fact of a feasible result, checked with the second implementation in scaled numbers.
pub fn check(scene: &Scene, solved: &Solved, epsilon: f64) {
    let v = check_flow(scene, solved, epsilon);
    let naive = Naive::new(&scene.problem().grid());
    check_densities(scene, solved, &naive, &v, epsilon);
    check_objective(scene, solved, &naive, epsilon);
}

/// That the flow is free of divergence and made by its forces; the flow.
pub fn check_flow(scene: &Scene, solved: &Solved, epsilon: f64) -> Vec<Components<f64>> {
    let grid = scene.problem().grid();
    let naive = Naive {
        viscosity: scene.problem().scaled_viscosity(),
        ..Naive::new(&grid)
    };
    let (speed, force) = (scene.length / scene.dt, scene.length / (scene.dt * scene.dt));
    let scaled = |list: &[Vec<Vec<f64>>], unit: f64| -> Vec<Components<f64>> {
        list.iter()
            .map(|v| faces(&grid, v).map(|c| c.iter().map(|x| x / unit).collect()))
            .collect()
    };
    let (v, u) = (scaled(&solved.velocity, speed), scaled(&solved.force, force));
    let (fastest, strongest) = (
        largest(v.iter().map(largest_of)),
        largest(u.iter().map(largest_of)),
    );
    assert!(fastest > 0.0 && strongest > 0.0, "nothing moves");
    for (k, v) in v.iter().enumerate() {
        let divergence = largest(naive.divergence(v));
        assert!(
            divergence <= (2e-5 + 40.0 * epsilon) * fastest / grid.h[0],
            "div v_{k} is {divergence:e}"
        );
    }
    for (k, u) in u.iter().enumerate() {
        let divergence = largest(naive.divergence(u));
        assert!(
            divergence <= (2e-5 + 40.0 * epsilon) * (strongest + fastest) / grid.h[0],
            "div u_{k} is {divergence:e}"
        );
        // What is left of the momentum equation must be a gradient: no curl anywhere, no mean along periodic axes.
        let produced = add_scaled_all(
            &add_scaled_all(&v[k + 1], -1.0, &v[k]),
            1.0,
            &naive.advection(&v[k + 1]),
        );
        let drag = |axis: usize, at: [usize; 3]| {
            naive.viscosity * naive.closeness(&|_| false, at, axis) * v[k + 1][axis][naive.id(at)]
        };
        let sticking = if scene.effects.sticks { 1.0 } else { 0.0 };
        let produced = add_scaled_all(&produced, sticking, &naive.at_faces(drag));
        let lift = scene.effects.lift(&naive, &solved.density[k + 1]);
        let produced = add_scaled_all(&produced, -1.0 / force, &lift);
        // Velocities of emitters are in scaled numbers where the scene's units are 1.
        assert!(
            force == 1.0
                || scene
                    .effects
                    .emitters
                    .iter()
                    .all(|emitter| emitter.velocity.is_none())
        );
        let produced = add_scaled_all(&produced, -1.0, &scene.effects.push(&naive, k, &v[k]));
        let left = add_scaled_all(u, -1.0, &produced);
        let unit = 60.0
            * epsilon
            * (strongest + fastest + (fastest + naive.viscosity / grid.h[0]) * fastest / grid.h[0]);
        // After the release the force is 0, and what an implicit step leaves is left; a curl takes it of four faces.
        let released = scene.effects.release.is_some_and(|release| k + 1 >= release);
        let unit = unit
            + if released {
                4.0 * scene.params.simulation.tolerance * fastest
            } else {
                0.0
            };
        assert!(
            naive.largest_curl(&left) <= unit / grid.h[0],
            "momentum at step {k}: {:e}",
            naive.largest_curl(&left)
        );
        for a in (0..grid.dims).filter(|&a| grid.axis(a).is_ring()) {
            assert_close(
                "mean force",
                left[a].iter().sum::<f64>() / grid.cells() as f64,
                0.0,
                unit,
                1.0,
            );
        }
    }
    v
}

fn check_densities(scene: &Scene, solved: &Solved, naive: &Naive, v: &[Components<f64>], epsilon: f64) {
    let rho_0 = &solved.density[0];
    assert!(
        gap(rho_0, &scene.densities[0]) <= epsilon,
        "rho_0 is not the source"
    );
    let top = largest(solved.density.iter().flatten().copied());
    let mut rho = rho_0.clone();
    for (step, v) in v.iter().enumerate() {
        rho = naive.transport(
            Advection {
                scheme: scene.scheme,
                tolerance: scene.cut * top,
            }
            .into(),
            v,
            &rho,
        );
        scene.effects.emit(step + 1, &mut rho);
        let error = gap(&rho, &solved.density[step + 1]);
        assert!(
            error <= (1e-4 + 100.0 * epsilon) * top,
            "rho_{} is {error:e} from what v carries there",
            step + 1
        );
    }
    let mass = |rho: &[f64]| rho.iter().sum::<f64>();
    if !scene.effects.emitters.is_empty() {
        return;
    }
    for (i, rho) in solved.density.iter().chain(&solved.targets).enumerate() {
        assert_close(
            &format!("mass of density {i}"),
            mass(rho),
            mass(rho_0),
            mass(rho_0),
            2e-6,
        );
    }
}

fn check_objective(scene: &Scene, solved: &Solved, naive: &Naive, epsilon: f64) {
    let filters = scene.problem().filters();
    let mut data = 0.0;
    let effects = &scene.effects;
    for (index, (target, &step)) in solved.targets.iter().zip(&scene.keyframes).enumerate() {
        let part = |at: usize| effects.regions.get(index).map_or(1.0, |region| region[at]);
        let pairs = solved.density[step].iter().zip(target).enumerate();
        let e: Vec<f64> = pairs.map(|(at, (x, y))| part(at) * (x - y)).collect();
        let weight = effects.weights.get(index).copied().unwrap_or(1.0);
        data += 0.5 * weight * dot(&e, &naive.metric(filters, &e));
    }
    let square = |u: &Vec<Vec<f64>>| {
        let u = effects.divided(naive, &faces(&naive.grid, u));
        u.iter().map(|c| dot(c, c)).sum::<f64>()
    };
    let sum: f64 = solved
        .force
        .iter()
        .enumerate()
        .map(|(slot, u)| effects.factor(slot) * square(u))
        .sum();
    assert_close(
        "data term",
        solved.objective[0],
        data,
        data,
        1e-9 + 100.0 * epsilon,
    );
    assert_close(
        "force term",
        solved.objective[1],
        0.5 * scene.force_weight * sum,
        solved.objective[1],
        1e-9 + 100.0 * epsilon,
    );
}
