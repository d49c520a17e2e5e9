//! The Fourier transform of many columns at once, for axes of any length: Stockham's passes, which leave the result in order (Van Loan
//! 1992, Computational Frameworks for the Fast Fourier Transform, section 1.7), by factors of 4, 2 and odd primes.
//!
//! A line of [`COLUMNS`] numbers holds one element of half as many complex columns, real parts first. A pass by a prime p takes
//! p / 2 multiplications a number, so a length with a large prime factor takes its time.

use crate::grid::fourier::factor;
use crate::grid::spectrum::COLUMNS;
use crate::real::Real;
use crate::simd::{Vector, vectorised};

/// The complex columns of a line.
pub const COMPLEX: usize = COLUMNS / 2;

/// sum_j x_j e^(-2 pi i j k / n) for k from 0 to n - 1, of lines x_j. `roots` are those of the axis, `from` and `to` hold `n` lines each. The
/// first slice that is returned has the result, the other one is free.
pub fn transform<'b, T: Real>(
    roots: &[T],
    mut from: &'b mut [T],
    mut to: &'b mut [T],
) -> (&'b mut [T], &'b mut [T]) {
    let (mut left, mut done) = (roots.len() / 2, 1);
    while left > 1 {
        let by = factor(left);
        left /= by;
        match by {
            4 => by_four(from, to, roots, left, done),
            2 => by_two(from, to, roots, left, done),
            3 => by_three(from, to, roots, left, done),
            5 => by_five(from, to, roots, left, done),
            _ => {
                fold_ends(from, by);
                by_prime(from, to, roots, by, left, done);
            }
        }
        done *= by;
        core::mem::swap(&mut from, &mut to);
    }
    (from, to)
}

/// A root of unity by its number.
#[inline(always)]
fn root<T: Real, V: Vector<Elem = T>>(roots: &[T], number: usize) -> [V; 2] {
    match roots.get(2 * number..) {
        Some(&[re, im, ..]) => [V::splat(re), V::splat(im)],
        _ => [V::splat(T::ONE), V::splat(T::ZERO)],
    }
}

/// The complex numbers of a line from `lane` on.
#[inline(always)]
fn read<T: Real, V: Vector<Elem = T>>(line: &[T], lane: usize) -> [V; 2] {
    [V::at(line, lane), V::at(line, COMPLEX + lane)]
}

/// Writes what [`read`] reads.
#[inline(always)]
fn write<T: Real, V: Vector<Elem = T>>([re, im]: [V; 2], line: &mut [T], lane: usize) {
    re.put(line, lane);
    im.put(line, COMPLEX + lane);
}

#[inline(always)]
fn add<V: Vector>(a: [V; 2], b: [V; 2]) -> [V; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn sub<V: Vector>(a: [V; 2], b: [V; 2]) -> [V; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
fn times<V: Vector>(a: [V; 2], b: [V; 2]) -> [V; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// -i a.
#[inline(always)]
fn turned<V: Vector>(a: [V; 2]) -> [V; 2] {
    [a[1], -a[0]]
}

/// One j of the sums e = x_0 + sum_j s_j cos(2 pi j k / p) and o = sum_j d_j sin(2 pi j k / p), with the root e^(-2 pi i j k / p).
#[inline(always)]
fn with_next<V: Vector>(
    [even, odd]: [[V; 2]; 2],
    [cosine, sine]: [V; 2],
    [s, d]: [[V; 2]; 2],
) -> [[V; 2]; 2] {
    [
        add(even, [cosine * s[0], cosine * s[1]]),
        sub(odd, [sine * d[0], sine * d[1]]),
    ]
}

/// Elements k and p - k of the short transform, e - i o and e + i o, each times its factor.
#[inline(always)]
fn of_ends<V: Vector>([even, odd]: [[V; 2]; 2], [w, v]: [[V; 2]; 2]) -> [[V; 2]; 2] {
    let odd = turned(odd);
    [times(add(even, odd), w), times(sub(even, odd), v)]
}

vectorised! {
    /// The pass by 4, with `left` what remains of the length after it and `done` what was divided out before.
    fn by_four[T, V](from: &[T], to: &mut [T], roots: &[T], left: usize, done: usize) {
        let len = done * COLUMNS;
        let mut quarters = from.chunks_exact(left * len);
        let (Some(q0), Some(q1), Some(q2), Some(q3)) = (quarters.next(), quarters.next(), quarters.next(), quarters.next()) else { return };
        let inputs = q0.chunks_exact(len).zip(q1.chunks_exact(len)).zip(q2.chunks_exact(len)).zip(q3.chunks_exact(len));
        for ((p, out), (((x0, x1), x2), x3)) in to.chunks_exact_mut(4 * len).enumerate().zip(inputs) {
            let w1: [V; 2] = root(roots, p * done);
            let w2: [V; 2] = root(roots, 2 * p * done);
            let w3: [V; 2] = root(roots, 3 * p * done);
            let (low, high) = out.split_at_mut(2 * len);
            let ((y0, y1), (y2, y3)) = (low.split_at_mut(len), high.split_at_mut(len));
            let lines = x0.chunks_exact(COLUMNS).zip(x1.chunks_exact(COLUMNS)).zip(x2.chunks_exact(COLUMNS)).zip(x3.chunks_exact(COLUMNS));
            let outputs = y0.chunks_exact_mut(COLUMNS).zip(y1.chunks_exact_mut(COLUMNS)).zip(y2.chunks_exact_mut(COLUMNS)).zip(y3.chunks_exact_mut(COLUMNS));
            for ((((x0, x1), x2), x3), (((y0, y1), y2), y3)) in lines.zip(outputs) {
                for lane in (0..COMPLEX).step_by(<V as Vector>::LANES) {
                    let [x0, x1, x2, x3]: [[V; 2]; 4] = [read(x0, lane), read(x1, lane), read(x2, lane), read(x3, lane)];
                    let (even, odd) = ([add(x0, x2), sub(x0, x2)], [add(x1, x3), turned(sub(x1, x3))]);
                    write(add(even[0], odd[0]), y0, lane);
                    write(times(add(even[1], odd[1]), w1), y1, lane);
                    write(times(sub(even[0], odd[0]), w2), y2, lane);
                    write(times(sub(even[1], odd[1]), w3), y3, lane);
                }
            }
        }
    }
}

vectorised! {
    /// The pass by 2: see [`by_four`].
    fn by_two[T, V](from: &[T], to: &mut [T], roots: &[T], left: usize, done: usize) {
        let len = done * COLUMNS;
        let (low, high) = from.split_at(left * len);
        for ((p, out), (x0, x1)) in to.chunks_exact_mut(2 * len).enumerate().zip(low.chunks_exact(len).zip(high.chunks_exact(len))) {
            let w: [V; 2] = root(roots, p * done);
            let (y0, y1) = out.split_at_mut(len);
            let lines = x0.chunks_exact(COLUMNS).zip(x1.chunks_exact(COLUMNS));
            for ((x0, x1), (y0, y1)) in lines.zip(y0.chunks_exact_mut(COLUMNS).zip(y1.chunks_exact_mut(COLUMNS))) {
                for lane in (0..COMPLEX).step_by(<V as Vector>::LANES) {
                    let [x0, x1]: [[V; 2]; 2] = [read(x0, lane), read(x1, lane)];
                    write(add(x0, x1), y0, lane);
                    write(times(sub(x0, x1), w), y1, lane);
                }
            }
        }
    }
}

/// The pass by the odd number p = 2 `H` + 1, so small that all of x_j stay in vectors: see [`by_four`]. With the sums s_j and differences d_j of
/// x_j and x_(p-j), elements k and p - k of the short transform are x_0 + sum_j (s_j cos(2 pi j k / p) -+ i d_j sin(2 pi j k / p)), j from 1 to H.
#[inline(always)]
fn by_odd<T: Real, V: Vector<Elem = T>, const H: usize>(
    from: &[T],
    to: &mut [T],
    roots: &[T],
    left: usize,
    done: usize,
) {
    let (factor, len) = (2 * H + 1, done * COLUMNS);
    let part = left * len;
    let nothing = [V::splat(T::ZERO); 2];
    let mut short = [[nothing; H]; H];
    for k in 0..H {
        for j in 0..H {
            short[k][j] = root(roots, (j + 1) * (k + 1) % factor * left * done);
        }
    }
    for (p, out) in to.chunks_exact_mut(factor * len).enumerate() {
        let mut turns = [[nothing; 2]; H];
        for k in 0..H {
            turns[k] = [
                root(roots, (k + 1) * p * done),
                root(roots, (2 * H - k) * p * done),
            ];
        }
        for start in (0..len).step_by(COLUMNS) {
            let at = p * len + start;
            for lane in (0..COMPLEX).step_by(V::LANES) {
                let first: [V; 2] = read(&from[at..], lane);
                let (mut sums, mut differences, mut whole) = ([nothing; H], [nothing; H], first);
                for j in 0..H {
                    let low: [V; 2] = read(&from[(j + 1) * part + at..], lane);
                    let high: [V; 2] = read(&from[(2 * H - j) * part + at..], lane);
                    (sums[j], differences[j]) = (add(low, high), sub(low, high));
                    whole = add(whole, sums[j]);
                }
                write(whole, &mut out[start..], lane);
                for k in 0..H {
                    let mut parts = [first, nothing];
                    for j in 0..H {
                        parts = with_next(parts, short[k][j], [sums[j], differences[j]]);
                    }
                    let [low, high] = of_ends(parts, turns[k]);
                    write(low, &mut out[(k + 1) * len + start..], lane);
                    write(high, &mut out[(2 * H - k) * len + start..], lane);
                }
            }
        }
    }
}

vectorised! {
    /// [`by_odd`] for 3.
    fn by_three[T, V](from: &[T], to: &mut [T], roots: &[T], left: usize, done: usize) {
        by_odd::<T, V, 1>(from, to, roots, left, done);
    }
}

vectorised! {
    /// [`by_odd`] for 5.
    fn by_five[T, V](from: &[T], to: &mut [T], roots: &[T], left: usize, done: usize) {
        by_odd::<T, V, 2>(from, to, roots, left, done);
    }
}

vectorised! {
    /// Of an odd number of parts, the second and the last become their sum and their difference, the third and the last but one, and so on.
    fn fold_ends[T, V](values: &mut [T], parts: usize) {
        let len = values.len() / parts;
        let (_, rest) = values.split_at_mut(len);
        let (low, high) = rest.split_at_mut(parts / 2 * len);
        for (low, high) in low.chunks_exact_mut(len).zip(high.chunks_exact_mut(len).rev()) {
            for (low, high) in low.chunks_exact_mut(COLUMNS).zip(high.chunks_exact_mut(COLUMNS)) {
                for lane in (0..COLUMNS).step_by(<V as Vector>::LANES) {
                    let [l, h] = [V::at(low, lane), V::at(high, lane)];
                    (l + h).put(low, lane);
                    (l - h).put(high, lane);
                }
            }
        }
    }
}

vectorised! {
    /// The pass by any odd prime, after [`fold_ends`], which leaves the s_j and d_j of [`by_odd`]; they are read again for every k.
    fn by_prime[T, V](from: &[T], to: &mut [T], roots: &[T], prime: usize, left: usize, done: usize) {
        let (len, part) = (done * COLUMNS, done * left * COLUMNS);
        let line = |j: usize, start: usize| from.get(j * part + start..).unwrap_or(&[]);
        for (p, out) in to.chunks_exact_mut(prime * len).enumerate() {
            for k in 0..=prime / 2 {
                let mirrored = if k == 0 { 0 } else { prime - k };
                let w: [V; 2] = root(roots, p * k * done);
                let v: [V; 2] = root(roots, p * mirrored * done);
                for start in (0..len).step_by(COLUMNS) {
                    for lane in (0..COMPLEX).step_by(<V as Vector>::LANES) {
                        let at = p * len + start;
                        let mut parts: [[V; 2]; 2] = [read(line(0, at), lane), [V::splat(T::ZERO); 2]];
                        for j in 1..=prime / 2 {
                            let folded = [read(line(j, at), lane), read(line(prime - j, at), lane)];
                            parts = with_next(parts, root(roots, j * k % prime * left * done), folded);
                        }
                        let [low, high] = of_ends(parts, [w, v]);
                        write(low, &mut out[k * len + start..], lane);
                        if mirrored > 0 {
                            write(high, &mut out[mirrored * len + start..], lane);
                        }
                    }
                }
            }
        }
    }
}
