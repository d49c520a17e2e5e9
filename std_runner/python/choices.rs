//! What is solved and how: the arguments that `solve` and `plan` share.

use crate::words::{automatic, flag, number, read, refused, unknown, whole, word};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use thurible::owned::OwnedProblem;
use thurible_core::words::{Named, UnknownWord};
use thurible_core::{Boundary, Method, Params};

const NAMES: [&str; 16] = [
    "steps",
    "dt",
    "length",
    "boundary",
    "viscosity",
    "force_weight",
    "filters",
    "match_mass",
    "advection",
    "advection_tolerance",
    "projection_tolerance",
    "method",
    "options",
    "iterations",
    "threads",
    "memory_limit",
];

/// A scene without its densities, and how it is to be solved.
#[derive(Clone, Debug)]
pub struct Choices {
    /// The scene.
    pub scene: OwnedProblem,
    /// Threads, or `None` for what the machine offers.
    pub threads: Option<usize>,
    /// Most bytes of the block, or `None` for what the machine has.
    pub memory_limit: Option<usize>,
    /// All parameters but threads and ceiling.
    pub params: Params,
}

impl Choices {
    /// The defaults for arrays of `shape`, whose last axis is x, with the arguments of `given`; the answer is also those among
    /// `others` that were given.
    pub fn read<'py, const N: usize>(
        shape: &[usize],
        keyframes: Vec<usize>,
        given: Option<&Bound<'py, PyDict>>,
        others: [&str; N],
    ) -> PyResult<(Self, [Option<Bound<'py, PyAny>>; N])> {
        let cells: Vec<usize> = shape.iter().rev().copied().collect();
        let mut choices = Self {
            scene: OwnedProblem::new(cells, keyframes),
            threads: None,
            memory_limit: None,
            params: Params::default(),
        };
        let (mut rest, mut options) = ([const { None }; N], None);
        for (name, value) in given.into_iter().flat_map(PyDictMethods::iter) {
            let name: String = name.extract()?;
            match others.iter().position(|other| *other == name) {
                Some(index) => rest[index] = (!value.is_none()).then_some(value),
                None if name == "options" => options = (!value.is_none()).then_some(value),
                None => choices.set(&name, &value, &others)?,
            }
        }
        if let Some(options) = options {
            set_options(&mut choices.params, &options)?;
        }
        if choices.scene.steps == 0 {
            return Err(refused(
                "steps",
                "is missing, and there is no keyframe to take it from; say how many there are",
            ));
        }
        Ok((choices, rest))
    }

    fn set(&mut self, name: &str, value: &Bound<'_, PyAny>, others: &[&str]) -> PyResult<()> {
        let chosen = |read: fn(&str, &Bound<'_, PyAny>) -> PyResult<usize>| {
            if value.is_none() {
                Ok(None)
            } else {
                read(name, value).map(Some)
            }
        };
        match name {
            "steps" => self.scene.steps = chosen(whole)?.unwrap_or(self.scene.steps),
            "dt" => self.scene.dt = number(name, value)?,
            "length" => self.scene.length = number(name, value)?,
            "boundary" => self.scene.boundary = boundary(value, self.scene.cells.len())?,
            "viscosity" => self.scene.viscosity = number(name, value)?,
            "force_weight" => self.scene.force_weight = number(name, value)?,
            "filters" => self.scene.filters = automatic(name, value)?,
            "match_mass" => self.scene.match_mass = flag(name, value)?,
            "advection" => self.scene.advection.scheme = word(name, value)?,
            "advection_tolerance" => self.scene.advection.tolerance = number(name, value)?,
            "projection_tolerance" => self.scene.projection_tolerance = number(name, value)?,
            "method" => self.params.method = word(name, value)?,
            "iterations" => self.params.iterations = whole(name, value)?,
            "threads" => self.threads = chosen(whole)?,
            "memory_limit" => self.memory_limit = chosen(whole)?,
            _ => return Err(unknown("argument", name, &[&NAMES, others].concat())),
        }
        Ok(())
    }

    /// Whether each axis wraps around.
    pub fn periodic(&self) -> Vec<bool> {
        self.scene
            .boundary
            .iter()
            .map(|&boundary| boundary == Boundary::Periodic)
            .collect()
    }
}

/// One word for all axes, or one for each of x, y (and z).
fn boundary(value: &Bound<'_, PyAny>, axes: usize) -> PyResult<Vec<Boundary>> {
    if value.extract::<&str>().is_ok() {
        return Ok(vec![word("boundary", value)?; axes]);
    }
    let known = UnknownWord {
        allowed: Boundary::ALL,
    };
    let words: Vec<Bound<'_, PyAny>> =
        read("boundary", value, &format!("{known}, or a list of these words"))?;
    if words.len() != axes {
        return Err(refused(
            "boundary",
            format!(
                "has {} entries; give one word, or {axes}: for x, y and so on",
                words.len()
            ),
        ));
    }
    words
        .iter()
        .enumerate()
        .map(|(axis, value)| word(&format!("boundary[{axis}]"), value))
        .collect()
}

/// The options of the method that was chosen.
fn set_options(params: &mut Params, given: &Bound<'_, PyAny>) -> PyResult<()> {
    let given = given.cast::<PyDict>().map_err(|_| {
        refused(
            "options",
            "is no dict; give the options of the method by their names",
        )
    })?;
    for (name, value) in given.iter() {
        let name: String = read("a name in options", &name, "a string")?;
        let field = format!("options[\"{name}\"]");
        let known: &[&str] = match params.method {
            Method::Direct => direct_option(params, &name, &field, &value)?,
            Method::Admm => admm_option(params, &name, &field, &value)?,
            Method::Lbfgs => lbfgs_option(params, &name, &field, &value)?,
            Method::Pd => pd_option(params, &name, &field, &value)?,
            Method::Simulate => simulate_option(params, &name, &field, &value)?,
        };
        if !known.is_empty() {
            return Err(unknown("option of this method", &name, known));
        }
    }
    Ok(())
}

// Each answers with the names that it knows if `name` is none of them.

fn direct_option(
    params: &mut Params,
    name: &str,
    field: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<&'static [&'static str]> {
    let direct = &mut params.direct;
    match name {
        "history" => direct.history = automatic(field, value)?,
        "tolerance" => direct.tolerance = number(field, value)?,
        "nested" => direct.nested = flag(field, value)?,
        _ => return Ok(&["history", "tolerance", "nested"]),
    }
    Ok(&[])
}

fn admm_option(
    params: &mut Params,
    name: &str,
    field: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<&'static [&'static str]> {
    let admm = &mut params.admm;
    match name {
        "penalty" => admm.penalty = number(field, value)?,
        "relaxation" => admm.relaxation = number(field, value)?,
        "ao_iterations" => admm.ao_iterations = whole(field, value)?,
        "ao_momentum" => admm.ao_momentum = number(field, value)?,
        "nested" => admm.nested = flag(field, value)?,
        "density_tolerance" => admm.density_tolerance = number(field, value)?,
        "nso" => admm.nso.solver = word(field, value)?,
        "nso_tolerance" => admm.nso.tolerance = number(field, value)?,
        "nso_norm" => admm.nso.norm = word(field, value)?,
        "smoother_colours" => admm.nso.colours = word(field, value)?,
        _ => {
            return Ok(&[
                "penalty",
                "relaxation",
                "ao_iterations",
                "ao_momentum",
                "nested",
                "density_tolerance",
                "nso",
                "nso_tolerance",
                "nso_norm",
                "smoother_colours",
            ]);
        }
    }
    Ok(&[])
}

fn lbfgs_option(
    params: &mut Params,
    name: &str,
    field: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<&'static [&'static str]> {
    let lbfgs = &mut params.lbfgs;
    match name {
        "history" => lbfgs.history = automatic(field, value)?,
        "tolerance" => lbfgs.tolerance = number(field, value)?,
        "nested" => lbfgs.nested = flag(field, value)?,
        _ => return Ok(&["history", "tolerance", "nested"]),
    }
    Ok(&[])
}

fn pd_option(
    params: &mut Params,
    name: &str,
    field: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<&'static [&'static str]> {
    let pd = &mut params.pd;
    match name {
        "drive" => pd.drive = number(field, value)?,
        "attenuation" => pd.attenuation = number(field, value)?,
        "gathering" => pd.gathering = number(field, value)?,
        _ => return Ok(&["drive", "attenuation", "gathering"]),
    }
    Ok(&[])
}

fn simulate_option(
    params: &mut Params,
    name: &str,
    field: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<&'static [&'static str]> {
    let simulation = &mut params.simulation;
    match name {
        "buoyancy" => simulation.buoyancy = number(field, value)?,
        "tolerance" => simulation.tolerance = number(field, value)?,
        _ => return Ok(&["buoyancy", "tolerance"]),
    }
    Ok(&[])
}
