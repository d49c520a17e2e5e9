//! The residual of the Navier-Stokes problem, against a plain second implementation.

use crate::fields;
use crate::fields::random::Random;
use crate::fields::spacetime::{Case, setup, trajectories, trajectory};
use crate::fields::{Components, gap, grid, largest};
use crate::nso_cases::{Both, IN_2D, IN_3D, SLOTS, SOLIDS, grids};
use thurible_core::field::Block;
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::level::System;
use thurible_core::nso::residual::{Rows, of_block, rows_of, work_len};
use thurible_core::nso::surroundings::Surroundings;
use thurible_core::nso::{Norm, NsoParams, Setup};
use thurible_core::{D2, D3, Real, Serial, Space};

/// All residuals of the core, in the order a, c (by component), b, d, as trajectories.
fn found<T: Real, S: Space>(system: &System<'_, T>) -> [Vec<T>; 8] {
    let grid = system.grid;
    let mut all: [Vec<T>; 8] = core::array::from_fn(|i| {
        if i % 3 < grid.dims || i >= 6 {
            vec![T::ZERO; grid.cells() * SLOTS]
        } else {
            Vec::new()
        }
    });
    for row in 0..grid.rows() {
        for block in Block::all(grid, SLOTS) {
            let mut numbers = vec![T::from_f64(f64::NAN); rows_of::<S>() * block.len()];
            let mut rows = Rows::new::<S>(block.len(), &mut numbers);
            of_block::<T, S>(
                system,
                &block,
                row,
                &mut rows,
                &mut vec![T::from_f64(f64::NAN); work_len(&block)],
            );
            for (all, row_of) in all.iter_mut().zip(rows.list()).filter(|(all, _)| !all.is_empty()) {
                all[block.span(row)].copy_from_slice(row_of);
            }
        }
    }
    all
}

fn residual_agrees<T: Real, S: Space>(list: &[(&[usize], &str)]) {
    let mut random = Random::new(61);
    let cases = list
        .iter()
        .flat_map(|(cells, ends)| grids(cells, ends))
        .flat_map(|grid| [(grid, false), (grid, true)])
        .flat_map(|(grid, coarse)| SOLIDS.map(|solid| (grid, coarse, solid)));
    for (grid, coarse, solid) in cases {
        let viscosity = if coarse { 0.2 * grid.h[0] * grid.h[0] } else { 0.0 };
        let both = Both::<T>::new::<S>(&mut random, &grid, 0.7, 2.0, viscosity, coarse, solid);
        let (found, expected) = (
            found::<T, S>(&both.system(Surroundings::new(2.0, 1.0), LocalDamping::NONE)),
            both.equations.residual(),
        );
        let [a, c]: [Components<f64>; 2] = [&expected.a, &expected.c].map(|x| trajectories(&grid, x));
        let list = a
            .iter()
            .chain(&c)
            .cloned()
            .chain([trajectory(&grid, &expected.b), trajectory(&grid, &expected.d)]);
        for (i, (found, expected)) in found.iter().zip(list).enumerate() {
            let error = gap(&fields::cast(found), &expected);
            let scale = T::EPSILON * (1.0 + largest(expected.iter().copied()));
            assert!(
                error <= 60.0 * scale,
                "part {i} on {:?}, coarse {coarse}, solids {}: off by {error:e}",
                grid.n,
                solid.is_some()
            );
        }
    }
}

#[test]
fn residual_of_every_equation() {
    residual_agrees::<f64, D2>(&IN_2D);
    residual_agrees::<f64, D3>(&IN_3D);
    residual_agrees::<f32, D2>(&IN_2D);
    residual_agrees::<f32, D3>(&IN_3D);
}

#[test]
fn norm_counts_all_four_equations() {
    let mut random = Random::new(62);
    for ((cells, ends), norm) in IN_2D
        .into_iter()
        .flat_map(|g| [(g, Norm::Scaled), (g, Norm::Plain)])
    {
        let grid = grid(cells, ends);
        let mut case = Case::<f64>::random(&mut random, &grid, SLOTS, 0.5 * grid.h[0]);
        let expected =
            case.equations(0.3, 0.0)
                .residual()
                .norm(if norm == Norm::Plain { 1.0 } else { grid.h[0] });
        let setup = Setup {
            params: NsoParams {
                norm,
                ..NsoParams::default()
            },
            ..setup(0.3, SLOTS)
        };
        let found = case.run::<D2, _>(&setup, |nso| nso.residual(&Serial));
        assert!(
            (found - expected).abs() <= 1e-12 * expected,
            "{norm:?} on {cells:?} {ends}: {found} against {expected}"
        );
    }
}
