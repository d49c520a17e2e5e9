//! Densities along a flow on a device: limited transport, forward and back, sub-step by sub-step (core/transport/limited).

use crate::kernels::{FLAGS, Kernel, Numbers};
use crate::machine::Machine;
use crate::memory::{Field, Part};
use crate::state::{Cell, STATES, State, most, rows_of, sum_of};
use thurible_core::exec::device::{NotFinite, Place};
use thurible_core::grid::solids::OUTSIDE;
use thurible_core::transport::KEEP;

/// Steps whose Courant numbers come back together at most.
const TOGETHER: usize = 512;
/// Keyframes whose data terms do.
const COMPARED: usize = 512;

impl State {
    /// Counts the sub-steps of every step.
    pub fn count_substeps(&mut self, machine: &mut Machine) -> Result<(), NotFinite> {
        let v = self.velocity();
        let [of_substep, bound] = self.facts.courant;
        let mut substeps = Vec::with_capacity(self.facts.room.slots + 1);
        let mut given = Some((self.courant(machine, self.flow(0)), 1));
        for (first, count) in v.windows(TOGETHER) {
            let range = self.courant(machine, v.part(first, count));
            let sums = machine.sums();
            for (range, rows) in given.take().into_iter().chain([(range, count)]) {
                for courant in rows_of(&sums, &range, rows).map(most) {
                    if !(courant <= bound) {
                        return Err(NotFinite);
                    }
                    substeps.push(((courant / of_substep).ceil() as usize).max(1));
                }
            }
        }
        if substeps.len() != self.facts.room.slots + 1 {
            return Err(NotFinite);
        }
        self.substeps = substeps;
        Ok(())
    }

    /// Stage `k` of a sub-step along the flow of `step`.
    fn stage(&self, machine: &mut Machine, step: usize, k: usize, out: Part, rho: Part, y: Part) {
        let numbers = Numbers {
            a: (1.0 / self.substeps[step] as f64) as f32,
            b: KEEP[k] as f32,
            c: self.facts.negligible as f32,
            ..self.numbers()
        };
        let rho = (k > 0).then_some(rho);
        let parts = [Some(out), None, None, rho, Some(y), Some(self.flow(step))];
        machine.run(Kernel::Carry, &parts, &numbers, self.count());
    }

    /// The stages a and b of the sub-step from `rho`, and where it leads if that is asked for.
    fn substep(&self, machine: &mut Machine, step: usize, rho: Part, out: Option<Part>) {
        let [a, b] = [Cell::A, Cell::B].map(|cell| self.cell(cell));
        self.stage(machine, step, 0, a, rho, rho);
        self.stage(machine, step, 1, b, rho, a);
        if let Some(out) = out {
            self.stage(machine, step, 2, out, rho, b);
        }
    }

    /// `count` sub-steps from `rho` to `out`, by way of two states that are overwritten.
    fn carry(&self, machine: &mut Machine, step: usize, count: usize, rho: Part, out: Part) {
        let ways = [self.kept(STATES - 2), self.kept(STATES - 1)];
        let mut from = rho;
        for substep in 1..=count {
            let to = if substep == count { out } else { ways[substep % 2] };
            self.substep(machine, step, from, Some(to));
            from = to;
        }
    }

    /// Carries the density through all steps; the data term of where it goes.
    pub fn carry_all(&self, machine: &mut Machine) -> f64 {
        for step in 0..=self.facts.room.slots {
            let count = self.substeps[step];
            self.carry(machine, step, count, self.density(step), self.density(step + 1));
            self.forget_outside(machine, self.density(step + 1));
            self.emit(machine, step + 1);
        }
        let all: Vec<usize> = (0..self.facts.keyframes.len()).collect();
        let terms = all.chunks(COMPARED).map(|indices| {
            let mut ranges = Vec::with_capacity(indices.len());
            for &index in indices {
                self.compare(machine, index);
                let [error, image] = [Cell::Error, Cell::Image].map(|cell| self.cell(cell));
                ranges.push(self.dot(machine, error, Some(image)));
            }
            let sums = machine.sums();
            let weight = |index: usize| 0.5 * self.facts.keyframes[index].1;
            let terms = indices.iter().zip(&ranges);
            terms
                .map(|(&index, range)| weight(index) * sum_of(&sums, range))
                .sum::<f64>()
        });
        terms.sum()
    }

    /// Adds to the density of a step what is emitted on the way there: first by rates, then up to targets (core/objective/script/emission.rs).
    fn emit(&self, machine: &mut Machine, step: usize) {
        let (rho, supplies) = (self.density(step), &self.facts.supplies[step]);
        for &(index, [added, _]) in supplies.iter().filter(|(_, [added, _])| *added > 0.0) {
            let shape = self.place(Place::Emitter(index));
            self.add(machine, rho, [1.0, added], Some(shape));
        }
        for &(index, [_, target]) in supplies.iter().filter(|(_, [_, target])| *target > 0.0) {
            let shape = [Some(self.place(Place::Emitter(index))), None];
            self.by_element(machine, Kernel::Fill, rho, shape, [target, 0.0]);
        }
    }

    /// A field of cells is 0 outside of open sides: smoke that has left the box in a step is gone.
    fn forget_outside(&self, machine: &mut Machine, field: Part) {
        if self.facts.room.solids {
            self.leave_out(machine, field, OUTSIDE, 1.0);
        }
    }

    /// mu = 0 where the density of a step was filled up.
    fn forget(&self, machine: &mut Machine, step: usize) {
        let filled = self.facts.supplies[step].iter();
        for &(index, [_, target]) in filled.filter(|(_, [_, target])| *target > 0.0) {
            let parts = [self.place(Place::Emitter(index)), self.density(step)].map(Some);
            self.by_element(machine, Kernel::Forget, self.cell(Cell::Mu), parts, [target, 0.0]);
        }
    }

    /// e = R (rho - rho*) of a keyframe, and C e.
    fn compare(&self, machine: &mut Machine, index: usize) {
        let (step, _) = self.facts.keyframes[index];
        let [error, image] = [Cell::Error, Cell::Image].map(|cell| self.cell(cell));
        self.add(machine, error, [0.0, 1.0], Some(self.density(step)));
        self.add(
            machine,
            error,
            [1.0, -1.0],
            Some(self.place(Place::Target(index))),
        );
        if self.facts.room.regions {
            self.multiply(machine, error, self.place(Place::Region(index)));
        }
        self.blur(machine, error, image);
    }

    /// Back through all steps: `out` = r `out` - A_v^T mu, slot by slot; with buoyancy mu has r B^T `z` too.
    pub fn go_back(&self, machine: &mut Machine, out: usize, z: &Field) {
        let (mu, image) = (self.cell(Cell::Mu), self.cell(Cell::Image));
        self.add(machine, mu, [0.0, 0.0], None);
        for step in (1..=self.facts.room.slots).rev() {
            let keyframes = self.facts.keyframes.iter();
            if let Some(index) = keyframes.clone().position(|(at, _)| *at == step + 1) {
                self.compare(machine, index);
                if self.facts.room.regions {
                    self.multiply(machine, image, self.place(Place::Region(index)));
                }
                let weight = self.facts.keyframes[index].1;
                self.add(machine, mu, [1.0, -weight], Some(image));
            }
            if step < self.facts.room.slots {
                self.lift_back(machine, z.step(step), mu);
            }
            self.forget(machine, step + 1);
            self.forget_outside(machine, mu);
            self.go_back_through(machine, step);
            let slot = self.fields[out].step(step - 1);
            let factors = [self.facts.force_weight, -1.0];
            self.add(machine, slot, factors, Some(self.gradient_of_step()));
        }
    }

    /// Back through the sub-steps of a step, in blocks of as many states as are kept, each of which is made again from the step's density.
    fn go_back_through(&self, machine: &mut Machine, step: usize) {
        let (substeps, rho) = (self.substeps[step], self.density(step));
        for first in (0..substeps).step_by(STATES).rev() {
            let count = STATES.min(substeps - first);
            if first > 0 {
                self.carry(machine, step, first, rho, self.kept(0));
            }
            let from = |state: usize| {
                if first + state == 0 { rho } else { self.kept(state) }
            };
            for state in 1..count {
                self.substep(machine, step, from(state - 1), Some(self.kept(state)));
            }
            for state in (0..count).rev() {
                self.substep(machine, step, from(state), None);
                self.substep_back(machine, step, from(state), first + state + 1 == substeps);
            }
        }
    }

    /// Back through the sub-step from `rho`, whose stages are there: mu, and the gradient, which begins with the `first`.
    fn substep_back(&self, machine: &mut Machine, step: usize, rho: Part, first: bool) {
        let cell = |which| self.cell(which);
        let [mu, a, b] = [cell(Cell::Mu), cell(Cell::A), cell(Cell::B)];
        let [of_b, of_a] = [cell(Cell::OfB), cell(Cell::OfA)];
        let [_, of_middle, of_last] = KEEP;
        let v = self.flow(step);
        let gradient = self.gradient_of_step();
        let mut back = |next: Option<Part>,
                        out: Option<Part>,
                        z: Part,
                        y: Part,
                        share: f64,
                        [keep, take]: [f64; 2],
                        clear| {
            let base = self.numbers();
            let does = u32::from(next.is_some()) | (u32::from(out.is_some()) << 1) | (u32::from(clear) << 2);
            let numbers = Numbers {
                a: (1.0 / self.substeps[step] as f64) as f32,
                b: keep as f32,
                c: take as f32,
                third: (share as f32).to_bits(),
                flags: base.flags | (does << FLAGS),
                ..base
            };
            let parts = [next, out, Some(gradient), Some(z), Some(y), Some(v)];
            machine.run(Kernel::CarryBack, &parts, &numbers, self.count());
        };
        back(Some(of_b), None, mu, b, 1.0 - of_last, [0.0, 0.0], first);
        back(
            Some(of_a),
            Some(mu),
            of_b,
            a,
            1.0 - of_middle,
            [of_last, of_middle],
            false,
        );
        back(None, Some(mu), of_a, rho, 1.0, [1.0, 1.0], false);
    }
}
