//! The objective of a search as a script: forces from unknowns, data terms, and the gradient by all unknowns.
//!
//! ```text
//! J = 1/2 sum over keyframes of <e, C e>  +  r/2 sum_k |f_k|^2  +  r_v/2 |z_v/N|^2,   e = rho_k - rho*_k
//! ```

use super::cells::Cells;
use super::flow::Seen;
use super::given::{Given, shape};
use super::march::Script;
use super::params::Control;
use crate::exec::{Capped, Exec};
use crate::field::turned::Turned;
use crate::field::{Vector, VectorMut, rows, sums};
use crate::grid::Grid;
use crate::grid::solids::Solids;
use crate::operators::blur::add_by_rows;
use crate::progress::Objective;
use crate::real::Real;

/// Fields that a script works in.
#[derive(Debug)]
pub struct Work<'a, T> {
    /// Two fields of the metric.
    pub metric: [&'a mut [T]; 2],
    /// Rows and taps of blurs.
    pub taps: &'a mut [T],
    /// Factors of templates.
    pub factors: &'a mut [f64],
}

/// A search's script at some unknowns.
pub struct Pricing<'a, T> {
    /// What it follows from.
    pub given: Given<'a, T>,
    /// Where it works.
    pub work: Work<'a, T>,
    /// The unknowns.
    pub z: &'a [T],
    /// The gradient by them, where one is asked for.
    pub out: &'a mut [T],
    /// What was seen of the objective.
    pub objective: Objective,
    /// Whether forces are paid for now: once, going forward.
    pub pays: bool,
}

impl<T: Real> Pricing<'_, T> {
    /// Adds the price of the velocity at the start.
    pub fn pay_initial(&mut self) {
        let (unknowns, [_, price]) = (&self.given.unknowns, self.given.prices);
        let unit = unknowns.of_velocity();
        for axis in 0..3 {
            let z = self.z.get(unknowns.initial(axis)).unwrap_or_default();
            self.objective.initial += 0.5 * price * unit * unit * rows::sum_squares(z);
        }
    }

    /// What the velocity at the start is for the gradient: `adjoint` is that of v_0, padded.
    pub fn take_initial(&mut self, cells: &Cells, adjoint: Vector<'_, T>) {
        let (unknowns, [_, price]) = (self.given.unknowns, self.given.prices);
        let unit = unknowns.of_velocity();
        for (axis, adjoint) in adjoint.iter().enumerate().take(cells.dims) {
            let span = unknowns.initial(axis);
            let (Some(out), Some(z)) = (self.out.get_mut(span.clone()), self.z.get(span)) else {
                continue;
            };
            if out.is_empty() {
                continue;
            }
            cells.pack(adjoint, out);
            rows::scale_in_place(out, T::from_f64(unit));
            rows::add_scaled(out, T::from_f64(price * unit * unit), z);
        }
    }

    /// e in the first field of the metric and C e in the second.
    fn error(&mut self, exec: &dyn Exec, index: usize, seen: &mut Seen<'_, T>) {
        let (cells, given) = (seen.cells, &self.given);
        let count = cells.count();
        let [e, image] = self
            .work
            .metric
            .each_mut()
            .map(|field| field.get_mut(..count).unwrap_or_default());
        cells.pack(seen.rho, e);
        let begin = index * given.pitch;
        rows::sub(e, given.keyframes.get(begin..begin + count).unwrap_or_default());
        image.copy_from_slice(e);
        let (one, other) = seen.work.split_at_mut(seen.work.len() / 2);
        let work = [one, other].map(|field| field.get_mut(..count).unwrap_or_default());
        let (capped, grid) = (Capped::new(exec, given.threads), cells.grid());
        add_by_rows(
            &capped,
            (&grid, Solids::default()),
            given.filters,
            e,
            image,
            work,
            (&mut Turned::default(), self.work.taps),
        );
    }
}

impl<T: Real> Script<T> for Pricing<'_, T> {
    fn force(
        &mut self,
        exec: &dyn Exec,
        (cells, grid): (&Cells, &Grid),
        step: usize,
        force: &mut VectorMut<'_, T>,
        sums: &mut [f64],
    ) {
        if !self.given.has_force() {
            return;
        }
        self.given
            .force(exec, (cells, grid), self.z, step, self.work.factors, force);
        if self.pays {
            let n = cells.n[0];
            let squares = sums::total(exec, grid, sums, |row| {
                let of = |field: &&mut [T]| field.get(row * n..(row + 1) * n).map_or(0.0, rows::sum_squares);
                force.iter().map(of).sum()
            });
            self.objective.force += 0.5 * self.given.prices[0] * squares;
        }
    }

    fn see(&mut self, exec: &dyn Exec, step: usize, mut seen: Seen<'_, T>) {
        let Some(index) = self.given.keyframe(step) else {
            return;
        };
        self.error(exec, index, &mut seen);
        let (n, grid) = (seen.cells.n[0], seen.cells.grid());
        let [e, image] = self.work.metric.each_ref().map(|field| &**field);
        let product = sums::total(exec, &grid, seen.sums, |row| {
            let [e, image] = [e, image].map(|field| rows::part(field, row * n..(row + 1) * n));
            rows::dot(e, image)
        });
        self.objective.data += 0.5 * self.given.weight(index) * product;
    }

    fn add_adjoint(&mut self, exec: &dyn Exec, step: usize, mut seen: Seen<'_, T>) {
        let Some(index) = self.given.keyframe(step) else {
            return;
        };
        self.error(exec, index, &mut seen);
        let (n, weight) = (seen.cells.n[0], T::from_f64(self.given.weight(index)));
        let image = &*self.work.metric[1];
        seen.cells.for_rows(exec, [seen.rho_adjoint], |row, [adjoint]| {
            rows::add_scaled(adjoint, weight, rows::part(image, row * n..(row + 1) * n));
        });
    }

    fn looks_at(&self, step: usize) -> bool {
        self.given.keyframe(step).is_some()
    }

    fn take_gradient(
        &mut self,
        exec: &dyn Exec,
        (cells, grid): (&Cells, &Grid),
        step: usize,
        [adjoint, force]: [Vector<'_, T>; 2],
        sums: &mut [f64],
    ) {
        let given = self.given;
        let (unknowns, [price, _]) = (given.unknowns, given.prices);
        let unit = unknowns.of_force();
        for (axis, (adjoint, force)) in adjoint.iter().zip(force).enumerate().take(cells.dims) {
            let Some(out) = self
                .out
                .get_mut(unknowns.force(step, axis))
                .filter(|out| !out.is_empty())
            else {
                continue;
            };
            cells.pack(adjoint, out);
            rows::scale_in_place(out, T::from_f64(unit));
            rows::add_scaled(
                out,
                T::from_f64(price * unit),
                rows::part(force, 0..cells.count()),
            );
        }
        if !unknowns.controls.has(Control::Templates) {
            return;
        }
        let covector = |row: usize, x: usize| {
            let (padded, plain) = (cells.row(row).start + x, row * cells.n[0] + x);
            core::array::from_fn(|axis| {
                let at = |field: &[T], place: usize| field.get(place).map_or(0.0, |value| value.to_f64());
                at(adjoint[axis], padded) + price * at(force[axis], plain)
            })
        };
        for placed in unknowns.placed(given.templates) {
            let Some(interval) = placed.interval(step) else {
                continue;
            };
            let now = shape(cells, &placed, self.z, interval, self.work.factors);
            let sums = now.adjoint(exec, grid, placed.moves(), covector, sums);
            let (numbers, amplitudes) = (placed.numbers(), placed.amplitudes());
            let [a, b, c, along @ .., radius] = sums;
            let of_place = along.into_iter().take(cells.dims).chain([radius]);
            let of_place = (amplitudes..)
                .zip(of_place)
                .take(if placed.moves() { cells.dims + 1 } else { 0 });
            let of_amplitude = (interval * numbers..).zip([a, b, c]).take(numbers);
            for (which, sum) in of_amplitude.chain(of_place) {
                if let Some(out) = self.out.get_mut(placed.first + which) {
                    *out += T::from_f64(sum * placed.slope(which));
                }
            }
        }
    }
}
