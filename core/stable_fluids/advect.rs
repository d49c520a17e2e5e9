//! Semi-Lagrangian advection (Stam 1999): d_i = d0 at X, X_a = i_a - M v_a(i), interpolated linearly along each axis.
//!
//! On wall axes X is clamped to the outermost centres' half cells, [1/2, n + 1/2]; on periodic ones it is wrapped. The adjoint takes the branch
//! that the forward step took: no derivative by the velocity along an axis whose X was clamped.

use super::cells::Cells;
use crate::exec::Exec;
use crate::field::Vector;
use crate::real::Real;

/// Numbers of a trace that do not depend on the cell.
#[derive(Clone, Copy)]
pub(super) struct Tracer<T, const D: usize> {
    /// M.
    pub scale: T,
    /// n, 1/2 and n + 1/2 along each axis.
    ends: [[T; 2]; D],
    ring: [bool; D],
    pub stride: [usize; D],
}

/// Where a cell comes from.
#[derive(Clone, Copy)]
pub(super) struct Trace<T, const D: usize> {
    /// The lowest of the corners around it.
    pub base: usize,
    /// How far it is from there along each axis, in cells.
    pub s: [T; D],
    /// Whether it was not clamped.
    pub free: [bool; D],
}

impl<T: Real, const D: usize> Tracer<T, D> {
    pub(super) fn new(cells: &Cells) -> Self {
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
    pub(super) fn trace(&self, at: [T; D], v: [T; D]) -> Trace<T, D> {
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
    pub(super) fn corner(&self, trace: &Trace<T, D>, corner: usize) -> (usize, T) {
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
    pub(super) fn slope(&self, trace: &Trace<T, D>, corner: usize, axis: usize) -> T {
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
        // What is farther away than can be counted ends at the edge, whatever this gives.
        whole.wrapping_sub(1)
    } else {
        whole
    };
    T::from_f64(f64::from(whole_below))
}

/// Calls `each` for the cells of a row, with their places in the row from 0, in a padded field, and their traces.
#[inline(always)]
pub(super) fn for_row<T: Real, const D: usize>(
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
