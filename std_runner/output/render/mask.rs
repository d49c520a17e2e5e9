//! What is drawn over a plane of smoke: how much of each pixel lines and arrows cover, with smooth edges.

/// A place in a picture, in pixels from its upper left corner.
pub(super) type Spot = [f32; 2];

/// Parts of pixels that are covered. Shapes that overlap cover no more than the one that covers most.
pub(super) struct Mask {
    width: usize,
    parts: Vec<f32>,
}

impl Mask {
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            parts: vec![0.0; width * height],
        }
    }

    /// A line with round ends, `radius` wide to either side.
    pub fn line(&mut self, from: Spot, to: Spot, radius: f32, alpha: f32) {
        let along = minus(to, from);
        let square = dot(along, along).max(1e-12);
        self.cover([from, to, to], radius, alpha, |spot| {
            let offset = minus(spot, from);
            let part = (dot(offset, along) / square).clamp(0.0, 1.0);
            let off = minus(offset, along.map(|x| part * x));
            dot(off, off).sqrt() - radius
        });
    }

    /// A triangle, larger by `more` on all sides.
    pub fn triangle(&mut self, corners: [Spot; 3], more: f32, alpha: f32) {
        let [a, b, c] = corners;
        let turn = cross(minus(b, a), minus(c, a)).signum();
        let beyond = |from: Spot, to: Spot, spot: Spot| {
            let along = minus(to, from);
            -turn * cross(along, minus(spot, from)) / dot(along, along).max(1e-12).sqrt()
        };
        self.cover(corners, more, alpha, |spot| {
            beyond(a, b, spot).max(beyond(b, c, spot)).max(beyond(c, a, spot)) - more
        });
    }

    /// Covers by `alpha` what has a negative `distance`, about three corners and `more` around them.
    fn cover(&mut self, corners: [Spot; 3], more: f32, alpha: f32, distance: impl Fn(Spot) -> f32) {
        let height = self.parts.len() / self.width.max(1);
        let span = |axis: usize, most: usize| {
            let [low, high] = [f32::min, f32::max].map(|fold: fn(f32, f32) -> f32| {
                corners
                    .iter()
                    .map(|corner| corner[axis])
                    .reduce(fold)
                    .unwrap_or(0.0)
            });
            let index = |place: f32| place.clamp(0.0, most as f32) as usize;
            index((low - more - 1.0).floor())..index((high + more + 2.0).ceil())
        };
        for y in span(1, height) {
            for x in span(0, self.width) {
                let covered = 0.5 - distance([x as f32 + 0.5, y as f32 + 0.5]);
                if let Some(part) = self.parts.get_mut(y * self.width + x) {
                    *part = part.max(alpha * covered.clamp(0.0, 1.0));
                }
            }
        }
    }

    /// Puts a colour over the light of a picture of the same size.
    pub fn paint(&self, light: &mut [[f32; 3]], colour: [f32; 3]) {
        for (light, &part) in light.iter_mut().zip(&self.parts).filter(|(_, part)| **part > 0.0) {
            for (light, colour) in light.iter_mut().zip(colour) {
                *light += part * (colour - *light);
            }
        }
    }
}

pub(super) fn minus(one: Spot, other: Spot) -> Spot {
    [one[0] - other[0], one[1] - other[1]]
}

fn dot(one: Spot, other: Spot) -> f32 {
    one[0] * other[0] + one[1] * other[1]
}

fn cross(one: Spot, other: Spot) -> f32 {
    one[0] * other[1] - one[1] * other[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_cover_as_much_as_their_area() {
        let area = |mask: &Mask| mask.parts.iter().sum::<f32>();
        let mut line = Mask::new(40, 30);
        line.line([10.3, 8.1], [27.2, 19.6], 2.5, 1.0);
        let length = 16.9_f32.hypot(11.5);
        let expected = 5.0 * length + core::f32::consts::PI * 6.25;
        assert!(
            (area(&line) - expected).abs() < 0.01 * expected,
            "{}",
            area(&line)
        );
        let mut triangle = Mask::new(40, 30);
        triangle.triangle([[5.0, 4.0], [30.0, 9.5], [12.0, 25.0]], 0.0, 0.5);
        let expected = 0.5 * 0.5 * (25.0 * 21.0 - 5.5 * 7.0);
        assert!(
            (area(&triangle) - expected).abs() < 0.01 * expected,
            "{}",
            area(&triangle)
        );
        // What reaches beyond the picture is cut off.
        triangle.line([-50.0, -50.0], [90.0, 80.0], 3.0, 1.0);
        assert!(triangle.parts.iter().all(|part| (0.0..=1.0).contains(part)));
    }
}
