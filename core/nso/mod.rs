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
use crate::memory::{Arena, Pool, Sharing, TooSmall, pooled};
use crate::observe::{Event, Observer, Phase};
use crate::real::Real;
use colours::Colours;
use core::marker::PhantomData;
use core::ops::ControlFlow;
use level::{Coefficients, LevelMut, State};

/// How observers hear of a Navier-Stokes problem.
pub const NSO: Phase = Phase {
    name: "nso",
    words: "Navier-Stokes problem",
    measure: "residual",
};

/// The smoother's bases on every grid: what NSO keeps for the whole solve.
#[derive(Debug)]
pub struct Bases<'m, T> {
    tables: heapless::Vec<&'m mut [T], MAX_LEVELS>,
}

impl<'m, T: Real> Bases<'m, T> {
    /// Without its elements, which workspaces do not need to be measured.
    #[must_use]
    pub fn bare(grids: &[Grid]) -> Self {
        Self {
            tables: grids.iter().map(|_| Default::default()).collect(),
        }
    }

    /// Takes its numbers and fills them.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn carve<S: Space>(arena: &mut Arena<'m>, grids: &[Grid]) -> Result<Self, TooSmall> {
        let elements = arena.take::<T>("smoother bases", pooled(local::table_len::<S>()) * grids.len())?;
        if arena.ledger().is_some() {
            return Ok(Self::bare(grids));
        }
        let mut pool = Pool::new(elements);
        let fill = |grid: &Grid| {
            let table = pool.take("basis", local::table_len::<S>());
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

/// Elements of the parts of the scratch.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    waiting: usize,
    lines: usize,
    transfer: usize,
}

impl Sizes {
    fn new<S: Space>(finest: &Grid, slots: usize, threads: usize, shape: Shape) -> Self {
        Self {
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

/// The coarse levels of STFAS and its scratch.
pub struct Workspace<'a, T, S> {
    coarse: heapless::Vec<LevelMut<'a, T>, MAX_LEVELS>,
    scratch: &'a mut [T],
    sizes: Sizes,
    space: PhantomData<S>,
}

impl<'a, T: Real, S: Space> Workspace<'a, T, S> {
    /// Takes them from a pool.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        bases: &'a Bases<'_, T>,
        setup: &Setup,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let slots = setup.slots;
        let sizes = Sizes::new::<S>(&hierarchy.finest, slots, setup.threads, setup.shape);
        pool.group("Navier-Stokes problem (NSO)", Sharing::Together, |pool| {
            let grids = hierarchy.grids.iter().zip(&bases.tables).skip(1);
            let coarse = pool.line("coarse levels", |pool| {
                grids
                    .map(|(grid, base)| LevelMut::coarse::<S>(grid, base, slots, pool))
                    .collect()
            });
            let uses = [
                (
                    "smoother: waiting changes, lines in time",
                    sizes.waiting + sizes.lines,
                ),
                ("transfer: rows of a block, residuals that wait", sizes.transfer),
            ];
            Self {
                coarse,
                scratch: pool.take_longest("smoothing or transfer", &uses),
                sizes,
                space: PhantomData,
            }
        })
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
    /// Assembles the levels; the coarse ones and all scratch are `workspace`.
    pub fn new(
        hierarchy: &'a Levels<'_, T>,
        bases: &'a Bases<'_, T>,
        finest: Finest<'a, T>,
        setup: &Setup,
        workspace: Workspace<'a, T, S>,
        sums: &'a mut [f64],
    ) -> Self {
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
        let coefficients = Coefficients {
            slots: setup.slots,
            kappa: T::from_f64(setup.kappa),
            viscosity: T::from_f64(setup.viscosity),
            outside: T::from_f64(outside_weight::<S>(setup.params.colours)),
            damping: setup.damping.at(setup.kappa),
        };
        Self {
            levels: core::iter::once(first).chain(workspace.coarse).collect(),
            tables: hierarchy.tables.iter().collect(),
            coefficients,
            setup: *setup,
            sizes: workspace.sizes,
            scratch: workspace.scratch,
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
