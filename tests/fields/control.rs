//! One call of AO by the core on a trajectory: the data term of the flow, and its gradient.

use crate::fields::{Components, Memory, view, view_mut, zeros};
use thurible_core::ao::{self, Fields, Setup};
use thurible_core::arena::Arena;
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::plan::Ledger;
use thurible_core::problem::keyframes::Keyframes;
use thurible_core::{Advection, Real, Serial, Silent};

/// A flow that should carry `source` to the targets.
pub struct Control<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// N.
    pub steps: usize,
    /// rho_0.
    pub source: &'a [T],
    /// Steps of the keyframes.
    pub keyframes: &'a [u32],
    /// Their densities, one after the other.
    pub targets: &'a [T],
    /// v_0.
    pub initial: &'a Components<T>,
    /// The transport.
    pub advection: Advection,
    /// Filters of the metric.
    pub filters: usize,
    /// Penalty K.
    pub penalty: f64,
}

/// What a call found.
pub struct Found<T> {
    /// Q(v + lambda/K + A_v^T mu / K) - v*, of the last iteration.
    pub direction: Components<T>,
    /// What AO says of itself.
    pub info: ao::Info,
}

impl<T: Real> Control<'_, T> {
    /// One call of AO with `iterations` from v with multipliers lambda / K.
    pub fn solve(&self, v: &Components<T>, multiplier: &Components<T>, iterations: usize) -> Found<T> {
        let (grid, slots) = (self.grid, self.steps - 1);
        let setup = Setup {
            penalty: self.penalty,
            iterations,
            momentum: 0.0,
            slots,
            filters: self.filters,
            advection: self.advection,
            largest: 1.0,
            projection_tolerance: 1e-13,
            threads: 1,
        };
        let mut ledger = Ledger::new();
        ao::requirement::<T>(&mut ledger, grid, &setup);
        let mut region = vec![T::ZERO; ledger.bytes().unwrap() / T::BYTES];
        let mut sums = vec![0.0; grid.rows() * slots.max(2)];
        let mut memory = Memory::new(1 << 20);
        let levels = Levels::carve(&mut Arena::new(memory.block()), grid).unwrap();
        let (mut star, mut direction) = (v.clone(), zeros(grid, slots));
        let mut rho = self.source.repeat(self.steps + 1);
        let (mut steps, mut targets) = (self.keyframes.to_vec(), self.targets.to_vec());
        let keyframes = Keyframes { steps: &mut steps, densities: &mut targets };
        let fields = Fields {
            v: view(v),
            multiplier: view(multiplier),
            star: view_mut(&mut star),
            direction: view_mut(&mut direction),
            initial: view(self.initial),
            rho: &mut rho,
            keyframes: &keyframes,
        };
        let mut step = 1.0;
        let info = ao::solve(&Serial, &mut Silent, &levels, &setup, fields, &mut step, &mut region, &mut sums).unwrap();
        Found { direction, info }
    }
}
