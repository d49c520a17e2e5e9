//! The projection: the pressure whose gradient takes the divergence out, by Gauss-Seidel or by conjugate gradients, and its adjoint.
//!
//! ```text
//! div_i = -(1/(2M)) sum_a (v_a[i+e_a] - v_a[i-e_a]),   2d p - (neighbours of p) = div,   v_a -= (M/2) (p[i+e_a] - p[i-e_a])
//! ```

use super::cells::Cells;
use super::conjugate::{self, Frame, Stopping, Tape, Work};
use super::params::Adjoint;
use super::relax::System;
use super::sweeps::Sweeps;
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::grid::Grid;
use crate::real::Real;

/// How the pressure is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solve {
    /// By so many sweeps.
    Sweeps(usize),
    /// By conjugate gradients.
    Conjugate(Stopping, Adjoint),
}

/// The fields that a projection works in, beside those that it changes.
pub struct Room<'a, T> {
    /// What is on the way and given back as it likes: room for [`Sweeps`], and for three padded fields at its end.
    pub fields: &'a mut [T],
    /// Of conjugate gradients: the direction, its image, a copy.
    pub conjugate: [&'a mut [T]; 3],
    /// Of its exact adjoint.
    pub tape: Tape<'a, T>,
    /// A sum of each row.
    pub sums: &'a mut [f64],
}

/// The three fields at the end of the room.
fn last_three<'r, T>(cells: &Cells, fields: &'r mut [T]) -> [&'r mut [T]; 3] {
    let pitch = fields.len() / (cells.dims + 3);
    let mut rest = fields.get_mut(cells.dims * pitch..).unwrap_or_default();
    [(); 3].map(|()| {
        let (field, behind) = core::mem::take(&mut rest)
            .split_at_mut_checked(pitch)
            .unwrap_or_default();
        rest = behind;
        field.get_mut(..cells.padded).unwrap_or_default()
    })
}

fn pressure(cells: &Cells, sweeps: usize, backwards: bool) -> System {
    System {
        a: 1.0,
        c: 2.0 * cells.dims as f64,
        component: None,
        sweeps,
        backwards,
    }
}

/// The divergence of a row.
fn divergence<'v, T: Real>(
    cells: &'v Cells,
    v: Vector<'v, T>,
    row: usize,
) -> impl Iterator<Item = T> + use<'v, T> {
    let span = cells.row(row);
    let pairs: [[&[T]; 2]; 3] = core::array::from_fn(|axis| {
        v.get(axis)
            .filter(|v| !v.is_empty())
            .map_or([&[][..]; 2], |v| cells.beside(v, &span, axis))
    });
    let factor = T::from_f64(-0.5 / cells.longest as f64);
    let [[xl, xh], [yl, yh], [zl, zh]] = pairs;
    (0..cells.n[0]).map(move |x| {
        let at = |field: &[T]| field.get(x).copied().unwrap_or(T::ZERO);
        factor * ((at(xh) - at(xl)) + (at(yh) - at(yl)) + (at(zh) - at(zl)))
    })
}

/// Projects `v`, whose ghosts are filled, and fills them again. With conjugate gradients the divergence is left in `kept`, where there is such a field.
pub fn project<T: Real>(
    exec: &dyn Exec,
    (cells, grid): (&Cells, &Grid),
    solve: Solve,
    v: &mut VectorMut<'_, T>,
    room: &mut Room<'_, T>,
    kept: &mut [T],
) {
    let p = match solve {
        Solve::Sweeps(sweeps) => {
            let mut solver = Sweeps::new(cells, room.fields);
            let v = view(v);
            solver.solve(exec, &pressure(cells, sweeps, false), false, |row| {
                divergence(cells, v, row)
            });
            solver.into_padded(exec)
        }
        Solve::Conjugate(stopping, _) => {
            let [p, div, r] = last_three(cells, room.fields);
            let flow = view(v);
            cells.for_rows(exec, [&mut *div], |row, [div]| {
                div.iter_mut()
                    .zip(divergence(cells, flow, row))
                    .for_each(|(div, value)| *div = value);
            });
            if kept.len() == cells.padded {
                kept.copy_from_slice(div);
            }
            let sums = &mut *room.sums;
            let mut frame = Frame { cells, grid, sums };
            let [direction, q, _] = room.conjugate.each_mut();
            let work = Work { r, p: direction, q };
            conjugate::solve(exec, &mut frame, stopping, div, Some(&mut *p), work, None);
            p
        }
    };
    cells.set_bnd(None, p);
    take_gradient(exec, cells, p, v);
    for (axis, v) in v.iter_mut().enumerate().take(cells.dims) {
        cells.set_bnd(Some(axis), v);
    }
}

/// v_a -= (M/2) (p[i+e_a] - p[i-e_a]).
fn take_gradient<T: Real>(exec: &dyn Exec, cells: &Cells, p: &[T], v: &mut VectorMut<'_, T>) {
    let half = T::from_f64(0.5 * cells.longest as f64);
    cells.for_rows(exec, reborrow(v), |row, v| {
        let span = cells.row(row);
        for (axis, v) in v.into_iter().enumerate().take(cells.dims) {
            let [low, high] = cells.beside(p, &span, axis);
            crate::field::rows::add_difference(v, -half, high, low);
        }
    });
}

/// The adjoint of [`project`], in place; ghosts of `v` hold what ghosts of the velocity before it get. `kept` is the divergence that was left.
pub fn project_adjoint<T: Real>(
    exec: &dyn Exec,
    (cells, grid): (&Cells, &Grid),
    solve: Solve,
    v: &mut VectorMut<'_, T>,
    room: &mut Room<'_, T>,
    kept: &[T],
) {
    for (axis, v) in v.iter_mut().enumerate().take(cells.dims) {
        cells.set_bnd_adjoint(Some(axis), v);
    }
    let div = match solve {
        Solve::Sweeps(sweeps) => {
            let mut solver = Sweeps::new(cells, room.fields);
            gather_pressure(exec, cells, view(v), solver.given());
            solver.solve_given(exec, &pressure(cells, sweeps, true));
            solver.into_padded(exec)
        }
        Solve::Conjugate(stopping, adjoint) => {
            let [p, div, r] = last_three(cells, room.fields);
            gather_pressure(exec, cells, view(v), p);
            let sums = &mut *room.sums;
            let mut frame = Frame { cells, grid, sums };
            let [direction, q, copy] = room.conjugate.each_mut();
            if adjoint == Adjoint::SecondSolve {
                let work = Work { r, p: direction, q };
                conjugate::solve(exec, &mut frame, stopping, p, Some(&mut *div), work, None);
                div
            } else {
                let again = Work {
                    r: &mut *r,
                    p: copy,
                    q,
                };
                let done = conjugate::solve(
                    exec,
                    &mut frame,
                    stopping,
                    kept,
                    None,
                    again,
                    Some(&mut room.tape),
                );
                let work = Work {
                    r: &mut *r,
                    p: direction,
                    q,
                };
                conjugate::adjoint(exec, &mut frame, done, p, work, copy, &room.tape);
                r
            }
        }
    };
    give_divergence(exec, cells, div, v);
}

/// What p gets from -(M/2) (p[i+e_a] - p[i-e_a]) being added to v_a, its ghosts given back to its cells. Ghosts of `v` hold 0.
fn gather_pressure<T: Real>(exec: &dyn Exec, cells: &Cells, v: Vector<'_, T>, p: &mut [T]) {
    let half = T::from_f64(0.5 * cells.longest as f64);
    p.fill(T::ZERO);
    cells.for_rows(exec, [&mut *p], |row, [p]| {
        let span = cells.row(row);
        for (axis, v) in v.iter().enumerate().take(cells.dims) {
            let [low, high] = cells.beside(v, &span, axis);
            crate::field::rows::add_difference(p, half, high, low);
        }
    });
    for (axis, v) in v.iter().enumerate().take(cells.dims) {
        cells.faces(axis, |ghost, beside, behind| {
            if let (Some(p), Some(&v)) = (p.get_mut(ghost), v.get(beside)) {
                *p += if behind { -half * v } else { half * v };
            }
        });
    }
    cells.set_bnd_adjoint(None, p);
}

/// What v_a gets from div: (1/(2M)) (div[j+e_a] - div[j-e_a]), where there is no div in ghosts, which are written over.
fn give_divergence<T: Real>(exec: &dyn Exec, cells: &Cells, div: &mut [T], v: &mut VectorMut<'_, T>) {
    let factor = T::from_f64(0.5 / cells.longest as f64);
    for axis in 0..cells.dims {
        cells.faces(axis, |ghost, _, _| {
            if let Some(ghost) = div.get_mut(ghost) {
                *ghost = T::ZERO;
            }
        });
    }
    let div = &*div;
    cells.for_rows(exec, reborrow(v), |row, v| {
        let span = cells.row(row);
        for (axis, v) in v.into_iter().enumerate().take(cells.dims) {
            let [low, high] = cells.beside(div, &span, axis);
            crate::field::rows::add_difference(v, factor, high, low);
        }
    });
    for (axis, v) in v.iter_mut().enumerate().take(cells.dims) {
        cells.faces(axis, |ghost, beside, behind| {
            if let (Some(v), Some(&div)) = (v.get_mut(ghost), div.get(beside)) {
                *v += if behind { -factor * div } else { factor * div };
            }
        });
    }
}
