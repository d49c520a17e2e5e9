//! What a search by Stable Fluids found, for Python.

use crate::iteration::Iteration;
use crate::place::Number;
use crate::templates::FoundTemplate;
use crate::watch::interruptible;
use crate::worked::room;
use core::ops::ControlFlow;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use thurible_core::{Fluids, Named, Space};

/// What a search by Stable Fluids found.
#[pyclass(frozen, get_all, module = "thurible_smoke", name = "StableFluids")]
pub struct Found {
    /// Densities, (steps + 1, (nz,) ny, nx).
    pub(crate) density: Py<PyAny>,
    /// Velocities at the centres of cells along x, y (and z), each of the shape of `density`.
    pub(crate) velocity: Py<PyTuple>,
    /// Forces there, (steps, (nz,) ny, nx) each.
    pub(crate) force: Py<PyTuple>,
    /// Templates as they were found, as they are given: an amplitude for each interval.
    pub(crate) templates: Py<PyList>,
    /// Distance from the keyframes.
    pub(crate) data_term: f64,
    /// Price of the force.
    pub(crate) force_term: f64,
    /// Price of the velocity at the start.
    pub(crate) initial_term: f64,
    /// All of them.
    pub(crate) objective: f64,
    /// Why it stopped.
    pub(crate) status: &'static str,
    /// All iterations.
    pub(crate) history: Vec<Iteration>,
    /// By how much each keyframe was scaled to the mass of the source.
    pub(crate) mass_factors: Vec<f64>,
    /// Bytes of the block.
    pub(crate) planned_bytes: usize,
    /// States that were kept; 0 where all that the adjoint reads was.
    pub(crate) slots: usize,
    /// Steps that a gradient repeats.
    pub(crate) repeated_steps: usize,
    /// Threads on which it ran.
    pub(crate) threads: usize,
}

#[pymethods]
impl Found {
    fn __repr__(&self) -> String {
        format!(
            "<thurible_smoke.StableFluids: {}, objective {:.5e}>",
            self.status, self.objective
        )
    }
}

/// A trajectory in arrays.
pub struct Arrays<T> {
    /// Densities.
    pub density: Vec<T>,
    /// Components of velocities.
    pub velocity: Vec<Vec<T>>,
    /// Components of forces.
    pub force: Vec<Vec<T>>,
}

/// The flow that was found, run once more.
pub fn replayed<T: Number, S: Space + Send>(
    py: Python<'_>,
    fluids: &mut Fluids<'_, T, S>,
    threads: usize,
) -> PyResult<Arrays<T>> {
    let (cells, steps) = (fluids.cells(), fluids.steps());
    let fields = |count: usize| {
        (0..S::DIM)
            .map(|_| room::<T>(count * cells))
            .collect::<PyResult<Vec<_>>>()
    };
    let mut arrays = Arrays {
        density: room(cells * (steps + 1))?,
        velocity: fields(steps + 1)?,
        force: fields(steps)?,
    };
    let part = |step: usize| step * cells..(step + 1) * cells;
    let written = &mut arrays;
    let done = interruptible(py, threads, |exec, observer| {
        fluids.replay(exec, observer, &mut |mut moment| {
            let step = moment.step;
            written.density[part(step)].copy_from_slice(moment.density());
            for axis in 0..S::DIM {
                written.velocity[axis][part(step)].copy_from_slice(moment.velocity(axis));
                if let Some(force) = moment.force(axis) {
                    written.force[axis][part(step - 1)].copy_from_slice(force);
                }
            }
            ControlFlow::Continue(())
        })
    })?;
    done.map_err(|status| {
        PyRuntimeError::new_err(format!("the result could not be read: {}", status.name()))
    })?;
    Ok(arrays)
}

/// All templates, as they are now.
pub fn found_templates<T: Number, S: Space>(fluids: &mut Fluids<'_, T, S>) -> Vec<FoundTemplate> {
    let mut all = Vec::new();
    while let Some(found) = fluids.template(all.len()) {
        let index = all.len();
        let amplitudes = (0..found.intervals).map(|interval| {
            let amplitude = fluids.template_amplitude(index, interval).unwrap_or_default();
            amplitude.into_iter().take(found.numbers).collect()
        });
        all.push(FoundTemplate {
            template: found.template,
            amplitudes: amplitudes.collect(),
            dims: S::DIM,
        });
    }
    all
}
