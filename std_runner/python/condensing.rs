//! `Condenser`: an elastic body whose energy is minimised step by step, in planned memory.

use crate::condensed::{Body, Choices, Kept, wrong};
use crate::plan::Precision;
use crate::watch::interruptible;
use crate::words::{read, refused};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use thurible::bytes::grouped;
use thurible_core::Named;
use thurible_core::condense::{CondenseParams, Iteration, Step};

/// An elastic body: `rest`, (vertices, d) for d from 1 to 3, `elements`, (elements, d + 1), and whether each vertex is held.
///
/// `step` goes to the next state of least energy, by the method and basis that were chosen, in one block whose bytes are known before.
#[pyclass(module = "thurible_smoke", name = "Condenser")]
pub struct PyCondenser {
    // Before what it points to.
    body: Box<dyn Body>,
    dims: usize,
    vertices: usize,
    params: CondenseParams,
    bytes: usize,
    _kept: Kept,
}

/// An array as lists.
fn listed<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if value.hasattr("tolist")? {
        value.call_method0("tolist")
    } else {
        Ok(value.clone())
    }
}

/// Rows of one length, one after the other, and that length.
fn rows<V: Copy>(field: &str, rows: Vec<Vec<V>>) -> PyResult<(Vec<V>, usize)> {
    let len = rows.first().map_or(0, Vec::len);
    if rows.iter().any(|row| row.len() != len) {
        return Err(refused(field, "has rows of different lengths; give an array"));
    }
    Ok((rows.concat(), len))
}

/// Refuses numbers of which one is not finite.
fn finite(field: &str, numbers: &[f64]) -> PyResult<()> {
    match numbers.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(at) => Err(refused(
            field,
            format!("has a number, the one after {at} others, that is not finite; every one must be"),
        )),
    }
}

#[pymethods]
impl PyCondenser {
    #[new]
    #[pyo3(signature = (rest, elements, held, **choices), text_signature = "(rest, elements, held, *, springs=None, young=1e5, poisson=0.4, density=1000.0, area=0.01, method='cc', basis='fixed', rebuild=5, radius=None, order='jacobi', block='vertex', tolerance=1e-06, cap=500, search=True, dt=None, dtype='float64', threads=None, memory_limit=None)")]
    fn new(
        rest: &Bound<'_, PyAny>,
        elements: &Bound<'_, PyAny>,
        held: &Bound<'_, PyAny>,
        choices: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut choices = Choices::read(choices)?;
        let wanted = "an array of shape (vertices, axes)";
        let (rest, dims) = rows("rest", read("rest", &listed(rest)?, wanted)?)?;
        let wanted = "an array of shape (elements, axes + 1) of whole numbers";
        let (elements, corners) = rows("elements", read("elements", &listed(elements)?, wanted)?)?;
        if (1..=3).contains(&dims) && corners != dims + 1 && !elements.is_empty() {
            let why = format!(
                "has {corners} columns; give {}: an element has one corner more than rest has axes",
                dims + 1
            );
            return Err(refused("elements", why));
        }
        let held: Vec<bool> = read("held", &listed(held)?, "an array of truth values")?;
        let vertices = held.len();
        let mut kept = Kept::new(rest, elements, core::mem::take(&mut choices.springs), held)?;
        let (body, bytes) = match (dims, choices.precision) {
            (1, Precision::Single) => kept.make::<f32, 1>(&choices),
            (1, Precision::Double) => kept.make::<f64, 1>(&choices),
            (2, Precision::Single) => kept.make::<f32, 2>(&choices),
            (2, Precision::Double) => kept.make::<f64, 2>(&choices),
            (3, Precision::Single) => kept.make::<f32, 3>(&choices),
            (3, Precision::Double) => kept.make::<f64, 3>(&choices),
            (axes, _) => {
                let why = format!(
                    "has {axes} axes; give an array of shape (vertices, 1), (vertices, 2) or (vertices, 3)"
                );
                return Err(refused("rest", why));
            }
        }?;
        Ok(Self {
            body,
            dims,
            vertices,
            params: choices.params,
            bytes,
            _kept: kept,
        })
    }

    /// The next step: every vertex, held or not, is moved by `shift`, (vertices, axes), `gravity` accelerates all, and the energy is minimised. A dict of
    /// "status", "iterations", "builds", and "energy", "residual" and "length" before each iteration and at the end.
    #[pyo3(signature = (shift=None, gravity=None))]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        shift: Option<&Bound<'py, PyAny>>,
        gravity: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let shift = self.vectors("shift", shift)?;
        let mut acceleration = [0.0; 3];
        if let Some(gravity) = gravity {
            let wanted = format!("{} numbers: along x, y and so on", self.dims);
            let given: Vec<f64> = read("gravity", &listed(gravity)?, &wanted)?;
            if given.len() != self.dims {
                return Err(refused(
                    "gravity",
                    format!("has {} numbers; give {wanted}", given.len()),
                ));
            }
            finite("gravity", &given)?;
            acceleration
                .iter_mut()
                .zip(given)
                .for_each(|(to, from)| *to = from);
        }
        let mut history: Vec<Iteration> = Vec::new();
        let (body, told) = (&mut self.body, &mut history);
        let step = Step {
            shift: &shift,
            gravity: acceleration,
        };
        let stepped = interruptible(py, self.params.threads, |exec, observer| {
            body.step(exec, observer, &step, &mut |iteration| told.push(*iteration))
        })?;
        let stepped = stepped.map_err(wrong)?;
        let said = PyDict::new(py);
        said.set_item("status", stepped.status.name())?;
        said.set_item("iterations", stepped.iterations)?;
        said.set_item("builds", stepped.builds)?;
        let column = |of: fn(&Iteration) -> f64| PyArray1::from_iter(py, history.iter().map(of));
        said.set_item("energy", column(|iteration| iteration.energy))?;
        said.set_item("residual", column(|iteration| iteration.residual))?;
        said.set_item("length", column(|iteration| iteration.length))?;
        Ok(said)
    }

    /// Gives free vertices a velocity, (vertices, axes), before an implicit step.
    fn set_velocity(&mut self, velocity: &Bound<'_, PyAny>) -> PyResult<()> {
        let velocity = self.vectors("velocity", Some(velocity))?;
        if self.params.dt.is_none() {
            let why = "is of no use to a body without time: each of its steps is at rest; make it with dt=..";
            return Err(refused("velocity", why));
        }
        self.body.set_velocity(&velocity).map_err(wrong)
    }

    /// Where the vertices are, (vertices, axes).
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &|vertex| self.body.position(vertex))
    }

    /// The gradient of the energy by them when it was made last; 0 of held ones.
    #[getter]
    fn gradient<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &|vertex| self.body.gradient(vertex))
    }

    /// Steps that are done.
    #[getter]
    fn steps(&self) -> usize {
        self.body.done()[0]
    }

    /// Builds of the basis, or of its factor, so far.
    #[getter]
    fn builds(&self) -> usize {
        self.body.done()[1]
    }

    /// Bytes of its block.
    #[getter]
    fn planned_bytes(&self) -> usize {
        self.bytes
    }

    fn __repr__(&self) -> String {
        format!(
            "<thurible_smoke.Condenser: {} vertices in {}D, {}, {} bytes>",
            self.vertices,
            self.dims,
            self.params.method.name(),
            grouped(self.bytes)
        )
    }
}

impl PyCondenser {
    /// A vector for each vertex; none where there is nothing.
    fn vectors(&self, field: &str, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<f64>> {
        let Some(given) = given else {
            return Ok(Vec::new());
        };
        let wanted = format!("an array of shape ({}, {})", self.vertices, self.dims);
        let (values, axes): (Vec<f64>, usize) = rows(field, read(field, &listed(given)?, &wanted)?)?;
        if axes != self.dims || values.len() != self.vertices * self.dims {
            return Err(refused(field, format!("has another shape; give {wanted}")));
        }
        finite(field, &values)?;
        Ok(values)
    }

    fn array<'py>(&self, py: Python<'py>, of: &dyn Fn(usize) -> [f64; 3]) -> PyResult<Bound<'py, PyAny>> {
        let values = (0..self.vertices).flat_map(|vertex| of(vertex).into_iter().take(self.dims));
        let array = PyArray1::from_iter(py, values).reshape([self.vertices, self.dims])?;
        Ok(array.into_any())
    }
}
