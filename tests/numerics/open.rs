//! Open sides: the pressure outside is 0, the flow passes, smoke leaves and none comes in.

use crate::effects::{ALL, NONE, On, among, eight_iterations, gradients, same_bits_by_three_threads};
use crate::fields::cases::Scene;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{
    Components, Memory, add_scaled_all, dot_all, grid, largest_of, places, slot_of_all, view, view_mut, zeros,
};
use thurible_core::grid::levels::Levels;
use thurible_core::grid::{Grid, Side};
use thurible_core::memory::Arena;
use thurible_core::operators::self_advection::{Fluid, apply, scratch_per_thread};
use thurible_core::{
    D2, D3, Feature, Method, NsoSolver, Params, Plan, PlanError, Problem, ProblemError, Real, Scheme, Serial,
    Silent, Space, Status,
};

/// The largest divergence of a flow inside the box, and what flows out of all of it in a unit of time and area of a face.
fn divergence_and_outflow(grid: &Grid, v: &Components<f64>) -> [f64; 2] {
    let all = Naive::new(grid).divergence(v);
    let (mut largest, mut out) = (0.0_f64, 0.0);
    for (at, div) in places(grid).zip(all) {
        if grid.is_outside(at) {
            out += div * grid.h[0];
        } else {
            largest = largest.max(div.abs());
        }
    }
    [largest, out]
}

fn projection(cells: &[usize], ends: &str) {
    let mut random = Random::new(43);
    let grid = grid(cells, ends);
    let [x, y]: [Components<f64>; 2] = [0, 1].map(|_| among(&grid, &[], random.faces(&grid, 2)));
    let rough: Components<f64> = random.faces(&grid, 2);
    let project = |v: &Components<f64>| among(&grid, &[], v.clone());
    for slot in 0..2 {
        let [left, out] = divergence_and_outflow(&grid, &slot_of_all(&grid, 2, slot, &x));
        assert!(left < 1e-11 / grid.h[0], "divergence {left:e}");
        assert!(out.abs() < 1e-11, "what flows in does not flow out: {out:e}");
    }
    let change = largest_of(&add_scaled_all(&project(&x), -1.0, &x));
    assert!(change < 1e-12, "a second projection changes {change:e}");
    // <P a, y> = <a, y> for y free of divergence.
    let (one, two) = (dot_all(&project(&rough), &y), dot_all(&rough, &y));
    assert!(
        (one - two).abs() < 1e-11 * dot_all(&rough, &rough),
        "{one} and {two}"
    );
}

#[test]
fn the_projection_lets_the_flow_out() {
    projection(&[16, 12], "ow");
    projection(&[13, 16], "ho");
    projection(&[12, 9], "lp");
    projection(&[11, 6], "hw");
    projection(&[8, 9, 8], "owh");
    projection(&[8, 7, 6], "pol");
}

#[test]
fn gradients_with_open_sides() {
    gradients::<D2>(&[8, 9], "ow", Scheme::Limited, NONE, 1e-6);
    gradients::<D2>(&[9, 8], "lh", Scheme::Limited, ALL, 1e-6);
    gradients::<D2>(&[8, 9], "po", Scheme::Limited, ALL, 1e-6);
    gradients::<D3>(&[5, 6, 4], "wph", Scheme::Limited, ALL, 1e-6);
    let all = On { solids: true, ..ALL };
    gradients::<D2>(&[12, 11], "oh", Scheme::Limited, all, 1e-6);
    gradients::<D3>(&[8, 8, 8], "wpo", Scheme::Limited, all, 1e-6);
}

/// The energy that self-advection takes is that of what leaves.
#[test]
fn energy_leaves_with_the_flow() {
    let mut random = Random::new(47);
    for (cells, ends) in [(&[9, 8][..], "oh"), (&[6, 5, 7], "lpo")] {
        let grid = grid(cells, ends);
        let v: Components<f64> = among(&grid, &[], random.faces(&grid, 1));
        let taken = dot_all(&v, &advection(&grid, &v));
        let mut left = 0.0;
        for at in places(&grid) {
            for axis in 0..grid.dims {
                let Some(low) = grid.beside(at, axis, Side::Low) else {
                    continue;
                };
                let out = v[axis][grid.index(at)]
                    * f64::from(i8::from(grid.is_outside(at)) - i8::from(grid.is_outside(low)));
                left += out.max(0.0).powi(3) / (2.0 * grid.h[axis]);
            }
        }
        assert!(
            (taken - left).abs() < 1e-11 * left.abs().max(1.0),
            "{taken} is taken, {left} leaves"
        );
    }
}

/// Adv(v) of the core.
fn advection(grid: &Grid, v: &Components<f64>) -> Components<f64> {
    let mut memory = Memory::new(1 << 20);
    let mut levels = Levels::<f64>::bare(grid, 0);
    levels.fill(&mut Arena::new(memory.block())).unwrap();
    let fluid = Fluid {
        grid,
        slots: 1,
        viscosity: 0.0,
        solids: levels.solids(0),
    };
    let mut out = zeros(grid, 1);
    let mut scratch = vec![0.0; scratch_per_thread(grid, 1)];
    if grid.dims == 2 {
        apply::<f64, D2>(&Serial, fluid, view(v), view_mut(&mut out), &mut scratch);
    } else {
        apply::<f64, D3>(&Serial, fluid, view(v), view_mut(&mut out), &mut scratch);
    }
    out
}

/// A plume that rises to an open top leaves the box, faster than a cell a step.
#[test]
fn a_plume_leaves_by_the_top() {
    let mut scene = Scene::small(&[24, 32], "oh", 60);
    scene.scheme = Scheme::Limited;
    scene.params.method = Method::Simulate;
    scene.effects.keep_mass = true;
    scene.effects.buoyancy[1] = 3e-3;
    let solved = scene.solve_alone::<f64, D2>();
    assert_eq!(solved.status, Status::Converged);
    let mass = |rho: &[f64]| rho.iter().sum::<f64>();
    assert!(
        mass(&solved.density[60]) < 0.3 * mass(&solved.density[0]),
        "{}",
        mass(&solved.density[60])
    );
    let fastest = solved
        .velocity
        .iter()
        .flatten()
        .flatten()
        .fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!(fastest * 32.0 > 1.0, "{fastest}");
}

/// A uniform wind through a channel of 16 cells, of length l = 17 h from outside to outside, carries the smoke out. The air that comes in was at rest and what leaves has its head, so that
/// v_k + v_k^2 / (2 l) = v_{k-1}.
#[test]
fn wind_blows_smoke_out_of_a_channel() {
    for (ends, speed) in [("ow", 1.0 / 16.0), ("ow", -1.0 / 16.0)] {
        let mut scene = Scene::small(&[16, 12], ends, 24);
        scene.scheme = Scheme::Limited;
        scene.params.method = Method::Simulate;
        scene.effects.keep_mass = true;
        let masses = scene.with::<f64, D2, _>(|solver| {
            let faces = vec![speed; solver.faces(0)];
            solver.set_initial_velocity(0, &faces).unwrap();
            assert_eq!(solver.solve(&Serial, &mut Silent, &mut |_| {}), Status::Converged);
            let length = 17.0 / 16.0;
            let (mut v, mut known) = (vec![0.0; solver.faces(0)], speed.abs());
            for step in 0..24 {
                solver.velocity(step, 0, &mut v);
                let off = v.iter().map(|v| (v - speed.signum() * known).abs());
                assert!(off.fold(0.0, f64::max) < 1e-4 * known, "v_{step} is not {known}");
                known = length * ((1.0 + 2.0 * known / length).sqrt() - 1.0);
            }
            let mass = |step| solver.density(step).iter().sum::<f64>();
            (0..=24).map(mass).collect::<Vec<f64>>()
        });
        assert!(
            masses.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12),
            "{masses:?}"
        );
        assert!(masses[24] < 1e-2 * masses[0], "smoke stays: {masses:?}");
    }
}

/// Smoke that is steered in a box with open sides: nothing comes in, no density leaves 0 .. max, and the bits are those of any threads.
fn steered<T: Real, S: Space>(method: Method, cells: &[usize], ends: &str, steps: usize) {
    let mut scene = eight_iterations(method, cells, ends, steps);
    scene.effects.keep_mass = true;
    scene.effects.buoyancy[1] = 2e-3;
    scene.params.admm.nso.solver = NsoSolver::NewtonCg;
    let solved = scene.solve_alone::<T, S>();
    assert!(solved.status != Status::NotFinite);
    let grid = scene.problem().grid();
    let mass = |rho: &[f64]| rho.iter().sum::<f64>();
    let top = solved.density[0].iter().fold(0.0_f64, |most, &x| most.max(x));
    for pair in solved.density.windows(2) {
        assert!(mass(&pair[1]) <= mass(&pair[0]) * (1.0 + 1e-6), "mass comes in");
    }
    for rho in &solved.density {
        assert!(rho.iter().all(|&x| (-1e-6..=top * (1.0 + 1e-5)).contains(&x)));
        assert!(
            places(&grid)
                .zip(rho)
                .all(|(at, &x)| !grid.is_outside(at) || x == 0.0)
        );
    }
    same_bits_by_three_threads::<T, S>(scene, &solved);
}

#[test]
fn smoke_is_steered_in_open_boxes() {
    let methods = [
        Method::Direct,
        Method::Lbfgs,
        Method::Pd,
        Method::Simulate,
        Method::Admm,
    ];
    for method in methods {
        steered::<f64, D2>(method, &[32, 32], "wh", 6);
        steered::<f32, D2>(method, &[24, 20], "po", 5);
        steered::<f32, D3>(method, &[16, 16, 16], "wpo", 4);
    }
}

/// ADMM, by Newton's method, ends no higher than the direct method in a box that is open, whose force is smooth there but is priced as ADMM does.
#[test]
fn admm_finds_the_same_flow_in_an_open_box() {
    let mut scene = eight_iterations(Method::Admm, &[16, 20], "oh", 8);
    scene.effects.keep_mass = true;
    scene.effects.buoyancy[1] = 4e-3;
    scene.force_weight = 1e3;
    (scene.params.iterations, scene.params.admm.ao_iterations) = (100, 4);
    (scene.params.admm.penalty, scene.params.admm.density_tolerance) = (5e2, 1e-4);
    scene.params.admm.nso.solver = NsoSolver::NewtonCg;
    let mut direct = scene.clone();
    (direct.params.method, direct.params.iterations) = (Method::Direct, 300);
    direct.params.direct.tolerance = 1e-6;
    let [admm, least] = [&scene, &direct].map(|scene| {
        let solved = scene.solve_alone::<f64, D2>();
        let squares = solved.force.iter().flatten().flatten().map(|u| u * u);
        solved.objective[0] + 0.5 * scene.force_weight * squares.sum::<f64>()
    });
    assert!(
        admm < 1.01 * least,
        "J = {admm} by ADMM, {least} by the direct method"
    );
}

/// The coarser grid has one layer outside too.
#[test]
fn coarse_grids_have_their_layer_outside() {
    let fine = grid(&[16, 12], "ho");
    let coarse = thurible_core::grid::levels::coarsen(&fine).unwrap();
    assert_eq!((fine.n, coarse.n), ([17, 14, 1], [9, 8, 1]));
    assert!((coarse.h[0] - 2.0 * fine.h[0]).abs() < 1e-15);
    let inside = |grid: &Grid| places(grid).filter(|&at| !grid.is_outside(at)).count();
    assert_eq!((inside(&fine), inside(&coarse)), (16 * 12, 8 * 6));
}

#[test]
fn what_open_sides_cannot_is_refused() {
    let cells = [8, 8];
    let boundary = [thurible_core::Boundary::OpenHigh, Default::default()];
    let base = Problem {
        smoothness: Some(0.0),
        match_mass: false,
        ..Problem::new(&cells, &boundary, &[4])
    };
    let plan = |problem: &Problem<'_>, method| {
        let params = Params {
            method,
            ..Params::default()
        };
        Plan::new::<f32, D2>(problem, &params).map(|_| ())
    };
    assert_eq!(plan(&base, Method::Direct), Ok(()));
    let unfit = ProblemError::Unfit {
        method: "admm",
        feature: Feature::Open,
    };
    assert_eq!(plan(&base, Method::Admm), Err(PlanError::Problem(unfit)));
    let mut newton = Params {
        method: Method::Admm,
        ..Params::default()
    };
    newton.admm.nso.solver = NsoSolver::NewtonCg;
    assert!(Plan::new::<f32, D2>(&base, &newton).is_ok());
    let mut quick = base;
    quick.advection.scheme = Scheme::Quick;
    assert_eq!(
        plan(&quick, Method::Direct),
        Err(PlanError::Problem(ProblemError::OpenScheme))
    );
    let matched = Problem {
        match_mass: true,
        ..base
    };
    assert_eq!(
        plan(&matched, Method::Direct),
        Err(PlanError::Problem(ProblemError::MassLeaves))
    );
    let long = [300, 8];
    let long = Problem { cells: &long, ..base };
    assert_eq!(
        plan(&long, Method::Direct),
        Err(PlanError::Problem(ProblemError::OpenCells {
            axis: 0,
            given: 300
        }))
    );
}
