//! What ends a cycle among solid cells: three projections on the finest grid.
//!
//! Coarse grids do not see a plate of one cell where it falls between two of their faces, nor the exact shape of anything else. So what they
//! correct flows through it, and their pressures are smooth where there is a jump. Both are matters of Poisson's problem alone, which is solved
//! among solids by other means (see [`crate::poisson`]): v is projected, w and p are taken from v, so that equations b, c and d hold, and
//! pbar becomes that which leaves of equation a a field free of divergence.

use super::level::LevelMut;
use super::multigrid::Nso;
use super::residual;
use super::workspace::Closing;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Block, VectorMut, reborrow, rows};
use crate::grid::Space;
use crate::observe::Observer;
use crate::real::Real;
use core::ops::ControlFlow;

/// What a projection leaves of the divergence that it finds. With a hundredth a cycle leaves hardly less.
const LEFT: f64 = 0.05;

impl<T: Real, S: Space> Nso<'_, T, S> {
    /// Ends a cycle: nothing is done where there are no solids.
    pub(super) fn close(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> ControlFlow<()> {
        let Some(mut closing) = self.closing.take() else {
            return ControlFlow::Continue(());
        };
        let ended = self.close_by(exec, observer, &mut closing);
        self.closing = Some(closing);
        ended
    }

    fn close_by(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        Closing { excess, projection }: &mut Closing<'_, T>,
    ) -> ControlFlow<()> {
        if let Some(LevelMut { state, .. }) = self.levels.first_mut() {
            projection.project(exec, observer, &mut state.v, None, LEFT, self.sums)?;
        }
        self.force_of_state(exec, true);
        if let Some(LevelMut { state, .. }) = self.levels.first_mut() {
            projection.project(exec, observer, &mut state.w, Some(state.p), LEFT, self.sums)?;
        }
        self.excess(exec, excess);
        if let Some(LevelMut { state, .. }) = self.levels.first_mut() {
            projection.project(exec, observer, excess, Some(state.pbar), LEFT, self.sums)?;
        }
        ControlFlow::Continue(())
    }

    /// `out` = left-hand side minus right-hand side of equation a.
    fn excess(&mut self, exec: &dyn Exec, out: &mut VectorMut<'_, T>) {
        let Some(level) = self.levels.first() else { return };
        let (slots, grid) = (self.coefficients.slots, level.grid);
        let system = level.system(&self.coefficients);
        let buffers = RowBuffers::fields(reborrow(out)).with_scratch(&mut *self.scratch);
        for_rows(exec, grid.rows(), buffers, |task| {
            let mut fields = task.fields;
            for block in Block::all(grid, slots) {
                let len = residual::rows_of::<S>() * block.len();
                let (values, work) = task.scratch.split_at_mut_checked(len).unwrap_or_default();
                let mut found = residual::Rows::new::<S>(block.len(), values);
                residual::of_block::<T, S>(&system, &block, task.row, &mut found, work);
                for (out, found) in fields.iter_mut().zip(found.a).take(S::DIM) {
                    rows::scale(rows::part_mut(out, block.span_in_row()), -T::ONE, found);
                }
            }
        });
    }
}
