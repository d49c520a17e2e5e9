//! The verbs of the direct method on a device.

use crate::kernels::{FLAGS, Kernel, Numbers};
use crate::machine::Machine;
use crate::memory::{Field, Part};
use crate::state::State;
use thurible_core::exec::device::{NotFinite, Place, Stride, WithGradient};
use thurible_core::force::mask::LEAST;

/// Passes of a projection at most: after two of them what is left is rounding.
const PASSES: usize = 2;
/// One pass is enough where max |div| h / max |x| is below this afterwards.
const CLEAN: f64 = 1e-5;
/// What is not finite comes back as 1e30.
const FINITE: f64 = 1e29;
/// The largest number of a gradient whose squares can be summed in `f32`.
const SUMMABLE: f64 = 1e15;

impl State {
    /// w = v_k - v_{k-1} + Adv(v_k) + nu C^T C v_k, slot by slot.
    fn accelerate(&self, machine: &mut Machine, w: &Field) {
        let numbers = Numbers {
            a: self.facts.viscosity as f32,
            ..self.numbers()
        };
        for slot in 0..self.facts.room.slots {
            let parts = [
                Some(w.step(slot)),
                Some(self.flow(slot + 1)),
                Some(self.flow(slot)),
                None,
            ];
            machine.run(Kernel::Force, &parts, &numbers, w.numbers());
            self.lift(machine, slot, w.step(slot));
            self.push(machine, slot, (self.flow(slot), 1.0), w.step(slot));
        }
    }

    /// The numbers of a kernel that is told what there is along each axis.
    fn along_axes(&self, [a, b, c]: [f64; 3]) -> Numbers {
        Numbers {
            a: a as f32,
            b: b as f32,
            c: c as f32,
            ..self.numbers()
        }
    }

    /// w -= B rho of a slot (core/force/lift.rs).
    fn lift(&self, machine: &mut Machine, slot: usize, w: Part) {
        if self.facts.buoyancy == [0.0; 3] {
            return;
        }
        let numbers = self.along_axes(self.facts.buoyancy.map(|b| -0.5 * b));
        let parts = [Some(w), Some(self.density(slot + 1)), None, None];
        machine.run(Kernel::Lift, &parts, &numbers, self.faces());
    }

    /// mu += r B^T z of a slot.
    pub fn lift_back(&self, machine: &mut Machine, z: Part, mu: Part) {
        if self.facts.buoyancy == [0.0; 3] {
            return;
        }
        let half = 0.5 * self.facts.force_weight;
        let numbers = self.along_axes(self.facts.buoyancy.map(|b| half * b));
        let parts = [Some(mu), Some(z), None, None];
        machine.run(Kernel::LiftBack, &parts, &numbers, self.count());
    }

    /// w -= s T - K x with what emitters do to v_slot (core/objective/script/jets.rs).
    fn push(&self, machine: &mut Machine, slot: usize, (x, s): (Part, f64), w: Part) {
        let pushed = self.gradient_of_step();
        for (place, &(index, along)) in self.facts.jets[slot].iter().enumerate() {
            let base = self.along_axes(along.map(|v| s * v));
            let numbers = Numbers {
                flags: base.flags | (u32::from(place == 0) << FLAGS),
                ..base
            };
            let shape = self.place(Place::Emitter(index));
            let parts = [Some(pushed), Some(x), Some(shape), None];
            machine.run(Kernel::Push, &parts, &numbers, self.faces());
        }
        if !self.facts.jets[slot].is_empty() {
            self.add(machine, w, [1.0, -1.0], Some(pushed));
        }
    }

    /// Steps of faces times the mask, which is `least` at least, or divided by it (core/force/mask.rs).
    fn weigh(&self, machine: &mut Machine, steps: Part, divide: bool, least: f64) {
        let base = self.numbers();
        let elements = (steps.bytes / 4) as usize;
        let numbers = Numbers {
            a: least as f32,
            count: (elements / self.faces()) as u32,
            flags: base.flags | (u32::from(divide) << FLAGS),
            ..base
        };
        let parts = [Some(steps), Some(self.place(Place::Mask)), None, None];
        machine.run(Kernel::Weigh, &parts, &numbers, elements);
    }

    /// Numbers of a step of faces.
    fn faces(&self) -> usize {
        self.facts.room.dims * self.apart()
    }

    /// out = a x + b s^2 C^T C x + c y in some steps.
    fn combine(&self, machine: &mut Machine, out: Part, [a, b, c]: [f64; 3], x: Part, y: Option<Part>) {
        let elements = (out.bytes / 4) as usize;
        let numbers = Numbers {
            a: a as f32,
            b: (b * self.facts.smoothing) as f32,
            c: c as f32,
            count: (elements / self.faces()) as u32,
            ..self.numbers()
        };
        machine.run(Kernel::Price, &[Some(out), Some(x), y, None], &numbers, elements);
    }

    /// The force's price and its plain square; the force times its price is written.
    fn price(&self, machine: &mut Machine, w: &Field) -> [f64; 2] {
        let weighs = self.facts.room.weighs;
        let found = self.products(machine, w, &mut |machine, (first, count)| {
            let force = w.part(first, count);
            let mut products = vec![self.dot(machine, force, None)];
            if weighs {
                self.times_price(machine, force, (first, count));
                let priced = self.priced.part(first, count);
                products.push(self.dot(machine, force, Some(priced)));
            }
            products
        });
        match found[..] {
            [plain, price] => [price, plain],
            [plain] => [plain; 2],
            _ => [f64::NAN; 2],
        }
    }

    /// The force in some steps times its price.
    fn times_price(&self, machine: &mut Machine, force: Part, (first, count): (usize, usize)) {
        let priced = self.priced.part(first, count);
        let mut source = force;
        if self.facts.room.masked {
            source = self.divided.part(first, count);
            self.add(machine, source, [0.0, 1.0], Some(force));
            self.weigh(machine, source, true, LEAST);
        }
        self.combine(machine, priced, [1.0, 1.0, 0.0], source, None);
        if self.facts.room.masked {
            self.weigh(machine, priced, true, LEAST);
        }
        for (slot, &factor) in self.facts.factors.iter().enumerate().skip(first).take(count) {
            self.add(machine, self.priced.step(slot), [factor, 0.0], None);
        }
    }

    /// See [`Device::value`](thurible_core::exec::Device::value).
    pub fn value(&mut self, machine: &mut Machine, force: usize) -> Result<[f64; 3], NotFinite> {
        self.count_substeps(machine)?;
        let data = self.carry_all(machine);
        let w = &self.fields[force];
        self.accelerate(machine, w);
        self.project(machine, w, self.facts.projection_tolerance);
        let weight = 0.5 * self.facts.force_weight;
        let [price, plain] = self.price(machine, w).map(|sum| weight * sum);
        Ok([data, price, plain])
    }

    /// See [`Device::gradient`](thurible_core::exec::Device::gradient).
    pub fn gradient(&self, machine: &mut Machine, force: usize, into: usize) -> Result<(), NotFinite> {
        let z = if self.facts.room.weighs {
            &self.priced
        } else {
            &self.fields[force]
        };
        // With a mask it is no derivative along fields free of divergence before.
        if self.facts.room.masked {
            self.project_to_rounding(machine, z);
        }
        let out = &self.fields[into];
        for slot in 0..self.facts.room.slots {
            let after = (slot + 1 < self.facts.room.slots).then(|| z.step(slot + 1));
            let base = self.numbers();
            let numbers = Numbers {
                a: self.facts.viscosity as f32,
                flags: base.flags | (u32::from(after.is_none()) << FLAGS),
                ..base
            };
            let parts = [
                Some(out.step(slot)),
                Some(self.flow(slot + 1)),
                Some(z.step(slot)),
                after,
            ];
            machine.run(Kernel::ForceBack, &parts, &numbers, out.numbers());
            let next = slot + 1;
            if next < self.facts.room.slots {
                self.push(machine, next, (z.step(next), 0.0), out.step(slot));
            }
        }
        self.go_back(machine, into, z);
        for _ in 0..PASSES {
            self.project(machine, out, self.facts.projection_tolerance);
            let [divergence, largest] = self.relative_divergence(machine, into);
            if !(largest < SUMMABLE) {
                return Err(NotFinite);
            }
            if divergence <= CLEAN {
                break;
            }
        }
        Ok(())
    }

    /// Field `into` = the sum of `factor` times a field each. Page by page, so that one that is streamed is brought once.
    pub fn form(&self, machine: &mut Machine, into: usize, terms: &mut dyn Iterator<Item = (f64, usize)>) {
        let terms: Vec<_> = terms.collect();
        for (first, count) in self.fields[into].windows(usize::MAX) {
            let mut keep = 0.0;
            for &(factor, field) in &terms {
                let [out, x] = [into, field].map(|field| self.fields[field].part(first, count));
                self.add(machine, out, [keep, factor], Some(x));
                keep = 1.0;
            }
        }
    }

    /// See [`Device::divergence`](thurible_core::exec::Device::divergence).
    pub fn relative_divergence(&self, machine: &mut Machine, field: usize) -> [f64; 2] {
        let [divergence, largest] = self.measure(machine, &self.fields[field]);
        if !(divergence < FINITE && largest < FINITE) {
            return [f64::NAN; 2];
        }
        if divergence == 0.0 {
            return [0.0, largest];
        }
        [divergence / (self.facts.inverse[0] * largest), largest]
    }

    /// v += s times a field.
    pub fn advance(&self, machine: &mut Machine, field: usize, s: f64) {
        self.add_fields(machine, self.velocity(), [1.0, s], &self.fields[field]);
    }

    /// v = v_0 + keep (v - v_0).
    pub fn retreat(&self, machine: &mut Machine, keep: f64) {
        for slot in 0..self.facts.room.slots {
            self.add(
                machine,
                self.flow(slot + 1),
                [keep, 1.0 - keep],
                Some(self.flow(0)),
            );
        }
    }

    /// Projects all slots of a field until what is left is rounding. Among solid cells one projection goes on until then.
    fn project_to_rounding(&self, machine: &mut Machine, field: &Field) {
        let passes = if self.facts.room.solids { 1 } else { PASSES };
        for _ in 0..passes {
            self.project(machine, field, self.facts.projection_tolerance);
        }
    }

    /// image = y divided by the price: by that of curls, and with a mask m the projection of m q m y (core/objective/force_term.rs).
    fn divide_by_price(&self, machine: &mut Machine, y: &Field, image: &Field) {
        let (masked, least) = (self.facts.room.masked, self.facts.least_of_mask);
        for (first, count) in y.windows(usize::MAX) {
            let [mut source, image, priced] = [y, image, &self.priced].map(|field| field.part(first, count));
            if masked {
                let divided = self.divided.part(first, count);
                self.add(machine, divided, [0.0, 1.0], Some(source));
                self.weigh(machine, divided, false, least);
                source = divided;
            }
            self.divide_by_curls(machine, source, [image, priced]);
            if masked {
                self.weigh(machine, image, false, least);
            }
        }
        if masked {
            self.project_to_rounding(machine, image);
        }
    }

    /// image = q(B) y in some steps, with B the price of curls: Richardson's steps of the given lengths (core/force/price.rs), by way of `work`;
    /// or y itself.
    fn divide_by_curls(&self, machine: &mut Machine, y: Part, [image, work]: [Part; 2]) {
        let lengths = &self.facts.lengths;
        if lengths.is_empty() {
            return self.add(machine, image, [0.0, 1.0], Some(y));
        }
        let [mut now, mut next] = if lengths.len().is_multiple_of(2) {
            [work, image]
        } else {
            [image, work]
        };
        for (step, &length) in lengths.iter().enumerate() {
            if step == 0 {
                self.add(machine, now, [0.0, length], Some(y));
                continue;
            }
            self.combine(machine, next, [1.0 - length, -length, length], now, Some(y));
            core::mem::swap(&mut now, &mut next);
        }
    }

    /// x <- (kappa + S)^-1 x along time, slot by slot (core/force/time_line.rs).
    fn solve_in_time(&self, machine: &mut Machine, x: &Field, scale: f64) {
        let coupling = self.facts.coupling;
        for (slot, &pivot) in self.facts.pivots.iter().enumerate() {
            let before = slot.checked_sub(1).map(|before| x.step(before));
            let by = if before.is_some() { pivot * coupling } else { 0.0 };
            self.add(machine, x.step(slot), [pivot * scale, by], before);
        }
        for (slot, &pivot) in self.facts.pivots.iter().enumerate().rev().skip(1) {
            self.add(
                machine,
                x.step(slot),
                [1.0, pivot * coupling],
                Some(x.step(slot + 1)),
            );
        }
    }

    /// See [`Device::arrive`](thurible_core::exec::Device::arrive).
    pub fn arrive(
        &self,
        machine: &mut Machine,
        [gradient, image]: [usize; 2],
        step: Option<Stride>,
        pairs: &mut dyn Iterator<Item = [usize; 2]>,
        products: &mut dyn FnMut([f64; 2]),
    ) -> WithGradient {
        let of = |field: usize| &self.fields[field];
        let (gradient, image) = (of(gradient), of(image));
        self.divide_by_price(machine, gradient, image);
        self.solve_in_time(machine, image, 1.0 / self.facts.force_weight);
        let pairs: Vec<_> = pairs.collect();
        let stepped = step.map(|stride| (stride.length, [stride.direction, stride.preconditioned].map(of)));
        let found = self.products(machine, gradient, &mut |machine, (first, count)| {
            let part = |field: &Field| field.part(first, count);
            let (gradient, image) = (part(gradient), part(image));
            let mut begun = vec![self.dot(machine, gradient, Some(image))];
            for &field in pairs.iter().flatten() {
                begun.push(self.dot(machine, gradient, Some(part(of(field)))));
            }
            if let Some((length, fields)) = stepped {
                let [s, z] = fields.map(part);
                self.add(machine, s, [length, 0.0], None);
                begun.extend([s, z].map(|x| self.dot(machine, gradient, Some(x))));
                self.add(machine, z, [-1.0, 1.0], Some(image));
            }
            begun
        });
        let mut found = found.into_iter();
        let mut next = || found.next().unwrap_or(f64::NAN);
        let norm = next();
        for _ in &pairs {
            products([next(), next()]);
        }
        let step = stepped.map_or([0.0; 2], |_| [next(), next()]);
        WithGradient { norm, step }
    }
}
