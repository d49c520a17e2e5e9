//! The adjoint of advection. It is a scatter: what is added to one number is added in the order of the cells, for any number of threads.

use super::advect::{Trace, Tracer, for_row};
use super::cells::Cells;
use crate::exec::{Exec, RowBuffers, Slabs, for_slabs, join};
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::real::Real;

/// The adjoint of the density's advection: `to += ` what `g` holds, given back to where it is from, and `by += ` its derivative by the
/// velocity. Ghosts of `g` hold 0.
pub fn density_adjoint<T: Real>(
    exec: &dyn Exec,
    cells: &Cells,
    (v, from): (Vector<'_, T>, &[T]),
    g: &[T],
    to: &mut [T],
    by: &mut VectorMut<'_, T>,
) {
    if cells.dims == 2 {
        density_adjoint_in::<T, 2>(exec, cells, (v, from), g, to, by);
    } else {
        density_adjoint_in::<T, 3>(exec, cells, (v, from), g, to, by);
    }
}

fn density_adjoint_in<T: Real, const D: usize>(
    exec: &dyn Exec,
    cells: &Cells,
    (v, from): (Vector<'_, T>, &[T]),
    g: &[T],
    to: &mut [T],
    by: &mut VectorMut<'_, T>,
) {
    let tracer = Tracer::<T, D>::new(cells);
    if exec.threads() == 1 {
        for row in 0..cells.rows() {
            for_row(cells, &tracer, v, row, |_, place, trace| {
                let g = value_at(g, place);
                scatter(&tracer, &trace, g, to);
                add_parts(by, place, slopes(&tracer, &trace, [(g, from)]));
            });
        }
        return;
    }
    let mut give = || {
        for row in 0..cells.rows() {
            for_row(cells, &tracer, v, row, |_, place, trace| {
                scatter(&tracer, &trace, value_at(g, place), to)
            });
        }
    };
    let mut derive = || {
        for row in 0..cells.rows() {
            for_row(cells, &tracer, v, row, |_, place, trace| {
                add_parts(by, place, slopes(&tracer, &trace, [(value_at(g, place), from)]));
            });
        }
    };
    join(exec, &mut give, &mut derive);
}

/// The adjoint of the velocity's advection by itself, `v`: `to += ` what `g` holds, given back to where it is from. `g` becomes the derivative
/// by the velocity that carries, which belongs to `to` as well. Ghosts of `g` hold 0.
pub fn velocity_adjoint<T: Real>(
    exec: &dyn Exec,
    cells: &Cells,
    v: Vector<'_, T>,
    g: &mut VectorMut<'_, T>,
    to: &mut VectorMut<'_, T>,
) {
    if cells.dims == 2 {
        velocity_adjoint_in::<T, 2>(exec, cells, v, g, to);
    } else {
        velocity_adjoint_in::<T, 3>(exec, cells, v, g, to);
    }
}

fn velocity_adjoint_in<T: Real, const D: usize>(
    exec: &dyn Exec,
    cells: &Cells,
    v: Vector<'_, T>,
    g: &mut VectorMut<'_, T>,
    to: &mut VectorMut<'_, T>,
) {
    let tracer = Tracer::<T, D>::new(cells);
    if exec.threads() == 1 {
        for row in 0..cells.rows() {
            for_row(cells, &tracer, v, row, |_, place, trace| {
                let here: [T; D] = core::array::from_fn(|a| g.get(a).map_or(T::ZERO, |g| value_at(g, place)));
                for (to, &g) in to.iter_mut().zip(&here) {
                    scatter(&tracer, &trace, g, to);
                }
                let parts = slopes(
                    &tracer,
                    &trace,
                    core::array::from_fn::<_, D, _>(|a| (here[a], component(v, a))),
                );
                put_parts(g, place, parts);
            });
        }
        return;
    }
    scatter_all(exec, cells, &tracer, v, view(g), to);
    cells.for_rows(exec, reborrow(g), |row, mut g| {
        for_row(cells, &tracer, v, row, |x, _, trace| {
            let fields = core::array::from_fn::<_, D, _>(|a| {
                (g.get(a).map_or(T::ZERO, |g| value_at(g, x)), component(v, a))
            });
            put_parts(&mut g, x, slopes(&tracer, &trace, fields));
        });
    });
}

/// Gives back the components, one after the other by one thread each, in the order of the cells.
fn scatter_all<T: Real, const D: usize>(
    exec: &dyn Exec,
    cells: &Cells,
    tracer: &Tracer<T, D>,
    v: Vector<'_, T>,
    g: Vector<'_, T>,
    to: &mut VectorMut<'_, T>,
) {
    let mut tasks: heapless::Vec<(&mut [T], &[T]), 3> = to
        .iter_mut()
        .zip(g)
        .take(D)
        .map(|(to, g)| (&mut **to, g))
        .collect();
    for_slabs(
        exec,
        Slabs::new(D, D, 1),
        RowBuffers::fields([&mut tasks[..]]),
        |slab| {
            for (to, g) in slab.fields.into_iter().flatten() {
                for row in 0..cells.rows() {
                    for_row(cells, tracer, v, row, |_, place, trace| {
                        scatter(tracer, &trace, value_at(g, place), to)
                    });
                }
            }
        },
    );
}

#[inline(always)]
fn value_at<T: Real>(x: &[T], place: usize) -> T {
    x.get(place).copied().unwrap_or(T::ZERO)
}

#[inline(always)]
fn component<'a, T>(v: Vector<'a, T>, axis: usize) -> &'a [T] {
    v.get(axis).copied().unwrap_or_default()
}

/// Adds what a cell holds to where it is from.
#[inline(always)]
fn scatter<T: Real, const D: usize>(tracer: &Tracer<T, D>, trace: &Trace<T, D>, g: T, to: &mut [T]) {
    for corner in 0..1 << D {
        let (place, weight) = tracer.corner(trace, corner);
        if let Some(to) = to.get_mut(place) {
            *to += weight * g;
        }
    }
}

/// The derivatives by the velocity of a cell, of fields with what their images hold.
#[inline(always)]
fn slopes<T: Real, const D: usize, const K: usize>(
    tracer: &Tracer<T, D>,
    trace: &Trace<T, D>,
    fields: [(T, &[T]); K],
) -> [T; D] {
    let held = |place: usize| {
        fields
            .iter()
            .fold(T::ZERO, |sum, &(g, from)| sum + g * value_at(from, place))
    };
    let mut parts = [T::ZERO; D];
    for corner in 0..1 << D {
        let (place, _) = tracer.corner(trace, corner);
        let held = held(place);
        for (axis, part) in parts.iter_mut().enumerate() {
            *part += tracer.slope(trace, corner, axis) * held;
        }
    }
    // Interpolation has a kink at a cell's centre, where cells at rest come from: neither side is better than the other.
    for axis in (0..D).filter(|&axis| trace.s[axis] == T::ZERO) {
        let mut below = T::ZERO;
        for corner in 0..1 << D {
            let (place, _) = tracer.corner(trace, corner);
            below += tracer.slope(trace, corner, axis) * held(place.wrapping_sub(tracer.stride[axis]));
        }
        parts[axis] = T::HALF * (parts[axis] + below);
    }
    core::array::from_fn(|axis| {
        if trace.free[axis] {
            -tracer.scale * parts[axis]
        } else {
            T::ZERO
        }
    })
}

#[inline(always)]
fn add_parts<T: Real, const D: usize>(by: &mut [&mut [T]], place: usize, parts: [T; D]) {
    for (by, part) in by.iter_mut().zip(parts) {
        if let Some(by) = by.get_mut(place) {
            *by += part;
        }
    }
}

#[inline(always)]
fn put_parts<T: Real, const D: usize>(g: &mut [&mut [T]], place: usize, parts: [T; D]) {
    for (g, part) in g.iter_mut().zip(parts) {
        if let Some(g) = g.get_mut(place) {
            *g = part;
        }
    }
}
