//! <y, A x> = <A^T y, x> for every linear part of a step, and the derivative of advection.

use crate::fields::random::Random;
use crate::fields::{boundaries, with_threads};
use thurible_core::stable_fluids::Adjoint;
use thurible_core::stable_fluids::advect::advect;
use thurible_core::stable_fluids::advect_back::{density_adjoint, velocity_adjoint};
use thurible_core::stable_fluids::cells::Cells;
use thurible_core::stable_fluids::conjugate::{Stopping, Tape};
use thurible_core::stable_fluids::fields::pitch;
use thurible_core::stable_fluids::project::{Room, Solve, project, project_adjoint};
use thurible_core::stable_fluids::sweeps::{diffuse, diffuse_adjoint};
use thurible_core::{Exec, Serial};

const SHAPES: [(&[usize], &str); 12] = [
    (&[7, 5], "ww"),
    (&[5, 8], "pw"),
    (&[6, 5], "wp"),
    (&[6, 6], "pp"),
    (&[5, 6, 4], "www"),
    (&[6, 4, 5], "pww"),
    (&[4, 5, 6], "wpw"),
    (&[5, 4, 4], "wwp"),
    (&[4, 6, 5], "ppw"),
    (&[6, 5, 4], "pwp"),
    (&[5, 4, 6], "wpp"),
    (&[4, 4, 6], "ppp"),
];

fn cells((n, ends): (&[usize], &str)) -> Cells {
    Cells::new(n, &boundaries(ends))
}

fn noise(random: &mut Random, len: usize) -> Vec<f64> {
    (0..len).map(|_| random.signed()).collect()
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[track_caller]
fn equal(forward: f64, backward: f64) {
    let gap = (forward - backward).abs() / forward.abs().max(1e-3);
    assert!(gap < 1e-11, "{forward} {backward}: {gap:e}");
}

fn room(cells: &Cells) -> Vec<f64> {
    vec![0.0; (cells.dims + 3) * pitch::<f64>(cells.padded)]
}

#[test]
fn ghosts_on_every_mixture_of_axes() {
    let mut random = Random::new(1);
    for shape in SHAPES {
        let cells = cells(shape);
        for component in [None, Some(0), Some(1), Some(cells.dims - 1)] {
            let (x, y) = (noise(&mut random, cells.padded), noise(&mut random, cells.padded));
            let mut inside = vec![0.0; cells.padded];
            let mut plain = vec![0.0; cells.count()];
            cells.pack(&x, &mut plain);
            cells.unpack(&plain, &mut inside);
            let mut image = x.clone();
            cells.set_bnd(component, &mut image);
            let mut back = y.clone();
            cells.set_bnd_adjoint(component, &mut back);
            equal(dot(&y, &image), dot(&back, &inside));
        }
    }
}

#[test]
fn diffusion_by_sweeps() {
    let mut random = Random::new(2);
    for shape in SHAPES {
        let cells = cells(shape);
        for component in [None, Some(0), Some(cells.dims - 1)] {
            for sweeps in [1, 2, 7] {
                let (mut x, mut y) = (noise(&mut random, cells.padded), noise(&mut random, cells.padded));
                let before = (x.clone(), y.clone());
                let mut work = room(&cells);
                diffuse(&Serial, &cells, (0.02, sweeps), component, &mut x, &mut work);
                diffuse_adjoint(&Serial, &cells, (0.02, sweeps), component, &mut y, &mut work);
                equal(dot(&before.1, &x), dot(&y, &before.0));
            }
        }
    }
}

/// Sweeps cell by cell, as the formula is written.
#[test]
fn sweeps_are_those_of_the_plain_order() {
    let mut random = Random::new(3);
    for shape in SHAPES {
        let cells = cells(shape);
        let mut x = noise(&mut random, cells.padded);
        let start = x.clone();
        let (k, m) = (0.02, cells.longest as f64);
        let (a, c) = (k * m * m, 1.0 + 2.0 * cells.dims as f64 * k * m * m);
        let mut plain = start.clone();
        cells.set_bnd(Some(1), &mut plain);
        for _ in 0..3 {
            for place in (0..cells.rows()).flat_map(|row| cells.row(row)) {
                let around: f64 = (0..cells.dims)
                    .map(|axis| plain[place - cells.stride[axis]] + plain[place + cells.stride[axis]])
                    .sum();
                plain[place] = (start[place] + a * around) / c;
            }
            cells.set_bnd(Some(1), &mut plain);
        }
        diffuse(&Serial, &cells, (k, 3), Some(1), &mut x, &mut room(&cells));
        let worst = x
            .iter()
            .zip(&plain)
            .fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()));
        assert!(worst < 1e-13, "{shape:?}: {worst:e}");
    }
}

/// The projection on rubbish, and its adjoint.
fn projected(cells: &Cells, solve: Solve, iterations: usize, x: &[Vec<f64>], y: &[Vec<f64>]) -> [f64; 2] {
    let grid = cells.grid();
    let (mut v, mut w) = (x.to_vec(), y.to_vec());
    v.resize(3, Vec::new());
    w.resize(3, Vec::new());
    for (axis, v) in v.iter_mut().enumerate().take(cells.dims) {
        cells.set_bnd(Some(axis), v);
    }
    let before = v.clone();
    let mut others = vec![vec![0.0; cells.padded]; 4];
    let [direction, image, copy, kept] = &mut others[..] else {
        unreachable!()
    };
    let each = pitch::<f64>(cells.count());
    let (mut fields, mut scalars) = (vec![0.0; 2 * iterations * each], vec![0.0; 3 * iterations]);
    let mut work = room(cells);
    let mut sums = vec![0.0; grid.rows()];
    let mut room = Room {
        fields: &mut work,
        conjugate: [direction, image, copy],
        tape: Tape {
            fields: &mut fields,
            pitch: each,
            scalars: &mut scalars,
        },
        sums: &mut sums,
    };
    let [vx, vy, vz] = &mut v[..] else { unreachable!() };
    project(&Serial, (cells, &grid), solve, &mut [vx, vy, vz], &mut room, kept);
    let [wx, wy, wz] = &mut w[..] else { unreachable!() };
    project_adjoint(&Serial, (cells, &grid), solve, &mut [wx, wy, wz], &mut room, kept);
    let sum = |a: &[Vec<f64>], b: &[Vec<f64>]| a.iter().zip(b).map(|(a, b)| dot(a, b)).sum();
    assert!(v.iter().chain(&w).flatten().all(|x| x.is_finite()));
    [sum(y, &v), sum(&w, &before)]
}

#[test]
fn projection_by_sweeps() {
    let mut random = Random::new(4);
    for shape in SHAPES {
        let cells = cells(shape);
        let [x, y] = [(); 2].map(|()| {
            (0..cells.dims)
                .map(|_| noise(&mut random, cells.padded))
                .collect::<Vec<_>>()
        });
        for sweeps in [1, 6] {
            let [forward, backward] = projected(&cells, Solve::Sweeps(sweeps), 0, &x, &y);
            equal(forward, backward);
        }
    }
}

/// Conjugate gradients are not linear in their right-hand side, so their derivative is told by differences.
#[test]
fn projection_by_conjugate_gradients() {
    let mut random = Random::new(5);
    for shape in SHAPES {
        let cells = cells(shape);
        let [x, way, y] = [(); 3].map(|()| {
            (0..cells.dims)
                .map(|_| noise(&mut random, cells.padded))
                .collect::<Vec<_>>()
        });
        let most = 4;
        let solve = Solve::Conjugate(Stopping { tolerance: 0.0, most }, Adjoint::Exact);
        let moved = |h: f64| -> Vec<Vec<f64>> {
            let add = |(x, way): (&Vec<f64>, &Vec<f64>)| x.iter().zip(way).map(|(x, d)| x + h * d).collect();
            x.iter().zip(&way).map(add).collect()
        };
        let value = |h: f64| projected(&cells, solve, most, &moved(h), &y)[0];
        let h = 1e-5;
        let difference = (8.0 * (value(h) - value(-h)) - (value(2.0 * h) - value(-2.0 * h))) / (12.0 * h);
        let slope = derivative(&cells, solve, most, &x, &way, &y);
        let gap = (difference - slope).abs() / slope.abs().max(1e-2);
        assert!(gap < 1e-8, "{shape:?}: {difference} {slope}");
    }
}

/// <P'(x)^T y, way>, `way` with its ghosts filled.
fn derivative(
    cells: &Cells,
    solve: Solve,
    most: usize,
    x: &[Vec<f64>],
    way: &[Vec<f64>],
    y: &[Vec<f64>],
) -> f64 {
    // <w, x + way> - <w, x> of the same w.
    let at = |x: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let mut x = x.to_vec();
        for (axis, x) in x.iter_mut().enumerate() {
            cells.set_bnd(Some(axis), x);
        }
        x
    };
    let (way, _) = (at(way), ());
    adjoint_of(cells, solve, most, x, y)
        .iter()
        .zip(&way)
        .map(|(w, way)| dot(w, way))
        .sum()
}

fn adjoint_of(cells: &Cells, solve: Solve, most: usize, x: &[Vec<f64>], y: &[Vec<f64>]) -> Vec<Vec<f64>> {
    // One number of the adjoint at a time would take long: probe it by what it is paired with.
    let grid = cells.grid();
    let (mut v, mut w) = (x.to_vec(), y.to_vec());
    v.resize(3, Vec::new());
    w.resize(3, Vec::new());
    for (axis, v) in v.iter_mut().enumerate().take(cells.dims) {
        cells.set_bnd(Some(axis), v);
    }
    let mut others = vec![vec![0.0; cells.padded]; 4];
    let [direction, image, copy, kept] = &mut others[..] else {
        unreachable!()
    };
    let each = pitch::<f64>(cells.count());
    let (mut fields, mut scalars) = (vec![0.0; 2 * most * each], vec![0.0; 3 * most]);
    let (mut work, mut sums) = (room(cells), vec![0.0; grid.rows()]);
    let mut room = Room {
        fields: &mut work,
        conjugate: [direction, image, copy],
        tape: Tape {
            fields: &mut fields,
            pitch: each,
            scalars: &mut scalars,
        },
        sums: &mut sums,
    };
    let [vx, vy, vz] = &mut v[..] else { unreachable!() };
    project(&Serial, (cells, &grid), solve, &mut [vx, vy, vz], &mut room, kept);
    let [wx, wy, wz] = &mut w[..] else { unreachable!() };
    project_adjoint(&Serial, (cells, &grid), solve, &mut [wx, wy, wz], &mut room, kept);
    w.truncate(cells.dims);
    w
}

#[test]
fn conjugate_gradients_stay_finite_where_there_is_nothing_to_do() {
    for shape in SHAPES {
        let cells = cells(shape);
        let still = vec![vec![0.0; cells.padded]; cells.dims];
        let ones = vec![vec![1.0; cells.padded]; cells.dims];
        let mut random = Random::new(6);
        let rough: Vec<Vec<f64>> = (0..cells.dims)
            .map(|_| noise(&mut random, cells.padded))
            .collect();
        let most = 300;
        let solve = Solve::Conjugate(Stopping { tolerance: 0.0, most }, Adjoint::Exact);
        for v in [&still, &ones, &rough] {
            assert!(
                projected(&cells, solve, most, v, &rough)
                    .iter()
                    .all(|x| x.is_finite())
            );
        }
    }
}

/// Fields carried at Courant numbers at which many traces are clamped.
fn carried(exec: &dyn Exec, cells: &Cells, v: &[Vec<f64>], d: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; cells.padded];
    let empty: &[f64] = &[];
    let v = [&v[0][..], &v[1][..], v.get(2).map_or(empty, |v| v)];
    advect(exec, cells, v, [d], [&mut out]);
    out
}

#[test]
fn advection_with_clamped_traces() {
    let mut random = Random::new(8);
    for shape in SHAPES {
        let cells = cells(shape);
        let scale = 4.0 / cells.longest as f64;
        let v: Vec<Vec<f64>> = (0..cells.dims)
            .map(|_| {
                noise(&mut random, cells.padded)
                    .iter()
                    .map(|v| scale * v)
                    .collect()
            })
            .collect();
        let way: Vec<Vec<f64>> = (0..cells.dims)
            .map(|_| noise(&mut random, cells.padded))
            .collect();
        let (d, y) = (noise(&mut random, cells.padded), noise(&mut random, cells.padded));
        let mut inside = vec![0.0; cells.count()];
        cells.pack(&y, &mut inside);
        let mut g = vec![0.0; cells.padded];
        cells.unpack(&inside, &mut g);
        let mut to = vec![0.0; cells.padded];
        let mut by = vec![vec![0.0; cells.padded]; 3];
        let [bx, by_, bz] = &mut by[..] else {
            unreachable!()
        };
        let empty: &[f64] = &[];
        let flow = [&v[0][..], &v[1][..], v.get(2).map_or(empty, |v| v)];
        density_adjoint(&Serial, &cells, (flow, &d), &g, &mut to, &mut [bx, by_, bz]);
        equal(dot(&g, &carried(&Serial, &cells, &v, &d)), dot(&to, &d));
        // By the velocity: linear in each trace but where it crosses a cell.
        let h = 1e-7;
        let moved = |h: f64| -> Vec<Vec<f64>> {
            let add = |(v, w): (&Vec<f64>, &Vec<f64>)| v.iter().zip(w).map(|(v, w)| v + h * w).collect();
            v.iter().zip(&way).map(add).collect()
        };
        let value = |h: f64| dot(&g, &carried(&Serial, &cells, &moved(h), &d));
        let difference = (value(h) - value(-h)) / (2.0 * h);
        let slope: f64 = by.iter().zip(&way).map(|(by, way)| dot(by, way)).sum();
        assert!(
            (difference - slope).abs() < 1e-5 * slope.abs().max(1.0),
            "{shape:?}: {difference} {slope}"
        );
    }
}

#[test]
fn threads_give_the_same_bits() {
    let mut random = Random::new(9);
    for shape in [
        (&[33, 48][..], "ww"),
        (&[40, 24][..], "pw"),
        (&[16, 12, 14][..], "wpw"),
        (&[12, 16, 14][..], "wwp"),
    ] {
        let cells = cells(shape);
        let start = noise(&mut random, cells.padded);
        let v: Vec<Vec<f64>> = (0..3)
            .map(|axis| {
                let len = if axis < cells.dims { cells.padded } else { 0 };
                noise(&mut random, len).iter().map(|v| 0.1 * v).collect()
            })
            .collect();
        let run = |exec: &dyn Exec| {
            let mut x = start.clone();
            diffuse(exec, &cells, (0.01, 9), Some(0), &mut x, &mut room(&cells));
            let mut y = start.clone();
            diffuse_adjoint(exec, &cells, (0.01, 9), Some(0), &mut y, &mut room(&cells));
            let mut g: Vec<Vec<f64>> = v.clone();
            for (axis, g) in g.iter_mut().enumerate().take(cells.dims) {
                cells.set_bnd_adjoint(Some(axis), g);
            }
            let mut to = vec![vec![0.0; cells.padded]; 3];
            let [tx, ty, tz] = &mut to[..] else { unreachable!() };
            let [gx, gy, gz] = &mut g[..] else { unreachable!() };
            velocity_adjoint(
                exec,
                &cells,
                [&v[0], &v[1], &v[2]],
                &mut [gx, gy, gz],
                &mut [tx, ty, tz],
            );
            [x, y, to.concat(), g.concat()].concat()
        };
        let alone = run(&Serial);
        for threads in [2, 3] {
            assert!(
                with_threads(threads, |exec| run(exec)) == alone,
                "{shape:?} with {threads} threads"
            );
        }
    }
}
