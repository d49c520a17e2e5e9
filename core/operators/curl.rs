//! The curl of a potential at faces.

/// Which differences make component `axis` of a curl: component of the potential, the axis along which it differs, sign.
///
/// d psi_c / d b - d psi_b / d c with (a, b, c) turning; in 2D psi stands along z, as the first component, and the second term is 0.
#[must_use]
pub fn turns(dims: usize, axis: usize) -> [(usize, usize, f64); 2] {
    match (dims, axis) {
        (2, 0) => [(0, 1, 1.0), (0, 1, 0.0)],
        (2, _) => [(0, 0, -1.0), (0, 0, 0.0)],
        _ => {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            [(c, b, 1.0), (b, c, -1.0)]
        }
    }
}
