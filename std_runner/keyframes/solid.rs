//! Bodies that are known by their signed distance: negative inside, positive outside.
//!
//! In 2D every point and every centre has z = 0, so that one formula serves both.

/// A body with a signed distance.
pub(super) trait Solid {
    /// Distance from `point` to the surface, negative inside.
    fn distance(&self, point: [f64; 3]) -> f64;
}

/// What belongs to a body of a cell whose middle lies so many cells outside of its surface: 0.5 - 0.5 tanh(distance).
pub(super) fn soft(cells: f64) -> f64 {
    0.5 - 0.5 * cells.tanh()
}

/// A circle or a sphere.
pub(super) struct Ball {
    pub center: [f64; 3],
    pub radius: f64,
}

/// An axis-parallel box; `half` is infinite along an axis that is not there.
pub(super) struct Block {
    pub center: [f64; 3],
    pub half: [f64; 3],
}

/// A torus about `axis` (a unit vector); a ring in 2D, where the axis is z.
pub(super) struct Torus {
    pub center: [f64; 3],
    pub axis: [f64; 3],
    pub radius: f64,
    pub tube: f64,
}

/// All points within `radius` of a segment.
pub(super) struct Capsule {
    pub from: [f64; 3],
    pub to: [f64; 3],
    pub radius: f64,
}

impl Solid for Ball {
    fn distance(&self, point: [f64; 3]) -> f64 {
        norm(minus(point, self.center)) - self.radius
    }
}

impl Solid for Block {
    fn distance(&self, point: [f64; 3]) -> f64 {
        let offset = minus(point, self.center);
        let beyond: [f64; 3] = core::array::from_fn(|axis| offset[axis].abs() - self.half[axis]);
        let outside = norm(beyond.map(|side| side.max(0.0)));
        let inside = beyond[0].max(beyond[1]).max(beyond[2]).min(0.0);
        outside + inside
    }
}

impl Solid for Torus {
    fn distance(&self, point: [f64; 3]) -> f64 {
        let offset = minus(point, self.center);
        let along = dot(offset, self.axis);
        let radial = (dot(offset, offset) - along * along).max(0.0).sqrt();
        (radial - self.radius).hypot(along) - self.tube
    }
}

impl Solid for Capsule {
    fn distance(&self, point: [f64; 3]) -> f64 {
        let (side, offset) = (minus(self.to, self.from), minus(point, self.from));
        let square = dot(side, side);
        let along = if square > 0.0 {
            (dot(offset, side) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        norm(minus(offset, side.map(|component| along * component))) - self.radius
    }
}

/// Their difference, axis by axis.
pub(super) fn minus(left: [f64; 3], right: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|axis| left[axis] - right[axis])
}

/// Their scalar product.
pub(super) fn dot(left: [f64; 3], right: [f64; 3]) -> f64 {
    left[0] * right[0] + left[1] * right[1] + left[2] * right[2]
}

/// Euclidean length.
pub(super) fn norm(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}
