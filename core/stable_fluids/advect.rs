//! Semi-Lagrangian advection (Stam 1999) and its adjoint: d_i = d0 at X, X_a = i_a - M v_a(i), interpolated linearly along each axis.
//!
//! On wall axes X is clamped to the outermost centres' half cells, [1/2, n + 1/2]; on periodic ones it is wrapped. The adjoint takes the branch
//! that the forward step took: no derivative by the velocity along an axis whose X was clamped.

use super::cells::Cells;
use crate::exec::{Exec, Slabs, for_slabs, join};
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::real::Real;

/// Numbers of a trace that do not depend on the cell.
#[derive(Clone, Copy)]
struct Tracer<T, const D: usize> {
    /// M.
    scale: T,
    /// n, 1/2 and n + 1/2 along each axis.
    ends: [[T; 2]; D],
    ring: [bool; D],
    stride: [usize; D],
}

/// Where a cell comes from.
#[derive(Clone, Copy)]
struct Trace<T, const D: usize> {
    /// The lowest of the corners around it.
    base: usize,
    /// How far it is from there along each axis, in cells.
    s: [T; D],
    /// Whether it was not clamped.
    free: [bool; D],
}

impl<T: Real, const D: usize> Tracer<T, D> {
    fn new(cells: &Cells) -> Self {
        Self {
            scale: T::from_usize(cells.longest),
            ends: core::array::from_fn(|axis| {
                let n = cells.n.get(axis).map_or(T::ZERO, |&n| T::from_usize(n));
                [n, n + T::HALF]
            }),
            ring: core::array::from_fn(|axis| cells.ring.get(axis) == Some(&true)),
            stride: core::array::from_fn(|axis| cells.stride.get(axis).copied().unwrap_or(0)),
        }
    }

    /// Traces back the cell at `at`, counted from 1, by its velocity.
    #[inline(always)]
    fn trace(&self, at: [T; D], v: [T; D]) -> Trace<T, D> {
        let mut trace = Trace {
            base: 0,
            s: [T::ZERO; D],
            free: [true; D],
        };
        for axis in 0..D {
            let [n, end] = self.ends[axis];
            let mut x = at[axis] - self.scale * v[axis];
            if self.ring[axis] {
                x = x - n * floor((x - T::HALF) / n);
                // Rounding may leave it a little outside.
                x = clamped(x, T::HALF, end);
            } else {
                trace.free[axis] = x > T::HALF && x < end;
                x = clamped(x, T::HALF, end);
            }
            let k = x.to_f64() as i32;
            trace.s[axis] = x - T::from_f64(f64::from(k));
            trace.base += k as usize * self.stride[axis];
        }
        trace
    }

    /// The corners around a trace, with their weights.
    #[inline(always)]
    fn corner(&self, trace: &Trace<T, D>, corner: usize) -> (usize, T) {
        let (mut place, mut weight) = (trace.base, T::ONE);
        for axis in 0..D {
            if corner >> axis & 1 == 1 {
                place += self.stride[axis];
                weight = weight * trace.s[axis];
            } else {
                weight = weight * (T::ONE - trace.s[axis]);
            }
        }
        (place, weight)
    }

    /// The derivative of a corner's weight by s along `axis`.
    #[inline(always)]
    fn slope(&self, trace: &Trace<T, D>, corner: usize, axis: usize) -> T {
        let mut slope = if corner >> axis & 1 == 1 { T::ONE } else { -T::ONE };
        for other in (0..D).filter(|&other| other != axis) {
            slope = slope
                * if corner >> other & 1 == 1 {
                    trace.s[other]
                } else {
                    T::ONE - trace.s[other]
                };
        }
        slope
    }
}

#[inline(always)]
fn clamped<T: Real>(x: T, low: T, high: T) -> T {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

#[inline(always)]
fn floor<T: Real>(x: T) -> T {
    let whole = x.to_f64() as i32;
    let whole_below = if f64::from(whole) > x.to_f64() {
        whole - 1
    } else {
        whole
    };
    T::from_f64(f64::from(whole_below))
}

/// Calls `each` for the cells of a row, with their places in the row from 0, in a padded field, and their traces.
#[inline(always)]
fn for_row<T: Real, const D: usize>(
    cells: &Cells,
    tracer: &Tracer<T, D>,
    v: Vector<'_, T>,
    row: usize,
    mut each: impl FnMut(usize, usize, Trace<T, D>),
) {
    let (span, [y, z]) = (cells.row(row), cells.row_at(row));
    let along: [&[T]; D] =
        core::array::from_fn(|axis| v.get(axis).and_then(|v| v.get(span.clone())).unwrap_or_default());
    let mut at: [T; D] = core::array::from_fn(|axis| T::from_usize(if axis == 1 { y + 1 } else { z + 1 }));
    for x in 0..cells.n[0] {
        at[0] = T::from_usize(x + 1);
        let here: [T; D] = core::array::from_fn(|axis| along[axis].get(x).copied().unwrap_or(T::ZERO));
        each(x, span.start + x, tracer.trace(at, here));
    }
}

/// `out = ` the fields `from`, carried by `v`; `from` with its ghosts, those of `out` are not written. Fields that are empty are left out.
pub fn advect<T: Real, const K: usize>(
    exec: &dyn Exec,
    cells: &Cells,
    v: Vector<'_, T>,
    from: [&[T]; K],
    out: [&mut [T]; K],
) {
    if cells.dims == 2 {
        advect_in::<T, 2, K>(exec, cells, v, from, out);
    } else {
        advect_in::<T, 3, K>(exec, cells, v, from, out);
    }
}

fn advect_in<T: Real, const D: usize, const K: usize>(
    exec: &dyn Exec,
    cells: &Cells,
    v: Vector<'_, T>,
    from: [&[T]; K],
    out: [&mut [T]; K],
) {
    let tracer = Tracer::<T, D>::new(cells);
    cells.for_rows(exec, out, |row, mut out| {
        for_row(cells, &tracer, v, row, |x, _, trace| {
            let mut sums = [T::ZERO; K];
            for corner in 0..1 << D {
                let (place, weight) = tracer.corner(&trace, corner);
                for (sum, from) in sums.iter_mut().zip(from) {
                    if let Some(&value) = from.get(place) {
                        *sum += weight * value;
                    }
                }
            }
            for (out, sum) in out.iter_mut().zip(sums) {
                if let Some(out) = out.get_mut(x) {
                    *out = sum;
                }
            }
        });
    });
}

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
    for_slabs(exec, Slabs::new(D, D, 1), [&mut tasks[..]], &mut [], |slab| {
        for (to, g) in slab.fields.into_iter().flatten() {
            for row in 0..cells.rows() {
                for_row(cells, tracer, v, row, |_, place, trace| {
                    scatter(tracer, &trace, value_at(g, place), to)
                });
            }
        }
    });
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
    let mut parts = [T::ZERO; D];
    for corner in 0..1 << D {
        let (place, _) = tracer.corner(trace, corner);
        let held = fields
            .iter()
            .fold(T::ZERO, |sum, &(g, from)| sum + g * value_at(from, place));
        for (axis, part) in parts.iter_mut().enumerate() {
            *part += tracer.slope(trace, corner, axis) * held;
        }
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
