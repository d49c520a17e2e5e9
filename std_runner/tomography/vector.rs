//! Three numbers, and what cameras need of them.

/// A place or a way; in a plane the third number is 0.
pub(crate) type Vector = [f64; 3];

/// a . b.
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b.
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// a times a number.
pub(super) fn scaled(a: Vector, by: f64) -> Vector {
    a.map(|x| x * by)
}

/// a - b.
pub(crate) fn minus(a: Vector, b: Vector) -> Vector {
    core::array::from_fn(|axis| a[axis] - b[axis])
}

/// a with length 1; nothing of no length.
pub(super) fn unit(a: Vector) -> Option<Vector> {
    let length = dot(a, a).sqrt();
    (length > 1e-12 && length.is_finite()).then(|| scaled(a, 1.0 / length))
}

/// x with rows x = right, by Cramer's rule; nothing where the rows lie in a plane.
pub(super) fn solve(rows: [Vector; 3], right: Vector) -> Option<Vector> {
    let [a, b, c] = rows;
    let whole = dot(a, cross(b, c));
    let size = [a, b, c].map(|row| dot(row, row).sqrt()).iter().product::<f64>();
    if !(whole.abs() > 1e-9 * size) {
        return None;
    }
    let parts = [cross(b, c), cross(c, a), cross(a, b)];
    Some(core::array::from_fn(|axis| {
        (0..3).map(|row| right[row] * parts[row][axis]).sum::<f64>() / whole
    }))
}
