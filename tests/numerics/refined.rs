//! A result on finer cells: its flow keeps its divergence, and its density goes with it in the memory of one step.

use crate::fields::carry::Carry;
use crate::fields::feasible::faces;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{
    Components, Memory, boundaries, cubic, flow, grid, largest, largest_of, places, view, view_mut,
    with_threads, zeros,
};
use thurible_core::grid::Grid;
use thurible_core::operators::refine;
use thurible_core::{
    Boundary, Emitter, InputError, PlanError, Problem, Refined, Refinement, Scheme, Serial, Silent, Supply,
    Yielding,
};

const GRIDS: [(&[usize], &str); 7] = [
    (&[12, 8], "ww"),
    (&[9, 14], "wp"),
    (&[5, 4], "pp"),
    (&[4, 4, 10], "wpw"),
    (&[6, 5, 7], "www"),
    (&[9, 8, 5], "pwp"),
    (&[4, 7, 5], "ppp"),
];

/// So many doublings, for so many threads.
fn finer(doublings: usize, threads: usize) -> Refinement {
    Refinement {
        doublings,
        threads,
        ..Refinement::default()
    }
}

fn doubled(from: &Grid, to: &Grid, v: &Components<f64>, threads: usize) -> Components<f64> {
    let mut fine = zeros(to, 1);
    let mut scratch = vec![f64::NAN; threads * refine::scratch_per_thread(from)];
    with_threads(threads, |exec| {
        refine::double(exec, (from, to), view(v), view_mut(&mut fine), &mut scratch)
    });
    fine
}

/// The flow at (2 x, 2 y, 2 z) and beyond, one number at a time: cubics along the axis of a component, parabolas across it.
fn plainly(naive: &Naive, from: &Grid, v: &Components<f64>, axis: usize, at: [usize; 3]) -> f64 {
    fn value(naive: &Naive, v: &Components<f64>, grid: &Grid, axis: usize, mut at: [isize; 3]) -> f64 {
        let mut sign = 1.0;
        for a in 0..grid.dims {
            let n = grid.n[a] as isize;
            if grid.axis(a).is_ring() {
                at[a] = at[a].rem_euclid(n);
            } else if a == axis {
                if at[a] < 0 {
                    (at[a], sign) = (-at[a], -sign);
                } else if at[a] > n {
                    (at[a], sign) = (2 * n - at[a], -sign);
                }
                if at[a] == 0 || at[a] == n {
                    return 0.0;
                }
            } else {
                at[a] = if at[a] < 0 {
                    -1 - at[a]
                } else if at[a] >= n {
                    2 * n - 1 - at[a]
                } else {
                    at[a]
                };
            }
        }
        sign * v[axis][naive.id(at.map(|i| i as usize))]
    }
    let mut places = vec![([0isize; 3], 1.0)];
    for a in 0..from.dims {
        let (parent, odd) = ((at[a] / 2) as isize, at[a] % 2 == 1);
        let rule: &[(isize, f64)] = match (a == axis, odd) {
            (true, false) => &[(0, 1.0)],
            (true, true) => &[(-1, -0.0625), (0, 0.5625), (1, 0.5625), (2, -0.0625)],
            (false, false) => &[(-1, 0.125), (0, 1.0), (1, -0.125)],
            (false, true) => &[(-1, -0.125), (0, 1.0), (1, 0.125)],
        };
        places = places
            .into_iter()
            .flat_map(|(place, weight)| {
                rule.iter().map(move |&(offset, share)| {
                    let mut place = place;
                    place[a] = parent + offset;
                    (place, weight * share)
                })
            })
            .collect();
    }
    places
        .into_iter()
        .map(|(place, weight)| weight * value(naive, v, from, axis, place))
        .sum()
}

#[test]
fn a_flow_without_divergence_stays_so_and_is_what_the_formula_says() {
    let mut random = Random::new(71);
    for (cells, ends) in GRIDS {
        let from = grid(cells, ends);
        let to = grid(&cells.iter().map(|n| 2 * n).collect::<Vec<_>>(), ends);
        let v: Components<f64> = flow::rough(&mut random, &from, 1, 1.0);
        let fine = doubled(&from, &to, &v, 1);
        assert_eq!(
            fine,
            doubled(&from, &to, &v, 3),
            "{cells:?} {ends}: on three threads"
        );
        let divergence = largest(Naive::new(&to).divergence(&fine)) * to.h[0] / largest_of(&fine);
        assert!(divergence < 1e-13, "{cells:?} {ends}: {divergence:e}");
        let naive = Naive::new(&from);
        for (index, at) in places(&to).enumerate() {
            for axis in 0..to.dims {
                let expected = plainly(&naive, &from, &v, axis, at);
                assert!(
                    (fine[axis][index] - expected).abs() < 1e-14,
                    "{cells:?} {ends}: {axis} {at:?}"
                );
            }
        }
    }
}

/// Open sides are passed by a flow without divergence, which has none on the finer grid either, and carries out there what it does here.
#[test]
fn a_flow_out_of_the_box_stays_without_divergence() {
    let mut random = Random::new(76);
    for (cells, ends) in [
        (&[9, 8][..], "oh"),
        (&[8, 7], "lw"),
        (&[7, 10], "po"),
        (&[6, 5, 4], "lpo"),
        (&[4, 6, 5], "hww"),
    ] {
        let from = grid(cells, ends);
        let to = grid(&cells.iter().map(|n| 2 * n).collect::<Vec<_>>(), ends);
        let v: Components<f64> = crate::effects::among(&from, &[], random.faces(&from, 1));
        let fine = doubled(&from, &to, &v, 1);
        assert_eq!(
            fine,
            doubled(&from, &to, &v, 3),
            "{cells:?} {ends}: on three threads"
        );
        let outward = |grid: &Grid, v: &Components<f64>| -> [f64; 2] {
            let (mut inside, mut out) = (0.0_f64, 0.0_f64);
            for (at, div) in places(grid).zip(Naive::new(grid).divergence(v)) {
                if grid.is_outside(at) {
                    out += (div * grid.h[0]).powi(2);
                } else {
                    inside = inside.max((div * grid.h[0]).abs());
                }
            }
            [inside, out]
        };
        let ([coarse, through], [left, fine_through]) = (outward(&from, &v), outward(&to, &fine));
        assert!(
            coarse < 1e-11 && left < 1e-11,
            "{cells:?} {ends}: {coarse:e}, {left:e}"
        );
        assert!(
            through > 0.1 && fine_through > through,
            "{cells:?} {ends}: {through}, {fine_through}"
        );
        for (at, axis) in places(&to).flat_map(|at| (0..to.dims).map(move |axis| (at, axis))) {
            // Only the faces between the box and what is outside are left to those cells.
            let inside = to.inside();
            let beyond = (0..to.dims).any(|a| {
                if a == axis {
                    at[a] < inside[a].start || at[a] > inside[a].end
                } else {
                    !inside[a].contains(&at[a])
                }
            });
            assert!(
                !beyond || fine[axis][to.index(at)] == 0.0,
                "{cells:?} {ends}: {axis} {at:?}"
            );
        }
    }
}

/// Smoke leaves by the finer grid's open sides, more cells than a projection knows along an axis with one too.
#[test]
fn smoke_leaves_on_the_finer_grid() {
    for (cells, ends) in [(&[8, 6][..], "wh"), (&[136, 8], "ow"), (&[4, 5, 6], "pwo")] {
        let ends = &boundaries(ends);
        let from = Grid::new(cells, ends);
        let fine: Vec<usize> = cells.iter().map(|n| 2 * n).collect();
        let problem = problem(&fine, ends, &[]);
        let bytes = Refined::<f64>::bytes(&problem, finer(1, 2)).unwrap();
        let mut memory = Memory::new(bytes);
        let mut refined = Refined::<f64>::carve(&problem, finer(1, 2), memory.block()).unwrap();
        let count: usize = fine.iter().product();
        assert_eq!(refined.cells(), count);
        refined.set_density(&vec![1.0; count]).unwrap();
        let v: Components<f64> = crate::effects::among(&from, &[], Random::new(77).faces(&from, 1));
        let v: Components<f64> = v.map(|c| c.iter().map(|x| 0.3 * from.h[0] * x).collect());
        let unit = problem.length / problem.dt;
        for axis in 0..from.dims {
            let walls = usize::from(!from.axis(axis).is_ring());
            let inside = from.inside();
            let mut n: [usize; 3] = core::array::from_fn(|a| inside[a].len());
            n[axis] += walls;
            let face = |i: usize| {
                let at = [i % n[0], i / n[0] % n[1], i / n[0] / n[1]];
                let at: [usize; 3] = core::array::from_fn(|a| inside[a].start + at[a]);
                if at[axis] < from.n[axis] {
                    unit * v[axis][from.index(at)]
                } else {
                    0.0
                }
            };
            let faces: Vec<f64> = (0..n[0] * n[1] * n[2]).map(face).collect();
            refined.set_velocity(axis, &faces).unwrap();
        }
        refined.advance(&Serial, &mut Silent).unwrap();
        let mut rho = vec![f64::NAN; count];
        refined.read_density(&mut rho);
        let mass: f64 = rho.iter().sum();
        assert!(
            mass < count as f64 - 0.01 && mass > 0.5 * count as f64,
            "{cells:?}: {mass} of {count}"
        );
        assert!(rho.iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x)));
        let mut means = vec![f64::NAN; cells.iter().product()];
        refined.means(&Serial, &mut means);
        let parts: f64 = means.iter().sum();
        assert!((mass - (1 << from.dims) as f64 * parts).abs() < 1e-9 * mass);
    }
}

/// What transport leaves out is measured by the smoke that there is, whether it was there at first or came later.
#[test]
fn smoke_that_is_added_is_carried_as_smoke_that_was_there() {
    let (cells, ends) = (&[16, 12][..], &boundaries("ww"));
    let grid = Grid::new(cells, ends);
    let v: Components<f64> = flow::rough(&mut Random::new(78), &grid, 1, 0.3 * grid.h[0]);
    let problem = problem(cells, ends, &[]);
    let unit = problem.length / problem.dt;
    let smoke: Vec<f64> = (0..grid.cells())
        .map(|cell| f64::from(u8::from(cell % 16 < 4)))
        .collect();
    let carried = |at_first: bool| {
        let mut memory = Memory::new(Refined::<f64>::bytes(&problem, finer(0, 1)).unwrap());
        let mut refined = Refined::<f64>::carve(&problem, finer(0, 1), memory.block()).unwrap();
        if at_first {
            refined.set_density(&smoke).unwrap();
        } else {
            refined.set_density(&vec![0.0; smoke.len()]).unwrap();
            refined.add(&smoke).unwrap();
        }
        for (axis, faces) in files(&grid, &v).into_iter().enumerate() {
            let faces: Vec<f64> = faces.iter().map(|x| unit * x).collect();
            refined.set_velocity(axis, &faces).unwrap();
        }
        refined.advance(&Serial, &mut Silent).unwrap();
        let mut rho = vec![f64::NAN; smoke.len()];
        refined.read_density(&mut rho);
        rho
    };
    assert_eq!(carried(true), carried(false));
}

#[test]
fn the_children_of_a_face_carry_what_it_carries() {
    let from = grid(&[6, 5, 4], "wpw");
    let to = grid(&[12, 10, 8], "wpw");
    let v: Components<f64> = flow::rough(&mut Random::new(72), &from, 1, 1.0);
    let fine = doubled(&from, &to, &v, 1);
    let (coarse, children) = (Naive::new(&from), Naive::new(&to));
    for at in places(&from) {
        for axis in 0..3 {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let sum: f64 = (0..4)
                .map(|child| {
                    let mut place = at.map(|i| 2 * i);
                    (place[b], place[c]) = (place[b] + child % 2, place[c] + child / 2);
                    fine[axis][children.id(place)]
                })
                .sum();
            assert!(
                (sum / 4.0 - v[axis][coarse.id(at)]).abs() < 1e-14,
                "{axis} {at:?}"
            );
        }
    }
}

/// A smooth flow through a box, at faces in the layout of a file.
pub fn files(grid: &Grid, v: &Components<f64>) -> Vec<Vec<f64>> {
    (0..grid.dims)
        .map(|axis| {
            let walls = !grid.axis(axis).is_ring();
            let mut n = grid.n;
            n[axis] += usize::from(walls);
            let faces = (0..n[0] * n[1] * n[2]).map(|i| [i % n[0], i / n[0] % n[1], i / n[0] / n[1]]);
            let value = |at: [usize; 3]| {
                if at[axis] == grid.n[axis] {
                    0.0
                } else {
                    v[axis][grid.index(at)]
                }
            };
            faces.map(value).collect()
        })
        .collect()
}

/// A problem on `cells` of a few steps.
pub fn problem<'a>(cells: &'a [usize], ends: &'a [Boundary], emitters: &'a [Emitter]) -> Problem<'a> {
    Problem {
        steps: 4,
        emitters,
        dt: 0.5,
        length: 2.0,
        ..Problem::new(cells, ends, &[])
    }
}

#[test]
fn the_density_goes_as_transport_on_the_finer_grid_takes_it() {
    for (cells, ends, doublings) in [
        (&[8, 6][..], "wp", 1),
        (&[6, 5][..], "ww", 2),
        (&[4, 5, 6][..], "pww", 1),
    ] {
        let ends = &boundaries(ends);
        let from = Grid::new(cells, ends);
        let fine: Vec<usize> = cells.iter().map(|n| n << doublings).collect();
        let to = Grid::new(&fine, ends);
        let mut random = Random::new(73);
        let v: Components<f64> = flow::rough(&mut random, &from, 1, 1.3);
        let (rho, shape): (Vec<f64>, Vec<f64>) = (random.density(&to), random.density(&to));
        let supply = Supply::Rate(0.25);
        let emitters = [Emitter {
            from: 1,
            to: 3,
            supply,
            velocity: None,
        }];
        let problem = problem(&fine, ends, &emitters);
        // By hand.
        let (mut grid_now, mut flow_now) = (from, v.clone());
        for _ in 0..doublings {
            let next = Grid::new(
                &grid_now.n[..grid_now.dims]
                    .iter()
                    .map(|n| 2 * n)
                    .collect::<Vec<_>>(),
                ends,
            );
            flow_now = doubled(&grid_now, &next, &flow_now, 1);
            grid_now = next;
        }
        let carry = Carry::new(&to, Scheme::Limited, 1e-5);
        let mut expected = rho.clone();
        for step in 1..=3 {
            expected = carry.forward(&flow_now, &expected).unwrap();
            let added = if (2..=3).contains(&step) { 0.25 } else { 0.0 };
            expected
                .iter_mut()
                .zip(&shape)
                .for_each(|(rho, shape)| *rho += added * shape);
        }
        let bytes = Refined::<f64>::bytes(&problem, finer(doublings, 2)).unwrap();
        let mut memory = Memory::new(bytes);
        let mut refined = Refined::<f64>::carve(&problem, finer(doublings, 2), memory.block()).unwrap();
        refined.set_density(&rho).unwrap();
        refined.set_emitter(0, &shape).unwrap();
        let unit = problem.length / problem.dt;
        for _ in 0..3 {
            for (axis, faces) in files(&from, &v).into_iter().enumerate() {
                let faces: Vec<f64> = faces.into_iter().map(|face| face * unit).collect();
                refined.set_velocity(axis, &faces).unwrap();
            }
            with_threads(2, |exec| refined.advance(exec, &mut Silent)).unwrap();
        }
        assert_eq!(refined.step(), 3);
        let gap = largest(refined.density().iter().zip(&expected).map(|(x, y)| x - y));
        assert!(gap < 1e-9, "{cells:?}: {gap:e}");
        // Means over the result's cells keep the mass.
        let mut means = vec![f64::NAN; from.cells()];
        refined.means(&Serial, &mut means);
        let children = (1usize << (doublings * from.dims)) as f64;
        let (whole, parts): (f64, f64) = (refined.density().iter().sum(), means.iter().sum());
        assert!((whole - children * parts).abs() < 1e-9 * whole);
    }
}

#[test]
fn flow_and_smoke_stay_out_of_solid_cells_of_the_finer_grid() {
    for (cells, ends) in [(&[8, 8][..], "ww"), (&[64, 32], "wp"), (&[8, 6, 5], "wpw")] {
        let ends = &boundaries(ends);
        let from = Grid::new(cells, ends);
        let fine: Vec<usize> = cells.iter().map(|n| 2 * n).collect();
        let to = Grid::new(&fine, ends);
        let problem = Problem {
            solids: true,
            ..problem(&fine, ends, &[])
        };
        let bytes = Refined::<f64>::bytes(&problem, finer(1, 2)).unwrap();
        let mut memory = Memory::new(bytes);
        let mut refined = Refined::<f64>::carve(&problem, finer(1, 2), memory.block()).unwrap();
        // Not in step with the cells of the result, whose flow goes through.
        let is_solid = |[x, y, z]: [usize; 3]| (7..10).contains(&x) && (5..8).contains(&y) && z < 6;
        let solid: Vec<bool> = places(&to).map(is_solid).collect();
        refined.set_solids(&solid).unwrap();
        refined.set_density(&vec![1.0; to.cells()]).unwrap();
        let v: Components<f64> = flow::rough(&mut Random::new(74), &from, 1, 0.7);
        let unit = problem.length / problem.dt;
        for _ in 0..2 {
            for (axis, faces) in files(&from, &v).into_iter().enumerate() {
                let faces: Vec<f64> = faces.into_iter().map(|face| face * unit).collect();
                refined.set_velocity(axis, &faces).unwrap();
            }
            with_threads(2, |exec| refined.advance(exec, &mut Silent)).unwrap();
        }
        for (rho, solid) in refined.density().iter().zip(&solid) {
            // Where the flow has no divergence what is full stays full.
            let expected = if *solid { 0.0 } else { 1.0 };
            assert!((rho - expected).abs() < 1e-3, "{cells:?}: {rho}");
        }
    }
}

/// A density of the result's cells is doubled by cubics, once for each halving of the cells, and so is what emitters add.
#[test]
fn a_density_is_doubled_by_cubics() {
    for (cells, ends, doublings) in [(&[8, 6][..], "wp", 1), (&[6, 5], "ww", 3), (&[4, 5, 6], "pww", 2)] {
        let ends = &boundaries(ends);
        let fine: Vec<usize> = cells.iter().map(|n| n << doublings).collect();
        let problem = problem(&fine, ends, &[]);
        let mut grid = Grid::in_cells(cells, ends);
        // Here and there some smoke, beside which cubics undershoot.
        let mut random = Random::new(78);
        let smoke = places(&grid).map(|at| {
            if (at[0] + 2 * at[1]) % 3 == 0 {
                random.unit()
            } else {
                0.0
            }
        });
        let given: Vec<f64> = smoke.collect();
        let mut expected = given.clone();
        for _ in 0..doublings {
            let next = grid.of_cells(core::array::from_fn(|a| {
                if a < grid.dims { 2 * grid.n[a] } else { 1 }
            }));
            let places = places(&next).map(|at| at.map(|i| 0.5 * (i as f64 + 0.5)));
            expected = places
                .map(|place| cubic::at(&grid, &expected, None, place))
                .collect();
            grid = next;
        }
        assert!(expected.iter().any(|&x| x < 0.0), "{cells:?}: nothing to cut off");
        expected.iter_mut().for_each(|x| *x = x.max(0.0));
        let bytes = Refined::<f64>::bytes(&problem, finer(doublings, 2)).unwrap();
        let mut memory = Memory::new(bytes);
        let mut refined = Refined::<f64>::carve(&problem, finer(doublings, 2), memory.block()).unwrap();
        with_threads(2, |exec| refined.set_density_of_result(exec, &given)).unwrap();
        let gap = |found: &[f64], by: f64| largest(found.iter().zip(&expected).map(|(x, y)| x - by * y));
        assert!(gap(refined.density(), 1.0) < 1e-13, "{cells:?}");
        refined.add_of_result(&Serial, &given).unwrap();
        assert!(gap(refined.density(), 2.0) < 1e-13, "{cells:?}");
        let short = refined.set_density_of_result(&Serial, &given[1..]);
        assert!(matches!(short, Err(InputError::Length { .. })));
    }
}

#[test]
fn memory_does_not_grow_with_steps() {
    let ends = &boundaries("www");
    let fine = [16, 16, 16];
    let bytes = |steps| {
        let problem = Problem {
            steps,
            ..problem(&fine, ends, &[])
        };
        Refined::<f32>::bytes(&problem, finer(1, 2)).unwrap()
    };
    assert_eq!(bytes(2), bytes(1000));
    // A dozen fields of the finer grid and what is small beside them.
    let field = 4 * 16usize.pow(3);
    assert!(bytes(2) < 16 * field, "{} fields", bytes(2) / field);
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let ends = &boundaries("ww");
    let odd = problem(&[10, 12], ends, &[]);
    assert!(matches!(
        Refined::<f32>::bytes(&odd, finer(2, 1)),
        Err(PlanError::OutOfRange {
            field: "doublings",
            most: 1,
            ..
        })
    ));
    assert!(Refined::<f32>::bytes(&odd, finer(4, 1)).is_err());
    let bytes = Refined::<f32>::bytes(&odd, finer(1, 1)).unwrap();
    let mut memory = Memory::new(bytes);
    assert!(Refined::<f32>::carve(&odd, finer(1, 1), &mut memory.block()[..bytes - 64]).is_err());
    let mut refined = Refined::<f32>::carve(&odd, finer(1, 1), memory.block()).unwrap();
    assert!(matches!(
        refined.set_density(&[1.0; 3]),
        Err(InputError::Length {
            expected: 120,
            given: 3
        })
    ));
    assert!(matches!(
        refined.set_density(&[-1.0; 120]),
        Err(InputError::Negative { index: 0 })
    ));
    assert!(matches!(
        refined.set_velocity(2, &[]),
        Err(InputError::Index { given: 2, count: 2 })
    ));
    assert!(matches!(
        refined.set_velocity(0, &[0.0; 30]),
        Err(InputError::Length { expected: 36, .. })
    ));
    assert!(matches!(
        refined.set_emitter(0, &[0.0; 120]),
        Err(InputError::Index { count: 0, .. })
    ));
}

/// Among solid cells the flow gives way where it matters least: W^2 Delta is a gradient away from closed faces.
#[test]
fn what_matters_keeps_its_flow() {
    for ends in ["ww", "pw"] {
        let ends = &boundaries(ends);
        let cells = [18, 16];
        let grid = Grid::new(&cells, ends);
        let naive = Naive::new(&grid);
        let problem = Problem {
            solids: true,
            projection_tolerance: 1e-11,
            ..problem(&cells, ends, &[])
        };
        let is_solid = |[x, y, _]: [usize; 3]| (6..10).contains(&x) && (5..11).contains(&y);
        let solid: Vec<bool> = places(&grid).map(is_solid).collect();
        let v: Components<f64> = flow::rough(&mut Random::new(75), &grid, 1, 0.7);
        let unit = problem.length / problem.dt;
        let through = |importance: Option<&[f64]>, threads: usize| {
            let how = Refinement {
                doublings: 0,
                weighted: importance.map(|_| Yielding::default()),
                threads,
                ..Refinement::default()
            };
            let mut memory = Memory::new(Refined::<f64>::bytes(&problem, how).unwrap());
            let mut refined = Refined::<f64>::carve(&problem, how, memory.block()).unwrap();
            refined.set_solids(&solid).unwrap();
            refined.set_density(&vec![1.0; grid.cells()]).unwrap();
            match importance {
                Some(importance) => refined.set_importance(importance).unwrap(),
                None => assert!(refined.set_importance(&vec![1.0; grid.cells()]).is_err()),
            }
            for (axis, faces) in files(&grid, &v).into_iter().enumerate() {
                let faces: Vec<f64> = faces.into_iter().map(|face| face * unit).collect();
                refined.set_velocity(axis, &faces).unwrap();
            }
            with_threads(threads, |exec| refined.advance(exec, &mut Silent)).unwrap();
            let component = |axis| {
                let mut out = vec![f64::NAN; refined.faces(axis)];
                refined.velocity(axis, &mut out).unwrap();
                out.iter().map(|x| x / unit).collect()
            };
            faces(&grid, &[component(0), component(1)])
        };
        let open = |axis: usize, at: [usize; 3]| {
            let low = naive.step(at, axis, -1);
            low.is_some_and(|low| !is_solid(low)) && !is_solid(at)
        };
        let plain = through(None, 1);
        let same = through(Some(&vec![1.0; grid.cells()]), 1);
        let gap = largest((0..2).flat_map(|a| plain[a].iter().zip(&same[a]).map(|(x, y)| x - y)));
        assert!(gap < 1e-9 * largest_of(&v), "{gap:e} from the plain projection");
        let importance: Vec<f64> = places(&grid)
            .map(|[x, y, _]| 0.1 + ((3 * x + 5 * y) % 10) as f64 * 0.1)
            .collect();
        let found = through(Some(&importance), 1);
        assert_eq!(found, through(Some(&importance), 3), "on three threads");
        let divergence = largest(naive.divergence(&found)) * grid.h[0] / largest_of(&v);
        assert!(divergence < 1e-9, "divergence {divergence:e}");
        // W^2 Delta on open faces.
        let weight = |axis: usize, at: [usize; 3]| {
            let low = naive.step(at, axis, -1).unwrap();
            let mean = 0.5 * (importance[naive.id(low)] + importance[naive.id(at)]);
            mean * mean * (found[axis][naive.id(at)] - v[axis][naive.id(at)])
        };
        let (mut seen, mut curl) = (0, 0.0_f64);
        for at in places(&grid) {
            let (Some(left), Some(below)) = (naive.step(at, 0, -1), naive.step(at, 1, -1)) else {
                continue;
            };
            if [open(0, at), open(0, below), open(1, at), open(1, left)].contains(&false) {
                continue;
            }
            seen += 1;
            curl = curl.max((weight(0, at) - weight(0, below) - weight(1, at) + weight(1, left)).abs());
        }
        assert!(
            seen > 100 && curl < 1e-8 * largest_of(&v),
            "curl {curl:e} at {seen} places"
        );
        for axis in 0..2 {
            for at in places(&grid).filter(|&at| !open(axis, at)) {
                assert_eq!(found[axis][naive.id(at)], 0.0, "{at:?}");
            }
        }
    }
}
