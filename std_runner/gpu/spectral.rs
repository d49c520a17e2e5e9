//! The projection and the metric on a device: transforms along every axis, and a product between them (`kernels/spectral.wgsl`).

use crate::kernels::{FLAGS, Kernel, Numbers};
use crate::machine::Machine;
use crate::memory::{Field, Part};
use crate::state::{Cell, State, gaussians, largest_of, most, rows_of, total, worse};
use thurible_core::grid::solids::SOLID;

/// Windows of so many slots whose largest numbers come back together at most.
const MEASURED: usize = 128;

/// Corrections of a projection among solid cells at most, and steps of conjugate gradients in each: as in core/poisson.
const CORRECTIONS: usize = 4;
const STEPS: usize = 60;
/// Rows and columns of a transform that a group makes: `SIDE` in `kernels/spectral.wgsl`.
const SIDE: usize = 64;

impl State {
    /// Where the matrix of an axis begins in the table.
    fn matrix(&self, axis: usize) -> usize {
        self.facts.room.cells.iter().take(axis).map(|n| n * n).sum()
    }

    /// Where the eigenvalues do.
    fn eigenvalues(&self) -> usize {
        self.matrix(self.facts.room.dims)
    }

    /// One field of cells after the other, along an axis times its matrix or its transpose.
    fn transform(
        &self,
        machine: &mut Machine,
        [out, from]: [Part; 2],
        axis: usize,
        back: bool,
        fields: usize,
    ) {
        let base = self.numbers();
        let numbers = Numbers {
            axis: axis as u32,
            first: self.matrix(axis) as u32,
            count: fields as u32,
            flags: base.flags | (u32::from(back) << FLAGS),
            ..base
        };
        let parts = [Some(out), Some(from), Some(self.table.step(0))];
        // Lines along y lie in planes of z.
        let n = self.facts.room.cells;
        let (lines, planes) = match axis {
            0 => (n[1] * n[2], 1),
            1 => (n[0], n[2]),
            _ => (n[0] * n[1], 1),
        };
        let tiles = n[axis].div_ceil(SIDE) * lines.div_ceil(SIDE) * planes * fields;
        machine.run_groups(Kernel::Transform, &parts, &numbers, tiles as u64);
    }

    /// `fields` fields in `parts[0]` become what `kernel` makes of their coefficients, by way of `parts[1]`.
    fn multiply_coefficients(
        &self,
        machine: &mut Machine,
        parts: [Part; 2],
        (kernel, numbers): (Kernel, Numbers),
        fields: usize,
    ) {
        let [mut now, mut next] = parts;
        for axis in 0..self.facts.room.dims {
            self.transform(machine, [next, now], axis, false, fields);
            core::mem::swap(&mut now, &mut next);
        }
        let table = Some(self.table.step(0));
        let bound = [Some(now), None, table];
        machine.run(kernel, &bound, &numbers, fields * self.apart());
        for axis in (0..self.facts.room.dims).rev() {
            self.transform(machine, [next, now], axis, true, fields);
            core::mem::swap(&mut now, &mut next);
        }
    }

    /// Where those of the filters do, or their taps.
    fn filters(&self) -> usize {
        let cells = self.facts.room.cells.iter().take(self.facts.room.dims);
        self.eigenvalues() + cells.sum::<usize>()
    }

    /// `out` = C e, by way of fields of work.
    pub fn blur(&self, machine: &mut Machine, e: Part, out: Part) {
        self.add(machine, out, [0.0, 1.0], Some(e));
        if self.facts.room.solids {
            return self.blur_among_solids(machine, e, out);
        }
        if self.facts.room.filters == 0 {
            return self.add(machine, out, [self.facts.identity, 0.0], None);
        }
        let numbers = Numbers {
            a: self.facts.identity as f32,
            first: self.filters() as u32,
            second: self.facts.room.filters as u32,
            ..self.numbers()
        };
        let parts = [out, self.cell(Cell::Work)];
        self.multiply_coefficients(machine, parts, (Kernel::FilterAll, numbers), 1);
    }

    /// `out`, which is e, becomes C e = identity F e + the sum over j of F G_j F G_j F e, F leaving solid cells out (core/operators/blur.rs).
    fn blur_among_solids(&self, machine: &mut Machine, e: Part, out: Part) {
        self.leave_out(machine, out, SOLID, self.facts.identity);
        let mut taps = self.filters();
        let [mut now, mut next] = [Cell::A, Cell::B].map(|cell| self.cell(cell));
        for gaussian in gaussians(&self.facts.room) {
            self.add(machine, now, [0.0, 1.0], Some(e));
            for _ in 0..2 {
                self.leave_out(machine, now, SOLID, 1.0);
                for axis in 0..self.facts.room.dims {
                    let numbers = Numbers {
                        axis: axis as u32,
                        first: taps as u32,
                        second: gaussian.radius as u32,
                        third: self.facts.inside[axis].start as u32,
                        count: self.facts.inside[axis].len() as u32,
                        ..self.numbers()
                    };
                    let parts = [Some(next), Some(now), Some(self.table.step(0))];
                    machine.run(Kernel::Gaussian, &parts, &numbers, self.count());
                    core::mem::swap(&mut now, &mut next);
                }
            }
            self.leave_out(machine, now, SOLID, 1.0);
            self.add(machine, out, [1.0, 1.0], Some(now));
            taps += gaussian.radius + 1;
        }
    }

    /// div of `count` slots of a field from `first` on, in the potentials.
    fn divergence(&self, machine: &mut Machine, field: &Field, (first, count): (usize, usize)) {
        let parts = [
            Some(self.potentials[0].part(0, count)),
            Some(field.part(first, count)),
        ];
        self.of_steps(machine, Kernel::Divergence, &parts, (count, self.apart()));
    }

    /// Projects all slots of a field, once; among solid cells and with open sides until at most this part of its divergence is left.
    pub fn project(&self, machine: &mut Machine, field: &Field, tolerance: f64) {
        for window in field.windows(self.potentials[0].steps()) {
            if self.facts.room.solids {
                self.project_among_solids(machine, field, window, tolerance);
            } else {
                self.divergence(machine, field, window);
                self.solve_in_box(machine, &self.potentials[0], window.1);
                self.subtract_gradient(machine, field, window);
            }
        }
    }

    /// Fields q with div grad q = what is in `count` of them, in the box without solid cells.
    fn solve_in_box(&self, machine: &mut Machine, fields: &Field, count: usize) {
        let invert = Numbers {
            first: self.eigenvalues() as u32,
            count: count as u32,
            ..self.numbers()
        };
        let parts = [fields, &self.potentials[1]].map(|field| field.part(0, count));
        self.multiply_coefficients(machine, parts, (Kernel::Invert, invert), count);
    }

    /// The potentials' gradient off `count` slots of a field from `first` on.
    fn subtract_gradient(&self, machine: &mut Machine, field: &Field, (first, count): (usize, usize)) {
        let bound = [
            Some(field.part(first, count)),
            Some(self.potentials[0].part(0, count)),
        ];
        self.of_steps(
            machine,
            Kernel::SubtractGradient,
            &bound,
            (count, field.numbers()),
        );
    }

    /// A kernel over `count` steps of so many numbers.
    fn of_steps(
        &self,
        machine: &mut Machine,
        kernel: Kernel,
        parts: &[Option<Part>],
        (count, numbers): (usize, usize),
    ) {
        let told = Numbers {
            count: count as u32,
            ..self.numbers()
        };
        machine.run(kernel, parts, &told, count * numbers);
    }

    /// As core/poisson: defect corrections, each of which starts from the divergence that is left.
    fn project_among_solids(
        &self,
        machine: &mut Machine,
        field: &Field,
        (first, count): (usize, usize),
        tolerance: f64,
    ) {
        let part = field.part(first, count);
        let close = |machine: &mut Machine| {
            let size = (count, field.numbers());
            self.of_steps(machine, Kernel::Close, &[Some(part)], size);
        };
        close(machine);
        let mut goal = None;
        for _ in 0..CORRECTIONS {
            self.divergence(machine, field, (first, count));
            let ranges = [
                self.largest(machine, self.potentials[0].part(0, count), 1),
                self.largest(machine, part, 1),
            ];
            let sums = machine.sums();
            let [divergence, speed] = ranges.map(|range| largest_of(&sums, &range));
            let rounding = 4.0 * f64::from(f32::EPSILON) * speed * self.facts.inverse[0];
            let goal = *goal.get_or_insert((tolerance * divergence).max(rounding));
            if !(divergence > goal) {
                return;
            }
            if self.facts.room.obstacles {
                self.solve_among_solids(machine, count, 0.5 * goal);
            } else {
                self.solve_in_box(machine, &self.potentials[0], count);
            }
            self.subtract_gradient(machine, field, (first, count));
            close(machine);
        }
    }

    /// Conjugate gradients, preconditioned by the box's own solve (core/poisson/conjugate.rs), in all slots of a batch together: the potentials
    /// q with div grad q = what they were through open faces, until no residual is above `goal`.
    fn solve_among_solids(&self, machine: &mut Machine, count: usize, goal: f64) {
        let [residual, mut direction, mut image] = self.conjugate.each_ref();
        let (q, all) = (self.potentials[0].part(0, count), |field: &Field| {
            field.part(0, count)
        });
        self.add(machine, all(residual), [0.0, -1.0], Some(q));
        self.add(machine, q, [0.0, 0.0], None);
        let precondition = |machine: &mut Machine, out: &Field| {
            self.add(machine, all(out), [0.0, 1.0], Some(all(residual)));
            self.solve_in_box(machine, out, count);
            self.leave_out(machine, all(out), SOLID, -1.0);
        };
        // <residual, x> and max |residual| of each slot.
        let measure = |machine: &mut Machine, x: &Field| {
            let slopes = self.dot_rows(machine, all(residual), Some(all(x)), count);
            let sizes = self.largest(machine, all(residual), count);
            let sums = machine.sums();
            let slopes = rows_of(&sums, &slopes, count).map(total);
            let sizes = rows_of(&sums, &sizes, count).map(most);
            slopes.zip(sizes).collect::<Vec<_>>()
        };
        let goes_on = |&(slope, size): &(f64, f64)| slope > 0.0 && size > goal;
        precondition(machine, direction);
        let mut now = measure(machine, direction);
        for _ in 0..STEPS {
            if !now.iter().any(goes_on) {
                return;
            }
            let bound = [Some(all(image)), Some(all(direction))];
            self.of_steps(machine, Kernel::ThroughOpen, &bound, (count, self.apart()));
            // What passes exits ends outside, where there is no equation.
            self.leave_out(machine, all(image), SOLID, 1.0);
            let curvatures = self.dot_rows(machine, all(direction), Some(all(image)), count);
            let sums = machine.sums();
            let curvatures = rows_of(&sums, &curvatures, count).map(total);
            let share = |now: &(f64, f64), share: f64| if goes_on(now) { share } else { 0.0 };
            let lengths = now.iter().zip(curvatures);
            self.tell_factors(machine, lengths.map(|(now, of)| share(now, now.0 / of)));
            self.add_each(machine, q, 1.0, all(direction));
            self.add_each(machine, all(residual), -1.0, all(image));
            precondition(machine, image);
            let next = measure(machine, image);
            let both = now.iter().zip(&next);
            self.tell_factors(machine, both.map(|(now, next)| share(now, next.0 / now.0)));
            self.add_each(machine, all(image), 1.0, all(direction));
            core::mem::swap(&mut direction, &mut image);
            now = next;
        }
    }

    /// Fields of cells, one after the other, times a number, and 0 in cells that have any of the `bits`.
    pub fn leave_out(&self, machine: &mut Machine, fields: Part, bits: u16, a: f64) {
        let count = (fields.bytes / 4) as usize;
        let numbers = Numbers {
            a: a as f32,
            second: bits.into(),
            count: (count / self.apart()) as u32,
            ..self.numbers()
        };
        machine.run(Kernel::LeaveOut, &[Some(fields)], &numbers, count);
    }

    /// Writes a factor for each slot of a batch.
    fn tell_factors(&self, machine: &mut Machine, factors: impl Iterator<Item = f64>) {
        let mut factors: Vec<f32> = factors.map(|factor| factor as f32).collect();
        machine.write(self.factors.step(0), 1, &mut factors, &mut |_, _| {});
    }

    /// to += b f x in every slot, f being its factor.
    fn add_each(&self, machine: &mut Machine, to: Part, b: f64, x: Part) {
        let parts = [x, self.factors.step(0)].map(Some);
        self.by_element(machine, Kernel::AddEach, to, parts, [1.0, b]);
    }

    /// max |div| of a field, and max |x|; 1e30 where that is not finite.
    pub fn measure(&self, machine: &mut Machine, field: &Field) -> [f64; 2] {
        let windows: Vec<_> = field.windows(self.potentials[0].steps()).collect();
        let mut found = [0.0, 0.0];
        for windows in windows.chunks(MEASURED) {
            let mut ranges = Vec::with_capacity(windows.len());
            for &(first, count) in windows {
                self.divergence(machine, field, (first, count));
                ranges.push([
                    self.largest(machine, self.potentials[0].part(0, count), 1),
                    self.largest(machine, field.part(first, count), 1),
                ]);
            }
            let sums = machine.sums();
            for ranges in &ranges {
                for (most, range) in found.iter_mut().zip(ranges) {
                    *most = worse(*most, largest_of(&sums, range));
                }
            }
        }
        found
    }
}
