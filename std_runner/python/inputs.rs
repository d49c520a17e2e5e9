//! NumPy's arrays as densities and velocities, checked and handed to the solver.

use crate::arrays::{Common, array, density, flags, numbers, untyped};
use crate::effects::{Given, by_step};
use crate::place::Number;
use crate::plan::Precision;
use crate::words::{read, refused};
use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use thurible_core::{InputError, Solver, Space};

/// What is given as arrays.
pub struct Inputs<'py> {
    /// rho_0, or nothing where emitters make all smoke.
    pub source: Option<Bound<'py, PyAny>>,
    /// Which cells are solid, if any are.
    pub solids: Option<Bound<'py, PyAny>>,
    /// Where force may act, from 0 to 1.
    pub mask: Option<Bound<'py, PyAny>>,
    /// Shapes of emitters, under their names.
    pub emitters: Vec<(String, Bound<'py, PyAny>)>,
    /// Keyframes by number, and the regions in which they are to be met.
    pub regions: Vec<(usize, Bound<'py, PyAny>)>,
    /// Steps and targets, by ascending step.
    pub keyframes: Vec<(usize, Bound<'py, PyAny>)>,
    /// v_0, or rest.
    pub velocity: Option<Bound<'py, PyAny>>,
    /// The flow that the method of guidance follows.
    pub reference: Option<Bound<'py, PyAny>>,
}

/// The precision that the dtype of an array says.
pub(crate) fn precision_of(field: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<Precision> {
    let dtype = array.dtype();
    if dtype.is_equiv_to(&numpy::dtype::<f32>(array.py())) {
        Ok(Precision::Single)
    } else if dtype.is_equiv_to(&numpy::dtype::<f64>(array.py())) {
        Ok(Precision::Double)
    } else {
        let remedy = "its dtype is the precision of the solve: use .astype(numpy.float32) or numpy.float64";
        Err(refused(field, format!("has dtype {dtype}; {remedy}")))
    }
}

/// Shape and precision of the source, or of the first emitter where that is None.
pub fn common(source: &Bound<'_, PyAny>, emitters: &[Given<'_>]) -> PyResult<Common> {
    let (field, array) = match (source.is_none(), emitters.first()) {
        (false, _) => ("source".to_owned(), source.clone()),
        (true, Some(emitter)) => emitter.shape()?,
        (true, None) => {
            let why = "is None, and there are no emitters; give an array, or emitters that make the smoke";
            return Err(refused("source", why));
        }
    };
    let array = untyped(&field, &array)?;
    let precision = precision_of(&field, array)?;
    if !(2..=3).contains(&array.ndim()) {
        let why = format!(
            "has {} axes; give an array of shape (ny, nx) or (nz, ny, nx)",
            array.ndim()
        );
        return Err(refused(&field, why));
    }
    let of = if source.is_none() {
        field
    } else {
        "the source".into()
    };
    Ok(Common {
        shape: array.shape().to_vec(),
        precision,
        of,
    })
}

/// Steps and arrays of a dict, or of pairs, by ascending step.
pub fn keyframes<'py>(given: &Bound<'py, PyAny>) -> PyResult<Vec<(usize, Bound<'py, PyAny>)>> {
    by_step(
        "keyframes",
        given,
        "a dict {step: array} or a list of pairs (step, array)",
    )
}

impl Inputs<'_> {
    /// Gives everything to `solver`; the answer is the mass factor of each keyframe.
    pub fn set_inputs<T: Number, S: Space>(
        &self,
        solver: &mut Solver<'_, T, S>,
        common: &Common,
        periodic: &[bool],
    ) -> PyResult<Vec<f64>> {
        if let Some(solids) = &self.solids {
            solver
                .set_solids(&flags("solids", solids, common)?)
                .map_err(|error| unusable("solids", error))?;
        }
        if let Some(mask) = &self.mask {
            let mask = array::<T>("mask", mask, common)?;
            solver
                .set_mask(&numbers(&mask)?)
                .map_err(|error| unusable("mask", error))?;
        }
        if let Some(source) = &self.source {
            let source = array::<T>("source", source, common)?;
            solver
                .set_source(&density("source", &source)?)
                .map_err(|error| unusable("source", error))?;
        }
        for (index, (field, shape)) in self.emitters.iter().enumerate() {
            let shape = array::<T>(field, shape, common)?;
            solver
                .set_emitter(index, &density(field, &shape)?)
                .map_err(|error| unusable(field, error))?;
        }
        if let Some(velocity) = &self.velocity {
            set_velocity(solver, velocity, common, periodic)?;
        }
        if let Some(reference) = &self.reference {
            set_reference(solver, reference, common, periodic)?;
        }
        for (index, region) in &self.regions {
            let field = format!("regions[{}]", self.keyframes[*index].0);
            let region = array::<T>(&field, region, common)?;
            solver
                .set_region(*index, &numbers(&region)?)
                .map_err(|error| unusable(&field, error))?;
        }
        let target = |(index, (step, target)): (usize, &(usize, Bound<'_, PyAny>))| {
            let field = format!("keyframes[{step}]");
            let target = array::<T>(&field, target, common)?;
            solver
                .set_keyframe(index, &density(&field, &target)?)
                .map_err(|error| unusable(&field, error))
        };
        self.keyframes.iter().enumerate().map(target).collect()
    }
}

pub(crate) fn unusable(field: &str, error: InputError) -> PyErr {
    refused(field, format!("cannot be used: {error}; change it"))
}

/// Sets v_0 to `velocity`, its components along x, y and so on.
fn set_velocity<T: Number, S: Space>(
    solver: &mut Solver<'_, T, S>,
    velocity: &Bound<'_, PyAny>,
    common: &Common,
    periodic: &[bool],
) -> PyResult<()> {
    let components = components::<S>("initial_velocity", velocity)?;
    for (axis, component) in components.iter().enumerate() {
        let field = format!("initial_velocity[{axis}]");
        let faces = faces::<S>(common, axis, periodic);
        let component = array::<T>(&field, component, &faces)?;
        solver
            .set_initial_velocity(axis, &numbers(&component)?)
            .map_err(|error| unusable(&field, error))?;
    }
    Ok(())
}

/// Sets the flow that is followed to `reference`, whose components along x, y and so on have an entry for each step, as those of a solution.
fn set_reference<T: Number, S: Space>(
    solver: &mut Solver<'_, T, S>,
    reference: &Bound<'_, PyAny>,
    common: &Common,
    periodic: &[bool],
) -> PyResult<()> {
    let components = components::<S>("reference", reference)?;
    for (axis, component) in components.iter().enumerate() {
        let field = format!("reference[{axis}]");
        let mut all = faces::<S>(common, axis, periodic);
        let count: usize = all.shape.iter().product();
        all.shape.insert(0, solver.steps());
        let component = array::<T>(&field, component, &all)?;
        let numbers = numbers(&component)?;
        for (step, numbers) in numbers.chunks_exact(count).enumerate().skip(1) {
            solver
                .set_reference(axis, step, numbers)
                .map_err(|error| unusable(&field, error))?;
        }
    }
    Ok(())
}

/// The components of a flow.
pub(crate) fn components<'py, S: Space>(
    field: &str,
    flow: &Bound<'py, PyAny>,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let wanted = format!(
        "a sequence of {} arrays: the components along x, y and so on",
        S::DIM
    );
    let components: Vec<Bound<'_, PyAny>> = read(field, flow, &wanted)?;
    if components.len() != S::DIM {
        let why = format!("has {} entries, but must be {wanted}", components.len());
        return Err(refused(field, why));
    }
    Ok(components)
}

/// What the faces of an axis have in common with the densities.
fn faces<S: Space>(common: &Common, axis: usize, periodic: &[bool]) -> Common {
    let mut shape = common.shape.clone();
    shape[S::DIM - 1 - axis] += usize::from(!periodic[axis]);
    Common {
        shape,
        precision: common.precision,
        of: common.of.clone(),
    }
}
