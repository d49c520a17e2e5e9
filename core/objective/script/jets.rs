//! Emitters whose smoke comes with a velocity: what they do to the flow.
//!
//! While an emitter of shape E with velocity V emits, a face between two of its cells gets, in every step, the acceleration that takes its
//! velocity to V: all of the way where E is 1, and the part e = min(1, E_low, E_high) of it elsewhere,
//!
//! ```text
//! (v_k - v_{k-1}) + Adv(v_k) + ... = u_{k-1} + T_k - K_k v_{k-1},    K = e, T = e V
//! ```
//!
//! Several one after the other: K <- K + e - K e, T <- (1 - e) T + e V. K is diagonal and between 0 and 1, so nothing grows by it.

use super::Script;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::slot::Slot;
use crate::field::{VectorMut, reborrow, rows::part};
use crate::grid::solids::{Solids, closed};
use crate::grid::{Grid, Side};
use crate::real::Real;

/// The emitters that push the flow of a grid.
#[derive(Clone, Copy, Debug)]
pub struct Jets<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// The solid cells in it: at closed faces nothing is pushed.
    pub solids: Solids<'a>,
    /// Emitters and their shapes.
    pub script: Script<'a, T>,
}

impl<'a, T: Real> Script<'a, T> {
    /// Number, shape and velocity of each emitter that pushes v_slot, counted from 0, on its way to v_{slot+1}.
    pub(super) fn jets(
        &self,
        slot: usize,
        cells: usize,
    ) -> impl Iterator<Item = (usize, &'a [T], [f64; 3])> + Clone + use<'a, T> {
        let (first, stride) = (self.lists.emitters_begin(), self.stride.get());
        let at = |slot: usize| self.first + slot as u32 * stride;
        let (begin, end, fields) = (at(slot), at(slot + 1), self.fields);
        let spans = self.lists.spans.as_chunks().0.iter();
        let each = spans.zip(self.lists.jets.as_chunks().0).enumerate();
        each.filter_map(move |(index, (&[from, to], &[pushes, x, y, z]))| {
            let field = (first + index) * cells..(first + index + 1) * cells;
            let acts = pushes != 0.0 && from < end && begin < to;
            // A long step goes as far as all its short ones.
            acts.then(|| {
                (
                    index,
                    part(fields, field),
                    [x, y, z].map(|v: f64| v * f64::from(stride)),
                )
            })
        })
    }

    /// The velocity to which emitter `index` pushes v_slot, where it does.
    #[must_use]
    pub fn jet(&self, slot: usize, index: usize, cells: usize) -> Option<[f64; 3]> {
        let mut jets = self.jets(slot, cells);
        jets.find(|(other, ..)| *other == index).map(|(.., along)| along)
    }

    /// Whether an emitter ever pushes.
    #[must_use]
    pub fn pushes(&self) -> bool {
        !self.lists.jets.is_empty()
    }
}

impl<T: Real> Jets<'_, T> {
    /// Whether nothing is ever pushed.
    #[must_use]
    pub fn is_none(&self) -> bool {
        !self.script.pushes()
    }

    /// `out += a T + b K x` for v_slot on its way to v_{slot+1}, in slot `to` of `out`.
    ///
    /// What emitters do to v is a = 1, b = -1 and x = v_slot; the adjoint of that in v_slot is a = 0, b = -1 and x the covector.
    pub fn add(
        &self,
        exec: &dyn Exec,
        [a, b]: [f64; 2],
        slot: usize,
        x: Slot<'_, T>,
        (out, to): (&mut VectorMut<'_, T>, usize),
    ) {
        let (grid, n) = (self.grid, self.grid.n[0]);
        if !self.push(slot) {
            return;
        }
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
            for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                let (x, out) = (
                    x.row(grid, axis, task.row),
                    out.get_mut(to * n..).unwrap_or_default(),
                );
                let faces = out.iter_mut().zip(x).zip(self.row(slot, axis, task.row));
                for ((out, x), [target, part]) in faces {
                    *out += T::from_f64(a * target + b * part * x.to_f64());
                }
            }
        });
    }

    /// Whether any emitter pushes v_slot.
    #[must_use]
    pub fn push(&self, slot: usize) -> bool {
        self.script.jets(slot, self.grid.cells()).next().is_some()
    }

    /// T and K at the low face across `axis` of each cell of a row; 0 where nothing pushes v_slot, on walls and at closed faces.
    pub fn row(&self, slot: usize, axis: usize, row: usize) -> impl Iterator<Item = [f64; 2]> {
        let (grid, n) = (self.grid, self.grid.n[0]);
        let jets = self.script.jets(slot, grid.cells());
        let open = self.solids.row(n, row);
        let low = match axis {
            0 => Some(row),
            _ => grid.neighbour(row, axis, Side::Low),
        };
        (0..n).map(move |at| {
            let below = match axis {
                0 => at.checked_sub(1).or(grid.axis(0).is_ring().then_some(n - 1)),
                _ => Some(at),
            };
            let is_open = open.get(at).is_none_or(|bits| bits & closed(axis) == 0);
            match (low, below, is_open) {
                (Some(low), Some(below), true) => joined(jets.clone(), [low * n + below, row * n + at], axis),
                _ => [0.0; 2],
            }
        })
    }
}

/// T and K of all emitters at the face between two cells.
fn joined<'s, T: Real + 's>(
    jets: impl Iterator<Item = (usize, &'s [T], [f64; 3])>,
    cells: [usize; 2],
    axis: usize,
) -> [f64; 2] {
    jets.fold([0.0; 2], |[target, part], (_, shape, along)| {
        let inside = cells.map(|cell| shape.get(cell).map_or(0.0, |x| x.to_f64()));
        let e = inside.into_iter().fold(1.0, f64::min);
        let v = along.get(axis).copied().unwrap_or(0.0);
        [(1.0 - e) * target + e * v, part + e - part * e]
    })
}
