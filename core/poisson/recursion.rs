//! Poisson's problem along the first axis, of coefficients in the eigenvectors of the others, by two recursions.
//!
//! In a row whose other eigenvalues add up to lambda, div grad q = f with q = -h^2 p is -p_{i-1} + (2 + s) p_i - p_{i+1} = f_i, s = lambda h^2. With the root
//! r < 1 of r + 1 / r = 2 + s that is two recursions (Unser, Aldroubi and Eden 1993, B-spline signal processing: part II):
//!
//! ```text
//! a_i = f_i + r a_{i-1} upwards,    p_i = r (p_{i+1} + a_i) downwards
//! ```
//!
//! They begin with what the images of f behind both ends would leave there: f mirrored in a wall, and with the other sign in the cell outside an open side. With
//! A the sum of r^i f_i and B that of r^(n-1-i) f_i over the n cells inside, sigma and tau for the low and the high end, 1 at a wall and -r at an open side:
//!
//! ```text
//! ends    a_{-1} = sigma (A + tau r^n B) / (1 - sigma tau r^2n),    p_n = a_{n-1} r / (1 - r) at a wall, 0 at an open side
//! ring    a_{-1} = B / (1 - r^n),                                   p_n = (A + r B) r / ((1 - r^2) (1 - r^n))
//! ```

use crate::exec::{Exec, for_panels};
use crate::field::lines::{lines_to_rows, rows_to_lines};
use crate::field::rows::part_mut;
use crate::field::transform::RowOf;
use crate::grid::spectrum::{COLUMNS, Spectrum};
use crate::grid::{Axis, Grid, Side};
use crate::real::Real;
use crate::simd::{Vector, vectorised};

/// How the first axis ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ends {
    /// It closes on itself.
    Ring,
    /// At each end an open side, or a wall.
    Opens([bool; 2]),
}

impl Ends {
    fn of(axis: Axis) -> Self {
        if axis.is_ring() {
            Self::Ring
        } else {
            Self::Opens([Side::Low, Side::High].map(|side| axis.ends().opens(side)))
        }
    }
}

/// Right-hand sides `field` of rows become potentials, on the threads of `exec`, each with a chunk of `scratch`. `grid` is the whole box, and row j of
/// the field is the row `of(j)` of it.
pub fn solve_rows<T: Real>(
    exec: &dyn Exec,
    (grid, spectrum): (&Grid, &Spectrum<'_, T>),
    of: RowOf<'_>,
    field: &mut [T],
    scratch: &mut [T],
) {
    let (axis, n, len) = (grid.axis(0), grid.n[0].max(1), field.len());
    let (ends, inside) = (Ends::of(axis), axis.inside());
    let squared = T::from_f64(grid.h[0] * grid.h[0]);
    let inside = inside.start * COLUMNS..inside.end * COLUMNS;
    for_panels(
        exec,
        field,
        [1, len, COLUMNS * n],
        scratch,
        |mut group, scratch| {
            let first = group.first() / n;
            let rows = group.row_mut(0);
            let lines = part_mut(scratch, 0..n * COLUMNS);
            let mut across = [T::ZERO; COLUMNS];
            for (j, sum) in across.iter_mut().enumerate().take(rows.len() / n) {
                let at = grid.row_at(of(first + j));
                *sum = (1..grid.dims).fold(T::ZERO, |sum, axis| {
                    let eigenvalues = spectrum.axes[axis].eigenvalues;
                    sum + eigenvalues.get(at[axis - 1]).copied().unwrap_or(T::ZERO)
                });
            }
            rows_to_lines(n, rows, lines, None);
            sweep(part_mut(lines, inside.clone()), ends, &across, squared);
            lines_to_rows_but_straight(lines, &across, (grid, ends), rows);
        },
    );
}

/// The potentials in `lines` to rows, but where the sum of eigenvalues is 0: those rows are solved by themselves. What is outside the box becomes 0.
fn lines_to_rows_but_straight<T: Real>(
    lines: &mut [T],
    across: &[T; COLUMNS],
    (grid, ends): (&Grid, Ends),
    rows: &mut [T],
) {
    let (n, inside) = (grid.n[0].max(1), grid.axis(0).inside());
    for (j, row) in rows.chunks_exact_mut(n).enumerate() {
        if !across.get(j).is_some_and(|&sum| sum > T::ZERO) {
            straight(part_mut(row, inside.clone()), ends, grid.h[0]);
            let columns = lines.iter_mut().skip(j).step_by(COLUMNS);
            columns.zip(&*row).for_each(|(to, &from)| *to = from);
        }
    }
    let (low, rest) = lines.split_at_mut((inside.start * COLUMNS).min(lines.len()));
    low.fill(T::ZERO);
    let outside = (inside.len() * COLUMNS).min(rest.len());
    rest.split_at_mut(outside).1.fill(T::ZERO);
    lines_to_rows(n, lines, rows, None, 0);
}

/// What the recursions of some rows begin with.
#[derive(Clone, Copy)]
struct Factors<V> {
    /// r.
    root: V,
    /// a_{-1} in terms of A and B.
    before: [V; 2],
    /// p_n in terms of A, B and a_{n-1}.
    behind: [V; 3],
}

impl<V: Vector> Factors<V>
where
    V::Elem: Real,
{
    /// Those of `n` cells inside with s = lambda h^2.
    #[inline(always)]
    fn new(s: V, ends: Ends, n: usize) -> Self {
        let number = |x: f64| V::splat(V::Elem::from_f64(x));
        let (zero, one) = (number(0.0), number(1.0));
        // r = 1 / (1 + gap), so that 1 - r has no cancellation.
        let gap = number(0.5) * s + (s * (one + number(0.25) * s)).root();
        let root = (one + gap).recip();
        let below_one = gap * root;
        let (mut power, mut square, mut left) = (one, root, n);
        while left > 0 {
            if left % 2 == 1 {
                power = power * square;
            }
            (square, left) = (square * square, left / 2);
        }
        match ends {
            Ends::Ring => {
                let whole = (one - power).recip();
                let both = root * (below_one * (one + root)).recip() * whole;
                Self {
                    root,
                    before: [zero, whole],
                    behind: [both, root * both, zero],
                }
            }
            Ends::Opens([low, high]) => {
                let image = if low { -root } else { one };
                let far = if high { -root } else { one } * power;
                let whole = image * (one - image * far * power).recip();
                Self {
                    root,
                    before: [whole, whole * far],
                    behind: [zero, zero, if high { zero } else { root * below_one.recip() }],
                }
            }
        }
    }
}

/// Vectors that go through the recursions side by side, since each step waits for the one before.
const BESIDE: usize = 2;

vectorised! {
    /// Right-hand sides in lines of [`COLUMNS`] rows become potentials, each with its own lambda; `squared` is h^2. Where lambda is 0 they are of no use.
    fn sweep[T, V](lines: &mut [T], ends: Ends, lambdas: &[T; COLUMNS], squared: T) {
        let (lanes, n) = (<V as Vector>::LANES, lines.len() / COLUMNS);
        let (zero, squared) = (V::splat(T::ZERO), V::splat(squared));
        for first in (0..COLUMNS).step_by(BESIDE * lanes) {
            let mut all = [Factors { root: zero, before: [zero; 2], behind: [zero; 3] }; BESIDE];
            let (mut above, mut below) = ([zero; BESIDE], [zero; BESIDE]);
            for v in 0..BESIDE {
                all[v] = Factors::new(V::at(lambdas, first + v * lanes) * squared, ends, n);
            }
            for (up, down) in lines.chunks_exact(COLUMNS).zip(lines.chunks_exact(COLUMNS).rev()) {
                for v in 0..BESIDE {
                    below[v] = all[v].root * below[v] + V::at(up, first + v * lanes);
                    above[v] = all[v].root * above[v] + V::at(down, first + v * lanes);
                }
            }
            let mut a = [zero; BESIDE];
            for v in 0..BESIDE {
                a[v] = all[v].before[0] * above[v] + all[v].before[1] * below[v];
            }
            for line in lines.chunks_exact_mut(COLUMNS) {
                for v in 0..BESIDE {
                    a[v] = all[v].root * a[v] + V::at(line, first + v * lanes);
                    a[v].put(line, first + v * lanes);
                }
            }
            let mut p = [zero; BESIDE];
            for v in 0..BESIDE {
                let [of_above, of_below, of_last] = all[v].behind;
                p[v] = of_above * above[v] + of_below * below[v] + of_last * a[v];
            }
            for line in lines.chunks_exact_mut(COLUMNS).rev() {
                for v in 0..BESIDE {
                    p[v] = all[v].root * (p[v] + V::at(line, first + v * lanes));
                    (-(squared * p[v])).put(line, first + v * lanes);
                }
            }
        }
    }
}

/// The row `f` of right-hand sides whose lambda is 0 becomes its potential: fluxes are sums of f, and potentials sums of fluxes, in `f64`. Without an open
/// side the mean of f is taken away, and the potential has none.
fn straight<T: Real>(f: &mut [T], ends: Ends, h: f64) {
    let count = f.len().max(1) as f64;
    let closed = matches!(ends, Ends::Ring | Ends::Opens([false, false]));
    let sum: f64 = f.iter().map(|f| f.to_f64()).sum();
    let mean = if closed { sum / count } else { 0.0 };
    // Each flux and each potential from a first flux of 0.
    let (mut flux, mut fluxes) = (0.0, 0.0);
    for f in &*f {
        fluxes += flux;
        flux += h * (f.to_f64() - mean);
    }
    let first = match ends {
        // The potential comes round to where it began.
        Ends::Ring => -fluxes / count,
        // Nothing flows through the high wall.
        Ends::Opens([true, false]) => -flux,
        // It is 0 in the cells outside at both ends.
        Ends::Opens([true, true]) => -(fluxes + flux) / (count + 1.0),
        Ends::Opens([false, _]) => 0.0,
    };
    let opens_low = matches!(ends, Ends::Opens([true, _]));
    let (mut flux, mut potential, mut potentials) = (first, 0.0, 0.0);
    for (i, value) in f.iter_mut().enumerate() {
        let own = value.to_f64() - mean;
        if i > 0 || opens_low {
            potential += h * flux;
        }
        flux += h * own;
        potentials += potential;
        *value = T::from_f64(potential);
    }
    let shift = match ends {
        Ends::Opens([false, true]) => potential + h * flux,
        _ if closed => potentials / count,
        _ => 0.0,
    };
    f.iter_mut()
        .for_each(|value| *value = T::from_f64(value.to_f64() - shift));
}
