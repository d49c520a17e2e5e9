//! Fields between their places, plainly: Catmull-Rom along every axis, one place at a time.

use thurible_core::grid::Grid;

/// The weights of the values at -1, 0, 1, 2 for a place `t` beyond 0.
fn weights(t: f64) -> [f64; 4] {
    [
        (-t + 2.0 * t * t - t * t * t) / 2.0,
        (2.0 - 5.0 * t * t + 3.0 * t * t * t) / 2.0,
        (t + 4.0 * t * t - 3.0 * t * t * t) / 2.0,
        (-t * t + t * t * t) / 2.0,
    ]
}

/// Value `i` of an axis of `n`, and its sign: rings wrap; cells are mirrored at walls, faces along their own axis odd about them.
fn beyond(grid: &Grid, axis: usize, i: isize, faces: bool) -> (usize, f64) {
    let n = grid.n[axis] as isize;
    if grid.axis(axis).is_ring() {
        return (i.rem_euclid(n) as usize, 1.0);
    }
    if faces {
        let sign = if i < 0 || i > n { -1.0 } else { 1.0 };
        let i = if i < 0 {
            -i
        } else if i > n {
            2 * n - i
        } else {
            i
        };
        return if i == 0 || i == n {
            (0, 0.0)
        } else {
            (i as usize, sign)
        };
    }
    let i = if i < 0 {
        -1 - i
    } else if i >= n {
        2 * n - 1 - i
    } else {
        i
    };
    (i as usize, 1.0)
}

/// A field of cells, or the component of a field of faces along `own`, at a place in cells from the low corner.
pub fn at(grid: &Grid, field: &[f64], own: Option<usize>, place: [f64; 3]) -> f64 {
    let mut terms = vec![([0usize; 3], 1.0)];
    for axis in 0..grid.dims {
        let faces = own == Some(axis);
        let x = if faces { place[axis] } else { place[axis] - 0.5 };
        let first = (x + 1e-12).floor();
        let weights = weights(x - first);
        terms = terms
            .into_iter()
            .flat_map(|(at, weight)| {
                (0..4).map(move |k| {
                    let (i, sign) = beyond(grid, axis, first as isize + k as isize - 1, faces);
                    let mut at = at;
                    at[axis] = i;
                    (at, weight * sign * weights[k])
                })
            })
            .collect();
    }
    terms
        .into_iter()
        .map(|(at, weight)| weight * field[grid.index(at)])
        .sum()
}
