//! A solve that goes on where another ended, of an animation that is solved window by window.

use super::Solver;
use super::errors::InputError;
use super::layout::{FileLayout, finite};
use super::shared::Verb;
use crate::exec::Exec;
use crate::field::borders;
use crate::grid::Space;
use crate::method::animation::Animation;
use crate::objective::script::Script;
use crate::progress::Objective;
use crate::real::Real;

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Sets rho_0 as a result left it, after v_0 and the emitters: it may be empty, and below 0 where transport undershoots. v_0 is taken as it
    /// is, since it was projected there.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is not finite.
    pub fn go_on_from(&mut self, density: &[T]) -> Result<(), InputError> {
        finite(density, self.cells())?;
        self.shared.ask(Verb::GoOn, [0; 3]);
        self.take_left(density);
        Ok(())
    }

    /// Takes rho_0 as a result left it, which the first rank has checked.
    pub(super) fn take_left(&mut self, density: &[T]) {
        let largest = density
            .iter()
            .fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
        self.put_source(density, largest);
        let mass: f64 = density.iter().map(|x| x.to_f64()).sum();
        // Where there is none yet, that is no fault here.
        self.mass = self.shared.told(mass.max(f64::MIN_POSITIVE));
        self.prepared = Some(0.0);
    }

    /// Sets a component of v_step, from step 1 on, where the search is to begin: see [`Self::begin_at_given`].
    ///
    /// # Errors
    /// As [`Self::set_initial_velocity`], or [`InputError::Index`] where there is no such step.
    pub fn give_velocity(&mut self, step: usize, axis: usize, faces: &[T]) -> Result<(), InputError> {
        let grid = *self.grid();
        let slots = self.animation().slots;
        let (given, count) = if axis < grid.dims {
            (step, slots + 1)
        } else {
            (axis, grid.dims)
        };
        if axis >= grid.dims || !(1..=slots).contains(&step) {
            return Err(InputError::Index { given, count });
        }
        finite(faces, FileLayout::new(&grid.whole(), axis).len())?;
        self.shared.ask(Verb::Guess, [step, axis, 0]);
        self.take_guess(step, axis, faces);
        Ok(())
    }

    /// Takes a component of v_step, which the first rank has checked.
    pub(super) fn take_guess(&mut self, step: usize, axis: usize, faces: &[T]) {
        let (grid, unit) = (*self.grid(), T::from_f64(1.0 / self.units.velocity));
        let Animation { v, slots, .. } = self.engine.get_mut().parts().animation;
        let slot = [*slots, step.saturating_sub(1)];
        if let Some(field) = v.get_mut(axis) {
            self.shared
                .put_slot((&grid, Some(axis)), faces, unit, field, slot);
        }
        self.finished = false;
    }

    /// Begins the search at the velocities of [`Self::give_velocity`], which must all be there, with everything else; whether the method can.
    /// Where it cannot, it begins by itself.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn begin_at_given(&mut self, exec: &dyn Exec) -> Result<bool, InputError> {
        self.shared.ask(Verb::Begin, [0; 3]);
        self.prepared(exec)?;
        let Animation { levels, v, .. } = self.engine.get_mut().parts().animation;
        borders::refresh_faces(exec, &levels.finest, v);
        let script = Script::new(self.lists, &*self.fields);
        Ok(self.engine.get_mut().begin_at(exec, &script))
    }

    /// The objective of a part of the result, after [`Self::finish`]: of the keyframes at step `last` or before, and the first `forces` forces.
    /// That of the whole where the method cannot tell.
    pub fn objective_of(&mut self, exec: &dyn Exec, last: usize, forces: usize) -> Objective {
        self.shared.ask(Verb::Price, [last, forces, 0]);
        let script = Script::new(self.lists, &*self.fields);
        let Some((parts, w)) = self.engine.get_mut().spent() else {
            return self.objective;
        };
        let (mut evaluation, _) = parts.animation.evaluation(*parts.setup, &script, parts.region);
        let data = evaluation.data(exec, last);
        let force = evaluation.price_of_first::<S>(exec, w, forces);
        Objective { data, ..force }
    }
}
