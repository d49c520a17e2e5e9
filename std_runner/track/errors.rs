//! How far a flow is from the true one, in cells a frame, at cell centres.

use thurible_core::{Boundary, Real};

/// Error measures of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    /// sqrt(mean |u - U|^2).
    pub rms: f64,
    /// That in parts of sqrt(mean |U|^2); none where the truth rests.
    pub relative: Option<f64>,
    /// sqrt(sum |U| theta^2 / sum |U|), theta the angle between u and U in degrees; 0 where the truth rests, of which no direction is missed.
    pub angular: f64,
}

/// A flow at faces, x fastest, and what it lives on.
pub(super) struct Measure<'a> {
    /// Cells along x, y (and z).
    pub cells: &'a [usize],
    /// How each axis ends.
    pub boundary: &'a [Boundary],
    /// Cells a frame that a velocity of 1 is.
    pub scale: f64,
}

impl Measure<'_> {
    /// The errors of `own` against `truth`, one component an axis.
    pub fn errors<T: Real>(&self, own: &[Vec<T>], truth: &[Vec<f64>]) -> Errors {
        let count: usize = self.cells.iter().product();
        let (mut gaps, mut sizes, mut turned, mut weight) = (0.0, 0.0, 0.0, 0.0);
        for cell in 0..count {
            let (mut gap, mut size, mut own_size, mut dot) = (0.0, 0.0, 0.0, 0.0);
            for (axis, (own, truth)) in own.iter().zip(truth).enumerate() {
                let periodic = self.boundary.get(axis) == Some(&Boundary::Periodic);
                let faces = faces(self.cells, (axis, periodic), cell);
                let mean =
                    |value: &dyn Fn(usize) -> f64| 0.5 * self.scale * (value(faces[0]) + value(faces[1]));
                let u = mean(&|face| own.get(face).map_or(0.0, |value| value.to_f64()));
                let v = mean(&|face| truth.get(face).copied().unwrap_or(0.0));
                gap += (u - v) * (u - v);
                size += v * v;
                own_size += u * u;
                dot += u * v;
            }
            let across = (size * own_size - dot * dot).max(0.0).sqrt();
            let angle = if own_size == 0.0 {
                90.0
            } else {
                across.atan2(dot).to_degrees()
            };
            gaps += gap;
            sizes += size;
            turned += size.sqrt() * angle * angle;
            weight += size.sqrt();
        }
        let rms = (gaps / count as f64).sqrt();
        let size = (sizes / count as f64).sqrt();
        Errors {
            rms,
            relative: (size > 0.0).then(|| rms / size),
            angular: if weight > 0.0 {
                (turned / weight).sqrt()
            } else {
                0.0
            },
        }
    }
}

/// The low and the high face of a cell along an axis, in a list of faces of which there is one more than cells unless it is periodic.
pub(super) fn faces(cells: &[usize], (axis, periodic): (usize, bool), cell: usize) -> [usize; 2] {
    let (mut rest, mut at, mut stride) = (cell, [0; 2], 1);
    for (along, &cells) in cells.iter().enumerate() {
        let place = rest % cells;
        rest /= cells;
        let (faces, high) = match (along == axis, periodic) {
            (true, true) => (cells, (place + 1) % cells),
            (true, false) => (cells + 1, place + 1),
            (false, _) => (cells, place),
        };
        at[0] += place * stride;
        at[1] += high * stride;
        stride *= faces;
    }
    at
}
