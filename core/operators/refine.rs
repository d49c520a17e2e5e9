//! A flow on a grid of twice as many cells along every axis, with the divergence that it has (mathematics section 9).
//!
//! Along its own axis a component is interpolated through four faces by a cubic (Deslauriers & Dubuc 1989), across it by the parabola
//! that has the means of three faces:
//!
//! ```text
//! along:    f_{2i} = F_i                                f_{2i+1} = (9 (F_i + F_{i+1}) - F_{i-1} - F_{i+2}) / 16
//! across:   f_{2i} = F_i - (F_{i+1} - F_{i-1}) / 8      f_{2i+1} = F_i + (F_{i+1} - F_{i-1}) / 8
//! ```
//!
//! The children of a face carry together what it carries. The differences of what the first rule makes, over half the length, are what the
//! second one makes of the differences: so div f is the second rule along all axes of div F, and 0 where that is 0 around.
//! Behind a wall stands the mirror image: of a component along the wall the same, of one through it the opposite. Behind an open side a component
//! along it is mirrored too, and one through it goes on as it comes, F_{-1} = 2 F_0 - F_1: there div F is what it is on this side.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, rows};
use crate::grid::{Axis, Grid};
use crate::real::Real;

/// Values beside a row that its children ask for: one before, two after.
const BESIDE: usize = 3;
/// Values of the coarser grid that make one.
const TAPS: usize = 4;
/// The most that stand for them where some are beyond the box.
const PLACES: usize = 2 * TAPS;

/// How a value is made of those of the coarser grid along an axis.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// Of faces along their own axis.
    Along,
    /// Of faces across it.
    Across,
}

/// Places on the coarser grid and their weights.
type Taps = heapless::Vec<(usize, f64), PLACES>;

impl Rule {
    /// Weights of the values at offsets -1, 0, 1, 2 from the parent, for its first child and its second.
    const fn weights(self) -> [[f64; TAPS]; 2] {
        match self {
            Self::Along => [
                [0.0, 1.0, 0.0, 0.0],
                [-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0],
            ],
            Self::Across => [[0.125, 1.0, -0.125, 0.0], [-0.125, 1.0, 0.125, 0.0]],
        }
    }

    /// What stands for the value of the coarser grid at index `i`, counted from the first inside.
    fn sources(self, axis: Axis, i: isize) -> heapless::Vec<(usize, f64), 2> {
        match self {
            Self::Along => axis.continued_face(i),
            Self::Across => {
                heapless::Vec::from_iter([(axis.mirrored(axis.inside().start as isize + i), 1.0)])
            }
        }
    }

    /// How many values there are inside, an open side at the end counted.
    fn count(self, axis: Axis) -> usize {
        let inside = axis.inside();
        inside.len() + usize::from(self == Self::Along && inside.end < axis.cells())
    }

    /// What makes value `i` of the finer grid; `axis` is that of the coarser one. Nothing outside the box.
    fn taps(self, axis: Axis, i: usize) -> Taps {
        let last = 2 * axis.inside().len() + self.count(axis) - axis.inside().len();
        let Some(i) = i.checked_sub(axis.inside().start).filter(|i| *i < last) else {
            return Taps::new();
        };
        let weights = self.weights()[i % 2];
        let taps = weights
            .into_iter()
            .enumerate()
            .filter(|&(_, weight)| weight != 0.0);
        taps.flat_map(|(offset, weight)| {
            let sources = self.sources(axis, (i / 2 + offset) as isize - 1);
            sources.into_iter().map(move |(at, factor)| (at, factor * weight))
        })
        .collect()
    }
}

/// Scratch of a thread.
#[must_use]
pub fn scratch_per_thread(coarse: &Grid) -> usize {
    coarse.n[0] + BESIDE
}

/// `fine` = the flow `coarse` on a grid of twice as many cells along every axis. `scratch` has [`scratch_per_thread`] for every thread.
pub fn double<T: Real>(
    exec: &dyn Exec,
    (from, to): (&Grid, &Grid),
    coarse: Vector<'_, T>,
    fine: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let rule = |component: usize, axis: usize| {
        if component == axis {
            Rule::Along
        } else {
            Rule::Across
        }
    };
    let buffers = RowBuffers::fields(fine).with_scratch(scratch);
    for_rows(exec, to.rows(), buffers, |task| {
        let [y, z] = to.row_at(task.row);
        let fields = task.fields.into_iter().zip(coarse).enumerate();
        for (component, (out, values)) in fields.take(to.dims) {
            let sum = rows::part_mut(task.scratch, 0..scratch_per_thread(from));
            let (inner, n) = (1..1 + from.n[0], from.n[0]);
            rows::part_mut(sum, inner.clone()).fill(T::ZERO);
            let in_z = if to.dims == 3 {
                rule(component, 2).taps(from.axis(2), z)
            } else {
                Taps::from_iter([(0, 1.0)])
            };
            for &(z, weight_z) in &in_z {
                for (y, weight_y) in rule(component, 1).taps(from.axis(1), y) {
                    let row = from.row(y, z);
                    let source = rows::part(values, row * n..(row + 1) * n);
                    rows::add_scaled(
                        rows::part_mut(sum, inner.clone()),
                        T::from_f64(weight_y * weight_z),
                        source,
                    );
                }
            }
            expand(rule(component, 0), from.axis(0), sum, out);
        }
    });
}

/// `out` = the children of a row, which has one value before it and two after it, to be filled.
fn expand<T: Real>(rule: Rule, axis: Axis, row: &mut [T], out: &mut [T]) {
    let (start, count) = (axis.inside().start, rule.count(axis));
    let line = rows::part_mut(row, start..start + count + BESIDE);
    for i in [-1, count as isize, count as isize + 1] {
        let sources = rule.sources(axis, i);
        let value = sources.into_iter().fold(T::ZERO, |sum, (at, factor)| {
            let value = line.get(1 + at - start).copied().unwrap_or(T::ZERO);
            sum + T::from_f64(factor) * value
        });
        if let Some(place) = line.get_mut((1 + i) as usize) {
            *place = value;
        }
    }
    let weights = rule.weights().map(|weights| weights.map(T::from_f64));
    let inside = start..start + axis.inside().len() + count;
    out.fill(T::ZERO);
    let children = rows::part_mut(out, inside).chunks_mut(2);
    for (children, around) in children.zip(line.windows(TAPS)) {
        for (child, weights) in children.iter_mut().zip(weights) {
            let products = around.iter().zip(weights).map(|(&value, weight)| weight * value);
            *child = products.fold(T::ZERO, |sum, product| sum + product);
        }
    }
}
