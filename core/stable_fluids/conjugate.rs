//! Conjugate gradients for the pressure, 2d p - (sum of the neighbours) = f, and the exact adjoint of the iterations that were done.
//!
//! The matrix is singular, since a constant pressure does nothing; right-hand sides sum to 0, and only differences of p are used.

use super::cells::Cells;
use crate::exec::Exec;
use crate::field::sums;
use crate::grid::Grid;
use crate::real::Real;
use core::ops::Range;

/// A residual of so many roundings of its right-hand side is none.
const NOISE: f64 = 16.0;

/// When iterations end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopping {
    /// At this part of the right-hand side, in the norm of the preconditioner.
    pub tolerance: f64,
    /// After so many.
    pub most: usize,
}

/// The cells, and where sums of their rows go.
pub struct Frame<'a> {
    /// The cells.
    pub cells: &'a Cells,
    /// The same without ghosts.
    pub grid: &'a Grid,
    /// A sum of each row.
    pub sums: &'a mut [f64],
}

impl Frame<'_> {
    fn total(&mut self, exec: &dyn Exec, of: impl Fn(Range<usize>, usize) -> f64 + Sync) -> f64 {
        let cells = self.cells;
        sums::total(exec, self.grid, self.sums, |row| of(cells.row(row), row))
    }

    /// <x, y> over cells.
    pub fn dot<T: Real>(&mut self, exec: &dyn Exec, x: &[T], y: &[T]) -> f64 {
        self.total(exec, |span, _| {
            crate::field::rows::dot(part(x, span.clone()), part(y, span))
        })
    }

    /// <x, P x>.
    fn weighted<T: Real>(&mut self, exec: &dyn Exec, x: &[T]) -> f64 {
        let cells = self.cells;
        self.total(exec, |span, row| {
            let weights = Weights::<T>::new(cells, row);
            let x = part(x, span);
            let [inner, edge] = [weights.inner, weights.edge].map(|weight| weight.to_f64());
            let squares = crate::field::rows::sum_squares(x);
            let square = |x: Option<&T>| x.map_or(0.0, |x| x.to_f64() * x.to_f64());
            inner * squares + (edge - inner) * (square(x.first()) + square(x.last()))
        })
    }
}

fn part<T>(x: &[T], span: Range<usize>) -> &[T] {
    x.get(span).unwrap_or_default()
}

/// P = 1 / (2d less one for every wall that a cell touches) in a row: at its ends and between.
#[derive(Clone, Copy)]
struct Weights<T> {
    inner: T,
    edge: T,
}

impl<T: Real> Weights<T> {
    fn new(cells: &Cells, row: usize) -> Self {
        let mut diagonal = 2 * cells.dims;
        for (axis, at) in (1..cells.dims).zip(cells.row_at(row)) {
            let ends = at == 0 || at + 1 == cells.n[axis];
            diagonal -= usize::from(ends && !cells.ring[axis]);
        }
        let inverse = |diagonal: usize| T::from_f64(1.0 / diagonal as f64);
        Self {
            inner: inverse(diagonal),
            edge: inverse(diagonal - usize::from(!cells.ring[0])),
        }
    }

    /// Calls `each` with the numbers of a row of `out`, their places and P.
    #[inline(always)]
    fn for_row(self, out: &mut [T], mut each: impl FnMut(&mut T, usize, T)) {
        let last = out.len().saturating_sub(1);
        for (place, out) in out.iter_mut().enumerate() {
            let edge = place == 0 || place == last;
            each(out, place, if edge { self.edge } else { self.inner });
        }
    }
}

/// `q = A p`, or `q += A p`; the ghosts of `p` are filled here.
fn apply<T: Real>(exec: &dyn Exec, cells: &Cells, p: &mut [T], q: &mut [T], add: bool) {
    cells.set_bnd(None, p);
    let p = &*p;
    let diagonal = T::from_usize(2 * cells.dims);
    cells.for_rows(exec, [q], |row, [q]| {
        let span = cells.row(row);
        let here = part(p, span.clone());
        for (q, &p) in q.iter_mut().zip(here) {
            *q = if add { *q + diagonal * p } else { diagonal * p };
        }
        for axis in 0..cells.dims {
            let [low, high] = cells.beside(p, &span, axis);
            for ((q, &low), &high) in q.iter_mut().zip(low).zip(high) {
                *q -= low + high;
            }
        }
    });
}

/// What the adjoint reads of every iteration: r and p before x and r change, and rho, beta, alpha.
pub struct Tape<'a, T> {
    /// r, p of each iteration one after the other.
    pub fields: &'a mut [T],
    /// Numbers from one field to the next.
    pub pitch: usize,
    /// rho, beta, alpha of each iteration.
    pub scalars: &'a mut [T],
}

impl<T: Real> Tape<'_, T> {
    fn record(&mut self, cells: &Cells, k: usize, fields: [&[T]; 2], scalars: [T; 3]) {
        for (which, field) in fields.into_iter().enumerate() {
            let begin = (2 * k + which) * self.pitch;
            cells.pack(
                field,
                self.fields
                    .get_mut(begin..begin + cells.count())
                    .unwrap_or_default(),
            );
        }
        if let Some(places) = self.scalars.get_mut(3 * k..3 * k + 3) {
            places.copy_from_slice(&scalars);
        }
    }

    fn field(&self, cells: &Cells, k: usize, which: usize) -> &[T] {
        let begin = (2 * k + which) * self.pitch;
        self.fields.get(begin..begin + cells.count()).unwrap_or_default()
    }

    fn scalars(&self, k: usize) -> [T; 3] {
        let mut out = [T::ZERO; 3];
        if let Some(scalars) = self.scalars.get(3 * k..3 * k + 3) {
            out.copy_from_slice(scalars);
        }
        out
    }
}

/// Padded fields that iterations work in: r, the direction and its image.
pub struct Work<'a, T> {
    /// r.
    pub r: &'a mut [T],
    /// p.
    pub p: &'a mut [T],
    /// q.
    pub q: &'a mut [T],
}

/// Solves A x = f from 0, or only goes through the iterations where `x` is `None`; how many there were.
pub fn solve<T: Real>(
    exec: &dyn Exec,
    frame: &mut Frame<'_>,
    stopping: Stopping,
    f: &[T],
    mut x: Option<&mut [T]>,
    work: Work<'_, T>,
    mut tape: Option<&mut Tape<'_, T>>,
) -> usize {
    let cells = frame.cells;
    let Work { r, p, q } = work;
    if let Some(x) = &mut x {
        x.fill(T::ZERO);
    }
    r.copy_from_slice(part(f, 0..cells.padded));
    let mut rho = frame.weighted(exec, r);
    // Below this there is nothing left but rounding, which a singular matrix blows up.
    let tolerance = stopping.tolerance.max(NOISE * T::EPSILON);
    let enough = tolerance * tolerance * rho;
    let mut before = None;
    for k in 0..stopping.most {
        if rho <= enough || !(rho > 0.0) {
            return k;
        }
        let beta = T::from_f64(before.map_or(0.0, |before| rho / before));
        let first = before.is_none();
        let residual = &*r;
        cells.for_rows(exec, [&mut *p], |row, [p]| {
            let residual = part(residual, cells.row(row));
            Weights::new(cells, row).for_row(p, |p, place, weight| {
                let z = residual.get(place).map_or(T::ZERO, |&r| weight * r);
                *p = if first { z } else { z + beta * *p };
            });
        });
        apply(exec, cells, p, q, false);
        let along = frame.dot(exec, p, q);
        if !(along > 0.0) {
            return k;
        }
        let alpha = T::from_f64(rho / along);
        if let Some(tape) = &mut tape {
            tape.record(cells, k, [r, p], [T::from_f64(rho), beta, alpha]);
        }
        let (p, q) = (&*p, &*q);
        if let Some(x) = &mut x {
            cells.for_rows(exec, [&mut **x], |row, [x]| {
                crate::field::rows::add_scaled(x, alpha, part(p, cells.row(row)));
            });
        }
        cells.for_rows(exec, [&mut *r], |row, [r]| {
            crate::field::rows::add_scaled(r, -alpha, part(q, cells.row(row)));
        });
        before = Some(rho);
        rho = frame.weighted(exec, r);
    }
    stopping.most
}

/// The adjoint of [`solve`]: `work.r` becomes what the right-hand side gets, with `x` what the solution holds. `copy` is a fourth field.
pub fn adjoint<T: Real>(
    exec: &dyn Exec,
    frame: &mut Frame<'_>,
    iterations: usize,
    x: &[T],
    work: Work<'_, T>,
    copy: &mut [T],
    tape: &Tape<'_, T>,
) {
    let cells = frame.cells;
    // The adjoints of r, p; q itself, then work.
    let Work { r, p, q } = work;
    r.fill(T::ZERO);
    p.fill(T::ZERO);
    let mut carried = 0.0;
    for k in (0..iterations).rev() {
        let [rho, beta, alpha] = tape.scalars(k).map(|scalar| scalar.to_f64());
        cells.unpack(tape.field(cells, k, 1), copy);
        apply(exec, cells, copy, q, false);
        let along = rho / alpha;
        let by_alpha = frame.dot(exec, copy, x) - frame.dot(exec, q, r);
        let by_along = -(alpha / along) * by_alpha;
        let mut by_rho = carried + by_alpha / along;
        carried = 0.0;
        let [alpha, by_along] = [alpha, by_along].map(T::from_f64);
        // q' = -alpha r' + p apq, in the place of p; p' += alpha x' + q apq.
        let (image, residual) = (&*q, &*r);
        cells.for_rows(exec, [&mut *p, &mut *copy], |row, [p, copy]| {
            let span = cells.row(row);
            let [image, residual, x] = [image, residual, x].map(|field| part(field, span.clone()));
            for ((((p, copy), &image), &residual), &x) in
                p.iter_mut().zip(copy).zip(image).zip(residual).zip(x)
            {
                *p += alpha * x + image * by_along;
                *copy = *copy * by_along - alpha * residual;
            }
        });
        apply(exec, cells, copy, p, true);
        if k > 0 {
            cells.unpack(tape.field(cells, k - 1, 1), q);
            let by_beta = frame.dot(exec, q, p);
            let before = tape.scalars(k - 1)[0].to_f64();
            carried = -(beta / before) * by_beta;
            by_rho += by_beta / before;
        }
        let (residual, twice) = (tape.field(cells, k, 0), T::from_f64(2.0 * by_rho));
        let beta = T::from_f64(if k > 0 { beta } else { 0.0 });
        let n = cells.n[0];
        cells.for_rows(exec, [&mut *p, &mut *r], |row, [p, r]| {
            let residual = part(residual, row * n..(row + 1) * n);
            Weights::new(cells, row).for_row(r, |r, place, weight| {
                if let (Some(p), Some(&own)) = (p.get_mut(place), residual.get(place)) {
                    *r += weight * (*p + twice * own);
                    *p = beta * *p;
                }
            });
        });
    }
}
