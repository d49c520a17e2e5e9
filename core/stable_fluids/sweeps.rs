//! Gauss-Seidel as the solver of a step, and its adjoint, in the fields of its room.

use super::cells::{Cells, Component};
use super::relax::{System, relax};
use super::skew::Skew;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::real::Real;

/// A field that is relaxed, and its right-hand side, both by diagonals.
pub struct Sweeps<'a, T> {
    cells: &'a Cells,
    skew: Skew,
    x: &'a mut [T],
    b: &'a mut [T],
}

impl<'a, T: Real> Sweeps<'a, T> {
    /// In the first numbers of a room.
    pub fn new(cells: &'a Cells, room: &'a mut [T]) -> Self {
        let skew = Skew::new(cells);
        let len = skew.len(cells);
        let (x, rest) = room.split_at_mut_checked(len).unwrap_or_default();
        let b = rest.get_mut(..len).unwrap_or_default();
        Self { cells, skew, x, b }
    }

    /// Where a padded right-hand side may be put for [`Self::solve_given`].
    pub fn given(&mut self) -> &mut [T] {
        self.x.get_mut(..self.cells.padded).unwrap_or_default()
    }

    /// Solves from 0 with the right-hand side that is in [`Self::given`].
    pub fn solve_given(&mut self, exec: &dyn Exec, system: &System) {
        let Self { cells, skew, x, b } = self;
        let (cells, skew, given) = (*cells, *skew, &**x);
        let of = |row| given.get(cells.row(row)).unwrap_or_default().iter().copied();
        lay_out(exec, cells, skew, T::from_f64(1.0 / system.c), b, of);
        x.fill(T::ZERO);
        relax(exec, cells, system, x, b);
    }

    /// Solves from 0, or from the right-hand side itself, which `of` tells row by row.
    pub fn solve<I: Iterator<Item = T>>(
        &mut self,
        exec: &dyn Exec,
        system: &System,
        from_itself: bool,
        of: impl Fn(usize) -> I + Sync,
    ) {
        let Self { cells, skew, x, b } = self;
        x.fill(T::ZERO);
        if from_itself {
            lay_out(exec, cells, *skew, T::ONE, x, &of);
        }
        lay_out(exec, cells, *skew, T::from_f64(1.0 / system.c), b, of);
        relax(exec, cells, system, x, b);
    }

    /// The rows of the solution, into the cells of a padded field.
    pub fn read_into(&self, exec: &dyn Exec, out: &mut [T]) {
        self.cells.for_rows(exec, [out], |row, [out]| {
            out.iter_mut()
                .zip(self.skew.read(self.cells, self.x, row))
                .for_each(|(out, value)| *out = value);
        });
    }

    /// The solution as a padded field without ghosts' values, in the place of the right-hand side.
    pub fn into_padded(self, exec: &dyn Exec) -> &'a mut [T] {
        let Self { cells, skew, x, b } = self;
        let out = b.get_mut(..cells.padded).unwrap_or_default();
        let x = &*x;
        cells.for_rows(exec, [&mut *out], |row, [out]| {
            out.iter_mut()
                .zip(skew.read(cells, x, row))
                .for_each(|(out, value)| *out = value);
        });
        out
    }
}

/// Writes `factor` times the rows that `of` tells into a field by diagonals.
fn lay_out<T: Real, I: Iterator<Item = T>>(
    exec: &dyn Exec,
    cells: &Cells,
    skew: Skew,
    factor: T,
    field: &mut [T],
    of: impl Fn(usize) -> I + Sync,
) {
    // In 3D the first plane and the last are ghosts.
    let ghosts = usize::from(cells.dims == 3);
    for_rows(
        exec,
        cells.n[2] + 2 * ghosts,
        RowBuffers::fields([field]),
        |task| {
            let [plane] = task.fields;
            let Some(z) = task.row.checked_sub(ghosts).filter(|&z| z < cells.n[2]) else {
                return;
            };
            for y in 0..cells.n[1] {
                skew.write(plane, y, of(z * cells.n[1] + y).map(|value| factor * value));
            }
        },
    );
}

/// Numbers of a diffusion: a = k M^2.
fn diffusion(cells: &Cells, k: f64, component: Component, sweeps: usize, backwards: bool) -> System {
    let longest = cells.longest as f64;
    let a = k * longest * longest;
    System {
        a,
        c: 1.0 + 2.0 * cells.dims as f64 * a,
        component,
        sweeps,
        backwards,
    }
}

/// Diffuses a padded field in place and fills its ghosts.
pub fn diffuse<T: Real>(
    exec: &dyn Exec,
    cells: &Cells,
    (k, sweeps): (f64, usize),
    component: Component,
    field: &mut [T],
    room: &mut [T],
) {
    if k > 0.0 {
        let system = diffusion(cells, k, component, sweeps, false);
        let mut solver = Sweeps::new(cells, room);
        let from = &*field;
        solver.solve(exec, &system, true, |row| {
            from.get(cells.row(row)).unwrap_or_default().iter().copied()
        });
        solver.read_into(exec, field);
    }
    cells.set_bnd(component, field);
}

/// The adjoint of [`diffuse`], in place: with Y what the right-hand side gets from the sweeps, the field that they began with gets
/// S - M Y, and both were the same field.
pub fn diffuse_adjoint<T: Real>(
    exec: &dyn Exec,
    cells: &Cells,
    (k, sweeps): (f64, usize),
    component: Component,
    field: &mut [T],
    room: &mut [T],
) {
    cells.set_bnd_adjoint(component, field);
    if k == 0.0 {
        return;
    }
    let system = diffusion(cells, k, component, sweeps, true);
    let mut solver = Sweeps::new(cells, room);
    let from = &*field;
    solver.solve(exec, &system, false, |row| {
        from.get(cells.row(row)).unwrap_or_default().iter().copied()
    });
    let y = solver.into_padded(exec);
    cells.set_bnd(component, y);
    let y = &*y;
    let [a, own] = [system.a, 1.0 - system.c].map(T::from_f64);
    cells.for_rows(exec, [field], |row, [field]| {
        let span = cells.row(row);
        let here = y.get(span.clone()).unwrap_or_default();
        field.iter_mut().zip(here).for_each(|(s, &y)| *s += own * y);
        for axis in 0..cells.dims {
            let [low, high] = cells.beside(y, &span, axis);
            field
                .iter_mut()
                .zip(low.iter().zip(high))
                .for_each(|(s, (&low, &high))| *s += a * (low + high));
        }
    });
}
