//! The flow that a method follows, where it follows one.

use super::layout::FileLayout;
use super::{InputError, Solver};
use crate::exec::Exec;
use crate::field::slot::put;
use crate::field::view;
use crate::flow::resample::{Kind, resample};
use crate::grid::Space;
use crate::memory::{Pool, pooled};
use crate::method::animation::Animation;
use crate::observe::Silent;
use crate::poisson::Projection;
use crate::real::Real;

/// The grid of a flow that comes from elsewhere, in the same box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elsewhere {
    /// Its cells along x, y, z; 1 along z in 2D.
    pub cells: [usize; 3],
    /// What a cell a step of it is in the numbers that are given.
    pub unit: f64,
}

impl<T: Real, S: Space> Solver<'_, T, S> {
    /// Sets a component of the flow of step `step`, from 1 to N - 1, that the method follows, as [`Self::set_initial_velocity`]. Where no step is
    /// set it is at rest. A solve goes over this flow, and puts what it finds in its place: for another solve it is given anew.
    ///
    /// # Errors
    /// [`InputError`]: a method that follows none, no such axis or step, wrong length, a value that is not finite.
    pub fn set_reference(&mut self, axis: usize, step: usize, faces: &[T]) -> Result<(), InputError> {
        self.begin_reference(axis, step)?;
        let (grid, slots) = (*self.grid(), self.animation().slots);
        let v = &mut self.engine.get_mut().parts().animation.v;
        FileLayout::new(&grid, axis).take(faces, 1.0 / self.units.velocity, v[axis], [slots, step - 1])?;
        (self.reference, self.finished) = (Some(true), false);
        Ok(())
    }

    /// Sets the flow of step `step` that the method follows, from one on other cells of a box whose axes end alike: every component by
    /// cubics, in cells a step of this grid, without divergence. Solid cells come before. `faces` are the components in the layout of a file of
    /// that grid.
    ///
    /// # Errors
    /// As [`Self::set_reference`]; [`InputError::TooFine`] where there is no room for a field of so many cells.
    pub fn set_reference_from(
        &mut self,
        exec: &dyn Exec,
        step: usize,
        from: Elsewhere,
        faces: [&[T]; 3],
    ) -> Result<(), InputError> {
        self.begin_reference(0, step)?;
        let parts = self.engine.get_mut().parts();
        let (tolerance, threads) = (parts.setup.projection_tolerance, parts.setup.sweep.threads);
        let Animation { levels, v, sums, .. } = parts.animation;
        let grid = &levels.finest;
        let source = grid.of_cells(from.cells);
        let (n, m) = (source.n, grid.n);
        // Along x first: what there is between the axes.
        let lengths = [source.cells(), m[0] * n[1] * n[2], m[0] * m[1] * n[2]];
        let needed = lengths.map(pooled).iter().sum::<usize>() + grid.dims * pooled(grid.cells());
        if needed > parts.region.len() {
            let cells = source.cells();
            return Err(InputError::TooFine { cells });
        }
        let mut pool = Pool::new(parts.region);
        let mut flow = pool.take_vector("flow of a step", grid.dims, grid.cells());
        let rest = pool.into_rest();
        let mut pool = Pool::new(&mut *rest);
        let [field, first, second] = lengths.map(|len| pool.take("a field", len));
        for (axis, (out, faces)) in flow.iter_mut().zip(faces).enumerate().take(grid.dims) {
            FileLayout::new(&source, axis).take(faces, 1.0 / from.unit, field, [1, 0])?;
            let scale = grid.h[axis] * m[axis] as f64 / n[axis] as f64;
            let kind = (Kind::Faces(axis), scale);
            resample(
                exec,
                [&source, grid],
                kind,
                field,
                out,
                [&mut *first, &mut *second],
            );
        }
        let mut projection = Projection::carve(levels, 0, 1, threads, &mut Pool::new(rest));
        let _ = projection.project(exec, &mut Silent, &mut flow, None, tolerance, sums);
        put(exec, grid, view(&flow), v, step - 1);
        (self.reference, self.finished) = (Some(true), false);
        Ok(())
    }

    /// Refuses an axis or a step that there is not; before the first, the flow that is followed is at rest.
    fn begin_reference(&mut self, axis: usize, step: usize) -> Result<(), InputError> {
        let slots = self.animation().slots;
        let axes = if self.reference.is_some() {
            self.grid().dims
        } else {
            0
        };
        for (given, count) in [(axis, axes), (step.wrapping_sub(1), slots)] {
            if given >= count {
                return Err(InputError::Index { given, count });
            }
        }
        self.changed();
        if self.reference == Some(false) {
            let v = &mut self.engine.get_mut().parts().animation.v;
            v.iter_mut().for_each(|component| component.fill(T::ZERO));
        }
        Ok(())
    }
}
