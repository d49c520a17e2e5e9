//! What tracking found, for Python.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use thurible_core::track::Pair;

/// The flow behind frames of smoke: N pairs.
#[pyclass(frozen, get_all, module = "thurible_smoke")]
pub struct Track {
    /// The flow of each pair along x, y (and z).
    pub(crate) velocity: Py<PyTuple>,
    /// What it was before the frames of a pair were looked at.
    pub(crate) predicted: Py<PyTuple>,
    /// What was added to that.
    pub(crate) correction: Py<PyTuple>,
    /// The force from the flow of each pair to the next, or None.
    pub(crate) force: Option<Py<PyTuple>>,
    /// The first frame carried by the flow, or None.
    pub(crate) density: Py<PyAny>,
    /// What is said of each pair.
    pub(crate) history: Py<PyList>,
    /// What densities were multiplied by.
    pub(crate) density_scale: f64,
    /// What no flow does of a frame beside the one before.
    pub(crate) remarks: Vec<String>,
    /// Bytes of the block.
    pub(crate) planned_bytes: usize,
    /// Threads that it ran on.
    pub(crate) threads: usize,
}

#[pymethods]
impl Track {
    fn __repr__(&self, py: Python<'_>) -> String {
        format!("<thurible_smoke.Track: {} pairs>", self.history.bind(py).len())
    }
}

/// What is said of a pair, by the names of `report.json`.
pub fn said<'py>(
    py: Python<'py>,
    frame: usize,
    seconds: f64,
    pair: &Pair,
    readvect: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let said = PyDict::new(py);
    said.set_item("frame", frame)?;
    said.set_item("cg", pair.efforts.to_vec())?;
    let numbers = [
        ("seconds", seconds),
        ("data", pair.terms.data),
        ("smoothness", pair.terms.smoothness),
        ("kinetic", pair.terms.kinetic),
        ("optimality", pair.terms.optimality),
        ("misfit_predicted", pair.misfit[0]),
        ("misfit", pair.misfit[1]),
        ("fastest", pair.fastest),
    ];
    for (name, value) in numbers {
        said.set_item(name, value)?;
    }
    if readvect {
        said.set_item("readvection_error", pair.readvection)?;
    }
    Ok(said)
}
