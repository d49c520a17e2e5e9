//! `Operator`: a simulation that can be differentiated, on NumPy's arrays.

use crate::block::Block;
use crate::choices::Choices;
use crate::effects;
use crate::inputs::{array, flags, numbers, unusable};
use crate::operating::About;
use crate::place::Number;
use crate::plan::{Precision, precision};
use crate::words::{automatic, number, plan_refused, read, refused};
use crate::worked::Gradient;
use core::mem::MaybeUninit;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use thurible::bytes::{self, grouped};
use thurible::owned::OwnedProblem;
use thurible::threads;
use thurible_core::{D2, D3, OperatorParams, OperatorPlan, PlanError, Space};

/// An operator of either precision in either dimension.
enum Any {
    Plane32(thurible_core::Operator<'static, f32, D2>),
    Plane64(thurible_core::Operator<'static, f64, D2>),
    Space32(thurible_core::Operator<'static, f32, D3>),
    Space64(thurible_core::Operator<'static, f64, D3>),
}

/// Calls `$work` with the operator, whatever it is.
macro_rules! each {
    ($any:expr, $one:ident => $work:expr) => {
        match $any {
            Any::Plane32($one) => $work,
            Any::Plane64($one) => $work,
            Any::Space32($one) => $work,
            Any::Space64($one) => $work,
        }
    };
}

/// A simulation as an operator, for arrays of `shape`, whose last axis is x, over `steps` steps, and its exact adjoint in planned memory.
///
/// `simulate` gives densities and velocities, `vjp` what a scalar function of them gets by where they begin and by what pushes them. The way back
/// keeps `slots` states, by default as many as memory_limit holds; how many changes time and memory, and no bit.
#[pyclass(module = "thurible_smoke", name = "Operator", weakref)]
pub struct PyOperator {
    // Before the block, in which it lives.
    any: Any,
    about: About,
    plan: OperatorPlan,
    _block: Block,
}

/// What an operator does not have.
const CONTROL: [&str; 12] = [
    "method",
    "options",
    "iterations",
    "force_weight",
    "smoothness",
    "schedule",
    "mask",
    "weights",
    "regions",
    "release",
    "filters",
    "match_mass",
];

#[pymethods]
impl PyOperator {
    #[new]
    #[pyo3(signature = (shape, steps, **choices), text_signature = "(shape, steps, *, dtype='float64', dt=1.0, length=1.0, boundary='wall', viscosity=0.0, buoyancy=0.0, emitters=None, templates=None, solids=None, advection='limited', advection_tolerance=1e-05, projection_tolerance=1e-05, tolerance=1e-10, slots='auto', threads=None, memory_limit=None)")]
    fn new(shape: &Bound<'_, PyAny>, steps: usize, choices: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let py = shape.py();
        let shape: Vec<usize> = read(
            "shape",
            shape,
            "a tuple of whole numbers, as the shape of a density",
        )?;
        if !(2..=3).contains(&shape.len()) {
            let why = format!("has {} axes; give (ny, nx) or (nz, ny, nx)", shape.len());
            return Err(refused("shape", why));
        }
        let given = choices.map_or_else(|| Ok(PyDict::new(py)), |choices| choices.copy())?;
        for name in CONTROL {
            if given.contains(name)? {
                let why = "steers, and an operator steers nothing; take it out";
                return Err(refused(name, why));
            }
        }
        given.set_item("steps", steps)?;
        let emitters = effects::emitters(Some(&given))?;
        let others = ["dtype", "tolerance", "slots"];
        let (choices, [dtype, tolerance, slots]) =
            Choices::read(&shape, Vec::new(), &emitters, Some(&given), others)?;
        let precision = dtype.map_or(Ok(Precision::Double), |dtype| precision(&dtype))?;
        let mut params = OperatorParams::default();
        if let Some(tolerance) = tolerance {
            params.tolerance = number("tolerance", &tolerance)?;
        }
        if let Some(slots) = slots {
            params.slots = automatic("slots", &slots)?;
        }
        let plan = plan(&choices, &mut params, precision)?;
        let short = || {
            PyMemoryError::new_err(format!(
                "the system has not the {} bytes that the operator needs",
                grouped(plan.bytes())
            ))
        };
        let mut block = Block::new(plan.bytes()).ok_or_else(short)?;
        let memory = block.bytes_mut();
        // SAFETY: the bytes stay where they are until the block is dropped, which is after the operator, the only one to use them.
        let memory: &'static mut [MaybeUninit<u8>] =
            unsafe { core::slice::from_raw_parts_mut(memory.as_mut_ptr(), memory.len()) };
        let scene = &choices.scene;
        let any = match (shape.len(), precision) {
            (2, Precision::Single) => Any::Plane32(made(scene, &params, memory)?),
            (2, Precision::Double) => Any::Plane64(made(scene, &params, memory)?),
            (_, Precision::Single) => Any::Space32(made(scene, &params, memory)?),
            (_, Precision::Double) => Any::Space64(made(scene, &params, memory)?),
        };
        let mut operator = Self {
            any,
            about: About {
                shape,
                steps,
                boundary: scene.boundary.clone(),
                precision,
                forces: Vec::new(),
                runs: 0,
                pushes: scene
                    .emitters
                    .iter()
                    .map(|emitter| emitter.velocity.is_some())
                    .collect(),
                threads: params.threads,
            },
            plan,
            _block: block,
        };
        operator.fill(&given, &emitters)?;
        Ok(operator)
    }

    /// Bytes of the operator's block.
    #[getter]
    fn planned_bytes(&self) -> usize {
        self.plan.bytes()
    }

    /// States that are kept.
    #[getter]
    fn slots(&self) -> usize {
        self.plan.slots()
    }

    /// Bytes with one state more; None where every step has one.
    #[getter]
    fn next_slot_bytes(&self) -> Option<usize> {
        self.plan.next_slot()
    }

    /// Steps that a gradient repeats beside the one for each step that it takes back, the simulation counted.
    #[getter]
    fn repeated_steps(&self) -> usize {
        self.plan.repeated_steps()
    }

    /// Steps.
    #[getter]
    fn steps(&self) -> usize {
        self.about.steps
    }

    /// Simulations that were begun, by which a program knows whether the last one is its own.
    #[getter]
    fn runs(&self) -> usize {
        self.about.runs
    }

    /// Shape of a density.
    #[getter]
    fn shape<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.about.shape)
    }

    /// Shapes of the components of a velocity or force, along x, y (and z).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let shapes: PyResult<Vec<_>> = (0..self.about.shape.len())
            .map(|axis| PyTuple::new(py, self.about.faces_of(axis)))
            .collect();
        PyTuple::new(py, shapes?)
    }

    /// "float32" or "float64".
    #[getter]
    fn dtype(&self) -> &'static str {
        match self.about.precision {
            Precision::Single => "float32",
            Precision::Double => "float64",
        }
    }

    fn __repr__(&self) -> String {
        format!(
            "<thurible_smoke.Operator: {:?}, {} steps, {}, {} bytes, {} of {} states kept>",
            self.about.shape,
            self.about.steps,
            self.dtype(),
            grouped(self.plan.bytes()),
            self.plan.slots(),
            self.about.steps
        )
    }

    /// Densities (steps + 1, ny, nx) and velocities, a tuple by axis of (steps + 1, faces), from density, velocity (a tuple by axis, at rest where
    /// it is None; it is projected) and forces, a tuple by axis of (steps, faces). Of the steps in the list `at` alone, if there is one.
    ///
    /// The forces are borrowed, not copied, where they lie in order: leave them as they are until `vjp` was called. Raises FloatingPointError
    /// where a flow is too fast.
    #[pyo3(signature = (density, velocity=None, forces=None, *, at=None))]
    fn simulate<'py>(
        &mut self,
        py: Python<'py>,
        density: &Bound<'py, PyAny>,
        velocity: Option<&Bound<'py, PyAny>>,
        forces: Option<&Bound<'py, PyAny>>,
        at: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let about = &mut self.about;
        each!(&mut self.any, one => about.run(py, one, density, velocity, forces, at))
    }

    /// The gradient of a scalar function of the last simulation, by its covectors: what it gets by density, (steps + 1, ny, nx), and by velocity,
    /// a tuple by axis; None is 0. A dict {step: array}, or {step: tuple}, gives those of single steps. `forces` is None where the simulation
    /// was given none.
    #[pyo3(signature = (density=None, velocity=None))]
    fn vjp<'py>(
        &mut self,
        py: Python<'py>,
        density: Option<&Bound<'py, PyAny>>,
        velocity: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Gradient> {
        let about = &self.about;
        each!(&mut self.any, one => about.back(py, one, density, velocity))
    }
}

/// An operator in memory.
fn made<T: Number, S: Space>(
    scene: &OwnedProblem,
    params: &OperatorParams,
    memory: &'static mut [MaybeUninit<u8>],
) -> PyResult<thurible_core::Operator<'static, T, S>> {
    let made = thurible_core::Operator::new(&scene.problem(), params, memory);
    made.map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Plans under the ceiling, on fewer threads if that is what it takes and nobody asked for a number.
fn plan(choices: &Choices, params: &mut OperatorParams, precision: Precision) -> PyResult<OperatorPlan> {
    params.ceiling = choices.memory_limit.or_else(bytes::of_machine);
    params.threads = choices.threads.unwrap_or_else(threads::available);
    let problem = choices.scene.problem();
    loop {
        let planned = match (choices.scene.cells.len(), precision) {
            (2, Precision::Single) => OperatorPlan::new::<f32, D2>(&problem, params),
            (2, Precision::Double) => OperatorPlan::new::<f64, D2>(&problem, params),
            (_, Precision::Single) => OperatorPlan::new::<f32, D3>(&problem, params),
            (_, Precision::Double) => OperatorPlan::new::<f64, D3>(&problem, params),
        };
        match planned {
            Err(PlanError::Ceiling { needed, ceiling })
                if choices.threads.is_some() || params.threads <= 1 =>
            {
                return Err(PyMemoryError::new_err(format!(
                    "the operator needs {} bytes, and memory_limit or the machine allows {}; raise memory_limit, keep fewer slots, or take fewer cells",
                    grouped(needed),
                    grouped(ceiling)
                )));
            }
            Err(PlanError::Ceiling { .. }) => params.threads /= 2,
            other => return other.map_err(plan_refused),
        }
    }
}

impl PyOperator {
    /// Sets solid cells and emitters.
    fn fill(&mut self, given: &Bound<'_, PyDict>, emitters: &[effects::Given<'_>]) -> PyResult<()> {
        let (about, any) = (&self.about, &mut self.any);
        let common = about.common(about.shape.clone(), None);
        if let Some(solids) = given.get_item("solids")?.filter(|solids| !solids.is_none()) {
            let solids = flags("solids", &solids, &common)?;
            each!(&mut *any, one => one.set_solids(&solids)).map_err(|error| unusable("solids", error))?;
        }
        for (index, emitter) in emitters.iter().enumerate() {
            let (field, shape) = emitter.shape()?;
            each!(&mut *any, one => {
                let shape = array(&field, &shape, &common)?;
                one.set_emitter(index, &numbers(&shape)?)
            })
            .map_err(|error| unusable(&field, error))?;
        }
        Ok(())
    }
}
