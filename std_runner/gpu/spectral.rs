//! The projection and the metric on a device: transforms along every axis, and a product between them (`kernels/spectral.wgsl`).

use crate::kernels::{FLAGS, Kernel, Numbers};
use crate::machine::Machine;
use crate::memory::{Field, Part};
use crate::state::{Cell, State, largest_of, worse};

/// Windows of so many slots whose largest numbers come back together at most.
const MEASURED: usize = 128;

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
        parts: &[Part; 2],
        (kernel, numbers): (Kernel, Numbers),
        fields: usize,
    ) {
        let [mut now, mut next] = parts.clone();
        for axis in 0..self.facts.room.dims {
            self.transform(machine, [next.clone(), now.clone()], axis, false, fields);
            core::mem::swap(&mut now, &mut next);
        }
        let table = Some(self.table.step(0));
        let bound = [Some(now.clone()), None, table];
        machine.run(kernel, &bound, &numbers, fields * self.apart());
        for axis in (0..self.facts.room.dims).rev() {
            self.transform(machine, [next.clone(), now.clone()], axis, true, fields);
            core::mem::swap(&mut now, &mut next);
        }
    }

    /// `out` = C e, by way of a field of work.
    pub fn blur(&self, machine: &mut Machine, e: &Part, out: &Part) {
        self.add(machine, out.clone(), [0.0, 1.0], Some(e.clone()));
        let lines: usize = self.facts.room.cells.iter().take(self.facts.room.dims).sum();
        let numbers = Numbers {
            a: self.facts.identity as f32,
            first: (self.eigenvalues() + lines) as u32,
            second: self.facts.room.filters as u32,
            ..self.numbers()
        };
        if self.facts.room.filters == 0 {
            return self.add(machine, out.clone(), [self.facts.identity, 0.0], None);
        }
        let parts = [out.clone(), self.cell(Cell::Work)];
        self.multiply_coefficients(machine, &parts, (Kernel::FilterAll, numbers), 1);
    }

    /// div of `count` slots of a field from `first` on, in the potentials.
    fn divergence(&self, machine: &mut Machine, field: &Field, (first, count): (usize, usize)) {
        let numbers = Numbers {
            count: count as u32,
            ..self.numbers()
        };
        let parts = [
            Some(self.potentials[0].part(0, count)),
            Some(field.part(first, count)),
        ];
        machine.run(Kernel::Divergence, &parts, &numbers, count * self.apart());
    }

    /// Projects all slots of a field.
    pub fn project(&self, machine: &mut Machine, field: &Field) {
        let d = self.facts.room.dims;
        for (first, count) in field.windows(self.potentials[0].steps()) {
            let numbers = Numbers {
                count: count as u32,
                ..self.numbers()
            };
            self.divergence(machine, field, (first, count));
            let parts = self.potentials.each_ref().map(|field| field.part(0, count));
            let invert = Numbers {
                first: self.eigenvalues() as u32,
                ..numbers
            };
            self.multiply_coefficients(machine, &parts, (Kernel::Invert, invert), count);
            let [potentials, _] = parts;
            let bound = [Some(field.part(first, count)), Some(potentials)];
            machine.run(
                Kernel::SubtractGradient,
                &bound,
                &numbers,
                count * d * self.apart(),
            );
        }
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
                    self.largest(machine, self.potentials[0].part(0, count)),
                    self.largest(machine, field.part(first, count)),
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
