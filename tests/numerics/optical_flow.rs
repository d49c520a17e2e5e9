//! The pieces of tracking: F and its adjoint, the Laplacian of faces, warps, resampling.

use crate::fields::random::Random;
use crate::fields::{
    Memory, assert_close, boundaries, dot, dot_all, gap, largest, places, view, view_mut, zeros,
};
use thurible_core::field::{Vector, VectorMut};
use thurible_core::flow::data::{self, Weights};
use thurible_core::flow::resample::{Kind, resample};
use thurible_core::flow::warp::{Warp, carry_flow};
use thurible_core::flow::{Warping, params::FlowParams, pyramid};
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::grid::solids::Solids;
use thurible_core::memory::{Arena, Ledger, Pool};
use thurible_core::operators::self_advection::{Fluid, apply_derivative, scratch_per_thread};
use thurible_core::poisson::Projection;
use thurible_core::{D2, D3, Serial, Silent, TrackParams};

const GRIDS: [(&[usize], &str); 5] = [
    (&[13, 9], "ww"),
    (&[8, 11], "pw"),
    (&[10, 8], "pp"),
    (&[7, 6, 9], "wpw"),
    (&[5, 8, 6], "ppw"),
];

fn grids() -> impl Iterator<Item = Grid> {
    GRIDS
        .iter()
        .map(|(cells, ends)| Grid::in_cells(cells, &boundaries(ends)))
}

fn scratch(grid: &Grid) -> Vec<f64> {
    vec![0.0; data::scratch_len(grid, 1)]
}

/// data F^T r + smooth L w + kinetic w.
fn combined(
    grid: &Grid,
    weights: Weights,
    g: Vector<'_, f64>,
    r: &[f64],
    w: Vector<'_, f64>,
) -> [Vec<f64>; 3] {
    let mut out = zeros(grid, 1);
    data::combine(
        &Serial,
        grid,
        weights,
        (g, r),
        w,
        &mut view_mut(&mut out),
        &mut scratch(grid),
    );
    out
}

const DATA: Weights = Weights {
    data: 1.0,
    smooth: 0.0,
    kinetic: 0.0,
};
const SMOOTH: Weights = Weights {
    data: 0.0,
    smooth: 1.0,
    kinetic: 0.0,
};

#[test]
fn the_data_term_has_its_adjoint() {
    let mut random = Random::new(1);
    for grid in grids() {
        let [a, b, r]: [Vec<f64>; 3] = core::array::from_fn(|_| random.cells(&grid, 1));
        let w = random.faces::<f64>(&grid, 1);
        let mut g = zeros(&grid, 1);
        data::gradient_of_mean(
            &Serial,
            &grid,
            [&a, &b],
            &mut view_mut(&mut g),
            &mut scratch(&grid),
        );
        let mut of_cells = vec![0.0; grid.cells()];
        data::apply(&Serial, &grid, view(&g), view(&w), &mut of_cells);
        let back = combined(&grid, DATA, view(&g), &r, view(&w));
        assert_close("F", dot(&of_cells, &r), dot_all(&w, &back), dot(&r, &r), 1e-12);
        for at in places(&grid) {
            let plain = plain_data(&grid, [&a, &b], &w, at);
            let own = of_cells[grid.index(at)];
            assert_close("F w", own, plain, 1.0, 1e-12);
        }
    }
}

/// (F w) of a cell, one face at a time.
fn plain_data(grid: &Grid, [a, b]: [&[f64]; 2], w: &[Vec<f64>; 3], at: [usize; 3]) -> f64 {
    let mean = |at: [usize; 3]| 0.5 * (a[grid.index(at)] + b[grid.index(at)]);
    (0..grid.dims)
        .map(|axis| {
            let line = grid.axis(axis);
            let face = |index: isize| {
                let Some(high) = line.open_face(index) else {
                    return 0.0;
                };
                let (mut above, mut below) = (at, at);
                above[axis] = high;
                below[axis] = line.cell(index - 1).unwrap();
                (mean(above) - mean(below)) * w[axis][grid.index(above)]
            };
            0.5 * (face(at[axis] as isize) + face(at[axis] as isize + 1))
        })
        .sum()
}

/// C^T C w + D^T D w by the operators of the flow's equation.
fn curls_and_divergence(grid: &Grid, w: &[Vec<f64>; 3]) -> [Vec<f64>; 3] {
    let (still, mut out) = (zeros::<f64>(grid, 1), zeros(grid, 1));
    let fluid = Fluid {
        grid,
        slots: 1,
        viscosity: 1.0,
        solids: Solids::default(),
    };
    let mut rows = vec![0.0; scratch_per_thread(grid, 1)];
    if grid.dims == 2 {
        apply_derivative::<f64, D2>(
            &Serial,
            fluid,
            view(&still),
            view(w),
            view_mut(&mut out),
            &mut rows,
        );
    } else {
        apply_derivative::<f64, D3>(
            &Serial,
            fluid,
            view(&still),
            view(w),
            view_mut(&mut out),
            &mut rows,
        );
    }
    let mut cells = vec![0.0; grid.cells()];
    let work = (&mut cells[..], &mut scratch(grid)[..]);
    data::add_divergence_price(
        &Serial,
        grid,
        Solids::default(),
        1.0,
        view(w),
        &mut view_mut(&mut out),
        work,
    );
    out
}

#[test]
fn the_laplacian_is_that_of_each_component() {
    let mut random = Random::new(2);
    for grid in grids() {
        let w = random.faces::<f64>(&grid, 1);
        let nothing = vec![0.0; grid.cells()];
        let own = combined(&grid, SMOOTH, view(&zeros(&grid, 1)), &nothing, view(&w));
        let other = curls_and_divergence(&grid, &w);
        for axis in 0..grid.dims {
            assert!(gap(&own[axis], &other[axis]) < 1e-12, "{grid:?}");
        }
    }
}

fn projected(grid: &Grid, w: &[Vec<f64>; 3]) -> [Vec<f64>; 3] {
    let mut memory = Memory::new(1 << 22);
    let mut levels = Levels::<f64>::alone(grid);
    levels.fill(&mut Arena::new(memory.block())).unwrap();
    let mut ledger = Ledger::new();
    Projection::<f64>::carve(&levels, 0, 1, 1, &mut Pool::measuring(&mut ledger));
    let mut numbers = vec![0.0; ledger.elements(8)];
    let mut projection = Projection::carve(&levels, 0, 1, 1, &mut Pool::new(&mut numbers));
    let mut out = w.clone();
    let mut sums = vec![0.0; 2 * grid.rows()];
    let field: &mut VectorMut<'_, f64> = &mut view_mut(&mut out);
    assert!(
        projection
            .project(&Serial, &mut Silent, field, None, 1e-12, &mut sums)
            .is_continue()
    );
    out
}

#[test]
fn the_laplacian_commutes_with_the_projection() {
    let mut random = Random::new(3);
    for grid in grids() {
        let w = random.faces::<f64>(&grid, 1);
        let (nothing, no_face) = (vec![0.0; grid.cells()], zeros(&grid, 1));
        let smooth = |w: &[Vec<f64>; 3]| combined(&grid, SMOOTH, view(&no_face), &nothing, view(w));
        let (one, other) = (projected(&grid, &smooth(&w)), smooth(&projected(&grid, &w)));
        for axis in 0..grid.dims {
            assert!(gap(&one[axis], &other[axis]) < 1e-10, "{grid:?}");
        }
    }
}

fn warped(grid: &Grid, warping: Warping, phi: &[f64], v: &[Vec<f64>; 3]) -> Vec<f64> {
    let mut ledger = Ledger::new();
    Warp::carve(grid, warping, 1, &mut Pool::<f64>::measuring(&mut ledger));
    let mut numbers = vec![0.0; ledger.elements(8)];
    let warp = Warp::carve(grid, warping, 1, &mut Pool::new(&mut numbers));
    let (mut out, mut sums) = (vec![0.0; grid.cells()], vec![0.0; 2 * grid.rows()]);
    warp.apply(&Serial, phi, view(v), &mut out, &mut sums).unwrap();
    out
}

#[test]
fn a_warp_leaves_what_does_not_change() {
    let mut random = Random::new(4);
    for grid in grids() {
        let (phi, v) = (random.density::<f64>(&grid), random.faces::<f64>(&grid, 1));
        for warping in [Warping::Bfecc, Warping::Quick] {
            assert_eq!(
                warped(&grid, warping, &phi, &zeros(&grid, 1)),
                phi,
                "{warping:?} at rest"
            );
        }
        let even = vec![2.5; grid.cells()];
        let after = warped(&grid, Warping::Bfecc, &even, &v);
        assert!(gap(&after, &even) < 1e-14, "a constant");
    }
}

#[test]
fn a_warp_moves_a_ramp_and_stays_in_its_limits() {
    let grid = Grid::in_cells(&[32, 24], &boundaries("ww"));
    let ramp: Vec<f64> = places(&grid)
        .map(|[x, y, _]| 0.3 * x as f64 - 0.2 * y as f64)
        .collect();
    let mut v = zeros(&grid, 1);
    for at in places(&grid) {
        for (axis, speed) in [1.3, -0.7].into_iter().enumerate() {
            v[axis][grid.index(at)] = if at[axis] == 0 { 0.0 } else { speed };
        }
    }
    let after = warped(&grid, Warping::Bfecc, &ramp, &v);
    for at in places(&grid) {
        let [x, y, _] = at;
        if (8..24).contains(&x) && (8..16).contains(&y) {
            let expected = ramp[grid.index(at)] + 0.3 * 1.3 + 0.2 * 0.7;
            assert_close("ramp", after[grid.index(at)], expected, 1.0, 1e-3);
        }
    }
    let mut random = Random::new(5);
    let noise = random.density::<f64>(&grid);
    let after = warped(&grid, Warping::Bfecc, &noise, &random.faces(&grid, 1));
    let (low, high) = noise
        .iter()
        .fold((1.0f64, 0.0f64), |(low, high), &x| (low.min(x), high.max(x)));
    assert!(after.iter().all(|&x| x >= low && x <= high));
}

/// phi(x + v) by the plain formula for whole cells on a ring: BFECC is exact there.
#[test]
fn a_warp_by_whole_cells_is_a_shift() {
    let grid = Grid::in_cells(&[9, 7, 8], &boundaries("ppp"));
    let phi = Random::new(6).density::<f64>(&grid);
    let mut v = zeros(&grid, 1);
    for (axis, speed) in [2.0, -1.0, 3.0].into_iter().enumerate() {
        v[axis].fill(speed);
    }
    let after = warped(&grid, Warping::Bfecc, &phi, &v);
    for at in places(&grid) {
        let [x, y, z] = at;
        let from = [(x + 2) % 9, (y + 6) % 7, (z + 3) % 8];
        assert_close("shift", after[grid.index(at)], phi[grid.index(from)], 1.0, 1e-12);
    }
}

#[test]
fn a_uniform_flow_carries_itself() {
    let grid = Grid::in_cells(&[9, 8], &boundaries("pp"));
    let mut v = zeros::<f64>(&grid, 1);
    v[0].fill(1.25);
    v[1].fill(-0.5);
    let [mut there, mut back, mut out] = [(); 3].map(|()| zeros::<f64>(&grid, 1));
    carry_flow(
        &Serial,
        &grid,
        view(&v),
        [&mut view_mut(&mut there), &mut view_mut(&mut back)],
        &mut view_mut(&mut out),
    );
    assert!(gap(&out[0], &v[0]) < 1e-14 && gap(&out[1], &v[1]) < 1e-14);
}

#[test]
fn resampling_keeps_constants_and_walls() {
    let mut random = Random::new(7);
    for grid in grids() {
        for factor in [0.6, 1.7] {
            let n = grid.n.map(|n| ((n as f64 * factor).round() as usize).max(4));
            let target = grid.of_cells(if grid.dims == 2 { [n[0], n[1], 1] } else { n });
            let largest_grid = grid.cells().max(target.cells());
            let room = largest_grid * 2;
            let [mut first, mut second] = [(); 2].map(|()| vec![0.0; room]);
            let mut out = vec![0.0; target.cells()];
            let even = vec![1.5; grid.cells()];
            let kinds = (Kind::Cells, 1.0);
            resample(
                &Serial,
                [&grid, &target],
                kinds,
                &even,
                &mut out,
                [&mut first, &mut second],
            );
            assert!(largest(out.iter().map(|x| x - 1.5)) < 1e-14, "{grid:?}");
            let w = random.faces::<f64>(&grid, 1);
            for axis in 0..grid.dims {
                let kinds = (Kind::Faces(axis), 2.0);
                resample(
                    &Serial,
                    [&grid, &target],
                    kinds,
                    &w[axis],
                    &mut out,
                    [&mut first, &mut second],
                );
                let on_wall = |at: &[usize; 3]| !target.axis(axis).is_ring() && at[axis] == 0;
                assert!(
                    places(&target)
                        .filter(on_wall)
                        .all(|at| out[target.index(at)] == 0.0)
                );
            }
        }
    }
}

#[test]
fn a_pyramid_ends_where_no_axis_shrinks() {
    let sizes = |cells: &[usize], levels: usize| -> Vec<Vec<usize>> {
        let params = FlowParams {
            levels,
            ..TrackParams::default().flow
        };
        let finest = Grid::in_cells(
            cells,
            &boundaries("ww")[..cells.len().min(2)].repeat(2)[..cells.len()],
        );
        let grids = pyramid::grids(&finest, &params);
        grids.iter().map(|grid| grid.n[..cells.len()].to_vec()).collect()
    };
    assert_eq!(sizes(&[64, 128], 3), [[64, 128], [42, 83], [27, 54]]);
    assert_eq!(sizes(&[9, 8], 5), [[9, 8], [8, 8]]);
    assert_eq!(sizes(&[5, 40], 2), [[5, 40], [5, 26]]);
    assert_eq!(sizes(&[300, 64], 2), [[300, 64], [192, 48]]);
}
