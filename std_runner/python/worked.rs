//! What an operator of either dimension does, and what its way back gives.

use crate::place::Number;
use crate::words::refused;
use pyo3::exceptions::{PyFloatingPointError, PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use thurible_core::operator::{Ask, EmitterGradient, OperatorError, Show, Start};
use thurible_core::{Exec, Observer, Operator, Space};

/// The gradient of a scalar function of a simulation.
#[pyclass(frozen, get_all, module = "thurible_smoke", name = "Gradient")]
pub struct Gradient {
    /// By the density at the start.
    pub density: Py<PyAny>,
    /// By the components of the velocity at the start, as it was given.
    pub velocity: Py<PyTuple>,
    /// By the components of the forces of all steps; None where the simulation was given none.
    pub forces: Option<Py<PyTuple>>,
    /// By the acceleration of buoyancy along each axis.
    pub buoyancy: Vec<f64>,
    /// Of each emitter a dict: "supply" (its rate or target), "velocity" (a list, or None where it has none), "shape".
    pub emitters: Vec<Py<PyDict>>,
}

/// What a way back found beside the fields.
pub struct Found {
    /// By the acceleration of buoyancy.
    pub buoyancy: [f64; 3],
    /// By the numbers of each emitter.
    pub emitters: Vec<EmitterGradient>,
}

/// An operator of either dimension.
pub trait Work<T>: Send {
    /// See [`Operator::simulate`].
    fn simulate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        start: &Start<'_, T>,
        force: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError>;

    /// See [`Operator::vjp`].
    fn vjp(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: &mut Ask<'_, T>,
        cotangent: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError>;

    /// Reads the rest of the gradient.
    fn found(&self, density: &mut [T], velocity: &mut [Vec<T>], shapes: &mut [Vec<T>]) -> Found;
}

impl<T: Number, S: Space + Send> Work<T> for Operator<'static, T, S> {
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

    fn found(&self, density: &mut [T], velocity: &mut [Vec<T>], shapes: &mut [Vec<T>]) -> Found {
        let view = self.gradient();
        view.read_density(density);
        for (axis, v) in velocity.iter_mut().enumerate() {
            view.read_vector(axis, v);
        }
        for (index, shape) in shapes.iter_mut().enumerate() {
            self.shape_gradient(index).read_density(shape);
        }
        Found {
            buoyancy: self.buoyancy_gradient(),
            emitters: (0..shapes.len())
                .map(|index| self.emitter_gradient(index))
                .collect(),
        }
    }
}

/// The refusal of a run.
pub fn stopped(error: OperatorError) -> PyErr {
    match error {
        OperatorError::TooFast { .. } => PyFloatingPointError::new_err(error.to_string()),
        OperatorError::NotSimulated => {
            PyRuntimeError::new_err("nothing was simulated yet; call simulate before vjp")
        }
        other => refused("what was given", format!("cannot be used: {other}; change it")),
    }
}

/// So many numbers, all 0.
pub fn room<T: Number>(count: usize) -> PyResult<Vec<T>> {
    let mut room = Vec::new();
    room.try_reserve_exact(count)
        .map_err(|_| PyMemoryError::new_err("the system has not the memory for the arrays of all steps"))?;
    room.resize(count, T::ZERO);
    Ok(room)
}
