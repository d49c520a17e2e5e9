//! Energy, gradient, Hessian, basis, rotations: each against something plainer.

use super::bench::{Bench, apart};
use super::reference::rod;
use thurible_core::condense::{Basis, Block, CondenseParams, Condenser, Regular, Spring, Step, Update};
use thurible_core::{Named, Serial, Silent};

fn params(method: Update) -> CondenseParams {
    CondenseParams {
        method,
        ..CondenseParams::default()
    }
}

/// A square and a box with a spring between two free vertices.
fn sprung(dims: usize) -> Bench {
    let mut bench = Bench::stretch(dims, 3);
    let free: Vec<u32> = (0..bench.vertices() as u32)
        .filter(|&vertex| !bench.held[vertex as usize])
        .collect();
    let ends = [free[0], free[free.len() - 1]];
    bench.springs = vec![Spring {
        ends,
        stiffness: 3e4,
        rest_length: 0.2,
        in_basis: true,
    }];
    bench
}

fn one<const D: usize>(bench: &Bench, [vertex, k]: [usize; 2], by: f64) -> Vec<f64> {
    let mut shift = vec![0.0; bench.rest.len()];
    shift[vertex * D + k] = by;
    shift
}

fn gradient_by_differences<const D: usize>(bench: &Bench, dt: Option<f64>) {
    let params = CondenseParams {
        dt,
        ..params(Update::Plain)
    };
    let moved = bench.random(0.01, true);
    bench.run::<f64, D, _>(params, |run| {
        // A step without an iteration sets where inertia leads, and gravity.
        let step = Step {
            shift: &moved,
            gravity: [0.3, -2.0, 0.7],
        };
        run.step(&Serial, &step, &mut Stop, &mut |_| {}).unwrap();
        run.evaluate(&Serial);
        let h = 1e-6;
        let largest = bench
            .unknowns()
            .iter()
            .map(|&[vertex, k]| run.gradient(vertex)[k].abs())
            .fold(0.0, f64::max);
        for at in bench.unknowns() {
            run.shift(&one::<D>(bench, at, h)).unwrap();
            let [above, _] = run.evaluate(&Serial);
            run.shift(&one::<D>(bench, at, -2.0 * h)).unwrap();
            let [below, _] = run.evaluate(&Serial);
            run.shift(&one::<D>(bench, at, h)).unwrap();
            run.evaluate(&Serial);
            let (found, expected) = (run.gradient(at[0])[at[1]], (above - below) / (2.0 * h));
            assert!(
                (found - expected).abs() < 1e-6 * largest,
                "{at:?}: {found}, not {expected}"
            );
        }
    });
}

/// Stops before the first iteration.
struct Stop;

impl thurible_core::Observer for Stop {
    fn on(&mut self, event: thurible_core::Event) -> core::ops::ControlFlow<()> {
        match event {
            thurible_core::Event::IterationBegin { .. } => core::ops::ControlFlow::Break(()),
            _ => core::ops::ControlFlow::Continue(()),
        }
    }
}

#[test]
fn the_gradient_is_that_of_the_energy() {
    for dt in [None, Some(0.02)] {
        gradient_by_differences::<2>(&sprung(2), dt);
        gradient_by_differences::<3>(&sprung(3), dt);
    }
    gradient_by_differences::<1>(&Bench::new(&[9], &[1.0], |place| place[0] == 0.0), Some(0.02));
}

/// Near rest no element's block has a negative eigenvalue, so nothing is projected away.
fn hessian_by_differences<const D: usize>(bench: &Bench) {
    bench.run::<f64, D, _>(params(Update::Plain), |run| {
        // All stretched alike, so that the springs and the elements are.
        let stretched = bench.field(|place, _, axis| 0.05 * place[axis]);
        run.shift(&stretched).unwrap();
        run.make_hessian(&Serial, true);
        let (all, h) = (bench.unknowns(), 1e-6);
        let largest = all
            .iter()
            .map(|&[vertex, k]| run.hessian_block(vertex, vertex)[k][k])
            .fold(0.0, f64::max);
        for &at in &all {
            let mut sides = [1.0, -1.0].map(|side| {
                run.shift(&one::<D>(bench, at, side * h)).unwrap();
                run.evaluate(&Serial);
                let gradient: Vec<f64> = all.iter().map(|&[vertex, k]| run.gradient(vertex)[k]).collect();
                run.shift(&one::<D>(bench, at, -side * h)).unwrap();
                gradient
            });
            let below = core::mem::take(&mut sides[1]);
            for ((&row, above), below) in all.iter().zip(&sides[0]).zip(below) {
                let expected = (above - below) / (2.0 * h);
                let found = run.hessian_block(row[0], at[0])[row[1]][at[1]];
                assert!(
                    (found - expected).abs() < 1e-6 * largest,
                    "{row:?} {at:?}: {found}, not {expected}"
                );
            }
        }
    });
}

#[test]
fn the_hessian_is_that_of_the_gradient() {
    hessian_by_differences::<2>(&sprung(2));
    hessian_by_differences::<3>(&sprung(3));
}

#[test]
fn meshes_fill_their_boxes_and_are_not_inverted() {
    for (cells, size) in [(vec![5, 4], vec![1.0, 0.3]), (vec![3, 2, 4], vec![1.0, 0.5, 2.0])] {
        let bench = Bench::new(&cells, &size, |_| false);
        let volume: f64 = size.iter().product();
        assert!((bench.mesh().volume() - volume).abs() < 1e-12);
        assert!(bench.mesh().check().is_ok());
        let mesh = Regular::new(&cells, &size).unwrap();
        assert_eq!(
            mesh.elements(),
            cells.iter().product::<usize>() * [2, 6][cells.len() - 2]
        );
    }
    assert!(Regular::new(&[0, 1], &[1.0, 1.0]).is_none() && Regular::new(&[1], &[1.0, 1.0]).is_none());
}

/// H0_CC U_i = -H0_Ci, in the rows that a column reaches.
fn basis_solves<const D: usize>(bench: &Bench, params: CondenseParams) {
    bench.run::<f64, D, _>(params, |run| {
        run.make_hessian(&Serial, true);
        run.build_basis(&Serial);
        let all = bench.unknowns();
        let same = |one: [usize; 2], other: [usize; 2]| {
            one[0] == other[0] && (params.block == Block::Vertex || one[1] == other[1])
        };
        let largest = run.hessian_block(all[0][0], all[0][0])[0][0];
        for &column in &all {
            for &row in &all {
                let own = same(row, column);
                let reached = run.basis_value(row, column) != 0.0;
                if own {
                    assert_eq!(run.basis_value(row, column), 0.0);
                } else if params.radius.is_none() || reached {
                    let product: f64 = all
                        .iter()
                        .map(|&at| {
                            run.hessian_block(row[0], at[0])[row[1]][at[1]] * run.basis_value(at, column)
                        })
                        .sum();
                    let coupling = run.hessian_block(row[0], column[0])[row[1]][column[1]];
                    assert!((product + coupling).abs() < 1e-9 * largest, "{row:?} {column:?}");
                }
            }
        }
    });
}

#[test]
fn a_basis_says_how_the_rest_follows() {
    for radius in [None, Some(1), Some(2), Some(100)] {
        for block in [Block::Vertex, Block::Scalar] {
            let params = CondenseParams {
                radius,
                block,
                ..CondenseParams::default()
            };
            basis_solves::<2>(&Bench::stretch(2, 4), params);
            basis_solves::<3>(&Bench::stretch(3, 2), params);
        }
    }
}

fn directions<const D: usize>(bench: &Bench, params: CondenseParams, built_here: bool) -> Vec<f64> {
    let moved = bench.random(0.03, true);
    bench.run::<f64, D, _>(params, |run| {
        if !built_here {
            run.build_basis(&Serial);
        }
        run.shift(&moved).unwrap();
        if built_here {
            run.build_basis(&Serial);
        }
        run.make_direction(&Serial);
        (0..bench.vertices())
            .flat_map(|vertex| run.direction(vertex))
            .collect()
    })
}

#[test]
fn an_exact_basis_makes_a_pass_newtons_step() {
    let (plane, space) = (Bench::stretch(2, 5), Bench::stretch(3, 2));
    for method in [Update::Cc, Update::Projected, Update::Chord] {
        let (found, newton) = (
            directions::<2>(&plane, params(method), true),
            directions::<2>(&plane, params(Update::Newton), true),
        );
        assert!(apart(&found, &newton) < 1e-7, "{}", method.name());
        let (found, newton) = (
            directions::<3>(&space, params(method), true),
            directions::<3>(&space, params(Update::Newton), true),
        );
        assert!(apart(&found, &newton) < 1e-7, "{} in space", method.name());
    }
    let (bench, velocity) = rod(1e3);
    let rods = [Update::Cc, Update::Newton].map(|method| {
        let params = CondenseParams {
            dt: Some(0.04),
            ..params(method)
        };
        bench.run::<f64, 1, _>(params, |run| {
            run.set_velocity(&velocity).unwrap();
            assert_eq!(
                run.step(&Serial, &Step::default(), &mut Silent, &mut |_| {})
                    .unwrap()
                    .iterations,
                1
            );
            (0..bench.vertices())
                .map(|vertex| run.position(vertex)[0])
                .collect::<Vec<f64>>()
        })
    });
    assert!(apart(&rods[0], &rods[1]) < 1e-10);
}

#[test]
fn a_radius_beyond_the_mesh_is_all_of_it() {
    let bench = Bench::stretch(2, 5);
    for method in [Update::Cc, Update::Jgs2, Update::Projected] {
        let whole = directions::<2>(&bench, params(method), false);
        let patched = directions::<2>(
            &bench,
            CondenseParams {
                radius: Some(50),
                ..params(method)
            },
            false,
        );
        assert!(
            apart(&patched, &whole) < 1e-8,
            "{}: {:e}",
            method.name(),
            apart(&patched, &whole)
        );
        let short = directions::<2>(
            &bench,
            CondenseParams {
                radius: Some(1),
                ..params(method)
            },
            false,
        );
        assert!(apart(&short, &whole) > 1e-3);
    }
}

/// A rotation about an axis that is none of the mesh's.
fn rotation<const D: usize>() -> [[f64; D]; D] {
    let mut turn = [[0.0; D]; D];
    let (sine, cosine) = 2.1f64.sin_cos();
    if D == 2 {
        (turn[0][0], turn[0][1], turn[1][0], turn[1][1]) = (cosine, -sine, sine, cosine);
        return turn;
    }
    let axis = [1.0f64 / 3.0, 2.0 / 3.0, -2.0 / 3.0];
    for i in 0..D {
        for k in 0..D {
            let cross = match (3 + k - i) % 3 {
                0 => 0.0,
                1 => -axis[3 - i - k],
                _ => axis[3 - i - k],
            };
            turn[i][k] =
                (1.0 - cosine) * axis[i] * axis[k] + sine * cross + if i == k { cosine } else { 0.0 };
        }
    }
    turn
}

/// A mesh that is deformed and then turned has the directions of the unturned one, turned.
fn turned<const D: usize>(bench: &Bench, method: Update, basis: Basis) {
    let moved = bench.random(0.02, true);
    let turn = rotation::<D>();
    let apply =
        |x: &[f64]| -> [f64; D] { core::array::from_fn(|i| turn[i].iter().zip(x).map(|(a, x)| a * x).sum()) };
    let params = CondenseParams {
        basis,
        ..params(method)
    };
    let direction = |shift: &[f64]| -> Vec<f64> {
        bench.run::<f64, D, _>(params, |run: &mut Condenser<'_, f64, D>| {
            run.build_basis(&Serial);
            run.shift(shift).unwrap();
            run.make_direction(&Serial);
            (0..bench.vertices())
                .flat_map(|vertex| run.direction(vertex)[..D].to_vec())
                .collect()
        })
    };
    let straight = direction(&moved);
    let places = bench.rest.chunks_exact(D).zip(moved.chunks_exact(D));
    let shift: Vec<f64> = places
        .flat_map(|(place, moved)| {
            let there: Vec<f64> = place.iter().zip(moved).map(|(x, u)| x + u).collect();
            let there = apply(&there);
            (0..D).map(move |k| there[k] - place[k]).collect::<Vec<f64>>()
        })
        .collect();
    let expected: Vec<f64> = straight.chunks_exact(D).flat_map(apply).collect();
    let apart = apart(&direction(&shift), &expected);
    assert!(
        apart < 1e-8,
        "{} {} in {D}: {apart:e}",
        method.name(),
        basis.name()
    );
}

#[test]
fn a_turned_mesh_has_the_turned_direction() {
    let (plane, space) = (Bench::stretch(2, 4), Bench::stretch(3, 2));
    for method in [Update::Cc, Update::Jgs2, Update::Jgs2Local, Update::Projected] {
        turned::<2>(&plane, method, Basis::Corotated);
        turned::<3>(&space, method, Basis::Corotated);
    }
    for method in [Update::Warped, Update::Newton, Update::Plain] {
        turned::<2>(&plane, method, Basis::Fixed);
        turned::<3>(&space, method, Basis::Fixed);
    }
}
