//! What a reconstruction found, for Python.

use crate::place::Number;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use thurible_core::tomography::Reconstruction;

/// The density behind pictures.
#[pyclass(frozen, get_all, module = "thurible_smoke")]
pub struct Tomography {
    /// Of shape (nz, ny, nx) or (ny, nx), after frames where pictures have some; None where it was not kept.
    pub(crate) density: Py<PyAny>,
    /// What each camera would see of it.
    pub(crate) reprojected: Py<PyTuple>,
    /// What each novel view shows.
    pub(crate) novel: Py<PyTuple>,
    /// What is said of each frame that is not dark.
    pub(crate) history: Py<PyList>,
    /// How much of the prior was charged.
    pub(crate) gamma: f64,
    /// Bytes of the block.
    pub(crate) planned_bytes: usize,
}

#[pymethods]
impl Tomography {
    fn __repr__(&self, py: Python<'_>) -> String {
        format!(
            "<thurible_smoke.Tomography: {} frames>",
            self.history.bind(py).len()
        )
    }
}

/// What is said of a frame, by the names of `report.json`.
pub fn said<'py, T: Number, const D: usize>(
    py: Python<'py>,
    one: &Reconstruction<'_, T, D>,
) -> PyResult<Bound<'py, PyDict>> {
    let said = PyDict::new(py);
    let (walked, energy) = (one.walked(), one.energy());
    said.set_item("frame", one.frame())?;
    said.set_item("mutations", walked.mutations)?;
    said.set_item("accepted", walked.recorded)?;
    said.set_item("data", energy.data)?;
    said.set_item("prior", energy.prior)?;
    said.set_item("residual_relative", one.residual_relative())?;
    Ok(said)
}
