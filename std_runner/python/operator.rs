//! `Operator`: a simulation that can be differentiated, on NumPy's arrays.

use crate::arrays::{array, flags, numbers};
use crate::block::Block;
use crate::choices::Choices;
use crate::effects;
use crate::inputs::unusable;
use crate::operating::About;
use crate::plan::{Precision, precision};
use crate::simulating::{Any, Chosen, Planned, STEERS, each};
use crate::steering::OF_FACES;
use crate::words::{read, refused, whole};
use crate::worked::Gradient;
use core::mem::MaybeUninit;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use thurible::bytes::grouped;

/// A simulation as an operator, for arrays of `shape`, whose last axis is x, over `steps` steps, and its exact adjoint in planned memory.
///
/// `simulate` gives densities and velocities, `vjp` what a scalar function of them gets by where they begin and by what pushes them. The way back
/// keeps `slots` states, by default as many as memory_limit holds; how many changes time and memory, and no bit. `solver` is "implicit", on the
/// staggered grid, or "stable_fluids", with everything at the centres of cells and `options` of its own.
#[pyclass(module = "thurible_smoke", name = "Operator", weakref)]
pub struct PyOperator {
    // Before the block, in which it lives.
    any: Any,
    about: About,
    plan: Planned,
    _block: Block,
}

/// What an operator does not have.
const CONTROL: [&str; 11] = [
    "method",
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
    #[pyo3(signature = (shape, steps, **choices), text_signature = "(shape, steps, *, dtype='float64', dt=1.0, length=1.0, boundary='wall', viscosity=0.0, slip=True, buoyancy=0.0, emitters=None, templates=None, solids=None, advection='limited', advection_tolerance=1e-05, projection_tolerance=1e-05, solver='implicit', options=None, tolerance=1e-10, slots='auto', threads=None, memory_limit=None)")]
    fn new(
        shape: &Bound<'_, PyAny>,
        steps: &Bound<'_, PyAny>,
        choices: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let py = shape.py();
        let steps = whole("steps", steps)?;
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
                return Err(refused(name, STEERS));
            }
        }
        given.set_item("steps", steps)?;
        let emitters = effects::emitters(Some(&given))?;
        let chosen =
            Chosen::read(["solver", "tolerance", "slots", "options"].map(|name| taken(&given, name)))?;
        for name in OF_FACES {
            if chosen.has_centers() && given.contains(name)? {
                let why = "is of the solver \"implicit\"; Stable Fluids have their own transport and pressure (`options`): take it out";
                return Err(refused(name, why));
            }
        }
        let (choices, [dtype]) = Choices::read(&shape, Vec::new(), &emitters, Some(&given), ["dtype"])?;
        let precision = dtype.map_or(Ok(Precision::Double), |dtype| precision(&dtype))?;
        let plan = Planned::new(&choices, chosen, precision)?;
        let remedy = "give a smaller memory_limit, fewer slots, or fewer cells";
        let mut block = Block::planned(plan.bytes, "the operator", remedy)?;
        let memory = block.bytes_mut();
        // SAFETY: the bytes stay where they are until the block is dropped, which is after the operator, the only one to use them.
        let memory: &'static mut [MaybeUninit<u8>] =
            unsafe { core::slice::from_raw_parts_mut(memory.as_mut_ptr(), memory.len()) };
        let any = plan.make(&choices, precision, memory)?;
        let scene = &choices.scene;
        let mut operator = Self {
            any,
            about: About {
                shape,
                steps,
                boundary: scene.boundary.clone(),
                centers: chosen.has_centers(),
                precision,
                forces: Vec::new(),
                runs: 0,
                simulated: false,
                pushes: scene
                    .emitters
                    .iter()
                    .map(|emitter| emitter.velocity.is_some())
                    .collect(),
                threads: plan.threads,
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
        self.plan.bytes
    }

    /// States that are kept; 0 where Stable Fluids keeps all that its adjoint reads.
    #[getter]
    fn slots(&self) -> usize {
        self.plan.slots
    }

    /// Bytes with one state more; None where every step has one.
    #[getter]
    fn next_slot_bytes(&self) -> Option<usize> {
        self.plan.next
    }

    /// Steps that a gradient repeats beside the one for each step that it takes back, the simulation counted.
    #[getter]
    fn repeated_steps(&self) -> usize {
        self.plan.repeated
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
            grouped(self.plan.bytes),
            self.plan.slots,
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
        each!(&mut self.any, one => about.run(py, one.as_mut(), density, velocity, forces, at))
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
        each!(&mut self.any, one => about.back(py, one.as_mut(), density, velocity))
    }
}

/// An argument, taken out of the others.
fn taken<'py>(given: &Bound<'py, PyDict>, name: &str) -> Option<Bound<'py, PyAny>> {
    let value = given.get_item(name).ok().flatten()?;
    given.del_item(name).ok()?;
    (!value.is_none()).then_some(value)
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
