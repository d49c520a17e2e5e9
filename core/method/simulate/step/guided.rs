//! The correction of a step that was solved by a given flow: see [`guide`](crate::method::simulate::guide).

use super::equation::project;
use super::{SURE, Step};
use crate::exec::Exec;
use crate::field::slot::Slot;
use crate::field::trajectory::add;
use crate::field::view;
use crate::method::simulate::guide::{Factor, Guide};
use crate::observe::Observer;
use crate::real::Real;
use crate::transport::Stop;

impl<T: Real> Step<'_, T> {
    /// v += the noise of step `step`, if guidance has one. The fields of the step that was solved hold what this takes.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn stir(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        guide: &mut Guide<'_, T>,
        step: usize,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let Some(stir) = &mut guide.stir else {
            return Ok(());
        };
        let (shape, tolerance) = (self.shape(), SURE * self.setup.tolerance);
        let Self {
            projection,
            v,
            given,
            residual,
            correction: [work, ..],
            solids,
            ..
        } = self;
        stir.noise(exec, step, residual, work, given);
        if solids.there() {
            // The curl knows walls, but no solid cells.
            project(projection, exec, observer, given, tolerance, sums)?;
        }
        stir.strengthen(exec, given, sums);
        add(exec, shape, v, 1.0, 1.0, view(given));
        Ok(())
    }

    /// v += Delta, by the given flow `reference`. The fields of the step that was solved hold what this takes.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn guide(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        guide: &mut Guide<'_, T>,
        reference: Slot<'_, T>,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let shape = self.shape();
        self.give(exec, [(1.0, reference)]);
        // Another box's flow may go through what is closed here.
        self.projection.close(exec, &mut self.given);
        add(exec, shape, &mut self.given, 1.0, -1.0, view(&self.v));
        let tolerance = SURE * self.setup.tolerance;
        if guide.closed {
            guide.filter(exec, Factor::Closed, &mut self.given);
            project(
                &mut self.projection,
                exec,
                observer,
                &mut self.given,
                tolerance,
                sums,
            )?;
            add(exec, shape, &mut self.v, 1.0, 1.0, view(&self.given));
            return Ok(());
        }
        guide.filter(exec, Factor::Given, &mut self.given);
        let Self {
            projection,
            v,
            given,
            residual: x,
            correction: y,
            adjoint: z,
            ..
        } = self;
        for field in y.iter_mut().chain(z.iter_mut()) {
            field.fill(T::ZERO);
        }
        for _ in 0..guide.params.iterations {
            add(exec, shape, x, 0.0, 1.0, view(z));
            add(exec, shape, x, 1.0, -1.0, view(y));
            guide.filter(exec, Factor::Kept, x);
            add(exec, shape, x, 1.0, 1.0, view(given));
            // y holds x + y until the projection of it is known.
            add(exec, shape, y, 1.0, 1.0, view(x));
            add(exec, shape, z, 0.0, 1.0, view(y));
            project(projection, exec, observer, z, tolerance, sums)?;
            add(exec, shape, y, 1.0, -1.0, view(z));
        }
        add(exec, shape, v, 1.0, 1.0, view(z));
        Ok(())
    }
}
