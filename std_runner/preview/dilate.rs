//! Cells within so many steps.

use crate::keyframes::Canvas;

/// The cells to which a way of at most `reach` steps leads from one of `cells`, each to one of the cells around, past the corners too, and
/// none into a cell where `solid`, unless that is empty, holds.
pub(super) fn dilated(canvas: &Canvas, cells: &[bool], reach: usize, solid: &[bool]) -> Vec<bool> {
    let counts = canvas.cells_3d();
    let mut wide = cells.to_vec();
    let mut front: Vec<usize> = (0..cells.len())
        .filter(|&cell| cells.get(cell) == Some(&true))
        .collect();
    for _ in 0..reach {
        if front.is_empty() {
            break;
        }
        let mut next = Vec::new();
        for cell in front {
            for beside in around(canvas, counts, cell) {
                let is_free = solid.get(beside) != Some(&true);
                if let Some(slot) = wide.get_mut(beside).filter(|slot| is_free && !**slot) {
                    *slot = true;
                    next.push(beside);
                }
            }
        }
        front = next;
    }
    wide
}

/// The cells around one, and itself.
fn around(canvas: &Canvas, counts: [usize; 3], cell: usize) -> impl Iterator<Item = usize> {
    let at = [
        cell % counts[0],
        cell / counts[0] % counts[1],
        cell / (counts[0] * counts[1]),
    ];
    let along = |axis: usize| -> [Option<usize>; 3] {
        let (place, count) = (at[axis], counts[axis]);
        if canvas.repeats(axis) {
            [(place + count - 1) % count, place, (place + 1) % count].map(Some)
        } else {
            [
                place.checked_sub(1),
                Some(place),
                Some(place + 1).filter(|&next| next < count),
            ]
        }
    };
    let [x, y, z] = [along(0), along(1), along(2)];
    let every = z.into_iter().flatten().flat_map(move |z| {
        let rows = y.into_iter().flatten();
        rows.flat_map(move |y| x.into_iter().flatten().map(move |x| [x, y, z]))
    });
    every.map(move |[x, y, z]| x + counts[0] * (y + counts[1] * z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(cells: &[bool]) -> Vec<usize> {
        (0..cells.len()).filter(|&cell| cells[cell]).collect()
    }

    #[test]
    fn cells_are_found_along_both_axes_and_around_a_ring() {
        let canvas = Canvas {
            cells: vec![6, 5],
            periodic: vec![true, false],
            length: 1.0,
        };
        let one: Vec<bool> = (0..30).map(|cell| cell == 6).collect();
        let wide = dilated(&canvas, &one, 1, &[]);
        assert_eq!(found(&wide), [0, 1, 5, 6, 7, 11, 12, 13, 17]);
        assert_eq!(found(&dilated(&canvas, &one, 9, &[])).len(), 30);
    }

    /// The way around a wall counts, and behind one without a gap there is none.
    #[test]
    fn ways_lead_around_solid_cells() {
        let canvas = Canvas {
            cells: vec![5, 4],
            periodic: vec![false, false],
            length: 1.0,
        };
        let one: Vec<bool> = (0..20).map(|cell| cell == 0).collect();
        let wall: Vec<bool> = (0..20).map(|cell| cell % 5 == 2 && cell / 5 < 3).collect();
        let wide = |reach| dilated(&canvas, &one, reach, &wall);
        // From the corner up to the gap are three steps, and two more are behind it.
        assert!(!wide(3)[13] && wide(4)[13] && !wide(5)[4] && wide(6)[4]);
        let whole: Vec<bool> = (0..20).map(|cell| cell % 5 == 2).collect();
        assert_eq!(
            found(&dilated(&canvas, &one, 99, &whole)),
            [0, 1, 5, 6, 10, 11, 15, 16]
        );
    }
}
