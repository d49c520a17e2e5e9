//! Triangles and lines on a picture, each pixel the mean of nine samples.

use crate::output::{Colours, Picture};

/// Samples of a pixel along an axis.
const FINE: usize = 3;

/// Red, green and blue.
pub(super) type Colour = [f64; 3];

/// A white picture.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    samples: Vec<[u8; 3]>,
}

impl Canvas {
    /// A picture of `width` x `height` pixels.
    pub fn new(width: usize, height: usize) -> Self {
        let (width, height) = (width * FINE, height * FINE);
        Self {
            width,
            height,
            samples: vec![[255; 3]; width * height],
        }
    }

    /// Calls `inside` with the middle of every sample in a box of pixels, and paints those that it says are inside.
    fn paint(&mut self, low: [f64; 2], high: [f64; 2], colour: Colour, inside: impl Fn([f64; 2]) -> bool) {
        let scale = FINE as f64;
        let bound = |x: f64, most: usize| (x * scale).clamp(0.0, most as f64) as usize;
        let paint = colour.map(|part| part.clamp(0.0, 255.0) as u8);
        let (left, right) = (bound(low[0], self.width), bound(high[0] + 1.0, self.width));
        for y in bound(low[1], self.height)..bound(high[1] + 1.0, self.height) {
            let row = self
                .samples
                .iter_mut()
                .skip(y * self.width + left)
                .take(right.saturating_sub(left));
            for (x, sample) in (left..right).zip(row) {
                if inside([(x as f64 + 0.5) / scale, (y as f64 + 0.5) / scale]) {
                    *sample = paint;
                }
            }
        }
    }

    /// Fills a triangle.
    pub fn triangle(&mut self, corners: [[f64; 2]; 3], colour: Colour) {
        let [a, b, c] = corners;
        let side = |p: [f64; 2], q: [f64; 2], x: [f64; 2]| {
            (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0])
        };
        let least = |k: usize| a[k].min(b[k]).min(c[k]);
        let most = |k: usize| a[k].max(b[k]).max(c[k]);
        let turn = side(a, b, c).signum();
        self.paint([least(0), least(1)], [most(0), most(1)], colour, |x| {
            [side(a, b, x), side(b, c, x), side(c, a, x)]
                .iter()
                .all(|side| side * turn >= 0.0)
        });
    }

    /// A line of `thickness` pixels.
    pub fn line(&mut self, [p, q]: [[f64; 2]; 2], thickness: f64, colour: Colour) {
        let half = 0.5 * thickness;
        let along = [q[0] - p[0], q[1] - p[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let low = [p[0].min(q[0]) - half, p[1].min(q[1]) - half];
        let high = [p[0].max(q[0]) + half, p[1].max(q[1]) + half];
        self.paint(low, high, colour, |x| {
            let part = ((x[0] - p[0]) * along[0] + (x[1] - p[1]) * along[1]) / square.max(f64::MIN_POSITIVE);
            let part = part.clamp(0.0, 1.0);
            let apart = [x[0] - p[0] - part * along[0], x[1] - p[1] - part * along[1]];
            apart[0] * apart[0] + apart[1] * apart[1] <= half * half
        });
    }

    /// A disc.
    pub fn dot(&mut self, at: [f64; 2], radius: f64, colour: Colour) {
        self.line([at, at], 2.0 * radius, colour);
    }

    /// The picture.
    pub fn picture(&self) -> Picture {
        let (width, height) = (self.width / FINE, self.height / FINE);
        let mut bytes = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0usize; 3];
                for row in 0..FINE {
                    let begin = (y * FINE + row) * self.width + x * FINE;
                    for sample in self.samples.iter().skip(begin).take(FINE) {
                        sum.iter_mut()
                            .zip(sample)
                            .for_each(|(sum, part)| *sum += usize::from(*part));
                    }
                }
                bytes.extend(sum.map(|sum| (sum / (FINE * FINE)) as u8));
            }
        }
        Picture {
            width,
            height,
            bytes,
            colours: Colours::Each,
        }
    }
}
