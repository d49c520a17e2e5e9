//! Fields as lists of numbers, x fastest: means over blocks, blurs, textures.

use thurible_core::grid::gaussian::Gaussian;
use thurible_core::walk::Random;

/// Counts along x, y and z; 1 for an axis that is not there.
pub(super) fn sides(counts: &[usize]) -> [usize; 3] {
    core::array::from_fn(|axis| counts.get(axis).copied().unwrap_or(1))
}

/// The faces across `axis` of so many cells.
pub(super) fn faces(cells: &[usize], axis: usize) -> Vec<usize> {
    let mut faces = cells.to_vec();
    faces.iter_mut().skip(axis).take(1).for_each(|count| *count += 1);
    faces
}

/// The mean of `values` over blocks of `span` that are `apart` from each other, for `coarse` blocks of a field of `fine` values.
fn means(
    values: &[f64],
    fine: [usize; 3],
    coarse: [usize; 3],
    apart: [usize; 3],
    span: [usize; 3],
) -> Vec<f64> {
    let share = 1.0 / span.iter().product::<usize>() as f64;
    let mut all = Vec::with_capacity(coarse.iter().product());
    for block in 0..coarse.iter().product::<usize>() {
        let place = [
            block % coarse[0],
            block / coarse[0] % coarse[1],
            block / (coarse[0] * coarse[1]),
        ];
        let mut sum = 0.0;
        for part in 0..span.iter().product::<usize>() {
            let offset = [
                part % span[0],
                part / span[0] % span[1],
                part / (span[0] * span[1]),
            ];
            let [x, y, z]: [usize; 3] = core::array::from_fn(|axis| place[axis] * apart[axis] + offset[axis]);
            sum += values
                .get((z * fine[1] + y) * fine[0] + x)
                .copied()
                .unwrap_or_default();
        }
        all.push(sum * share);
    }
    all
}

/// A density on half as many `cells` along every axis.
pub(super) fn half_of_cells(values: &[f64], cells: &[usize]) -> Vec<f64> {
    let (fine, two) = (sides(cells), block(cells));
    means(
        values,
        fine,
        core::array::from_fn(|axis| fine[axis] / two[axis]),
        two,
        two,
    )
}

/// A component of a flow there: the mean over the faces that lie on a face of the coarser cells, so that no divergence comes in.
pub(super) fn half_of_faces(values: &[f64], cells: &[usize], axis: usize) -> Vec<f64> {
    let (fine, two) = (sides(cells), block(cells));
    let mut span = two;
    span[axis.min(2)] = 1;
    let coarse = core::array::from_fn(|along| fine[along] / two[along] + usize::from(along == axis));
    means(values, sides(&faces(cells, axis)), coarse, two, span)
}

/// Two along the axes that are there.
fn block(cells: &[usize]) -> [usize; 3] {
    core::array::from_fn(|axis| if axis < cells.len() { 2 } else { 1 })
}

/// A density blurred by `sigma` cells along every axis, mirrored at the walls; 0 leaves it.
pub(super) fn blurred(values: &[f64], cells: &[usize], sigma: f64) -> Vec<f64> {
    let mut now = values.to_vec();
    if sigma <= 0.0 {
        return now;
    }
    let gaussian = Gaussian::of(sigma);
    let mut stride = 1;
    for &count in cells {
        let before = now.clone();
        for (index, now) in now.iter_mut().enumerate() {
            let at = index / stride % count;
            let first = index - at * stride;
            let value = |place: usize| before.get(first + place * stride).copied().unwrap_or_default();
            *now = gaussian
                .taps()
                .map(|(offset, tap)| match offset {
                    0 => tap * value(at),
                    _ => {
                        tap * (value(mirrored(at as isize - offset as isize, count))
                            + value(mirrored((at + offset) as isize, count)))
                    }
                })
                .sum();
        }
        stride *= count;
    }
    now
}

/// The place that is seen in the mirrors at both ends.
fn mirrored(place: isize, count: usize) -> usize {
    let count = count as isize;
    let turned = place.rem_euclid(2 * count);
    turned.min(2 * count - 1 - turned) as usize
}

/// Noise between 0 and 1 whose grain is `sigma` cells.
pub(super) fn texture(cells: &[usize], sigma: f64, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed, 0, 0);
    let white: Vec<f64> = (0..cells.iter().product::<usize>())
        .map(|_| random.normal())
        .collect();
    let soft = blurred(&white, cells, sigma);
    let (low, high) = soft
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
            (low.min(value), high.max(value))
        });
    soft.into_iter()
        .map(|value| (value - low) / (high - low).max(f64::MIN_POSITIVE))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The divergence of a flow in cells.
    fn divergence(flow: &[Vec<f64>], cells: &[usize]) -> Vec<f64> {
        let [nx, ny, _] = sides(cells);
        let cell = |index: usize| {
            let (x, y, z) = (index % nx, index / nx % ny, index / (nx * ny));
            let part = |axis: usize| {
                let wide = sides(&faces(cells, axis));
                let at = |place: [usize; 3]| flow[axis][(place[2] * wide[1] + place[1]) * wide[0] + place[0]];
                let mut high = [x, y, z];
                high[axis] += 1;
                at(high) - at([x, y, z])
            };
            (0..cells.len()).map(part).sum()
        };
        (0..cells.iter().product::<usize>()).map(cell).collect()
    }

    #[test]
    fn a_coarser_flow_has_the_divergence_of_the_finer_one() {
        let cells = [6, 4, 8];
        let flow: Vec<Vec<f64>> = (0..3)
            .map(|axis| {
                let count = faces(&cells, axis).iter().product::<usize>();
                let mut random = Random::new(1, axis as u64, 0);
                (0..count).map(|_| random.normal()).collect()
            })
            .collect();
        let coarse: Vec<Vec<f64>> = (0..3)
            .map(|axis| half_of_faces(&flow[axis], &cells, axis))
            .collect();
        let ours = divergence(&coarse, &[3, 2, 4]);
        // What leaves a block leaves through four faces a side, each with the mean of what they have.
        let theirs = half_of_cells(&divergence(&flow, &cells), &cells);
        assert!(
            ours.iter()
                .zip(&theirs)
                .all(|(ours, theirs)| (ours - 2.0 * theirs).abs() < 1e-12)
        );
    }

    #[test]
    fn a_blur_keeps_the_sum_and_a_constant() {
        let noise = texture(&[9, 7, 5], 0.5, 3);
        let soft = blurred(&noise, &[9, 7, 5], 1.5);
        let [before, after]: [f64; 2] = [&noise, &soft].map(|values| values.iter().sum());
        assert!((before - after).abs() < 1e-9 * before && soft != noise);
        assert!(
            blurred(&[2.0; 20], &[4, 5], 3.0)
                .iter()
                .all(|value| (value - 2.0).abs() < 1e-12)
        );
    }
}
