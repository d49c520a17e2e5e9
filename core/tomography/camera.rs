//! Cameras: where a place appears in a picture, how large a pixel is there, and the ray of a pixel. All lengths are in cells.

use crate::real::Real;

/// A camera of a plane (`D` = 2, whose pictures are rows) or of a box (`D` = 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera<const D: usize> {
    /// How it sees.
    pub lens: Lens<D>,
    /// Pixels across and down; one row in a plane.
    pub pixels: [usize; 2],
}

/// How a camera sees. Pixel i has its middle at i + 1/2; row 0 is the first of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens<const D: usize> {
    /// Parallel rays: u = across . x + at\[0\], v = down . x + at\[1\].
    Orthographic {
        /// What u rises along: a unit vector over the pitch.
        across: [f64; D],
        /// The same for v; not used in a plane.
        down: [f64; D],
        /// u and v of the origin.
        at: [f64; 2],
        /// The way of the rays, of length 1.
        forward: [f64; D],
        /// Cells that a pixel is wide.
        pitch: f64,
    },
    /// Rays through an eye: u = (across . (x - eye)) / Z + at\[0\] with Z = forward . (x - eye), v alike.
    Pinhole {
        /// The eye.
        eye: [f64; D],
        /// Focal length in pixels times the way of u.
        across: [f64; D],
        /// The same for v; not used in a plane.
        down: [f64; D],
        /// u and v of what lies straight ahead.
        at: [f64; 2],
        /// Straight ahead, of length 1.
        forward: [f64; D],
    },
}

/// Where a place appears, and what it weighs there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// u and v, in pixels.
    pub at: [f64; 2],
    /// 1 over the area that a pixel covers at the place, across the ray.
    pub weight: f64,
}

#[inline(always)]
pub(super) fn dot<const D: usize>(one: &[f64; D], other: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for axis in 0..D {
        sum += one[axis] * other[axis];
    }
    sum
}

impl<const D: usize> Camera<D> {
    /// How many pixels it has.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pixels[0] * self.pixels[1]
    }

    /// Whether it has none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where `place` appears, be it off the picture; nothing behind a pinhole.
    #[inline(always)]
    #[must_use]
    pub fn see(&self, place: &[f64; D]) -> Option<Seen> {
        match &self.lens {
            Lens::Orthographic {
                across,
                down,
                at,
                pitch,
                ..
            } => {
                let v = if D > 2 { dot(down, place) + at[1] } else { 0.5 };
                let weight = if D > 2 { 1.0 / (pitch * pitch) } else { 1.0 / pitch };
                Some(Seen {
                    at: [dot(across, place) + at[0], v],
                    weight,
                })
            }
            Lens::Pinhole {
                eye,
                across,
                down,
                at,
                forward,
            } => {
                let mut way = *place;
                for axis in 0..D {
                    way[axis] -= eye[axis];
                }
                let depth = dot(forward, &way);
                if !(depth > 1e-9) {
                    return None;
                }
                let near = 1.0 / depth;
                // Over the depth once for the cosine, and for each side of the pixel once.
                let slant = Real::sqrt(dot(&way, &way)) * near;
                let u = dot(across, &way) * near + at[0];
                let focal = Real::sqrt(dot(across, across)) * near;
                let (v, area) = if D > 2 {
                    let high = Real::sqrt(dot(down, down)) * near;
                    (dot(down, &way) * near + at[1], focal * high)
                } else {
                    (0.5, focal)
                };
                Some(Seen {
                    at: [u, v],
                    weight: slant * area,
                })
            }
        }
    }

    /// Start and way, of length 1, of the ray through u and v.
    #[must_use]
    pub fn ray(&self, [u, v]: [f64; 2]) -> ([f64; D], [f64; D]) {
        match &self.lens {
            Lens::Orthographic {
                across,
                down,
                at,
                forward,
                pitch,
            } => {
                let mut start = [0.0; D];
                for axis in 0..D {
                    start[axis] = (u - at[0]) * across[axis] * pitch * pitch;
                    if D > 2 {
                        start[axis] += (v - at[1]) * down[axis] * pitch * pitch;
                    }
                }
                (start, *forward)
            }
            Lens::Pinhole {
                eye,
                across,
                down,
                at,
                forward,
            } => {
                let (wide, high) = (dot(across, across), dot(down, down));
                let mut way = *forward;
                for axis in 0..D {
                    way[axis] += (u - at[0]) * across[axis] / wide;
                    if D > 2 {
                        way[axis] += (v - at[1]) * down[axis] / high;
                    }
                }
                let length = Real::sqrt(dot(&way, &way));
                (*eye, way.map(|part| part / length))
            }
        }
    }
}
