//! The order in which the smoother visits cells (mathematics section 5).

use crate::grid::Grid;
use crate::words::named;

/// How cells are split into colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colours {
    /// By the parity of x + y (+ z), even first: two passes.
    #[default]
    RedBlack,
    /// The paper's 2^d colours, by the parity of each coordinate.
    PowerOfTwo,
}

named!(Colours { RedBlack = "red_black", PowerOfTwo = "2^d" });

/// The cells of one colour in one row: `start`, `start + 2`, .., `count` of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// The first cell.
    pub start: usize,
    /// How many.
    pub count: usize,
}

impl Colours {
    /// Passes on `grid`. The last cells of a periodic axis of odd length are colours of their own.
    #[must_use]
    pub fn passes(self, grid: &Grid) -> usize {
        let base = match self {
            Self::RedBlack => 2,
            Self::PowerOfTwo => 1 << grid.dims,
        };
        base << (0..grid.dims).filter(|&axis| odd(grid, axis)).count()
    }

    /// The cells of `row` that pass `pass` visits. Of a box that ranks share a rank visits its own planes and rows and those beside, whose changes reach them.
    #[must_use]
    pub fn cells(self, grid: &Grid, pass: usize, row: usize) -> Cells {
        let none = Cells { start: 0, count: 0 };
        let [y, z] = grid.row_at(row);
        let is_near = |(axis, place): (usize, usize)| {
            let own = grid.own(axis);
            place + 1 >= own.start && place <= own.end
        };
        if ![(1, y), (2, z)].into_iter().all(is_near) {
            return none;
        }
        let at = [0, grid.in_whole(1, y), grid.in_whole(2, z)];
        let (base, mut bits) = match self {
            Self::RedBlack => (pass % 2, pass / 2),
            Self::PowerOfTwo => (pass % (1 << grid.dims), pass >> grid.dims),
        };
        let mut last = [false; 3];
        for (axis, last) in last.iter_mut().enumerate().take(grid.dims) {
            if odd(grid, axis) {
                *last = bits % 2 == 1;
                bits /= 2;
            }
            if axis > 0 && odd(grid, axis) && *last != (at[axis] + 1 == grid.whole_axis(axis).cells()) {
                return none;
            }
        }
        let parity = match self {
            Self::RedBlack => (base + at[1] + at[2]) % 2,
            Self::PowerOfTwo if (1..grid.dims).any(|axis| at[axis] % 2 != (base >> axis) % 2) => {
                return none;
            }
            Self::PowerOfTwo => base % 2,
        };
        along_x(grid, parity, last[0])
    }
}

/// Cells of `parity` along x; on a periodic axis of odd length either the last cell or all the others.
fn along_x(grid: &Grid, parity: usize, last: bool) -> Cells {
    let n = grid.n[0];
    if odd(grid, 0) && last {
        return Cells {
            start: n - 1,
            count: usize::from((n - 1) % 2 == parity),
        };
    }
    let limit = if odd(grid, 0) { n - 1 } else { n };
    Cells {
        start: parity,
        count: limit.saturating_sub(parity).div_ceil(2),
    }
}

fn odd(grid: &Grid, axis: usize) -> bool {
    let whole = grid.whole_axis(axis);
    whole.is_ring() && whole.cells() % 2 == 1
}
