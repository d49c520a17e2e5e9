//! The Taylor series of exp(tau L(v)) and its adjoint, term by term.

use super::MAX_TERMS;
use super::flux::{
    self, Around, BEFORE, Cells, HALO, Rows, Velocity, cells, each_run, faces, surround_cells, with_halo,
};
use crate::exec::{Exec, for_runs};
use crate::field::{VectorMut, rows};
use crate::grid::{Grid, Side};
use crate::real::Real;
use crate::simd::{self, vectorised};

/// Numbers of a term below this part of the cut are set to 0: a quarter of the square root of the rounding error, which makes 1e-9 of max
/// rho_0 in single precision with the default cut and keeps mass to 1e-7. Far from the smoke they would otherwise fade into denormal
/// numbers, on which processors are a hundred times slower; and rows without smoke are passed over.
fn negligible<T: Real>() -> f64 {
    0.25 * libm::sqrt(T::EPSILON)
}

/// One sub-step.
pub struct Series<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// Velocity at faces.
    pub velocity: Velocity<'a, T>,
    /// See [`super::flux::weights`].
    pub weights: [T; 3],
    /// Length of the sub-step.
    pub tau: f64,
    /// Terms are summed until max |term| is below this.
    pub cut: f64,
}

/// The size of a row that is 0 where it was not before.
const GONE: f64 = -1.0;

/// Terms y_1 .. y_k of a series.
pub struct Terms<N> {
    /// The fields, with their rows' neighbours.
    pub fields: N,
    /// Numbers from one to the next.
    pub stride: usize,
    /// max |y| of their rows; where that is 0, [`GONE`] if an earlier term or y_0 is not.
    pub sizes: N,
}

/// The terms of the series from y_0 = `from`, and `total` = their sum with y_0 unless it is empty. Returns how many there are, or
/// `None` where `terms` has no room for all of them.
pub fn sum<T: Real>(
    exec: &dyn Exec,
    series: &Series<'_, T>,
    from: &[T],
    terms: Terms<&mut [T]>,
    total: &mut [T],
    scratch: &mut [T],
) -> Option<usize> {
    let grid = series.grid;
    let (n, rows) = (grid.n[0], grid.rows());
    let Terms {
        fields,
        stride,
        sizes,
    } = terms;
    let negligible = T::from_f64(series.cut * negligible::<T>());
    for k in 1..=MAX_TERMS.min(fields.len() / stride) {
        let ((before, after), (known, sizes)) = (
            fields.split_at_mut((k - 1) * stride),
            sizes.split_at_mut((k - 1) * rows),
        );
        let from = Cells::before(k, from, before, stride);
        let previous = k.checked_sub(2).and_then(|k| known.get(k * rows..));
        let (to, sizes) = (&mut after[..with_halo(grid)], &mut sizes[..rows]);
        let scales = grid.h.map(|h| T::from_f64(series.tau / k as f64 / h));
        for_runs(
            exec,
            rows,
            [to, &mut *total, &mut *sizes],
            &mut *scratch,
            move |task| {
                let ([to, total, sizes], first, apart) = (task.fields, task.rows.start, flux::stride(n));
                let empty = |around: &Around<'_>, after: usize| {
                    around.empty(after, previous, |size| size <= T::ZERO, from)
                };
                each_run(grid, task.rows, k == 1, empty, |around, count, empty| {
                    let begin = around.row - first;
                    let to = to
                        .get_mut(begin * apart..(begin + count) * apart)
                        .unwrap_or_default();
                    let total = total.get_mut(begin * n..(begin + count) * n).unwrap_or_default();
                    let sizes = sizes.get_mut(begin..begin + count).unwrap_or_default();
                    let before = previous.and_then(|sizes| sizes.get(around.row..around.row + count));
                    if empty {
                        to.fill(T::ZERO);
                        for (row, size) in sizes.iter_mut().enumerate() {
                            *size = before
                                .and_then(|before| before.get(row).copied())
                                .unwrap_or(T::ZERO);
                        }
                        if k == 1 {
                            total.fill(T::ZERO);
                        }
                        return;
                    }
                    let (from, faces) = (cells(around, from, task.scratch), faces(around, series.velocity));
                    term(
                        to,
                        total,
                        sizes,
                        n,
                        k == 1,
                        &from,
                        &faces,
                        series.weights,
                        &scales[..grid.dims],
                        negligible,
                    );
                    for (row, (to, size)) in to.chunks_exact_mut(apart).zip(sizes).enumerate() {
                        let first = || {
                            from.own(row, BEFORE + n)
                                .get(BEFORE..)
                                .map_or(f64::NAN, rows::max_abs)
                        };
                        let was = || {
                            before
                                .and_then(|sizes| sizes.get(row))
                                .map_or_else(first, |size| size.to_f64())
                        };
                        if *size == T::ZERO && was() != 0.0 {
                            *size = T::from_f64(GONE);
                        }
                        surround_cells(to, n, grid.periodic[0]);
                    }
                });
            },
        );
        if k == MAX_TERMS || !(rows::largest(sizes.iter().map(|size| size.to_f64())) >= series.cut) {
            return Some(k);
        }
    }
    None
}

vectorised! {
    /// Rows of `to = s L from`, what is negligible set to 0, and `total += to` unless that is empty, or `total = from + to` for the `first` term;
    /// `sizes` receives max |to| of every row, not finite when any number is not.
    fn term[T, V](
        to: &mut [T], total: &mut [T], sizes: &mut [T], n: usize, first: bool, from: &Rows<'_, T>, faces: &Rows<'_, T>, w: [T; 3], scales: &[T], negligible: T,
    ) {
        let apart = flux::stride(n);
        for (row, size) in sizes.iter_mut().enumerate() {
            let begin = row * apart + BEFORE;
            let to = to.get_mut(begin..begin + n).unwrap_or_default();
            let total = total.get_mut(row * n..(row + 1) * n).unwrap_or_default();
            let mut extremes = [V::splat(T::ZERO); 2];
            let mut rest = [T::ZERO; 2];
            let i = term_from::<T, V>(0, row, to, total, first, from, faces, w, scales, negligible, &mut extremes);
            term_from::<T, T>(i, row, to, total, first, from, faces, w, scales, negligible, &mut rest);
            let mut lanes = [[T::ZERO; rows::LANES]; 2];
            extremes[0].store(&mut lanes[0]);
            extremes[1].store(&mut lanes[1]);
            lanes[0][0] = rest[0].max(lanes[0][0]);
            lanes[1][0] += rest[1];
            let largest = T::from_f64(rows::largest_lane(lanes[0], lanes[1]));
            // 0 where all was set to 0, not finite where any number was not.
            *size = if negligible > largest { T::ZERO } else { largest };
        }
    }
}

/// The inflow through the faces of cell c along an axis, `low` and `high`, the cells being a b c d e.
#[inline(always)]
fn inflow<T: Real, V: simd::Vector<Elem = T>>(
    [a, b, c, d, e]: [V; 5],
    [low, high]: [V; 2],
    [near, upstream, next]: [V; 3],
) -> V {
    let below = low * (near * low.select(c, b) + upstream * low.select(b, c) - next * low.select(a, d));
    let above = high * (near * high.select(d, c) + upstream * high.select(c, d) - next * high.select(b, e));
    below - above
}

/// The kernel of [`term`] from `i` as far as whole vectors go; where it ended.
#[inline(always)]
fn term_from<T: Real, V: simd::Vector<Elem = T>>(
    mut i: usize,
    row: usize,
    to: &mut [T],
    total: &mut [T],
    first: bool,
    from: &Rows<'_, T>,
    faces: &Rows<'_, T>,
    w: [T; 3],
    scales: &[T],
    negligible: T,
    extremes: &mut [V; 2],
) -> usize {
    let (n, summed) = (to.len(), !total.is_empty());
    let (x, faces_x) = (from.own(row, n + 4), faces.own(row, n + 3));
    let (y, faces_y) = (from.along(1, row, n), faces.along(1, row, n));
    let deep = scales.len() > 2;
    let (z, faces_z) = if deep {
        (from.along(2, row, n), faces.along(2, row, n))
    } else {
        (y, faces_y)
    };
    let (zero, negligible) = (V::splat(T::ZERO), V::splat(negligible));
    let w = [V::splat(w[0]), V::splat(w[1]), V::splat(w[2])];
    let scales = [
        V::splat(scales[0]),
        V::splat(scales[1]),
        V::splat(if deep { scales[2] } else { T::ZERO }),
    ];
    while i + V::LANES <= n {
        let c = V::load(&x[i + 2..]);
        let along_x = [
            V::load(&x[i..]),
            V::load(&x[i + 1..]),
            c,
            V::load(&x[i + 3..]),
            V::load(&x[i + 4..]),
        ];
        let mut sum = scales[0]
            * inflow(
                along_x,
                [V::load(&faces_x[i + 1..]), V::load(&faces_x[i + 2..])],
                w,
            );
        let along_y = [
            V::load(&y[0][i..]),
            V::load(&y[1][i..]),
            c,
            V::load(&y[2][i..]),
            V::load(&y[3][i..]),
        ];
        sum = sum + scales[1] * inflow(along_y, [V::load(&faces_y[1][i..]), V::load(&faces_y[2][i..])], w);
        if deep {
            let along_z = [
                V::load(&z[0][i..]),
                V::load(&z[1][i..]),
                c,
                V::load(&z[2][i..]),
                V::load(&z[3][i..]),
            ];
            sum =
                sum + scales[2] * inflow(along_z, [V::load(&faces_z[1][i..]), V::load(&faces_z[2][i..])], w);
        }
        let size = sum.max(-sum);
        extremes[0] = size.max(extremes[0]);
        extremes[1] = extremes[1] + sum * zero;
        let sum = (negligible - size).select(zero, sum);
        sum.store(&mut to[i..]);
        if summed {
            let before = if first { c } else { V::load(&total[i..]) };
            (before + sum).store(&mut total[i..]);
        }
        i += V::LANES;
    }
    i
}

/// What the backward sweep of a sub-step changes.
pub struct Backward<'a, T> {
    /// mu, before and after.
    pub mu: &'a mut [T],
    /// Two fields of cells.
    pub work: [&'a mut [T]; 2],
    /// The velocity gradient.
    pub gradient: VectorMut<'a, T>,
    /// Whether the gradient is begun with this sub-step, or added to.
    pub first: bool,
}

/// The adjoint of [`sum`] from `from` with `last` terms: `mu` <- z_0 where z_last = mu, z_{k-1} = mu + (tau / k) L^T z_k, and
/// `gradient` += (tau / k) rho_f(y_{k-1}) (z_k[R] - z_k[L]) / h at every face. Rows around which y_0 .. y_{k-1} are 0 are passed over: what z
/// is there meets no smoke on the way back, unless smoke that lies perfectly still is let go beside rows that move.
pub fn adjoint<T: Real>(
    exec: &dyn Exec,
    series: &Series<'_, T>,
    from: &[T],
    terms: Terms<&[T]>,
    last: usize,
    backward: Backward<'_, T>,
    scratch: &mut [T],
) {
    let (grid, len) = (series.grid, series.grid.cells());
    let Backward {
        mu,
        work: [mut z, mut next],
        gradient: [g0, g1, g2],
        first,
    } = backward;
    for k in (1..=last).rev() {
        let y = Cells::before(k, from, terms.fields, terms.stride);
        let sizes = k.checked_sub(2).and_then(|k| terms.sizes.get(k * grid.rows()..));
        let gradient = [&mut *g0, &mut *g1, &mut *g2];
        let term = AdjointTerm {
            scale: series.tau / k as f64,
            y,
            sizes,
            clear: first && k == last,
        };
        // mu itself is the first z, and what the last is written to: a row of it is read by that row alone then.
        let room = if k == 1 { len } else { with_halo(grid) };
        match (k == last, k == 1) {
            (true, _) => adjoint_term(
                exec,
                series,
                &term,
                mu,
                Cells::Alone(mu),
                &mut next[..room],
                gradient,
                scratch,
            ),
            (false, true) => adjoint_term(
                exec,
                series,
                &term,
                &[],
                Cells::WithHalo(z),
                mu,
                gradient,
                scratch,
            ),
            (false, false) => adjoint_term(
                exec,
                series,
                &term,
                mu,
                Cells::WithHalo(z),
                &mut next[..room],
                gradient,
                scratch,
            ),
        }
        core::mem::swap(&mut z, &mut next);
    }
    if last == 1 {
        mu.copy_from_slice(&z[..len]);
    }
}

/// One term on the way back.
struct AdjointTerm<'a, T> {
    /// tau / k.
    scale: f64,
    /// y_{k-1}.
    y: Cells<'a, T>,
    /// The sizes of its rows, where they are known.
    sizes: Option<&'a [T]>,
    /// Whether the gradient begins with this term.
    clear: bool,
}

/// `next` = `mu` + (tau / k) L^T `z`, or `next` += the latter where `mu` is empty, and the gradient's share.
fn adjoint_term<T: Real>(
    exec: &dyn Exec,
    series: &Series<'_, T>,
    term: &AdjointTerm<'_, T>,
    mu: &[T],
    z: Cells<'_, T>,
    next: &mut [T],
    [g0, g1, g2]: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let grid = series.grid;
    let n = grid.n[0];
    let scales = grid.h.map(|h| T::from_f64(term.scale / h));
    for_runs(exec, grid.rows(), [next, g0, g1, g2], scratch, move |task| {
        let ([next, mut gradient @ ..], first) = (task.fields, task.rows.start);
        if term.clear {
            gradient.iter_mut().for_each(|component| component.fill(T::ZERO));
        }
        let apart = (next.len() / task.rows.len().max(1)).max(1);
        let before = if apart > n { BEFORE } else { 0 };
        let alone = matches!(z, Cells::Alone(_)) || matches!(term.y, Cells::Alone(_));
        let empty = |around: &Around<'_>, after: usize| {
            around.empty(after, term.sizes, |size| size == T::ZERO, term.y)
        };
        each_run(grid, task.rows, alone, empty, |around, count, empty| {
            let begin = around.row - first;
            let next = next
                .get_mut(begin * apart..(begin + count) * apart)
                .unwrap_or_default();
            let mu = mu
                .get(around.row * n..(around.row + count) * n)
                .unwrap_or_default();
            if !empty {
                let mut gradient = gradient.each_mut().map(|component| {
                    component
                        .get_mut(begin * n..(begin + count) * n)
                        .unwrap_or_default()
                });
                let (of_z, of_y) = task.scratch.split_at_mut(n + HALO);
                let (z, y, faces) = (
                    cells(around, z, of_z),
                    cells(around, term.y, of_y),
                    faces(around, series.velocity),
                );
                transposed(
                    next,
                    apart,
                    before,
                    mu,
                    &mut gradient,
                    n,
                    &z,
                    &y,
                    &faces,
                    series.weights,
                    &scales[..grid.dims],
                );
                for (row, next) in next.chunks_exact_mut(apart).enumerate() {
                    fold_at_walls(
                        grid,
                        around,
                        row,
                        &mut next[before..before + n],
                        &z,
                        &faces,
                        series.weights[2],
                        scales,
                    );
                }
            } else if !mu.is_empty() {
                for (next, mu) in next.chunks_exact_mut(apart).zip(mu.chunks_exact(n)) {
                    next[before..before + n].copy_from_slice(mu);
                }
            }
            if before > 0 {
                next.chunks_exact_mut(apart)
                    .for_each(|next| surround_cells(next, n, grid.periodic[0]));
            }
        });
    });
}

vectorised! {
    /// Rows of `out = mu + s L^T z`, or `out += s L^T z` where `mu` is empty, walls left out: a cell is R of its low face, L of its high
    /// face, and the next one upstream of the faces beyond. And of `gradient += s rho_f(y) (z[R] - z[L])` at the cells' low faces; where v is
    /// exactly 0, rho_f is the mean of both sides'. Rows of `out` are `apart` and begin after so many numbers.
    fn transposed[T, V](
        out: &mut [T], apart: usize, before: usize, mu: &[T], gradient: &mut [&mut [T]; 3], n: usize, z: &Rows<'_, T>, y: &Rows<'_, T>,
        faces: &Rows<'_, T>, w: [T; 3], scales: &[T],
    ) {
        let [gx, gy, gz] = gradient;
        for (row, out) in out.chunks_exact_mut(apart.max(1)).enumerate() {
            let (out, span) = (out.get_mut(before..before + n).unwrap_or_default(), row * n..(row + 1) * n);
            let mu = mu.get(span.clone()).unwrap_or_default();
            let gz = gz.get_mut(span.clone()).unwrap_or_default();
            let mut gradient = [gx.get_mut(span.clone()).unwrap_or_default(), gy.get_mut(span).unwrap_or_default(), gz];
            let i = transposed_from::<T, V>(0, row, out, mu, &mut gradient, z, y, faces, w, scales);
            transposed_from::<T, T>(i, row, out, mu, &mut gradient, z, y, faces, w, scales);
        }
    }
}

/// The share of cell c, among a b c d e, in the changes that flow through the faces around it: those before, below, above and after.
#[inline(always)]
fn outflow<T: Real, V: simd::Vector<Elem = T>>(
    [a, b, c, d, e]: [V; 5],
    faces: [V; 4],
    [near, upstream, next]: [V; 3],
    zero: V,
) -> V {
    let [before, low, high, after] = faces;
    let at_low = low * low.select(near, upstream) * (c - b);
    let at_high = high * high.select(upstream, near) * (d - c);
    let beyond = after.max(zero) * (e - d) + before.min(zero) * (b - a);
    at_low + at_high - next * beyond
}

/// rho_f at a face with the cells a b | c d around it, through which `v` goes.
#[inline(always)]
fn at_face<T: Real, V: simd::Vector<Elem = T>>(
    [a, b, c, d]: [V; 4],
    v: V,
    [near, upstream, next]: [V; 3],
) -> V {
    let upward = near * c + upstream * b - next * a;
    let downward = near * b + upstream * c - next * d;
    v.select(
        upward,
        (-v).select(downward, V::splat(T::HALF) * (upward + downward)),
    )
}

/// What one axis brings cells c at `i`, s times [`outflow`], and the gradient at their low faces. Rows of z and y stand at offsets -2, -1, 1
/// and 2 of the cells, those of faces at -1, 0, 1 and 2.
#[inline(always)]
fn along_axis<T: Real, V: simd::Vector<Elem = T>>(
    i: usize,
    (c, y_c): (V, V),
    z: &[&[T]; 4],
    y: &[&[T]; 4],
    faces: &[&[T]; 4],
    gradient: &mut [T],
    s: V,
    w: [V; 3],
    zero: V,
) -> V {
    let (b, low) = (V::load(&z[1][i..]), V::load(&faces[1][i..]));
    let rho_f = at_face(
        [V::load(&y[0][i..]), V::load(&y[1][i..]), y_c, V::load(&y[2][i..])],
        low,
        w,
    );
    (V::load(&gradient[i..]) + s * rho_f * (c - b)).store(&mut gradient[i..]);
    let through = [
        V::load(&faces[0][i..]),
        low,
        V::load(&faces[2][i..]),
        V::load(&faces[3][i..]),
    ];
    s * outflow(
        [
            V::load(&z[0][i..]),
            b,
            c,
            V::load(&z[2][i..]),
            V::load(&z[3][i..]),
        ],
        through,
        w,
        zero,
    )
}

/// The kernel of [`transposed`] from `i` as far as whole vectors go; where it ended.
#[inline(always)]
fn transposed_from<T: Real, V: simd::Vector<Elem = T>>(
    mut i: usize,
    row: usize,
    out: &mut [T],
    mu: &[T],
    gradient: &mut [&mut [T]; 3],
    z: &Rows<'_, T>,
    y: &Rows<'_, T>,
    faces: &Rows<'_, T>,
    w: [T; 3],
    scales: &[T],
) -> usize {
    let (n, last, alone) = (out.len(), scales.len() - 1, mu.is_empty());
    let mu = if alone { mu } else { &mu[..n] };
    let [gx, gy, gz] = gradient;
    let (gx, gy, gz) = (
        &mut gx[..n],
        &mut gy[..n],
        if last > 1 { &mut gz[..n] } else { &mut [][..] },
    );
    let (cells, rho, faces_x) = (z.own(row, n + 4), y.own(row, n + 4), faces.own(row, n + 3));
    let (z_x, y_x) = (
        [&cells[..n], &cells[1..], &cells[3..], &cells[4..]],
        [&rho[..n], &rho[1..], &rho[3..], &rho[4..]],
    );
    let faces_x = [&faces_x[..n], &faces_x[1..], &faces_x[2..], &faces_x[3..]];
    let (z_y, y_y, faces_y) = (z.along(1, row, n), y.along(1, row, n), faces.along(1, row, n));
    let (z_z, y_z, faces_z) = (
        z.along(last, row, n),
        y.along(last, row, n),
        faces.along(last, row, n),
    );
    let zero = V::splat(T::ZERO);
    let w = [V::splat(w[0]), V::splat(w[1]), V::splat(w[2])];
    let scales = [V::splat(scales[0]), V::splat(scales[1]), V::splat(scales[last])];
    while i + V::LANES <= n {
        let here = (V::load(&cells[i + 2..]), V::load(&rho[i + 2..]));
        let mut sum = if alone {
            V::load(&out[i..])
        } else {
            V::load(&mu[i..])
        };
        sum = sum + along_axis(i, here, &z_x, &y_x, &faces_x, gx, scales[0], w, zero);
        sum = sum + along_axis(i, here, &z_y, &y_y, &faces_y, gy, scales[1], w, zero);
        if last > 1 {
            sum = sum + along_axis(i, here, &z_z, &y_z, &faces_z, gz, scales[2], w, zero);
        }
        sum.store(&mut out[i..]);
        i += V::LANES;
    }
    i
}

/// At a wall the last cell stands in for the missing one next upstream, and so takes its share too.
fn fold_at_walls<T: Real>(
    grid: &Grid,
    around: &Around<'_>,
    row: usize,
    out: &mut [T],
    z: &Rows<'_, T>,
    faces: &Rows<'_, T>,
    w: T,
    scales: [T; 3],
) {
    let n = out.len();
    let (c, through) = (&z.own(row, n + BEFORE)[BEFORE..], faces.own(row, n + 1));
    if !grid.periodic[0] {
        out[0] -= scales[0] * w * through[2].max(T::ZERO) * (c[1] - c[0]);
        out[n - 1] -= scales[0] * w * through[n].min(T::ZERO) * (c[n - 1] - c[n - 2]);
    }
    for axis in 1..grid.dims {
        if around.at_wall(axis, Side::Low) {
            let (above, high) = (z.along(axis, row, n)[2], faces.along(axis, row, n)[2]);
            for i in 0..n {
                out[i] -= scales[axis] * w * high[i].max(T::ZERO) * (above[i] - c[i]);
            }
        }
        if around.at_wall(axis, Side::High) {
            let (below, low) = (z.along(axis, row, n)[1], faces.along(axis, row, n)[1]);
            for i in 0..n {
                out[i] -= scales[axis] * w * low[i].min(T::ZERO) * (c[i] - below[i]);
            }
        }
    }
}
