//! What a run is made of, for who wants to look at it: one evaluation, the Hessian, the basis, one direction.

use super::condenser::Condenser;
use super::small::Square;
use crate::exec::{Capped, Exec};
use crate::real::Real;

impl<T: Real, const D: usize> Condenser<'_, T, D> {
    /// E and the residual at the present state, whose gradient is there afterwards.
    pub fn evaluate(&mut self, exec: &dyn Exec) -> [f64; 2] {
        let exec = Capped::new(exec, self.params.threads);
        self.fill_gradient(&exec);
        [self.energy_of(&exec, false), self.residual()]
    }

    /// Makes the Hessian at the present state, without the springs that a basis does not know unless `all`.
    pub fn make_hessian(&mut self, exec: &dyn Exec, all: bool) {
        self.fill_hessian(&Capped::new(exec, self.params.threads), all, None);
    }

    /// The block of the Hessian, as it was made last, of two vertices; 0 where they are not joined, or one is held.
    #[must_use]
    pub fn hessian_block(&self, one: usize, other: usize) -> Square<D> {
        let mut out = [[0.0; D]; D];
        let places =
            [one, other].map(|vertex| self.topology.place.get(vertex).copied().unwrap_or(u32::MAX) as usize);
        let block = self.hessian().block(places[0], places[1]).unwrap_or(&[]);
        for (to, from) in out.as_flattened_mut().iter_mut().zip(block) {
            *to = from.to_f64();
        }
        out
    }

    /// Builds the basis, or H0's factor, at the present state.
    pub fn build_basis(&mut self, exec: &dyn Exec) {
        self.build_here(&Capped::new(exec, self.params.threads));
    }

    /// How component `component` of vertex `vertex` follows a unit move of component `of` of vertex `column`, by the basis; blocks are vertices, or
    /// single components. 0 of what a column does not reach and of held vertices.
    #[must_use]
    pub fn basis_value(&self, [vertex, component]: [usize; 2], [column, of]: [usize; 2]) -> f64 {
        let place = |vertex: usize| self.topology.place.get(vertex).copied().unwrap_or(u32::MAX) as usize;
        let (row, column) = (place(vertex), place(column));
        let free = self.topology.free();
        if row >= free || column >= free {
            return 0.0;
        }
        let columns = self.columns();
        let size = self.params.size(D);
        let (begin, count) = columns.extent(column);
        let Some(local) = columns.local(column, row) else {
            return 0.0;
        };
        let begin = begin * D * D + of / size * count * D * size;
        let at = begin + (local * D + component) * size + of % size;
        self.buffers.basis.get(at).map_or(0.0, |value| value.to_f64())
    }

    /// R_j of vertex `vertex` at the present state.
    #[must_use]
    pub fn rotation(&self, vertex: usize) -> Square<D> {
        self.turn(vertex)
    }

    /// Finds the direction of the method at the present state, from the basis as it is; <g, d>.
    pub fn make_direction(&mut self, exec: &dyn Exec) -> f64 {
        let exec = Capped::new(exec, self.params.threads);
        self.fill_gradient(&exec);
        self.find_direction(&exec, self.params.method, None)
    }
}
