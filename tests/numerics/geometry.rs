//! What lies beyond a cell, a face and a row, against a naive model that walks from cell to cell.

use crate::fields::naive::Naive;
use crate::fields::{grid, places};
use thurible_core::field::Block;
use thurible_core::grid::geometry::Beyond;
use thurible_core::grid::halo::{self, BEFORE, HALO};
use thurible_core::grid::stencil::Stencil;
use thurible_core::grid::{Axis, Boundary, Grid, Side};

const SIDES: [(Side, isize); 2] = [(Side::Low, -1), (Side::High, 1)];

/// Boxes with walls, rings and both, of even and odd lengths, down to two cells.
fn boxes() -> impl Iterator<Item = (Grid, String)> {
    let flat = [[4, 4], [5, 4], [7, 9], [2, 3], [16, 5]].map(|n| n.to_vec());
    let deep = [[4, 4, 4], [4, 5, 6], [7, 2, 5], [9, 6, 3]].map(|n| n.to_vec());
    flat.into_iter().chain(deep).flat_map(|n| {
        (0..1 << n.len()).map(move |rings| {
            let ends: String = (0..n.len())
                .map(|a| if rings >> a & 1 == 1 { 'p' } else { 'w' })
                .collect();
            (grid(&n, &ends), format!("{n:?} {ends}"))
        })
    })
}

/// Boxes that a flux is computed in: at least four cells along every axis.
fn boxes_of_smoke() -> impl Iterator<Item = (Grid, String)> {
    boxes().filter(|(grid, _)| grid.n.iter().take(grid.dims).all(|&n| n >= 4))
}

/// The cells that begin the rows.
fn row_starts(grid: &Grid) -> impl Iterator<Item = ([usize; 3], usize)> {
    let rows = grid.n[1];
    places(grid)
        .filter(|at| at[0] == 0)
        .map(move |at| (at, at[2] * rows + at[1]))
}

#[test]
fn an_axis_answers_for_every_index() {
    for n in 1..=9usize {
        for ends in [Boundary::Wall, Boundary::Periodic] {
            let (axis, ring) = (Axis::new(n, ends), ends == Boundary::Periodic);
            assert_eq!((axis.cells(), axis.faces()), (n, n + usize::from(!ring)));
            let last = n as isize - 1;
            for i in -3 * n as isize..=4 * n as isize {
                let inside = (0..=last).contains(&i);
                let wrapped = i.rem_euclid(n as isize) as usize;
                assert_eq!(axis.cell(i), (inside || ring).then_some(wrapped));
                assert_eq!(axis.open_face(i), (ring || (inside && i > 0)).then_some(wrapped));
                let (mut nearest, mut mirrored) = (i, i);
                while !ring && !(0..=last).contains(&mirrored) {
                    mirrored = if mirrored < 0 {
                        -1 - mirrored
                    } else {
                        2 * n as isize - 1 - mirrored
                    };
                }
                if !ring {
                    nearest = nearest.max(0).min(last);
                }
                assert_eq!(axis.nearest(i), nearest.rem_euclid(n as isize) as usize);
                assert_eq!(axis.mirrored(i), mirrored.rem_euclid(n as isize) as usize);
                let x = i as f64 + 0.25;
                let free = ring || (x > 0.0 && x < last as f64);
                let point = if free { x } else { x.max(0.0).min(last as f64) };
                assert_eq!(axis.nearest_point(x), (point, free));
            }
        }
    }
}

#[test]
fn cells_and_rows_know_their_neighbours() {
    for (grid, name) in boxes() {
        let naive = Naive::new(&grid);
        let row_of = |at: [usize; 3]| at[2] * grid.n[1] + at[1];
        for at in places(&grid) {
            assert_eq!(grid.cell_at(row_of(at), at[0]), at);
            assert_eq!(grid.index(at), naive.id(at));
            for axis in 0..grid.dims {
                for (side, by) in SIDES {
                    let beside = naive.step(at, axis, by);
                    assert_eq!(
                        grid.beside(at, axis, side),
                        beside,
                        "{name} {at:?} axis {axis} {side:?}"
                    );
                    let face = 2 * axis + usize::from(side == Side::High);
                    assert_eq!(
                        grid.closed_faces(at) >> face & 1 == 1,
                        beside.is_none(),
                        "{name} {at:?}"
                    );
                }
            }
        }
        for (at, row) in row_starts(&grid) {
            for axis in 1..grid.dims {
                for (side, by) in SIDES {
                    let beside = naive.step(at, axis, by).map(row_of);
                    assert_eq!(
                        grid.neighbour(row, axis, side),
                        beside,
                        "{name} {at:?} axis {axis} {side:?}"
                    );
                }
                assert_eq!(grid.wall_below(row, axis), naive.wall(at, axis));
            }
            let around = grid.rows_around(row);
            for (place, &found) in around.iter().enumerate() {
                let offset = [place % 3, place / 3].map(|i| i as isize - 1);
                let in_y = naive.step(at, 1, offset[0]);
                let row = match offset[1] {
                    0 => in_y,
                    _ if grid.dims == 2 => None,
                    by => in_y.and_then(|at| naive.step(at, 2, by)),
                };
                assert_eq!(found, row.map(row_of), "{name} {at:?} {offset:?}");
            }
        }
    }
}

#[test]
fn stencils_stop_at_walls() {
    for (grid, name) in boxes_of_smoke() {
        let naive = Naive::new(&grid);
        let row_of = |at: [usize; 3]| at[2] * grid.n[1] + at[1];
        for (at, row) in row_starts(&grid) {
            let stencil = Stencil::new(&grid, row);
            assert_eq!(stencil.row, row);
            for axis in 1..grid.dims {
                let cells = [-2, -1, 1, 2].map(|by| row_of(naive.walk(at, axis, by)));
                assert_eq!(stencil.cells[axis - 1], cells, "{name} {at:?} axis {axis}");
                let mut first = at;
                first[axis] = 0;
                let faces = [-1, 0, 1, 2].map(|by| row_of(naive.step(at, axis, by).unwrap_or(first)));
                assert_eq!(stencil.faces[axis - 1], faces, "{name} {at:?} axis {axis}");
                for (side, by) in SIDES {
                    assert_eq!(stencil.at_wall(axis, side), naive.step(at, axis, by).is_none());
                }
            }
            for further in 1..stencil.alike {
                let other = Stencil::new(&grid, row + further);
                let moved = |rows: [[usize; 4]; 2]| rows.map(|rows| rows.map(|row| row + further));
                assert_eq!(
                    other.cells,
                    moved(stencil.cells),
                    "{name} {at:?} and {further} further"
                );
                assert_eq!(
                    other.faces,
                    moved(stencil.faces),
                    "{name} {at:?} and {further} further"
                );
            }
        }
    }
}

#[test]
fn halos_continue_a_row_behind_its_ends() {
    for n in 4..=9usize {
        for ends in ["ww", "pw"] {
            let grid = grid(&[n, 4], ends);
            let naive = Naive::new(&grid);
            let mut cells = vec![-1.0; halo::stride(n)];
            halo::inner(&mut cells, n)
                .iter_mut()
                .enumerate()
                .for_each(|(i, cell)| *cell = i as f64);
            grid.axis(0).surround_cells(&mut cells);
            let mut faces = cells.clone();
            if naive.wall([0; 3], 0) {
                faces[BEFORE] = 0.0;
            }
            grid.axis(0).surround_faces(&mut faces);
            for place in 0..n + HALO {
                let by = place as isize - BEFORE as isize;
                assert_eq!(
                    cells[place],
                    naive.walk([0; 3], 0, by)[0] as f64,
                    "cell {by} of {n} {ends}"
                );
                if place > 0 {
                    let face = naive.step([0; 3], 0, by).filter(|&at| !naive.wall(at, 0));
                    assert_eq!(
                        faces[place],
                        face.map_or(0.0, |at| at[0] as f64),
                        "face {by} of {n} {ends}"
                    );
                }
            }
        }
    }
}

#[test]
fn blocks_find_the_values_beside_theirs() {
    const SLOTS: usize = 3;
    for (grid, name) in boxes() {
        let naive = Naive::new(&grid);
        let n = grid.n[0];
        // Every value says which cell and which slot it belongs to.
        let value = |at: [usize; 3], slot: usize| (10 * naive.id(at) + slot + 1) as f64;
        let mut field = vec![0.0; grid.cells() * SLOTS];
        for (at, row) in row_starts(&grid) {
            for (i, x) in field[row * SLOTS * n..][..SLOTS * n].iter_mut().enumerate() {
                *x = value([i % n, at[1], at[2]], i / n);
            }
        }
        let block = Block {
            grid: &grid,
            slots: SLOTS,
            first: 1,
            count: 2,
        };
        for (at, row) in row_starts(&grid) {
            let cell = |i: usize| ([i % n, at[1], at[2]], 1 + i / n);
            for axis in 0..grid.dims {
                for ((side, by), beyond) in SIDES
                    .into_iter()
                    .flat_map(|s| [Beyond::Zero, Beyond::Own].map(|b| (s, b)))
                {
                    let mut scratch = vec![-1.0; block.len()];
                    let found = block.beside((axis, side), beyond, &field, row, &mut scratch);
                    assert!(axis > 0 || found.is_some());
                    for i in 0..block.len() {
                        let (own, slot) = cell(i);
                        let behind = if beyond == Beyond::Own {
                            value(own, slot)
                        } else {
                            0.0
                        };
                        let expected = naive.step(own, axis, by).map_or(behind, |at| value(at, slot));
                        let found = found.map_or(behind, |values| values[i]);
                        assert_eq!(found, expected, "{name} {own:?} axis {axis} {side:?} {beyond:?}");
                    }
                }
                let mut values = block.of(&field, row).to_vec();
                block.clear_closed(axis, row, &mut values);
                for (i, &found) in values.iter().enumerate() {
                    let (own, slot) = cell(i);
                    let expected = if naive.wall(own, axis) {
                        0.0
                    } else {
                        value(own, slot)
                    };
                    assert_eq!(found, expected, "{name} {own:?} axis {axis}");
                }
            }
        }
    }
}
