//! What is chosen for NSO, and how it uses memory and threads.

use super::colours::Colours;
use super::damping::LocalDamping;
use super::surroundings::Surroundings;
use crate::exec::Slabs;
use crate::grid::{Grid, Space};
use crate::real::Real;
use crate::words::named;

/// In which units divergences count in max |f|.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// Times h / dt, so that all four equations are accelerations.
    #[default]
    Scaled,
    /// As they are: the paper's, stricter by 1 / h on divergence (its Figure 6).
    Plain,
}

named!(Norm { Scaled = "scaled", Plain = "plain" });

/// How Navier-Stokes problems are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NsoSolver {
    /// The paper's multigrid in space and time.
    #[default]
    Stfas,
    /// Newton's method with conjugate gradients, preconditioned in time: see [`newton`](super::newton). It
    /// has memory of its own.
    NewtonCg,
}

named!(NsoSolver { Stfas = "stfas", NewtonCg = "newton_cg" });

/// What a caller chooses for NSO.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NsoParams {
    /// The solver.
    pub solver: NsoSolver,
    /// Stop at max |f| below this, in scaled accelerations.
    pub tolerance: f64,
    /// The most V-cycles, or Newton steps.
    pub cycles: usize,
    /// The smoother's colours.
    pub colours: Colours,
    /// The norm of the stop.
    pub norm: Norm,
}

impl Default for NsoParams {
    fn default() -> Self {
        Self {
            solver: NsoSolver::Stfas,
            tolerance: 1e-5,
            cycles: 30,
            colours: Colours::RedBlack,
            norm: Norm::Scaled,
        }
    }
}

/// A Navier-Stokes problem in scaled units, and how it is solved. Each solver reads what concerns it.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// K / r, scaled.
    pub kappa: f64,
    /// nu, scaled.
    pub viscosity: f64,
    /// Slots T.
    pub slots: usize,
    /// Threads that scratch was planned for.
    pub threads: usize,
    /// Solver, stop and colours.
    pub params: NsoParams,
    /// Where the smoother damps, at kappa = 1.
    pub damping: LocalDamping<f64>,
    /// What the smoother's blocks know beyond their cells.
    pub surroundings: Surroundings<f64>,
    /// How the multigrid uses its memory.
    pub memory: SmootherMemory,
    /// Relative tolerance of Newton's projections.
    pub projection_tolerance: f64,
}

/// How threads share the planes of a grid, which in 2D are its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Every thread has a slab of planes of its own.
    Slabs,
    /// All threads share the rows of this number of planes, then those of the next ones.
    Planes(usize),
}

impl Split {
    /// The slabs of a grid's planes, one for each of `threads` as long as each has `least` planes; one where
    /// threads share planes.
    pub(super) fn slabs(self, grid: &Grid, threads: usize, least: usize) -> Slabs {
        let count = if self == Self::Slabs { threads } else { 1 };
        Slabs::new(grid.planes(), count, least)
    }
}

/// How the multigrid uses its memory: a choice that changes its speed, never its results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SmootherMemory {
    /// The most cells that a thread smooths side by side.
    pub lanes: usize,
    /// How threads share planes.
    pub split: Split,
}

impl SmootherMemory {
    /// The way that takes the least memory.
    pub const LEAST: Self = Self {
        lanes: 1,
        split: Split::Planes(1),
    };
    /// Bytes of the longest vector.
    const LONGEST_VECTOR: usize = 64;
    /// The most vectors side by side.
    const MOST_VECTORS: usize = 2;
    /// Bytes of lanes below which slabs gain less than longer vectors do.
    const WORTH_SLABS: usize = 32;

    /// The ways to choose from for a grid, the fastest first. Slabs are for 2D alone: in 3D they would not
    /// be faster, since each thread has the same rows of all shared planes anyway, and the changes at their
    /// edges would take as much memory as a part of the state.
    pub fn all<T: Real, S: Space>(grid: &Grid) -> impl Iterator<Item = Self> + Clone {
        let vector = Self::LONGEST_VECTOR / T::BYTES;
        let cells = grid.n[0].div_ceil(2).next_multiple_of(vector);
        let most = cells.min(Self::MOST_VECTORS * vector);
        let lanes = [32, 16, 8, 4, 1].into_iter().filter(move |&lanes| lanes <= most);
        let slabs = lanes
            .clone()
            .filter(|lanes| S::DIM == 2 && lanes * T::BYTES >= Self::WORTH_SLABS)
            .map(|lanes| Self {
                lanes,
                split: Split::Slabs,
            });
        let planes: &[usize] = if S::DIM == 2 { &[1] } else { &[2, 1] };
        slabs.chain(lanes.flat_map(|lanes| {
            planes.iter().map(move |&planes| Self {
                lanes,
                split: Split::Planes(planes),
            })
        }))
    }
}
