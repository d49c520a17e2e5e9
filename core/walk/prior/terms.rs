//! Changes of the sums by a sample of +m and of -m, over the patch about it.

use super::patch::Patch;
use crate::real::Real;

/// Lanes that sums are taken in, one after the other at the end.
const LANES: usize = 4;

/// Offsets along the axes.
const fn strides<const D: usize, const SIDE: usize>() -> [usize; D] {
    let mut strides = [1; D];
    let mut axis = 1;
    while axis < D {
        strides[axis] = strides[axis - 1] * SIDE;
        axis += 1;
    }
    strides
}

fn sum(lanes: [f64; LANES]) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// Sum over pairs of |d + s| - |d|, with d the pair's difference and s what the sample adds to it.
#[inline(always)]
pub(super) fn sad<const D: usize, const N: usize>(patch: &Patch<D, 4, N>, mass: f64) -> [f64; 2] {
    let mut sums = [[0.0; LANES]; 2];
    // Half of the cells that touch one: those behind it.
    pairs::<D, N, 1>(patch, mass, &mut sums);
    if D > 1 {
        pairs::<D, N, 3>(patch, mass, &mut sums);
        pairs::<D, N, 4>(patch, mass, &mut sums);
        pairs::<D, N, 5>(patch, mass, &mut sums);
    }
    if D > 2 {
        pairs::<D, N, 11>(patch, mass, &mut sums);
        pairs::<D, N, 12>(patch, mass, &mut sums);
        pairs::<D, N, 13>(patch, mass, &mut sums);
        pairs::<D, N, 15>(patch, mass, &mut sums);
        pairs::<D, N, 16>(patch, mass, &mut sums);
        pairs::<D, N, 17>(patch, mass, &mut sums);
        pairs::<D, N, 19>(patch, mass, &mut sums);
        pairs::<D, N, 20>(patch, mass, &mut sums);
        pairs::<D, N, 21>(patch, mass, &mut sums);
    }
    sums.map(sum)
}

/// Those of cells so far apart, in whole vectors from the first pair that has a cell of the footprint on.
#[inline(always)]
fn pairs<const D: usize, const N: usize, const APART: usize>(
    patch: &Patch<D, 4, N>,
    mass: f64,
    sums: &mut [[f64; LANES]; 2],
) {
    let first = (N / 3).saturating_sub(APART);
    let last = N - N / 3;
    let mut place = first;
    while place < last {
        let lanes = if place + LANES + APART <= N {
            LANES
        } else {
            last - place
        };
        for lane in 0..lanes {
            let (here, there) = (place + lane, place + lane + APART);
            let difference = patch.values[here] - patch.values[there];
            let added = mass * (patch.weights[here] - patch.weights[there]);
            let both = match &patch.inside {
                None => 1.0,
                Some(inside) => inside[here] * inside[there],
            };
            let before = difference.abs();
            sums[0][lane] += both * ((difference + added).abs() - before);
            sums[1][lane] += both * ((difference - added).abs() - before);
        }
        place += LANES;
    }
}

/// 1 where a place of the patch lies in the box, else 0.
#[inline(always)]
fn within<const D: usize, const SIDE: usize, const N: usize>(patch: &Patch<D, SIDE, N>, place: usize) -> f64 {
    match &patch.inside {
        None => 1.0,
        Some(inside) => inside[place],
    }
}

/// Sum over cells of the change of the length of the forward differences.
#[inline(always)]
pub(super) fn tv<const D: usize, const N: usize>(patch: &Patch<D, 4, N>, mass: f64) -> [f64; 2] {
    let strides = strides::<D, 4>();
    let [values, weights] = [&patch.values, &patch.weights];
    let (mut plus, mut minus) = (0.0, 0.0);
    // Terms of the footprint, and of the cells just before it along each axis.
    let first = N / 3 - strides[D - 1];
    for place in first..N - N / 3 {
        let (mut before, mut both, mut square) = (0.0, 0.0, 0.0);
        for stride in strides {
            let there = within(patch, place + stride);
            let difference = there * (values[place + stride] - values[place]);
            let added = there * mass * (weights[place + stride] - weights[place]);
            before += difference * difference;
            both += difference * added;
            square += added * added;
        }
        if square * within(patch, place) > 0.0 {
            // |d + s|^2 and |d - s|^2; rounding must not make them negative.
            let [up, down] = [2.0 * both, -2.0 * both].map(|twice| (before + twice + square).max(0.0));
            let before = Real::sqrt(before);
            plus += Real::sqrt(up) - before;
            minus += Real::sqrt(down) - before;
        }
    }
    [plus, minus]
}

/// +-m <L p, L w> + m^2/2 |L w|^2.
#[inline(always)]
pub(super) fn l2<const D: usize, const N: usize>(patch: &Patch<D, 6, N>, mass: f64) -> [f64; 2] {
    let strides = strides::<D, 6>();
    let reach = strides[D - 1];
    let (mut both, mut square) = (0.0, 0.0);
    let laplacian = |of: &[f64; N], place: usize| {
        let mut sum = 0.0;
        for stride in strides {
            for other in [place - stride, place + stride] {
                sum += within(patch, other) * (of[other] - of[place]);
            }
        }
        sum
    };
    for place in reach..N - reach {
        let added = laplacian(&patch.weights, place);
        if added != 0.0 && within(patch, place) > 0.0 {
            both += laplacian(&patch.values, place) * added;
            square += added * added;
        }
    }
    let square = 0.5 * mass * mass * square;
    [mass * both + square, square - mass * both]
}
