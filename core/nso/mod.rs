//! NSO, the Navier-Stokes problem of the paper (section 4.2, eq. 13), by the spacetime full-approximation multigrid (STFAS).
//!
//! For targets t_k: the smallest kappa |v_k - t_k|^2 + |w_k|^2 over flows v driven by forces w.

mod collect;
pub mod colours;
pub mod damping;
pub mod info;
pub mod level;
pub mod local;
pub mod newton;
pub mod params;
mod pass;
mod pending;
mod reduced;
pub mod residual;
pub mod smoother;
pub mod solve;
pub mod transfer;
pub mod vcycle;
mod window;

pub use info::{Ended, Info, MAX_CYCLES};
pub use params::{Norm, NsoParams, NsoSolver, Setup, Shape, Split};

use crate::exec::Exec;
use crate::field::{VectorMut, means};
use crate::grid::levels::{self, Levels, MAX_LEVELS};
use crate::grid::tables::Tables;
use crate::grid::{Grid, Space};
use crate::memory::{Arena, Ledger, Pool, Sharing, TooSmall, pooled};
use crate::observe::{Event, Observer};
use crate::real::Real;
use colours::Colours;
use core::marker::PhantomData;
use core::ops::ControlFlow;
use level::{Coefficients, LevelMut, State};

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

/// One Navier-Stokes problem while it is solved: all levels and the scratch.
pub struct Nso<'a, T, S> {
    levels: heapless::Vec<LevelMut<'a, T>, MAX_LEVELS>,
    tables: heapless::Vec<&'a Tables<'a, T>, MAX_LEVELS>,
    coefficients: Coefficients<T>,
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
        let coefficients = Coefficients {
            slots,
            kappa: T::from_f64(setup.kappa),
            viscosity: T::from_f64(setup.viscosity),
            outside: T::from_f64(outside_weight::<S>(setup.params.colours)),
            damping: setup.damping.at(setup.kappa),
        };
        let scratch = pool.take((sizes.waiting + sizes.lines).max(sizes.transfer));
        Self {
            levels,
            tables: hierarchy.tables.iter().collect(),
            coefficients,
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
                &self.coefficients,
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
            &self.coefficients,
            unit,
            self.sums,
            self.scratch,
        )
    }

    /// Both pressures of `level` with mean zero in every slot.
    fn remove_means(&mut self, exec: &dyn Exec, level: usize) {
        let LevelMut { grid, state, .. } = &mut self.levels[level];
        for field in [&mut *state.p, &mut *state.pbar] {
            means::remove(exec, grid, self.coefficients.slots, field, self.sums);
        }
    }
}
