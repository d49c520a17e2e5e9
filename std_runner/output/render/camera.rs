//! A camera with perspective that has the whole box in its picture; z is up.

/// Distance from the middle of the box, in parts of its diagonal.
const DISTANCE: f32 = 1.9;
/// Margin about the box, in parts of the picture.
const MARGIN: f32 = 0.035;

pub(super) type Vector = [f32; 3];

/// From where the box is seen, in degrees: turned from the front (small y) to the right, and raised above the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles {
    /// 0 in front, 90 at the right.
    pub azimuth: f32,
    /// 0 level with the box, 90 above it.
    pub elevation: f32,
}

impl Default for Angles {
    fn default() -> Self {
        Self {
            azimuth: 24.0,
            elevation: 14.0,
        }
    }
}

/// Rays through a box of cells; positions are in cells.
pub(super) struct Camera {
    pub width: usize,
    pub height: usize,
    cells: Vector,
    eye: Vector,
    right: Vector,
    up: Vector,
    forward: Vector,
    /// Upper left corner on the plane at distance 1, and a pixel there.
    corner: [f32; 2],
    pitch: f32,
}

/// A ray and the part of it within the box, empty where it misses it.
pub(super) struct Ray {
    pub origin: Vector,
    /// Of length 1.
    pub direction: Vector,
    pub near: f32,
    pub far: f32,
}

impl Camera {
    /// A picture of `width` by `height`.
    pub fn new(cells: [usize; 3], angles: Angles, width: usize, height: usize) -> Self {
        let mut camera = Self::at(cells, angles);
        let [left, right, bottom, top] = camera.window();
        camera.pitch = ((right - left) / width as f32).max((top - bottom) / height as f32);
        (camera.width, camera.height) = (width, height);
        camera.corner = [
            0.5 * (left + right - camera.pitch * width as f32),
            0.5 * (top + bottom + camera.pitch * height as f32),
        ];
        camera
    }

    /// A picture that fits the box, `width` wide and at most `height` high.
    pub fn fitting(cells: [usize; 3], angles: Angles, width: usize, height: usize) -> Self {
        let [left, right, bottom, top] = Self::at(cells, angles).window();
        let pitch = ((right - left) / width as f32).max((top - bottom) / height as f32);
        let size = [right - left, top - bottom].map(|side| (side / pitch).round().max(1.0) as usize);
        Self::new(cells, angles, size[0], size[1])
    }

    fn at(cells: [usize; 3], angles: Angles) -> Self {
        let cells = cells.map(|count| count as f32);
        let (turn, raise) = (
            angles.azimuth.to_radians().sin_cos(),
            angles.elevation.to_radians().sin_cos(),
        );
        let forward = [-turn.0 * raise.1, turn.1 * raise.1, -raise.0];
        let away = DISTANCE * dot(cells, cells).sqrt();
        Self {
            width: 1,
            height: 1,
            cells,
            eye: core::array::from_fn(|axis| 0.5 * cells[axis] - away * forward[axis]),
            right: [turn.1, turn.0, 0.0],
            up: [-turn.0 * raise.0, turn.1 * raise.0, raise.1],
            forward,
            corner: [0.0; 2],
            pitch: 1.0,
        }
    }

    /// Left, right, bottom and top of the box on the plane at distance 1, with a margin.
    fn window(&self) -> [f32; 4] {
        let mut window = [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY];
        for corner in 0..8 {
            let offset: Vector = core::array::from_fn(|axis| {
                let side = if (corner >> axis) & 1 == 1 {
                    self.cells[axis]
                } else {
                    0.0
                };
                side - self.eye[axis]
            });
            let away = dot(offset, self.forward);
            for (axis, place) in [dot(offset, self.right) / away, dot(offset, self.up) / away]
                .into_iter()
                .enumerate()
            {
                window[2 * axis] = window[2 * axis].min(place);
                window[2 * axis + 1] = window[2 * axis + 1].max(place);
            }
        }
        let margin = MARGIN * (window[1] - window[0]).max(window[3] - window[2]);
        [
            window[0] - margin,
            window[1] + margin,
            window[2] - margin,
            window[3] + margin,
        ]
    }

    /// The ray through a place of the picture, in pixels.
    pub fn ray(&self, column: f32, row: f32) -> Ray {
        let across = self.corner[0] + column * self.pitch;
        let above = self.corner[1] - row * self.pitch;
        let way: Vector = core::array::from_fn(|axis| {
            self.forward[axis] + across * self.right[axis] + above * self.up[axis]
        });
        let direction = way.map(|part| part / dot(way, way).sqrt());
        let (mut near, mut far) = (0.0_f32, f32::INFINITY);
        for axis in 0..3 {
            let ends = [0.0, self.cells[axis]].map(|side| (side - self.eye[axis]) / direction[axis]);
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        // A direction along a side divides 0 by 0 there, which `min` and `max` pass over.
        Ray {
            origin: self.eye,
            direction,
            near,
            far: far.max(near),
        }
    }

    /// The way from a point to the eye, of length 1.
    pub fn toward_eye(&self, point: Vector) -> Vector {
        let way: Vector = core::array::from_fn(|axis| self.eye[axis] - point[axis]);
        let length = dot(way, way).sqrt().max(1e-6);
        way.map(|part| part / length)
    }
}

impl Ray {
    /// The point at a distance.
    #[inline]
    pub fn along(&self, distance: f32) -> Vector {
        core::array::from_fn(|axis| self.origin[axis] + distance * self.direction[axis])
    }
}

#[inline]
pub(super) fn dot(left: Vector, right: Vector) -> f32 {
    left[0] * right[0] + left[1] * right[1] + left[2] * right[2]
}
