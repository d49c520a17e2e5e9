//! The signed distance to an outline of closed polygons, by the nonzero winding rule.

/// A point in the plane.
pub(super) type Point = [f64; 2];
type Segment = [Point; 2];

/// How far beside a segment its two sides are looked at, in em.
const BESIDE: f64 = 1e-3;
/// Segments are looked at about this often, in em.
const STRIDE: f64 = 0.02;

/// A glyph's outline.
pub(super) struct Outline {
    /// All sides of the polygons, in order: they decide what is inside.
    sides: Vec<Segment>,
    /// The sides that part inside from outside; where contours overlap, the others lie within the ink.
    border: Vec<Segment>,
    low: Point,
    high: Point,
}

impl Outline {
    /// An outline of closed contours; `None` if nothing is inside them.
    pub(super) fn new(contours: &[Vec<Point>]) -> Option<Self> {
        let sides: Vec<Segment> = contours.iter().flat_map(|contour| sides(contour)).collect();
        let border: Vec<Segment> = sides.iter().flat_map(|&side| border_of(side, &sides)).collect();
        let mut outline = Self {
            sides,
            border,
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
        };
        for point in outline.border.iter().flatten() {
            outline.low = [outline.low[0].min(point[0]), outline.low[1].min(point[1])];
            outline.high = [outline.high[0].max(point[0]), outline.high[1].max(point[1])];
        }
        (!outline.border.is_empty()).then_some(outline)
    }

    /// The lower left and the upper right corner of the ink.
    pub(super) fn bounds(&self) -> (Point, Point) {
        (self.low, self.high)
    }

    /// Distance to the border, negative inside; beyond `reach` of the bounds a lower estimate.
    pub(super) fn distance(&self, point: Point, reach: f64) -> f64 {
        let beyond = |axis: usize| {
            (self.low[axis] - point[axis])
                .max(point[axis] - self.high[axis])
                .max(0.0)
        };
        let estimate = beyond(0).hypot(beyond(1));
        if estimate > reach {
            return estimate;
        }
        let distance = self
            .border
            .iter()
            .map(|&side| square_distance(point, side))
            .fold(f64::INFINITY, f64::min)
            .sqrt();
        if winding(point, &self.sides) == 0 {
            distance
        } else {
            -distance
        }
    }
}

fn sides(contour: &[Point]) -> impl Iterator<Item = Segment> {
    let next = contour.iter().cycle().skip(1);
    contour
        .iter()
        .zip(next)
        .map(|(&from, &to)| [from, to])
        .filter(|[from, to]| from != to)
}

/// The parts of `side` that have ink on exactly one hand.
fn border_of(side: Segment, sides: &[Segment]) -> Vec<Segment> {
    let [from, to] = side;
    let (along, across) = (to[0] - from[0], to[1] - from[1]);
    let length = along.hypot(across);
    let pieces = (length / STRIDE).ceil().clamp(1.0, 1000.0) as usize;
    let at = |part: f64| [from[0] + part * along, from[1] + part * across];
    let is_border = |piece: usize| {
        let [x, y] = at((piece as f64 + 0.5) / pieces as f64);
        let (right, up) = (across / length * BESIDE, -along / length * BESIDE);
        (winding([x + right, y + up], sides) == 0) != (winding([x - right, y - up], sides) == 0)
    };
    let kept: Vec<usize> = (0..pieces).filter(|&piece| is_border(piece)).collect();
    if kept.len() == pieces {
        return vec![side];
    }
    let part = |piece: usize| {
        [
            at(piece as f64 / pieces as f64),
            at((piece + 1) as f64 / pieces as f64),
        ]
    };
    kept.into_iter().map(part).collect()
}

/// How often the sides go round `point`, counter-clockwise.
fn winding(point: Point, sides: &[Segment]) -> i32 {
    let mut turns = 0;
    for [from, to] in sides {
        let (below, ends_below) = (from[1] <= point[1], to[1] <= point[1]);
        if below != ends_below {
            let left = (to[0] - from[0]) * (point[1] - from[1]) - (point[0] - from[0]) * (to[1] - from[1]);
            turns += i32::from(below && left > 0.0) - i32::from(ends_below && left < 0.0);
        }
    }
    turns
}

fn square_distance(point: Point, [from, to]: Segment) -> f64 {
    let side = [to[0] - from[0], to[1] - from[1]];
    let offset = [point[0] - from[0], point[1] - from[1]];
    let square = side[0] * side[0] + side[1] * side[1];
    let part = ((offset[0] * side[0] + offset[1] * side[1]) / square).clamp(0.0, 1.0);
    let rest = [offset[0] - part * side[0], offset[1] - part * side[1]];
    rest[0] * rest[0] + rest[1] * rest[1]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Vec<Point> {
        vec![[low, low], [high, low], [high, high], [low, high]]
    }

    #[test]
    fn a_square_has_its_distance() {
        let outline = Outline::new(&[square(0.0, 1.0)]).unwrap();
        assert!((outline.distance([0.5, 0.25], 10.0) + 0.25).abs() < 1e-12);
        assert!((outline.distance([2.0, 0.5], 10.0) - 1.0).abs() < 1e-12);
        assert_eq!(outline.bounds(), ([0.0, 0.0], [1.0, 1.0]));
    }

    #[test]
    fn overlapping_contours_leave_no_seam() {
        let outline = Outline::new(&[square(0.0, 1.0), square(0.5, 1.5)]).unwrap();
        assert!(outline.distance([0.75, 0.75], 10.0) < -0.3);
    }

    #[test]
    fn a_hole_is_outside() {
        let mut hole = square(0.25, 0.75);
        hole.reverse();
        let outline = Outline::new(&[square(0.0, 1.0), hole]).unwrap();
        assert!((outline.distance([0.5, 0.5], 10.0) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn no_area_is_no_outline() {
        assert!(Outline::new(&[]).is_none());
        assert!(Outline::new(&[vec![[0.0, 0.0], [1.0, 0.0]]]).is_none());
    }
}
