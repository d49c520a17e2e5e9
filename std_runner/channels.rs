//! Colours that were given for smoke.

/// Whether frames with so many values along each axis, the last axis of their array first, are more likely pictures in colour than boxes: three or
/// four values, and the other axes longer.
#[must_use]
pub fn has_channels(cells: &[usize]) -> bool {
    matches!(cells, &[channels @ (3 | 4), width, height] if width.min(height) > channels)
}
