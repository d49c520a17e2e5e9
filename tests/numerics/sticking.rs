//! Walls and obstacles to which a viscous flow sticks.

use crate::effects::{ALL, NONE, On, among, gradients};
use crate::fields::cases::Scene;
use crate::fields::effects::block;
use crate::fields::feasible::check;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{
    Components, Memory, add_scaled_all, dot_all, flow, grid, largest_of, places, view, view_mut,
    with_threads, zeros,
};
use thurible_core::exec::ranks::Alone;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::{Levels, hierarchy};
use thurible_core::grid::solids::Surfaces;
use thurible_core::memory::Arena;
use thurible_core::operators::self_advection::{self, Fluid};
use thurible_core::{
    D2, D3, Feature, Method, NsoSolver, Params, Plan, PlanError, Problem, ProblemError, Real, Scheme, Space,
};

const SLOTS: usize = 3;
const NU: f64 = 0.7;

/// Adv(v) of a flow that sticks to these cells and walls, or slips; with a second field J(v) d, or J(v)^T d.
fn advected<T: Real, S: Space>(
    place: (&Grid, &[bool], bool),
    v: &Components<T>,
    second: Option<(&Components<T>, bool)>,
) -> Components<T> {
    on_level::<T, S>(place, 0, v, second)
}

/// The same on a coarser grid of these cells.
fn on_level<T: Real, S: Space>(
    (grid, solid, stick): (&Grid, &[bool], bool),
    level: usize,
    v: &Components<T>,
    second: Option<(&Components<T>, bool)>,
) -> Components<T> {
    let mut memory = Memory::new(1 << 20);
    let surfaces = Surfaces {
        obstacles: !solid.is_empty(),
        stick,
    };
    let mut levels = Levels::<T>::bare(grid, 0).with_surfaces(surfaces);
    levels.fill(&mut Arena::new(memory.block())).unwrap();
    levels.set_solids(&Alone, |cell| solid.get(cell).is_some_and(|&solid| solid));
    let grid = &levels.grids[level];
    let fluid = Fluid {
        grid,
        slots: SLOTS,
        viscosity: NU,
        solids: levels.solids(level),
    };
    let mut out = zeros(grid, SLOTS);
    let mut scratch = vec![T::ZERO; 2 * self_advection::scratch_per_thread(grid, SLOTS)];
    let (v, into) = (view(v), view_mut(&mut out));
    with_threads(2, |exec| match second {
        None => self_advection::apply::<T, S>(exec, fluid, v, into, &mut scratch),
        Some((d, false)) => {
            self_advection::apply_derivative::<T, S>(exec, fluid, v, view(d), into, &mut scratch)
        }
        Some((m, true)) => self_advection::apply_adjoint::<T, S>(exec, fluid, v, view(m), into, &mut scratch),
    });
    out
}

/// What sticking adds at the faces of a component where all of that component is 1: c, face by face.
fn closeness(fine: &Grid, solid: &[bool], level: usize, axis: usize) -> impl Fn([usize; 2]) -> f64 {
    let grid = hierarchy(fine)[level];
    let mut ones: Components<f64> = zeros(&grid, SLOTS);
    ones[axis].fill(1.0);
    let rest = zeros(&grid, SLOTS);
    let of = |stick| on_level::<f64, D2>((fine, solid, stick), level, &rest, Some((&ones, false)));
    let [slips, sticks] = [false, true].map(of);
    move |[x, y]| {
        let index = y * SLOTS * grid.n[0] + x;
        (sticks[axis][index] - slips[axis][index]) * grid.h[0] * grid.h[0] / NU
    }
}

/// On coarser grids a plate one cell thick is a row of closed faces.
#[test]
fn a_plate_one_cell_thick_holds_the_flow_on_coarser_grids() {
    let fine = grid(&[16, 16], "ww");
    let solid: Vec<bool> = places(&fine).map(|at| at[1] == 8 && at[0] < 8).collect();
    for level in [0, 1] {
        let (c, n) = (closeness(&fine, &solid, level, 0), [16, 8][level]);
        for x in 1..n {
            // Walls below and above, and the plate with its end.
            for (y, on_walls) in [(0, 2.0), (n - 1, 2.0)] {
                assert!((c([x, y]) - on_walls).abs() < 1e-9, "{x} {y}: {}", c([x, y]));
            }
            let along: Vec<f64> = (2..n - 2).map(|y| c([x, y])).collect();
            let expected: &[f64] = match x.cmp(&(n / 2)) {
                core::cmp::Ordering::Less => &[2.0, 2.0],
                core::cmp::Ordering::Equal if level == 0 => &[1.0, 1.0],
                _ => &[],
            };
            let found: Vec<f64> = along.into_iter().filter(|c| c.abs() > 1e-9).collect();
            assert!(
                found.len() == expected.len()
                    && found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-9),
                "level {level}, x = {x}: {found:?}"
            );
        }
    }
}

/// An exit sticks to an obstacle beside it as to a wall; open sides hold nothing.
#[test]
fn exits_stick_to_what_is_beside_them() {
    let open = grid(&[8, 8], "wo");
    // In the last cells of the box along y, which cells outside are behind.
    let last = open.axis(1).inside().end - 1;
    let solid: Vec<bool> = places(&open).map(|at| at[1] == last && at[0] == 3).collect();
    let c = closeness(&open, &solid, 0, 1);
    let of_exits: Vec<f64> = (0..8).map(|x| (c([x, last + 1]) * 1e6).round() / 1e6).collect();
    assert_eq!(of_exits, [2.0, 0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 2.0]);
    // Faces along x beside the open side.
    let c = closeness(&open, &solid, 0, 0);
    let along: Vec<f64> = (1..8)
        .map(|x| (c([x, open.axis(1).inside().start]) * 1e6).round() / 1e6)
        .collect();
    assert_eq!(along, [0.0; 7]);
}

/// What sticking adds, by ghosts beyond the surface; J and its adjoint; energy only leaves.
fn operator<T: Real, S: Space>(cells: &[usize], ends: &str, with_block: bool) {
    let grid = grid(cells, ends);
    let solid = if with_block { block(&grid) } else { Vec::new() };
    let mut random = Random::new(3);
    let mut field = || -> Components<T> {
        let rough: Components<f64> = among(&grid, &solid, flow::rough(&mut random, &grid, SLOTS, 1.0));
        rough.map(|part| part.into_iter().map(T::from_f64).collect())
    };
    let [v, d, m] = [field(), field(), field()];
    let place = |stick| (&grid, &solid[..], stick);
    let [slips, sticks] = [false, true].map(|stick| advected::<T, S>(place(stick), &v, None));
    let solid_at = |at: [usize; 3]| {
        let cell = (at[2] * grid.n[1] + at[1]) * grid.n[0] + at[0];
        solid.get(cell).is_some_and(|&solid| solid)
    };
    let naive = Naive::new(&grid);
    for (axis, (sticks, slips)) in sticks.iter().zip(&slips).enumerate().take(grid.dims) {
        for at in places(&grid) {
            for slot in 0..SLOTS {
                let row = (at[2] * grid.n[1] + at[1]) * SLOTS + slot;
                let index = row * grid.n[0] + at[0];
                let expected = NU * v[axis][index].to_f64() * naive.closeness(&solid_at, at, axis);
                let found = (sticks[index] - slips[index]).to_f64();
                let unit = (grid.n[0] * grid.n[0]) as f64 * T::EPSILON;
                assert!(
                    (found - expected).abs() <= 40.0 * unit,
                    "{cells:?} {ends}, {at:?} along {axis}: {found} and not {expected}"
                );
            }
        }
    }
    let (jd, jm) = (
        advected::<T, S>(place(true), &v, Some((&d, false))),
        advected::<T, S>(place(true), &v, Some((&m, true))),
    );
    let (one, other) = (dot_all(&jd, &m), dot_all(&d, &jm));
    let unit = dot_all(&jd, &jd).sqrt() * dot_all(&m, &m).sqrt();
    assert!(
        (one - other).abs() < 40.0 * T::EPSILON * unit,
        "{one} and {other}"
    );
    assert!(dot_all(&v, &sticks) > dot_all(&v, &slips) && dot_all(&v, &slips) > 0.0);
}

#[test]
fn the_operator_and_its_adjoint() {
    for with_block in [false, true] {
        operator::<f64, D2>(&[11, 9], "ww", with_block);
        operator::<f32, D2>(&[8, 12], "pw", with_block);
        operator::<f64, D2>(&[270, 6], "wp", with_block);
        operator::<f64, D3>(&[8, 9, 8], "wpw", with_block);
        operator::<f32, D3>(&[7, 8, 10], "www", with_block);
    }
}

/// With nu C^T C it is minus the Laplacian of a flow without divergence that is 0 on the walls.
fn laplacian<S: Space>(cells: &[usize], ends: &str) {
    let grid = grid(cells, ends);
    let mut random = Random::new(5);
    let v: Components<f64> = flow::rough(&mut random, &grid, SLOTS, 1.0);
    // J(0) d is nu C^T C d alone.
    let rest = zeros(&grid, SLOTS);
    let found = advected::<f64, S>((&grid, &[], true), &rest, Some((&v, false)));
    let naive = Naive::new(&grid);
    for slot in 0..SLOTS {
        let [v, found] = [&v, &found].map(|field| crate::fields::slot_of_all(&grid, SLOTS, slot, field));
        let expected = naive.at_faces(|axis, at| {
            let here = v[axis][naive.id(at)];
            let along = |across: usize, by: isize| match naive.step(at, across, by) {
                Some(to) => v[axis][naive.id(to)],
                // On the wall that the component goes through, and half a cell beyond the others.
                None if across == axis => 0.0,
                None => -here,
            };
            let part = |b: usize| (2.0 * here - along(b, -1) - along(b, 1)) / (grid.h[b] * grid.h[b]);
            NU * (0..grid.dims).map(part).sum::<f64>()
        });
        let error = largest_of(&add_scaled_all(&found, -1.0, &expected));
        assert!(
            error < 1e-9 * largest_of(&expected),
            "{cells:?} {ends}: {error:e}"
        );
    }
}

#[test]
fn it_is_minus_the_laplacian_of_a_flow_that_is_0_on_walls() {
    laplacian::<D2>(&[11, 9], "ww");
    laplacian::<D2>(&[8, 9], "pw");
    laplacian::<D3>(&[6, 7, 5], "wpw");
}

/// Between two walls a force of 1 along them holds the parabola y (1 - y) / 2 nu, by h^2 / 8 nu faster.
#[test]
fn a_channel_has_the_parabola_of_poiseuille() {
    let grid = grid(&[4, 20], "pw");
    let h = grid.h[1];
    let mut v: Components<f64> = zeros(&grid, SLOTS);
    let length = 20.0 * h;
    for (index, value) in v[0].iter_mut().enumerate() {
        let y = ((index / (4 * SLOTS)) as f64 + 0.5) * h;
        *value = (0.5 * y * (length - y) + h * h / 8.0) / NU;
    }
    let rest = zeros(&grid, SLOTS);
    let found = advected::<f64, D2>((&grid, &[], true), &rest, Some((&v, false)));
    assert!(found[0].iter().all(|x| (x - 1.0).abs() < 1e-11), "{:?}", found[0]);
    assert!(found[1].iter().all(|x| x.abs() < 1e-11), "{:?}", found[1]);
}

#[test]
fn gradients_of_flows_that_stick() {
    let sticks = On { sticks: true, ..NONE };
    gradients::<D2>(&[8, 9], "wp", Scheme::Central, sticks, 1e-4);
    gradients::<D3>(&[5, 6, 4], "wpw", Scheme::Central, sticks, 1e-4);
    let all = On {
        sticks: true,
        solids: true,
        ..ALL
    };
    gradients::<D2>(&[12, 11], "ww", Scheme::Limited, all, 1e-6);
    gradients::<D2>(&[12, 11], "wo", Scheme::Limited, all, 1e-6);
    gradients::<D3>(&[8, 8, 8], "wpw", Scheme::Limited, all, 1e-6);
}

/// Every method that can, alone and with everything, by a second implementation.
fn solved<T: Real, S: Space>(method: Method, cells: &[usize], ends: &str, steps: usize) {
    let small = Scene::small(cells, ends, steps);
    let params = Params {
        method,
        iterations: 4,
        ..small.params
    };
    let mut scene = Scene {
        params,
        viscosity: 2e-3,
        ..small
    };
    scene.params.admm.nso.solver = NsoSolver::NewtonCg;
    scene.effects.sticks = true;
    if !matches!(method, Method::Simulate | Method::Templates) {
        check(&scene, &scene.solve_alone::<T, S>(), T::EPSILON);
    }
    let mut all = scene.with_everything();
    all.effects.sticks = true;
    check(&all, &all.solve_alone::<T, S>(), T::EPSILON);
}

#[test]
fn results_of_every_method_are_feasible() {
    for method in [
        Method::Direct,
        Method::Lbfgs,
        Method::Pd,
        Method::Simulate,
        Method::Templates,
        Method::Admm,
    ] {
        solved::<f64, D2>(method, &[12, 16], "ww", 6);
        solved::<f32, D2>(method, &[16, 13], "pw", 5);
        solved::<f64, D3>(method, &[8, 7, 6], "wpw", 4);
    }
}

#[test]
fn what_cannot_stick_is_refused() {
    let (cells, boundary) = ([8, 8], [Default::default(); 2]);
    let problem = Problem {
        slip: false,
        smoothness: Some(0.0),
        ..Problem::new(&cells, &boundary, &[4])
    };
    let plan = |problem: &Problem<'_>, params: &Params| Plan::new::<f32, D2>(problem, params).map(|_| ());
    assert_eq!(
        plan(&problem, &Params::default()),
        Err(PlanError::Problem(ProblemError::SticksWithoutViscosity))
    );
    let problem = Problem {
        viscosity: 1e-3,
        ..problem
    };
    assert_eq!(plan(&problem, &Params::default()), Ok(()));
    let mut params = Params {
        method: Method::Admm,
        ..Params::default()
    };
    assert_eq!(
        plan(&problem, &params),
        Err(PlanError::Problem(ProblemError::Unfit {
            method: "admm",
            feature: Feature::Sticking
        }))
    );
    params.admm.nso.solver = NsoSolver::NewtonCg;
    assert_eq!(plan(&problem, &params), Ok(()));
}
