//! Runs of an operator: NumPy's arrays in, the trajectory and its gradient out.

use crate::arrays::{Common, array, numbers};
use crate::covectors::{Covectors, Fields};
use crate::place::Number;
use crate::plan::Precision;
use crate::watch::interruptible;
use crate::words::{read, refused};
use crate::worked::{Gradient, found, room, stopped};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping, PyTuple};
use std::borrow::Cow;
use thurible_core::Boundary;
use thurible_core::operator::{Given, OperatorError, Simulator, Start, View};

/// What is known of an operator beside its memory.
pub struct About {
    /// Shape of a density.
    pub shape: Vec<usize>,
    /// How many steps there are.
    pub steps: usize,
    /// How each axis ends.
    pub boundary: Vec<Boundary>,
    /// Whether components are at the centres of cells too.
    pub centers: bool,
    /// Of all arrays.
    pub precision: Precision,
    /// The forces of the last simulation, which its way back reads again.
    pub forces: Vec<Py<PyAny>>,
    /// Simulations that were begun.
    pub runs: usize,
    /// Whether the last of them came to its end: one that did not has left a start that does not belong to `forces`.
    pub simulated: bool,
    /// Whether each emitter pushes.
    pub pushes: Vec<bool>,
    /// Threads.
    pub threads: usize,
}

impl About {
    /// Shape of a component: that of the faces across its axis, or of the cells.
    pub fn faces_of(&self, axis: usize) -> Vec<usize> {
        let mut faces = self.shape.clone();
        let closed = !self.centers && self.boundary.get(axis) != Some(&Boundary::Periodic);
        let along = faces.len() - 1 - axis;
        faces
            .iter_mut()
            .skip(along)
            .take(1)
            .for_each(|count| *count += usize::from(closed));
        faces
    }

    /// An array's shape and precision, with so many steps in front.
    pub fn common(&self, shape: Vec<usize>, steps: Option<usize>) -> Common {
        Common {
            shape: steps.into_iter().chain(shape).collect(),
            precision: self.precision,
            of: "the operator".into(),
        }
    }

    /// Components of a field, with so many steps in front.
    fn fields<'py, T: Number>(
        &self,
        name: &str,
        given: &Bound<'py, PyAny>,
        steps: Option<usize>,
    ) -> PyResult<Fields<'py, T>> {
        let dims = self.shape.len();
        let wanted = format!("a sequence of {dims} arrays: the components along x, y and so on");
        let components: Vec<Bound<'py, PyAny>> = read(name, given, &wanted)?;
        if components.len() != dims {
            let why = format!("has {} entries, but must be {wanted}", components.len());
            return Err(refused(name, why));
        }
        let each = components.iter().enumerate().map(|(axis, component)| {
            let common = self.common(self.faces_of(axis), steps);
            array::<T>(&format!("{name}[{axis}]"), component, &common)
        });
        each.collect()
    }

    /// The steps that `at` names, all where there is none.
    fn shown(&self, at: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<usize>> {
        let Some(at) = at else {
            return Ok((0..=self.steps).collect());
        };
        let wanted = format!(
            "a list of whole numbers from 0 to {}, each larger than the one before",
            self.steps
        );
        let shown: Vec<usize> = read("at", at, &wanted)?;
        if shown.is_sorted_by(|one, next| one < next) && shown.last().is_none_or(|&last| last <= self.steps) {
            Ok(shown)
        } else {
            Err(refused("at", format!("is {shown:?}, but must be {wanted}")))
        }
    }

    /// See `Operator.simulate`.
    pub fn run<'py, T: Number>(
        &mut self,
        py: Python<'py>,
        work: &mut (dyn Simulator<T> + Send),
        density: &Bound<'py, PyAny>,
        velocity: Option<&Bound<'py, PyAny>>,
        forces: Option<&Bound<'py, PyAny>>,
        at: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let steps = self.steps;
        let shown = self.shown(at)?;
        let density = array::<T>("density", density, &self.common(self.shape.clone(), None))?;
        let density = numbers(&density)?;
        let velocity = velocity
            .map(|v| self.fields::<T>("velocity", v, None))
            .transpose()?;
        let velocity = velocity.unwrap_or_default();
        let velocity = velocity.iter().map(numbers).collect::<PyResult<Vec<_>>>()?;
        let pushed = forces
            .map(|forces| self.fields::<T>("forces", forces, Some(steps)))
            .transpose()?;
        let pushed = pushed.unwrap_or_default();
        let kept = pushed
            .iter()
            .map(|array| array.as_any().clone().unbind())
            .collect();
        let forces = pushed.iter().map(numbers).collect::<PyResult<Vec<_>>>()?;
        let cells: usize = self.shape.iter().product();
        let mut rho = room::<T>(shown.len() * cells)?;
        let lens: Vec<usize> = (0..self.shape.len())
            .map(|axis| self.faces_of(axis).iter().product())
            .collect();
        let mut v = lens
            .iter()
            .map(|len| room::<T>(shown.len() * len))
            .collect::<PyResult<Vec<_>>>()?;
        let threads = self.threads;
        self.runs += 1;
        self.simulated = false;
        let start = Start {
            density: &density,
            velocity: core::array::from_fn(|axis| velocity.get(axis).map_or(&[][..], |v| v)),
        };
        let mut show = |step: usize, view: &View<'_, T>| {
            let Ok(row) = shown.binary_search(&step) else {
                return;
            };
            view.read_density(part(&mut rho, row, cells));
            for (axis, (v, &len)) in v.iter_mut().zip(&lens).enumerate() {
                view.read_vector(axis, part(v, row, len));
            }
        };
        interruptible(py, threads, |exec, observer| {
            work.simulate(exec, observer, &start, &mut push(&forces, &lens), &mut show)
        })?
        .map_err(stopped)?;
        self.forces = kept;
        self.simulated = true;
        let with_steps = |shape: Vec<usize>| [vec![shown.len()], shape].concat();
        let rho = PyArray1::from_vec(py, rho).reshape(with_steps(self.shape.clone()))?;
        let v: PyResult<Vec<_>> = v
            .into_iter()
            .enumerate()
            .map(|(axis, v)| PyArray1::from_vec(py, v).reshape(with_steps(self.faces_of(axis))))
            .collect();
        Ok((rho.into_any(), PyTuple::new(py, v?)?))
    }

    /// Covectors as they are given.
    fn covectors<'py, T: Number>(
        &self,
        name: &str,
        given: Option<&Bound<'py, PyAny>>,
        fields: impl Fn(&str, &Bound<'py, PyAny>, Option<usize>) -> PyResult<Fields<'py, T>>,
    ) -> PyResult<Covectors<'py, T>> {
        let Some(given) = given.filter(|given| !given.is_none()) else {
            return Ok(Covectors::None);
        };
        let Ok(by_step) = given.cast::<PyMapping>() else {
            return Ok(Covectors::Whole(fields(name, given, Some(self.steps + 1))?));
        };
        let mut steps = Vec::new();
        let pairs: Vec<(Bound<'py, PyAny>, Bound<'py, PyAny>)> = by_step.items()?.extract()?;
        for (step, value) in pairs {
            let step: usize = read(&format!("a step of {name}"), &step, "a whole number from 0")?;
            if step > self.steps {
                let why = format!("is beyond the last one, {}; take it out", self.steps);
                return Err(refused(&format!("{name}[{step}]"), why));
            }
            steps.push((step, fields(&format!("{name}[{step}]"), &value, None)?));
        }
        Ok(Covectors::Steps(steps))
    }

    /// See `Operator.vjp`.
    pub fn back<'py, T: Number>(
        &self,
        py: Python<'py>,
        work: &mut (dyn Simulator<T> + Send),
        density: Option<&Bound<'py, PyAny>>,
        velocity: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Gradient> {
        if !self.simulated {
            return Err(stopped(OperatorError::NotSimulated));
        }
        let (steps, dims) = (self.steps, self.shape.len());
        let of_density = self.covectors::<T>("density", density, |name, given, steps| {
            Ok(vec![array::<T>(
                name,
                given,
                &self.common(self.shape.clone(), steps),
            )?])
        })?;
        let of_velocity = self.covectors::<T>("velocity", velocity, |name, given, steps| {
            self.fields::<T>(name, given, steps)
        })?;
        let (of_density, of_velocity) = (of_density.in_order()?, of_velocity.in_order()?);
        let kept: Vec<PyReadonlyArrayDyn<'py, T>> = self
            .forces
            .iter()
            .map(|array| Ok(array.bind(py).cast::<PyArrayDyn<T>>()?.try_readonly()?))
            .collect::<PyResult<_>>()?;
        let forces = kept.iter().map(numbers).collect::<PyResult<Vec<_>>>()?;
        let cells: usize = self.shape.iter().product();
        let lens: Vec<usize> = (0..dims)
            .map(|axis| self.faces_of(axis).iter().product())
            .collect();
        // Of forces that were given alone: those of a long run take more than all else.
        let mut by_force = lens
            .iter()
            .take(forces.len())
            .map(|len| room::<T>(steps * len))
            .collect::<PyResult<Vec<_>>>()?;
        let threads = self.threads;
        let mut cotangent = |step: usize, given: &mut Given<'_, T>| {
            for numbers in of_density.at(step, cells, 0) {
                given.density(numbers);
            }
            for (axis, &len) in lens.iter().enumerate() {
                for numbers in of_velocity.at(step, len, axis) {
                    given.vector(axis, numbers);
                }
            }
        };
        let mut show = |step: usize, view: &View<'_, T>| {
            for (axis, (gradient, &len)) in by_force.iter_mut().zip(&lens).enumerate() {
                view.read_vector(axis, part(gradient, step, len));
            }
        };
        interruptible(py, threads, |exec, observer| {
            work.vjp(
                exec,
                observer,
                &mut push(&forces, &lens),
                &mut cotangent,
                &mut show,
            )
        })?
        .map_err(stopped)?;
        self.gradient(py, work, by_force)
    }

    fn gradient<T: Number>(
        &self,
        py: Python<'_>,
        work: &mut (dyn Simulator<T> + Send),
        by_force: Vec<Vec<T>>,
    ) -> PyResult<Gradient> {
        let (steps, dims) = (self.steps, self.shape.len());
        let cells: usize = self.shape.iter().product();
        let shapes: Vec<Vec<usize>> = (0..dims).map(|axis| self.faces_of(axis)).collect();
        let mut rho = room::<T>(cells)?;
        let mut v = shapes
            .iter()
            .map(|shape| room::<T>(shape.iter().product()))
            .collect::<PyResult<Vec<_>>>()?;
        let count = self.pushes.len();
        let mut of_shapes = (0..count)
            .map(|_| room::<T>(cells))
            .collect::<PyResult<Vec<_>>>()?;
        let found = found(work, &mut rho, &mut v, &mut of_shapes);
        let mut emitters = Vec::new();
        for ((shape, of), pushes) in of_shapes.into_iter().zip(found.emitters).zip(&self.pushes) {
            let emitter = PyDict::new(py);
            emitter.set_item("supply", of.supply)?;
            let velocity: Vec<f64> = of.velocity.into_iter().take(dims).collect();
            emitter.set_item("velocity", pushes.then_some(velocity))?;
            emitter.set_item(
                "shape",
                PyArray1::from_vec(py, shape).reshape(self.shape.clone())?,
            )?;
            emitters.push(emitter.unbind());
        }
        let arrays = |fields: Vec<Vec<T>>, steps: Option<usize>| -> PyResult<Py<PyTuple>> {
            let arrays = fields.into_iter().zip(&shapes).map(|(field, shape)| {
                let shape: Vec<usize> = steps.into_iter().chain(shape.iter().copied()).collect();
                PyArray1::from_vec(py, field).reshape(shape)
            });
            Ok(PyTuple::new(py, arrays.collect::<PyResult<Vec<_>>>()?)?.unbind())
        };
        Ok(Gradient {
            density: PyArray1::from_vec(py, rho)
                .reshape(self.shape.clone())?
                .into_any()
                .unbind(),
            velocity: arrays(v, None)?,
            forces: if by_force.is_empty() {
                None
            } else {
                Some(arrays(by_force, Some(steps))?)
            },
            buoyancy: found.buoyancy.into_iter().take(dims).collect(),
            emitters,
        })
    }
}

/// One step of an array of steps.
fn part<T>(field: &mut [T], step: usize, len: usize) -> &mut [T] {
    field.get_mut(step * len..(step + 1) * len).unwrap_or_default()
}

/// Gives each step its force.
fn push<'a, T: Number>(
    forces: &'a [Cow<'_, [T]>],
    lens: &'a [usize],
) -> impl FnMut(usize, &mut Given<'_, T>) + 'a {
    move |step, given| {
        for (axis, (force, &len)) in forces.iter().zip(lens).enumerate() {
            given.vector(axis, force.get(step * len..(step + 1) * len).unwrap_or_default());
        }
    }
}
