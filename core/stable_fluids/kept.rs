//! What is kept of a simulation for the way back: states, or all that the adjoint reads of a step.

use super::cells::Cells;
use super::fields::{Flow, Parts, pitch};
use crate::field::view;
use crate::real::Real;

impl<T: Real> Flow<'_, T> {
    /// Numbers that hold the state at hand.
    #[must_use]
    pub fn state_len(cells: &Cells) -> usize {
        (cells.dims + 1) * pitch::<T>(cells.count())
    }

    /// Copies the state at hand.
    pub fn store(&self, slot: &mut [T]) {
        let each = pitch::<T>(self.cells.count()).max(1);
        let fields = core::iter::once(self.rho()).chain(self.v());
        for (slot, field) in slot.chunks_exact_mut(each).zip(fields) {
            self.cells
                .pack(field, slot.get_mut(..self.cells.count()).unwrap_or_default());
        }
    }

    /// Makes a copy the state at hand.
    pub fn restore(&mut self, slot: &[T]) {
        let cells = self.cells;
        let Parts { rho, v, .. } = self.parts();
        let each = pitch::<T>(cells.count()).max(1);
        for (slot, field) in slot.chunks_exact(each).zip(core::iter::once(rho).chain(v)) {
            cells.unpack(slot.get(..cells.count()).unwrap_or_default(), field);
        }
    }

    /// Numbers that hold what the adjoint of a step reads.
    #[must_use]
    pub fn tape_len(cells: &Cells, divergences: bool) -> usize {
        (2 * cells.dims + 1 + 2 * usize::from(divergences)) * pitch::<T>(cells.count())
    }

    /// Copies what the adjoint of the last step reads.
    pub fn record(&mut self, tape: &mut [T]) {
        let cells = self.cells;
        let each = pitch::<T>(cells.count()).max(1);
        let parts = self.parts();
        let [v3, v] = [&parts.v3, &parts.v].map(|field| view(field).into_iter().take(cells.dims));
        let kept = parts.kept.iter().map(|kept| &**kept);
        let fields = v3.chain(v).chain([&*parts.rho2]).chain(kept);
        for (tape, field) in tape.chunks_exact_mut(each).zip(fields) {
            cells.pack(field, tape.get_mut(..cells.count()).unwrap_or_default());
        }
    }

    /// Makes the fields of a step those at hand.
    pub fn replay(&mut self, tape: &[T]) {
        let cells = self.cells;
        let each = pitch::<T>(cells.count()).max(1);
        let parts = self.parts();
        let axes = || (0..cells.dims).map(Some);
        let v3 = parts.v3.into_iter().take(cells.dims).zip(axes());
        let v = parts.v.into_iter().take(cells.dims).zip(axes());
        let kept = parts.kept.into_iter().map(|field| (field, None));
        let fields = v3.chain(v).chain([(parts.rho2, None)]).chain(kept);
        for (tape, (field, component)) in tape.chunks_exact(each).zip(fields) {
            cells.unpack(tape.get(..cells.count()).unwrap_or_default(), field);
            cells.set_bnd(component, field);
        }
    }
}
