//! A Navier-Stokes problem (NSO) with a synthetic target, alone in its memory.

use super::flow;
use core::mem::MaybeUninit;
use thurible::region::Region;
use thurible_core::arena::Arena;
use thurible_core::field::VectorMut;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::nso::level::State;
use thurible_core::nso::{Bases, Finest, Nso, Setup, Shape};
use thurible_core::plan::{Ledger, Pool};
use thurible_core::{Boundary, Colours, Exec, Norm, NsoParams, Real, Space};

/// What is posed.
#[derive(Clone, Debug)]
pub struct Case {
    /// Cells along each axis.
    pub cells: Vec<usize>,
    /// Steps N; there are N - 1 slots.
    pub steps: usize,
    /// K / r in scaled numbers.
    pub kappa: f64,
    /// Largest Courant number of the target.
    pub courant: f64,
    /// The smoother's colours.
    pub colours: Colours,
}

impl Case {
    /// A box with walls, kappa = 1, red-black.
    pub fn new(cells: &[usize], steps: usize, courant: f64) -> Self {
        Self { cells: cells.to_vec(), steps, kappa: 1.0, courant, colours: Colours::RedBlack }
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        Grid::new(&self.cells, &vec![Boundary::Wall; self.cells.len()])
    }

    fn setup<S: Space>(&self, threads: usize) -> Setup {
        let params = NsoParams { tolerance: 0.0, cycles: 1, colours: self.colours, norm: Norm::Scaled, ..NsoParams::default() };
        let shape = Shape { lanes: 16, together: if S::DIM == 2 { 8 } else { 1 } };
        Setup { kappa: self.kappa, viscosity: 0.0, slots: self.steps - 1, threads, params, shape }
    }

    /// Bytes of the unknowns v, w, p, pbar of the finest level.
    pub fn state_bytes<T: Real, S: Space>(&self) -> usize {
        2 * (1 + S::DIM) * self.grid().cells() * (self.steps - 1) * T::BYTES
    }

    /// Poses the problem with v = t, w = p = pbar = 0 and hands it to `work`.
    pub fn pose<T: Real, S: Space, R>(&self, exec: &dyn Exec, work: impl FnOnce(&mut Nso<'_, T, S>) -> R) -> R {
        let (grid, setup) = (self.grid(), self.setup::<S>(exec.threads()));
        let (cells, len) = (grid.cells(), grid.cells() * setup.slots);
        let target = flow::synthetic::<T, S>(&grid, setup.slots, self.courant);
        let numbers = 3 * S::DIM * len + 2 * len + S::DIM * cells + pool_len::<T, S>(&grid, &setup);
        let mut region = Region::new(2 * T::BYTES * numbers + (1 << 24)).unwrap();
        let block: &mut [MaybeUninit<u8>] = region.carve(T::BYTES * numbers + (1 << 23)).unwrap();
        let mut arena = Arena::new(block);
        let levels = Levels::<T>::carve(&mut arena, &grid).unwrap();
        let bases = Bases::<T>::carve::<S>(&mut arena, &levels.grids).unwrap();
        let (v, w, a) = (vector::<T, S>(&mut arena, len), vector::<T, S>(&mut arena, len), vector::<T, S>(&mut arena, len));
        let v = copied(v, &target);
        let a = copied(a, &target);
        drop(target);
        let state = State { v, w, p: arena.take(len).unwrap(), pbar: arena.take(len).unwrap() };
        let finest = Finest { state, v0: vector::<T, S>(&mut arena, cells), target: a, spare: Default::default() };
        let mut pool = Pool::new(arena.take(pool_len::<T, S>(&grid, &setup)).unwrap());
        let mut sums = vec![0.0; grid.rows() * setup.slots];
        work(&mut Nso::<T, S>::new(&levels, &bases, finest, &setup, &mut pool, &mut sums))
    }
}

fn pool_len<T: Real, S: Space>(grid: &Grid, setup: &Setup) -> usize {
    let mut ledger = Ledger::new();
    Nso::<T, S>::requirement(&mut ledger, grid, setup.slots, setup.threads, setup.shape);
    ledger.bytes().unwrap() / T::BYTES
}

fn vector<'m, T: Real, S: Space>(arena: &mut Arena<'m>, len: usize) -> VectorMut<'m, T> {
    core::array::from_fn(|axis| if axis < S::DIM { arena.take(len).unwrap() } else { Default::default() })
}

fn copied<'m, T: Real>(to: VectorMut<'m, T>, from: &[Vec<T>; 3]) -> VectorMut<'m, T> {
    let mut from = from.iter();
    to.map(|component| {
        component.copy_from_slice(from.next().unwrap());
        component
    })
}
