//! Resampling along one axis at a time: area averages where cells are coarser than samples, linear in between where
//! they are finer, the identity where they agree.

/// What lies beyond the first and last sample.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Edge {
    /// The outermost sample again.
    Clamp,
    /// The samples repeat.
    Wrap,
    /// Nothing: a cell whose middle lies outside has no taps, every other one is clamped.
    Empty,
}

/// The samples that one cell takes, each with its weight.
pub(super) type Taps = Vec<(usize, f64)>;

/// Taps of `cells` cells of `step` samples each, the first beginning at sample coordinate `start`.
///
/// A cell averages piecewise constant samples over a window as wide as itself, or one sample wide if that is more.
pub(super) fn windows(cells: usize, samples: usize, start: f64, step: f64, edge: Edge) -> Vec<Taps> {
    let half = 0.5 * step.max(1.0);
    let window = |cell: usize| {
        let middle = start + (cell as f64 + 0.5) * step;
        let (low, high) = (middle - half, middle + half);
        let mut taps = Taps::new();
        if edge == Edge::Empty && !(0.0..=samples as f64).contains(&middle) {
            return taps;
        }
        let mut add = |index: i64, from: f64, to: f64| {
            let overlap = high.min(to) - low.max(from);
            if overlap > 1e-12 {
                taps.push((sample_at(index, samples, edge), overlap / (2.0 * half)));
            }
        };
        let (mut first, mut last) = (low.floor() as i64, high.ceil() as i64);
        if edge != Edge::Wrap {
            // Beyond the ends there is one sample, however wide the window is.
            (first, last) = (first.max(0), last.min(samples as i64));
            add(-1, f64::NEG_INFINITY, 0.0);
        }
        for index in first..last {
            add(index, index as f64, (index + 1) as f64);
        }
        if edge != Edge::Wrap {
            add(samples as i64, samples as f64, f64::INFINITY);
        }
        taps
    };
    (0..cells).map(window).collect()
}

/// An array of `shape` [x, y, ..] samples, which fill the box, on the cells of `canvas`.
pub(super) fn resampled(values: Vec<f64>, shape: &[usize], canvas: &super::Canvas) -> Vec<f64> {
    let axes = shape.iter().zip(&canvas.cells).enumerate();
    let taps = axes.map(|(axis, (&samples, &cells))| {
        let edge = if canvas.repeats(axis) {
            Edge::Wrap
        } else {
            Edge::Clamp
        };
        windows_of_box(cells, samples, edge)
    });
    resample(values, shape, &taps.collect::<Vec<_>>())
}

/// Taps of an axis whose samples fill the box from side to side.
pub(super) fn windows_of_box(cells: usize, samples: usize, edge: Edge) -> Vec<Taps> {
    windows(cells, samples, 0.0, samples as f64 / cells as f64, edge)
}

fn sample_at(index: i64, samples: usize, edge: Edge) -> usize {
    let count = samples as i64;
    match edge {
        Edge::Clamp | Edge::Empty => index.clamp(0, count - 1) as usize,
        Edge::Wrap => index.rem_euclid(count) as usize,
    }
}

/// Applies one list of taps an axis, x (the fastest) first, to an array of `shape` [x, y, ..] samples.
pub(super) fn resample(values: Vec<f64>, shape: &[usize], taps: &[Vec<Taps>]) -> Vec<f64> {
    let mut values = values;
    let mut inner = 1;
    for (&samples, taps) in shape.iter().zip(taps) {
        values = along(&values, inner, samples, taps);
        inner *= taps.len();
    }
    values
}

/// Applies the taps of one axis, along which there are `samples` of `inner` values each.
pub(super) fn along(values: &[f64], inner: usize, samples: usize, taps: &[Taps]) -> Vec<f64> {
    let mut out = Vec::with_capacity(values.len() / samples * taps.len());
    for slab in values.chunks_exact(inner * samples) {
        for cell in taps {
            let begin = out.len();
            out.resize(begin + inner, 0.0);
            for &(sample, weight) in cell {
                let row = &slab[sample * inner..(sample + 1) * inner];
                out[begin..]
                    .iter_mut()
                    .zip(row)
                    .for_each(|(sum, value)| *sum += weight * value);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_size_is_the_identity() {
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        let taps = [
            windows_of_box(4, 4, Edge::Clamp),
            windows_of_box(3, 3, Edge::Wrap),
        ];
        assert_eq!(resample(values.clone(), &[4, 3], &taps), values);
    }

    #[test]
    fn coarser_cells_average_and_finer_cells_interpolate() {
        let half = windows_of_box(2, 4, Edge::Clamp);
        assert_eq!(resample(vec![1.0, 3.0, 5.0, 7.0], &[4], &[half]), [2.0, 6.0]);
        let twice = windows_of_box(4, 2, Edge::Clamp);
        assert_eq!(resample(vec![0.0, 4.0], &[2], &[twice]), [0.0, 1.0, 3.0, 4.0]);
        let wrapped = windows_of_box(4, 2, Edge::Wrap);
        assert_eq!(resample(vec![0.0, 4.0], &[2], &[wrapped]), [1.0, 1.0, 3.0, 3.0]);
    }

    #[test]
    fn a_window_of_any_width_has_a_tap_for_each_sample_and_end() {
        let taps = windows(3, 4, -1.5e12 + 2.0, 1e12, Edge::Empty);
        assert_eq!(taps.iter().map(Vec::len).collect::<Vec<_>>(), [0, 6, 0]);
        let sum: f64 = taps[1].iter().map(|(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }

    #[test]
    fn beyond_an_empty_edge_there_is_nothing() {
        let taps = windows(4, 2, -1.0, 1.0, Edge::Empty);
        assert_eq!(resample(vec![5.0, 6.0], &[2], &[taps]), [0.0, 5.0, 6.0, 0.0]);
    }
}
