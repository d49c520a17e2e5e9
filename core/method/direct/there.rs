//! One grid of the search on a device, which has the fields.

use super::room::{Given, room_of};
use super::work::{Work, is_usable};
use crate::exec::Exec;
use crate::exec::device::{Device, NotFinite, Place, Search, Stride};
use crate::field::slot::Slot;
use crate::field::trajectory::Shape;
use crate::field::{Vector, VectorMut, rows, view};
use crate::force::price;
use crate::force::time_line::TimeLine;
use crate::grid::Grid;
use crate::grid::spectrum::eigenvector_of;
use crate::method::first_hessian::LEAST_OF_FLOWS;
use crate::objective::feasible::{CLEAN, DIRECTION_TOLERANCE};
use crate::objective::flow::Evaluation;
use crate::objective::sweep;
use crate::observe::Observer;
use crate::optimise::descent::{Descent, Function};
use crate::optimise::quasi_newton::history::Kept;
use crate::optimise::quasi_newton::recursion::{Borrowed, GradientProducts, Products, QuasiNewton};
use crate::progress::Objective;
use crate::real::Real;
use crate::transport::{MAX_SUBSTEPS, Stop, negligible};

/// Hands a flow `v` to a device, and all that an `evaluation` of it follows from; L-BFGS has so many `fields`, and begins with the `line`.
pub fn hand_over<T: Real>(
    device: &dyn Device,
    evaluation: &Evaluation<'_, '_, T>,
    v: Vector<'_, T>,
    line: TimeLine<'_>,
    fields: usize,
) {
    let Shape { grid, slots } = evaluation.shape();
    let (setup, script) = (&evaluation.setup, &evaluation.script);
    let sweep::Setup {
        metric,
        stepping,
        largest,
        ..
    } = setup.sweep;
    let spectrum = evaluation.levels.spectrum(evaluation.level);
    let (pivots, coupling) = line.numbers();
    let factor = |slot: usize| script.factor(slot);
    let squared = |axis: usize| grid.h[axis] * grid.h[axis];
    let wanted = |index: usize| script.wanted(index, grid.cells());
    let given = Given {
        keyframes: script.keyframes(),
        regions: (0..script.keyframes()).any(|index| !wanted(index).region.is_empty()),
        emitters: script.emitters(),
    };
    device.begin(&Search {
        room: room_of(grid, setup, fields, given),
        inverse: grid.h.map(|h| 1.0 / h),
        rings: core::array::from_fn(|axis| grid.axis(axis).is_ring()),
        inside: core::array::from_fn(|axis| grid.axis(axis).inside()),
        viscosity: setup.viscosity,
        force_weight: setup.force_weight,
        smoothing: setup.smoothing,
        factor: setup.scheduled.then_some(&factor),
        lengths: &|step| {
            (setup.smoothing > 0.0)
                .then(|| price::length(grid, setup.smoothing, step))
                .flatten()
        },
        least_of_mask: LEAST_OF_FLOWS,
        buoyancy: setup.buoyancy,
        supply: &|step, index| script.supply(step, index, grid.cells()),
        jet: &|slot, index| script.jet(slot, index, grid.cells()),
        pivots,
        coupling,
        courant: [stepping.courant(), MAX_SUBSTEPS as f64],
        negligible: stepping.tolerance * largest * negligible::<T>(),
        keyframe: &|index| {
            let step = script.steps().nth(index)?;
            Some((step, wanted(index).weight))
        },
        projection_tolerance: setup.projection_tolerance,
        identity: metric.identity,
        vector: &|[axis, k, i]| eigenvector_of(grid.axis(axis), k, i).0,
        eigenvalue: &|[axis, k]| eigenvector_of(grid.axis(axis), k, 0).1 / squared(axis),
        blur: &|[axis, j, k]| spectrum.axes[axis].blur(j)[k].to_f64(),
    });
    for step in 0..=slots {
        let slot = Slot::at(step, evaluation.initial, v, slots);
        for axis in 0..grid.dims {
            write(device, Place::Flow(step, axis), &|row| slot.row(grid, axis, row));
        }
    }
    let n = grid.n[0];
    let write_cells = |place: Place, field: &[T]| {
        write(device, place, &|row| rows::part(field, row * n..(row + 1) * n));
    };
    write_cells(Place::Density(0), rows::part(evaluation.rho, 0..grid.cells()));
    for index in 0..script.keyframes() {
        write_cells(Place::Target(index), wanted(index).target);
        if given.regions {
            write_cells(Place::Region(index), wanted(index).region);
        }
    }
    for index in 0..given.emitters {
        write_cells(Place::Emitter(index), script.shape(index, grid.cells()));
    }
    let solids = evaluation.levels.solids(evaluation.level);
    if solids.there() {
        device.write(Place::Solids, &mut |row, out| {
            for (out, bits) in out.iter_mut().zip(solids.row(n, row)) {
                *out = f32::from(*bits);
            }
        });
    }
    if setup.masked {
        write_cells(Place::Mask, script.mask(grid.cells()));
    }
}

fn write<'f, T: Real>(device: &dyn Device, place: Place, row_of: &dyn Fn(usize) -> &'f [T]) {
    device.write(place, &mut |row, out| {
        for (out, value) in out.iter_mut().zip(row_of(row)) {
            *out = value.to_f64() as f32;
        }
    });
}

/// The data of a grid here, and the device that works on it.
pub(super) struct There<'d, 'w, 'a, 'm, T> {
    device: &'d dyn Device,
    work: &'w mut Work<'a, 'm, T>,
}

impl<'d, 'w, 'a, 'm, T: Real> There<'d, 'w, 'a, 'm, T> {
    pub fn new(device: &'d dyn Device, work: &'w mut Work<'a, 'm, T>) -> Self {
        Self { device, work }
    }

    /// Hands the grid to the device, and what a descent has of it so far.
    pub fn begin(&self, descent: &Descent) {
        let Work {
            evaluation,
            v,
            fields,
            line,
        } = &*self.work;
        hand_over(self.device, evaluation, view(v), *line, fields.len());
        if descent.has_begun() {
            let Shape { grid, slots } = self.work.shape();
            for (which, field) in fields.iter().enumerate() {
                for slot in 0..slots {
                    let slot_of = Slot {
                        field: view(field),
                        slots,
                        slot,
                    };
                    for axis in 0..grid.dims {
                        let place = Place::Field(which, slot, axis);
                        write(self.device, place, &|row| slot_of.row(grid, axis, row));
                    }
                }
            }
        }
    }

    /// Takes the flow and its densities back.
    pub fn read_flow(&mut self) {
        let Shape { grid, slots } = self.work.shape();
        let Work { evaluation, v, .. } = &mut *self.work;
        read_slots(self.device, (grid, slots), v, &|slot, axis| {
            Place::Flow(slot + 1, axis)
        });
        let n = grid.n[0];
        for step in 1..slots + 2 {
            let rho = rows::part_mut(evaluation.rho, step * grid.cells()..(step + 1) * grid.cells());
            self.device.read(Place::Density(step), &mut |row, values| {
                put(rows::part_mut(rho, row * n..(row + 1) * n), values);
            });
        }
    }

    /// Takes the fields of L-BFGS back.
    pub fn read_fields(&mut self) {
        let Shape { grid, slots } = self.work.shape();
        for (which, field) in self.work.fields.iter_mut().enumerate() {
            read_slots(self.device, (grid, slots), field, &|slot, axis| {
                Place::Field(which, slot, axis)
            });
        }
    }
}

fn put<T: Real>(out: &mut [T], values: &[f32]) {
    for (out, value) in out.iter_mut().zip(values) {
        *out = T::from_f64(f64::from(*value));
    }
}

/// Reads a trajectory of faces, component by component in every slot.
fn read_slots<T: Real>(
    device: &dyn Device,
    (grid, slots): (&Grid, usize),
    out: &mut VectorMut<'_, T>,
    place: &dyn Fn(usize, usize) -> Place,
) {
    let n = grid.n[0];
    for slot in 0..slots {
        for (axis, out) in out.iter_mut().enumerate().take(grid.dims) {
            device.read(place(slot, axis), &mut |row, values| {
                let begin = (row * slots + slot) * n;
                put(rows::part_mut(out, begin..begin + n), values);
            });
        }
    }
}

/// What a verb ends with, unless the observer says stop.
fn heard<V>(observer: &mut dyn Observer, ended: Result<V, NotFinite>) -> Result<V, Stop> {
    Stop::heard(observer)?;
    ended.map_err(|NotFinite| Stop::TooFast)
}

impl<T: Real, S> Function<T, S> for There<'_, '_, '_, '_, T> {
    fn direction(
        &mut self,
        _: &dyn Exec,
        observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop> {
        let (combination, slope) = newton.combine();
        let of_gradient = (combination.preconditioned, newton.preconditioned);
        let of_pairs = combination.pairs.iter().flat_map(|(kept, factors)| match kept {
            Kept::Full(fields) => [(factors[0], fields[0]), (factors[1], fields[1])],
            // A device is not begun with pairs in halves.
            Kept::Halves(field) => [(0.0, *field); 2],
        });
        let mut terms = core::iter::once(of_gradient).chain(of_pairs);
        self.device.form(newton.direction, &mut terms);
        let mut left = self.device.divergence(newton.direction);
        if !(left[0] <= CLEAN) {
            self.device.project(newton.direction, DIRECTION_TOLERANCE);
            [left[0], _] = self.device.divergence(newton.direction);
        }
        Stop::heard(observer)?;
        Ok(if is_usable(left) { slope } else { f64::NAN })
    }

    fn move_along(&mut self, _: &dyn Exec, direction: usize, s: f64) {
        self.device.advance(direction, s);
    }

    fn retreat(&mut self, _: &dyn Exec, keep: f64) {
        self.device.retreat(keep);
    }

    fn value(
        &mut self,
        _: &dyn Exec,
        observer: &mut dyn Observer,
        force: usize,
        bound: f64,
    ) -> Result<Objective, Stop> {
        let [data, price, plain] = heard(observer, self.device.value(force))?;
        // The search of a step goes by what it is told here too.
        if data > bound {
            return Ok(Objective::of_data(data));
        }
        Ok(Objective {
            data,
            ..Objective::of_force(price, plain)
        })
    }

    fn gradient(
        &mut self,
        _: &dyn Exec,
        observer: &mut dyn Observer,
        force: usize,
        into: usize,
    ) -> Result<(), Stop> {
        heard(observer, self.device.gradient(force, into))
    }

    fn arrive(&mut self, _: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let mut products = GradientProducts::default();
        let stride = step.map(|length| Stride {
            length,
            direction: newton.direction,
            preconditioned: newton.preconditioned,
        });
        let mut pairs = newton.kept().map(|kept| match kept {
            Kept::Full(fields) => fields,
            Kept::Halves(field) => [field; 2],
        });
        let with = self.device.arrive(
            borrowed.gradient,
            borrowed.work,
            stride,
            &mut pairs,
            &mut |[s, z]| {
                let _ = products.pairs.push(Products { s, z });
            },
        );
        drop(pairs);
        products.norm = with.norm;
        products.step = Products {
            s: with.step[0],
            z: with.step[1],
        };
        newton.move_to(borrowed, step, &products);
    }
}
