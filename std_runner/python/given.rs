//! What a method gives, as Python sees it.

use crate::place::Field;
use crate::solution::{Solution, filed};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use thurible_core::Named;

/// Something that the method gives: a field for each of many steps.
#[pyclass(frozen, module = "thurible_smoke", name = "Output")]
pub struct Given {
    pub(crate) solution: Py<Solution>,
    pub(crate) index: usize,
}

impl Given {
    /// What it is, or nothing of a solution that has fewer: those of an output are never fewer.
    fn field(&self) -> Option<&Field> {
        self.solution.get().fields.get(self.index)
    }
}

#[pymethods]
impl Given {
    /// Its name.
    #[getter]
    fn name(&self) -> &'static str {
        self.field().map_or("", |field| field.output.name)
    }

    /// What it is, in a few words.
    #[getter]
    fn words(&self) -> &'static str {
        self.field().map_or("", |field| field.output.words)
    }

    /// "cells", or "faces" for a component along each axis, on the faces across it.
    #[getter]
    fn place(&self) -> &'static str {
        self.field().map_or("", |field| field.output.place.name())
    }

    /// In what it is measured: "density", "velocity" or "force".
    #[getter]
    fn unit(&self) -> &'static str {
        self.field().map_or("", |field| field.output.unit.name())
    }

    /// An array for each component as result.npz has it: the solver's own memory where it lies so, else made when first asked for.
    #[getter]
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        filed(
            self.solution.bind(py),
            self.field().map_or(&[], |field| &field.components),
        )
    }

    fn __repr__(&self) -> String {
        format!("<thurible_smoke.Output: {}, {}>", self.name(), self.words())
    }
}
