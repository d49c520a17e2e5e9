//! Effects: smoke that is made on the way, buoyancy, what matters where and when, and what comes after the release.

use crate::fields::Memory;
use crate::fields::cases::{Scene, Solved};
use crate::fields::control::Control;
use crate::fields::effects::block;
use crate::fields::feasible::check;
use crate::fields::naive::Naive;
use crate::fields::places;
use crate::fields::random::Random;
use crate::fields::{
    Components, add_scaled_all, dot, dot_all, flow, gap, grid, largest_of, view, view_mut, with_threads,
    zeros,
};
use crate::gradients::taylor;
use thurible_core::exec::ranks::Alone;
use thurible_core::force::lift::Lift;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::grid::solids::Surfaces;
use thurible_core::memory::{Arena, Ledger, Pool};
use thurible_core::objective::script::Lists;
use thurible_core::poisson::Projection;
use thurible_core::{
    Advection, D2, D3, Emitter, Feature, InputError, Method, Params, Plan, PlanError, Problem, ProblemError,
    Real, Scheme, Serial, Silent, Space, Status, Supply,
};

const METHODS: [Method; 6] = [
    Method::Direct,
    Method::Lbfgs,
    Method::Pd,
    Method::Simulate,
    Method::Admm,
    Method::Templates,
];

/// B by the second implementation, and <B rho, z> = <rho, B^T z>.
fn lift_and_its_adjoint(cells: &[usize], ends: &str) {
    let mut random = Random::new(31);
    let (grid, slots) = (grid(cells, ends), 3);
    let acceleration = [0.3, -0.7, if grid.dims == 3 { 1.1 } else { 0.0 }];
    let lift = Lift {
        grid: &grid,
        slots,
        solids: Default::default(),
        acceleration,
    };
    let rho: Vec<f64> = (0..5).flat_map(|_| random.density(&grid)).collect();
    let mut lifted: Components<f64> = zeros(&grid, slots);
    lift.add(&Serial, 2.0, &rho, 0..slots, &mut view_mut(&mut lifted));
    let effects = crate::fields::effects::Effects {
        buoyancy: acceleration,
        ..Default::default()
    };
    let z: Components<f64> = flow::rough(&mut random, &grid, slots, 1.0);
    for slot in 0..slots {
        let rho = &rho[(slot + 1) * grid.cells()..][..grid.cells()];
        let expected = effects.lift(&Naive::new(&grid), rho);
        let found = crate::fields::slot_of_all(&grid, slots, slot, &lifted);
        let error = largest_of(&add_scaled_all(&found, -2.0, &expected));
        assert!(error < 1e-14, "B is off by {error:e} in slot {slot}");
        let mut mu = vec![0.0; grid.cells()];
        lift.add_adjoint(&Serial, 2.0, view(&z), slot, &mut mu);
        let (one, other) = (
            dot_all(&found, &crate::fields::slot_of_all(&grid, slots, slot, &z)),
            dot(rho, &mu),
        );
        assert!(
            (one - other).abs() < 1e-13 * one.abs().max(1.0),
            "{one} and {other}"
        );
    }
}

#[test]
fn buoyancy_and_its_adjoint() {
    lift_and_its_adjoint(&[7, 9], "ww");
    lift_and_its_adjoint(&[8, 5], "pw");
    lift_and_its_adjoint(&[6, 5, 4], "wpw");
    lift_and_its_adjoint(&[4, 5, 6], "pwp");
}

/// Which features of a control are on.
#[derive(Clone, Copy, Debug)]
pub struct On {
    pub rate: bool,
    pub target: bool,
    pub buoyancy: bool,
    pub regions: bool,
    pub schedule: bool,
    pub solids: bool,
    pub mask: bool,
    pub jets: bool,
    pub sticks: bool,
    pub smoothing: f64,
}

pub const ALL: On = On {
    rate: true,
    target: true,
    buoyancy: true,
    regions: true,
    schedule: true,
    solids: false,
    mask: true,
    jets: true,
    sticks: false,
    smoothing: 0.05,
};
pub const NONE: On = On {
    rate: false,
    target: false,
    buoyancy: false,
    regions: false,
    schedule: false,
    solids: false,
    mask: false,
    jets: false,
    sticks: false,
    smoothing: 0.0,
};

/// A density that is 0 in solid cells and outside the box.
fn outside(grid: &Grid, solid: &[bool], mut rho: Vec<f64>) -> Vec<f64> {
    for (cell, (at, x)) in places(grid).zip(&mut rho).enumerate() {
        if grid.is_outside(at) || solid.get(cell).is_some_and(|&solid| solid) {
            *x = 0.0;
        }
    }
    rho
}

/// A trajectory whose closed faces are 0, projected among the solid cells, or in a box with open sides.
pub fn among(grid: &Grid, solid: &[bool], v: Components<f64>) -> Components<f64> {
    if solid.is_empty() && !grid.is_open() {
        return v;
    }
    let slots = v[0].len() / grid.cells();
    let mut memory = Memory::new(1 << 20);
    let mut levels = Levels::bare(grid, 0).with_surfaces(Surfaces {
        obstacles: !solid.is_empty(),
        stick: false,
    });
    levels.fill(&mut Arena::new(memory.block())).unwrap();
    levels.set_solids(&Alone, |cell| solid.get(cell).is_some_and(|&solid| solid));
    let mut ledger = Ledger::new();
    Projection::<f64>::carve(&levels, 0, slots, 1, &mut Pool::measuring(&mut ledger));
    let mut elements = vec![f64::NAN; ledger.elements(8)];
    let mut projection = Projection::carve(&levels, 0, slots, 1, &mut Pool::new(&mut elements));
    let (mut v, mut sums) = (v, vec![0.0; 2 * grid.rows()]);
    let left = projection.project(
        &Serial,
        &mut Silent,
        &mut view_mut(&mut v),
        None,
        1e-13,
        &mut sums,
    );
    assert!(left.is_continue());
    v
}

/// [`gradients_at`] about one cell a step.
pub fn gradients<S: Space>(cells: &[usize], ends: &str, scheme: Scheme, on: On, first: f64) {
    gradients_at::<S>(1.0, cells, ends, scheme, on, first);
}

/// Gradients by the flow and by the forces against differences, at `speed` times a cell a step. Where smoke is filled up to a target, only what transport leaves well below
/// or above it: at equality the derivative jumps.
fn gradients_at<S: Space>(speed: f64, cells: &[usize], ends: &str, scheme: Scheme, on: On, first: f64) {
    let mut random = Random::new(37);
    let grid = grid(cells, ends);
    let solid: Vec<bool> = if on.solids { block(&grid) } else { Vec::new() };
    let density = |random: &mut Random| outside(&grid, &solid, random.density(&grid));
    let source: Vec<f64> = density(&mut random);
    let initial = among(&grid, &solid, flow::rough(&mut random, &grid, 1, 0.8 * speed));
    let mut fields = [density(&mut random), density(&mut random)].concat();
    if on.regions {
        fields.extend(density(&mut random).iter().map(|x: &f64| x.min(1.0)));
        fields.extend(density(&mut random).iter().map(|x: &f64| x.min(1.0)));
    }
    let (mut spans, mut supplies) = (Vec::new(), Vec::new());
    if on.rate {
        spans.extend([0, 3]);
        supplies.extend([0.4, 0.0]);
        fields.extend(density(&mut random));
    }
    if on.target {
        spans.extend([1, 4]);
        supplies.extend([0.0, 3.0]);
        let shape = (0..grid.cells()).map(|at| if at % 5 == 0 { 1.0 } else { 0.0 });
        fields.extend(outside(&grid, &solid, shape.collect()));
    }
    if on.mask {
        fields.extend(random.density(&grid).iter().map(|x: &f64| x.clamp(0.2, 1.0)));
    }
    // The first pushes across the box, the second holds still where it is not pushed too.
    let jets: Vec<f64> = match (on.jets, spans.len()) {
        (true, 2..) => {
            [[1.0, 0.03, -0.05, 0.02], [1.0, 0.0, 0.04, 0.0]].as_flattened()[..2 * spans.len()].to_vec()
        }
        _ => Vec::new(),
    };
    let lists = Lists {
        steps: &[2, 5],
        weights: if on.regions { &[2.0, 0.5] } else { &[] },
        regions: on.regions,
        spans: &spans,
        supplies: &supplies,
        jets: &jets,
        knots: if on.schedule { &[1, 3] } else { &[] },
        factors: if on.schedule { &[4.0, 0.5] } else { &[] },
        mask: on.mask,
        templates: &[],
    };
    let control = Control {
        grid: &grid,
        steps: 5,
        source: &source,
        lists,
        fields: &fields,
        buoyancy: if on.buoyancy {
            [0.01, -0.02, if grid.dims == 3 { 0.03 } else { 0.0 }]
        } else {
            [0.0; 3]
        },
        solid: &solid,
        sticks: on.sticks,
        initial: &initial,
        advection: Advection {
            scheme,
            tolerance: 1e-200,
        },
        filters: 2,
        penalty: 1.0,
        viscosity: 0.01,
        smoothing: on.smoothing,
    };
    let at: Components<f64> = among(&grid, &solid, flow::rough(&mut random, &grid, 4, 1.2 * speed));
    let d: Components<f64> = among(&grid, &solid, flow::rough(&mut random, &grid, 4, speed));
    let (found, _) = control.direct::<S>(&at, 1.0);
    let weight = 3.0 * found.data / found.force;
    let (_, gradient) = control.direct::<S>(&at, weight);
    taylor(
        &format!("direct, {on:?} on {cells:?} {ends}"),
        first,
        dot_all(&gradient, &d),
        |t| control.direct::<S>(&add_scaled_all(&at, t, &d), weight).0.total(),
    );
    let u = add_scaled_all(&zeros(&grid, 4), 0.3, &at);
    let (found, ..) = control.simulated::<S>(&u, 1.0, 1e-13);
    let weight = 3.0 * found.data / found.force;
    let (_, gradient, _) = control.simulated::<S>(&u, weight, 1e-13);
    taylor(
        &format!("by forces, {on:?} on {cells:?} {ends}"),
        first,
        dot_all(&gradient, &d),
        |t| {
            control
                .simulated::<S>(&add_scaled_all(&u, t, &d), weight, 1e-13)
                .0
                .total()
        },
    );
}

#[test]
fn gradients_with_each_feature_and_with_all() {
    let one = [
        On { rate: true, ..NONE },
        On { target: true, ..NONE },
        On {
            buoyancy: true,
            ..NONE
        },
        On {
            regions: true,
            ..NONE
        },
        On {
            schedule: true,
            ..NONE
        },
        On {
            rate: true,
            jets: true,
            ..NONE
        },
    ];
    for on in one {
        gradients::<D2>(&[8, 9], "wp", Scheme::Central, on, 1e-4);
    }
    // A mask down to 0.2 bends the objective up to 25 times as much.
    gradients::<D2>(&[8, 9], "wp", Scheme::Central, On { mask: true, ..NONE }, 1e-5);
    gradients::<D2>(&[8, 9], "ww", Scheme::Central, ALL, 1e-5);
    gradients::<D2>(&[9, 8], "pw", Scheme::Limited, ALL, 1e-6);
    gradients::<D3>(&[5, 6, 4], "wpw", Scheme::Central, ALL, 1e-5);
    let among_solids = On { solids: true, ..NONE };
    gradients::<D2>(&[12, 11], "wp", Scheme::Limited, among_solids, 1e-6);
    gradients_at::<D2>(0.3, &[270, 6], "ww", Scheme::Limited, among_solids, 1e-6);
    let all = On { solids: true, ..ALL };
    gradients::<D2>(&[12, 11], "ww", Scheme::Limited, all, 1e-6);
    gradients::<D3>(&[8, 8, 8], "wpw", Scheme::Limited, all, 1e-6);
}

/// A solve with everything on is what the second implementation says, and the flow is free after the release.
fn everything<T: Real, S: Space>(method: Method, cells: &[usize], ends: &str, steps: usize) {
    let small = Scene::small(cells, ends, steps);
    let params = Params {
        method,
        iterations: 4,
        ..small.params
    };
    let scene = Scene { params, ..small }.with_everything();
    let solved = scene.solve_alone::<T, S>();
    check(&scene, &solved, T::EPSILON);
    let released = &solved.force[steps - 1..];
    assert_eq!((solved.force.len(), released.len()), (steps + 1, 2));
    assert!(
        released.iter().flatten().flatten().all(|&x| x == 0.0),
        "{method:?}"
    );
}

#[test]
fn results_with_everything_are_feasible() {
    for method in METHODS {
        everything::<f64, D2>(method, &[12, 16], "ww", 6);
        everything::<f32, D2>(method, &[16, 13], "pw", 5);
        everything::<f32, D2>(method, &[300, 7], "wp", 4);
        everything::<f64, D2>(method, &[8, 260], "wp", 4);
        everything::<f64, D3>(method, &[8, 7, 6], "wpw", 4);
        everything::<f32, D3>(method, &[8, 8, 8], "www", 6);
    }
}

/// One emitter of a ball and no source, towards a ball higher up.
fn chimney(method: Method) -> Scene {
    let small = Scene::small(&[32, 32], "ww", 12);
    let grid = small.problem().grid();
    let ball = |y: f64| crate::fields::cases::balls(&grid, &[[0.5, y, 0.5]], 0.12);
    Scene {
        params: Params {
            method,
            iterations: 60,
            ..Params::default()
        },
        densities: vec![vec![0.0; grid.cells()], ball(0.6)],
        effects: crate::fields::effects::Effects {
            emitters: vec![Emitter {
                from: 0,
                to: 6,
                supply: Supply::Rate(0.25),
                velocity: None,
            }],
            shapes: vec![ball(0.25)],
            ..Default::default()
        },
        ..small
    }
}

#[test]
fn an_emitter_alone_fills_a_keyframe() {
    // A change of the scene in its last bits leads L-BFGS without coarser grids to anything from 0.13 to 0.19.
    for (method, most) in [(Method::Direct, 0.15), (Method::Lbfgs, 0.25)] {
        let scene = chimney(method);
        let mut memory = Memory::new(scene.plan::<f64, D2>().bytes());
        let mut solver =
            thurible_core::Solver::<f64, D2>::new(&scene.problem(), &scene.params, memory.block()).unwrap();
        assert_eq!(
            solver.set_keyframe(0, &scene.densities[1]),
            Err(InputError::NoEmitter { index: 0 })
        );
        scene.set_rest(&mut solver);
        let (made, shape) = (solver.mass_at(12), scene.effects.shapes[0].iter().sum::<f64>());
        assert!((made - 6.0 * 0.25 * shape).abs() < 1e-12 * made);
        assert!((solver.mass_at(3) - 0.5 * made).abs() < 1e-12 * made);
        let solved = Solved::run(&scene, &mut solver, &Serial, &mut Silent);
        check(&scene, &solved, f64::EPSILON);
        let target = &solved.targets[0];
        assert!(
            (target.iter().sum::<f64>() - made).abs() < 1e-12 * made,
            "the target has the mass that is made"
        );
        let error = |rho: &[f64]| {
            let e: Vec<f64> = rho.iter().zip(target).map(|(x, y)| x - y).collect();
            dot(&e, &e).sqrt() / dot(target, target).sqrt()
        };
        let missed = error(&solved.density[12]);
        assert!(missed < most, "{method:?} misses the keyframe by {missed}");
    }
}

#[test]
fn a_target_keeps_its_shape_filled() {
    let mut scene = Scene::small(&[24, 24], "ww", 8);
    scene.params.method = Method::Simulate;
    scene.keyframes.clear();
    scene.densities.truncate(1);
    let grid = scene.problem().grid();
    scene.effects.shapes = vec![crate::fields::cases::balls(&grid, &[[0.5, 0.2, 0.5]], 0.1)];
    scene.effects.emitters = vec![Emitter {
        from: 2,
        to: 8,
        supply: Supply::Target(0.7),
        velocity: None,
    }];
    scene.effects.buoyancy = [0.0, 2e-2, 0.0];
    let solved = scene.solve_alone::<f64, D2>();
    check(&scene, &solved, f64::EPSILON);
    for (step, rho) in solved.density.iter().enumerate().skip(3) {
        for (&x, shape) in rho.iter().zip(&scene.effects.shapes[0]) {
            assert!(x >= 0.7 * shape - 1e-12, "step {step}: {x} in a shape of {shape}");
        }
    }
    let mass = |rho: &[f64]| rho.iter().sum::<f64>();
    assert!(
        mass(&solved.density[8]) > 1.05 * mass(&solved.density[3]),
        "made {} of {}",
        mass(&solved.density[8]),
        mass(&solved.density[3])
    );
}

/// Where the region is 0 the keyframe does not care, and a heavier keyframe is met better.
#[test]
fn what_matters_is_met() {
    let mut scene = Scene::small(&[32, 32], "ww", 10);
    scene.params = Params {
        iterations: 60,
        ..Params::default()
    };
    scene.force_weight = 1e3;
    let missed = |scene: &Scene, within: &dyn Fn(usize) -> bool| {
        let solved = scene.solve_alone::<f64, D2>();
        let pairs = solved.density[10].iter().zip(&solved.targets[0]).enumerate();
        pairs
            .filter(|&(at, _)| within(at))
            .map(|(_, (x, y))| (x - y).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let plain = missed(&scene, &|_| true);
    scene.effects.weights = vec![25.0];
    let heavy = missed(&scene, &|_| true);
    assert!(
        heavy < 0.5 * plain,
        "{heavy} by a heavy keyframe, {plain} by a light one"
    );
    scene.effects.weights.clear();
    let left = |at: usize| at % 32 < 20;
    let half = missed(&scene, &left);
    scene.effects.regions = vec![(0..32 * 32).map(|at| f64::from(u8::from(left(at)))).collect()];
    scene.effects.keep_mass = true;
    let solved = scene.solve_alone::<f64, D2>();
    let force = |scene: &Scene| scene.solve_alone::<f64, D2>().objective[1];
    let mut whole = scene.clone();
    whole.effects.regions.clear();
    assert!(
        solved.objective[1] < force(&whole),
        "what does not matter costs no force"
    );
    let cared = missed(&scene, &left);
    assert!(
        cared < 1.5 * half,
        "{cared} where it matters, {half} where all does"
    );
}

#[test]
fn a_price_that_falls_moves_force_to_later_steps() {
    let mut scene = Scene::small(&[24, 24], "ww", 10);
    scene.params = Params {
        iterations: 60,
        ..Params::default()
    };
    let late = |scene: &Scene| {
        let solved = scene.solve_alone::<f64, D2>();
        check(scene, &solved, f64::EPSILON);
        let square = |u: &Vec<Vec<f64>>| u.iter().map(|c| dot(c, c)).sum::<f64>();
        let all: f64 = solved.force.iter().map(square).sum();
        solved.force[4..].iter().map(square).sum::<f64>() / all
    };
    let even = late(&scene);
    scene.effects.schedule = vec![(0, 10.0), (8, 0.1)];
    let eased = late(&scene);
    assert!(
        eased > 1.5 * even,
        "{eased} of the force is late, {even} by one price"
    );
}

#[test]
fn what_a_method_cannot_is_refused_by_name() {
    let (cells, boundary) = ([8, 8], [Default::default(); 2]);
    let base = Problem {
        smoothness: Some(0.0),
        ..Problem::new(&cells, &boundary, &[4])
    };
    let plan = |problem: &Problem<'_>, method| {
        let params = Params {
            method,
            ..Params::default()
        };
        Plan::new::<f32, D2>(problem, &params).map(|_| ())
    };
    let asks = [
        (
            Feature::Smoothness,
            Problem {
                smoothness: Some(2.0),
                ..base
            },
        ),
        (
            Feature::Schedule,
            Problem {
                schedule: &[(0, 2.0)],
                ..base
            },
        ),
        (Feature::Mask, Problem { mask: true, ..base }),
    ];
    for (feature, problem) in asks {
        let refused = PlanError::Problem(ProblemError::Unfit {
            method: "admm",
            feature,
        });
        assert_eq!(plan(&problem, Method::Admm), Err(refused));
        assert_eq!(plan(&problem, Method::Direct), Ok(()));
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let (cells, boundary) = ([8, 8], [Default::default(); 2]);
    let base = Problem {
        steps: 8,
        ..Problem::new(&cells, &boundary, &[4])
    };
    let emitter = |from, to, supply| {
        [Emitter {
            from,
            to,
            supply,
            velocity: None,
        }]
    };
    let rate = Supply::Rate(1.0);
    let refused = |problem: &Problem<'_>| match Plan::new::<f32, D2>(problem, &Params::default()) {
        Err(PlanError::Problem(error)) => error,
        other => panic!("{:?}", other.map(|_| ())),
    };
    let by = |emitters: &[Emitter]| refused(&Problem { emitters, ..base });
    let steps = ProblemError::EmitterSteps { index: 0, steps: 8 };
    assert_eq!(by(&emitter(3, 3, rate)), steps);
    assert_eq!(by(&emitter(3, 9, rate)), steps);
    assert!(matches!(
        by(&emitter(0, 1, Supply::Rate(0.0))),
        ProblemError::NotPositive { .. }
    ));
    let target = emitter(0, 1, Supply::Target(1.0));
    assert_eq!(by(&target), ProblemError::MassUnknown { index: 0 });
    let release = |release| {
        refused(&Problem {
            release: Some(release),
            ..base
        })
    };
    assert_eq!(release(3), ProblemError::KeyframeReleased { step: 4, release: 3 });
    assert_eq!(release(8), ProblemError::Release { given: 8, steps: 8 });
    assert_eq!(release(1), ProblemError::Release { given: 1, steps: 8 });
    let schedule = [(3, 1.0), (3, 2.0)];
    assert_eq!(
        refused(&Problem {
            schedule: &schedule,
            ..base
        }),
        ProblemError::ScheduleOrder { step: 3 }
    );
    let weights = [1.0, 1.0];
    assert_eq!(
        refused(&Problem {
            keyframe_weights: &weights,
            ..base
        }),
        ProblemError::Weights { given: 2 }
    );
    assert!(matches!(
        refused(&Problem {
            buoyancy: [f64::NAN, 0.0, 0.0],
            ..base
        }),
        ProblemError::NotFinite { .. }
    ));
}

/// A release changes nothing before it, and what follows is what a simulation of its own gives.
#[test]
fn a_release_is_a_simulation_from_there() {
    let mut scene = Scene::small(&[16, 16], "ww", 6);
    (scene.params.method, scene.params.threads) = (Method::Direct, 2);
    let before = scene.solve_alone::<f64, D2>();
    scene.steps = 10;
    scene.effects.release = Some(6);
    let whole = with_threads(2, |exec| scene.solve::<f64, D2>(exec, &mut Silent));
    check(&scene, &whole, f64::EPSILON);
    assert_eq!(whole.status, before.status);
    assert!(
        whole.density[..7] == before.density[..],
        "the controlled part is another"
    );
    assert!(whole.velocity[..6] == before.velocity[..]);
    let (speed, still) = (
        largest_of_all(&whole.velocity[9]),
        gap(&whole.density[9], &whole.density[10]),
    );
    assert!(speed > 0.0 && still > 1e-3, "the smoke stands after the release");
    assert_ne!(whole.status, Status::NotFinite);
}

fn largest_of_all(v: &[Vec<f64>]) -> f64 {
    crate::fields::largest(v.iter().flatten().copied())
}

/// The projection among solid cells: closed faces and divergence are 0, twice is once, and it is symmetric.
fn projected_among_solids(cells: &[usize], ends: &str) {
    let mut random = Random::new(41);
    let grid = grid(cells, ends);
    let solid = block(&grid);
    let [x, y]: [Components<f64>; 2] = [0, 1].map(|_| random.faces(&grid, 2));
    let project = |v: &Components<f64>| among(&grid, &solid, v.clone());
    let (px, py) = (project(&x), project(&y));
    let naive = Naive::new(&grid);
    for slot in 0..2 {
        let v = crate::fields::slot_of_all(&grid, 2, slot, &px);
        let left = crate::fields::largest(naive.divergence(&v));
        assert!(left < 1e-10 / grid.h[0], "divergence {left:e}");
        for (axis, component) in v.iter().enumerate().take(grid.dims) {
            for at in places(&grid) {
                let low = naive.step(at, axis, -1);
                let closed = solid[naive.id(at)] || low.is_some_and(|low| solid[naive.id(low)]);
                assert!(
                    !closed || component[naive.id(at)] == 0.0,
                    "flow through a closed face"
                );
            }
        }
    }
    let again = project(&px);
    let change = largest_of(&add_scaled_all(&again, -1.0, &px));
    assert!(change < 1e-10, "a second projection changes {change:e}");
    let (one, other) = (dot_all(&px, &y), dot_all(&x, &py));
    assert!(
        (one - other).abs() < 1e-10 * one.abs().max(1.0),
        "{one} and {other}"
    );
}

#[test]
fn the_projection_goes_around_solids() {
    projected_among_solids(&[16, 12], "ww");
    projected_among_solids(&[13, 16], "pw");
    projected_among_solids(&[8, 9, 8], "wpw");
    projected_among_solids(&[270, 9], "ww");
}

/// Where cells may be solid and none is, the projection is that of the box.
#[test]
fn the_projection_among_no_solids_is_that_of_the_box() {
    for (cells, ends) in [(&[16usize, 12][..], "wp"), (&[8, 9, 8], "wpw")] {
        let mut random = Random::new(43);
        let grid = grid(cells, ends);
        let v = random.faces(&grid, 2);
        let one = among(&grid, &vec![false; grid.cells()], v.clone());
        let mut other = v;
        crate::projection::project::<f64>(&grid, 2, &mut other, None, 1e-13, usize::MAX);
        let apart = largest_of(&add_scaled_all(&one, -1.0, &other));
        assert!(apart < 1e-12, "{cells:?} {ends}: {apart:e}");
    }
}

/// A small scene by `limited` transport, with eight iterations of a method.
pub fn eight_iterations(method: Method, cells: &[usize], ends: &str, steps: usize) -> Scene {
    let small = Scene::small(cells, ends, steps);
    Scene {
        scheme: Scheme::Limited,
        params: Params {
            method,
            iterations: 8,
            ..small.params
        },
        ..small
    }
}

/// That three threads come to what one came to.
pub fn same_bits_by_three_threads<T: Real, S: Space>(mut scene: Scene, solved: &Solved) {
    scene.params.threads = 3;
    let threads = with_threads(3, |exec| scene.solve::<T, S>(exec, &mut Silent));
    assert!(
        threads.bits() == solved.bits(),
        "{:?}: three threads give other bits",
        scene.params.method
    );
}

/// Smoke that is steered around a plate: none in it, none through it, none lost.
fn around_a_plate<T: Real, S: Space>(method: Method, cells: &[usize], ends: &str, steps: usize) {
    let mut scene = eight_iterations(method, cells, ends, steps);
    let grid = scene.problem().grid();
    scene.effects.solid = block(&grid);
    if method != Method::Direct && method != Method::Lbfgs {
        scene.effects.buoyancy[1] = 1e-3;
    }
    let solved = scene.solve_alone::<T, S>();
    assert!(solved.status != Status::NotFinite);
    let mass = |rho: &[f64]| rho.iter().sum::<f64>();
    for rho in &solved.density {
        assert!(
            rho.iter()
                .zip(&scene.effects.solid)
                .all(|(&x, &solid)| !solid || x == 0.0)
        );
        assert!((mass(rho) - mass(&solved.density[0])).abs() < 1e-5 * mass(rho));
    }
    let naive = Naive::new(&grid);
    for v in &solved.velocity {
        let v = crate::fields::feasible::faces(&grid, v);
        let (left, fastest) = (crate::fields::largest(naive.divergence(&v)), largest_of(&v));
        assert!(
            left <= 1e-3 * fastest / grid.h[0],
            "divergence {left:e} of a flow of {fastest:e}"
        );
        for (axis, component) in v.iter().enumerate().take(grid.dims) {
            for at in places(&grid) {
                let low = naive.step(at, axis, -1);
                let here = scene.effects.solid[naive.id(at)];
                let closed = here || low.is_some_and(|low| scene.effects.solid[naive.id(low)]);
                assert!(!closed || component[naive.id(at)] == 0.0);
            }
        }
    }
    same_bits_by_three_threads::<T, S>(scene, &solved);
}

#[test]
fn smoke_goes_around_solids() {
    let methods = [
        Method::Direct,
        Method::Lbfgs,
        Method::Pd,
        Method::Simulate,
        Method::Admm,
    ];
    for method in methods {
        around_a_plate::<f64, D2>(method, &[32, 32], "ww", 6);
        around_a_plate::<f32, D2>(method, &[24, 20], "pw", 5);
        around_a_plate::<f32, D3>(method, &[16, 16, 16], "wpw", 4);
    }
}
