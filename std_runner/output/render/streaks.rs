//! Streaklines over a plane of smoke: where the flow has carried what it met at fixed places, a speck at every step.

use super::arrows::Field;
use super::flat::Stand;
use super::mask::{Mask, Spot};

/// Steps that a streakline goes back.
const LIFE: usize = 24;
/// Places along the longer side where streaklines begin.
const ALONG: f32 = 30.0;
/// Parts of a step in which specks are followed, and parts that a step of a line is drawn in.
const PARTS: usize = 4;
/// Streaklines of fewer pixels are not drawn.
const SHORTEST: f32 = 3.0;
/// Linear red, green and blue: of lines, and of what stands around them so that they are seen on smoke.
const COLOUR: [f32; 3] = [0.16, 0.56, 1.0];
const AROUND: [f32; 3] = [0.004, 0.004, 0.006];

/// The streaklines of a step.
#[derive(Clone)]
pub(crate) struct Streaks {
    cells: [usize; 2],
    step: usize,
    /// Where they begin.
    seeds: Vec<Spot>,
    /// The specks of each, in cells, the one that left last first.
    lines: Vec<Vec<Spot>>,
}

impl Streaks {
    /// None yet, at step 0.
    pub fn new(cells: [usize; 2]) -> Self {
        let apart = (cells[0].max(cells[1]) as f32 / ALONG).max(1.0);
        let [nx, ny] = cells.map(|count| count as f32);
        let rows = (ny / apart).round().max(1.0);
        let columns = (nx / apart).round().max(1.0);
        // Every other row is moved by half a place, which shows no columns.
        let seed = |row: usize, column: usize| {
            let beside = if row.is_multiple_of(2) { 0.25 } else { 0.75 };
            [
                (column as f32 + beside) * nx / columns,
                (row as f32 + 0.5) * ny / rows,
            ]
        };
        let seeds =
            (0..rows as usize).flat_map(|row| (0..columns as usize).map(move |column| seed(row, column)));
        let seeds: Vec<Spot> = seeds.collect();
        Self {
            cells,
            step: 0,
            lines: seeds.iter().map(|&seed| vec![seed]).collect(),
            seeds,
        }
    }

    /// The first step from which they must be followed for those of `step`.
    pub fn begins(step: usize) -> usize {
        step.saturating_sub(LIFE)
    }

    /// Goes to a step from which on they will be followed; they begin there if they were not yet.
    pub fn begin_at(&mut self, step: usize) {
        if step > self.step {
            *self = Self {
                step,
                ..Self::new(self.cells)
            };
        }
    }

    /// The step that they stand at.
    pub fn step(&self) -> usize {
        self.step
    }

    /// Follows the flow for a step: `flow` is in cells a step; an axis may repeat.
    pub fn follow(&mut self, flow: &Field, repeats: [bool; 2]) {
        self.step += 1;
        let part = 1.0 / PARTS as f32;
        for (line, &seed) in self.lines.iter_mut().zip(&self.seeds) {
            for speck in line.iter_mut() {
                for _ in 0..PARTS {
                    let half = moved(*speck, at(flow, *speck, repeats), 0.5 * part);
                    *speck = moved(*speck, at(flow, half, repeats), part);
                }
            }
            line.insert(0, seed);
            line.truncate(LIFE + 1);
        }
    }

    /// Draws them over a picture.
    pub(super) fn draw(&self, light: &mut [[f32; 3]], stand: &Stand) {
        let pixels = stand.pixels(self.cells[0]);
        let width = (0.0010 * stand.width.max(stand.height) as f32).max(0.7);
        let new = || Mask::new(stand.width, stand.height);
        let mut masks = [new(), new()];
        for line in &self.lines {
            let length: f32 = line.windows(2).map(|pair| apart(pair[0], pair[1])).sum();
            if length * pixels < SHORTEST {
                continue;
            }
            let count = (line.len().max(2) - 1) as f32;
            for step in 0..line.len().saturating_sub(1) {
                let mut before = curve(line, step, 0.0);
                for piece in 1..=PARTS {
                    let now = curve(line, step, piece as f32 / PARTS as f32);
                    // From nothing where they begin to bright where the flow has come to.
                    let age = (step as f32 + piece as f32 / PARTS as f32) / count;
                    let radius = width * (0.6 + 0.7 * age);
                    let [around, lines] = &mut masks;
                    self.piece(around, stand, [before, now], (radius + 1.0, 0.6 * age));
                    self.piece(lines, stand, [before, now], (radius, 0.95 * age));
                    before = now;
                }
            }
        }
        let [around, lines] = masks;
        around.paint(light, AROUND);
        lines.paint(light, COLOUR);
    }

    /// A piece of a line; one that left the box is drawn where the box repeats.
    fn piece(&self, mask: &mut Mask, stand: &Stand, ends: [Spot; 2], (radius, alpha): (f32, f32)) {
        let shift: [f32; 2] = core::array::from_fn(|axis| {
            let count = self.cells[axis] as f32;
            let middle = 0.5 * (ends[0][axis] + ends[1][axis]);
            middle.rem_euclid(count) - middle
        });
        let [from, to] = ends.map(|end| stand.spot(self.cells[0], [end[0] + shift[0], end[1] + shift[1]]));
        mask.line(from, to, radius, alpha);
    }
}

fn moved(speck: Spot, flow: [f32; 2], part: f32) -> Spot {
    [speck[0] + part * flow[0], speck[1] + part * flow[1]]
}

fn apart(one: Spot, other: Spot) -> f32 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// The flow at a place, linear between the centres of cells.
fn at(flow: &Field, speck: Spot, repeats: [bool; 2]) -> [f32; 2] {
    let mut taps = [[(0, 0.0); 2]; 2];
    for axis in 0..2 {
        let count = flow.cells[axis] as i64;
        let place = speck[axis] - 0.5;
        let low = place.floor();
        let part = place - low;
        let index = |cell: i64| {
            let cell = if repeats[axis] {
                cell.rem_euclid(count)
            } else {
                cell.clamp(0, count - 1)
            };
            cell as usize
        };
        taps[axis] = [(index(low as i64), 1.0 - part), (index(low as i64 + 1), part)];
    }
    let mut sum = [0.0; 2];
    for (y, weight_y) in taps[1] {
        for (x, weight_x) in taps[0] {
            let value = flow
                .values
                .get(y * flow.cells[0] + x)
                .copied()
                .unwrap_or_default();
            sum = moved(sum, value, weight_x * weight_y);
        }
    }
    sum
}

/// A point of the smooth curve through the specks (Catmull and Rom 1974), `part` of the way from one to the next.
fn curve(line: &[Spot], step: usize, part: f32) -> Spot {
    let last = line.len().saturating_sub(1);
    let speck = |index: usize| line.get(index.min(last)).copied().unwrap_or_default();
    let [a, b, c, d] = [
        speck(step.saturating_sub(1)),
        speck(step),
        speck(step + 1),
        speck(step + 2),
    ];
    core::array::from_fn(|axis| {
        let [a, b, c, d] = [a, b, c, d].map(|speck| speck[axis]);
        let (slope_b, slope_c) = (0.5 * (c - a), 0.5 * (d - b));
        let (square, cube) = (part * part, part * part * part);
        (2.0 * cube - 3.0 * square + 1.0) * b
            + (cube - 2.0 * square + part) * slope_b
            + (3.0 * square - 2.0 * cube) * c
            + (cube - square) * slope_c
    })
}
