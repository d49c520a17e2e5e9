//! Enlarging by a whole number, by Mitchell and Netravali's cubic: smooth, and hardly ringing.

/// Enlarges a picture of `width` columns; both sides grow by `factor`.
pub(super) fn enlarge(picture: &[f32], width: usize, factor: usize) -> Vec<f32> {
    if factor <= 1 {
        return picture.to_vec();
    }
    let height = picture.len() / width.max(1);
    let taps = taps(factor);
    let mut wide = Vec::with_capacity(picture.len() * factor);
    for row in picture.chunks_exact(width) {
        for column in 0..width {
            for (first, weights) in &taps {
                let at = |tap: usize| row[clamp(column as i64 + first + tap as i64, width)];
                wide.push(
                    weights
                        .iter()
                        .enumerate()
                        .map(|(tap, weight)| weight * at(tap))
                        .sum(),
                );
            }
        }
    }
    let line = width * factor;
    let mut large = Vec::with_capacity(line * height * factor);
    for row in 0..height {
        for (first, weights) in &taps {
            let rows: [&[f32]; 4] = core::array::from_fn(|tap| {
                let from = clamp(row as i64 + first + tap as i64, height);
                &wide[from * line..][..line]
            });
            large.extend(
                (0..line).map(|column| (0..4).map(|tap| weights[tap] * rows[tap][column]).sum::<f32>()),
            );
        }
    }
    large
}

fn clamp(index: i64, count: usize) -> usize {
    index.clamp(0, count as i64 - 1) as usize
}

/// For each of the new pixels within an old one: its first neighbour and the weights of four.
fn taps(factor: usize) -> Vec<(i64, [f32; 4])> {
    let tap = |pixel: usize| {
        let place = (pixel as f32 + 0.5) / factor as f32 - 0.5;
        let first = place.floor() - 1.0;
        let weights = core::array::from_fn(|tap| mitchell(place - first - tap as f32));
        (first as i64, weights)
    };
    (0..factor).map(tap).collect()
}

/// Mitchell and Netravali (1988), B = C = 1/3.
fn mitchell(distance: f32) -> f32 {
    let x = distance.abs();
    if x < 1.0 {
        (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
    } else if x < 2.0 {
        (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_constant() {
        assert!(
            enlarge(&[0.7; 12], 4, 3)
                .iter()
                .all(|value| (value - 0.7).abs() < 1e-5)
        );
    }

    #[test]
    fn sizes_grow_by_the_factor() {
        assert_eq!(enlarge(&[0.0; 12], 4, 5).len(), 12 * 25);
    }
}
