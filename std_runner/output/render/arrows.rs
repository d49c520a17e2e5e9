//! Arrows over a plane of smoke: where a field points, each for the mean of a square of cells.

use super::flat::Stand;
use super::mask::{Mask, Spot};

/// Arrows along the longer side, at most, and pixels from one to the next, at least.
const ALONG: usize = 32;
const APART: f32 = 20.0;
/// The length of the longest arrow, in parts of the way from one to the next.
const LONGEST: f32 = 1.5;
/// Shorter ones, in pixels, are not drawn.
const SHORTEST: f32 = 3.0;
/// Linear red, green and blue: of arrows, and of what stands around them so that they are seen on smoke.
const COLOUR: [f32; 3] = [1.0, 0.24, 0.035];
const AROUND: [f32; 3] = [0.004, 0.004, 0.006];

/// A field of two components at the centres of the cells of a plane.
pub(crate) struct Field {
    /// Cells along x and y.
    pub cells: [usize; 2],
    pub values: Vec<[f32; 2]>,
}

impl Field {
    /// The means over squares of `side` cells, with the centres of these in cells.
    fn squares(&self, side: usize) -> impl Iterator<Item = (Spot, [f32; 2])> {
        let [nx, ny] = self.cells;
        let [columns, rows] = self.cells.map(|count| count.div_ceil(side));
        (0..columns * rows).map(move |square| {
            let [left, low] = [square % columns * side, square / columns * side];
            let [right, high] = [(left + side).min(nx), (low + side).min(ny)];
            let (mut sum, count) = ([0.0; 2], ((right - left) * (high - low)) as f32);
            for row in low..high {
                let cells = self.values.get(row * nx + left..row * nx + right);
                for value in cells.into_iter().flatten() {
                    sum = [sum[0] + value[0], sum[1] + value[1]];
                }
            }
            let centre = [0.5 * (left + right) as f32, 0.5 * (low + high) as f32];
            (centre, sum.map(|sum| sum / count))
        })
    }

    /// The size of the largest mean.
    pub fn strongest(&self, side: usize) -> f32 {
        let sizes = self.squares(side).map(|(_, [x, y])| x.hypot(y));
        sizes.fold(0.0, f32::max)
    }
}

/// Cells along a side of the squares that have an arrow each, in a picture where a cell has so many `pixels`.
pub(crate) fn side(cells: [usize; 2], pixels: f32) -> usize {
    let longest = cells[0].max(cells[1]);
    longest.div_ceil(ALONG).max((APART / pixels).ceil() as usize)
}

/// Draws `field` over a picture; an arrow of the size `strongest` is the longest, and lengths go with the square root of sizes.
pub(super) fn draw(light: &mut [[f32; 3]], stand: &Stand, field: &Field, strongest: f32) {
    let pixels = stand.pixels(field.cells[0]);
    let side = side(field.cells, pixels);
    let apart = pixels * side as f32;
    let mut around = Mask::new(stand.width, stand.height);
    let mut arrows = Mask::new(stand.width, stand.height);
    for (centre, [x, y]) in field.squares(side) {
        let size = x.hypot(y);
        let share = (size / strongest).sqrt().min(1.0);
        let length = LONGEST * apart * share;
        if !(length >= SHORTEST) {
            continue;
        }
        let arrow = Arrow {
            centre: stand.spot(field.cells[0], centre),
            // Rows go down, y up.
            way: [x / size, -y / size],
            length,
            radius: (0.045 * apart * share.sqrt()).max(0.6),
            head: (0.45 * length).min(0.42 * apart),
        };
        let alpha = 0.35 + 0.65 * share;
        arrow.draw(&mut around, 1.2, 0.55 * alpha);
        arrow.draw(&mut arrows, 0.0, alpha);
    }
    around.paint(light, AROUND);
    arrows.paint(light, COLOUR);
}

/// An arrow, in pixels.
struct Arrow {
    centre: Spot,
    way: [f32; 2],
    length: f32,
    radius: f32,
    /// Length of its head.
    head: f32,
}

impl Arrow {
    fn draw(&self, mask: &mut Mask, more: f32, alpha: f32) {
        let at = |along: f32, across: f32| {
            let [x, y] = self.way;
            [
                self.centre[0] + along * x - across * y,
                self.centre[1] + along * y + across * x,
            ]
        };
        let (tip, neck, half) = (0.5 * self.length, 0.5 * self.length - self.head, 0.42 * self.head);
        let half = half.max(1.6 * self.radius);
        mask.line(
            at(-tip, 0.0),
            at(neck + 0.3 * self.head, 0.0),
            self.radius + more,
            alpha,
        );
        mask.triangle([at(tip, 0.0), at(neck, half), at(neck, -half)], more, alpha);
    }
}
