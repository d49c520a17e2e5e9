//! What was found, in memory that NumPy's arrays borrow.

use crate::block::Block;
use crate::place::{Component, Number, Place, Places};
use crate::plan::Precision;
use crate::watch::{Ended, Iteration};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::OnceLock;
use thurible::bytes::grouped;
use thurible::remarks::{KeyframeError, largest};
use thurible_core::{Named, Objective};

/// A result. Its arrays cannot be written to and keep it alive; copy what you want to change.
#[pyclass(frozen, module = "thurible")]
pub struct Solution {
    pub(crate) block: Block,
    pub(crate) places: Places,
    pub(crate) precision: Precision,
    pub(crate) velocity: [OnceLock<(Block, Place)>; 3],
    pub(crate) force: [OnceLock<(Block, Place)>; 3],
    pub(crate) objective: Objective,
    pub(crate) ended: Ended,
    pub(crate) mass_factors: Vec<f64>,
    pub(crate) errors: Vec<KeyframeError>,
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
    /// Densities, of shape (steps + 1, (nz,) ny, nx).
    #[getter]
    fn density<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        let Self {
            precision,
            places,
            block,
            ..
        } = this.get();
        typed!(precision, view(this, block, &places.density))
    }

    /// Velocities along x, y (and z), of shape (steps, (nz,) ny, nx), and on a wall axis one more along it. The arrays are made when
    /// they are first asked for, and stay.
    #[getter]
    fn velocity<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        filed(this, &this.get().places.velocity, &this.get().velocity)
    }

    /// Forces along x, y (and z), as velocities, of steps - 1 entries: entry k turns velocity k into velocity k + 1.
    #[getter]
    fn force<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        filed(this, &this.get().places.force, &this.get().force)
    }

    /// Velocities 1 .. steps - 1 as they lie in the solver's memory: nothing is copied. Each cell has its low face, so that the last
    /// walls are left out; times velocity_unit they are in the scene's units.
    #[getter]
    fn velocity_in_place<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        in_place(this, &this.get().places.velocity)
    }

    /// Forces as they lie in the solver's memory, as velocity_in_place; times force_unit they are in the scene's units.
    #[getter]
    fn force_in_place<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        in_place(this, &this.get().places.force)
    }

    /// length / dt.
    #[getter]
    fn velocity_unit(&self) -> f64 {
        self.places
            .velocity
            .first()
            .map_or(1.0, |component| component.rest.unit)
    }

    /// length / dt^2.
    #[getter]
    fn force_unit(&self) -> f64 {
        self.places
            .force
            .first()
            .map_or(1.0, |component| component.rest.unit)
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
        self.errors.iter().map(|error| error.step).collect()
    }

    /// How far the densities are from each keyframe: |rho - rho*| / |rho*|.
    #[getter]
    fn keyframe_errors(&self) -> Vec<f64> {
        self.errors.iter().map(|error| error.after).collect()
    }

    /// How far the source, held still, is from each keyframe.
    #[getter]
    fn keyframe_errors_before(&self) -> Vec<f64> {
        self.errors.iter().map(|error| error.before).collect()
    }

    /// Sentences about what the status alone does not say, as that nothing moved; mostly none.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// By how much each keyframe was scaled to the mass of the source.
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
            "<thurible.Solution: {status} after {iterations} iterations, objective {:.5e}, largest keyframe error {:.1} % (before {:.1} %), {} bytes>",
            self.objective(),
            100.0 * after,
            100.0 * before,
            grouped(self.planned_bytes)
        )
    }
}

/// An array over `block`, which the solution owns.
fn view<'py, T: Number>(this: &Bound<'py, Solution>, block: &Block, place: &Place) -> Bound<'py, PyAny> {
    place.array::<T>(block, this.as_any()).into_any()
}

fn in_place<'py>(this: &Bound<'py, Solution>, components: &[Component]) -> PyResult<Bound<'py, PyTuple>> {
    let Solution { precision, block, .. } = this.get();
    PyTuple::new(
        this.py(),
        components
            .iter()
            .map(|component| typed!(precision, view(this, block, &component.rest)))
            .collect::<Vec<_>>(),
    )
}

fn filed<'py>(
    this: &Bound<'py, Solution>,
    components: &[Component],
    files: &[OnceLock<(Block, Place)>; 3],
) -> PyResult<Bound<'py, PyTuple>> {
    let Solution { precision, block, .. } = this.get();
    let file = |component, file| {
        typed!(precision, file_of(component, block, file))
            .map(|(block, place)| typed!(precision, view(this, block, place)))
    };
    let arrays: Option<Vec<_>> = components
        .iter()
        .zip(files)
        .map(|(component, kept)| file(component, kept))
        .collect();
    let arrays = arrays.ok_or_else(|| {
        PyMemoryError::new_err(
            "the system has not the memory for these arrays; use those with _in_place, which take none",
        )
    })?;
    PyTuple::new(this.py(), arrays)
}

/// The file of a component, made if nobody has asked for it before.
fn file_of<'a, T: Number>(
    component: &Component,
    block: &Block,
    kept: &'a OnceLock<(Block, Place)>,
) -> Option<&'a (Block, Place)> {
    match kept.get() {
        Some(file) => Some(file),
        None => {
            let file = component.filed::<T>(block)?;
            Some(kept.get_or_init(|| file))
        }
    }
}
