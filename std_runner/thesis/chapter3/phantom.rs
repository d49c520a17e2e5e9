//! The modified Shepp-Logan phantom (Toft 1996, The Radon Transform, table of appendix B).

/// Value, half axes, middle, degrees that it is turned by, in a square from -1 to 1.
const ELLIPSES: [[f64; 6]; 10] = [
    [1.0, 0.69, 0.92, 0.0, 0.0, 0.0],
    [-0.8, 0.6624, 0.874, 0.0, -0.0184, 0.0],
    [-0.2, 0.11, 0.31, 0.22, 0.0, -18.0],
    [-0.2, 0.16, 0.41, -0.22, 0.0, 18.0],
    [0.1, 0.21, 0.25, 0.0, 0.35, 0.0],
    [0.1, 0.046, 0.046, 0.0, 0.1, 0.0],
    [0.1, 0.046, 0.046, 0.0, -0.1, 0.0],
    [0.1, 0.046, 0.023, -0.08, -0.605, 0.0],
    [0.1, 0.023, 0.023, 0.0, -0.606, 0.0],
    [0.1, 0.023, 0.046, 0.06, -0.605, 0.0],
];
/// Places along a side of a cell whose mean it is.
const FINE: usize = 8;

/// The phantom on `side` x `side` cells.
pub(super) fn phantom(side: usize) -> Vec<f64> {
    let at = |place: usize| 2.0 * (place as f64 + 0.5) / (side * FINE) as f64 - 1.0;
    let cell = |cell: usize| {
        let part = |part: usize| {
            let x = at(cell % side * FINE + part % FINE);
            let y = at(cell / side * FINE + part / FINE);
            ELLIPSES.iter().map(|ellipse| inside(ellipse, x, y)).sum::<f64>()
        };
        (0..FINE * FINE).map(part).sum::<f64>() / (FINE * FINE) as f64
    };
    (0..side * side).map(cell).collect()
}

fn inside(&[value, a, b, x0, y0, degrees]: &[f64; 6], x: f64, y: f64) -> f64 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let along = ((x - x0) * cos + (y - y0) * sin) / a;
    let across = ((y - y0) * cos - (x - x0) * sin) / b;
    if along * along + across * across <= 1.0 {
        value
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phantom_is_a_skull() {
        let side = 64;
        let values = phantom(side);
        assert_eq!(values[0], 0.0);
        let middle = values[side / 2 * side + side / 2];
        assert!((middle - 0.2).abs() < 0.11, "{middle}");
        let bone = values.iter().copied().fold(0.0, f64::max);
        assert!((bone - 1.0).abs() < 1e-12);
        let mean = values.iter().sum::<f64>() / (side * side) as f64;
        assert!((mean - 0.12).abs() < 0.02, "{mean}");
    }
}
