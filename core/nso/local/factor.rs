//! The block-tridiagonal system in time: block L D L^T, one cell in each lane.

use super::form::Form;
use super::lanes::{at, store_at, unroll};
use super::storage::{Stored, form, lower_len, store_form};
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;

/// The place of (row, column), column <= row, in a packed lower triangle.
#[inline(always)]
pub(super) fn triangle(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// Finishes slot k once slot k + 1 is assembled: its right-hand side, the elimination of slot k - 1 by X_k in
/// `lower`, the factors L_k D_k L_k^T with the reciprocals of D_k on the diagonal, z_k = D_k^-1 L_k^-1
/// right-hand side, and X_{k+1} = -L_k^-1 M_{k+1}, which takes the place of X_k. `diagonal` is what is added
/// to M^T M on the diagonal.
#[inline(always)]
pub(super) fn eliminate<T: Real, S: Space, V: Vector<Elem = T>>(
    stored: &mut [T],
    lower: &mut [T],
    k: usize,
    slots: usize,
    diagonal: T,
) {
    let size = Stored::<S>::SIZE * V::LANES;
    let (before, rest) = stored.split_at_mut(k * size);
    let (now, after) = rest.split_at_mut(size);
    let before = if k > 0 {
        Some(&before[(k - 1) * size..][..size])
    } else {
        None
    };
    let next = if k + 1 < slots { Some(&after[..size]) } else { None };
    let lower = &mut lower[..lower_len::<S>() * V::LANES];
    let damped = !form::<S, V>(now).is_full();
    let mut right = [V::splat(T::ZERO); 5];
    unroll!(i < S::FREE; 0 1 2 3 4; {
        right[i] = at::<V>(now, Stored::<S>::RIGHT + i);
        if let Some(next) = next {
            right[i] = right[i] - at::<V>(next, Stored::<S>::FORCE + i);
        }
    });
    let of_before = match before.map(form::<S, V>) {
        None => Some(V::splat(T::ZERO)),
        Some(Form::Scalar(reciprocal)) => Some(reciprocal),
        Some(_) => None,
    };
    if let Some(of_before) = of_before.filter(|_| damped) {
        let reciprocal = (damped_diagonal::<S, V>(now, diagonal) - of_before).recip();
        return eliminate_scalar::<S, V>(before, now, next, right, reciprocal, lower);
    }
    let mut l = block_of::<S, V>(now, damped, diagonal);
    if let Some(before) = before {
        if damped {
            absorb::<S, V, true>(before, lower, &mut right, &mut l);
        } else {
            absorb::<S, V, false>(before, lower, &mut right, &mut l);
        }
    }
    let unit = factorise::<S, V>(l, right, now);
    if let Some(next) = next {
        lower_of::<S, V>(next, &unit, lower);
    }
}

/// The diagonal of the block of a damped slot, of which only the damping is stored.
#[inline(always)]
fn damped_diagonal<S: Space, V: Vector>(now: &[V::Elem], diagonal: V::Elem) -> V
where
    V::Elem: Real,
{
    at::<V>(now, Stored::<S>::DAMPING) + V::splat(V::Elem::ONE) + V::splat(diagonal)
}

/// Finishes a slot whose block, like those of all slots before, is a multiple of the identity, of which
/// `reciprocal` is the reciprocal.
#[inline(always)]
fn eliminate_scalar<S: Space, V: Vector>(
    before: Option<&[V::Elem]>,
    now: &mut [V::Elem],
    next: Option<&[V::Elem]>,
    mut right: [V; 5],
    reciprocal: V,
    lower: &mut [V::Elem],
) where
    V::Elem: Real,
{
    store_form::<S, V>(Form::Scalar(reciprocal), now);
    unroll!(i < S::FREE; 0 1 2 3 4; {
        if let Some(before) = before {
            right[i] = right[i] + at::<V>(before, Stored::<S>::RIGHT + i);
        }
        store_at(right[i] * reciprocal, now, Stored::<S>::RIGHT + i);
    });
    if let Some(next) = next.filter(|next| form::<S, V>(next).is_full()) {
        unroll!(i < S::FREE; 0 1 2 3 4; {
            store_at(reciprocal, now, Stored::<S>::FACTOR + triangle(i, i));
            unroll!(j < S::FREE; 0 1 2 3 4; {
                store_at(-at::<V>(next, Stored::<S>::MATRIX + i * S::FREE + j), lower, i * S::FREE + j);
            });
        });
    }
}

/// The lower triangle of the block of a slot.
#[inline(always)]
fn block_of<S: Space, V: Vector>(now: &[V::Elem], damped: bool, diagonal: V::Elem) -> [[V; 5]; 5]
where
    V::Elem: Real,
{
    let mut l = [[V::splat(V::Elem::ZERO); 5]; 5];
    if damped {
        let diagonal = damped_diagonal::<S, V>(now, diagonal);
        unroll!(i < S::FREE; 0 1 2 3 4; {
            l[i][i] = diagonal;
        });
    } else {
        unroll!(i < S::FREE; 0 1 2 3 4; {
            unroll!(j < i + 1; 0 1 2 3 4; {
                l[i][j] = at::<V>(now, Stored::<S>::FACTOR + triangle(i, j));
            });
        });
    }
    l
}

/// Factorises a block and solves for z; both are stored. Returns L with the reciprocals of D on its diagonal.
#[inline(always)]
fn factorise<S: Space, V: Vector>(mut l: [[V; 5]; 5], mut right: [V; 5], now: &mut [V::Elem]) -> [[V; 5]; 5] {
    // `l` becomes L D.
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
        store_at(right[i] * unit[i][i], now, Stored::<S>::RIGHT + i);
        unroll!(j < i + 1; 0 1 2 3 4; {
            store_at(unit[i][j], now, Stored::<S>::FACTOR + triangle(i, j));
        });
    });
    unit
}

/// X of the slot `next` from the factor of the slot before it.
#[inline(always)]
fn lower_of<S: Space, V: Vector>(next: &[V::Elem], unit: &[[V; 5]; 5], lower: &mut [V::Elem])
where
    V::Elem: Real,
{
    if form::<S, V>(next).is_full() {
        unroll!(column < S::FREE; 0 1 2 3 4; {
            let mut x = [V::splat(V::Elem::ZERO); 5];
            unroll!(i < S::FREE; 0 1 2 3 4; {
                x[i] = -at::<V>(next, Stored::<S>::MATRIX + i * S::FREE + column);
                unroll!(j < i; 0 1 2 3; {
                    x[i] = x[i] - unit[i][j] * x[j];
                });
                store_at(x[i], lower, i * S::FREE + column);
            });
        });
    } else {
        // M is the identity, so X is -L^-1, of which only the lower triangle is stored.
        unroll!(column < S::FREE; 0 1 2 3 4; {
            let mut x = [-V::splat(V::Elem::ONE); 5];
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
                    store_at(x[i], lower, i * S::FREE + column);
                }
            });
        });
    }
}

/// Eliminates the slot `before` by X in `lower`, of which there is the lower triangle alone if `TRIANGLE`.
#[inline(always)]
fn absorb<S: Space, V: Vector, const TRIANGLE: bool>(
    before: &[V::Elem],
    lower: &[V::Elem],
    right: &mut [V; 5],
    l: &mut [[V; 5]; 5],
) {
    unroll!(m < S::FREE; 0 1 2 3 4; {
        let z: V = at(before, Stored::<S>::RIGHT + m);
        let pivot: V = at(before, Stored::<S>::FACTOR + triangle(m, m));
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
    let mut l = [[image[0]; 5]; 5];
    let mut y = *image;
    if let Form::Scalar(reciprocal) = form::<S, V>(now) {
        unroll!(i < S::FREE; 0 1 2 3 4; {
            y[i] = reciprocal * y[i] + at::<V>(now, Stored::<S>::RIGHT + i);
        });
        return y;
    }
    unroll!(i < S::FREE; 0 1 2 3 4; {
        unroll!(j < i + 1; 0 1 2 3 4; {
            l[i][j] = at::<V>(now, Stored::<S>::FACTOR + triangle(i, j));
        });
        unroll!(j < i; 0 1 2 3; {
            y[i] = y[i] - l[i][j] * y[j];
        });
    });
    unroll!(i < S::FREE; 4 3 2 1 0; {
        y[i] = l[i][i] * y[i] + at::<V>(now, Stored::<S>::RIGHT + i);
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
    if !form::<S, V>(now).is_full() {
        return image;
    }
    unroll!(i < S::FREE; 0 1 2 3 4; {
        image[i] = at::<V>(now, Stored::<S>::MATRIX + i * S::FREE) * y[0];
        unroll!(j < S::FREE; 1 2 3 4; {
            image[i] = image[i] + at::<V>(now, Stored::<S>::MATRIX + i * S::FREE + j) * y[j];
        });
    });
    image
}
