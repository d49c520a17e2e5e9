//! Control by templates: fields and their derivatives, the gradient by the unknowns, and solves.

use crate::fields::cases::Scene;
use crate::fields::control::Control;
use crate::fields::effects::templates;
use crate::fields::feasible::check;
use crate::fields::random::Random;
use crate::fields::{flow, grid, index, places, view_mut, with_threads, zeros};
use crate::gradients::taylor;
use thurible_core::force::template::Placed;
use thurible_core::objective::script::Lists;
use thurible_core::{
    Advection, D2, D3, Method, Named, Params, Scheme, Serial, Silent, Space, Status, Template, TemplateKind,
};

/// The field of a template of amplitude `a` at `x`, as the documents have it.
fn expected(template: &Template, dims: usize, a: [f64; 3], x: [f64; 3]) -> Option<[f64; 3]> {
    let d: [f64; 3] = core::array::from_fn(|i| if i < dims { x[i] - template.center[i] } else { 0.0 });
    let s = template.radius;
    let w = (-d.iter().map(|d| d * d).sum::<f64>() / (2.0 * s * s)).exp();
    match template.kind {
        TemplateKind::Wind => Some(a.map(|a| a * w)),
        TemplateKind::Vortex => {
            let [p, q, r] = if dims == 2 { [0.0, 0.0, a[0]] } else { a };
            let cross = [q * d[2] - r * d[1], r * d[0] - p * d[2], p * d[1] - q * d[0]];
            Some(cross.map(|f| f * w / s))
        }
        TemplateKind::Attract => Some(d.map(|d| -a[0] * d * w / s)),
        TemplateKind::Noise => None,
    }
}

/// Values at faces by the formulas, in the steps and intervals that are asked for and nowhere else.
fn fields_at_faces(cells: &[usize], ends: &str) {
    let (grid, slots) = (grid(cells, ends), 6);
    for kind in [TemplateKind::Wind, TemplateKind::Vortex] {
        let template = Template {
            from: 1,
            interval: 3,
            ..Template::new(kind, [0.4, 0.5, 0.3], 0.2, 5)
        };
        let placed = Placed::new(&grid, Default::default(), slots, template);
        let amplitude = |interval: usize| [0.3, -0.7, 1.1].map(|a| a * (1.0 + interval as f64));
        let mut out = zeros::<f64>(&grid, slots);
        placed.add(&Serial, &amplitude, &[], (0..slots, 0), &mut view_mut(&mut out));
        for slot in 0..slots {
            let acts = (1..5).contains(&slot);
            let inside = places(&grid).filter(|&at| !grid.is_outside(at));
            for (axis, at) in inside.flat_map(|at| (0..grid.dims).map(move |axis| (axis, at))) {
                let wall = at[axis] == 0 && matches!(ends.as_bytes()[axis], b'w' | b'h');
                // Layers outside lie before the box begins.
                let x = core::array::from_fn(|i| {
                    let cell = (at[i] - grid.inside()[i].start) as f64;
                    (cell + if i == axis { 0.0 } else { 0.5 }) * grid.h[i]
                });
                let a = amplitude(usize::from(slot == 4));
                let f = expected(&template, grid.dims, a, x).unwrap()[axis];
                let f = if acts && !wall { f } else { 0.0 };
                let found = out[axis][index(&grid, slots, slot, at)];
                assert!(
                    (found - f).abs() < 1e-14,
                    "{kind:?} {axis} {at:?} in slot {slot}: {found} for {f}"
                );
            }
        }
    }
}

#[test]
fn templates_are_what_the_documents_say() {
    fields_at_faces(&[9, 7], "ww");
    fields_at_faces(&[8, 7], "wp");
    fields_at_faces(&[5, 6, 4], "wpw");
    fields_at_faces(&[9, 7], "ol");
    fields_at_faces(&[5, 6, 4], "lwh");
}

/// Noise has no divergence that shrinking cells do not take away, and its seed and size matter.
#[test]
fn noise_stirs_without_divergence() {
    let field = |n: usize, seed: u32, size: f64| {
        let grid = grid(&[n, n], "ww");
        let template = Template {
            size,
            seed,
            ..Template::new(TemplateKind::Noise, [0.5, 0.5, 0.0], 0.12, 1)
        };
        let placed = Placed::new(&grid, Default::default(), 1, template);
        let mut out = zeros::<f64>(&grid, 1);
        placed.add(
            &Serial,
            &|_| [1.0, 0.0, 0.0],
            &[],
            (0..1, 0),
            &mut view_mut(&mut out),
        );
        (grid, out)
    };
    let divergence = |n: usize| {
        let (grid, out) = field(n, 1, 0.2);
        let at = |axis: usize, at: [usize; 3]| {
            let inside = (0..2).all(|a| at[a] < n);
            if inside {
                out[axis][index(&grid, 1, 0, at)]
            } else {
                0.0
            }
        };
        let one = |[x, y, z]: [usize; 3]| {
            let along = at(0, [x + 1, y, z]) - at(0, [x, y, z]);
            (along + at(1, [x, y + 1, z]) - at(1, [x, y, z])).abs() * n as f64
        };
        places(&grid).map(one).fold(0.0, f64::max)
    };
    let (coarse, fine) = (divergence(32), divergence(64));
    assert!(coarse > 0.1 && fine < 0.3 * coarse, "{coarse} and {fine}");
    let largest = |field: &[f64]| field.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let (one, other, finer) = (field(32, 1, 0.2).1, field(32, 2, 0.2).1, field(32, 1, 0.1).1);
    assert!((0.5..3.0).contains(&largest(&one[0])), "{}", largest(&one[0]));
    assert!(one != other && one != finer && one == field(32, 1, 0.2).1);
}

/// The gradient by every unknown of every kind against differences.
fn gradients<S: Space>(cells: &[usize], ends: &str, scheme: Scheme, solids: bool) {
    let mut random = Random::new(53);
    let (grid, steps) = (grid(cells, ends), 5);
    let solid: Vec<bool> = places(&grid)
        .map(|at| solids && (0..grid.dims).all(|a| (3 * grid.n[a] / 8..grid.n[a] / 2 + 1).contains(&at[a])))
        .collect();
    let clear = |mut rho: Vec<f64>| {
        rho.iter_mut()
            .zip(&solid)
            .filter(|(_, solid)| **solid)
            .for_each(|(x, _)| *x = 0.0);
        rho
    };
    let source = clear(random.density(&grid));
    let targets = [clear(random.density(&grid)), clear(random.density(&grid))].concat();
    let initial = if solids {
        zeros(&grid, 1)
    } else {
        flow::rough(&mut random, &grid, 1, 0.3)
    };
    let sides = core::array::from_fn(|a| grid.n[a] as f64 * grid.h[a]);
    for kind in TemplateKind::ALL {
        let own = templates(&sides, steps)
            .into_iter()
            .filter(|template| template.kind == *kind);
        let own: Vec<Template> = own
            .map(|template| Template {
                moves: true,
                ..template
            })
            .collect();
        let packed: Vec<f64> = own.iter().flat_map(Template::pack).collect();
        let control = Control {
            grid: &grid,
            steps,
            source: &source,
            lists: Lists {
                steps: &[2, 5],
                knots: &[1, 3],
                factors: &[4.0, 0.5],
                templates: &packed,
                ..Default::default()
            },
            fields: &targets,
            buoyancy: [0.01, -0.02, if grid.dims == 3 { 0.03 } else { 0.0 }],
            solid: if solids { &solid } else { &[] },
            sticks: false,
            initial: &initial,
            advection: Advection {
                scheme,
                tolerance: 1e-200,
            },
            filters: 2,
            penalty: 1.0,
            viscosity: 0.01,
            smoothing: 0.05,
        };
        let count: usize = own
            .iter()
            .map(|template| template.unknowns(grid.dims, steps - 1))
            .sum();
        let z: Vec<f64> = (0..count).map(|i| 0.4 + 0.3 * (i as f64).sin()).collect();
        let (found, _) = control.searched::<S>(&z, 1.0);
        let weight = 3.0 * found.data / found.force;
        let (_, gradient) = control.searched::<S>(&z, weight);
        for (which, slope) in gradient.iter().enumerate() {
            let value = |t: f64| {
                let mut z = z.clone();
                z[which] += t;
                control.searched::<S>(&z, weight).0.total()
            };
            taylor(
                &format!("unknown {which} of {kind:?} on {cells:?} {ends}"),
                1e-3,
                *slope,
                value,
            );
        }
    }
}

#[test]
fn gradients_by_every_unknown() {
    gradients::<D2>(&[12, 11], "ww", Scheme::Central, false);
    gradients::<D2>(&[11, 12], "pw", Scheme::Central, false);
    gradients::<D2>(&[12, 11], "wp", Scheme::Central, true);
    gradients::<D3>(&[8, 7, 6], "wpw", Scheme::Central, false);
}

/// A blob that a wind and a vortex of known amplitudes carry, to be found again from 0: by the method, and by nothing but its end.
#[test]
fn amplitudes_are_found_again() {
    let template = |kind, center, amplitude| Template {
        amplitude,
        ..Template::new(kind, center, 0.25, 10)
    };
    let known = [[4e-3, 2e-3, 0.0], [6e-3, 0.0, 0.0]];
    let kinds = [TemplateKind::Wind, TemplateKind::Vortex];
    let centers = [[0.4, 0.4, 0.0], [0.6, 0.5, 0.0]];
    let all = |amplitudes: [[f64; 3]; 2]| -> Vec<Template> {
        let each = kinds.into_iter().zip(centers).zip(amplitudes);
        each.map(|((kind, center), amplitude)| template(kind, center, amplitude))
            .collect()
    };
    let mut scene = Scene {
        scheme: Scheme::Limited,
        force_weight: 1e-3,
        ..Scene::small(&[24, 24], "ww", 10)
    };
    scene.params = Params {
        method: Method::Simulate,
        iterations: 60,
        ..Params::default()
    };
    scene.effects.keep_mass = true;
    scene.effects.templates = all(known);
    let made = scene.solve_alone::<f64, D2>();
    scene.densities[1] = made.density[10].clone();
    scene.params.method = Method::Templates;
    scene.params.templates.tolerance = 1e-9;
    scene.effects.templates = all([[0.0; 3]; 2]);
    scene.with::<f64, D2, _>(|solver| {
        let status = solver.solve(&Serial, &mut Silent, &mut |_| {});
        assert!(
            matches!(
                status,
                Status::Converged | Status::Stalled | Status::MaxIterations
            ),
            "{status:?}"
        );
        for (index, known) in known.iter().enumerate() {
            let found = solver.template(index).unwrap();
            for (found, known) in found.amplitude.iter().zip(known) {
                assert!(
                    (found - known).abs() < 0.02 * 6e-3,
                    "{found} for {known}, {:?}",
                    solver.objective()
                );
            }
        }
    });
}

/// Middles and radii move where they may, stay where they may not, and the objective falls in every iteration.
fn searches<T: thurible_core::Real, S: Space>(cells: &[usize], ends: &str) {
    let mut scene = Scene {
        scheme: Scheme::Quick,
        ..Scene::small(cells, ends, 8)
    };
    scene.params = Params {
        method: Method::Templates,
        iterations: 6,
        threads: 2,
        ..Params::default()
    };
    scene.force_weight = 1.0;
    let scene = scene.with_templates();
    let solved = with_threads(2, |exec| scene.solve::<T, S>(exec, &mut Silent));
    check(&scene, &solved, T::EPSILON);
    for pair in solved.history.windows(2) {
        let [before, after] = [&pair[0], &pair[1]].map(|progress| progress.objective.total());
        assert!(after < before, "{cells:?}: {after} after {before}");
    }
    scene.with::<T, S, _>(|solver| {
        solver.solve(&Serial, &mut Silent, &mut |_| {});
        assert!(solver.template(scene.effects.templates.len()).is_none());
        for (index, given) in scene.effects.templates.iter().enumerate() {
            let found = solver.template(index).unwrap();
            let still = found.radius == given.radius && found.center[..S::DIM] == given.center[..S::DIM];
            let near = (found.radius - given.radius).abs() < 1e-6
                && (found.center[0] - given.center[0]).abs() < 1e-6;
            assert_eq!(given.moves, !(still || near), "{given:?} became {found:?}");
            let inside = (0..S::DIM).all(|a| (-0.2..1.2).contains(&found.center[a]));
            assert!(inside && found.radius > 0.25 * given.radius && found.radius < 4.0 * given.radius);
            assert_eq!((found.to, found.intervals(found.to)), (7, given.intervals(7)));
            assert_ne!(found.amplitude, [0.0; 3]);
        }
    });
}

#[test]
fn searches_move_what_may_move() {
    searches::<f64, D2>(&[20, 16], "ww");
    searches::<f32, D2>(&[16, 21], "pw");
    searches::<f32, D3>(&[10, 12, 8], "wpw");
}

/// What the core refuses of templates, in words.
#[test]
fn odd_templates_are_refused() {
    let mut scene = Scene::small(&[12, 8], "ww", 6);
    scene.params.method = Method::Templates;
    let good = Template::new(TemplateKind::Wind, [0.5, 0.3, 7.0], 0.2, 6);
    let refused = |scene: &Scene| {
        let plan = thurible_core::Plan::new::<f32, D2>(&scene.problem(), &scene.params);
        plan.unwrap_err().to_string()
    };
    assert!(refused(&scene).contains("there is no template"));
    let cases: [(Template, &str); 9] = [
        (
            Template { from: 6, ..good },
            "template 0 must act from a force to a later one; there are 5",
        ),
        (Template { from: 5, ..good }, "template 0 must act"),
        (Template { to: 7, ..good }, "template 0 must act"),
        (
            Template { interval: 0, ..good },
            "template 0 has an interval of 0 steps",
        ),
        (
            Template { radius: 0.0, ..good },
            "template.radius is 0; it must be positive",
        ),
        (Template { size: -1.0, ..good }, "template.size is -1"),
        (
            Template {
                amplitude: [0.0, f64::NAN, 0.0],
                ..good
            },
            "template.amplitude is NaN",
        ),
        (
            Template {
                center: [0.5, 0.7, 0.0],
                ..good
            },
            "template 0 has its middle at 0.7 along axis 1",
        ),
        (
            Template {
                center: [f64::NAN, 0.5, 0.0],
                ..good
            },
            "template 0 has its middle at NaN along axis 0",
        ),
    ];
    for (odd, words) in cases {
        scene.effects.templates = vec![odd];
        assert!(refused(&scene).contains(words), "{odd:?}: {}", refused(&scene));
    }
    scene.effects.templates = vec![good];
    scene.effects.release = Some(4);
    scene.keyframes = vec![3];
    scene.effects.templates[0].from = 3;
    assert!(refused(&scene).contains("there are 3 of them"));
    for method in [Method::Direct, Method::Lbfgs, Method::Pd, Method::Admm] {
        scene.params.method = method;
        let words = format!("the method {} knows no templates", method.name());
        scene.effects.templates = vec![good];
        assert!(refused(&scene).contains(&words), "{}", refused(&scene));
    }
}
