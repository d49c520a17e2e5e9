//! Where a flow should stay as it is when it gets new solid cells.

use thurible_core::Boundary;

/// What matters nowhere has this importance; what matters most has 1.
const LEAST: f64 = 0.1;
/// Cells from a solid one within which less and less matters.
const NEAR: f64 = 3.0;
/// Beyond so many cells nothing of that is left.
const REACH: isize = 14;

/// Squared distance of each cell from the nearest solid one, in cells, as far as it reaches: the least of each axis in turn
/// (Felzenszwalb & Huttenlocher 2012, Distance transforms of sampled functions).
pub(super) fn distances(cells: &[usize], boundary: &[Boundary], solid: &[bool]) -> Vec<f64> {
    let most = (REACH * REACH) as f64;
    let mut now: Vec<f64> = solid
        .iter()
        .map(|&solid| if solid { 0.0 } else { most })
        .collect();
    let mut stride = 1;
    for (&count, end) in cells.iter().zip(boundary) {
        let before = now.clone();
        for (index, now) in now.iter_mut().enumerate() {
            let at = (index / stride % count) as isize;
            let first = index - at as usize * stride;
            for offset in -REACH..=REACH {
                let mut place = at + offset;
                if *end == Boundary::Periodic {
                    place = place.rem_euclid(count as isize);
                }
                let value = usize::try_from(place).ok().filter(|&place| place < count);
                let value = value.and_then(|place| before.get(first + place * stride));
                if let Some(value) = value {
                    *now = now.min(value + (offset * offset) as f64);
                }
            }
        }
        stride *= count;
    }
    now
}

/// W = 0.1 + 0.9 rho / max rho (1 - exp(-(distance / 3)^2)): dyed smoke keeps its flow, but for what is near a solid cell.
pub(super) fn importance(smoke: &[f64], squared: &[f64]) -> Vec<f64> {
    let largest = smoke.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    smoke
        .iter()
        .zip(squared)
        .map(|(smoke, squared)| {
            let away = 1.0 - (-squared / (NEAR * NEAR)).exp();
            LEAST + (1.0 - LEAST) * (smoke / largest).clamp(0.0, 1.0) * away
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_to_the_nearest_solid_cell() {
        let (cells, ends) = ([9, 7], [Boundary::Periodic, Boundary::Wall]);
        let solid: Vec<bool> = (0..63).map(|cell| cell == 9 + 1 || cell == 5 * 9 + 4).collect();
        let found = distances(&cells, &ends, &solid);
        for (cell, found) in found.iter().enumerate() {
            let (x, y) = ((cell % 9) as isize, (cell / 9) as isize);
            let to = |sx: isize, sy: isize| {
                let across = (x - sx).abs().min(9 - (x - sx).abs());
                (across * across + (y - sy) * (y - sy)) as f64
            };
            assert_eq!(*found, to(1, 1).min(to(4, 5)), "cell {cell}");
        }
    }

    #[test]
    fn smoke_matters_more_than_air_and_less_beside_a_solid_cell() {
        let found = importance(&[0.0, 2.0, 2.0], &[100.0, 100.0, 1.0]);
        assert_eq!(found[0], LEAST);
        assert!(found[1] > 0.999 && found[2] < 0.3 && found[2] > LEAST);
    }
}
