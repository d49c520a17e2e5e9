//! STFAS: the levels of a Navier-Stokes problem, and what is done on each of them.

use super::level::{Coefficients, LevelMut, State};
use super::params::{Norm, Setup};
use super::workspace::{Bases, Closing, Parts, Workspace};
use super::{residual, smoother};
use crate::exec::Exec;
use crate::field::{VectorMut, means};
use crate::grid::levels::{Levels, MAX_LEVELS};
use crate::grid::tables::Tables;
use crate::grid::{Grid, Space};
use crate::observe::{Event, Observer};
use crate::real::Real;
use core::marker::PhantomData;
use core::ops::ControlFlow;

/// The unknowns and data of the finest level, which live outside of NSO.
#[derive(Debug)]
pub struct Finest<'a, T> {
    /// The solution.
    pub state: State<'a, T>,
    /// The given velocity before slot 1.
    pub v0: VectorMut<'a, T>,
    /// The targets t_k.
    pub target: VectorMut<'a, T>,
    /// The right-hand side of equation c, buoyancy; empty where there is none.
    pub lift: VectorMut<'a, T>,
    /// A vector field that may be overwritten: the damped target, should damping be needed.
    pub spare: VectorMut<'a, T>,
}

/// One Navier-Stokes problem while it is solved: all levels and the scratch.
pub struct Nso<'a, T, S> {
    pub(super) levels: heapless::Vec<LevelMut<'a, T>, MAX_LEVELS>,
    pub(super) tables: heapless::Vec<&'a Tables<'a, T>, MAX_LEVELS>,
    pub(super) coefficients: Coefficients<T>,
    pub(super) setup: Setup,
    parts: Parts,
    pub(super) scratch: &'a mut [T],
    pub(super) sums: &'a mut [f64],
    pub(super) spare: VectorMut<'a, T>,
    pub(super) closing: Option<Closing<'a, T>>,
    space: PhantomData<S>,
}

/// Cells up to this many times as long as wide are smoothed as often as square ones.
const SQUARE_ENOUGH: f64 = 1.5;
/// Cells count as at most this many times as long as wide.
const LONGEST: f64 = 32.0;

/// How often to smooth a grid instead of `times`. Long thin boxes have coarse grids of few but long cells, on which the
/// smoother couples neighbours across alone. Along the cells it then takes as many smoothings as diffusion does: stretch^2 / 2
/// times as many, for cells `stretch` times as long as wide.
fn stretched<S: Space>(grid: &Grid, times: usize) -> usize {
    let sizes = grid.h.iter().copied().take(S::DIM);
    let longest = sizes.clone().fold(0.0, f64::max);
    let shortest = sizes.fold(f64::MAX, f64::min);
    let stretch = (longest / shortest).min(LONGEST);
    if stretch > SQUARE_ENOUGH {
        libm::ceil(times as f64 * stretch * stretch / 2.0) as usize
    } else {
        times
    }
}

/// What the equations of all levels share.
fn coefficients<T: Real>(setup: &Setup) -> Coefficients<T> {
    Coefficients {
        slots: setup.slots,
        kappa: T::from_f64(setup.kappa),
        viscosity: T::from_f64(setup.viscosity),
        surroundings: setup.surroundings.to(),
        damping: setup.damping.at(setup.kappa),
    }
}

impl<'a, T: Real, S: Space> Nso<'a, T, S> {
    /// Puts the levels together; the coarse ones and all scratch are those of `workspace`.
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
            solids: hierarchy.solids(0),
            state: finest.state,
            v0: finest.v0,
            a: finest.target,
            scale: T::from_f64(setup.kappa),
            b: &mut [],
            c: finest.lift,
            d: &mut [],
            table: &*bases.tables[0],
        };
        Self {
            levels: core::iter::once(first).chain(workspace.coarse).collect(),
            tables: hierarchy.tables.iter().collect(),
            coefficients: coefficients(setup),
            setup: *setup,
            parts: workspace.parts,
            scratch: workspace.scratch,
            sums,
            spare: finest.spare,
            closing: workspace.closing,
            space: PhantomData,
        }
    }

    /// Smooths level `level` a few times, more often where its cells are much longer than wide.
    pub(super) fn smooth(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        level: usize,
        times: usize,
    ) -> ControlFlow<()> {
        let (waiting, lines) = self.scratch.split_at_mut(self.parts.waiting);
        let mut workspace = smoother::Workspace {
            waiting,
            scratch: &mut lines[..self.parts.lines],
            memory: self.setup.memory,
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
    pub(super) fn pair_of<'l>(
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
    pub(super) fn remove_means(&mut self, exec: &dyn Exec, level: usize) {
        let LevelMut { grid, state, .. } = &mut self.levels[level];
        for field in [&mut *state.p, &mut *state.pbar] {
            means::remove(exec, grid, self.coefficients.slots, field, self.sums);
        }
    }
}
