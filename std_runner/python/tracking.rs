//! Frames that are tracked, in a block and on threads of its own.

use crate::arrays::{Common, array, numbers};
use crate::block::Block;
use crate::inputs::unusable;
use crate::place::Number;
use crate::plan::Precision;
use crate::tracked::{Track, said};
use crate::watch::on_threads;
use crate::words::{plan_refused, refused};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::exceptions::{PyFloatingPointError, PyMemoryError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use std::time::Instant;
use thurible::bytes::{self, grouped};
use thurible::threads;
use thurible_core::track::Pair;
use thurible_core::{Boundary, Capture, Exec, Silent, Space, TrackParams, TrackPlan, Tracker};

/// Frames that are ready to be tracked.
pub struct Job<'py> {
    /// Of the array of frames.
    pub shape: Vec<usize>,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// How each axis ends.
    pub boundary: Vec<Boundary>,
    /// The longest side of the box.
    pub length: f64,
    /// The time between frames.
    pub dt: f64,
    /// What densities are multiplied by, or none: 10 / max.
    pub density_scale: Option<f64>,
    /// Acceleration upwards where the density is 1.
    pub buoyancy: f64,
    /// The flow of the first pair by component, or empty.
    pub initial_velocity: Vec<Bound<'py, PyAny>>,
    /// What was made between a frame and the next, where that is known.
    pub emission: Option<Bound<'py, PyAny>>,
    /// How it is tracked; threads are set here.
    pub params: TrackParams,
    /// Threads, or none: what the machine offers.
    pub threads: Option<usize>,
    /// Most bytes of the block, or none: what the machine has.
    pub memory_limit: Option<usize>,
}

/// What the pairs hand out: predicted, correction, velocity and force, by axis, and the density.
struct Found<T> {
    faces: [[Vec<T>; 3]; 4],
    density: Vec<T>,
    pairs: Vec<(f64, Pair)>,
}

impl<'py> Job<'py> {
    /// Tracks them.
    pub fn run<T: Number, S: Space>(
        mut self,
        frames: &Bound<'py, PyAny>,
        precision: Precision,
    ) -> PyResult<Track> {
        let py = frames.py();
        let common = Common {
            shape: self.shape.clone(),
            precision,
            of: "frames".into(),
        };
        let frames = array::<T>("frames", frames, &common)?;
        let frames = numbers(&frames)?;
        let density_scale = self.scale(&frames)?;
        let remarks = self.compare(&frames)?;
        let (cells, boundary) = (self.cells.clone(), self.boundary.clone());
        let mut acceleration = [0.0; 3];
        acceleration
            .iter_mut()
            .skip(S::DIM - 1)
            .take(1)
            .for_each(|up| *up = self.buoyancy);
        let capture = Capture {
            length: self.length,
            dt: self.dt,
            density_scale,
            buoyancy: acceleration,
            emission: self.emission.is_some(),
            ..Capture::new(&cells, &boundary)
        };
        let made = self.made::<T>(precision)?;
        let made = made.as_ref().map(numbers).transpose()?;
        let plan = self.plan::<T, S>(&capture)?;
        let remedy = "give a smaller memory_limit, or frames of fewer cells";
        let mut block = Block::planned(plan.bytes(), "tracking", remedy)?;
        let mut tracker = Tracker::<T, S>::new(&capture, &self.params, block.bytes_mut())
            .map_err(|error| refused("frames", error))?;
        self.begin(&mut tracker, precision)?;
        let mut found = self.room::<T>()?;
        let count = self.params.threads;
        let cell_count: usize = cells.iter().product();
        for (index, frame) in frames.chunks_exact(cell_count).enumerate() {
            let made = made.as_deref().zip(index.checked_sub(1));
            let made = made.and_then(|(made, pair)| made.chunks_exact(cell_count).nth(pair));
            py.check_signals()?;
            py.detach(|| {
                on_threads(count, |exec| {
                    advance(&mut tracker, exec, (frame, made), &mut found)
                })
            })??;
        }
        self.track(py, found, (density_scale, remarks), plan.bytes())
    }

    /// What was made between frames, as an array of its own shape.
    fn made<T: Number>(&self, precision: Precision) -> PyResult<Option<PyReadonlyArrayDyn<'py, T>>> {
        let Some(emission) = &self.emission else {
            return Ok(None);
        };
        let mut shape = self.shape.clone();
        shape.iter_mut().take(1).for_each(|frames| *frames -= 1);
        let common = Common {
            shape,
            precision,
            of: "frames".into(),
        };
        array::<T>("emission", emission, &common).map(Some)
    }

    /// Plans under the ceiling, on fewer threads if that is what it takes and nobody asked for a number.
    fn plan<T: Number, S: Space>(&mut self, capture: &Capture<'_>) -> PyResult<TrackPlan> {
        let limit = self.memory_limit.or_else(bytes::of_machine);
        self.params.threads = self.threads.unwrap_or_else(threads::available);
        loop {
            let plan = TrackPlan::new::<T, S>(capture, &self.params).map_err(plan_refused)?;
            let fits = limit.is_none_or(|limit| plan.bytes() <= limit);
            if fits {
                return Ok(plan);
            }
            if self.threads.is_some() || self.params.threads <= 1 {
                return Err(PyMemoryError::new_err(format!(
                    "tracking needs {} bytes, and memory_limit or the machine allows {}; raise memory_limit, or give frames of fewer cells",
                    grouped(plan.bytes()),
                    grouped(limit.unwrap_or_default())
                )));
            }
            self.params.threads /= 2;
        }
    }

    /// Faces across an axis, x last.
    fn faces(&self, axis: usize) -> Vec<usize> {
        let mut faces = self.cells.clone();
        let closed = self.boundary.get(axis) != Some(&Boundary::Periodic);
        faces
            .iter_mut()
            .skip(axis)
            .take(1)
            .for_each(|count| *count += usize::from(closed));
        faces.reverse();
        faces
    }

    /// Gives the flow of the first pair, where there is one.
    fn begin<T: Number, S: Space>(
        &self,
        tracker: &mut Tracker<'_, T, S>,
        precision: Precision,
    ) -> PyResult<()> {
        if !self.initial_velocity.is_empty() && self.initial_velocity.len() != S::DIM {
            let why = format!(
                "has {} entries, but must have one for each of {} axes",
                self.initial_velocity.len(),
                S::DIM
            );
            return Err(refused("initial_velocity", why));
        }
        for (axis, component) in self.initial_velocity.iter().enumerate() {
            let field = format!("initial_velocity[{axis}]");
            let common = Common {
                shape: self.faces(axis),
                precision,
                of: "frames".into(),
            };
            let component = array::<T>(&field, component, &common)?;
            let taken = tracker.set_initial_velocity(axis, &numbers(&component)?);
            taken.map_err(|error| unusable(&field, error))?;
        }
        Ok(())
    }

    /// Room for all results.
    fn room<T: Number>(&self) -> PyResult<Found<T>> {
        let (frames, dims) = (self.shape[0], self.cells.len());
        let cells: usize = self.cells.iter().product();
        let list = |count: usize| -> PyResult<Vec<T>> {
            let mut list = Vec::new();
            let room = list.try_reserve_exact(count);
            room.map_err(|_| {
                PyMemoryError::new_err("the system has not the memory for the results; give fewer frames")
            })?;
            Ok(list)
        };
        let mut faces: [[Vec<T>; 3]; 4] = Default::default();
        let forces = if self.params.forces { frames - 2 } else { 0 };
        for (part, count) in faces.iter_mut().zip([frames - 1, frames - 1, frames - 1, forces]) {
            for (axis, component) in part.iter_mut().enumerate().take(dims) {
                *component = list(count * self.faces(axis).iter().product::<usize>())?;
            }
        }
        Ok(Found {
            faces,
            density: list(if self.params.readvect { frames * cells } else { 0 })?,
            pairs: Vec::new(),
        })
    }

    fn track<T: Number>(
        &self,
        py: Python<'_>,
        found: Found<T>,
        (density_scale, remarks): (f64, Vec<String>),
        planned_bytes: usize,
    ) -> PyResult<Track> {
        let pairs = self.shape[0] - 1;
        let part = |components: [Vec<T>; 3], count: usize| -> PyResult<Py<PyTuple>> {
            let arrays = components.into_iter().enumerate().take(self.cells.len());
            let arrays = arrays.map(|(axis, values)| {
                let mut shape = vec![count];
                shape.extend(self.faces(axis));
                PyArray1::from_vec(py, values).reshape(shape)
            });
            Ok(PyTuple::new(py, arrays.collect::<PyResult<Vec<_>>>()?)?.unbind())
        };
        let [predicted, correction, velocity, force] = found.faces;
        let history = PyList::empty(py);
        for (frame, (seconds, pair)) in found.pairs.iter().enumerate() {
            history.append(said(py, frame, *seconds, pair, self.params.readvect)?)?;
        }
        Ok(Track {
            velocity: part(velocity, pairs)?,
            predicted: part(predicted, pairs)?,
            correction: part(correction, pairs)?,
            force: if self.params.forces {
                Some(part(force, pairs - 1)?)
            } else {
                None
            },
            density: if self.params.readvect {
                PyArray1::from_vec(py, found.density)
                    .reshape(self.shape.clone())?
                    .into_any()
                    .unbind()
            } else {
                py.None()
            },
            history: history.unbind(),
            density_scale,
            remarks,
            planned_bytes,
            threads: self.params.threads,
        })
    }
}

/// Gives a frame, and finds the flow of the pair that it ends.
fn advance<T: Number, S: Space>(
    tracker: &mut Tracker<'_, T, S>,
    exec: &dyn Exec,
    (frame, made): (&[T], Option<&[T]>),
    found: &mut Found<T>,
) -> PyResult<()> {
    let began = Instant::now();
    match made {
        None => tracker
            .give(exec, frame)
            .map_err(|error| unusable("frames", error))?,
        // The frame itself was looked at before.
        Some(made) => tracker
            .give_with_emission(exec, frame, made)
            .map_err(|error| unusable("emission", error))?,
    }
    if !tracker.is_ready() {
        found.density.extend_from_slice(tracker.carried());
        return Ok(());
    }
    let places = &mut found.faces;
    let pair = tracker.step(exec, &mut Silent, &mut |part, faces| {
        let components = places.iter_mut().skip(part as usize).take(1).flatten();
        for (axis, component) in components.enumerate().take(S::DIM) {
            let (begin, count) = (component.len(), faces.len(axis));
            component.resize(begin + count, T::ZERO);
            faces.read(axis, component.split_at_mut(begin).1);
        }
    });
    let pair = pair.map_err(|_| {
        let frame = found.pairs.len();
        PyFloatingPointError::new_err(format!(
            "the flow from frame {frame} is too fast or not finite; give options={{\"independent\": True}}, or a larger beta"
        ))
    })?;
    found.density.extend_from_slice(tracker.carried());
    found.pairs.push((began.elapsed().as_secs_f64(), pair));
    Ok(())
}
