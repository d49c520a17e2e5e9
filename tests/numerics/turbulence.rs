//! Wavelet turbulence on finer cells, beside its formulas one number at a time.

use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{Components, Memory, boundaries, cubic, flow, largest, largest_of, places, with_threads};
use crate::refined::{files, problem};
use thurible_core::flow::turbulence::{PERIOD, tile, weights};
use thurible_core::flow::warp::carry_coordinate;
use thurible_core::grid::Grid;
use thurible_core::{Refined, Refinement, Serial, Silent, Turbulence};

const SIDE: usize = tile::SIDE;

fn noise(dims: usize, seed: u64, threads: usize) -> Vec<f64> {
    let len = tile::len(dims);
    let mut values = vec![f64::NAN; len];
    let mut work: Vec<Vec<f64>> = (0..tile::FIELDS).map(|_| vec![f64::NAN; len]).collect();
    let mut parts = work.iter_mut();
    let fields = core::array::from_fn(|_| parts.next().unwrap().as_mut_slice());
    with_threads(threads, |exec| tile::fill(exec, dims, seed, &mut values, fields));
    values
}

/// The quadratic B-spline around 0.
fn spline(x: f64) -> f64 {
    let x = x.abs();
    if x < 0.5 {
        0.75 - x * x
    } else if x < 1.5 {
        0.5 * (1.5 - x) * (1.5 - x)
    } else {
        0.0
    }
}

/// The tile at a place: value i stands at i, moved by `shift`, and on a ring begins again after `ring`.
fn value(tile: &[f64], dims: usize, place: [f64; 3], ring: [Option<isize>; 3], shift: usize) -> f64 {
    let mut terms = vec![(0usize, 1.0, 1usize)];
    for axis in 0..dims {
        let near = place[axis].round() as isize;
        terms = terms
            .into_iter()
            .flat_map(|(start, weight, stride)| {
                (near - 2..=near + 2).map(move |i| {
                    let own = ring[axis].map_or(i, |ring| i.rem_euclid(ring));
                    let at = (own + shift as isize).rem_euclid(SIDE as isize) as usize;
                    (
                        start + stride * at,
                        weight * spline(place[axis] - i as f64),
                        stride * SIDE,
                    )
                })
            })
            .collect();
    }
    terms.into_iter().map(|(at, weight, _)| weight * tile[at]).sum()
}

#[test]
fn the_tile_has_no_long_waves_and_a_curl_of_1() {
    for dims in [2, 3] {
        let tile = noise(dims, 7, 1);
        assert_eq!(tile, noise(dims, 7, 3), "on three threads");
        assert_ne!(tile, noise(dims, 8, 1));
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
            (sum / f64::from(count)).sqrt()
        };
        // Means of blocks of eight cells a side, beside what white noise has there.
        let size = mean(&mut tile.iter().copied());
        let blocks = SIDE / 8;
        let block = |b: usize| {
            let corner = [b % blocks, b / blocks % blocks, b / blocks / blocks].map(|i| 8 * i);
            let inside = (0..8usize.pow(dims as u32)).map(|i| {
                let at = [i % 8, i / 8 % 8, i / 64];
                tile[(0..dims)
                    .rev()
                    .fold(0, |place, a| place * SIDE + corner[a] + at[a])]
            });
            inside.sum::<f64>() / 8f64.powi(dims as i32)
        };
        let long = mean(&mut (0..blocks.pow(dims as u32)).map(block));
        let white = size / 8f64.powf(dims as f64 / 2.0);
        assert!(long < 0.25 * white, "{dims}D: {long:e} of {white:e}");
        // The mean square of the curl at many places.
        let mut random = Random::new(3);
        let step = 1e-4;
        let mut square = 0.0;
        const PLACES: usize = 20_000;
        for _ in 0..PLACES {
            let place: [f64; 3] = core::array::from_fn(|_| SIDE as f64 * random.unit());
            for axis in 0..dims {
                let at = |by: f64| {
                    let mut place = place;
                    place[axis] += by;
                    value(&tile, dims, place, [None; 3], 0)
                };
                square += ((at(step) - at(-step)) / (2.0 * step)).powi(2);
            }
        }
        let curl = (square * (dims - 1) as f64 / PLACES as f64).sqrt();
        assert!((curl - 1.0).abs() < 0.02, "{dims}D: {curl}");
    }
}

#[test]
fn what_begins_anew_weighs_nothing_and_both_are_as_strong_as_one() {
    for step in 0..3 * PERIOD {
        let [one, other] = weights(step);
        assert!((one * one + other * other - 1.0).abs() < 1e-15);
        assert_eq!(one == 0.0, step % PERIOD == 0, "step {step}");
        assert_eq!(other == 0.0, step % PERIOD == PERIOD / 2, "step {step}");
        assert_eq!([other, one], weights(step + PERIOD / 2));
    }
}

/// 1/2 |v - U R v|^2 at a cell.
fn energies(grid: &Grid, v: &Components<f64>) -> Vec<f64> {
    let n: Vec<usize> = grid.n[..grid.dims].iter().map(|n| n / 2).collect();
    let coarse = grid.of_cells(core::array::from_fn(|a| n.get(a).copied().unwrap_or(1)));
    let naive = Naive::new(grid);
    let mut energy = vec![0.0; grid.cells()];
    for axis in 0..grid.dims {
        let cells: Vec<f64> = places(grid)
            .map(|at| {
                let after = naive
                    .step(at, axis, 1)
                    .map_or(0.0, |next| v[axis][naive.id(next)]);
                0.5 * (v[axis][naive.id(at)] + after)
            })
            .collect();
        let mut means = vec![0.0; coarse.cells()];
        let share = 0.5f64.powi(grid.dims as i32);
        for (at, value) in places(grid).zip(&cells) {
            let parent = core::array::from_fn(|a| if a < grid.dims { at[a] / 2 } else { 0 });
            means[coarse.index(parent)] += share * value;
        }
        for (at, (energy, value)) in places(grid).zip(energy.iter_mut().zip(&cells)) {
            let back = cubic::at(&coarse, &means, None, at.map(|i| 0.5 * (i as f64 + 0.5)));
            *energy += 0.5 * (value - back).powi(2);
        }
    }
    energy
}

/// c - x after the coordinates rode on `v`, in cells a step, for `steps` steps.
fn drifted(grid: &Grid, v: &Components<f64>, steps: usize) -> Vec<Vec<f64>> {
    let mut work = [(); 3].map(|()| vec![0.0; grid.cells()]);
    let along = |axis: usize| {
        let mut drift = vec![0.0; grid.cells()];
        for _ in 0..steps {
            let [a, b, c] = work.each_mut().map(Vec::as_mut_slice);
            let v = [&*v[0], &*v[1], &*v[2]];
            carry_coordinate(&Serial, grid, (v, 1.0), (axis, &mut drift), [a, b, c]);
        }
        drift
    };
    (0..grid.dims).map(along).collect()
}

/// sqrt(|grad c|^2 - (d - 1)) at a cell.
fn stretch(grid: &Grid, drift: &[Vec<f64>], at: [usize; 3]) -> f64 {
    let naive = Naive::new(grid);
    let mut square = 1.0 - grid.dims as f64;
    for (axis, drift) in drift.iter().enumerate() {
        for along in 0..grid.dims {
            let [low, high] = [-1, 1].map(|by| naive.walk(at, along, by));
            let ends = [-1, 1].map(|by| naive.step(at, along, by).is_some());
            let apart = ends.into_iter().filter(|&there| there).count() as f64;
            let slope = (drift[naive.id(high)] - drift[naive.id(low)]) / apart;
            square += (slope + f64::from(u8::from(axis == along))).powi(2);
        }
    }
    square.max(1.0).sqrt()
}

/// What turbulence adds after `taken` steps by the same flow `v` of a step, before the projection.
fn added(
    from: &Grid,
    to: &Grid,
    v: &Components<f64>,
    (octaves, taken): (usize, usize),
    given: Turbulence,
) -> Components<f64> {
    let dims = from.dims;
    let in_cells = from.of_cells(from.n);
    let (energy, tile) = (energies(&in_cells, v), noise(dims, given.seed, 1));
    let by = to.n[0] / from.n[0];
    let h = 1.0 / by as f64;
    let of_cells: Components<f64> = v.each_ref().map(|c| c.iter().map(|x| x / from.h[0]).collect());
    let drift = drifted(&in_cells, &of_cells, taken);
    let stretched: Vec<f64> = places(from).map(|at| stretch(&in_cells, &drift, at)).collect();
    let potential = |component: usize, at: [usize; 3]| {
        let place: [f64; 3] = core::array::from_fn(|a| {
            let half = if dims == 3 && a == component { 0.5 } else { 0.0 };
            (at[a] as f64 + half) * h
        });
        let s = cubic::at(&in_cells, &stretched, None, place).max(1.0);
        let c: [f64; 3] = core::array::from_fn(|a| {
            let moved = drift
                .get(a)
                .map_or(0.0, |drift| cubic::at(&in_cells, drift, None, place));
            place[a] + moved
        });
        let mut sum = 0.0;
        for (set, weight) in weights(taken).into_iter().enumerate() {
            for b in 0..octaves {
                let scale = 2f64.powi(b as i32);
                let ring = core::array::from_fn(|a| {
                    (a < dims && from.axis(a).is_ring()).then(|| (from.n[a] as f64 * scale) as isize)
                });
                let shift = 32 * set + 21 * component + 11 * b;
                let kept = (2.0 - 2.0 * scale * s * h).clamp(0.0, 1.0) / s;
                let noise = value(&tile, dims, c.map(|x| x * scale), ring, shift);
                sum += weight * kept * 2f64.powf(-5.0 * b as f64 / 6.0) / scale * noise;
            }
        }
        sum
    };
    let slope = |component: usize, along: usize, at: [usize; 3]| {
        let mut next = at;
        next[along] += 1;
        (potential(component, next) - potential(component, at)) / h
    };
    let naive = Naive::new(to);
    let strength = |at: [usize; 3]| {
        let place = core::array::from_fn(|a| (at[a] as f64 + 0.5) * h);
        (2.0 * cubic::at(&in_cells, &energy, None, place)).max(0.0).sqrt()
    };
    naive.at_faces(|axis, at| {
        let Some(low) = naive.step(at, axis, -1) else {
            return 0.0;
        };
        let curl = match (dims, axis) {
            (2, 0) => slope(0, 1, at),
            (2, _) => -slope(0, 0, at),
            _ => {
                let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                slope(c, b, at) - slope(b, c, at)
            }
        };
        given.strength * 2f64.powf(-5.0 / 6.0) * 0.5 * (strength(low) + strength(at)) * curl
    })
}

/// The last of `steps` turbulent steps by a rough flow on cells halved so often.
fn stepped(
    (cells, ends): (&[usize], &str),
    (doublings, steps): (usize, usize),
    turbulence: Option<Turbulence>,
    threads: usize,
) -> (Grid, Components<f64>, Grid, Components<f64>) {
    let ends = &boundaries(ends);
    let from = Grid::new(cells, ends);
    let fine: Vec<usize> = cells.iter().map(|n| n << doublings).collect();
    let to = Grid::new(&fine, ends);
    let mut problem = problem(&fine, ends, &[]);
    problem.projection_tolerance = 1e-12;
    let how = Refinement {
        doublings,
        turbulence,
        weighted: None,
        threads,
    };
    let mut memory = Memory::new(Refined::<f64>::bytes(&problem, how).unwrap());
    let mut refined = Refined::<f64>::carve(&problem, how, memory.block()).unwrap();
    refined
        .set_density_of_result(&Serial, &vec![1.0; from.cells()])
        .unwrap();
    let v: Components<f64> = flow::rough(&mut Random::new(74), &from, 1, 0.7);
    let unit = problem.length / problem.dt;
    for _ in 0..steps {
        for (axis, faces) in files(&from, &v).into_iter().enumerate() {
            let faces: Vec<f64> = faces.into_iter().map(|face| face * unit).collect();
            refined.set_velocity(axis, &faces).unwrap();
        }
        with_threads(threads, |exec| refined.advance(exec, &mut Silent)).unwrap();
    }
    let component = |axis: usize| {
        let mut out = vec![f64::NAN; refined.faces(axis)];
        refined.velocity(axis, &mut out).unwrap();
        out.iter().map(|x| x / unit).collect()
    };
    let all: Vec<Vec<f64>> = (0..to.dims).map(component).collect();
    let out = crate::fields::feasible::faces(&to, &all);
    let [before, after] = refined.effort().energy;
    assert_eq!(turbulence.is_some(), after > 0.0);
    assert!(turbulence.is_none_or(|given| given.strength == 0.0 || after > before));
    (from, v, to, out)
}

#[test]
fn a_step_is_what_the_formula_says() {
    let given = Turbulence {
        strength: 0.8,
        seed: 5,
    };
    for (case, doublings, steps) in [
        ((&[12, 8][..], "ww"), 1, 1),
        ((&[8, 10], "wp"), 2, 3),
        ((&[6, 8], "pp"), 3, 2),
        ((&[6, 4, 8], "wpw"), 2, 3),
    ] {
        let last = |given, threads| stepped(case, (doublings, steps), given, threads);
        let (from, v, to, with) = last(Some(given), 1);
        let (.., without) = last(None, 1);
        let expected = added(&from, &to, &v, (doublings, steps - 1), given);
        let naive = Naive::new(&to);
        let divergence = largest(naive.divergence(&with)) * to.h[0] / largest_of(&with);
        assert!(divergence < 1e-10, "{case:?}: divergence {divergence:e}");
        // Only a gradient is left out: the curls are those of what was added.
        let rest: Components<f64> = core::array::from_fn(|a| {
            let parts = with[a].iter().zip(&without[a]).zip(&expected[a]);
            parts
                .map(|((with, without), added)| with - without - added)
                .collect()
        });
        let [left, size] = [&rest, &expected].map(|field| naive.largest_curl(field));
        assert!(left < 1e-9 * size, "{case:?}: {left:e} of {size:e}");
        assert!(largest_of(&expected) > 0.02 * largest_of(&v), "{case:?}");
        assert_eq!(with, last(Some(given), 3).3, "on three threads");
        assert_ne!(with, last(Some(Turbulence { seed: 6, ..given }), 1).3);
        let none = Turbulence {
            strength: 0.0,
            ..given
        };
        assert_eq!(last(Some(none), 1).3, without);
    }
}

#[test]
fn coordinates_ride_on_the_flow() {
    // Along a ring every step takes the coordinates back by the flow.
    let ring = Grid::in_cells(&[10, 12], &boundaries("pp"));
    let uniform = [vec![0.7; 120], vec![-0.3; 120], Vec::new()];
    let mut drift = vec![0.0; 120];
    let mut work = [(); 3].map(|()| vec![0.0; 120]);
    let mut carry = |grid: &Grid, v: &Components<f64>, s: f64, axis: usize, drift: &mut [f64]| {
        let [a, b, c] = work.each_mut().map(Vec::as_mut_slice);
        let v = [&*v[0], &*v[1], &*v[2]];
        carry_coordinate(&Serial, grid, (v, s), (axis, drift), [a, b, c]);
    };
    for step in 1..=5 {
        carry(&ring, &uniform, 2.0, 0, &mut drift);
        let expected = -1.4 * f64::from(step);
        assert!(largest(drift.iter().map(|x| x - expected)) < 1e-12);
    }
    // In a box they come from where a particle was.
    let grid = Grid::in_cells(&[40, 32], &boundaries("ww"));
    let v: Components<f64> = flow::swirl(&grid, 1, 1.0);
    let speed = 0.3 / largest_of(&v);
    let drift: Vec<Vec<f64>> = {
        let slow: Components<f64> = v.each_ref().map(|c| c.iter().map(|x| x * speed).collect());
        drifted(&grid, &slow, 10)
    };
    let at = |place: [f64; 3], axis: usize| {
        speed * thurible_core::flow::sample::linear(&grid, &v[axis], axis, place)
    };
    let (mut apart, mut size) = (0.0, 0.0);
    for (index, cell) in places(&grid).enumerate() {
        let begin = cell.map(|i| i as f64 + 0.5);
        let mut place = begin;
        for _ in 0..1000 {
            let middle = [
                place[0] - 0.005 * at(place, 0),
                place[1] - 0.005 * at(place, 1),
                0.5,
            ];
            place = [
                place[0] - 0.01 * at(middle, 0),
                place[1] - 0.01 * at(middle, 1),
                0.5,
            ];
        }
        for (axis, drift) in drift.iter().enumerate() {
            apart += (drift[index] - (place[axis] - begin[axis])).powi(2);
            size += (place[axis] - begin[axis]).powi(2);
        }
    }
    let relative = f64::sqrt(apart / size);
    assert!(relative < 0.05, "{relative} of the way");
}

#[test]
fn turbulence_takes_what_is_planned() {
    let ends = &boundaries("wp");
    let bytes = |steps, turbulence| {
        let problem = thurible_core::Problem {
            steps,
            ..problem(&[32, 48], ends, &[])
        };
        let how = Refinement {
            doublings: 2,
            turbulence,
            weighted: None,
            threads: 2,
        };
        let bytes = Refined::<f32>::bytes(&problem, how).unwrap();
        let mut memory = Memory::new(bytes);
        assert!(Refined::<f32>::carve(&problem, how, &mut memory.block()[..bytes - 64]).is_err());
        assert!(Refined::<f32>::carve(&problem, how, memory.block()).is_ok());
        bytes
    };
    let given = Some(Turbulence {
        strength: 1.0,
        seed: 1,
    });
    assert_eq!(bytes(2, given), bytes(1000, given));
    assert!(bytes(2, given) > bytes(2, None));
}
