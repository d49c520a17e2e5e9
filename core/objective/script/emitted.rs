//! What a covector of the density or of the flow is for the emitters: their rates and targets, the velocities of their smoke, their shapes.
//!
//! With mu the covector of rho_{i+1}, what was added by a rate a gets <mu, E> for a and a mu for E, where no target has filled up what was
//! there; where a target t has, it gets mu E for t and t mu for E. Where several have, the first does.
//!
//! A face that is pushed has x <- (1 - e) x + e (V - v) for one emitter after the other, from x = 0, with e = min(1, E_low, E_high): see
//! [`jets`](super::jets). So with z the covector of the acceleration, P the product of 1 - e of those after it and x what those before it did,
//! V gets e P z, and e gets (V - v - x) P z, which goes to the cell that e is of: to none where both are above 1. Where two of the three are equal a cell gets
//! half, the mean of both sides of that kink.

use super::Script;
use super::jets::Jets;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::Vector;
use crate::field::rows::part_mut;
use crate::grid::solids::closed;
use crate::grid::{Grid, Side};
use crate::real::Real;
use core::cmp::Ordering;

/// Numbers of an emitter: its rate or target, and its velocity.
pub const NUMBERS: usize = 4;

/// What emitters get, added up.
pub struct OfEmitters<'a, T> {
    /// [`NUMBERS`] of each emitter.
    pub numbers: &'a mut [f64],
    /// A field of cells for the shape of each.
    pub shapes: &'a mut [T],
    /// Sums over rows, three for each.
    pub sums: &'a mut [f64],
}

impl<T> OfEmitters<'_, T> {
    /// The field of emitter `index`, and as many sums as there are rows, `each` times.
    fn of(&mut self, index: usize, grid: &Grid, each: usize) -> (&mut [T], &mut [f64]) {
        let cells = grid.cells();
        (
            part_mut(self.shapes, index * cells..(index + 1) * cells),
            part_mut(self.sums, 0..each * grid.rows()),
        )
    }

    /// Adds the sums of all rows to numbers of emitter `index`, from number `first` on.
    fn take(&mut self, index: usize, grid: &Grid, first: usize, each: usize) {
        let sums = part_mut(self.sums, 0..each * grid.rows());
        let numbers = self.numbers.iter_mut().skip(index * NUMBERS + first).take(each);
        for (which, number) in numbers.enumerate() {
            *number += sums.iter().skip(which).step_by(each).sum::<f64>();
        }
    }
}

impl<'a, T: Real> Script<'a, T> {
    /// What the covector `mu` of the density `rho` of `step` is for those that fill up to targets, or for those with rates, of which mu is
    /// after [`Self::forget`].
    pub fn add_to_emitters(
        &self,
        exec: &dyn Exec,
        grid: &Grid,
        step: usize,
        [rho, mu]: [&[T]; 2],
        targets: bool,
        out: &mut OfEmitters<'_, T>,
    ) {
        let (n, all) = (grid.n[0], self.supplies(step, grid.cells()));
        let chosen = all.clone().filter(|supply| (supply.target > 0.0) == targets);
        for supply in chosen.clone() {
            let (shapes, sums) = out.of(supply.index, grid, 1);
            let by_rate = f64::from(self.stride.get());
            for_rows(
                exec,
                grid.rows(),
                RowBuffers::fields([shapes]).with_sums(sums),
                |task| {
                    let ([shapes], first) = (task.fields, task.row * n);
                    let mut sum = 0.0;
                    for (x, gradient) in shapes.iter_mut().enumerate() {
                        let at = |field: &[T]| field.get(first + x).map_or(0.0, |value| value.to_f64());
                        let (covector, inside) = (at(mu), at(supply.shape));
                        if targets {
                            let here = rho.get(first + x).copied().unwrap_or(T::ZERO);
                            let fills = |target: f64, shape: &[T]| {
                                let shape = shape.get(first + x).copied().unwrap_or(T::ZERO);
                                shape > T::ZERO && here <= T::from_f64(target) * shape
                            };
                            let before = || chosen.clone().take_while(|other| other.index < supply.index);
                            if fills(supply.target, supply.shape)
                                && !before().any(|other| fills(other.target, other.shape))
                            {
                                *gradient += T::from_f64(supply.target * covector);
                                sum += covector * inside;
                            }
                        } else {
                            *gradient += T::from_f64(supply.added * covector);
                            sum += by_rate * covector * inside;
                        }
                    }
                    task.sums.iter_mut().for_each(|of_row| *of_row = sum);
                },
            );
            out.take(supply.index, grid, 0, 1);
        }
    }
}

/// What an emitter does to a face where the covector is 1: what e and V get, and what part of e's both of its cells do.
struct Pushed {
    by_part: f64,
    by_velocity: f64,
    shares: [f64; 2],
}

/// The derivative of min(1, `own`, `other`) by `own`; the mean of both sides where they differ, which central differences give too.
fn share(own: f64, other: f64) -> f64 {
    match own.partial_cmp(&other.min(1.0)) {
        Some(Ordering::Less) => 1.0,
        Some(Ordering::Equal) => 0.5,
        _ => 0.0,
    }
}

impl<T: Real> Jets<'_, T> {
    /// The cells on both sides of the low face of cell `x` of a row, where it is open.
    fn cells_at(&self, axis: usize, row: usize, x: usize) -> Option<[usize; 2]> {
        let (grid, n) = (self.grid, self.grid.n[0]);
        let low = match axis {
            0 => row * n + x.checked_sub(1).or(grid.axis(0).is_ring().then_some(n - 1))?,
            _ => grid.neighbour(row, axis, Side::Low)? * n + x,
        };
        let bits = self.solids.row(n, row);
        let open = bits.get(x).is_none_or(|bits| bits & closed(axis) == 0);
        open.then_some([low, row * n + x])
    }

    /// The face above cell `x` of a row: its own row and place.
    fn face_above(&self, axis: usize, row: usize, x: usize) -> Option<[usize; 2]> {
        let (grid, n) = (self.grid, self.grid.n[0]);
        match axis {
            0 if x + 1 < n => Some([row, x + 1]),
            0 => grid.axis(0).is_ring().then_some([row, 0]),
            _ => Some([grid.neighbour(row, axis, Side::High)?, x]),
        }
    }

    /// What emitter `index` does to a face between two cells, where v_slot is `v`.
    fn pushed(&self, slot: usize, index: usize, cells: [usize; 2], axis: usize, v: f64) -> Pushed {
        let (mut x, mut pushed) = (
            0.0,
            Pushed {
                by_part: 0.0,
                by_velocity: 0.0,
                shares: [0.0; 2],
            },
        );
        for (other, shape, along) in self.script.jets(slot, self.grid.cells()) {
            let [low, high] = cells.map(|cell| shape.get(cell).map_or(0.0, |x| x.to_f64()));
            let e = 1.0_f64.min(low).min(high);
            let goes = along.get(axis).copied().unwrap_or(0.0) - v;
            if other == index {
                pushed = Pushed {
                    by_part: goes - x,
                    by_velocity: e,
                    shares: [share(low, high), share(high, low)],
                };
            } else {
                pushed.by_part *= 1.0 - e;
                pushed.by_velocity *= 1.0 - e;
            }
            x = (1.0 - e) * x + e * goes;
        }
        pushed
    }

    /// What the covector `z` of the acceleration of v_slot = `v` is for the emitters that push it.
    pub fn add_to_emitters(
        &self,
        exec: &dyn Exec,
        slot: usize,
        [z, v]: [Vector<'_, T>; 2],
        out: &mut OfEmitters<'_, T>,
    ) {
        let (grid, n) = (self.grid, self.grid.n[0]);
        let at = |field: Vector<'_, T>, axis: usize, face: usize| {
            let component = field.get(axis).copied().unwrap_or_default();
            component.get(face).map_or(0.0, |value| value.to_f64())
        };
        for (index, _, _) in self.script.jets(slot, grid.cells()) {
            let (shapes, sums) = out.of(index, grid, 3);
            for_rows(
                exec,
                grid.rows(),
                RowBuffers::fields([shapes]).with_sums(sums),
                |task| {
                    let [shapes] = task.fields;
                    task.sums.fill(0.0);
                    for (x, gradient) in shapes.iter_mut().enumerate() {
                        for axis in 0..grid.dims {
                            // `own` is the place of this cell among the two of the face.
                            let mut face = |row: usize, place: usize, own: usize| {
                                let Some(cells) = self.cells_at(axis, row, place) else {
                                    return 0.0;
                                };
                                let (z, v) = (at(z, axis, row * n + place), at(v, axis, row * n + place));
                                let pushed = self.pushed(slot, index, cells, axis, v);
                                let share = pushed.shares.get(own).copied().unwrap_or(0.0);
                                if share > 0.0 {
                                    *gradient += T::from_f64(z * pushed.by_part * share);
                                }
                                z * pushed.by_velocity
                            };
                            let of_low = face(task.row, x, 1);
                            if let Some(sum) = task.sums.get_mut(axis) {
                                *sum += of_low;
                            }
                            if let Some([row, place]) = self.face_above(axis, task.row, x) {
                                face(row, place, 0);
                            }
                        }
                    }
                },
            );
            out.take(index, grid, 1, 3);
        }
    }
}
