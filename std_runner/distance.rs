//! How far one field is from another.

/// The Euclidean distance of pairs of values, in parts of the size of the second ones.
pub(crate) fn relative_l2(pairs: impl IntoIterator<Item = [f64; 2]>) -> f64 {
    let (mut apart, mut size) = (0.0, 0.0);
    for [one, other] in pairs {
        apart += (one - other) * (one - other);
        size += other * other;
    }
    (apart / f64::max(size, f64::MIN_POSITIVE)).sqrt()
}
