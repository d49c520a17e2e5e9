//! What self-advection does at exits, the faces of open sides.
//!
//! In (curl v) x v the potential p is the head, pressure and v^2 / 2. What flows out keeps its speed at the pressure 0, so that the head outside
//! is o^2 / 2 with the outward speed o > 0; air that comes in was at rest, with the head 0. The gradient of that head at an exit is the term
//!
//! ```text
//! Adv(v) gets max(o, 0)^2 / (2 h) outwards        <v, Adv(v)> = sum over exits of max(o, 0)^3 / (2 h): the energy that leaves
//! ```
//!
//! Without it no energy would leave with the flow that does, and jets would pile up before an exit.

use crate::field::rows::{part, part_mut};
use crate::field::{Block, Vector};
use crate::grid::solids::{OUTSIDE, Solids, exit};
use crate::operators::plaquette::{Adjoint, Advection, Bend, Derivative};
use crate::real::Real;

/// What a rule of the plaquettes does at exits.
pub trait AtExits<T>: Copy {
    /// What an exit gets outwards, times h, with the outward speed `out` and that of the second field.
    fn leaving(self, out: T, second: T) -> T;
}

impl<T: Real> AtExits<T> for Advection<T> {
    fn leaving(self, out: T, _second: T) -> T {
        let out = out.max(T::ZERO);
        T::HALF * out * out
    }
}

impl<T: Real> AtExits<T> for Derivative<T> {
    fn leaving(self, out: T, second: T) -> T {
        out.max(T::ZERO) * second
    }
}

impl<T: Real> AtExits<T> for Adjoint<T> {
    fn leaving(self, out: T, second: T) -> T {
        out.max(T::ZERO) * second
    }
}

impl<T: Real> AtExits<T> for Bend {
    fn leaving(self, _out: T, _second: T) -> T {
        T::ZERO
    }
}

/// Adds what exits get in a row of a block.
pub fn add<T: Real, R: AtExits<T>>(
    (block, row, solids): (&Block<'_>, usize, Solids<'_>),
    rule: R,
    v: Vector<'_, T>,
    second: Vector<'_, T>,
    out: &mut [&mut [T]; 3],
) {
    let (grid, n) = (block.grid, block.grid.n[0]);
    if !grid.is_open() {
        return;
    }
    let table = solids.row(n, row);
    for (axis, out) in out.iter_mut().enumerate().take(grid.dims) {
        let inverse = T::from_f64(1.0 / grid.h[axis]);
        let exits = table
            .iter()
            .enumerate()
            .filter(|(_, bits)| **bits & exit(axis) != 0);
        for (x, bits) in exits {
            // Low faces: of a cell outside it is on the high side of the box.
            let outwards = if bits & OUTSIDE != 0 { T::ONE } else { -T::ONE };
            for slot in 0..block.count {
                let at = slot * n + x;
                let of = |field: &[T]| {
                    let field = if field.is_empty() {
                        field
                    } else {
                        block.of(field, row)
                    };
                    part(field, at..at + 1).first().map_or(T::ZERO, |&x| outwards * x)
                };
                let leaves = rule.leaving(of(v[axis]), of(second[axis]));
                part_mut(out, at..at + 1)
                    .iter_mut()
                    .for_each(|out| *out += outwards * inverse * leaves);
            }
        }
    }
}
