//! Which parts of the box are cut off from each other by obstacles, and where there is smoke.

use crate::keyframes::Canvas;

/// What is no more than this part of a shape does not count: a keyframe of which more can never be reached is refused.
const MOST_CUT_OFF: f64 = 0.01;

/// What solid cells are in; and cells that nothing was found of yet.
const SOLID: u32 = u32::MAX;

/// The connected parts of the fluid.
pub(super) struct Reach {
    /// The number of the part that each cell is in, or [`SOLID`].
    part: Vec<u32>,
    /// Whether there is smoke in each part.
    smoke: Vec<bool>,
}

impl Reach {
    /// The parts of a box with these solid cells; no smoke yet.
    pub fn new(canvas: &Canvas, solid: &[bool]) -> Self {
        let mut part = vec![SOLID; solid.len()];
        let mut count = 0;
        for first in 0..solid.len() {
            if solid[first] || part[first] != SOLID {
                continue;
            }
            let mut waiting = vec![first];
            part[first] = count;
            while let Some(cell) = waiting.pop() {
                for beside in neighbours(canvas, cell) {
                    if !solid[beside] && part[beside] == SOLID {
                        part[beside] = count;
                        waiting.push(beside);
                    }
                }
            }
            // Of more parts than there are numbers the last ones are one.
            count = (count + 1).min(SOLID - 1);
        }
        Self {
            part,
            smoke: vec![false; count as usize],
        }
    }

    /// Smoke is, or is made, in all parts that have more than a little of `density`.
    pub fn fill(&mut self, density: impl Iterator<Item = f64>) {
        let mut masses = vec![0.0; self.smoke.len()];
        for (part, density) in self.part.iter().zip(density) {
            if let Some(mass) = masses.get_mut(*part as usize) {
                *mass += density;
            }
        }
        let least = MOST_CUT_OFF * masses.iter().sum::<f64>();
        let smoke = self.smoke.iter_mut().zip(masses);
        smoke.for_each(|(smoke, mass)| *smoke |= mass > least);
    }

    /// The part of a keyframe's mass in fluid that no smoke can come to, if that is too much.
    pub fn cut_off(&self, density: impl Iterator<Item = f64>) -> Option<f64> {
        let (mut all, mut beyond) = (0.0, 0.0);
        for (part, density) in self.part.iter().zip(density) {
            let Some(&smoke) = self.smoke.get(*part as usize) else {
                continue;
            };
            all += density;
            beyond += if smoke { 0.0 } else { density };
        }
        let cut_off = beyond / all;
        (cut_off > MOST_CUT_OFF).then_some(cut_off)
    }
}

/// The cells beside a cell.
fn neighbours(canvas: &Canvas, cell: usize) -> impl Iterator<Item = usize> + '_ {
    let mut stride = 1;
    let axes = canvas.cells.iter().zip(&canvas.periodic);
    axes.flat_map(move |(&n, &ring)| {
        let (own, at) = (stride, cell / stride % n);
        stride *= n;
        let low = match at.checked_sub(1) {
            Some(_) => Some(cell - own),
            None => ring.then(|| cell + (n - 1) * own),
        };
        let high = if at + 1 < n {
            Some(cell + own)
        } else {
            ring.then(|| cell - (n - 1) * own)
        };
        [low, high].into_iter().flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall across the box cuts it in two, unless the axis along which one would go around is periodic.
    #[test]
    fn a_wall_cuts_the_box_in_two() {
        for (periodic, parts) in [(false, 2), (true, 1)] {
            let canvas = Canvas {
                cells: vec![6, 5],
                periodic: vec![periodic, false],
                length: 1.0,
            };
            let solid: Vec<bool> = (0..30).map(|cell| cell % 6 == 2).collect();
            let mut reach = Reach::new(&canvas, &solid);
            assert_eq!(reach.smoke.len(), parts);
            let at = |x: usize| (0..30).map(move |cell| if cell % 6 == x { 1.0 } else { 0.0 });
            reach.fill(at(0));
            assert_eq!(reach.cut_off(at(1)), None);
            assert_eq!(reach.cut_off(at(4)), (parts == 2).then_some(1.0));
        }
    }
}
