//! `solve`: from arguments to a [`Solution`].

use crate::arrays::Common;
use crate::block::Block;
use crate::choices::Choices;
use crate::effects;
use crate::inputs::{self, Inputs};
use crate::iterated::Kept;
use crate::keep::{self, States};
use crate::place::{self, Number, Place, fields};
use crate::plan::{self, Planned, Precision};
use crate::solution::Solution;
use crate::templates;
use crate::watch;
use crate::words::refused;
use pyo3::exceptions::{PyFloatingPointError, PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use thurible::bytes::grouped;
use thurible::remarks::{OF_PYTHON, faint, keyframe_errors, or_else, remarks, still_falls};
use thurible_core::{D2, D3, Method, Solver, SolverError, Space, Status};

/// Finds the smallest force that carries the smoke of `source` to `keyframes`, a dict {step: array} or pairs (step, array).
///
/// The dtype of `source`, float32 or float64, is the precision of the solve; its shape, (ny, nx) or (nz, ny, nx), is the grid. It may be
/// None where `emitters`, dicts with a shape each, make all smoke.
/// The state is kept in the file `checkpoint` every `checkpoint_every` seconds, and `resume` names one to go on from, bit for bit.
/// `progress` is called after every iteration with a Progress; it stops the solve by returning False, or by raising. Other Python
/// threads run meanwhile. Raises ValueError or TypeError for what cannot be used, MemoryError for what does not fit in memory_limit
/// bytes, FloatingPointError when the flow leaves the finite numbers.
#[pyfunction]
#[pyo3(signature = (source, keyframes, **choices), text_signature = "(source, keyframes, *, steps=None, dt=1.0, length=1.0, boundary='wall', viscosity=0.0, slip=True, buoyancy=0.0, emitters=None, templates=None, solids=None, force_weight=None, smoothness=None, schedule=None, mask=None, weights=None, regions=None, release=None, filters=None, match_mass=True, advection='limited', advection_tolerance=1e-05, projection_tolerance=1e-05, initial_velocity=None, reference=None, method=None, options=None, iterations=60, threads=None, memory_limit=None, progress=None, checkpoint=None, checkpoint_every=60.0, resume=None)")]
pub fn solve<'py>(
    source: &Bound<'py, PyAny>,
    keyframes: &Bound<'py, PyAny>,
    choices: Option<&Bound<'py, PyDict>>,
) -> PyResult<Solution> {
    let emitters = effects::emitters(choices)?;
    let common = inputs::common(source, &emitters)?;
    let keyframes = inputs::keyframes(keyframes)?;
    let steps: Vec<usize> = keyframes.iter().map(|(step, _)| *step).collect();
    let regions = effects::kept(choices, "regions")?;
    let solids = effects::argument(choices, "solids")?;
    let mask = effects::argument(choices, "mask")?;
    let [of_states, of_often, of_resume] = keep::ARGUMENTS;
    let (choices, [velocity, reference, progress, checkpoint, every, resume]) = Choices::read(
        &common.shape,
        steps.clone(),
        &emitters,
        choices,
        [
            "initial_velocity",
            "reference",
            "progress",
            of_states,
            of_often,
            of_resume,
        ],
    )?;
    let states = States::read([checkpoint, every, resume])?;
    if progress.as_ref().is_some_and(|progress| !progress.is_callable()) {
        return Err(refused(
            "progress",
            "cannot be called; give a function of one argument",
        ));
    }
    let planned = plan::choose(&choices, common.precision)?;
    let job = Job {
        inputs: Inputs {
            source: (!source.is_none()).then(|| source.clone()),
            solids,
            mask,
            emitters: emitters
                .iter()
                .map(effects::Given::shape)
                .collect::<PyResult<_>>()?,
            regions: match regions {
                Some(regions) => effects::regions(&regions, &steps)?,
                None => Vec::new(),
            },
            keyframes,
            velocity,
            reference,
        },
        common,
        choices,
        planned,
        progress,
        states,
    };
    let py = source.py();
    match (job.common.shape.len(), job.common.precision) {
        (2, Precision::Single) => job.solve::<f32, D2>(py),
        (2, Precision::Double) => job.solve::<f64, D2>(py),
        (_, Precision::Single) => job.solve::<f32, D3>(py),
        (_, Precision::Double) => job.solve::<f64, D3>(py),
    }
}

/// A solve that is ready to run.
struct Job<'py> {
    common: Common,
    choices: Choices,
    planned: Planned,
    inputs: Inputs<'py>,
    progress: Option<Bound<'py, PyAny>>,
    states: States,
}

impl Job<'_> {
    fn solve<T: Number, S: Space + Send>(self, py: Python<'_>) -> PyResult<Solution> {
        let Self {
            common,
            choices,
            planned: Planned { plan, params },
            inputs,
            progress,
            states,
        } = self;
        if params.method != Method::Guide && inputs.reference.is_some() {
            let why = "is what method=\"guide\" follows; take that method, or leave it out";
            return Err(refused("reference", why));
        }
        if params.method == Method::Guide && inputs.reference.is_none() {
            return Err(refused(
                "reference",
                "is missing, so that there is no flow to follow; give the velocity of a solution",
            ));
        }
        let planned_bytes = plan.bytes();
        let remedy = "give a smaller memory_limit, or fewer cells or steps";
        let mut block = Block::planned(planned_bytes, "the solve", remedy)?;
        let start = block.address();
        let mut solver = Solver::<T, S>::new(&choices.scene.problem(), &params, block.bytes_mut())
            .map_err(solver_refused)?;
        let periodic = choices.periodic();
        let mass_factors = inputs.set_inputs(&mut solver, &common, &periodic)?;
        let mut keep = states.begin(&mut solver)?;
        let callback = progress.map(Bound::unbind);
        let mut kept = Kept {
            one: &mut solver,
            keep: keep.as_mut(),
        };
        let ended = watch::solve(py, &mut kept, params.threads, callback);
        // What could not be kept is said of a solve that was interrupted too.
        if let Some(keep) = keep {
            keep.end(py)?;
        }
        let ended = ended?;
        if matches!(ended.status, Status::NotFinite | Status::NotReady) {
            return Err(PyFloatingPointError::new_err(
                "the solve left the finite numbers, or a flow was too fast to follow from the start; use float64, more steps or a slower initial_velocity",
            ));
        }
        let emission = if choices.scene.emitters.is_empty() {
            None
        } else {
            Some(emission(py, &mut solver, &common.shape, params.threads)?)
        };
        let emitter_force = emitter_force(&solver, &common.shape, &periodic)?;
        let fields = fields(&solver, start, &choices.scene.boundary);
        let objective = solver.objective();
        let errors = keyframe_errors(&solver, &choices.scene.problem());
        let gradients = ended
            .history
            .iter()
            .filter(|iteration| iteration.is_on(&choices.scene.cells));
        let falls = still_falls(
            ended.last,
            gradients.filter_map(|iteration| iteration.fact("gradient_norm")),
        );
        let said = remarks(
            &choices.scene.problem(),
            &params,
            ended.last,
            &errors,
            T::BYTES == size_of::<f64>(),
            &OF_PYTHON,
        );
        let mut said = or_else(said, falls);
        said.extend(faint(&choices.scene.problem(), &mass_factors, &OF_PYTHON));
        let templates = templates::found(&solver);
        drop(solver);
        Ok(Solution {
            fields,
            emission,
            emitter_force,
            precision: common.precision,
            objective,
            ended,
            mass_factors,
            errors,
            templates,
            remarks: said,
            planned_bytes,
            threads: params.threads,
            block,
        })
    }
}

/// What emitters added, computed with the interpreter released.
fn emission<T: Number, S: Space>(
    py: Python<'_>,
    solver: &mut Solver<'_, T, S>,
    shape: &[usize],
    threads: usize,
) -> PyResult<(Block, Place)> {
    let bytes = solver.steps() * shape.iter().product::<usize>() * T::BYTES;
    let added = py.detach(|| watch::on_threads(threads, |exec| place::emission(solver, shape, exec)))?;
    added.ok_or_else(|| no_memory(bytes))
}

/// What emitters with a velocity added beside the forces, along each axis; none where there are none. `shape` is that of a density.
fn emitter_force<T: Number, S: Space>(
    solver: &Solver<'_, T, S>,
    shape: &[usize],
    periodic: &[bool],
) -> PyResult<Vec<(Block, Place)>> {
    let along = |(axis, &periodic): (usize, &bool)| {
        let mut shape = shape.to_vec();
        let own = shape.iter_mut().rev().skip(axis).take(1);
        own.for_each(|count| *count += usize::from(!periodic));
        let bytes = (solver.steps() - 1) * shape.iter().product::<usize>() * T::BYTES;
        place::jets(solver, &shape, axis).ok_or_else(|| no_memory(bytes))
    };
    let axes = periodic.iter().enumerate().filter(|_| solver.has_jets());
    axes.map(along).collect()
}

fn no_memory(bytes: usize) -> PyErr {
    PyMemoryError::new_err(format!(
        "the system has not {} bytes; close other programs, or take fewer cells or steps",
        grouped(bytes)
    ))
}

fn solver_refused(error: SolverError) -> PyErr {
    PyRuntimeError::new_err(format!(
        "the solver refused its block of memory: {error}; this is a fault of thurible, please report it"
    ))
}
