//! An iteration, as callbacks and the history have it.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use thurible_core::{Fact, Kind, Progress};

/// What one iteration did.
#[pyclass(frozen, module = "thurible_smoke", name = "Progress")]
#[derive(Clone, Debug)]
pub struct Iteration {
    /// Iteration, from 1, those on coarser grids included.
    #[pyo3(get)]
    iteration: usize,
    /// Seconds since the solve began.
    #[pyo3(get)]
    seconds: f64,
    /// The objective: `data + force`.
    #[pyo3(get)]
    objective: f64,
    /// Distance from the keyframes.
    #[pyo3(get)]
    data: f64,
    /// Price of the force.
    #[pyo3(get)]
    force: f64,
    /// Cells along x, y (and z) of the grid that it worked on, where the method tells.
    #[pyo3(get)]
    cells: Option<Vec<usize>>,
    /// Step along the direction, of the direct method and L-BFGS; blending step of ADMM.
    #[pyo3(get)]
    step: Option<f64>,
    /// ADMM: largest change of the densities, in parts of the source's largest.
    #[pyo3(get)]
    density_change: Option<f64>,
    /// ADMM: max |v - v*| over max |v|.
    #[pyo3(get)]
    gap: Option<f64>,
    /// ADMM: the largest violation of the conditions of an optimum.
    #[pyo3(get)]
    kkt: Option<f64>,
    /// What the method reported, each fact with its values.
    facts: Vec<(Fact, Vec<f64>)>,
}

impl Iteration {
    pub(crate) fn new(progress: &Progress, seconds: f64) -> Self {
        let fact = |name: &str| progress.report.get(name);
        Self {
            iteration: progress.iteration,
            seconds,
            objective: progress.objective.total(),
            data: progress.objective.data,
            force: progress.objective.force,
            cells: (progress.level_iteration > 0)
                .then(|| progress.cells.into_iter().filter(|&count| count > 1).collect()),
            step: fact("step").or(fact("ao_step")),
            density_change: fact("density_change"),
            gap: fact("gap"),
            kkt: fact("kkt"),
            facts: progress
                .report
                .iter()
                .map(|(fact, values)| (fact, values.to_vec()))
                .collect(),
        }
    }
}

impl Iteration {
    /// Whether it worked on the grid of these cells, where it says.
    pub fn is_on(&self, cells: &[usize]) -> bool {
        self.cells.as_deref().is_none_or(|own| own == cells)
    }

    /// The last value of a fact.
    pub fn fact(&self, name: &str) -> Option<f64> {
        let found = self.facts.iter().find(|(fact, _)| fact.name == name);
        found.and_then(|(_, values)| values.last().copied())
    }
}

#[pymethods]
impl Iteration {
    /// What the method reported, by name: a number, a count, a truth value, or a list of numbers.
    #[getter]
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let facts = PyDict::new(py);
        for (Fact { name, kind, .. }, values) in &self.facts {
            let value = values.first().copied().unwrap_or(f64::NAN);
            match kind {
                Kind::Number => facts.set_item(name, value)?,
                Kind::Count => facts.set_item(name, value as u64)?,
                Kind::Flag => facts.set_item(name, value != 0.0)?,
                Kind::Series => facts.set_item(name, values)?,
            }
        }
        Ok(facts)
    }

    /// What each of the facts is, in a few words, by name.
    #[getter]
    fn fact_words<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let words = PyDict::new(py);
        for (fact, _) in &self.facts {
            words.set_item(fact.name, fact.words)?;
        }
        Ok(words)
    }

    fn __repr__(&self) -> String {
        format!(
            "<thurible_smoke.Progress: iteration {}, objective {:.5e} = data {:.5e} + force {:.5e}>",
            self.iteration, self.objective, self.data, self.force
        )
    }
}
