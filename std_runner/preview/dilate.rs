//! Cells within so many cells along every axis.

use crate::keyframes::Canvas;

/// The cells of which one of `cells` is within `reach` cells along each axis.
pub(super) fn dilated(canvas: &Canvas, cells: &[bool], reach: usize) -> Vec<bool> {
    let mut wide = cells.to_vec();
    let mut stride = 1;
    for (axis, &count) in canvas.cells.iter().enumerate() {
        let slab = stride * count;
        let before = wide.clone();
        for (number, out) in wide.chunks_exact_mut(slab.max(1)).enumerate() {
            for line in 0..stride {
                let at = |place: usize| {
                    before
                        .get(number * slab + place * stride + line)
                        .copied()
                        .unwrap_or(false)
                };
                let near = nearest(count, canvas.repeats(axis), at);
                for (place, near) in near.into_iter().enumerate() {
                    if let Some(slot) = out.get_mut(place * stride + line) {
                        *slot = near <= reach;
                    }
                }
            }
        }
        stride = slab;
    }
    wide
}

/// How far each of `count` places is from one where `at` holds, along a line or a ring.
fn nearest(count: usize, ring: bool, at: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut near = vec![usize::MAX; count];
    let rounds = if ring { 2 } else { 1 };
    for backwards in [false, true] {
        let mut last = usize::MAX;
        for step in 0..rounds * count {
            let place = if backwards {
                count - 1 - step % count
            } else {
                step % count
            };
            last = if at(place) { 0 } else { last.saturating_add(1) };
            if let Some(slot) = near.get_mut(place) {
                *slot = (*slot).min(last);
            }
        }
    }
    near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_found_along_both_axes_and_around_a_ring() {
        let canvas = Canvas {
            cells: vec![6, 5],
            periodic: vec![true, false],
            length: 1.0,
        };
        let one: Vec<bool> = (0..30).map(|cell| cell == 6).collect();
        let wide = dilated(&canvas, &one, 1);
        let found: Vec<usize> = (0..30).filter(|&cell| wide[cell]).collect();
        assert_eq!(found, [0, 1, 5, 6, 7, 11, 12, 13, 17]);
    }
}
