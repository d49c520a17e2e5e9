//! What the walk is compared with.

use super::kernel::Blur;
use super::settings::{Deblur, Restorer};
use crate::real::Real;

/// What a baseline works on.
pub(super) struct Work<'a, 'm, T> {
    pub problem: &'a Deblur<'a>,
    pub blur: Blur<'a, T>,
    pub measured: &'a [T],
    pub residual: &'a mut [T],
    pub mask: &'a [u16],
    pub planes: &'a mut [T],
    pub work: &'a mut [&'m mut [T]; 4],
}

/// One iteration; `first` says that it is the first one.
pub(super) fn iterate<T: Real>(method: Restorer, work: Work<'_, '_, T>, first: bool) {
    match method {
        Restorer::Walk => {}
        Restorer::RichardsonLucy => richardson_lucy(work),
        Restorer::Wiener => wiener(work),
        Restorer::PrimalDual => primal_dual(work, first),
    }
}

/// p *= f^T (q / (f * p)) / f^T 1, the border replicated from the image's edge before and the quotient after (Richardson 1972, Lucy 1974).
/// One kernel sums to 1, so that f^T 1 is 1; those of different pixels meet in a sum that is not, and would leave bands.
fn richardson_lucy<T: Real>(work: Work<'_, '_, T>) {
    let frame = work.blur.frame;
    let (wide, side) = (frame.wide(), 2 * frame.border + 1);
    let [quotient, ..] = work.work;
    for (channel, plane) in work.planes.chunks_exact_mut(frame.unknowns()).enumerate() {
        let start = channel * frame.pixels();
        let Some(measured) = work.measured.get(start..start + frame.pixels()) else {
            return;
        };
        work.blur.apply(plane, quotient);
        for (quotient, measured) in quotient.iter_mut().zip(measured) {
            let seen = quotient.to_f64().max(1e-12);
            *quotient = T::from_f64(measured.to_f64().max(0.0) / seen);
        }
        for pixel in 0..frame.pixels() {
            let (x, y) = (pixel % frame.width, pixel / frame.width);
            let (mut sum, mut light) = (0.0, 0.0);
            for number in 0..side * side {
                // Kernel number k reaches pixel x + k - R, or the nearest that there is.
                let near =
                    |at: usize, k: usize, count: usize| (at + k).saturating_sub(frame.border).min(count - 1);
                let other =
                    near(y, number / side, frame.height) * frame.width + near(x, number % side, frame.width);
                let kernel = work.blur.which.get(other).map_or(0, |&which| usize::from(which));
                let value = work.blur.values.get(kernel * side * side + number);
                let quotient = quotient.get(other).map_or(0.0, |quotient| quotient.to_f64());
                let value = value.map_or(0.0, |value| value.to_f64());
                sum += value * quotient;
                light += value;
            }
            if !work.blur.which.is_empty() {
                // What no pixel sees stays as it is.
                sum = if light > 0.0 { sum / light } else { 1.0 };
            }
            if let Some(value) = plane.get_mut(frame.bordered(pixel)) {
                *value = T::from_f64(value.to_f64() * sum);
            }
        }
        for place in 0..frame.unknowns() {
            let from = frame.bordered(frame.nearest(place));
            let value = plane.get(from).copied().unwrap_or_default();
            if let Some(to) = plane.get_mut(place) {
                *to = value;
            }
        }
        debug_assert!(wide > 0);
    }
}

fn inner<T: Real>(one: &[T], other: &[T]) -> f64 {
    one.iter()
        .zip(other)
        .map(|(one, other)| one.to_f64() * other.to_f64())
        .sum()
}

/// `iterations` steps of conjugate gradients on (F^T M F + k) p = F^T M q, from where p is.
fn wiener<T: Real>(work: Work<'_, '_, T>) {
    let frame = work.blur.frame;
    let noise = work.problem.tuning.gamma;
    let [way, rest, image_of, image] = work.work;
    for (channel, plane) in work.planes.chunks_exact_mut(frame.unknowns()).enumerate() {
        let range = channel * frame.pixels()..(channel + 1) * frame.pixels();
        let (Some(residual), Some(mask)) = (work.residual.get(range.clone()), work.mask.get(range)) else {
            return;
        };
        work.blur.transpose(residual, mask, rest);
        for (rest, value) in rest.iter_mut().zip(&*plane) {
            *rest = T::from_f64(rest.to_f64() - noise * value.to_f64());
        }
        way.copy_from_slice(rest);
        let mut size = inner(rest, rest);
        let begun = size;
        for _ in 0..work.problem.tuning.iterations {
            if !(size > 1e-12 * begun) {
                break;
            }
            work.blur.apply(way, image);
            work.blur.transpose(image, mask, image_of);
            for (of, way) in image_of.iter_mut().zip(&**way) {
                *of = T::from_f64(of.to_f64() + noise * way.to_f64());
            }
            let step = size / inner(way, image_of).max(f64::MIN_POSITIVE);
            for ((value, way), (rest, of)) in
                plane.iter_mut().zip(&**way).zip(rest.iter_mut().zip(&**image_of))
            {
                *value = T::from_f64(value.to_f64() + step * way.to_f64());
                *rest = T::from_f64(rest.to_f64() - step * of.to_f64());
            }
            let now = inner(rest, rest);
            let turn = now / size;
            for (way, rest) in way.iter_mut().zip(&**rest) {
                *way = T::from_f64(rest.to_f64() + turn * way.to_f64());
            }
            size = now;
        }
    }
}

/// Step of the primal and of the dual: the norm of (f, forward differences) is at most 3.
const STEP: f64 = 1.0 / 3.0;

/// Chambolle & Pock (2011) for `atv`: duals of the residual and of both differences, theta = 1.
fn primal_dual<T: Real>(work: Work<'_, '_, T>, first: bool) {
    let frame = work.blur.frame;
    let (wide, high, plane) = (frame.wide(), frame.high(), frame.unknowns());
    let Work {
        problem,
        blur,
        measured,
        residual,
        mask,
        planes,
        work: [seen, across, down, ahead],
    } = work;
    if first {
        ahead.copy_from_slice(planes);
        for dual in [&mut **seen, across, down] {
            dual.fill(T::ZERO);
        }
    }
    let gamma = problem.tuning.gamma;
    for channel in 0..frame.channels {
        let (image, own) = (
            channel * frame.pixels()..(channel + 1) * frame.pixels(),
            channel * plane..(channel + 1) * plane,
        );
        let (Some(ahead), Some(values)) = (ahead.get_mut(own.clone()), planes.get_mut(own.clone())) else {
            return;
        };
        let (Some(across), Some(down)) = (across.get_mut(own.clone()), down.get_mut(own)) else {
            return;
        };
        let (Some(seen), Some(space)) = (seen.get_mut(image.clone()), residual.get_mut(image.clone())) else {
            return;
        };
        let (Some(measured), Some(mask)) = (measured.get(image.clone()), mask.get(image)) else {
            return;
        };
        blur.apply(ahead, space);
        for (((seen, space), measured), &mask) in seen.iter_mut().zip(&*space).zip(measured).zip(mask) {
            let moved = seen.to_f64() + STEP * (space.to_f64() - measured.to_f64());
            *seen = T::from_f64(f64::from(mask) * moved / (1.0 + STEP));
        }
        let at = |of: &[T], place: usize| of.get(place).map_or(0.0, |value| value.to_f64());
        for place in 0..plane {
            let (x, y) = (place % wide, place / wide);
            let here = at(ahead, place);
            let dx = if x + 1 < wide {
                at(ahead, place + 1) - here
            } else {
                0.0
            };
            let dy = if y + 1 < high {
                at(ahead, place + wide) - here
            } else {
                0.0
            };
            for (dual, difference) in [(&mut *across, dx), (&mut *down, dy)] {
                if let Some(dual) = dual.get_mut(place) {
                    *dual = T::from_f64((dual.to_f64() + STEP * difference).clamp(-gamma, gamma));
                }
            }
        }
        for place in 0..plane {
            let (x, y) = (place % wide, place / wide);
            let mut fall = blur.gains([x, y], seen, mask)[0];
            fall -= if x + 1 < wide { at(across, place) } else { 0.0 };
            fall += if x > 0 { at(across, place - 1) } else { 0.0 };
            fall -= if y + 1 < high { at(down, place) } else { 0.0 };
            fall += if y > 0 { at(down, place - wide) } else { 0.0 };
            let before = at(values, place);
            let mut now = before - STEP * fall;
            if problem.tuning.nonnegative {
                now = now.max(0.0);
            }
            if let (Some(value), Some(ahead)) = (values.get_mut(place), ahead.get_mut(place)) {
                *value = T::from_f64(now);
                *ahead = T::from_f64(2.0 * now - before);
            }
        }
    }
}
