//! A surface of triangles, as a file has it.

use std::path::Path;

use crate::keyframes::error::Fault;
use crate::keyframes::whole::whole;

/// A point in space.
pub(super) type Point = [f64; 3];

/// More triangles than this are refused.
pub(super) const MOST_TRIANGLES: usize = 1 << 26;
/// Bytes of memory that a byte of a file may become.
const GROWTH: usize = 8;
/// What to do with a mesh that is too large.
pub(super) const REDUCE: &str = "reduce it: the cells of the grid are coarser than its triangles by far";

/// All bytes of a file that fits into memory with what is made of it.
pub(super) fn bytes_of(path: &Path) -> Result<Vec<u8>, Fault> {
    whole(path, GROWTH, REDUCE)
}

/// Points, and triangles of three of them.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub points: Vec<Point>,
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Adds the triangles of a polygon, a fan from its first corner.
    pub fn polygon(&mut self, corners: &[u32]) -> Result<(), Fault> {
        if let Some((&first, rest)) = corners.split_first() {
            for pair in rest.windows(2) {
                self.triangles.push([first, pair[0], pair[1]]);
            }
        }
        if self.triangles.len() > MOST_TRIANGLES {
            return Err(Fault::content(
                format!("has more than {MOST_TRIANGLES} triangles"),
                REDUCE,
            ));
        }
        Ok(())
    }

    /// The same, if every triangle has its points, all of them are finite, and there are some.
    pub fn checked(self) -> Result<Self, Fault> {
        let count = self.points.len();
        if let Some(odd) = self
            .points
            .iter()
            .find(|point| !point.iter().all(|x| x.is_finite() && x.abs() < 1e30))
        {
            let found = format!("has a point at {odd:?}");
            return Err(Fault::content(
                found,
                "every coordinate must be finite; export it again",
            ));
        }
        let corners = self.triangles.iter().flatten();
        if let Some(missing) = corners.copied().find(|&corner| corner as usize >= count) {
            let found = format!("has a face of point {missing}, counted from 0, and only {count} points");
            return Err(Fault::content(found, "it was cut off: export it again"));
        }
        if self.triangles.is_empty() {
            return Err(Fault::content(
                format!("has {count} points and no faces"),
                "export the surface with its faces; points alone bound no body",
            ));
        }
        Ok(self)
    }

    /// Corners of a triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [Point; 3] {
        triangle.map(|corner| self.points.get(corner as usize).copied().unwrap_or_default())
    }

    /// Lowest and highest coordinates of the points that triangles have.
    pub fn bounds(&self) -> [Point; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in self.triangles.iter().flat_map(|&triangle| self.corners(triangle)) {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        [low, high]
    }
}
