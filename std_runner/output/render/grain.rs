//! Detail finer than the cells of a search: smoke is curled by noise that drifts with the flow.
//!
//! Noise is looked up where the smoke came from. That place is followed by the flow of every step (semi-Lagrangian), and after
//! a while forgotten, since a flow stretches it; two such fields in turn, the one blended out while the other is young, show no seam
//! (Neyret, "Advected Textures", 2003). Both begin at fixed steps, so that a picture does not depend on those before it.

use rayon::prelude::*;

use super::camera::Vector;
use super::volume::Volume;

/// Steps after which a field begins anew.
const LIFE: usize = 24;
/// Points of the lattice of noise along a side, after which it repeats.
const LATTICE: usize = 32;
/// Octaves: cells of the smoke to a point of the lattice, and how far noise moves smoke, in cells.
const OCTAVES: [(f32, f32); 4] = [(6.5, 1.4), (3.1, 1.1), (1.5, 0.75), (0.75, 0.4)];
/// By how much an octave thins or thickens it.
const MOTTLE: f32 = 1.0;

/// Where smoke came from: offsets in cells, two fields of them.
#[derive(Clone)]
pub(crate) struct Drift {
    cells: [usize; 3],
    offsets: [Vec<Vector>; 2],
    step: usize,
}

impl Drift {
    /// At step 0 of a box of `cells`.
    pub fn new(cells: [usize; 3]) -> Self {
        let still = vec![[0.0; 3]; cells.iter().product()];
        Self {
            cells,
            offsets: [still.clone(), still],
            step: 0,
        }
    }

    /// The first step from which a drift must be followed for that of `step`.
    pub fn begins(step: usize) -> usize {
        step.saturating_sub(LIFE)
    }

    /// Goes to a step from which on it will be followed.
    pub fn begin_at(&mut self, step: usize) {
        self.step = step;
    }

    /// The step that it stands at.
    pub fn step(&self) -> usize {
        self.step
    }

    /// Follows the flow for a step: `flow` is that at the centres of the cells, in cells a step.
    pub fn follow(&mut self, flow: &[Vector]) {
        self.step += 1;
        for (phase, offsets) in self.offsets.iter_mut().enumerate() {
            if age(self.step, phase) == 0 {
                offsets.iter_mut().for_each(|offset| *offset = [0.0; 3]);
                continue;
            }
            let [nx, ny, _] = self.cells;
            let before = core::mem::take(offsets);
            let grid = Volume {
                cells: self.cells,
                factor: 1,
                values: Vec::new(),
            };
            let mut now = vec![[0.0; 3]; before.len()];
            now.par_chunks_mut(nx).enumerate().for_each(|(row, now)| {
                for (x, now) in now.iter_mut().enumerate() {
                    let moved = flow[row * nx + x];
                    let place = [x, row % ny, row / ny].map(|place| place as f32 + 0.5);
                    let came = core::array::from_fn(|axis| place[axis] - moved[axis]);
                    *now = grid.corners(came).of(&before);
                    (0..3).for_each(|axis| now[axis] += moved[axis]);
                }
            });
            *offsets = now;
        }
    }
}

/// Steps since a field began.
fn age(step: usize, phase: usize) -> usize {
    (step + phase * LIFE / 2) % LIFE
}

/// Curls `density` where `busy` says of a point that there may be smoke, by `amount` 0 ..= 1.
pub(super) fn curl(
    density: &Volume,
    drift: &Drift,
    amount: f32,
    busy: impl Fn(Vector) -> bool + Sync,
) -> Volume {
    let noise = Noise::new();
    let grid = Volume {
        cells: drift.cells,
        factor: 1,
        values: Vec::new(),
    };
    // Cells of the smoke for each of the drift, which may be that of a coarser grid.
    let by = (density.cells[0] / density.factor / drift.cells[0].max(1)).max(1) as f32;
    let ages = [0, 1].map(|phase| age(drift.step, phase) as f32 / LIFE as f32);
    let shares = ages.map(|age| 1.0 - (2.0 * age - 1.0).abs());
    // Two noises have less contrast than one.
    let norm = 1.0 / (shares[0] * shares[0] + shares[1] * shares[1]).sqrt();
    let [nx, ny, _] = density.cells;
    let cell = 1.0 / density.factor as f32;
    let mut values = vec![0.0; density.values.len()];
    values.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
        for (x, out) in out.iter_mut().enumerate() {
            let place = [x, row % ny, row / ny].map(|place| (place as f32 + 0.5) * cell);
            if !busy(place) {
                continue;
            }
            let corners = grid.corners(place.map(|place| place / by));
            let mut sum = [0.0; 4];
            for (phase, offsets) in drift.offsets.iter().enumerate() {
                let offset = corners.of(offsets).map(|offset| offset * by);
                let began = drift.step - age(drift.step, phase).min(drift.step);
                let from = core::array::from_fn(|axis| place[axis] - offset[axis] + (7 * began) as f32);
                let share = amount * norm * shares[phase];
                noise.add(from, share, &mut sum);
            }
            let moved = core::array::from_fn(|axis| place[axis] + sum[axis]);
            let there = density.at(moved);
            if there > 0.0 {
                *out = there * (MOTTLE * sum[3]).exp();
            }
        }
    });
    Volume {
        cells: density.cells,
        factor: density.factor,
        values,
    }
}

/// Smooth noise of four numbers that repeats.
struct Noise {
    lattice: Vec<[f32; 4]>,
}

impl Noise {
    fn new() -> Self {
        let mut state = 0x9e37_79b9_u32;
        let mut random = || {
            // Marsaglia's xorshift (2003).
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        };
        let lattice = (0..LATTICE.pow(3)).map(|_| core::array::from_fn(|_| random()));
        Self {
            lattice: lattice.collect(),
        }
    }

    /// Adds all octaves at a place: a way in cells, and a number.
    fn add(&self, place: Vector, share: f32, sum: &mut [f32; 4]) {
        for (octave, (wave, curl)) in OCTAVES.into_iter().enumerate() {
            let at = self.at(place.map(|place| place / wave + 11.3 * octave as f32));
            for axis in 0..3 {
                sum[axis] += share * curl * at[axis];
            }
            sum[3] += share * at[3];
        }
    }

    fn at(&self, place: Vector) -> [f32; 4] {
        let low = place.map(f32::floor);
        let part: Vector = core::array::from_fn(|axis| {
            let part = place[axis] - low[axis];
            part * part * (3.0 - 2.0 * part)
        });
        let around = |cell: f32, next: usize| (cell as i64 + next as i64).rem_euclid(LATTICE as i64) as usize;
        let mut sum = [0.0; 4];
        for corner in 0..8_usize {
            let side: [usize; 3] = core::array::from_fn(|axis| (corner >> axis) & 1);
            let weights: Vector = core::array::from_fn(|axis| {
                if side[axis] == 1 {
                    part[axis]
                } else {
                    1.0 - part[axis]
                }
            });
            let [x, y, z] = core::array::from_fn(|axis| around(low[axis], side[axis]));
            let weight = weights[0] * weights[1] * weights[2];
            let values = self.lattice[(z * LATTICE + y) * LATTICE + x];
            for (sum, value) in sum.iter_mut().zip(values) {
                *sum += weight * value;
            }
        }
        sum
    }
}
