//! What the way back of an operator gives.

use crate::place::Number;
use crate::words::refused;
use pyo3::exceptions::{PyFloatingPointError, PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use thurible_core::operator::{EmitterGradient, OperatorError, Simulator};

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

/// Reads what a way back found beside the forces.
pub fn found<T: Number>(
    work: &dyn Simulator<T>,
    density: &mut [T],
    velocity: &mut [Vec<T>],
    shapes: &mut [Vec<T>],
) -> Found {
    let view = work.gradient();
    view.read_density(density);
    for (axis, v) in velocity.iter_mut().enumerate() {
        view.read_vector(axis, v);
    }
    for (index, shape) in shapes.iter_mut().enumerate() {
        if let Some(view) = work.shape_gradient(index) {
            view.read_density(shape);
        }
    }
    Found {
        buoyancy: work.buoyancy_gradient(),
        emitters: (0..shapes.len())
            .map(|index| work.emitter_gradient(index))
            .collect(),
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
