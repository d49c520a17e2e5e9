//! Random Navier-Stokes problems, as the core reads them and slot by slot.

use crate::fields::naive::Solid;
use crate::fields::random::Random;
use crate::fields::spacetime::{Case, Equations, Residual, trajectories, trajectory};
use crate::fields::{Components, grid, places, view};
use thurible_core::exec::ranks::Alone;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::coarsen;
use thurible_core::grid::solids::{self, SOLID, Solids, Surfaces};
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::level::{Rhs, System};
use thurible_core::nso::local::{fill_table, table_len};
use thurible_core::nso::surroundings::Surroundings;
use thurible_core::{Real, Space};

pub const IN_2D: [(&[usize], &str); 6] = [
    (&[6, 6], "ww"),
    (&[7, 5], "pw"),
    (&[4, 9], "wp"),
    (&[40, 4], "pp"),
    (&[5, 5], "pp"),
    (&[4, 27], "ww"),
];

pub const IN_3D: [(&[usize], &str); 4] = [
    (&[4, 4, 4], "www"),
    (&[5, 4, 3], "pwp"),
    (&[18, 3, 4], "wpw"),
    (&[3, 5, 4], "ppp"),
];

pub const SLOTS: usize = 3;

/// The grid itself, or the next coarser one with its own cell sizes.
pub fn grids(cells: &[usize], ends: &str) -> [Grid; 2] {
    let fine = grid(cells, ends);
    [
        fine,
        coarsen(&grid(
            &cells.iter().map(|n| 2 * n - n % 2).collect::<Vec<_>>(),
            ends,
        ))
        .unwrap(),
    ]
}

/// The bits of solid cells.
pub fn bits(grid: &Grid, solid: Solid) -> Vec<u16> {
    let mut bits: Vec<u16> = places(grid)
        .map(|at| if solid(grid, at) { SOLID } else { 0 })
        .collect();
    solids::fill(&Alone, grid, &mut bits);
    bits
}

/// Right-hand sides of all four equations, random.
pub fn right_hand_sides(random: &mut Random, grid: &Grid) -> Residual {
    let vectors = |random: &mut Random| (0..SLOTS).map(|_| random.faces(grid, 1)).collect();
    let scalars = |random: &mut Random| (0..SLOTS).map(|_| random.cells(grid, 1)).collect();
    Residual {
        a: vectors(random),
        b: scalars(random),
        c: vectors(random),
        d: scalars(random),
    }
}

/// Right-hand sides a, b, c, d as trajectories.
pub type Sides<T> = (Components<T>, Vec<T>, Components<T>, Vec<T>);

/// A random problem as the core reads it and slot by slot.
pub struct Both<T> {
    pub case: Case<T>,
    pub equations: Equations,
    pub rhs: Option<Sides<T>>,
    pub table: Vec<T>,
    /// Bits of the solid cells, if there are any.
    bits: Vec<u16>,
}

/// Solid cells here and there, so that cells have all kinds of closed faces.
fn scattered(_: &Grid, [x, y, z]: [usize; 3]) -> bool {
    (5 * x + 3 * y + 7 * z).is_multiple_of(6) || (x == 1 && y == 1)
}

/// Without solids and among some.
pub const SOLIDS: [Option<Solid>; 2] = [None, Some(scattered)];

impl<T: Real> Both<T> {
    /// With right-hand sides as on a coarse grid, or with a target alone as on the finest.
    pub fn new<S: Space>(
        random: &mut Random,
        grid: &Grid,
        kappa: f64,
        speed: f64,
        viscosity: f64,
        coarse: bool,
        solid: Option<Solid>,
    ) -> Self {
        let case = Case::<T>::random(random, grid, SLOTS, speed * grid.h[0]).among(solid);
        let mut equations = case.equations(kappa, viscosity);
        let mut rhs = None;
        if coarse {
            let r = right_hand_sides(random, grid);
            rhs = Some((
                trajectories(grid, &r.a),
                trajectory(grid, &r.b),
                trajectories(grid, &r.c),
                trajectory(grid, &r.d),
            ));
            equations.rhs = r;
        }
        let mut table = vec![T::ZERO; table_len::<S>()];
        fill_table::<T, S>(grid.h, solid.is_some(), &mut table);
        Both {
            bits: solid.map_or_else(Vec::new, |solid| bits(grid, solid)),
            case,
            equations,
            rhs,
            table,
        }
    }

    pub fn system(&self, surroundings: Surroundings<f64>, damping: LocalDamping<f64>) -> System<'_, T> {
        let case = &self.case;
        let kappa = T::from_f64(self.equations.kappa);
        let rhs = match &self.rhs {
            Some((a, b, c, d)) => Rhs {
                scale: T::ONE,
                a: view(a),
                b,
                c: view(c),
                d,
            },
            None => Rhs {
                scale: kappa,
                a: view(&case.target),
                b: &[],
                c: [&[]; 3],
                d: &[],
            },
        };
        System {
            grid: &case.grid,
            solids: if self.bits.is_empty() {
                Solids::default()
            } else {
                Solids::new(
                    &self.bits,
                    Surfaces {
                        obstacles: true,
                        stick: false,
                    },
                )
            },
            first: 0,
            slots: SLOTS,
            kappa,
            viscosity: T::from_f64(self.equations.naive.viscosity),
            surroundings: surroundings.to(),
            damping: LocalDamping {
                threshold: T::from_f64(damping.threshold),
            },
            v: view(&case.v),
            w: view(&case.w),
            p: &case.p,
            pbar: &case.pbar,
            v0: view(&case.v0),
            rhs,
            table: &self.table,
        }
    }
}
