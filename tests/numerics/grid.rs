//! The grid: the hierarchy of coarser grids, and the weights by which fields pass between two of them.

use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{Components, Memory, flow, grid, largest, largest_of, places, zeros};
use thurible_core::exec::ranks::Alone;
use thurible_core::field::Block;
use thurible_core::field::transfer::{Move, Place, Placed};
use thurible_core::grid::levels::{Levels, MAX_LEVELS, hierarchy};
use thurible_core::grid::solids::{SOLID, Surfaces, closed};
use thurible_core::grid::taps::{Transfer, taps};
use thurible_core::grid::{Axis, Boundary, Grid, Side};
use thurible_core::memory::Arena;

/// The weights of a transfer as a full matrix, targets by sources.
fn matrix(transfer: Transfer, fine: usize, coarse: usize, periodic: bool) -> Vec<Vec<f64>> {
    let up = matches!(transfer, Transfer::ProlongCell | Transfer::ProlongFace);
    let (targets, sources) = if up { (fine, coarse) } else { (coarse, fine) };
    let ends = if periodic {
        Boundary::Periodic
    } else {
        Boundary::Wall
    };
    let (fine, coarse) = (Axis::new(fine, ends), Axis::new(coarse, ends));
    let row = |i| {
        let mut row = vec![0.0; sources];
        taps(transfer, i, fine, coarse)
            .iter()
            .for_each(|&(at, weight)| row[at] += weight);
        row
    };
    (0..targets).map(row).collect()
}

fn apply(matrix: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    matrix
        .iter()
        .map(|row| row.iter().zip(x).map(|(w, x)| w * x).sum())
        .collect()
}

/// Half of n; of the two numbers beside it the even one where n is odd and not 5.
fn half(n: usize) -> usize {
    match n % 4 {
        0 | 2 => n / 2,
        1 if n == 5 => 3,
        1 => (n - 1) / 2,
        _ => n.div_ceil(2),
    }
}

/// All sizes with the coarse size that the hierarchy gives them, walls and periodic.
fn sizes() -> impl Iterator<Item = (usize, usize, bool)> {
    (3..=70usize).flat_map(|n| [(n, half(n), false), (n, half(n), true)])
}

#[test]
fn hierarchy_halves_every_axis_and_keeps_the_box() {
    for cells in [
        &[4096, 4][..],
        &[4, 4096],
        &[33, 47],
        &[64, 8],
        &[50, 50],
        &[17, 20, 15],
        &[64, 64, 32],
        &[4095, 5, 4],
    ] {
        let finest = grid(cells, "wpw");
        assert_eq!(
            finest.h,
            [1.0 / cells.iter().copied().max().unwrap() as f64; 3],
            "square cells, the longest side is 1"
        );
        let grids = hierarchy(&finest);
        assert!(grids.len() <= MAX_LEVELS);
        assert!(
            grids.last().unwrap().n.iter().all(|&n| n <= 2),
            "{cells:?} stops too early"
        );
        for pair in grids.windows(2) {
            for a in 0..3 {
                assert_eq!(pair[1].axis(a).is_ring(), finest.axis(a).is_ring());
                let n = pair[0].n[a];
                assert_eq!(pair[1].n[a], if n > 2 { half(n) } else { n });
                let (before, after) = (n as f64 * pair[0].h[a], pair[1].n[a] as f64 * pair[1].h[a]);
                assert!(
                    (before - after).abs() < 1e-12 * before,
                    "the box changes its size"
                );
            }
        }
    }
}

#[test]
fn even_sizes_have_the_textbook_weights() {
    for (n, periodic) in (4..=70usize).step_by(2).flat_map(|n| [(n, false), (n, true)]) {
        let coarse = n / 2;
        let wrap = |i: isize| {
            if periodic {
                i.rem_euclid(coarse as isize) as usize
            } else {
                i.clamp(0, coarse as isize - 1) as usize
            }
        };
        let wall = |i: usize| !periodic && i.is_multiple_of(coarse);
        let expect = |transfer, i: usize, sources: &[(usize, f64)]| {
            let count = if matches!(transfer, Transfer::ProlongCell | Transfer::ProlongFace) {
                coarse
            } else {
                n
            };
            let mut row = vec![0.0; count];
            sources.iter().for_each(|&(at, weight)| row[at] += weight);
            let found = &matrix(transfer, n, coarse, periodic)[i];
            assert!(
                largest(row.iter().zip(found).map(|(x, y)| x - y)) < 1e-12,
                "{transfer:?} of {i} at n = {n}: {found:?}"
            );
        };
        for i in 0..coarse {
            expect(Transfer::RestrictCell, i, &[(2 * i, 0.5), (2 * i + 1, 0.5)]);
            let injected = [(2 * i, 1.0)];
            expect(Transfer::RestrictFace, i, if wall(i) { &[] } else { &injected });
        }
        for f in 0..n {
            let (own, beside) = (f / 2, wrap((f / 2) as isize + if f % 2 == 1 { 1 } else { -1 }));
            expect(Transfer::ProlongCell, f, &[(own, 0.75), (beside, 0.25)]);
            let faces = if f % 2 == 0 {
                vec![(own, 1.0)]
            } else {
                vec![(own, 0.5), ((own + 1) % coarse, 0.5)]
            };
            let inside: Vec<_> = faces.into_iter().filter(|&(at, _)| !wall(at)).collect();
            expect(Transfer::ProlongFace, f, &inside);
        }
    }
}

#[test]
fn prolongation_is_exact_for_what_it_must_carry() {
    for (n, coarse, periodic) in sizes() {
        for (f, row) in matrix(Transfer::ProlongCell, n, coarse, periodic)
            .iter()
            .enumerate()
        {
            assert!(
                (row.iter().sum::<f64>() - 1.0).abs() < 1e-12,
                "a constant at cell {f} of {n}"
            );
        }
        let faces = matrix(Transfer::ProlongFace, n, coarse, periodic);
        if periodic {
            assert!(
                faces
                    .iter()
                    .all(|row| (row.iter().sum::<f64>() - 1.0).abs() < 1e-12),
                "a constant on the {n} faces of a circle"
            );
            continue;
        }
        // A roof with its ridge on a coarse face, 0 on both walls, is linear between coarse faces.
        let ridge = coarse / 2;
        let roof = |x: f64| (x / ridge as f64).min((coarse as f64 - x) / (coarse - ridge) as f64);
        let fine = apply(&faces, &(0..coarse).map(|i| roof(i as f64)).collect::<Vec<_>>());
        let error = largest(
            fine.iter()
                .enumerate()
                .map(|(f, x)| x - roof(f as f64 * coarse as f64 / n as f64)),
        );
        assert!(error < 1e-9, "a roof on {n} faces is off by {error:e}");
    }
}

#[test]
fn collecting_is_the_scaled_transpose_of_prolongation() {
    for (n, coarse, periodic) in sizes() {
        for (collect, prolong) in [
            (Transfer::CollectCell, Transfer::ProlongCell),
            (Transfer::CollectFace, Transfer::ProlongFace),
        ] {
            let (down, up) = (
                matrix(collect, n, coarse, periodic),
                matrix(prolong, n, coarse, periodic),
            );
            for (c, row) in down.iter().enumerate() {
                for (f, weight) in row.iter().enumerate() {
                    let expected = up[f][c] * coarse as f64 / n as f64;
                    assert!(
                        (weight - expected).abs() < 1e-12,
                        "{collect:?} {c} from {f} at n = {n}: {weight} for {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn restriction_of_cells_is_a_mean_that_keeps_the_sum() {
    for (n, coarse, periodic) in sizes() {
        let down = matrix(Transfer::RestrictCell, n, coarse, periodic);
        assert!(
            down.iter()
                .all(|row| (row.iter().sum::<f64>() - 1.0).abs() < 1e-12),
            "rows at n = {n}"
        );
        for f in 0..n {
            let column: f64 = down.iter().map(|row| row[f]).sum();
            assert!(
                (column - coarse as f64 / n as f64).abs() < 1e-12,
                "column {f} at n = {n}"
            );
        }
    }
}

/// A vector field passed down one level by the core, as the solution of STFAS is.
fn restricted(levels: &Levels<'_, f64>, level: usize, v: &Components<f64>) -> Components<f64> {
    let (source, target) = (&levels.grids[level], &levels.grids[level + 1]);
    let step = Move {
        tables: &levels.tables[level],
        source,
        target,
        cell: Transfer::RestrictCell,
        face: Transfer::RestrictFace,
    };
    let (mut out, mut work) = (zeros::<f64>(target, 1), vec![0.0; source.n[0]]);
    for axis in 0..source.dims {
        for (row, out) in out[axis].chunks_exact_mut(target.n[0]).enumerate() {
            let field = Placed {
                place: Place::Face(axis),
                values: &v[axis],
            };
            let block = Block {
                grid: target,
                slots: 1,
                first: 0,
                count: 1,
            };
            step.add_row(field, &block, row, 1.0, out, &mut work);
        }
    }
    out
}

#[test]
fn restriction_keeps_flows_free_of_divergence() {
    let mut random = Random::new(11);
    for (cells, ends) in [
        (&[16, 16][..], "ww"),
        (&[33, 47], "ww"),
        (&[33, 47], "pp"),
        (&[50, 7], "wp"),
        (&[12, 9, 7], "www"),
        (&[5, 8, 11], "pwp"),
    ] {
        let finest: Grid = grid(cells, ends);
        let mut memory = Memory::new(1 << 22);
        let levels = Levels::<f64>::carve(&mut Arena::new(memory.block()), &finest, 0).unwrap();
        let mut v: Components<f64> = flow::rough(&mut random, &finest, 1, 1.0);
        for level in 0..levels.tables.len() {
            let coarse = restricted(&levels, level, &v);
            let grid = &levels.grids[level + 1];
            let (divergence, speed) = (largest(Naive::new(grid).divergence(&coarse)), largest_of(&coarse));
            assert!(
                divergence <= 1e-11 * speed.max(1e-3) / grid.h[0],
                "{cells:?} {ends} level {level}: {divergence:e}"
            );
            assert!(level > 0 || speed > 0.0);
            v = coarse;
        }
    }
}

/// Solid cells of a coarser grid are those all of whose cells are solid, its closed faces those that restriction makes of closed ones alone; so
/// a flow around solids stays one.
#[test]
fn coarser_grids_close_what_is_closed_throughout() {
    let mut random = Random::new(71);
    for (cells, ends) in [
        (&[16, 12][..], "ww"),
        (&[13, 10], "pw"),
        (&[9, 11], "wp"),
        (&[8, 7, 9], "wpw"),
    ] {
        let finest = grid(cells, ends);
        let solid: Vec<bool> = places(&finest)
            .map(|at| at[0] / 4 % 2 == 1 || random.unit() < 0.3)
            .collect();
        let mut memory = Memory::new(1 << 20);
        let mut levels = Levels::<f64>::bare(&finest, 0).with_surfaces(Surfaces {
            obstacles: true,
            stick: false,
        });
        levels.fill(&mut Arena::new(memory.block())).unwrap();
        levels.set_solids(&Alone, |cell| solid[cell]);
        for (level, pair) in levels.grids.windows(2).enumerate() {
            let (fine, coarse) = (&pair[0], &pair[1]);
            let bits = |level: usize, grid: &Grid, at: [usize; 3]| {
                levels.solids(level).row(grid.n[0], grid.row(at[1], at[2]))[at[0]]
            };
            let sources = |at: [usize; 3], own: Option<usize>| -> Vec<[usize; 3]> {
                let along = |axis: usize| -> Vec<usize> {
                    if axis >= fine.dims {
                        return vec![0];
                    }
                    let transfer = if own == Some(axis) {
                        Transfer::RestrictFace
                    } else {
                        Transfer::RestrictCell
                    };
                    let taps = taps(transfer, at[axis], fine.axis(axis), coarse.axis(axis));
                    taps.iter().map(|tap| tap.0).collect()
                };
                let [x, y, z] = [0, 1, 2].map(along);
                let rows = z.iter().flat_map(|&z| y.iter().map(move |&y| (y, z)));
                rows.flat_map(|(y, z)| x.iter().map(move |&x| [x, y, z]))
                    .collect()
            };
            for at in places(coarse) {
                let all_solid = sources(at, None)
                    .into_iter()
                    .all(|at| bits(level, fine, at) & SOLID != 0);
                assert_eq!(
                    bits(level + 1, coarse, at) & SOLID != 0,
                    all_solid,
                    "{cells:?} {at:?}"
                );
                for axis in 0..coarse.dims {
                    if coarse.beside(at, axis, Side::Low).is_none() {
                        continue;
                    }
                    let all_closed = sources(at, Some(axis))
                        .into_iter()
                        .all(|at| bits(level, fine, at) & closed(axis) != 0);
                    let found = bits(level + 1, coarse, at) & closed(axis) != 0;
                    assert_eq!(found, all_closed, "{cells:?}, face {at:?} of axis {axis}");
                }
            }
        }
    }
}
