//! A Navier-Stokes problem (NSO) with a synthetic target, alone in its memory.

use super::flow;
use super::prepared::{in_block, no_memory};
use thurible::exit::Failure;
use thurible_core::field::VectorMut;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::memory::{Arena, TooSmall};
use thurible_core::memory::{Ledger, Pool};
use thurible_core::nso::damping::LocalDamping;
use thurible_core::nso::level::State;
use thurible_core::nso::{Bases, Finest, Nso, Setup, SmootherMemory, Workspace};
use thurible_core::{Boundary, Colours, Exec, Norm, NsoParams, Real, Space};

/// What is posed.
#[derive(Clone, Debug)]
pub struct Case {
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// Steps N; there are N - 1 slots.
    pub steps: usize,
    /// K / r in units of dt and length.
    pub kappa: f64,
    /// Largest Courant number of the target.
    pub courant: f64,
    /// The smoother's colours.
    pub colours: Colours,
    /// In which units max |f| is measured.
    pub norm: Norm,
    /// Where the smoother leaves terms out, at kappa = 1.
    pub damping: LocalDamping<f64>,
}

impl Case {
    /// A box with walls, kappa = 1, red-black, all four equations as accelerations.
    pub fn new(cells: &[usize], steps: usize, courant: f64) -> Self {
        Self {
            cells: cells.to_vec(),
            steps,
            kappa: 1.0,
            courant,
            colours: Colours::RedBlack,
            norm: Norm::Scaled,
            damping: LocalDamping::USUAL,
        }
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        Grid::new(&self.cells, &vec![Boundary::Wall; self.cells.len()])
    }

    fn setup<T: Real, S: Space>(&self, threads: usize) -> Setup {
        let params = NsoParams {
            tolerance: 0.0,
            cycles: 1,
            colours: self.colours,
            norm: self.norm,
            ..NsoParams::default()
        };
        let memory = SmootherMemory::all::<T, S>(&self.grid())
            .next()
            .unwrap_or(SmootherMemory::LEAST);
        Setup {
            kappa: self.kappa,
            viscosity: 0.0,
            slots: self.steps - 1,
            threads,
            params,
            damping: self.damping,
            memory,
            projection_tolerance: 0.0,
        }
    }

    /// Bytes of the unknowns v, w, p, pbar of the finest level.
    pub fn state_bytes<T: Real, S: Space>(&self) -> usize {
        2 * (1 + S::DIM) * self.grid().cells() * (self.steps - 1) * T::BYTES
    }

    /// Poses the problem with v = t, w = p = pbar = 0 and hands it to `work`.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for it.
    pub fn pose<T: Real, S: Space, R>(
        &self,
        exec: &dyn Exec,
        work: impl FnOnce(&mut Nso<'_, T, S>) -> R,
    ) -> Result<R, Failure> {
        let (grid, setup) = (self.grid(), self.setup::<T, S>(exec.threads()));
        let len = grid.cells() * setup.slots;
        let numbers = 3 * S::DIM * len + 2 * len + S::DIM * grid.cells() + pool_len::<T, S>(&grid, &setup);
        let bytes = T::BYTES * numbers + (1 << 23);
        in_block(bytes, |block| {
            self.pose_in(&mut Arena::new(block), &grid, &setup, work)
                .map_err(|TooSmall { .. }| no_memory(bytes))
        })
    }

    fn pose_in<T: Real, S: Space, R>(
        &self,
        arena: &mut Arena<'_>,
        grid: &Grid,
        setup: &Setup,
        work: impl FnOnce(&mut Nso<'_, T, S>) -> R,
    ) -> Result<R, TooSmall> {
        let (cells, len) = (grid.cells(), grid.cells() * setup.slots);
        let levels = Levels::<T>::carve(arena, grid, 0)?;
        let bases = Bases::<T>::carve::<S>(arena, &levels.grids)?;
        let target = flow::synthetic::<T, S>(grid, setup.slots, self.courant);
        let v = copied(arena.take_vector("field", S::DIM, len)?, &target);
        let a = copied(arena.take_vector("field", S::DIM, len)?, &target);
        drop(target);
        let state = State {
            v,
            w: arena.take_vector("field", S::DIM, len)?,
            p: arena.take("field", len)?,
            pbar: arena.take("field", len)?,
        };
        let finest = Finest {
            state,
            v0: arena.take_vector("field", S::DIM, cells)?,
            target: a,
            spare: Default::default(),
        };
        let mut pool = Pool::new(arena.take("workspace", pool_len::<T, S>(grid, setup))?);
        let space = Workspace::carve(&levels, &bases, setup, &mut pool);
        let mut sums = vec![0.0; grid.rows() * setup.slots];
        Ok(work(&mut Nso::<T, S>::new(
            &levels, &bases, finest, setup, space, &mut sums,
        )))
    }
}

fn pool_len<T: Real, S: Space>(grid: &Grid, setup: &Setup) -> usize {
    let levels = Levels::<T>::bare(grid, 0);
    let bases = Bases::bare(&levels.grids);
    let mut ledger = Ledger::new();
    Workspace::<T, S>::carve(&levels, &bases, setup, &mut Pool::measuring(&mut ledger));
    ledger.elements(T::BYTES)
}

fn copied<'m, T: Real>(mut to: VectorMut<'m, T>, from: &[Vec<T>; 3]) -> VectorMut<'m, T> {
    to.iter_mut()
        .zip(from)
        .for_each(|(to, from)| to.copy_from_slice(from));
    to
}
