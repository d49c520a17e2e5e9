//! The smoother's step at one cell and its sweeps, against a plain second implementation.

use crate::fields;
use crate::fields::random::Random;
use crate::fields::spacetime::{Case, Residual};
use crate::fields::{grid, index, largest, local, places, zeros};
use crate::nso_cases::{self, Both, IN_2D, IN_3D, SLOTS, SOLIDS, grids};
use thurible_core::grid::Grid;
use thurible_core::grid::solids::{Solids, Surfaces};
use thurible_core::nso::colours::{Cells, Colours};
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::level::System;
use thurible_core::nso::local::{Changes, changes, fill_table, scratch_len, solve_row, table_len};
use thurible_core::nso::surroundings::Surroundings;
use thurible_core::nso::{SmootherMemory, Split};
use thurible_core::{D2, D3, Real, Space};

/// The changes of some cells of a row, the same bits for vectors of several widths.
fn solved_in_any_lanes<T: Real, S: Space>(
    system: &System<'_, T>,
    row: usize,
    cells: Cells,
    half: usize,
) -> Vec<T> {
    let solved = |lanes: usize| {
        let mut out = vec![T::ZERO; SLOTS * changes::<S>() * half];
        let mut scratch = vec![T::from_f64(f64::NAN); scratch_len::<S>(SLOTS, lanes)];
        let changes = Changes { out: &mut out, half };
        solve_row::<T, S>(system, row, cells, lanes, &mut scratch, changes);
        out
    };
    let out = solved(1);
    let bits = |x: &T| x.to_f64().to_bits();
    for lanes in [4, 8, 16, 32] {
        let differs = solved(lanes).iter().zip(&out).any(|(x, y)| bits(x) != bits(y));
        let (n, start) = (system.grid.n, cells.start);
        assert!(
            !differs,
            "{n:?}, row {row} from {start}: other bits in {lanes} lanes"
        );
    }
    out
}

/// Every cell's changes against the dense solution, for vectors of several widths, of which none may change a bit, and for every order of
/// slots in which a cell is damped and others.
fn step_agrees<T: Real, S: Space>(list: &[(&[usize], &str)], tolerance: f64) {
    let mut random = Random::new(63);
    let mut orders = [0; 1 << SLOTS];
    let cases = list
        .iter()
        .flat_map(|(cells, ends)| grids(cells, ends))
        .flat_map(|grid| [(grid, false), (grid, true)]);
    for (solid, (n, (grid, coarse))) in SOLIDS
        .into_iter()
        .flat_map(|solid| cases.clone().enumerate().map(move |case| (solid, case)))
    {
        let (kappa, surroundings, viscosity) = (
            [1.0, 0.05][n % 2],
            Surroundings::new([2.0, 0.0, 3.0][n % 3], [1.0, 1.3, 1.25, 1.6][n % 4]),
            [0.0, 0.0, 0.2][n % 5 % 3] * grid.h[0] * grid.h[0],
        );
        let damping = [
            LocalDamping {
                threshold: 1.3 * S::DIM as f64,
            },
            LocalDamping::NONE,
        ][n % 7 % 2];
        let both = Both::<T>::new::<S>(&mut random, &grid, kappa, 1.5, viscosity, coarse, solid);
        let (system, residual) = (both.system(surroundings, damping), both.equations.residual());
        for row in 0..grid.rows() {
            let [y, z] = grid.row_at(row);
            for start in 0..2 {
                let cells = Cells {
                    start,
                    count: (grid.n[0] - start) / 2,
                };
                let half = grid.n[0].div_ceil(2);
                let out = solved_in_any_lanes::<T, S>(&system, row, cells, half);
                let i = random.between(0, cells.count - 1);
                let at = [start + 2 * i, y, z];
                let expected = local::changes(&both.equations, &residual, surroundings, damping, at);
                if damping.threshold > 0.0 && viscosity == 0.0 {
                    let squares = local::squares(&both.equations, at);
                    orders[squares.iter().fold(0, |code, &squares| {
                        2 * code + usize::from(squares > damping.threshold)
                    })] += 1;
                }
                let scale = largest(expected.iter().flatten().copied());
                for (k, expected) in expected.iter().enumerate() {
                    for (quantity, expected) in expected.iter().enumerate() {
                        let found = out[(quantity * SLOTS + k) * half + i].to_f64();
                        let what = format!(
                            "{:?}, coarse {coarse}, solids {}, cell {at:?}, slot {k}, quantity {quantity}",
                            grid.n,
                            solid.is_some()
                        );
                        fields::assert_close(&what, found, *expected, scale, tolerance);
                    }
                }
            }
        }
    }
    assert!(
        !orders.contains(&0),
        "some order of damped slots and others was not met: {orders:?}"
    );
}

#[test]
fn step_at_a_cell_solves_the_local_problem() {
    step_agrees::<f64, D2>(&IN_2D, 1e-11);
    step_agrees::<f64, D3>(&IN_3D, 1e-11);
    step_agrees::<f32, D2>(&IN_2D, 3e-4);
    step_agrees::<f32, D3>(&IN_3D, 3e-4);
}

/// Every cell belongs to one pass, and cells of a pass share no face.
#[test]
fn colours_visit_every_cell_once() {
    for (grid, colours) in IN_2D
        .iter()
        .chain(&IN_3D)
        .map(|(cells, ends)| grid(cells, ends))
        .flat_map(|g| [(g, Colours::RedBlack), (g, Colours::PowerOfTwo)])
    {
        let naive = fields::naive::Naive::new(&grid);
        let mut pass_of = vec![usize::MAX; grid.cells()];
        for (pass, row) in
            (0..colours.passes(&grid)).flat_map(|pass| (0..grid.rows()).map(move |row| (pass, row)))
        {
            let Cells { start, count } = colours.cells(&grid, pass, row);
            for x in (0..count).map(|i| start + 2 * i) {
                let cell = &mut pass_of[row * grid.n[0] + x];
                assert_eq!(*cell, usize::MAX, "cell {x} of row {row} is visited twice");
                *cell = pass;
            }
        }
        assert!(
            !pass_of.contains(&usize::MAX),
            "{:?} {colours:?}: a cell is never visited",
            grid.n
        );
        for (at, axis) in places(&grid).flat_map(|at| (0..grid.dims).map(move |axis| (at, axis))) {
            let Some(next) = naive.step(at, axis, 1) else {
                continue;
            };
            assert_ne!(
                pass_of[naive.id(at)],
                pass_of[naive.id(next)],
                "{:?} {colours:?}: {at:?} and {next:?} share a face",
                grid.n
            );
        }
    }
}

/// Nearly at rest the problem is linear and cells of a pass do not meet: after a sweep the last pass's cells are solved.
fn sweep_solves_its_last_cells<S: Space>(list: &[(&[usize], &str)]) {
    use thurible_core::nso::smoother::{Workspace, scratch_len, sweep, waiting_len};
    let mut random = Random::new(64);
    let shared = [
        (Split::Planes(1), 1),
        (Split::Planes(2), 3),
        (Split::Slabs, 1),
        (Split::Slabs, 3),
    ];
    let orders = [Colours::RedBlack, Colours::PowerOfTwo]
        .into_iter()
        .flat_map(|colours| shared.map(|(split, threads)| (colours, split, threads)));
    let cases = list
        .iter()
        .flat_map(|&g| orders.clone().map(move |order| (g, order)));
    for (((cells, ends), (colours, split, threads)), solid) in
        cases.flat_map(|case| SOLIDS.map(|solid| (case, solid)))
    {
        let grid = grid(cells, ends);
        let mut case = Case::<f64>::towards(
            &grid,
            SLOTS,
            random
                .faces::<f64>(&grid, SLOTS)
                .map(|c| c.iter().map(|x| 1e-9 * x).collect()),
        );
        case.v = zeros(&grid, SLOTS);
        let mut case = case.among(solid);
        let bits = solid.map_or_else(Vec::new, |solid| nso_cases::bits(&grid, solid));
        let before = case.equations(0.6, 0.0).residual().norm(grid.h[0]);
        let memory = SmootherMemory { lanes: 8, split };
        let mut waiting = vec![f64::NAN; waiting_len::<S>(&grid, SLOTS, threads, split)];
        let mut scratch = vec![f64::NAN; threads * scratch_len::<S>(&grid, SLOTS, memory)];
        let mut table = vec![0.0; table_len::<S>()];
        fill_table::<f64, S>(grid.h, solid.is_some(), &mut table);
        let coefficients = thurible_core::nso::level::Coefficients {
            slots: SLOTS,
            kappa: 0.6,
            viscosity: 0.0,
            surroundings: Surroundings::new(0.0, 1.0),
            damping: LocalDamping::NONE,
        };
        let mut level = thurible_core::nso::level::LevelMut {
            grid: &grid,
            solids: if solid.is_some() {
                Solids::new(
                    &bits,
                    Surfaces {
                        obstacles: true,
                        stick: false,
                    },
                )
            } else {
                Solids::default()
            },
            state: thurible_core::nso::level::State {
                v: fields::view_mut(&mut case.v),
                w: fields::view_mut(&mut case.w),
                p: &mut case.p,
                pbar: &mut case.pbar,
            },
            v0: fields::view_mut(&mut case.v0),
            a: fields::view_mut(&mut case.target),
            scale: 0.6,
            b: &mut [],
            c: Default::default(),
            d: &mut [],
            table: &table,
        };
        let mut workspace = Workspace {
            waiting: &mut waiting,
            scratch: &mut scratch,
            memory,
        };
        fields::with_threads(threads, |exec| {
            sweep::<f64, S>(exec, &mut level, &coefficients, colours, &mut workspace)
        });
        let after = case.equations(0.6, 0.0).residual();
        let worst = largest(last_cells(&grid, colours).flat_map(|at| of_cell(&grid, &after, at)));
        assert!(
            worst < 1e-7 * before,
            "{cells:?} {ends} {colours:?} {split:?} on {threads}, solids {}: {worst:e} is left of {before:e}",
            solid.is_some()
        );
    }
}

fn last_cells(grid: &Grid, colours: Colours) -> impl Iterator<Item = [usize; 3]> {
    let last = (0..colours.passes(grid))
        .rev()
        .find(|&pass| (0..grid.rows()).any(|row| colours.cells(grid, pass, row).count > 0))
        .unwrap();
    places(grid).filter(move |at| {
        let Cells { start, count } = colours.cells(grid, last, grid.row(at[1], at[2]));
        (0..count).any(|i| start + 2 * i == at[0])
    })
}

/// The residuals at a cell and its faces in all slots, b and d times h.
fn of_cell(grid: &Grid, all: &Residual, at: [usize; 3]) -> Vec<f64> {
    let naive = fields::naive::Naive::new(grid);
    let mut list = Vec::new();
    for k in 0..SLOTS {
        list.extend([
            all.b[k][naive.id(at)] * grid.h[0],
            all.d[k][naive.id(at)] * grid.h[0],
        ]);
        for axis in 0..grid.dims {
            let ends = [Some(at), naive.step(at, axis, 1)];
            list.extend(
                ends.into_iter()
                    .flatten()
                    .flat_map(|at| [all.a[k][axis][naive.id(at)], all.c[k][axis][naive.id(at)]]),
            );
        }
    }
    assert_eq!(index(grid, 1, 0, at), naive.id(at));
    list
}

#[test]
fn a_sweep_solves_the_cells_that_it_visits_last() {
    sweep_solves_its_last_cells::<D2>(&IN_2D);
    sweep_solves_its_last_cells::<D3>(&IN_3D);
}
