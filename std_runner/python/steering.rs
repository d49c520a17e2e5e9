//! `stable_fluids`: a search by Stable Fluids.

use crate::arrays::{Common, array, density, numbers};
use crate::block::Block;
use crate::choices::{Choices, set_options};
use crate::effects;
use crate::inputs::{self, components, unusable};
use crate::iterated::Kept;
use crate::keep::{self, States};
use crate::place::Number;
use crate::plan::{Precision, under_ceiling};
use crate::steered::{Arrays, Found, found_templates, replayed};
use crate::templates::{self, FoundTemplate};
use crate::watch::{self, Ended};
use crate::words::{automatic, one_of, read, refused};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyFloatingPointError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use thurible_core::stable_fluids::{Control, Controls, Slots};
use thurible_core::{D2, D3, Fluids, FluidsParams, FluidsPlan, Named, Space, Status};

/// Searches for what carries the smoke of `source` through `keyframes` by Stable Fluids: `control` is one or several of "initial_velocity" (the default), "forces"
/// and "templates". Takes the arguments of `solve` that it knows, and `slots`; `options` are those of `[method.stable_fluids]`. `initial_velocity` is a tuple by
/// axis of arrays of the source's shape: everything is at the centres of cells. States are kept and gone on from as by `solve`.
#[pyfunction]
#[pyo3(signature = (source, keyframes, **choices), text_signature = "(source, keyframes, *, control='initial_velocity', steps=None, dt=1.0, length=1.0, boundary='wall', viscosity=0.0, buoyancy=0.0, templates=None, force_weight=None, weights=None, filters=None, match_mass=True, initial_velocity=None, options=None, slots='auto', iterations=60, threads=None, memory_limit=None, progress=None, checkpoint=None, checkpoint_every=60.0, resume=None)")]
pub fn stable_fluids<'py>(
    source: &Bound<'py, PyAny>,
    keyframes: &Bound<'py, PyAny>,
    choices: Option<&Bound<'py, PyDict>>,
) -> PyResult<Found> {
    let py = source.py();
    let common = inputs::common(source, &[])?;
    let keyframes = inputs::keyframes(keyframes)?;
    let given = choices.map_or_else(|| Ok(PyDict::new(py)), |choices| choices.copy())?;
    let options = effects::argument(Some(&given), "options")?;
    for name in ["method", "options"] {
        if given.contains(name)? {
            if name == "method" {
                return Err(refused(name, "is chosen by this function; take it out"));
            }
            given.del_item(name)?;
        }
    }
    for name in OF_FACES {
        if given.contains(name)? {
            let why = "is of the flow at faces; stable_fluids has its own transport and pressure (`options`): take it out";
            return Err(refused(name, why));
        }
    }
    let emitters = effects::emitters(Some(&given))?;
    let steps = keyframes.iter().map(|(step, _)| *step).collect();
    let [checkpoint, every, resume] = keep::ARGUMENTS;
    let others = [
        "control",
        "slots",
        "initial_velocity",
        "progress",
        checkpoint,
        every,
        resume,
    ];
    let (choices, [control, slots, velocity, progress, checkpoint, every, resume]) =
        Choices::read(&common.shape, steps, &emitters, Some(&given), others)?;
    if progress.as_ref().is_some_and(|progress| !progress.is_callable()) {
        let why = "cannot be called; give a function of one argument";
        return Err(refused("progress", why));
    }
    let states = States::read([checkpoint, every, resume])?;
    let mut params = FluidsParams {
        controls: control.map_or(Ok(Controls::default()), |control| controls(&control))?,
        iterations: choices.params.iterations,
        initial_velocity: velocity.is_some(),
        ..FluidsParams::default()
    };
    if let Some(options) = options {
        set_options(&mut params, &options)?;
    }
    let slots = slots.map_or(Ok(None), |slots| automatic("slots", &slots))?;
    let job = Job {
        source: source.clone(),
        keyframes,
        velocity,
        progress,
        params,
        slots: slots.map(Slots::of),
        states,
        choices,
        common,
    };
    match (job.common.shape.len(), job.common.precision) {
        (2, Precision::Single) => job.run::<f32, D2>(py),
        (2, Precision::Double) => job.run::<f64, D2>(py),
        (_, Precision::Single) => job.run::<f32, D3>(py),
        (_, Precision::Double) => job.run::<f64, D3>(py),
    }
}

/// What belongs to the solver of faces.
pub const OF_FACES: [&str; 3] = ["advection", "advection_tolerance", "projection_tolerance"];

/// A word, or a list of them.
fn controls(given: &Bound<'_, PyAny>) -> PyResult<Controls> {
    let words: Vec<Bound<'_, PyAny>> = if given.extract::<&str>().is_ok() {
        vec![given.clone()]
    } else {
        read("control", given, "a word, or a list of words")?
    };
    let mut controls = Controls::none();
    for word in &words {
        let word = one_of("control", word, Control::WORDS)?;
        let control = Control::ALL.iter().find(|control| control.name() == word);
        controls = control.map_or(controls, |&control| controls.with(control));
    }
    if controls.is_empty() {
        return Err(refused(
            "control",
            "is empty, so that nothing is searched for; give a word",
        ));
    }
    Ok(controls)
}

/// A search that is ready to run.
struct Job<'py> {
    source: Bound<'py, PyAny>,
    keyframes: Vec<(usize, Bound<'py, PyAny>)>,
    velocity: Option<Bound<'py, PyAny>>,
    progress: Option<Bound<'py, PyAny>>,
    params: FluidsParams,
    slots: Option<Slots>,
    states: States,
    choices: Choices,
    common: Common,
}

impl Job<'_> {
    /// Plans under the ceiling, on fewer threads if that is what it takes and nobody asked for a number.
    fn plan<T: Number, S: Space>(&self) -> PyResult<(FluidsParams, FluidsPlan)> {
        let problem = self.choices.scene.problem();
        under_ceiling(&self.choices, "search", |threads, limit| {
            let params = FluidsParams {
                threads,
                ..self.params
            };
            FluidsPlan::within::<T, S>(&problem, &params, self.slots, limit)
        })
    }

    fn run<T: Number, S: Space + Send>(self, py: Python<'_>) -> PyResult<Found> {
        let (params, plan) = self.plan::<T, S>()?;
        let problem = self.choices.scene.problem();
        let remedy = "give a smaller memory_limit, fewer slots, or fewer cells";
        let mut block = Block::planned(plan.bytes(), "the search", remedy)?;
        let mut fluids = Fluids::<T, S>::new(&problem, &params, block.bytes_mut())
            .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let mass_factors = self.fill(&mut fluids)?;
        let callback = self.progress.as_ref().map(|progress| progress.clone().unbind());
        let mut keep = self.states.begin(&mut fluids)?;
        let mut kept = Kept {
            one: &mut fluids,
            keep: keep.as_mut(),
        };
        let ended = watch::solve(py, &mut kept, params.threads, callback);
        // What could not be kept is said of a search that was interrupted too.
        if let Some(keep) = keep {
            keep.end(py)?;
        }
        let Ended {
            last,
            status,
            history,
        } = ended?;
        if last == Status::NotFinite && history.is_empty() || status == Status::NotReady {
            let why = "the search left the finite numbers at once; use float64, or a slower initial_velocity";
            return Err(PyFloatingPointError::new_err(why));
        }
        let arrays = replayed(py, &mut fluids, params.threads)?;
        let objective = fluids.objective();
        let found = found_templates(&mut fluids);
        self.found(py, arrays, &found, move |density, velocity, force, templates| {
            Found {
                density,
                velocity,
                force,
                templates,
                data_term: objective.data,
                force_term: objective.force,
                initial_term: objective.initial,
                objective: objective.total(),
                status: status.name(),
                history,
                mass_factors,
                planned_bytes: plan.bytes(),
                slots: params.slots.states(),
                repeated_steps: params.slots.repeated_steps(problem.steps),
                threads: params.threads,
            }
        })
    }

    /// Gives everything to the search; by how much keyframes were scaled.
    fn fill<T: Number, S: Space>(&self, fluids: &mut Fluids<'_, T, S>) -> PyResult<Vec<f64>> {
        let source = array::<T>("source", &self.source, &self.common)?;
        fluids
            .set_source(&density("source", &source)?)
            .map_err(|error| unusable("source", error))?;
        if let Some(velocity) = &self.velocity {
            for (axis, component) in components::<S>("initial_velocity", velocity)?.iter().enumerate() {
                let field = format!("initial_velocity[{axis}]");
                let component = array::<T>(&field, component, &self.common)?;
                fluids
                    .set_initial_velocity(axis, &numbers(&component)?)
                    .map_err(|error| unusable(&field, error))?;
            }
        }
        let each = self.keyframes.iter().enumerate().map(|(index, (step, target))| {
            let field = format!("keyframes[{step}]");
            let target = array::<T>(&field, target, &self.common)?;
            let set = fluids.set_keyframe(index, &density(&field, &target)?);
            set.map_err(|error| unusable(&field, error))
        });
        each.collect()
    }

    fn found<T: Number>(
        &self,
        py: Python<'_>,
        arrays: Arrays<T>,
        found: &[FoundTemplate],
        make: impl FnOnce(Py<PyAny>, Py<PyTuple>, Py<PyTuple>, Py<PyList>) -> Found,
    ) -> PyResult<Found> {
        let steps = self.choices.scene.steps;
        let shape = |count: usize| [vec![count], self.common.shape.clone()].concat();
        let tuple = |fields: Vec<Vec<T>>, count: usize| -> PyResult<Py<PyTuple>> {
            let arrays = fields
                .into_iter()
                .map(|field| PyArray1::from_vec(py, field).reshape(shape(count)));
            Ok(PyTuple::new(py, arrays.collect::<PyResult<Vec<_>>>()?)?.unbind())
        };
        let density = PyArray1::from_vec(py, arrays.density).reshape(shape(steps + 1))?;
        Ok(make(
            density.into_any().unbind(),
            tuple(arrays.velocity, steps + 1)?,
            tuple(arrays.force, steps)?,
            templates::listed(py, found)?.unbind(),
        ))
    }
}
