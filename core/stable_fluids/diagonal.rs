//! One diagonal of a Gauss-Seidel sweep: loops over vectors of cells that do not know of each other.

use super::skew::Skew;
use crate::real::Real;

/// The numbers of a kernel.
#[derive(Clone, Copy)]
pub(super) struct Kernel<T> {
    /// How cells lie by diagonals.
    pub skew: Skew,
    /// a / c.
    pub k: T,
    /// What the cell itself is multiplied by for a ghost before and behind it, along the shorter axis, the longer one and z: the ghost of a
    /// wall is the cell, or minus the cell. 0 where the axis is periodic.
    pub own: [T; 3],
    /// Whether cells are taken from the last to the first.
    pub backwards: bool,
}

/// The last `count` of some numbers.
#[inline(always)]
pub(super) fn tail<T>(of: &[T], count: usize) -> &[T] {
    of.get(of.len().saturating_sub(count)..).unwrap_or_default()
}

/// One diagonal of number `number`, ghosts counted. `beside` has the diagonals before and behind it, `z` in 3D the same diagonal of the planes
/// before and behind, and what the cell itself counts for a wall there.
#[inline(always)]
pub(super) fn relax_diagonal<T: Real>(
    kernel: &Kernel<T>,
    number: usize,
    x: &mut [T],
    [before, behind]: [&[T]; 2],
    b: &[T],
    z: Option<([&[T]; 2], T)>,
) {
    let [short, long] = kernel.skew.sides;
    let first = number.saturating_sub(long).max(1);
    let last = short.min(number.saturating_sub(1));
    if first > last || number > short + long {
        return;
    }
    let (span, count) = (first..last + 1, last + 1 - first);
    let Some(x) = x.get_mut(span.clone()) else { return };
    let [Some(b), Some(low), Some(lower), Some(high), Some(higher)] = [
        b.get(span.clone()),
        before.get(first - 1..last),
        before.get(span.clone()),
        behind.get(span.clone()),
        behind.get(first + 1..last + 2),
    ] else {
        return;
    };
    // Walls are at the ends of a diagonal alone.
    let [own_short, own_long, _] = kernel.own;
    let pick = |wall: bool, own: T| if wall { own } else { T::ZERO };
    let at_first = pick(first == 1, own_short) + pick(number - first == long, own_long);
    let at_last = pick(last == short, own_short) + pick(number - last == 1, own_long);
    let olds = [
        x.first().copied().unwrap_or(T::ZERO),
        x.last().copied().unwrap_or(T::ZERO),
    ];
    match z {
        None => run(x, b, [low, lower, high, higher], kernel.k),
        Some((beside, own)) => {
            let [Some(under), Some(over)] = beside.map(|plane| plane.get(span.clone())) else {
                return;
            };
            if own == T::ZERO {
                run_3d(x, b, [low, lower, high, higher, under, over], kernel.k);
            } else {
                x.iter_mut().for_each(|x| *x = own * *x);
                run_wall(x, b, [low, lower, high, higher, under, over], kernel.k);
            }
        }
    }
    if let Some(x) = x.first_mut() {
        *x += at_first * olds[0];
    }
    if let Some(x) = x.get_mut(count - 1) {
        *x += at_last * olds[1];
    }
}

/// Lanes of the loops over a diagonal.
const LANES: usize = 8;

/// A loop over equal slices, by whole vectors and one number at a time behind them.
macro_rules! by_lanes {
    ($x:ident, $again:literal, [$($from:ident),+], $each:expr) => {{
        let count = $x.len();
        {
            let (whole, _) = $x.as_chunks_mut::<LANES>();
            $(let ($from, _) = $from.as_chunks::<LANES>();)+
            let mut turn = 0;
            for x in whole {
                $(let Some($from) = $from.get(turn) else { return };)+
                // All is read before anything is written, so that compilers need not ask what overlaps.
                *x = core::array::from_fn(|lane| $each(x[lane], $($from[lane]),+));
                turn += 1;
            }
        }
        if count.is_multiple_of(LANES) {
            return;
        }
        // What is left is done again with some of what was done, where that gives the same.
        if $again && count >= LANES {
            let (Some(x), $(Some($from)),+) = ($x.last_chunk_mut::<LANES>(), $($from.last_chunk::<LANES>()),+) else {
                return;
            };
            *x = core::array::from_fn(|lane| $each(x[lane], $($from[lane]),+));
            return;
        }
        let (_, rest) = $x.as_chunks_mut::<LANES>();
        $(let (_, $from) = $from.as_chunks::<LANES>();)+
        let mut turn = 0;
        for x in rest {
            $(let Some(&$from) = $from.get(turn) else { return };)+
            *x = $each(*x, $($from),+);
            turn += 1;
        }
    }};
}

#[inline(always)]
fn run<T: Real>(x: &mut [T], b: &[T], [low, lower, high, higher]: [&[T]; 4], k: T) {
    by_lanes!(
        x,
        true,
        [b, low, lower, high, higher],
        |_, b, low: T, lower, high: T, higher| b + k * ((low + lower) + (high + higher))
    );
}

#[inline(always)]
fn run_3d<T: Real>(x: &mut [T], b: &[T], [low, lower, high, higher, under, over]: [&[T]; 6], k: T) {
    by_lanes!(
        x,
        true,
        [b, low, lower, high, higher, under, over],
        |_, b, low: T, lower, high: T, higher, under: T, over| b + k
            * (((low + lower) + (high + higher)) + (under + over))
    );
}

/// As [`run_3d`], added to what `x` holds.
#[inline(always)]
fn run_wall<T: Real>(x: &mut [T], b: &[T], [low, lower, high, higher, under, over]: [&[T]; 6], k: T) {
    by_lanes!(
        x,
        false,
        [b, low, lower, high, higher, under, over],
        |x: T, b, low: T, lower, high: T, higher, under: T, over| x
            + (b + k * (((low + lower) + (high + higher)) + (under + over)))
    );
}
