//! What was found, in memory that NumPy's arrays borrow.

use crate::block::Block;
use crate::iteration::Iteration;
use crate::place::{Component, Field, Number, Place};
use crate::plan::Precision;
use crate::watch::Ended;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use thurible::bytes::grouped;
use thurible::remarks::{KeyframeError, largest};
use thurible_core::output::{DENSITY, FORCE, VELOCITY};
use thurible_core::{Named, Objective, Output};

/// A result. Its arrays cannot be written to and keep it alive; copy what you want to change.
#[pyclass(frozen, module = "thurible_smoke")]
pub struct Solution {
    pub(crate) block: Block,
    pub(crate) fields: Vec<Field>,
    pub(crate) emission: Option<(Block, Place)>,
    /// For each axis; none where no emitter has a velocity.
    pub(crate) emitter_force: Vec<(Block, Place)>,
    pub(crate) precision: Precision,
    pub(crate) objective: Objective,
    pub(crate) ended: Ended,
    pub(crate) mass_factors: Vec<f64>,
    pub(crate) errors: Vec<KeyframeError>,
    pub(crate) templates: Vec<crate::templates::FoundTemplate>,
    pub(crate) remarks: Vec<String>,
    pub(crate) planned_bytes: usize,
    pub(crate) threads: usize,
}

/// Calls a generic function with the number type of a solution.
macro_rules! typed {
    ($precision:expr, $function:ident($($argument:expr),*)) => {
        match $precision {
            Precision::Single => $function::<f32>($($argument),*),
            Precision::Double => $function::<f64>($($argument),*),
        }
    };
}

#[pymethods]
impl Solution {
    /// All that the method gives, by name: a dict of Output.
    #[getter]
    fn outputs<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let outputs = PyDict::new(this.py());
        for (index, field) in this.get().fields.iter().enumerate() {
            let solution = this.clone().unbind();
            outputs.set_item(field.output.name, Given { solution, index })?;
        }
        Ok(outputs)
    }

    /// Densities, of shape (steps + 1, (nz,) ny, nx).
    #[getter]
    fn density<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        filed(this, this.get().components(&DENSITY))?.get_item(0)
    }

    /// Velocities along x, y (and z), of shape (steps, (nz,) ny, nx), on a wall axis one more along it; made when first asked for.
    #[getter]
    fn velocity<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        filed(this, this.get().components(&VELOCITY))
    }

    /// Forces along x, y (and z), as velocities, of steps - 1 entries: entry k turns velocity k into velocity k + 1.
    #[getter]
    fn force<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        filed(this, this.get().components(&FORCE))
    }

    /// What emitters added to the density after each step, of shape (steps, (nz,) ny, nx); None where there are none.
    #[getter]
    fn emission<'py>(this: &Bound<'py, Self>) -> Option<Bound<'py, PyAny>> {
        let (block, place) = this.get().emission.as_ref()?;
        Some(typed!(this.get().precision, view(this, block, place)))
    }

    /// What emitters with a velocity added beside the forces, along x, y (and z) and of the same shape; None where there are none.
    #[getter]
    fn emitter_force<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        let added = this.get().emitter_force.iter();
        let arrays: Vec<_> = added
            .map(|(block, place)| typed!(this.get().precision, view(this, block, place)))
            .collect();
        (!arrays.is_empty())
            .then(|| PyTuple::new(this.py(), arrays))
            .transpose()
    }

    /// Velocities 1 .. steps - 1 as they lie in the solver's memory: nothing is copied. Each cell has its low face, so that the last
    /// walls are left out; times velocity_unit they are in the scene's units.
    #[getter]
    fn velocity_in_place<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        in_place(this, this.get().components(&VELOCITY))
    }

    /// Forces as they lie in the solver's memory, as velocity_in_place; times force_unit they are in the scene's units.
    #[getter]
    fn force_in_place<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        in_place(this, this.get().components(&FORCE))
    }

    /// length / dt.
    #[getter]
    fn velocity_unit(&self) -> f64 {
        self.unit(&VELOCITY)
    }

    /// length / dt^2.
    #[getter]
    fn force_unit(&self) -> f64 {
        self.unit(&FORCE)
    }

    /// The objective: data_term + force_term.
    #[getter]
    fn objective(&self) -> f64 {
        self.objective.total()
    }

    /// Distance from the keyframes.
    #[getter]
    fn data_term(&self) -> f64 {
        self.objective.data
    }

    /// Price of the force.
    #[getter]
    fn force_term(&self) -> f64 {
        self.objective.force
    }

    /// "converged", "max_iterations", "stalled" or "cancelled".
    #[getter]
    fn status(&self) -> &'static str {
        self.ended.status.name()
    }

    /// All iterations.
    #[getter]
    fn history(&self) -> Vec<Iteration> {
        self.ended.history.clone()
    }

    /// Steps of the keyframes, ascending.
    #[getter]
    fn keyframe_steps(&self) -> Vec<usize> {
        self.errors.iter().map(|error| error.stay.first).collect()
    }

    /// How far the densities are from each keyframe: |R (rho - rho*)| / |R rho*| with its region R, 1 where there is none.
    #[getter]
    fn keyframe_errors(&self) -> Vec<f64> {
        self.errors.iter().map(|error| error.after).collect()
    }

    /// How far the source, held still, is from each keyframe.
    #[getter]
    fn keyframe_errors_before(&self) -> Vec<f64> {
        self.errors.iter().map(|error| error.before).collect()
    }

    /// The templates of the force as they were found: a list of dicts with the keys that they are given by, an amplitude for each interval.
    #[getter]
    fn templates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        crate::templates::listed(py, &self.templates)
    }

    /// Sentences about what the status alone does not say, as that the smoke came no nearer; mostly none.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// By how much each keyframe was scaled to the mass of the smoke at its step.
    #[getter]
    fn mass_factors(&self) -> Vec<f64> {
        self.mass_factors.clone()
    }

    /// Bytes of the one block in which it was solved, which the solution holds on to.
    #[getter]
    fn planned_bytes(&self) -> usize {
        self.planned_bytes
    }

    /// Threads on which it was solved.
    #[getter]
    fn threads(&self) -> usize {
        self.threads
    }

    fn __repr__(&self) -> String {
        let (status, iterations) = (self.status(), self.ended.history.len());
        let [before, after] = largest(&self.errors);
        format!(
            "<thurible_smoke.Solution: {status} after {iterations} iterations, objective {:.5e}, largest keyframe error {:.1} % (before {:.1} %), {} bytes>",
            self.objective(),
            100.0 * after,
            100.0 * before,
            grouped(self.planned_bytes)
        )
    }
}

impl Solution {
    /// The components of an output; none where the method does not give it.
    fn components(&self, output: &Output) -> &[Component] {
        let found = self.fields.iter().find(|field| field.output == *output);
        found.map_or(&[], |field| &field.components)
    }

    /// The scene's unit of an output in the block.
    fn unit(&self, output: &Output) -> f64 {
        self.components(output).first().map_or(1.0, Component::unit)
    }
}

/// Something that the method gives: a field for each of many steps.
#[pyclass(frozen, module = "thurible_smoke", name = "Output")]
pub struct Given {
    solution: Py<Solution>,
    index: usize,
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

/// An array over `block`, which the solution owns.
fn view<'py, T: Number>(this: &Bound<'py, Solution>, block: &Block, place: &Place) -> Bound<'py, PyAny> {
    place.array::<T>(block, this.as_any()).into_any()
}

/// What was found of a component, as it lies in the block.
fn lying<'py, T: Number>(this: &Bound<'py, Solution>, component: &Component) -> Option<Bound<'py, PyAny>> {
    let place = component.in_place::<T>()?;
    Some(view::<T>(this, &this.get().block, &place))
}

fn in_place<'py>(this: &Bound<'py, Solution>, components: &[Component]) -> PyResult<Bound<'py, PyTuple>> {
    let arrays: Vec<_> = components
        .iter()
        .filter_map(|component| typed!(this.get().precision, lying(this, component)))
        .collect();
    PyTuple::new(this.py(), arrays)
}

/// A component as files have it.
fn in_order<'py, T: Number>(this: &Bound<'py, Solution>, component: &Component) -> Option<Bound<'py, PyAny>> {
    let (block, place) = component.filed::<T>(&this.get().block)?;
    Some(view::<T>(this, block, place))
}

fn filed<'py>(this: &Bound<'py, Solution>, components: &[Component]) -> PyResult<Bound<'py, PyTuple>> {
    let precision = this.get().precision;
    let arrays: Option<Vec<_>> = components
        .iter()
        .map(|component| typed!(precision, in_order(this, component)))
        .collect();
    let arrays = arrays.ok_or_else(|| {
        PyMemoryError::new_err(
            "the system has not the memory for these arrays; use those with _in_place, which take none",
        )
    })?;
    PyTuple::new(this.py(), arrays)
}
