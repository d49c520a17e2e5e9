//! Where there is nothing to be seen.

use super::camera::Vector;
use super::smoke::Smoke;

/// Cells of a block along each side.
const BLOCK: usize = 4;
/// Less smoke than this is not seen.
pub(super) const LEAST: f32 = 1e-3;
/// Smoke is seen so many cells away from its own: between centres, and with detail where that curls it to.
const REACH: usize = 2;
const CURLED: usize = 3;

/// Blocks of cells, each with or without something in it.
pub(super) struct Blocks {
    count: [usize; 3],
    busy: Vec<bool>,
}

impl Blocks {
    /// Those of `smoke`: a block is busy if smoke or a body is in it, or so close that it is seen there.
    pub fn new(smoke: &Smoke) -> Self {
        let [nx, ny, _] = smoke.cells;
        let count = smoke.cells.map(|count| count.div_ceil(BLOCK));
        let mut busy = vec![false; count.iter().product()];
        let reach = if smoke.detail.is_some() { CURLED } else { REACH };
        let there = |cell: usize| {
            smoke.values[cell] > LEAST || smoke.body.as_ref().is_some_and(|body| body.0[cell] > 0.05)
        };
        for cell in (0..smoke.values.len()).filter(|&cell| there(cell)) {
            let place = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            let range = |axis: usize| {
                let last = (place[axis] + reach).min(smoke.cells[axis] - 1);
                place[axis].saturating_sub(reach) / BLOCK..=last / BLOCK
            };
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        busy[(z * count[1] + y) * count[0] + x] = true;
                    }
                }
            }
        }
        Self { count, busy }
    }

    /// The block of a point, and whether anything is in it.
    #[inline]
    pub fn at(&self, point: Vector) -> ([usize; 3], bool) {
        let block: [usize; 3] = core::array::from_fn(|axis| {
            ((point[axis].max(0.0) / BLOCK as f32) as usize).min(self.count[axis] - 1)
        });
        let [x, y, z] = block;
        (block, self.busy[(z * self.count[1] + y) * self.count[0] + x])
    }

    /// The sides of a block along an axis.
    #[inline]
    pub fn sides(block: usize) -> [f32; 2] {
        [(block * BLOCK) as f32, ((block + 1) * BLOCK) as f32]
    }
}
