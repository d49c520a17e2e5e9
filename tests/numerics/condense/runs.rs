//! Whole runs: energies that never rise, the same bits by any number of threads, memory, and the counts of the design's tables.

use super::bench::{Bench, close};
use crate::allocations;
use crate::fields::{Memory, with_threads};
use thurible_core::condense::{
    Basis, Block, CondenseParams, CondensePlan, Condenser, Order, Spring, Step, Topology, Update,
};
use thurible_core::{Entry, Named, Real, Serial, Silent, Status};

const ALL: [Update; 8] = [
    Update::Newton,
    Update::Plain,
    Update::Jgs2,
    Update::Jgs2Local,
    Update::Cc,
    Update::Projected,
    Update::Chord,
    Update::Warped,
];

fn params(method: Update, basis: Basis) -> CondenseParams {
    CondenseParams {
        method,
        basis,
        cap: 300,
        ..CondenseParams::default()
    }
}

fn total(found: &(Vec<usize>, Vec<usize>, f64)) -> (usize, usize) {
    (found.0.iter().sum(), found.1.iter().sum())
}

#[test]
fn the_energy_never_rises_beyond_its_slack() {
    let bench = Bench::stretch(2, 5);
    let pull = bench.pull(0.15);
    for method in ALL {
        for order in [Order::Jacobi, Order::Colours] {
            let params = CondenseParams {
                order,
                cap: 60,
                ..params(method, Basis::Fixed)
            };
            if params.check(2).is_err() {
                continue;
            }
            bench.run::<f64, 2, _>(params, |run| {
                let (mut last, mut seen) = (f64::INFINITY, 0);
                let step = Step {
                    shift: &pull,
                    ..Step::default()
                };
                run.step(&Serial, &step, &mut Silent, &mut |at| {
                    assert!(
                        at.energy <= last + 4.0 * 8.0 * f64::EPSILON * last.abs(),
                        "{}",
                        method.name()
                    );
                    (last, seen) = (at.energy, seen + 1);
                })
                .unwrap();
                assert!(seen > 3);
            });
        }
    }
}

/// All displacements after two steps.
fn state<T: Real, const D: usize>(bench: &Bench, threads: usize, params: CondenseParams) -> Vec<[f64; 3]> {
    let pull = bench.pull(0.1);
    with_threads(threads, |exec| {
        bench.run::<T, D, _>(CondenseParams { threads, ..params }, |run| {
            for _ in 0..2 {
                let step = Step {
                    shift: &pull,
                    gravity: [0.0, -3.0, 0.0],
                };
                run.step(exec, &step, &mut Silent, &mut |_| {}).unwrap();
            }
            (0..bench.vertices())
                .map(|vertex| run.displacement(vertex))
                .collect()
        })
    })
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (plane, space) = (Bench::stretch(2, 6), Bench::stretch(3, 3));
    for method in ALL {
        let basis = if method.keeps_basis() {
            Basis::CorotatedRebuilt
        } else {
            Basis::Fixed
        };
        let params = CondenseParams {
            cap: 12,
            rebuild: 1,
            ..params(method, basis)
        };
        for params in [
            params,
            CondenseParams {
                radius: method.keeps_basis().then_some(2),
                ..params
            },
        ] {
            assert_eq!(
                state::<f64, 2>(&plane, 1, params),
                state::<f64, 2>(&plane, 3, params),
                "{}",
                method.name()
            );
            assert_eq!(
                state::<f32, 3>(&space, 1, params),
                state::<f32, 3>(&space, 4, params),
                "{}",
                method.name()
            );
        }
    }
}

fn bytes_of(entries: &[Entry], name: &str) -> usize {
    entries
        .iter()
        .find(|entry| entry.name == name)
        .map_or(0, |entry| entry.bytes)
}

/// The table of the design, each array rounded up to 64 bytes.
#[test]
fn the_ledger_is_the_table_of_the_design() {
    let bench = Bench::stretch(2, 16);
    let mesh = bench.mesh();
    for (radius, threads) in [(None, 1), (None, 3), (Some(2), 2)] {
        let mut words = vec![0; Topology::words(&mesh)];
        let topology = Topology::new(&mesh, radius, &mut words).unwrap();
        let params = CondenseParams {
            radius,
            threads,
            ..CondenseParams::default()
        };
        let plan = CondensePlan::new::<f64>(&mesh, &topology, &params).unwrap();
        let unknowns = 2 * topology.free();
        assert_eq!(unknowns, 510);
        let joined = |one: usize, other: usize| {
            let held = bench.held[one] || bench.held[other];
            let element =
                |corners: &[u32]| corners.contains(&(one as u32)) && corners.contains(&(other as u32));
            !held && bench.elements.chunks_exact(3).any(element)
        };
        let n = bench.vertices();
        let near: Vec<Vec<usize>> = (0..n)
            .map(|one| (0..n).filter(|&other| joined(one, other)).collect())
            .collect();
        let within = |vertex: usize, radius: usize| -> usize {
            let mut reached = vec![vertex];
            for _ in 0..radius {
                let mut next: Vec<usize> = reached.iter().flat_map(|&vertex| near[vertex].clone()).collect();
                next.sort_unstable();
                next.dedup();
                reached = next;
            }
            reached.len()
        };
        let free: Vec<usize> = (0..n).filter(|&vertex| !bench.held[vertex]).collect();
        let patches: Vec<usize> = free
            .iter()
            .map(|&vertex| radius.map_or(free.len(), |radius| within(vertex, radius)))
            .collect();
        let rounded = |numbers: usize| (8 * numbers).next_multiple_of(64);
        let entries = plan.entries();
        for name in ["displacement", "gradient", "direction", "trial"] {
            assert_eq!(bytes_of(entries, name), rounded(unknowns));
        }
        let blocks: usize = free.iter().map(|&vertex| near[vertex].len()).sum();
        assert_eq!(bytes_of(entries, "Hessian"), rounded(4 * blocks));
        assert_eq!(
            bytes_of(entries, "basis"),
            rounded(4 * patches.iter().sum::<usize>())
        );
        assert_eq!(
            bytes_of(entries, "factor"),
            rounded(unknowns * (topology.band(2) + 1))
        );
        assert!(topology.band(2) < 64, "{}", topology.band(2));
        let largest = patches.iter().max().unwrap();
        assert_eq!(
            bytes_of(entries, "blocks of threads"),
            rounded(threads * 2 * largest * 4)
        );
    }
}

#[test]
fn every_plan_is_used_and_nothing_is_allocated() {
    let bench = Bench::stretch(2, 4);
    let mesh = bench.mesh();
    let pull = bench.pull(0.1);
    for method in ALL {
        for (radius, dt) in [(None, None), (Some(2), Some(0.05))] {
            let radius = radius.filter(|_| method.keeps_basis());
            let params = CondenseParams {
                radius,
                dt,
                cap: 5,
                ..params(method, Basis::Fixed)
            };
            let mut words = vec![0; Topology::words(&mesh)];
            let topology = Topology::new(&mesh, radius, &mut words).unwrap();
            let plan = CondensePlan::new::<f32>(&mesh, &topology, &params).unwrap();
            let top: usize = plan
                .entries()
                .iter()
                .filter(|entry| entry.depth == 1)
                .map(|entry| entry.bytes)
                .sum();
            assert_eq!(top, plan.bytes());
            let mut memory = Memory::new(plan.bytes());
            let block = memory.block();
            let before = allocations::count();
            let mut run = Condenser::<f32, 2>::new(mesh, topology, params, block).unwrap();
            let step = Step {
                shift: &pull,
                ..Step::default()
            };
            run.step(&Serial, &step, &mut Silent, &mut |_| {}).unwrap();
            assert_eq!(allocations::count(), before, "{}", method.name());
        }
    }
}

#[test]
fn a_stretched_square_of_16_takes_the_counts_of_the_design() {
    let bench = Bench::stretch(2, 16);
    let pull = bench.pull(0.1);
    let step = Step {
        shift: &pull,
        ..Step::default()
    };
    let rows = [
        (Update::Newton, Basis::Fixed, [4, 4]),
        (Update::Cc, Basis::Fixed, [10, 8]),
        (Update::Cc, Basis::Corotated, [8, 8]),
        (Update::Projected, Basis::Fixed, [7, 8]),
        (Update::Chord, Basis::Fixed, [7, 9]),
    ];
    for (method, basis, expected) in rows {
        let found = bench.steps::<f64, 2>(params(method, basis), &[step; 2]).0;
        let same = found
            .iter()
            .zip(expected)
            .all(|(&found, expected)| close(found, expected));
        assert!(
            same,
            "{} {}: {found:?}, not {expected:?}",
            method.name(),
            basis.name()
        );
    }
}

/// 20 equal steps to the whole acceleration.
fn cantilever(gravity: f64, params: CondenseParams) -> (usize, usize, usize) {
    let bench = Bench::new(&[16, 3], &[1.0, 0.2], |place| place[0] == 0.0);
    let steps: Vec<Step<'_>> = (1..=20)
        .map(|step| Step {
            shift: &[],
            gravity: [0.0, -gravity * f64::from(step) / 20.0, 0.0],
        })
        .collect();
    let found = bench.steps::<f64, 2>(
        CondenseParams {
            tolerance: 1e-7,
            ..params
        },
        &steps,
    );
    let (iterations, builds) = total(&found);
    (iterations, builds, found.0.len())
}

#[test]
fn a_cantilever_takes_the_counts_of_the_design() {
    let rows = [
        (0.2, Update::Newton, Basis::Fixed, 40, 0),
        (0.2, Update::Cc, Basis::Corotated, 66, 1),
        (0.2, Update::Cc, Basis::CorotatedRebuilt, 45, 4),
        (0.2, Update::Cc, Basis::CorotatedAdaptive, 63, 2),
        (0.2, Update::Projected, Basis::Corotated, 58, 1),
        (0.2, Update::Warped, Basis::Fixed, 40, 1),
        (1.0, Update::Newton, Basis::Fixed, 62, 0),
        (1.0, Update::Cc, Basis::CorotatedRebuilt, 107, 4),
        (1.0, Update::Warped, Basis::Rebuilt, 65, 4),
    ];
    for (gravity, method, basis, expected, builds) in rows {
        let (found, built, steps) = cantilever(gravity, params(method, basis));
        let name = format!(
            "{} {} at {gravity}: {found} ({built}) in {steps}",
            method.name(),
            basis.name()
        );
        assert_eq!((steps, built), (20, builds), "{name}");
        assert!(
            (found as f64 - f64::from(expected)).abs() <= 1.0 + 0.1 * f64::from(expected),
            "{name}, not {expected}"
        );
    }
    let (_, _, steps) = cantilever(1.0, params(Update::Cc, Basis::Fixed));
    assert!(steps < 8, "a fixed basis goes to step {steps}");
}

#[test]
fn rounding_of_32_bits_does_not_stall() {
    let bench = Bench::stretch(2, 8);
    let pull = bench.pull(0.1);
    let step = Step {
        shift: &pull,
        ..Step::default()
    };
    let params = CondenseParams {
        tolerance: 1e-7,
        ..params(Update::Cc, Basis::Fixed)
    };
    let (wide, narrow) = (
        bench.steps::<f64, 2>(params, &[step; 3]),
        bench.steps::<f32, 2>(params, &[step; 3]),
    );
    assert_eq!(narrow.0.len(), 3, "{narrow:?}");
    assert!(
        narrow
            .0
            .iter()
            .zip(&wide.0)
            .all(|(&narrow, &wide)| close(narrow, wide)),
        "{narrow:?}, {wide:?}"
    );
}

#[test]
fn a_spring_that_the_basis_does_not_know_makes_it_slow() {
    let counts = [true, false].map(|in_basis| {
        let mut bench = Bench::new(&[16, 3], &[1.0, 0.2], |place| place[0] == 0.0);
        let corner = bench.vertices() as u32 - 1;
        bench.rest.extend([1.0, 0.5]);
        bench.held.push(true);
        bench.regular = [0; 3];
        bench.springs = vec![Spring {
            ends: [corner, corner + 1],
            stiffness: 2e2,
            rest_length: 0.28,
            in_basis,
        }];
        let params = CondenseParams {
            tolerance: 1e-8,
            ..params(Update::Cc, Basis::Fixed)
        };
        bench.steps::<f64, 2>(params, &[Step::default()]).0[0]
    });
    assert!(close(counts[0], 15) && close(counts[1], 144), "{counts:?}");
}

#[test]
fn boxes_converge_to_what_newton_finds() {
    let bench = Bench::stretch(3, 4);
    let pull = bench.pull(0.1);
    let step = Step {
        shift: &pull,
        gravity: [0.0, 0.0, -2.0],
    };
    let newton = bench.steps::<f64, 3>(params(Update::Newton, Basis::Fixed), &[step; 2]);
    assert_eq!(newton.0.len(), 2);
    for (method, basis) in [
        (Update::Cc, Basis::Corotated),
        (Update::Projected, Basis::Fixed),
        (Update::Warped, Basis::Fixed),
    ] {
        let found = bench.steps::<f64, 3>(params(method, basis), &[step; 2]);
        let name = method.name();
        assert!(
            found.0.len() == 2 && found.0.iter().all(|&count| count < 30),
            "{name}: {:?}",
            found.0
        );
        assert!((found.2 - newton.2).abs() < 1e-6 * newton.2.abs(), "{name}");
    }
}

/// Components one by one are blocks too, where nothing turns.
#[test]
fn scalar_blocks_converge_and_a_swept_plain_is_faster() {
    let bench = Bench::stretch(2, 4);
    let pull = bench.pull(0.1);
    let step = Step {
        shift: &pull,
        ..Step::default()
    };
    let scalar = CondenseParams {
        block: Block::Scalar,
        ..params(Update::Cc, Basis::Fixed)
    };
    let (vertex, scalar) = (
        bench.steps::<f64, 2>(params(Update::Cc, Basis::Fixed), &[step; 2]),
        bench.steps::<f64, 2>(scalar, &[step; 2]),
    );
    assert!(
        scalar.0.len() == 2 && (scalar.2 - vertex.2).abs() < 1e-6 * vertex.2,
        "{scalar:?}"
    );
    let swept = CondenseParams {
        order: Order::Colours,
        ..params(Update::Plain, Basis::Fixed)
    };
    let found = bench.steps::<f64, 2>(swept, &[step; 3]).0;
    assert!(found.iter().all(|&count| close(count, 23)), "{found:?}");
    let mut greedy = bench.clone();
    greedy.regular = [0; 3];
    let found = greedy.steps::<f64, 2>(swept, &[step; 3]).0;
    assert!(found.iter().all(|&count| count < 40), "{found:?}");
}

#[test]
fn noise_makes_a_basis_worse_and_has_its_seed() {
    let bench = Bench::stretch(2, 8);
    let pull = bench.pull(0.1);
    let step = Step {
        shift: &pull,
        ..Step::default()
    };
    let run = |noise: f64, seed: u64| {
        let params = CondenseParams {
            noise,
            seed,
            ..params(Update::Cc, Basis::Fixed)
        };
        bench.steps::<f64, 2>(params, &[step])
    };
    let counts: Vec<usize> = [0.0, 1e-3, 1e-2, 1e-1]
        .iter()
        .map(|&sigma| run(sigma, 1).0[0])
        .collect();
    assert!(
        close(counts[0], 6) && close(counts[1], 6) && counts[2] < counts[3] && counts[3] < 150,
        "{counts:?}"
    );
    assert_eq!(run(0.1, 1), run(0.1, 1));
    assert_ne!(run(0.1, 1).2, run(0.1, 2).2);
}

#[test]
fn a_boundary_that_goes_through_the_mesh_is_not_finite() {
    let bench = Bench::stretch(2, 4);
    let push = bench.pull(-0.9);
    bench.run::<f64, 2, _>(params(Update::Newton, Basis::Fixed), |run| {
        let step = Step {
            shift: &push,
            ..Step::default()
        };
        let stepped = run.step(&Serial, &step, &mut Silent, &mut |_| {}).unwrap();
        assert_eq!((stepped.status, stepped.iterations), (Status::NotFinite, 0));
    });
}
