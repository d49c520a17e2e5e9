//! A simulation that is guided by a given flow.

use crate::fields::cases::{Scene, Solved, StopAt};
use crate::fields::feasible::{check_flow, faces};
use crate::fields::naive::Naive;
use crate::fields::{
    Components, add_scaled_all, boundaries, cubic, dot_all, flow, gap, largest_of, places, to_file,
    with_threads,
};
use crate::free_flow::free;
use thurible_core::grid::Grid;
use thurible_core::method::simulate::guide::GuideSolver;
use thurible_core::{
    D2, D3, Elsewhere, Feature, InputError, Method, Plan, PlanError, ProblemError, Real, Serial, Silent,
    Solver, Space, Status,
};

/// A flow that begins at rest and has one step.
fn one_step(cells: &[usize], ends: &str) -> Scene {
    let mut scene = free(cells, ends, 2);
    scene.params.method = Method::Guide;
    scene.params.simulation.tolerance = 1e-12;
    scene
}

/// v_1 of a scene.
fn first_flow<T: Real, S: Space>(scene: &Scene) -> Components<f64> {
    let solved = scene.solve_alone::<T, S>();
    assert_eq!(solved.status, Status::Converged);
    faces(&scene.problem().grid(), &solved.velocity[1])
}

/// The value of component `axis` at a place that may be beyond a wall: mirrored across, odd along its own axis.
fn value(grid: &Grid, w: &Components<f64>, axis: usize, at: [isize; 3]) -> f64 {
    let mut sign = 1.0;
    let place = core::array::from_fn(|a| {
        let n = grid.n[a] as isize;
        if grid.axis(a).is_ring() {
            return at[a].rem_euclid(n) as usize;
        }
        let i = at[a].rem_euclid(2 * n);
        if a == axis {
            // Faces: 0 and n are walls.
            if i % n == 0 {
                sign = 0.0;
            }
            if i > n {
                sign = -sign;
            }
            (if i >= n { 2 * n - i } else { i }).rem_euclid(n) as usize
        } else {
            (if i >= n { 2 * n - 1 - i } else { i }) as usize
        }
    });
    sign * w[axis][Naive::new(grid).id(place)]
}

/// Every component as a sum over offsets along one axis.
fn along(grid: &Grid, w: &Components<f64>, a: usize, taps: &[(isize, f64)]) -> Components<f64> {
    Naive::new(grid).at_faces(|axis, at| {
        let term = |&(offset, weight): &(isize, f64)| {
            let mut from = at.map(|i| i as isize);
            from[a] += offset;
            weight * value(grid, w, axis, from)
        };
        taps.iter().map(term).sum()
    })
}

/// B w, tap by tap.
fn blurred(grid: &Grid, sigma: f64, w: &Components<f64>) -> Components<f64> {
    let radius = (3.0 * sigma).ceil() as isize;
    let weight = |o: isize| (-0.5 * (o as f64 / sigma).powi(2)).exp();
    let total: f64 = (-radius..=radius).map(weight).sum();
    let taps: Vec<(isize, f64)> = (-radius..=radius).map(|o| (o, weight(o) / total)).collect();
    (0..grid.dims).fold(w.clone(), |w, axis| along(grid, &w, axis, &taps))
}

/// L w in cells.
fn minus_laplacian(grid: &Grid, w: &Components<f64>) -> Components<f64> {
    let taps = [(-1, -1.0), (0, 2.0), (1, -1.0)];
    let parts = (0..grid.dims).map(|axis| along(grid, w, axis, &taps));
    parts
        .reduce(|sum, part| add_scaled_all(&sum, 1.0, &part))
        .unwrap_or_default()
}

/// The gradient of what Delta minimises has no curl, and no mean along rings.
fn is_the_minimum<T: Real, S: Space>(cells: &[usize], ends: &str, accuracy: f64) {
    let mut scene = one_step(cells, ends);
    (scene.params.guide.radius, scene.params.guide.kinetic) = (1.3, 0.02);
    scene.params.guide.smoothness = 0.05;
    let grid = scene.problem().grid();
    let (found, given) = (first_flow::<T, S>(&scene), scene.reference(1));
    let guide = scene.params.guide;
    let off = add_scaled_all(&found, -1.0, &given);
    let twice = blurred(&grid, guide.radius, &blurred(&grid, guide.radius, &off));
    let slope = add_scaled_all(&twice, guide.smoothness, &minus_laplacian(&grid, &found));
    let slope = add_scaled_all(&slope, guide.kinetic, &found);
    let naive = Naive::new(&grid);
    let size = largest_of(&given);
    assert!(largest_of(&off) > 1e-3 * size && largest_of(&found) > 1e-2 * size);
    assert!(
        naive.largest_curl(&slope) <= accuracy * size / grid.h[0],
        "{cells:?} {ends}: curl {:e} of {size:e}",
        naive.largest_curl(&slope)
    );
    for a in (0..grid.dims).filter(|&a| grid.axis(a).is_ring()) {
        let mean = slope[a].iter().sum::<f64>() / grid.cells() as f64;
        assert!(mean.abs() <= accuracy * size, "{mean:e}");
    }
}

#[test]
fn the_correction_is_the_minimum() {
    is_the_minimum::<f64, D2>(&[16, 12], "ww", 1e-10);
    is_the_minimum::<f64, D2>(&[13, 10], "pw", 1e-10);
    is_the_minimum::<f64, D2>(&[10, 12], "pp", 1e-10);
    is_the_minimum::<f64, D2>(&[260, 6], "wp", 1e-9);
    is_the_minimum::<f64, D2>(&[1024, 16], "wp", 1e-9);
    is_the_minimum::<f64, D3>(&[7, 8, 9], "wpw", 1e-10);
    is_the_minimum::<f32, D3>(&[8, 8, 6], "www", 2e-4);
}

#[test]
fn admm_comes_to_the_closed_form() {
    let mut scene = one_step(&[24, 20], "wp");
    let closed = first_flow::<f64, D2>(&scene);
    scene.params.guide.solver = GuideSolver::Admm;
    let mut apart = |iterations| {
        scene.params.guide.iterations = iterations;
        let off = add_scaled_all(&first_flow::<f64, D2>(&scene), -1.0, &closed);
        (dot_all(&off, &off) / dot_all(&closed, &closed)).sqrt()
    };
    let [one, three, many] = [1, 3, 200].map(&mut apart);
    assert!(one < 0.05 && three < 0.5 * one, "{one:e}, {three:e}");
    assert!(many < 1e-6, "{many:e} after 200 iterations");
}

/// Among solid cells ADMM gets to a flow that no admissible change brings nearer.
fn guided_among_solids<T: Real, S: Space>(cells: &[usize], ends: &str, tolerance: f64) {
    let mut scene = one_step(cells, ends);
    scene.scheme = thurible_core::Scheme::Limited;
    scene.effects.keep_mass = true;
    let grid = scene.problem().grid();
    scene.effects.solid = places(&grid)
        .map(|at| (0..grid.dims).all(|a| at[a] * 3 / grid.n[a] == 1))
        .collect();
    scene.params.simulation.tolerance = tolerance;
    scene.params.guide.iterations = 60;
    let near = first_flow::<T, S>(&scene);
    scene.params.guide.solver = GuideSolver::ClosedForm;
    let rough = first_flow::<T, S>(&scene);
    let naive = Naive::new(&grid);
    assert!(largest_of(&near) > 0.0);
    for (axis, faces) in near.iter().enumerate().take(grid.dims) {
        for (at, &face) in places(&grid).zip(faces) {
            let low = naive.step(at, axis, -1);
            let solid = |at: [usize; 3]| scene.effects.solid[naive.id(at)];
            assert!(
                face == 0.0 || !(solid(at) || low.is_some_and(solid)),
                "flow through a solid face at {at:?}"
            );
        }
    }
    let price = |flow: &Components<f64>| {
        let mut given = scene.reference(1);
        for (axis, faces) in given.iter_mut().enumerate().take(grid.dims) {
            for (at, face) in places(&grid).zip(faces) {
                let low = naive.step(at, axis, -1);
                let solid = |at: [usize; 3]| scene.effects.solid[naive.id(at)];
                if solid(at) || low.is_some_and(solid) {
                    *face = 0.0;
                }
            }
        }
        let off = blurred(
            &grid,
            scene.params.guide.radius,
            &add_scaled_all(flow, -1.0, &given),
        );
        let rough = minus_laplacian(&grid, flow);
        dot_all(&off, &off) + scene.params.guide.smoothness * dot_all(flow, &rough)
    };
    let mut rest = near.clone();
    rest.iter_mut().for_each(|component| component.fill(0.0));
    let [near_price, rough_price, at_rest] = [&near, &rough, &rest].map(price);
    assert!(
        near_price < rough_price && rough_price < at_rest,
        "ADMM {near_price:e}, the box's own eigenvectors {rough_price:e}, at rest {at_rest:e}"
    );
    let both = add_scaled_all(&near, 1.0, &rough);
    let middle = both.map(|component| component.iter().map(|x| 0.5 * x).collect());
    assert!(price(&middle) > near_price, "half way to it is nearer");
}

#[test]
fn solid_cells_stay_closed_to_guided_flows() {
    guided_among_solids::<f64, D2>(&[24, 18], "ww", 1e-8);
    guided_among_solids::<f64, D3>(&[9, 12, 9], "wpw", 1e-8);
    guided_among_solids::<f32, D2>(&[18, 24], "pw", 1e-5);
}

/// A plume without buoyancy rises where a buoyant one guides it, and its forces are those that this takes.
#[test]
fn a_guided_plume_rises_without_buoyancy() {
    let mut risen = free(&[24, 32], "wp", 16);
    risen.effects.buoyancy[1] = 2e-3;
    let truth = risen.solve_alone::<f64, D2>();
    let mut scene = free(&[24, 32], "wp", 16);
    let still = scene.densities[0].clone();
    scene.params.method = Method::Guide;
    let apart = |threads: usize| {
        let mut scene = scene.clone();
        scene.params.threads = threads;
        with_threads(threads, |exec| {
            scene.with::<f64, D2, _>(|solver| {
                for (step, flow) in truth.velocity.iter().enumerate().skip(1) {
                    for (axis, faces) in flow.iter().enumerate() {
                        solver.set_reference(axis, step, faces).unwrap();
                    }
                }
                Solved::run(&scene, solver, exec, &mut Silent)
            })
        })
    };
    let guided = apart(1);
    check_flow(&scene, &guided, f64::EPSILON);
    let [moved, off] = [&still, &guided.density[16]].map(|rho| gap(rho, &truth.density[16]));
    assert!(off < 0.1 * moved, "{off} of {moved}");
    for threads in [2, 3] {
        assert!(apart(threads).bits() == guided.bits(), "{threads} threads");
    }
}

/// A guided solve goes over the flow that it follows, to its end or to a stop: the next one is refused until that is given anew, and then finds what a
/// new solver finds.
#[test]
fn another_guided_solve_needs_the_flow_anew() {
    let mut risen = free(&[16, 20], "wp", 6);
    risen.effects.buoyancy[1] = 2e-3;
    let truth = risen.solve_alone::<f64, D2>();
    let mut scene = free(&[16, 20], "wp", 6);
    scene.params.method = Method::Guide;
    let give = |solver: &mut Solver<'_, f64, D2>, times: f64| {
        for (step, flow) in truth.velocity.iter().enumerate().skip(1) {
            for (axis, faces) in flow.iter().enumerate() {
                let faces: Vec<f64> = faces.iter().map(|x| times * x).collect();
                solver.set_reference(axis, step, &faces).unwrap();
            }
        }
    };
    let guided = |solver: &mut Solver<'_, f64, D2>, times: f64| {
        give(solver, times);
        Solved::run(&scene, solver, &Serial, &mut Silent)
    };
    let [whole, half] = [1.0, 0.5].map(|times| scene.with::<f64, D2, _>(|solver| guided(solver, times)));
    let used = scene.with::<f64, D2, _>(|solver| {
        guided(solver, 1.0);
        solver.set_source(&scene.densities[0]).unwrap();
        assert_eq!(solver.prepare(&Serial), Err(InputError::NoReference));
        guided(solver, 0.5)
    });
    assert!(used.bits() == half.bits());
    for at in [2, 9, 20] {
        let stopped = scene.with::<f64, D2, _>(|solver| {
            give(solver, 0.5);
            let status = solver.solve(&Serial, &mut StopAt { at, seen: 0 }, &mut |_| {});
            assert_eq!(status, Status::Cancelled);
            assert_eq!(solver.prepare(&Serial), Err(InputError::NoReference));
            guided(solver, 1.0)
        });
        assert!(stopped.bits() == whole.bits(), "stopped at {at}");
    }
}

/// A flow of other cells guides as what cubics make of it on the scene's.
#[test]
fn a_flow_of_other_cells_guides() {
    for ends in ["wp", "ww"] {
        let scene = one_step(&[16, 12], ends);
        let (problem, grid) = (scene.problem(), scene.problem().grid());
        let source = Grid::in_cells(&[8, 9], &boundaries(ends));
        let given: Components<f64> = flow::swirl(&source, 1, 0.8);
        let cells: Components<f64> = Naive::new(&grid).at_faces(|axis, at| {
            let place = core::array::from_fn(|a| {
                let half = if a == axis { 0.0 } else { 0.5 };
                (at[a] as f64 + half) * source.n[a] as f64 / grid.n[a] as f64
            });
            let ratio = grid.n[axis] as f64 / source.n[axis] as f64;
            ratio * cubic::at(&source, &given[axis], Some(axis), place)
        });
        // In the scene's units a cell of either grid has another size.
        let [of_source, of_grid] = [9.0, 16.0].map(|n| problem.length / n / problem.dt);
        let along = |elsewhere: bool| {
            let solved = scene.with::<f64, D2, _>(|solver| {
                let file = |grid: &Grid, v: &Components<f64>, unit: f64, axis: usize| -> Vec<f64> {
                    to_file(grid, axis, &v[axis])
                        .into_iter()
                        .map(|x| x * unit)
                        .collect()
                };
                if elsewhere {
                    let faces: [Vec<f64>; 2] = [0, 1].map(|axis| file(&source, &given, of_source, axis));
                    let from = Elsewhere {
                        cells: [8, 9, 1],
                        unit: of_source,
                    };
                    let all = [&*faces[0], &*faces[1], &[]];
                    solver.set_reference_from(&Serial, 1, from, all).unwrap();
                } else {
                    for axis in 0..2 {
                        let faces = file(&grid, &cells, of_grid, axis);
                        solver.set_reference(axis, 1, &faces).unwrap();
                    }
                }
                Solved::run(&scene, solver, &Serial, &mut Silent)
            });
            faces(&grid, &solved.velocity[1])
        };
        let [elsewhere, here] = [along(true), along(false)];
        let apart = largest_of(&add_scaled_all(&elsewhere, -1.0, &here));
        assert!(
            largest_of(&here) > 0.0 && apart < 1e-9 * largest_of(&here),
            "{ends}: {apart:e} of {:e}",
            largest_of(&here)
        );
    }
    let scene = one_step(&[8, 8], "ww");
    scene.with::<f32, D2, _>(|solver| {
        let from = |cells| Elsewhere { cells, unit: 1.0 };
        let refused = solver.set_reference_from(&Serial, 1, from([512, 512, 1]), [&[]; 3]);
        let cells = 512 * 512;
        assert_eq!(refused, Err(InputError::TooFine { cells }));
        let refused = solver.set_reference_from(&Serial, 2, from([4, 4, 1]), [&[]; 3]);
        assert_eq!(refused, Err(InputError::Index { given: 1, count: 1 }));
        let refused = solver.set_reference_from(&Serial, 1, from([4, 4, 1]), [&[0.0; 20], &[0.0; 3], &[]]);
        let (expected, given) = (20, 3);
        assert_eq!(refused, Err(InputError::Length { expected, given }));
    });
}

#[test]
fn what_cannot_guide_is_refused() {
    let scene = one_step(&[8, 8], "ww");
    scene.with::<f32, D2, _>(|solver| {
        let faces = vec![0.0; solver.faces(0)];
        let index = |given, count| Err(InputError::Index { given, count });
        assert_eq!(solver.set_reference(2, 1, &faces), index(2, 2));
        assert_eq!(solver.set_reference(0, 2, &faces), index(1, 1));
        assert_eq!(solver.set_reference(0, 0, &faces), index(usize::MAX, 1));
        let (expected, given) = (faces.len(), 3);
        assert_eq!(
            solver.set_reference(0, 1, &faces[..3]),
            Err(InputError::Length { expected, given })
        );
        let mut broken = faces.clone();
        broken[5] = f32::NAN;
        assert_eq!(
            solver.set_reference(0, 1, &broken),
            Err(InputError::NotFinite { index: 5 })
        );
    });
    // Without a flow to follow nothing begins.
    let mut memory = crate::fields::Memory::new(scene.plan::<f32, D2>().bytes());
    let mut solver = Solver::<f32, D2>::new(&scene.problem(), &scene.params, memory.block()).unwrap();
    solver
        .set_source(&crate::fields::cast(&scene.densities[0]))
        .unwrap();
    assert_eq!(solver.prepare(&Serial), Err(InputError::NoReference));
    let mut other = scene.clone();
    other.params.method = Method::Simulate;
    other.with::<f32, D2, _>(|solver| {
        let faces = vec![0.0; solver.faces(0)];
        let none = InputError::Index { given: 0, count: 0 };
        assert_eq!(solver.set_reference(0, 1, &faces), Err(none));
    });
    let mut open = scene.clone();
    open.boundary = boundaries("ow");
    (open.scheme, open.effects.keep_mass) = (thurible_core::Scheme::Limited, true);
    let unfit = ProblemError::Unfit {
        method: "guide",
        feature: Feature::Open,
    };
    assert_eq!(
        Plan::new::<f32, D2>(&open.problem(), &open.params).map(|_| ()),
        Err(PlanError::Problem(unfit))
    );
    // A Gaussian of any width would take any time to plan.
    let mut wide = scene.clone();
    for given in [64.0, 1e300] {
        wide.params.guide.radius = given;
        let (field, limit) = ("guide.radius", 64.0);
        assert_eq!(
            Plan::new::<f32, D2>(&wide.problem(), &wide.params).map(|_| ()),
            Err(PlanError::Problem(ProblemError::NotWithin {
                field,
                given,
                limit
            }))
        );
    }
}

/// The noise of one step from rest, which a dear correction leaves as it is, in box lengths a step.
fn noise<T: Real, S: Space>(
    cells: &[usize],
    ends: &str,
    change: impl Fn(&mut Scene),
) -> (Grid, Components<f64>) {
    let mut scene = one_step(cells, ends);
    scene.params.guide.kinetic = 1e12;
    scene.params.guide.noise.strength = 0.4;
    change(&mut scene);
    let grid = scene.problem().grid();
    let unit = scene.length / scene.dt;
    let found = first_flow::<T, S>(&scene);
    (
        grid,
        found.map(|component| component.iter().map(|x| x / unit).collect()),
    )
}

fn noise_is_a_flow<T: Real, S: Space>(cells: &[usize], ends: &str) {
    let (grid, found) = noise::<T, S>(cells, ends, |_| ());
    let size = (dot_all(&found, &found) / grid.cells() as f64).sqrt();
    let accuracy = 1e-7 + 100.0 * T::EPSILON;
    assert!((size / (0.4 * grid.h[0]) - 1.0).abs() < accuracy, "{size:e}");
    let divergence = largest_of(&[Naive::new(&grid).divergence(&found), Vec::new(), Vec::new()]);
    assert!(
        divergence < accuracy * largest_of(&found) / grid.h[0],
        "{divergence:e}"
    );
    // No axis is left out, and neighbours are alike: the noise is blurred.
    let naive = Naive::new(&grid);
    for (axis, component) in found.iter().enumerate().take(grid.dims) {
        let mean_square = dot_all(&found, &found) / component.len() as f64;
        assert!(component.iter().map(|x| x * x).sum::<f64>() / component.len() as f64 > 0.1 * mean_square);
        let beside = places(&grid).map(|at| component[naive.id(naive.walk(at, axis, 1))]);
        let together: f64 = component.iter().zip(beside).map(|(x, next)| x * next).sum();
        assert!(together > 0.5 * component.iter().map(|x| x * x).sum::<f64>());
    }
    let [again, other] =
        [1, 2].map(|seed| noise::<T, S>(cells, ends, |scene| scene.params.guide.noise.seed = seed).1);
    assert!(again == found && other != found);
}

#[test]
fn noise_has_its_strength_and_no_divergence() {
    noise_is_a_flow::<f64, D2>(&[24, 18], "ww");
    noise_is_a_flow::<f32, D2>(&[17, 20], "pw");
    noise_is_a_flow::<f64, D3>(&[12, 10, 14], "wpw");
    noise_is_a_flow::<f32, D3>(&[10, 12, 9], "ppp");
}

/// What is larger than the radius is the given flow's, here rest; what is smaller stays.
#[test]
fn guidance_calms_the_large_waves_of_noise() {
    let (grid, free) = noise::<f64, D2>(&[40, 32], "pp", |_| ());
    let (_, led) = noise::<f64, D2>(&[40, 32], "pp", |scene| {
        (scene.params.guide.kinetic, scene.params.guide.radius) = (0.0, 2.0);
        scene.params.guide.noise.sigma = 2.0;
    });
    let large = |w: &Components<f64>| {
        let w = blurred(&grid, 4.0, w);
        dot_all(&w, &w)
    };
    let still = one_step(&[40, 32], "pp").reference(1);
    let away = add_scaled_all(&led, -1.0, &still);
    assert!(
        large(&away) < 0.2 * large(&free),
        "{} of {}",
        large(&away),
        large(&free)
    );
}

#[test]
fn noise_goes_through_no_solid_cell_and_is_the_same_on_any_threads() {
    let disc = |scene: &mut Scene| {
        let grid = scene.problem().grid();
        scene.scheme = thurible_core::Scheme::Limited;
        scene.effects.keep_mass = true;
        scene.effects.solid = places(&grid)
            .map(|at| (0..grid.dims).all(|a| at[a] * 3 / grid.n[a] == 1))
            .collect();
    };
    let (grid, found) = noise::<f64, D2>(&[24, 18], "ww", disc);
    assert!(largest_of(&found) > 0.1 * grid.h[0]);
    let inside = (9..15).flat_map(|x| (6..12).map(move |y| [x, y, 0]));
    let naive = Naive::new(&grid);
    assert!(
        inside
            .into_iter()
            .all(|at| (0..2).all(|axis| found[axis][naive.id(at)] == 0.0))
    );
    let [alone, together] = [1, 3].map(|threads| {
        let mut scene = one_step(&[72, 64], "pw");
        (scene.params.guide.noise.strength, scene.params.threads) = (0.4, threads);
        with_threads(threads, |exec| {
            scene.with::<f32, D2, _>(|solver| Solved::run(&scene, solver, exec, &mut Silent))
        })
    });
    assert!(alone.bits() == together.bits());
}
