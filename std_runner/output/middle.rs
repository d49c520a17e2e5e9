//! From faces to the centres of cells.

/// The mean of the two faces of each cell across `axis`, of `faces` that are `counts` along x, y and z. On a ring the last cell's other face is the first.
pub(crate) fn middle(faces: &[f64], cells: [usize; 3], counts: [usize; 3], axis: usize) -> Vec<f64> {
    let strides = [1, counts[0], counts[0] * counts[1]];
    let mut values = Vec::with_capacity(cells.iter().product());
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let at = [x, y, z];
                let place: usize = (0..3).map(|axis| at[axis] * strides[axis]).sum();
                let beyond = if at[axis] + 1 == counts[axis] {
                    place - at[axis] * strides[axis]
                } else {
                    place + strides[axis]
                };
                let of = |place: usize| faces.get(place).copied().unwrap_or(0.0);
                values.push(0.5 * (of(place) + of(beyond)));
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::middle;

    #[test]
    fn the_middle_is_the_mean_of_two_faces() {
        let walls = middle(&[0.0, 2.0, 6.0], [2, 1, 1], [3, 1, 1], 0);
        assert_eq!(walls, [1.0, 4.0]);
        let ring = middle(&[1.0, 3.0, 5.0, 7.0], [2, 2, 1], [2, 2, 1], 1);
        assert_eq!(ring, [3.0, 5.0, 3.0, 5.0]);
    }
}
