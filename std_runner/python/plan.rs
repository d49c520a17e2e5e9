//! How many bytes a solve takes.

use crate::choices::Choices;
use crate::effects;
use crate::words::{plan_refused, read, refused};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyInt};
use thurible::bytes::{self, grouped};
use thurible::threads;
use thurible_core::{D2, D3, Params, PlanError};

/// Precision of all numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// `float32`.
    Single,
    /// `float64`.
    Double,
}

/// The memory of a solve, to the byte.
#[pyclass(frozen, get_all, module = "thurible_smoke", name = "Plan")]
#[derive(Clone, Debug)]
pub struct Plan {
    /// Bytes of the whole block.
    bytes: usize,
    /// Bytes of the method: all but the keyframes.
    method_bytes: usize,
    /// What the paper's method may take, in bytes.
    paper_bound: usize,
    /// Threads planned for.
    threads: usize,
    /// Every buffer: its name, its bytes, its depth in the tree; groups come before what they hold.
    ledger: Vec<(&'static str, usize, usize)>,
}

#[pymethods]
impl Plan {
    fn __repr__(&self) -> String {
        format!(
            "<thurible_smoke.Plan: {} bytes on {} threads>",
            grouped(self.bytes),
            self.threads
        )
    }
}

/// A plan of the core's, and the parameters that it was made with.
pub struct Planned {
    /// The plan.
    pub plan: thurible_core::Plan,
    /// The parameters.
    pub params: Params,
}

/// Plans under the ceiling, on fewer threads if that is what it takes and nobody asked for a number.
pub fn choose(choices: &Choices, precision: Precision) -> PyResult<Planned> {
    let limit = choices.memory_limit.or_else(bytes::of_machine);
    let mut threads = choices.threads.unwrap_or_else(threads::available);
    loop {
        let planned = make(
            choices,
            precision,
            Params {
                threads,
                ceiling: limit,
                ..choices.params
            },
        )?;
        match limit {
            Some(limit) if planned.plan.bytes() > limit => {
                if choices.threads.is_some() || threads == 1 {
                    return Err(too_large(choices, precision, planned.plan.bytes(), limit));
                }
            }
            _ => return Ok(planned),
        }
        threads /= 2;
    }
}

/// What `plan` makes of a number of threads and the ceiling; of fewer threads if that is what it takes and nobody asked for a number.
pub fn under_ceiling<P>(
    choices: &Choices,
    what: &str,
    mut plan: impl FnMut(usize, Option<usize>) -> Result<P, PlanError>,
) -> PyResult<P> {
    let limit = choices.memory_limit.or_else(bytes::of_machine);
    let mut threads = choices.threads.unwrap_or_else(threads::available);
    loop {
        match plan(threads, limit) {
            Err(PlanError::Ceiling { needed, ceiling }) if choices.threads.is_some() || threads <= 1 => {
                return Err(PyMemoryError::new_err(format!(
                    "the {what} needs {} bytes, and memory_limit or the machine allows {}; raise memory_limit, keep fewer slots, or take fewer cells",
                    grouped(needed),
                    grouped(ceiling)
                )));
            }
            Err(PlanError::Ceiling { .. }) => threads /= 2,
            other => return other.map_err(plan_refused),
        }
    }
}

fn make(choices: &Choices, precision: Precision, params: Params) -> PyResult<Planned> {
    let problem = choices.scene.problem();
    let plan = match (choices.scene.cells.len(), precision) {
        (2, Precision::Single) => thurible_core::Plan::new::<f32, D2>(&problem, &params),
        (2, Precision::Double) => thurible_core::Plan::new::<f64, D2>(&problem, &params),
        (_, Precision::Single) => thurible_core::Plan::new::<f32, D3>(&problem, &params),
        (_, Precision::Double) => thurible_core::Plan::new::<f64, D3>(&problem, &params),
    };
    Ok(Planned {
        plan: plan.map_err(plan_refused)?,
        params,
    })
}

fn too_large(choices: &Choices, precision: Precision, needed: usize, limit: usize) -> PyErr {
    let whose = if choices.memory_limit.is_some() {
        "memory_limit allows"
    } else {
        "this machine has"
    };
    let narrower = if precision == Precision::Double {
        ", or give float32 arrays"
    } else {
        ""
    };
    let needed = grouped(needed);
    PyMemoryError::new_err(format!(
        "the solve needs {needed} bytes, but {whose} {}; raise memory_limit to {needed}{narrower}, or take fewer cells or steps",
        grouped(limit)
    ))
}

/// The memory that a solve of arrays of `shape` with keyframes at the steps `keyframes` takes; nothing is allocated. Takes the
/// arguments of `solve`, and dtype: "float32" or "float64"; emitters need no shape, and solids, mask and regions may be True.
#[pyfunction]
#[pyo3(signature = (shape, keyframes, **choices), text_signature = "(shape, keyframes, *, dtype='float32', steps=None, dt=1.0, length=1.0, boundary='wall', viscosity=0.0, slip=True, buoyancy=0.0, emitters=None, templates=None, solids=None, force_weight=None, smoothness=None, schedule=None, mask=None, weights=None, regions=None, release=None, filters=None, match_mass=True, advection='limited', advection_tolerance=1e-05, projection_tolerance=1e-05, method=None, options=None, iterations=60, threads=None, memory_limit=None)")]
pub fn plan(
    shape: &Bound<'_, PyAny>,
    keyframes: &Bound<'_, PyAny>,
    choices: Option<&Bound<'_, PyDict>>,
) -> PyResult<Plan> {
    let shape: Vec<usize> = read(
        "shape",
        shape,
        "a tuple of whole numbers, as the shape of the source",
    )?;
    if !(2..=3).contains(&shape.len()) {
        return Err(refused(
            "shape",
            format!("has {} axes; give (ny, nx) or (nz, ny, nx)", shape.len()),
        ));
    }
    let mut steps = Vec::new();
    let each = keyframes.try_iter().map_err(|_| {
        refused(
            "keyframes",
            "cannot be gone through; give the steps, as [6], or the dict that solve takes",
        )
    })?;
    for step in each {
        let step = step?;
        if !step.is_instance_of::<PyInt>() && step.hasattr("__len__")? {
            return Err(refused(
                "keyframes",
                "has more than steps; give the steps alone, or the dict that solve takes",
            ));
        }
        steps.push(read("keyframes", &step, "steps: whole numbers")?);
    }
    steps.sort_unstable();
    let emitters = effects::emitters(choices)?;
    let (choices, [dtype]) = Choices::read(&shape, steps, &emitters, choices, ["dtype"])?;
    let precision = match dtype {
        None => Precision::Single,
        Some(dtype) => precision(&dtype)?,
    };
    let Planned { plan, params } = choose(&choices, precision)?;
    Ok(Plan {
        bytes: plan.bytes(),
        method_bytes: plan.method_bytes(),
        paper_bound: plan.paper_bound(),
        threads: params.threads,
        ledger: plan
            .entries()
            .iter()
            .map(|entry| (entry.name, entry.bytes, entry.depth))
            .collect(),
    })
}

/// The precision of a NumPy dtype, or of what NumPy makes one of.
pub(crate) fn precision(dtype: &Bound<'_, PyAny>) -> PyResult<Precision> {
    let name: String = dtype
        .py()
        .import("numpy")?
        .getattr("dtype")?
        .call1((dtype,))?
        .getattr("name")?
        .extract()?;
    match name.as_str() {
        "float32" => Ok(Precision::Single),
        "float64" => Ok(Precision::Double),
        _ => Err(refused("dtype", format!("is {name}; give float32 or float64"))),
    }
}
