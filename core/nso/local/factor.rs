//! The block-tridiagonal system in time: block L D L^T, one cell in each lane.

use super::pace::Pace;
use super::{Kept, at, unroll};
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;

/// The place of (row, column), column <= row, in a packed lower triangle.
#[inline(always)]
pub(super) fn triangle(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// Finishes slot k once slot k + 1 is assembled: its right-hand side, the elimination of slot k - 1 by X_k in `lower`, the factors
/// L_k D_k L_k^T with the reciprocals of D_k on the diagonal, z_k = D_k^-1 L_k^-1 right-hand side, and X_{k+1} = -L_k^-1 M_{k+1},
/// which takes the place of X_k. `diagonal` is what there is on the diagonal beside M^T M.
#[inline(always)]
pub(super) fn eliminate<T: Real, S: Space, V: Vector<Elem = T>>(
    kept: &mut [T],
    lower: &mut [T],
    k: usize,
    slots: usize,
    diagonal: T,
) {
    let (lanes, zero) = (V::LANES, V::splat(T::ZERO));
    let size = Kept::<S>::SIZE * lanes;
    let (before, rest) = kept.split_at_mut(k * size);
    let (now, after) = rest.split_at_mut(size);
    let before = if k > 0 {
        Some(&before[(k - 1) * size..][..size])
    } else {
        None
    };
    let next = if k + 1 < slots { Some(&after[..size]) } else { None };
    let lower = &mut lower[..super::lower::<S>() * lanes];
    let slow = !Pace::<V>::of::<S>(now).is_fast();
    let mut right = [zero; 5];
    unroll!(i < S::FREE; 0 1 2 3 4; {
        right[i] = at::<V>(now, Kept::<S>::RIGHT + i);
        if let Some(next) = next {
            right[i] = right[i] - at::<V>(next, Kept::<S>::FORCE + i);
        }
    });
    let reciprocal = match before.map(Pace::<V>::of::<S>) {
        None => Some(zero),
        Some(Pace::Still(reciprocal)) => Some(reciprocal),
        Some(_) => None,
    };
    // The diagonal of a slow slot, of which only what it is damped by is kept.
    let of_slow = |now: &[T]| at::<V>(now, Kept::<S>::DAMPING) + V::splat(T::ONE) + V::splat(diagonal);
    if let Some(of_before) = reciprocal.filter(|_| slow) {
        let reciprocal = (of_slow(now) - of_before).recip();
        Pace::Still(reciprocal).keep::<S>(now);
        unroll!(i < S::FREE; 0 1 2 3 4; {
            if let Some(before) = before {
                right[i] = right[i] + at::<V>(before, Kept::<S>::RIGHT + i);
            }
            (right[i] * reciprocal).store(&mut now[(Kept::<S>::RIGHT + i) * lanes..]);
        });
        if let Some(next) = next.filter(|next| Pace::<V>::of::<S>(next).is_fast()) {
            unroll!(i < S::FREE; 0 1 2 3 4; {
                reciprocal.store(&mut now[(Kept::<S>::FACTOR + triangle(i, i)) * lanes..]);
                unroll!(j < S::FREE; 0 1 2 3 4; {
                    (-at::<V>(next, Kept::<S>::MATRIX + i * S::FREE + j)).store(&mut lower[(i * S::FREE + j) * lanes..]);
                });
            });
        }
        return;
    }
    let mut l = [[zero; 5]; 5];
    if slow {
        let of_slow = of_slow(now);
        unroll!(i < S::FREE; 0 1 2 3 4; {
            l[i][i] = of_slow;
        });
    } else {
        unroll!(i < S::FREE; 0 1 2 3 4; {
            unroll!(j < i + 1; 0 1 2 3 4; {
                l[i][j] = at::<V>(now, Kept::<S>::FACTOR + triangle(i, j));
            });
        });
    }
    if let Some(before) = before {
        if slow {
            absorb::<S, V, true>(before, lower, &mut right, &mut l);
        } else {
            absorb::<S, V, false>(before, lower, &mut right, &mut l);
        }
    }
    // `l` becomes L D, `unit` L with the reciprocals of D.
    let mut unit = l;
    unroll!(j < S::FREE; 0 1 2 3 4; {
        unroll!(i < S::FREE; 0 1 2 3 4; {
            if i >= j {
                unroll!(k < j; 0 1 2 3; {
                    l[i][j] = l[i][j] - l[i][k] * unit[j][k];
                });
                unit[i][j] = if i == j { l[j][j].recip() } else { l[i][j] * unit[j][j] };
            }
        });
    });
    unroll!(i < S::FREE; 0 1 2 3 4; {
        unroll!(j < i; 0 1 2 3; {
            right[i] = right[i] - unit[i][j] * right[j];
        });
        (right[i] * unit[i][i]).store(&mut now[(Kept::<S>::RIGHT + i) * lanes..]);
        unroll!(j < i + 1; 0 1 2 3 4; {
            unit[i][j].store(&mut now[(Kept::<S>::FACTOR + triangle(i, j)) * lanes..]);
        });
    });
    let Some(next) = next else { return };
    if Pace::<V>::of::<S>(next).is_fast() {
        unroll!(column < S::FREE; 0 1 2 3 4; {
            let mut x = [zero; 5];
            unroll!(i < S::FREE; 0 1 2 3 4; {
                x[i] = -at::<V>(next, Kept::<S>::MATRIX + i * S::FREE + column);
                unroll!(j < i; 0 1 2 3; {
                    x[i] = x[i] - unit[i][j] * x[j];
                });
                x[i].store(&mut lower[(i * S::FREE + column) * lanes..]);
            });
        });
    } else {
        // M is 1, so X is -L^-1, of which only the lower triangle is written.
        unroll!(column < S::FREE; 0 1 2 3 4; {
            let mut x = [-V::splat(T::ONE); 5];
            unroll!(i < S::FREE; 0 1 2 3 4; {
                if i > column {
                    x[i] = -(unit[i][column] * x[column]);
                    unroll!(j < i; 1 2 3; {
                        if j > column {
                            x[i] = x[i] - unit[i][j] * x[j];
                        }
                    });
                }
                if i >= column {
                    x[i].store(&mut lower[(i * S::FREE + column) * lanes..]);
                }
            });
        });
    }
}

/// The elimination of the slot `before` by X in `lower`, of which only the lower triangle is there if `TRIANGLE`.
#[inline(always)]
fn absorb<S: Space, V: Vector, const TRIANGLE: bool>(
    before: &[V::Elem],
    lower: &[V::Elem],
    right: &mut [V; 5],
    l: &mut [[V; 5]; 5],
) {
    unroll!(m < S::FREE; 0 1 2 3 4; {
        let (z, pivot): (V, V) = (at(before, Kept::<S>::RIGHT + m), at(before, Kept::<S>::FACTOR + triangle(m, m)));
        unroll!(i < S::FREE; 0 1 2 3 4; {
            if !TRIANGLE || i <= m {
                let x = at::<V>(lower, m * S::FREE + i);
                right[i] = right[i] - x * z;
                let x = x * pivot;
                unroll!(j < i + 1; 0 1 2 3 4; {
                    l[i][j] = l[i][j] - x * at::<V>(lower, m * S::FREE + j);
                });
            }
        });
    });
}

/// y_k = L_k^-T (z_k + D_k^-1 L_k^-1 M_{k+1} y_{k+1}) from M_{k+1} y_{k+1}, 0 behind the last slot.
#[inline(always)]
pub(super) fn solve_factor<T: Real, S: Space, V: Vector<Elem = T>>(now: &[T], image: &[V; 5]) -> [V; 5] {
    let (mut l, mut y) = ([[image[0]; 5]; 5], *image);
    if let Pace::Still(reciprocal) = Pace::<V>::of::<S>(now) {
        unroll!(i < S::FREE; 0 1 2 3 4; {
            y[i] = reciprocal * y[i] + at::<V>(now, Kept::<S>::RIGHT + i);
        });
        return y;
    }
    unroll!(i < S::FREE; 0 1 2 3 4; {
        unroll!(j < i + 1; 0 1 2 3 4; {
            l[i][j] = at::<V>(now, Kept::<S>::FACTOR + triangle(i, j));
        });
        unroll!(j < i; 0 1 2 3; {
            y[i] = y[i] - l[i][j] * y[j];
        });
    });
    unroll!(i < S::FREE; 4 3 2 1 0; {
        y[i] = l[i][i] * y[i] + at::<V>(now, Kept::<S>::RIGHT + i);
        unroll!(j < S::FREE; 1 2 3 4; {
            if j > i {
                y[i] = y[i] - l[j][i] * y[j];
            }
        });
    });
    y
}

/// M_k y.
#[inline(always)]
pub(super) fn times_m<T: Real, S: Space, V: Vector<Elem = T>>(now: &[T], y: &[V; 5]) -> [V; 5] {
    let mut image = *y;
    if !Pace::<V>::of::<S>(now).is_fast() {
        return image;
    }
    unroll!(i < S::FREE; 0 1 2 3 4; {
        image[i] = at::<V>(now, Kept::<S>::MATRIX + i * S::FREE) * y[0];
        unroll!(j < S::FREE; 1 2 3 4; {
            image[i] = image[i] + at::<V>(now, Kept::<S>::MATRIX + i * S::FREE + j) * y[j];
        });
    });
    image
}
