//! What is solved and how: the arguments that `solve` and `plan` share.

use crate::effects::{self, Given};
use crate::templates;
use crate::words::{automatic, flag, is_automatic, number, one_of, read, refused, unknown, whole, word};
use numpy::PyUntypedArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use thurible::owned::OwnedProblem;
use thurible_core::choices::{Kind, Value};
use thurible_core::words::{Alternatives, Named};
use thurible_core::{Boundary, Method, Params};

const NAMES: [&str; 27] = [
    "steps",
    "dt",
    "length",
    "boundary",
    "viscosity",
    "slip",
    "buoyancy",
    "emitters",
    "templates",
    "solids",
    "force_weight",
    "smoothness",
    "schedule",
    "mask",
    "weights",
    "regions",
    "release",
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
    /// The defaults for arrays of `shape`, whose last axis is x, with `emitters` and the arguments of `given`; the answer is also those
    /// among `others` that were given.
    pub fn read<'py, const N: usize>(
        shape: &[usize],
        keyframes: Vec<usize>,
        emitters: &[Given<'py>],
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
        let templates = effects::argument(given, "templates")?;
        if templates.is_some() && effects::argument(given, "method")?.is_none() {
            choices.params.method = Method::Templates;
        }
        // Weights that are left out are those of a box and steps of length 1.
        let units = choices.scene.problem().units();
        if effects::argument(given, "force_weight")?.is_none() {
            choices.scene.force_weight = units.force_weight(choices.scene.force_weight);
        }
        choices.params.admm.penalty = units.penalty(choices.params.admm.penalty);
        if let Some(options) = options {
            let method = choices.params.method;
            set_options(choices.params.choices_mut(method), &options)?;
        }
        if choices.scene.steps == 0 {
            return Err(refused(
                "steps",
                "is missing or 0, and there is no keyframe to take it from; say how many there are",
            ));
        }
        let steps = choices.scene.steps;
        let emitters = emitters
            .iter()
            .map(|emitter| emitter.emitter(steps, choices.scene.cells.len()));
        choices.scene.emitters = emitters.collect::<PyResult<_>>()?;
        if let Some(templates) = templates {
            let dims = choices.scene.cells.len();
            choices.scene.templates = templates::templates(&templates, dims, steps)?;
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
            "slip" => self.scene.slip = flag(name, value)?,
            "buoyancy" => self.scene.buoyancy = effects::buoyancy(value, self.scene.cells.len())?,
            "schedule" | "weights" | "regions" | "solids" | "mask" if value.is_none() => {}
            // An array, or True or False where a plan is made.
            "solids" => self.scene.solids = is_there(name, value)?,
            "mask" => self.scene.mask = is_there(name, value)?,
            "schedule" => self.scene.schedule = effects::schedule(value)?,
            "weights" => self.scene.keyframe_weights = effects::weights(value, &self.scene.keyframes)?,
            "regions" => self.scene.keyframe_regions = effects::has_regions(value, &self.scene.keyframes)?,
            "release" => self.scene.release = chosen(whole)?,
            // Read before, where the shape of the grid is asked for.
            "emitters" => {}
            // Read after all others: they end with the scene.
            "templates" => {}
            "force_weight" if value.is_none() => {}
            "force_weight" => self.scene.force_weight = number(name, value)?,
            "smoothness" if is_automatic(value) => self.scene.smoothness = None,
            "smoothness" => self.scene.smoothness = Some(number(name, value)?),
            "filters" => self.scene.filters = automatic(name, value)?,
            "match_mass" => self.scene.match_mass = flag(name, value)?,
            "advection" => self.scene.advection.scheme = word(name, value)?,
            "advection_tolerance" => self.scene.advection.tolerance = number(name, value)?,
            "projection_tolerance" => self.scene.projection_tolerance = number(name, value)?,
            "method" if value.is_none() => {}
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

/// Whether there is an array, which True says too.
fn is_there(name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    match value.cast::<PyUntypedArray>() {
        Ok(_) => Ok(true),
        Err(_) => read(name, value, "an array, or where a plan is made True or False"),
    }
}

/// One word for all axes, or one for each of x, y (and z).
pub(crate) fn boundary(value: &Bound<'_, PyAny>, axes: usize) -> PyResult<Vec<Boundary>> {
    if value.extract::<&str>().is_ok() {
        return Ok(vec![word("boundary", value)?; axes]);
    }
    let known = Alternatives(Boundary::WORDS);
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
pub(crate) fn set_options(
    choices: &mut dyn thurible_core::choices::Choices,
    given: &Bound<'_, PyAny>,
) -> PyResult<()> {
    let given = given.cast::<PyMapping>().map_err(|_| {
        refused(
            "options",
            "is no dict; give the options of the method by their names",
        )
    })?;
    let table = choices.table();
    let pairs: Vec<(Bound<'_, PyAny>, Bound<'_, PyAny>)> = given.items()?.extract()?;
    for (name, value) in pairs {
        let name: String = read("a name in options", &name, "a string")?;
        let known = table.iter().enumerate().find(|(_, choice)| choice.name == name);
        let Some((index, choice)) = known else {
            let names: Vec<&str> = table.iter().map(|choice| choice.name).collect();
            return Err(unknown("option of this method", &name, &names));
        };
        let field = format!("options[\"{name}\"]");
        let value = chosen(&field, &value, choice.kind)?;
        if !choices.set(index, value) {
            return Err(refused(&field, format!("must be {}", choice.kind)));
        }
    }
    Ok(())
}

/// What `value` chooses where that is of this kind.
fn chosen(field: &str, value: &Bound<'_, PyAny>, kind: Kind) -> PyResult<Value<'static>> {
    Ok(match kind {
        Kind::Number(_) => Value::Number(number(field, value)?),
        Kind::Count(_) => Value::Count(whole(field, value)?),
        Kind::Automatic(_) => automatic(field, value)?.map_or(Value::Automatic, Value::Count),
        Kind::Flag => Value::Flag(flag(field, value)?),
        Kind::Word(words) => Value::Word(one_of(field, value, words)?),
    })
}
