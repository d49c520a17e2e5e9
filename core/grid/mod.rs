//! The MAC grid (Harlow & Welch 1965): a box of cells, scalars at centres, vector components on the faces normal to them.
//!
//! ```text
//! face 0   cell 0   face 1   cell 1   face 2  ...   cell n-1   face n
//! ```
//!
//! Face `i` of an axis is the low side of cell `i`. On a wall axis nothing flows through faces 0 and n; on a periodic axis face n
//! is face 0. So face 0 .. n-1 are enough, and each component of a vector field has as many values as there are cells.
//!
//! A trajectory in time is stored by rows along x, with all slots (time levels) of a row together: value `x` of slot `k` of row
//! `(y, z)` is at `((z ny + y) slots + k) nx + x`. The unknowns of a face in time lie close together for the smoother, operators
//! that treat all slots alike run over long contiguous stretches, and the rows of a thread are one chunk.

pub mod fourier;
pub mod gaussian;
pub mod geometry;
pub mod halo;
pub mod levels;
pub mod open_modes;
pub mod parity;
pub mod part;
pub mod solids;
pub mod spectrum;
pub mod stencil;
pub mod tables;
pub mod taps;

pub use crate::memory::Share;
pub use geometry::Axis;

use crate::memory::Parts;
use crate::memory::part::Cut;
use crate::words::named;

mod sealed {
    pub trait Sealed {}
}

/// The dimension, known when compiling: [`D2`] or [`D3`].
pub trait Space: sealed::Sealed + Copy + Clone + core::fmt::Debug + Default + Send + Sync + 'static {
    /// 2 or 3.
    const DIM: usize;
    /// Faces of a cell, 2 d.
    const FACES: usize = 2 * Self::DIM;
    /// Velocity changes of one cell that keep its divergence, 2 d - 1.
    const FREE: usize = 2 * Self::DIM - 1;
    /// Edges of a cell across which two of its faces meet: 4 in 2D (its corners), 12 in 3D.
    const EDGES: usize = 4 * Self::PAIRS.len();
    /// The ordered axis pairs of the plaquettes (mathematics section 2).
    const PAIRS: &'static [(usize, usize)];
}

/// Two dimensions.
#[derive(Clone, Copy, Debug, Default)]
pub struct D2;
/// Three dimensions.
#[derive(Clone, Copy, Debug, Default)]
pub struct D3;

impl sealed::Sealed for D2 {}
impl sealed::Sealed for D3 {}
impl Space for D2 {
    const DIM: usize = 2;
    const PAIRS: &'static [(usize, usize)] = &[(0, 1)];
}
impl Space for D3 {
    const DIM: usize = 3;
    const PAIRS: &'static [(usize, usize)] = &[(0, 1), (1, 2), (2, 0)];
}

/// How an axis ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Closed, with free slip unless the flow sticks (the paper's Neumann condition).
    #[default]
    Wall,
    /// Wraps around.
    Periodic,
    /// Open on both sides: the pressure outside is 0, and smoke leaves.
    Open,
    /// Open on the low side, a wall on the high one.
    OpenLow,
    /// Open on the high side, a wall on the low one.
    OpenHigh,
}

named!(Boundary { Wall = "wall", Periodic = "periodic", Open = "open", OpenLow = "open_low", OpenHigh = "open_high" });

impl Boundary {
    /// Whether a side is open.
    #[inline(always)]
    #[must_use]
    pub const fn opens(self, side: Side) -> bool {
        match side {
            Side::Low => matches!(self, Self::Open | Self::OpenLow),
            Side::High => matches!(self, Self::Open | Self::OpenHigh),
        }
    }

    /// Whether any side is open.
    #[inline(always)]
    #[must_use]
    pub const fn is_open(self) -> bool {
        self.opens(Side::Low) || self.opens(Side::High)
    }
}

/// Which side of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Towards smaller coordinates.
    Low,
    /// Towards larger coordinates.
    High,
}

/// A box of `n[0] x n[1] (x n[2])` equal cells of size `h[0] x h[1] (x h[2])`; the finest grid has square cells.
///
/// Beyond an open side lies one more layer of cells, outside the box: the pressure and the density are 0 there, and the faces between it and
/// the box belong to the flow. It counts among `n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// 2 or 3.
    pub dims: usize,
    /// Cells along x, y, z, layers outside the box counted; 1 along z in 2D.
    pub n: [usize; 3],
    /// Size of a cell along each axis, in box lengths.
    pub h: [f64; 3],
    /// How each axis ends: see [`geometry`].
    ends: [Boundary; 3],
    /// Which part of a box it is: see [`part`].
    cut: Option<Cut>,
}

impl Grid {
    /// The finest grid of a box of so many cells inside, square cells of size 1 / max n.
    #[must_use]
    pub fn new(cells: &[usize], boundary: &[Boundary]) -> Self {
        let largest = cells.iter().copied().max().unwrap_or(1);
        let n = core::array::from_fn(|a| cells.get(a).copied().unwrap_or(1));
        let ends = core::array::from_fn(|a| boundary.get(a).copied().unwrap_or_default());
        let h = [1.0 / largest as f64; 3];
        let dims = cells.len();
        let cut = None;
        Self {
            dims,
            n,
            h,
            ends,
            cut,
        }
        .with_inside(n)
    }

    /// The same in cells: h = 1.
    #[must_use]
    pub fn in_cells(cells: &[usize], boundary: &[Boundary]) -> Self {
        Self {
            h: [1.0; 3],
            ..Self::new(cells, boundary)
        }
    }

    /// A closed grid in cells whose axes end as those of this one.
    #[must_use]
    pub fn of_cells(self, n: [usize; 3]) -> Self {
        Self {
            h: [1.0; 3],
            ..self.with_inside(n)
        }
    }

    /// The same with so many cells inside along each axis.
    pub(crate) fn with_inside(self, inside: [usize; 3]) -> Self {
        let n = core::array::from_fn(|a| inside[a] + self.layers(a, Side::Low) + self.layers(a, Side::High));
        Self { n, ..self }
    }

    /// The number of cells.
    #[inline]
    #[must_use]
    pub fn cells(&self) -> usize {
        self.n[0] * self.n[1] * self.n[2]
    }

    /// The number of rows along x.
    #[inline]
    #[must_use]
    pub fn rows(&self) -> usize {
        self.n[1] * self.n[2]
    }

    /// The rows of a plane normal to the last axis. The smoother sweeps plane by plane.
    #[must_use]
    pub fn rows_per_plane(&self) -> usize {
        if self.dims == 2 { 1 } else { self.n[1] }
    }

    /// The plane that a row is in, and its index among the rows of that plane.
    #[must_use]
    pub fn plane_of(&self, row: usize) -> [usize; 2] {
        let rows = self.rows_per_plane().max(1);
        [row / rows, row % rows]
    }

    /// The number of planes normal to the last axis.
    #[must_use]
    pub fn planes(&self) -> usize {
        self.n[self.dims - 1]
    }

    /// The index of row (y, z).
    #[inline]
    #[must_use]
    pub fn row(&self, y: usize, z: usize) -> usize {
        z * self.n[1] + y
    }

    /// The (y, z) of a row.
    #[inline]
    #[must_use]
    pub fn row_at(&self, row: usize) -> [usize; 2] {
        [row % self.n[1], row / self.n[1]]
    }

    /// The (x, y, z) of cell `x` of a row.
    #[inline]
    #[must_use]
    pub fn cell_at(&self, row: usize, x: usize) -> [usize; 3] {
        let [y, z] = self.row_at(row);
        [x, y, z]
    }

    /// Where cell (x, y, z) stands in a field of one slot.
    #[inline]
    #[must_use]
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        self.row(y, z) * self.n[0] + x
    }
}
