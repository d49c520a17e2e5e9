//! What a finished solver gives.

use super::Solver;
use super::layout::{FileLayout, Run, Strided};
use super::shared::Verb;
use crate::exec::Exec;
use crate::field::slot::Slot;
use crate::grid::{Grid, Space};
use crate::method::contract::Parts;
use crate::method::output::{DENSITY, FORCE, Output, Place, Stored, Unit, VELOCITY};
use crate::objective::script::Script;
use crate::objective::script::jets::Jets;
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Everything that the method gives, to be read after [`Self::finish`] by [`Self::read`] or [`Self::in_place`].
    #[must_use]
    pub fn outputs(&self) -> &'static [Output] {
        self.engine.get().outputs()
    }

    /// Time steps N.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Where step `step` of an output is: in the controlled part, or after the release.
    fn stored(&self, output: &Output, step: usize) -> Stored<'_, T> {
        let method = self.engine.get();
        let controlled = output.count(self.animation().slots + 1);
        let released = self.release.as_ref();
        let released = released.and_then(|release| release.stored(output, step, controlled));
        released.unwrap_or_else(|| method.stored(output, step.min(controlled.saturating_sub(1))))
    }

    /// The scene's unit of an output.
    fn unit(&self, output: &Output) -> f64 {
        match output.unit {
            Unit::Density => 1.0,
            Unit::Velocity => self.units.velocity,
            Unit::Force => self.units.force,
        }
    }

    /// Component `axis` of step `step` of an output as it lies in memory.
    #[must_use]
    pub fn in_place(&self, output: &Output, step: usize, axis: usize) -> Strided<'_, T> {
        let stored = self.stored(output, step);
        let field = stored.components[axis];
        let [slots, slot] = [stored.slots, stored.slot];
        Strided::slot(
            self.grid(),
            field,
            [slots, slot],
            self.unit(output),
            faces(output, axis),
        )
    }

    /// Elements that [`Self::read`] writes of a component of an output.
    #[must_use]
    pub fn elements(&self, output: &Output, axis: usize) -> usize {
        FileLayout::of(&self.grid().whole(), faces(output, axis)).len()
    }

    /// Component `axis` of step `step` of an output in the layout of a file, x fastest, of faces one more than cells along a wall axis,
    /// and in the scene's units. `out` has [`Self::elements`] elements.
    pub fn read(&self, output: &Output, step: usize, axis: usize, out: &mut [T]) {
        if self.is_shared() {
            let number = self.outputs().iter().position(|known| known == output);
            self.shared
                .ask(Verb::Read, [number.unwrap_or(usize::MAX), step, axis]);
        }
        let place = (self.grid(), faces(output, axis));
        self.shared.collect(place, out, |layout, out| {
            self.read_part(output, step, axis, (layout, out));
        });
    }

    /// What this rank has of it.
    fn read_part(
        &self,
        output: &Output,
        step: usize,
        axis: usize,
        (layout, out): (&FileLayout<'_>, &mut [T]),
    ) {
        let stored = self.stored(output, step);
        let (field, unit) = (stored.components[axis], T::from_f64(self.unit(output)));
        layout.read(field, [stored.slots, stored.slot], unit, out);
    }

    /// Sends the first rank what this one has of component `axis` of step `step` of an output by its number.
    pub(super) fn send_output(&mut self, output: usize, step: usize, axis: usize) {
        if let Some(output) = self.outputs().get(output) {
            self.send(faces(output, axis), |solver, layout, out| {
                solver.read_part(output, step, axis, (layout, out));
            });
        }
    }

    /// Sends the first rank what `own` writes of this one's part of a component: of the faces of `axis`, or of cells.
    fn send(&mut self, axis: Option<usize>, own: impl FnOnce(&Self, &FileLayout<'_>, &mut [T])) {
        let mut shared = core::mem::take(&mut self.shared);
        shared.send((self.grid(), axis), |layout, out| own(self, layout, out));
        self.shared = shared;
    }

    /// Copies a field of cells as it is stored, such as [`Self::density`], to `out` of [`Self::cells`](Solver::cells) elements.
    pub fn read_cells(&self, stored: &[T], out: &mut [T]) {
        FileLayout::of_cells(self.grid()).read(stored, [1, 0], T::ONE, out);
    }

    /// The same without copying.
    #[must_use]
    pub fn cells_in_place<'s>(&self, stored: &'s [T]) -> Strided<'s, T> {
        Strided::slot(self.grid(), stored, [1, 0], 1.0, None)
    }

    /// rho_step as it is stored: one element for each cell, those outside open sides, where it is 0, among them.
    #[must_use]
    pub fn density(&self, step: usize) -> &[T] {
        self.stored(&DENSITY, step).components[0]
    }

    /// The target of keyframe `index`, after any scaling of its mass, stored as a density.
    #[must_use]
    pub fn keyframe(&self, index: usize) -> &[T] {
        self.field(index)
    }

    /// The same in the layout of a file: `out` has [`Self::cells`](Solver::cells) elements.
    pub fn read_keyframe(&self, index: usize, out: &mut [T]) {
        self.read_given(index, out);
    }

    /// What keyframe `index` has its error multiplied by, as [`Self::read_keyframe`]; 1 where keyframes have no regions.
    pub fn read_region(&self, index: usize, out: &mut [T]) {
        if self.lists.regions {
            self.read_given(self.lists.steps.len() + index, out);
        } else {
            out.fill(T::ONE);
        }
    }

    /// Where force may act, as [`Self::read_keyframe`]; 1 where there is no mask.
    pub fn read_mask(&self, out: &mut [T]) {
        if self.lists.mask {
            self.read_given(self.lists.mask_begins(), out);
        } else {
            out.fill(T::ONE);
        }
    }

    /// Field `index` of the script in the layout of a file.
    fn read_given(&self, index: usize, out: &mut [T]) {
        self.shared.ask(Verb::Given, [index, 0, 0]);
        let field = self.field(index);
        self.shared.collect((self.grid(), None), out, |layout, out| {
            layout.read(field, [1, 0], T::ONE, out);
        });
    }

    /// Sends the first rank what this one has of it.
    pub(super) fn send_given(&mut self, index: usize) {
        self.send(None, |solver, layout, out| {
            layout.read(solver.field(index), [1, 0], T::ONE, out);
        });
    }

    /// Field `index` of the script as it is stored.
    fn field(&self, index: usize) -> &[T] {
        Script::new(self.lists, &*self.fields).field(index, self.grid().cells())
    }

    /// What keyframe `index` has its error multiplied by, stored as a density; empty where keyframes have no regions.
    #[must_use]
    pub fn keyframe_region(&self, index: usize) -> &[T] {
        Script::new(self.lists, self.fields)
            .wanted(index, self.grid().cells())
            .region
    }

    /// What the price of the force u_step is multiplied by.
    #[must_use]
    pub fn force_factor(&self, step: usize) -> f64 {
        Script::new(self.lists, &*self.fields).factor(step)
    }

    /// What emitters added to the density after `step` (0 .. N-1), one element for each cell inside; to be asked after [`Self::finish`].
    pub fn emission(&mut self, exec: &dyn Exec, step: usize, out: &mut [T]) {
        self.shared.ask(Verb::Emission, [step, 0, 0]);
        let script = Script::new(self.lists, &*self.fields);
        let controlled = self.engine.get().animation().slots + 1;
        out.fill(T::ZERO);
        let shared = &mut self.shared;
        let mut take = |grid: &Grid, added: &[T]| {
            let own = |layout: &FileLayout<'_>, out: &mut [T]| layout.read(added, [1, 0], T::ONE, out);
            if shared.is_first() {
                shared.collect((grid, None), out, own);
            } else {
                shared.send((grid, None), own);
            }
        };
        match &mut self.release {
            Some(release) if step >= controlled => {
                let Parts { animation, setup, .. } = self.engine.get_mut().parts();
                let controlled = (&*animation, setup.sweep.largest);
                release.emission(exec, controlled, step, &script, &mut take);
            }
            _ => self
                .engine
                .get_mut()
                .idle_parts()
                .emission(exec, step, &script, &mut take),
        }
    }

    /// Whether emitters give their smoke a velocity: then [`Self::jet`] is not 0.
    #[must_use]
    pub fn has_jets(&self) -> bool {
        !self.lists.jets.is_empty()
    }

    /// Component `axis` of what emitters add to the force u_step (step 0 .. N-2) to give their smoke its velocity: T - K v_step, with K and T of
    /// [`Jets`]. As [`Self::force`]; to be asked after [`Self::finish`].
    pub fn jet(&self, step: usize, axis: usize, out: &mut [T]) {
        self.shared.ask(Verb::Jet, [step, axis, 0]);
        let place = (self.grid(), Some(axis));
        self.shared.collect(place, out, |layout, out| {
            self.jet_part(step, axis, (layout, out));
        });
    }

    /// What this rank has of it.
    fn jet_part(&self, step: usize, axis: usize, (layout, out): (&FileLayout<'_>, &mut [T])) {
        out.fill(T::ZERO);
        let v = self.stored(&VELOCITY, step);
        let (animation, unit) = (self.animation(), self.units.force);
        let (grid, solids) = (animation.grid(), animation.levels.solids(0));
        let script = Script::new(self.lists, &*self.fields);
        let jets = Jets { grid, solids, script };
        let before = Slot {
            field: v.components,
            slots: v.slots,
            slot: v.slot,
        };
        if !jets.push(step) {
            return;
        }
        for Run { row, x, file, count } in layout.runs() {
            let faces = out.get_mut(file..file + count).unwrap_or_default().iter_mut();
            let pushed = jets.row(step, axis, row).zip(before.row(grid, axis, row));
            for (out, ([target, part], v)) in faces.zip(pushed.skip(x)) {
                *out = T::from_f64(unit * (target - part * v.to_f64()));
            }
        }
    }

    /// Sends the first rank what this one has of it.
    pub(super) fn send_jet(&mut self, step: usize, axis: usize) {
        self.send(Some(axis), |solver, layout, out| {
            solver.jet_part(step, axis, (layout, out));
        });
    }

    /// Faces of a component of a velocity or force in the layout of a file.
    #[must_use]
    pub fn faces(&self, axis: usize) -> usize {
        self.elements(&VELOCITY, axis)
    }

    /// Component `axis` of v_step (step 0 .. N-1), as [`Self::read`] gives it; `out` has [`Self::faces`] elements.
    pub fn velocity(&self, step: usize, axis: usize, out: &mut [T]) {
        self.read(&VELOCITY, step, axis, out);
    }

    /// Component `axis` of the force u_step (step 0 .. N-2) that turns v_step into v_{step+1}; as [`Self::velocity`].
    pub fn force(&self, step: usize, axis: usize, out: &mut [T]) {
        self.read(&FORCE, step, axis, out);
    }
}

/// The axis whose faces an output's component `axis` is on; `None` of cells.
fn faces(output: &Output, axis: usize) -> Option<usize> {
    (output.place == Place::Faces).then_some(axis)
}
