//! The colours that pixels gather at.

use super::plane::Frame;
use super::prior::{Clusters, MOST_COLOURS};
use crate::real::Real;

/// Passes of the search.
const PASSES: usize = 8;

/// Searches the colours by K-means, from those of before or, `first`, from colours of the image between its darkest and its brightest.
pub(super) fn gather<T: Real>(clusters: &mut Clusters, frame: &Frame, planes: &[T], first: bool) {
    let plane = frame.unknowns();
    let count = clusters.count;
    let colour = |place: usize| -> [f64; 3] {
        core::array::from_fn(|channel| {
            let value = planes.get(channel * plane + place);
            value
                .filter(|_| channel < frame.channels)
                .map_or(0.0, |value| value.to_f64())
        })
    };
    if first {
        // From the darkest to the brightest, evenly.
        let brightness = |place: usize| colour(place).iter().sum::<f64>();
        let ends = (0..plane)
            .map(brightness)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
        for number in 0..count {
            let wanted = ends.0 + (ends.1 - ends.0) * (number as f64 + 0.5) / count as f64;
            let off = |place: &usize| (brightness(*place) - wanted).abs();
            let near = (0..plane).min_by(|one, other| off(one).total_cmp(&off(other)));
            if let (Some(slot), Some(near)) = (clusters.colours.get_mut(number), near) {
                *slot = colour(near);
            }
        }
    }
    for _ in 0..PASSES {
        let mut sums = [([0.0; 3], 0.0); MOST_COLOURS];
        for place in 0..plane {
            let own = colour(place);
            let far = |other: &[f64; 3]| -> f64 {
                own.iter()
                    .zip(other)
                    .map(|(one, other)| (one - other) * (one - other))
                    .sum()
            };
            let used = clusters.colours.iter().take(count).enumerate();
            let nearest = used.min_by(|one, other| far(one.1).total_cmp(&far(other.1)));
            if let Some((sum, number)) = nearest.and_then(|(number, _)| sums.get_mut(number)) {
                sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
                *number += 1.0;
            }
        }
        for (colour, (sum, number)) in clusters.colours.iter_mut().zip(sums) {
            if number > 0.0 {
                *colour = sum.map(|sum| sum / number);
            }
        }
    }
}
