//! States between two steps, kept and fetched.

use super::Operator;
use super::layout::state_len;
use crate::field::{VectorMut, rows, view};
use crate::grid::Space;
use crate::real::Real;
use crate::transport::Flow;

impl<T: Real, S: Space> Operator<'_, T, S> {
    /// The state after a step becomes that at hand.
    pub(super) fn go_on(&mut self) {
        let cells = self.grid().cells();
        self.rho.copy_within(cells.., 0);
        self.v.rotate_left(1);
    }

    /// Keeps the state at hand.
    pub(super) fn store(&mut self, slot: usize) {
        let (grid, len) = (self.levels.finest, state_len(&self.levels.finest));
        let cells = grid.cells();
        let [before, v, _] = &self.v;
        let parts = v.iter().take(grid.dims).chain(before.iter().take(grid.dims));
        let kept = rows::part_mut(self.kept, slot * len..(slot + 1) * len);
        let (density, rest) = kept.split_at_mut_checked(cells).unwrap_or_default();
        density.copy_from_slice(rows::part(self.rho, 0..density.len()));
        for (to, from) in rest.chunks_exact_mut(cells).zip(parts) {
            to.copy_from_slice(from);
        }
    }

    /// Makes a kept state that at hand.
    pub(super) fn restore(&mut self, slot: usize) {
        let (grid, len) = (self.levels.finest, state_len(&self.levels.finest));
        let cells = grid.cells();
        let [before, v, _] = &mut self.v;
        let parts = v
            .iter_mut()
            .take(grid.dims)
            .chain(before.iter_mut().take(grid.dims));
        let kept = rows::part(self.kept, slot * len..(slot + 1) * len);
        let (density, rest) = kept.split_at_checked(cells).unwrap_or_default();
        rows::part_mut(self.rho, 0..density.len()).copy_from_slice(density);
        for (from, to) in rest.chunks_exact(cells).zip(parts) {
            to.copy_from_slice(from);
        }
    }
}

/// A flow of one step.
pub(super) fn flow<'a, T>(v: &'a VectorMut<'_, T>) -> Flow<'a, T> {
    Flow {
        initial: view(v),
        v: [&[]; 3],
        along: None,
    }
}
