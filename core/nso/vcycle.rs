//! One FAS V(2,2) cycle (paper Algorithm 2), coarsened in space alone.
//!
//! No copy of the coarse solution is kept: it is subtracted from the fine one on the way down, and added
//! again, corrected, on the way up. Among solid cells projections on the finest grid end it (see `closing`).

use super::multigrid::Nso;
use super::transfer::{add_prolonged, restrict_residual, restrict_solution};
use crate::exec::Exec;
use crate::grid::Space;
use crate::observe::Observer;
use crate::real::Real;
use core::ops::ControlFlow;

/// Smoothings before and after the coarser grids.
const SMOOTHINGS: usize = 2;
/// Smoothings on the coarsest grid, which has two cells along every axis.
const COARSEST: usize = 10;

impl<T: Real, S: Space> Nso<'_, T, S> {
    /// Improves the solution of level 0. A break leaves a valid, less improved solution.
    pub fn vcycle(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> ControlFlow<()> {
        let coarsest = self.levels.len() - 1;
        let mut flow = ControlFlow::Continue(());
        let mut depth = 0;
        while depth < coarsest && flow.is_continue() {
            flow = self.smooth(exec, observer, depth, SMOOTHINGS);
            self.descend(exec, depth);
            depth += 1;
        }
        if flow.is_continue() {
            flow = self.smooth(exec, observer, coarsest, COARSEST);
        }
        for level in (0..depth).rev() {
            self.ascend(exec, level);
            if flow.is_continue() {
                flow = self.smooth(exec, observer, level, SMOOTHINGS);
            }
            self.remove_means(exec, level);
        }
        flow?;
        self.close(exec, observer)
    }

    /// x_c = R x, f_c = lhs(x_c) + R residual(x), x -= P x_c.
    fn descend(&mut self, exec: &dyn Exec, level: usize) {
        let coefficients = self.coefficients;
        let tables = self.tables[level];
        let (fine, coarse) = Self::pair_of(&mut self.levels, level);
        restrict_solution(exec, fine, coarse, tables, coefficients.slots, self.scratch);
        restrict_residual::<T, S>(
            exec,
            fine,
            coarse,
            tables,
            &coefficients,
            self.setup.memory.split,
            self.scratch,
        );
        add_prolonged(
            exec,
            fine,
            coarse,
            tables,
            coefficients.slots,
            -T::ONE,
            self.scratch,
        );
    }

    /// x += P x_c.
    fn ascend(&mut self, exec: &dyn Exec, level: usize) {
        let slots = self.coefficients.slots;
        let tables = self.tables[level];
        let (fine, coarse) = Self::pair_of(&mut self.levels, level);
        add_prolonged(exec, fine, coarse, tables, slots, T::ONE, self.scratch);
    }
}
