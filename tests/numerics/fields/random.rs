//! A small seeded generator of random numbers and fields.

use super::{Components, places, zeros};
use thurible_core::Real;
use thurible_core::grid::Grid;

/// SplitMix64 (Steele, Lea & Flood 2014).
pub struct Random(u64);

impl Random {
    /// The sequence that belongs to `seed`.
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From -1 to 1.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// From `low` to `high`, both included.
    pub fn between(&mut self, low: usize, high: usize) -> usize {
        low + (self.bits() % (high - low + 1) as u64) as usize
    }

    /// One of a list.
    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.between(0, list.len() - 1)]
    }

    pub fn coin(&mut self) -> bool {
        self.bits() & 1 == 1
    }

    /// Numbers from -1 to 1 at all cells and slots.
    pub fn cells<T: Real>(&mut self, grid: &Grid, slots: usize) -> Vec<T> {
        (0..grid.cells() * slots)
            .map(|_| T::from_f64(self.signed()))
            .collect()
    }

    /// Densities from 0 to 1 at all cells.
    pub fn density<T: Real>(&mut self, grid: &Grid) -> Vec<T> {
        (0..grid.cells()).map(|_| T::from_f64(self.unit())).collect()
    }

    /// Numbers from -1 to 1 at all faces that are not walls; 0 there.
    pub fn faces<T: Real>(&mut self, grid: &Grid, slots: usize) -> Components<T> {
        self.faces_from(grid, slots, Self::signed)
    }

    /// As [`Self::faces`], but no number is closer to 0 than 0.3.
    pub fn moving_faces<T: Real>(&mut self, grid: &Grid, slots: usize) -> Components<T> {
        self.faces_from(grid, slots, |random| {
            let size = 0.3 + 0.7 * random.unit();
            if random.coin() { size } else { -size }
        })
    }

    fn faces_from<T: Real>(
        &mut self,
        grid: &Grid,
        slots: usize,
        mut number: impl FnMut(&mut Self) -> f64,
    ) -> Components<T> {
        let mut v = zeros(grid, slots);
        for axis in 0..grid.dims {
            for k in 0..slots {
                for at in places(grid) {
                    let wall = !grid.axis(axis).is_ring() && at[axis] == 0;
                    v[axis][super::index(grid, slots, k, at)] =
                        T::from_f64(if wall { 0.0 } else { number(self) });
                }
            }
        }
        v
    }
}
