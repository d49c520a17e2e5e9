//! NSO, the Navier-Stokes problem of the paper (section 4.2, eq. 13), by the spacetime full-approximation multigrid (STFAS).
//!
//! For targets t_k: the smallest kappa |v_k - t_k|^2 + |w_k|^2 over flows v driven by forces w.

pub mod colours;
pub mod level;
pub mod local;
pub mod newton;
pub mod residual;
pub mod smoother;
pub mod solve;
pub mod transfer;
pub mod vcycle;

pub use solve::{Ended, Info};

use crate::exec::{Exec, Slabs};
use crate::field::{VectorMut, means};
use crate::grid::levels::{self, Levels, MAX_LEVELS, Tables};
use crate::grid::{Grid, Space};
use crate::memory::{Arena, TooSmall};
use crate::memory::{Ledger, Pool, Sharing, pooled};
use crate::observe::{Event, Observer};
use crate::real::Real;
use crate::words::named;
use colours::Colours;
use core::marker::PhantomData;
use core::ops::ControlFlow;
use level::{LevelMut, State, Weights};
use local::Slow;

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
    /// Newton's method with conjugate gradients, preconditioned in time: see [`newton`]. It has memory of its own.
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
    /// V-cycles, or Newton steps, at most.
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

/// How threads share the planes of a grid, which in 2D are its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Every thread has slabs of planes of its own.
    Slabs,
    /// All threads share so many planes, then the next ones.
    Planes(usize),
}

impl Split {
    /// The slabs of a grid's planes, of `least` each: one, unless threads have their own.
    fn slabs(self, grid: &Grid, threads: usize, least: usize) -> Slabs {
        Slabs::new(
            grid.planes(),
            if self == Self::Slabs { threads } else { 1 },
            least,
        )
    }
}

/// How the memory that there is is used; changes speed, never results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Cells that a thread smooths side by side at most.
    pub lanes: usize,
    /// How threads share planes.
    pub split: Split,
}

impl Shape {
    /// The least memory.
    pub const LEAST: Self = Self {
        lanes: 1,
        split: Split::Planes(1),
    };
    /// Bytes of the longest vector, and vectors side by side at most.
    const WIDEST: [usize; 2] = [64, 2];
    /// Bytes side by side below which slabs bring less than more cells do.
    const WORTH_SLABS: usize = 32;

    /// Those to choose from for a grid, the fastest first. In 3D every thread has the same rows of all planes that are shared, so slabs
    /// would not be faster, and what waits for other threads would be a part of the state.
    pub fn all<T: Real, S: Space>(grid: &Grid) -> impl Iterator<Item = Self> + Clone {
        let [bytes, vectors] = Self::WIDEST;
        let vector = bytes / T::BYTES;
        let most = grid.n[0]
            .div_ceil(2)
            .next_multiple_of(vector)
            .min(vectors * vector);
        let lanes = [32, 16, 8, 4, 1].into_iter().filter(move |&lanes| lanes <= most);
        let slabs = lanes
            .clone()
            .filter(|lanes| S::DIM == 2 && lanes * T::BYTES >= Self::WORTH_SLABS)
            .map(|lanes| Self {
                lanes,
                split: Split::Slabs,
            });
        let together: &[usize] = if S::DIM == 2 { &[1] } else { &[2, 1] };
        slabs.chain(lanes.flat_map(|lanes| {
            together.iter().map(move |&together| Self {
                lanes,
                split: Split::Planes(together),
            })
        }))
    }
}

/// The smoother's bases on every grid: what NSO keeps for the whole solve.
#[derive(Debug)]
pub struct Bases<'m, T> {
    tables: heapless::Vec<&'m mut [T], MAX_LEVELS>,
}

impl<'m, T: Real> Bases<'m, T> {
    /// Writes the ledger line of [`Self::carve`].
    pub fn requirement<S: Space>(ledger: &mut Ledger, grids: &[Grid]) {
        ledger.line(
            "smoother bases",
            pooled(local::table_len::<S>()) * grids.len(),
            T::BYTES,
        );
    }

    /// Takes its numbers and fills them.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn carve<S: Space>(arena: &mut Arena<'m>, grids: &[Grid]) -> Result<Self, TooSmall> {
        let mut pool = Pool::new(arena.take::<T>(pooled(local::table_len::<S>()) * grids.len())?);
        let fill = |grid: &Grid| {
            let table = pool.take(local::table_len::<S>());
            local::fill_table::<T, S>(grid.h, table);
            table
        };
        Ok(Self {
            tables: grids.iter().map(fill).collect(),
        })
    }
}

/// The unknowns and data of the finest level, which live outside of NSO.
#[derive(Debug)]
pub struct Finest<'a, T> {
    /// The solution.
    pub state: State<'a, T>,
    /// The given velocity before slot 1.
    pub v0: VectorMut<'a, T>,
    /// The targets t_k.
    pub target: VectorMut<'a, T>,
    /// A vector field that may be overwritten: the damped target, should damping be needed.
    pub spare: VectorMut<'a, T>,
}

/// How a Navier-Stokes problem is posed and solved.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// K / r in scaled numbers.
    pub kappa: f64,
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// Slots T.
    pub slots: usize,
    /// Threads that scratch was planned for.
    pub threads: usize,
    /// Stop and smoother.
    pub params: NsoParams,
    /// Where the smoother leaves terms out, at kappa = 1.
    pub slow: Slow<f64>,
    /// Use of the memory.
    pub shape: Shape,
}

/// One Navier-Stokes problem while it is solved: all levels and the scratch.
pub struct Nso<'a, T, S> {
    levels: heapless::Vec<LevelMut<'a, T>, MAX_LEVELS>,
    tables: heapless::Vec<&'a Tables<'a, T>, MAX_LEVELS>,
    weights: Weights<T>,
    setup: Setup,
    sizes: Sizes,
    scratch: &'a mut [T],
    sums: &'a mut [f64],
    spare: VectorMut<'a, T>,
    space: PhantomData<S>,
}

/// Numbers of the parts of the shared pool.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    coarse: usize,
    waiting: usize,
    lines: usize,
    transfer: usize,
}

impl Sizes {
    fn new<S: Space>(finest: &Grid, slots: usize, threads: usize, shape: Shape) -> Self {
        let level =
            |grid: &Grid| 4 * (1 + S::DIM) * pooled(grid.cells() * slots) + S::DIM * pooled(grid.cells());
        Self {
            coarse: levels::hierarchy(finest).iter().skip(1).map(level).sum(),
            waiting: pooled(smoother::waiting_len::<S>(finest, slots, threads, shape.split)),
            lines: pooled(threads * smoother::scratch_len::<S>(finest, slots, shape)),
            transfer: pooled(
                levels::hierarchy(finest)
                    .iter()
                    .map(|grid| transfer::scratch_len::<S>(grid, slots, threads, shape.split))
                    .max()
                    .unwrap_or(0),
            ),
        }
    }
}

/// Weight of the outside-face term (mathematics section 5).
fn outside_weight<S: Space>(colours: Colours) -> f64 {
    if S::DIM == 3 && colours == Colours::RedBlack {
        3.0
    } else {
        2.0
    }
}

/// Cells stretch beyond this before a grid is smoothed more often, and count as no longer than the second.
const STRETCH: [f64; 2] = [1.5, 32.0];

/// How often to smooth a grid instead of `times`. Long thin boxes have coarse grids (of few cells) with long cells, on which
/// the smoother couples only across: then it takes as many as diffusion along them does, stretch^2 / 2 times as many.
fn stretched<S: Space>(grid: &Grid, times: usize) -> usize {
    let (longest, shortest) = grid
        .h
        .iter()
        .take(S::DIM)
        .fold((0.0, f64::MAX), |(long, short): (f64, f64), &h| {
            (long.max(h), short.min(h))
        });
    let stretch = (longest / shortest).min(STRETCH[1]);
    if stretch > STRETCH[0] {
        libm::ceil(times as f64 * stretch * stretch / 2.0) as usize
    } else {
        times
    }
}

impl<'a, T: Real, S: Space> Nso<'a, T, S> {
    /// Writes the ledger lines of the numbers that [`Self::new`] takes from the shared pool.
    pub fn requirement(ledger: &mut Ledger, finest: &Grid, slots: usize, threads: usize, shape: Shape) {
        let sizes = Sizes::new::<S>(finest, slots, threads, shape);
        ledger.group("Navier-Stokes problem (NSO)", Sharing::Together, |ledger| {
            ledger.line("coarse levels", sizes.coarse, T::BYTES);
            ledger.group("smoothing or transfer", Sharing::InTurn, |ledger| {
                ledger.line(
                    "smoother: waiting changes, lines in time",
                    sizes.waiting + sizes.lines,
                    T::BYTES,
                );
                ledger.line(
                    "transfer: rows of a block, residuals that wait",
                    sizes.transfer,
                    T::BYTES,
                );
            });
        });
    }

    /// Assembles the levels; the coarse ones and all scratch take their numbers from `pool`.
    pub fn new(
        hierarchy: &'a Levels<'_, T>,
        bases: &'a Bases<'_, T>,
        finest: Finest<'a, T>,
        setup: &Setup,
        pool: &mut Pool<'a, T>,
        sums: &'a mut [f64],
    ) -> Self {
        let slots = setup.slots;
        let mut levels = heapless::Vec::new();
        let first = LevelMut {
            grid: &hierarchy.finest,
            state: finest.state,
            v0: finest.v0,
            a: finest.target,
            scale: T::from_f64(setup.kappa),
            b: &mut [],
            c: Default::default(),
            d: &mut [],
            table: &*bases.tables[0],
        };
        let _ = levels.push(first);
        for (grid, base) in hierarchy.grids.iter().zip(&bases.tables).skip(1) {
            let len = grid.cells() * slots;
            let level = LevelMut {
                grid,
                state: State {
                    v: pool.take_vector(S::DIM, len),
                    w: pool.take_vector(S::DIM, len),
                    p: pool.take(len),
                    pbar: pool.take(len),
                },
                v0: pool.take_vector(S::DIM, grid.cells()),
                a: pool.take_vector(S::DIM, len),
                scale: T::ONE,
                b: pool.take(len),
                c: pool.take_vector(S::DIM, len),
                d: pool.take(len),
                table: base,
            };
            let pushed = levels.push(level);
            debug_assert!(pushed.is_ok());
        }
        let sizes = Sizes::new::<S>(&hierarchy.finest, slots, setup.threads, setup.shape);
        let weights = Weights {
            slots,
            kappa: T::from_f64(setup.kappa),
            viscosity: T::from_f64(setup.viscosity),
            outside: T::from_f64(outside_weight::<S>(setup.params.colours)),
            slow: setup.slow.at(setup.kappa),
        };
        let scratch = pool.take((sizes.waiting + sizes.lines).max(sizes.transfer));
        Self {
            levels,
            tables: hierarchy.tables.iter().collect(),
            weights,
            setup: *setup,
            sizes,
            scratch,
            sums,
            spare: finest.spare,
            space: PhantomData,
        }
    }

    /// Smooths level `level` a few times, more often where its cells are much longer than wide.
    fn smooth(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        level: usize,
        times: usize,
    ) -> ControlFlow<()> {
        let (waiting, lines) = self.scratch.split_at_mut(self.sizes.waiting);
        let mut workspace = smoother::Workspace {
            waiting,
            scratch: &mut lines[..self.sizes.lines],
            shape: self.setup.shape,
        };
        for _ in 0..stretched::<S>(self.levels[level].grid, times) {
            smoother::sweep::<T, S>(
                exec,
                &mut self.levels[level],
                &self.weights,
                self.setup.params.colours,
                &mut workspace,
            );
            observer.on(Event::Work)?;
        }
        ControlFlow::Continue(())
    }

    /// Levels `level` and `level + 1`.
    fn pair_of<'l>(
        levels: &'l mut [LevelMut<'a, T>],
        level: usize,
    ) -> (&'l mut LevelMut<'a, T>, &'l mut LevelMut<'a, T>) {
        let (fine, coarse) = levels.split_at_mut(level + 1);
        (&mut fine[level], &mut coarse[0])
    }

    /// max |f| on the finest level, NaN when anything is not finite.
    pub fn residual(&mut self, exec: &dyn Exec) -> f64 {
        let unit = match self.setup.params.norm {
            Norm::Scaled => self.levels[0].grid.h[0],
            Norm::Plain => 1.0,
        };
        residual::norm::<T, S>(
            exec,
            &self.levels[0],
            &self.weights,
            unit,
            self.sums,
            self.scratch,
        )
    }

    /// Both pressures of `level` with mean zero in every slot.
    fn remove_means(&mut self, exec: &dyn Exec, level: usize) {
        let LevelMut { grid, state, .. } = &mut self.levels[level];
        for field in [&mut *state.p, &mut *state.pbar] {
            means::remove(exec, grid, self.weights.slots, field, self.sums);
        }
    }
}
