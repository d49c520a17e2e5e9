//! A camera without perspective, in front of the box, a little to the right and above; z is up.

/// Turned from the front to the right, in radians.
const TURN: f32 = 0.42;
/// Raised above the floor, in radians.
const RAISE: f32 = 0.36;
/// Samples across the picture.
const ACROSS: usize = 256;
/// Samples from top to bottom, at most.
const DOWN: usize = 512;
/// Margin about the box, in parts of its width.
const MARGIN: f32 = 0.05;

pub(super) type Vector = [f32; 3];

/// Parallel rays through a box of cells; positions are in cells.
pub(super) struct Camera {
    pub width: usize,
    pub height: usize,
    cells: Vector,
    right: Vector,
    up: Vector,
    forward: Vector,
    /// Cells a sample.
    pitch: f32,
    /// Upper left corner on the picture plane.
    corner: [f32; 2],
    /// The edges of the box that show, on the picture plane.
    edges: Vec<[[f32; 2]; 2]>,
}

/// The part of a ray within the box.
pub(super) struct Ray {
    pub origin: Vector,
    pub near: f32,
    pub far: f32,
}

impl Camera {
    pub fn new(cells: [usize; 3]) -> Self {
        let cells = cells.map(|count| count as f32);
        let (turn, raise) = ((TURN.sin(), TURN.cos()), (RAISE.sin(), RAISE.cos()));
        let right = [turn.1, turn.0, 0.0];
        let forward = [-turn.0 * raise.1, turn.1 * raise.1, -raise.0];
        let up = [-turn.0 * raise.0, turn.1 * raise.0, raise.1];
        let mut camera = Self {
            width: ACROSS,
            height: 1,
            cells,
            right,
            up,
            forward,
            pitch: 1.0,
            corner: [0.0; 2],
            edges: Vec::new(),
        };
        let corners = camera.corners().map(|corner| camera.project(corner));
        let bound = |axis: usize, pick: fn(f32, f32) -> f32| {
            corners
                .iter()
                .map(|corner| corner[axis])
                .reduce(pick)
                .unwrap_or(0.0)
        };
        let (left, right) = (bound(0, f32::min), bound(0, f32::max));
        let (bottom, top) = (bound(1, f32::min), bound(1, f32::max));
        let margin = MARGIN * (right - left).max(top - bottom);
        let size = [right - left + 2.0 * margin, top - bottom + 2.0 * margin];
        camera.pitch = (size[0] / ACROSS as f32).max(size[1] / DOWN as f32);
        camera.width = (size[0] / camera.pitch).round().max(1.0) as usize;
        camera.height = (size[1] / camera.pitch).round().max(1.0) as usize;
        camera.corner = [left - margin, top + margin];
        camera.edges = camera.visible_edges();
        camera
    }

    /// The ray through a pixel, if it meets the box.
    pub fn ray(&self, column: usize, row: usize) -> Option<Ray> {
        let [across, above] = self.place(column, row);
        let origin: Vector = core::array::from_fn(|axis| {
            0.5 * self.cells[axis] + across * self.right[axis] + above * self.up[axis]
        });
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        for ((origin, forward), cells) in origin.iter().zip(self.forward).zip(self.cells) {
            let ends = [0.0, cells].map(|side| (side - origin) / forward);
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        (near < far).then_some(Ray { origin, near, far })
    }

    /// The point of a ray at a distance.
    pub fn along(&self, ray: &Ray, distance: f32) -> Vector {
        core::array::from_fn(|axis| ray.origin[axis] + distance * self.forward[axis])
    }

    /// Where the rays leave the box: is it the floor?
    pub fn floor(&self, ray: &Ray) -> Option<Vector> {
        let end = self.along(ray, ray.far);
        (end[2].abs() < 1e-2).then_some(end)
    }

    /// How close a pixel is to an edge of the box, in pixels; the three edges at the nearest corner do not count.
    pub fn edge_distance(&self, column: usize, row: usize) -> f32 {
        let place = self.place(column, row);
        self.edges
            .iter()
            .map(|&[from, to]| distance(place, from, to))
            .fold(f32::INFINITY, f32::min)
            / self.pitch
    }

    fn place(&self, column: usize, row: usize) -> [f32; 2] {
        [
            self.corner[0] + (column as f32 + 0.5) * self.pitch,
            self.corner[1] - (row as f32 + 0.5) * self.pitch,
        ]
    }

    fn corners(&self) -> [Vector; 8] {
        core::array::from_fn(|corner| {
            core::array::from_fn(|axis| {
                if (corner >> axis) & 1 == 1 {
                    self.cells[axis]
                } else {
                    0.0
                }
            })
        })
    }

    fn project(&self, point: Vector) -> [f32; 2] {
        let offset: Vector = core::array::from_fn(|axis| point[axis] - 0.5 * self.cells[axis]);
        [dot(offset, self.right), dot(offset, self.up)]
    }

    fn visible_edges(&self) -> Vec<[[f32; 2]; 2]> {
        let corners = self.corners();
        let nearest = (0..3)
            .filter(|&axis| self.forward[axis] < 0.0)
            .map(|axis| 1 << axis)
            .sum::<usize>();
        let mut edges = Vec::new();
        for corner in 0..8_usize {
            for other in [1, 2, 4].map(|bit| corner | bit) {
                if other != corner && other != nearest && corner != nearest {
                    edges.push([self.project(corners[corner]), self.project(corners[other])]);
                }
            }
        }
        edges
    }
}

fn dot(left: Vector, right: Vector) -> f32 {
    left[0] * right[0] + left[1] * right[1] + left[2] * right[2]
}

fn distance(point: [f32; 2], from: [f32; 2], to: [f32; 2]) -> f32 {
    let (side, offset) = (
        [to[0] - from[0], to[1] - from[1]],
        [point[0] - from[0], point[1] - from[1]],
    );
    let square = (side[0] * side[0] + side[1] * side[1]).max(1e-12);
    let part = ((offset[0] * side[0] + offset[1] * side[1]) / square).clamp(0.0, 1.0);
    (offset[0] - part * side[0]).hypot(offset[1] - part * side[1])
}
