//! One level of STFAS: its grid, solution and right-hand side.

use super::damping::LocalDamping;
use super::surroundings::Surroundings;
use crate::exec::Exec;
use crate::field::transfer::Place;
use crate::field::{Vector, VectorMut, borders, view};
use crate::grid::solids::Solids;
use crate::grid::{Grid, Space};
use crate::memory::Pool;
use crate::real::Real;
use core::ops::Range;

/// The unknowns of slots 1..T on one grid, all trajectories.
#[derive(Debug, Default)]
pub struct State<'a, T> {
    /// Velocities v_k at faces.
    pub v: VectorMut<'a, T>,
    /// Forces w_k that produce them, at faces.
    pub w: VectorMut<'a, T>,
    /// Pressures p_k at cells, of equation c.
    pub p: &'a mut [T],
    /// Pressures pbar_k at cells, of equation a.
    pub pbar: &'a mut [T],
}

/// Right-hand sides of the equations a to d; an empty slice stands for zeros.
#[derive(Clone, Copy, Debug)]
pub struct Rhs<'a, T> {
    /// Factor of `a`: on the finest grid `a` is the target and this kappa, elsewhere 1.
    pub scale: T,
    /// Equation a, at faces.
    pub a: Vector<'a, T>,
    /// Equation b, at cells.
    pub b: &'a [T],
    /// Equation c, at faces.
    pub c: Vector<'a, T>,
    /// Equation d, at cells.
    pub d: &'a [T],
}

/// The discrete Navier-Stokes problem of one level (paper eq. 13), to read.
#[derive(Clone, Copy, Debug)]
pub struct System<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// The solid cells in it.
    pub solids: Solids<'a>,
    /// The row that the fields begin with: 0 unless they are a part of the grid's rows.
    pub first: usize,
    /// Slots T.
    pub slots: usize,
    /// K / r.
    pub kappa: T,
    /// nu.
    pub viscosity: T,
    /// What the smoother's blocks know beyond their cells.
    pub surroundings: Surroundings<T>,
    /// Where the smoother damps.
    pub damping: LocalDamping<T>,
    /// Velocities.
    pub v: Vector<'a, T>,
    /// Forces.
    pub w: Vector<'a, T>,
    /// Pressures of equation c.
    pub p: &'a [T],
    /// Pressures of equation a.
    pub pbar: &'a [T],
    /// The given velocity before slot 1.
    pub v0: Vector<'a, T>,
    /// Right-hand sides.
    pub rhs: Rhs<'a, T>,
    /// The smoother's bases, see [`super::local::fill_table`].
    pub table: &'a [T],
}

/// One level, to write.
#[derive(Debug)]
pub struct LevelMut<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// The solid cells in it.
    pub solids: Solids<'a>,
    /// The unknowns.
    pub state: State<'a, T>,
    /// The given velocity before slot 1, a field of one slot.
    pub v0: VectorMut<'a, T>,
    /// Right-hand side of equation a.
    pub a: VectorMut<'a, T>,
    /// Factor of `a`.
    pub scale: T,
    /// Right-hand side of equation b, empty on the finest level.
    pub b: &'a mut [T],
    /// Right-hand side of equation c; on the finest level buoyancy, along the axes that have any.
    pub c: VectorMut<'a, T>,
    /// Right-hand side of equation d, empty on the finest level.
    pub d: &'a mut [T],
    /// The smoother's bases.
    pub table: &'a [T],
}

/// The coefficients of the equations, the same on all levels.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients<T> {
    /// Slots T.
    pub slots: usize,
    /// K / r.
    pub kappa: T,
    /// nu.
    pub viscosity: T,
    /// What the smoother's blocks know beyond their cells.
    pub surroundings: Surroundings<T>,
    /// Where the smoother damps.
    pub damping: LocalDamping<T>,
}

impl<'a, T: Real> LevelMut<'a, T> {
    /// A coarse level, in elements of a pool.
    pub fn coarse<S: Space>(
        (grid, solids): (&'a Grid, Solids<'a>),
        table: &'a [T],
        slots: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let len = grid.cells() * slots;
        Self {
            grid,
            solids,
            state: State {
                v: pool.take_vector("v", S::DIM, len),
                w: pool.take_vector("w", S::DIM, len),
                p: pool.take("p", len),
                pbar: pool.take("pbar", len),
            },
            v0: pool.take_vector("v_0", S::DIM, grid.cells()),
            a: pool.take_vector("right-hand side a", S::DIM, len),
            scale: T::ONE,
            b: pool.take("right-hand side b", len),
            c: pool.take_vector("right-hand side c", S::DIM, len),
            d: pool.take("right-hand side d", len),
            table,
        }
    }

    /// The level's equations, to read.
    pub fn system(&self, coefficients: &Coefficients<T>) -> System<'_, T> {
        System {
            rhs: Rhs {
                scale: self.scale,
                a: view(&self.a),
                b: self.b,
                c: view(&self.c),
                d: self.d,
            },
            ..left_hand_side(
                (self.grid, self.solids),
                coefficients,
                &self.state,
                &self.v0,
                self.table,
            )
        }
    }

    /// The level's left-hand sides, to read, and its right-hand sides, to write: a, c by component, b and d.
    pub(super) fn sides(&mut self, coefficients: &Coefficients<T>) -> (System<'_, T>, [&mut [T]; 8]) {
        let left = left_hand_side(
            (self.grid, self.solids),
            coefficients,
            &self.state,
            &self.v0,
            self.table,
        );
        let [a0, a1, a2] = self.a.each_mut().map(|c| &mut **c);
        let [c0, c1, c2] = self.c.each_mut().map(|c| &mut **c);
        (left, [a0, a1, a2, c0, c1, c2, self.b, self.d])
    }
}

/// The equations with 0 on the right.
fn left_hand_side<'a, T: Real>(
    (grid, solids): (&'a Grid, Solids<'a>),
    coefficients: &Coefficients<T>,
    state: &'a State<'_, T>,
    v0: &'a VectorMut<'_, T>,
    table: &'a [T],
) -> System<'a, T> {
    System {
        grid,
        solids,
        first: 0,
        slots: coefficients.slots,
        kappa: coefficients.kappa,
        viscosity: coefficients.viscosity,
        surroundings: coefficients.surroundings,
        damping: coefficients.damping,
        v: view(&state.v),
        w: view(&state.w),
        p: state.p,
        pbar: state.pbar,
        v0: view(v0),
        rhs: Rhs {
            scale: T::ONE,
            a: [&[]; 3],
            b: &[],
            c: [&[]; 3],
            d: &[],
        },
        table,
    }
}

impl<'a, T: Real> System<'a, T> {
    /// The equations of some `rows` of all, with these unknowns of them, in the order of [`State::fields`].
    #[must_use]
    pub fn of_rows(&self, rows: Range<usize>, state: [&'a [T]; 8]) -> Self {
        let Self { grid, slots, rhs, .. } = *self;
        let [v0, v1, v2, w0, w1, w2, p, pbar] = state;
        let part = |field: &'a [T], slots: usize| {
            let part = field.get(rows.start * slots * grid.n[0]..rows.end * slots * grid.n[0]);
            debug_assert!(part.is_some() || field.is_empty());
            part.unwrap_or(field)
        };
        let rhs = Rhs {
            a: rhs.a.map(|a| part(a, slots)),
            b: part(rhs.b, slots),
            c: rhs.c.map(|c| part(c, slots)),
            d: part(rhs.d, slots),
            ..rhs
        };
        Self {
            first: rows.start,
            v: [v0, v1, v2],
            w: [w0, w1, w2],
            p,
            pbar,
            v0: self.v0.map(|v0| part(v0, 1)),
            rhs,
            ..*self
        }
    }
}

impl<'a, T: Real> State<'a, T> {
    /// Brings the copies up to date of what other ranks have.
    pub(super) fn refresh(&mut self, exec: &dyn Exec, grid: &Grid) {
        for velocities in [&mut self.v, &mut self.w] {
            borders::refresh_faces(exec, grid, velocities);
        }
        for pressures in [&mut *self.p, &mut *self.pbar] {
            borders::refresh(exec, grid, pressures);
        }
    }

    /// The eight components as one list: v, w, p, pbar.
    pub fn fields(&mut self) -> [&mut [T]; 8] {
        let [v0, v1, v2] = self.v.each_mut().map(|c| &mut **c);
        let [w0, w1, w2] = self.w.each_mut().map(|c| &mut **c);
        [v0, v1, v2, w0, w1, w2, self.p, self.pbar]
    }
}

/// Of the fields of [`State::fields`], how many are at faces: v and w by component.
pub(super) const FACES_OF_STATE: usize = 6;

/// Where the values of a field of [`State::fields`] are.
pub(super) fn place_of(field: usize) -> Place {
    if field < FACES_OF_STATE {
        Place::Face(field % 3)
    } else {
        Place::Cell
    }
}
