//! A group of cells: one in each lane of a vector.

use super::edge::Edge;
use super::reflection::Place;
use super::storage::Header;
use crate::grid::Space;
use crate::nso::level::System;
use crate::real::Real;
use crate::simd::Vector;

/// Cells of one colour and one row that are solved at the same time.
pub(super) struct Group<'s, 'a, T> {
    pub(super) system: &'s System<'a, T>,
    pub(super) row: usize,
    /// The first cell, along x.
    pub(super) x: usize,
    /// The first cell, as a number among the row's cells of its colour.
    pub(super) first: usize,
    pub(super) count: usize,
    /// Whether there is a wall below along y: then p is the face above, and the faces along y change places
    /// in the system.
    pub(super) above_wall: bool,
    /// Whether lanes are in the order of the cells, or in that of [`Vector::load_pairs`].
    pub(super) in_order: bool,
}

impl<T: Real> Group<'_, '_, T> {
    /// Fills the header for lanes that repeat every `each` of them; 1 / 4h of an edge is 0 where it is on a
    /// wall.
    #[inline(always)]
    pub(super) fn fill_header<S: Space, V: Vector<Elem = T>>(&self, each: usize, header: &mut [T]) {
        let grid = self.system.grid;
        let lanes = V::LANES;
        let [y, z] = grid.row_at(self.row);
        for lane in 0..lanes {
            let cell = if self.in_order {
                lane % each
            } else {
                V::PAIRED[lane]
            };
            let at = [self.x + 2 * cell.min(self.count - 1), y, z];
            let solids = self.system.solids;
            let closed = grid.closed_faces(at) | solids.closed_faces(grid, at);
            let wall = |face: usize| closed >> face & 1 == 1;
            let row = &self.system.table[closed * Place::<S>::SIZE..][..Place::<S>::SIZE];
            for (q, &value) in row.iter().enumerate() {
                header[q * lanes + lane] = value;
            }
            for e in 0..S::EDGES {
                let edge = Edge::new::<S>(e);
                let free = !wall(edge.face_a())
                    && !wall(edge.face_b())
                    && !solids.is_dead(grid, at, (e / 4, [edge.a, edge.b]), [edge.side_a, edge.side_b]);
                for (i, axis) in [edge.a, edge.b].into_iter().enumerate() {
                    let inverse = if free {
                        T::from_f64(0.25 / grid.h[axis])
                    } else {
                        T::ZERO
                    };
                    header[(Header::<S>::EDGES + 2 * e + i) * lanes + lane] = inverse;
                }
            }
        }
    }

    /// What kappa and the changes' own derivatives in time add to M^T M on the diagonal in slot `k`.
    #[inline(always)]
    pub(super) fn diagonal(&self, k: usize) -> T {
        if k + 1 == self.system.slots {
            self.system.kappa
        } else {
            self.system.kappa + T::ONE
        }
    }

    /// 16 nu, which makes up for the two quarters that it meets: in omega or sigma, and in sigma.
    #[inline(always)]
    pub(super) fn viscosity<V: Vector<Elem = T>>(&self) -> V {
        V::splat(self.system.viscosity * T::from_f64(16.0))
    }
}
