//! What programs that differentiate through a simulation need of it, whichever simulator it is.

use super::{Ask, EmitterGradient, Operator, OperatorError, Show, Start, View};
use crate::exec::Exec;
use crate::grid::Space;
use crate::observe::Observer;
use crate::real::Real;
use crate::solver::InputError;

/// A simulation that can be differentiated, in planned memory.
pub trait Simulator<T: Real> {
    /// Numbers of a density.
    fn density_len(&self) -> usize;

    /// Numbers of component `axis` of a velocity or force in the layout of a file; 0 of an axis that there is not.
    fn vector_len(&self, axis: usize) -> usize;

    /// As [`Operator::set_solids`].
    ///
    /// # Errors
    /// [`InputError`].
    fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        let _ = solid;
        Err(InputError::Index { given: 0, count: 0 })
    }

    /// As [`Operator::set_emitter`].
    ///
    /// # Errors
    /// [`InputError`].
    fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        let _ = shape;
        Err(InputError::Index {
            given: index,
            count: 0,
        })
    }

    /// As [`Operator::simulate`].
    ///
    /// # Errors
    /// [`OperatorError`].
    fn simulate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        start: &Start<'_, T>,
        force: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError>;

    /// As [`Operator::vjp`].
    ///
    /// # Errors
    /// [`OperatorError`].
    fn vjp(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: &mut Ask<'_, T>,
        cotangent: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError>;

    /// The gradient by rho_0 and by v_0 as it was given, after [`Self::vjp`].
    fn gradient(&self) -> View<'_, T>;

    /// The gradient by the acceleration of buoyancy along each axis, after [`Self::vjp`].
    fn buoyancy_gradient(&self) -> [f64; 3];

    /// The gradient by the numbers of emitter `index`, after [`Self::vjp`]; 0 where there is none.
    fn emitter_gradient(&self, index: usize) -> EmitterGradient {
        let _ = index;
        EmitterGradient::default()
    }

    /// The gradient by the shape of emitter `index`, after [`Self::vjp`]: the field of cells of a view, where there is such an emitter.
    fn shape_gradient(&self, index: usize) -> Option<View<'_, T>> {
        let _ = index;
        None
    }

    /// Steps that the last simulation and its last gradient ran again, beside the one for each step that was taken back.
    fn repeated(&self) -> usize;
}

impl<T: Real, S: Space> Simulator<T> for Operator<'_, T, S> {
    fn density_len(&self) -> usize {
        self.cells()
    }

    fn vector_len(&self, axis: usize) -> usize {
        if axis < S::DIM { self.faces_len(axis) } else { 0 }
    }

    fn set_solids(&mut self, solid: &[bool]) -> Result<(), InputError> {
        Operator::set_solids(self, solid)
    }

    fn set_emitter(&mut self, index: usize, shape: &[T]) -> Result<(), InputError> {
        Operator::set_emitter(self, index, shape)
    }

    fn simulate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        start: &Start<'_, T>,
        force: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError> {
        Operator::simulate(self, exec, observer, start, force, show)
    }

    fn vjp(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: &mut Ask<'_, T>,
        cotangent: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError> {
        Operator::vjp(self, exec, observer, force, cotangent, show)
    }

    fn gradient(&self) -> View<'_, T> {
        Operator::gradient(self)
    }

    fn buoyancy_gradient(&self) -> [f64; 3] {
        Operator::buoyancy_gradient(self)
    }

    fn emitter_gradient(&self, index: usize) -> EmitterGradient {
        Operator::emitter_gradient(self, index)
    }

    fn shape_gradient(&self, index: usize) -> Option<View<'_, T>> {
        (index < self.setup.emitters).then(|| Operator::shape_gradient(self, index))
    }

    fn repeated(&self) -> usize {
        Operator::repeated(self)
    }
}
