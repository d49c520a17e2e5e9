//! Templates of the force as Python gives them, and as they were found.

use crate::words::{flag, number, positive, read, refused, unknown, whole, word};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use thurible_core::{Named, Real, Solver, Space, Template, TemplateKind};

const KEYS: [&str; 10] = [
    "kind",
    "center",
    "radius",
    "from",
    "to",
    "interval",
    "move",
    "amplitude",
    "size",
    "seed",
];

/// The templates in `given`, a list of dicts, of a scene with so many axes and steps.
pub fn templates(given: &Bound<'_, PyAny>, dims: usize, steps: usize) -> PyResult<Vec<Template>> {
    let dicts: Vec<Bound<'_, PyAny>> = read("templates", given, "a list of dicts")?;
    let each = dicts.iter().enumerate();
    each.map(|(index, given)| One::new(index, given, dims)?.read(steps))
        .collect()
}

/// A template as Python gives it.
struct One<'a, 'py> {
    field: String,
    given: &'a Bound<'py, PyDict>,
    dims: usize,
}

impl<'a, 'py> One<'a, 'py> {
    fn new(index: usize, given: &'a Bound<'py, PyAny>, dims: usize) -> PyResult<Self> {
        let field = format!("templates[{index}]");
        let why = "is no dict; give one of kind, center, radius and what else it has";
        let given = given.cast::<PyDict>().map_err(|_| refused(&field, why))?;
        for name in given.keys() {
            let name: String = read(&format!("a name in {field}"), &name, "a string")?;
            if !KEYS.contains(&name.as_str()) {
                return Err(unknown(&format!("key of {field}"), &name, &KEYS));
            }
        }
        Ok(Self { field, given, dims })
    }

    /// What stands under a key, where it is given and not None, read by `read` under its name.
    fn get<V>(
        &self,
        key: &str,
        read: impl FnOnce(&str, &Bound<'py, PyAny>) -> PyResult<V>,
    ) -> PyResult<Option<V>> {
        let found = self.given.get_item(key)?.filter(|found| !found.is_none());
        found.map(|found| read(&self.at(key), &found)).transpose()
    }

    fn at(&self, key: &str) -> String {
        format!("{}[\"{key}\"]", self.field)
    }

    fn needed<V>(&self, key: &str, found: Option<V>) -> PyResult<V> {
        found.ok_or_else(|| refused(&self.field, format!("has no {key}; give one")))
    }

    /// So many numbers; one may stand alone.
    fn numbers(&self, key: &str, count: usize) -> PyResult<Option<[f64; 3]>> {
        self.get(key, |field, found| {
            let numbers = match found.extract::<f64>() {
                Ok(one) if count == 1 => vec![one],
                _ => read::<Vec<f64>>(field, found, &format!("a sequence of {count}"))?,
            };
            if numbers.len() != count {
                let why = format!("has {} entries, but must have {count}", numbers.len());
                return Err(refused(field, why));
            }
            let mut three = [0.0; 3];
            three.iter_mut().zip(numbers).for_each(|(to, from)| *to = from);
            Ok(three)
        })
    }

    fn read(&self, steps: usize) -> PyResult<Template> {
        let kind: TemplateKind = self.needed("kind", self.get("kind", word)?)?;
        let center = self.needed("center", self.numbers("center", self.dims)?)?;
        let radius = self.needed("radius", self.get("radius", positive)?)?;
        let standard = Template::new(kind, center, radius, self.get("to", whole)?.unwrap_or(steps));
        for key in ["size", "seed"] {
            if kind != TemplateKind::Noise && self.get(key, |_, _| Ok(()))?.is_some() {
                let why = format!("is an argument of noise alone; take it out of a {}", kind.name());
                return Err(refused(&self.at(key), why));
            }
        }
        let seed = self.get("seed", |field, found| {
            read(field, found, "a whole number from 0 to 4294967295")
        })?;
        Ok(Template {
            from: self.get("from", whole)?.unwrap_or(standard.from),
            interval: self.get("interval", whole)?.unwrap_or(standard.interval),
            moves: self.get("move", flag)?.unwrap_or(standard.moves),
            amplitude: self
                .numbers("amplitude", kind.numbers(self.dims))?
                .unwrap_or(standard.amplitude),
            size: self.get("size", number)?.unwrap_or(standard.size),
            seed: seed.unwrap_or(standard.seed),
            ..standard
        })
    }
}

/// A template as it was found, and its amplitudes.
#[derive(Clone, Debug)]
pub struct FoundTemplate {
    /// With its middle and radius as found.
    pub template: Template,
    /// The numbers of its amplitude in each interval.
    pub amplitudes: Vec<Vec<f64>>,
    /// Axes.
    pub dims: usize,
}

/// All templates of a solver.
pub fn found<T: Real, S: Space>(solver: &Solver<'_, T, S>) -> Vec<FoundTemplate> {
    let all = (0..).map_while(|index| Some((index, solver.template(index)?)));
    all.map(|(index, template)| {
        let numbers = template.kind.numbers(S::DIM);
        let amplitude = |interval| {
            solver
                .amplitude(index, interval)
                .into_iter()
                .take(numbers)
                .collect()
        };
        FoundTemplate {
            template,
            amplitudes: (0..template.intervals(template.to)).map(amplitude).collect(),
            dims: S::DIM,
        }
    })
    .collect()
}

/// Found templates as a list of dicts, whose keys are those that they are given by.
pub fn listed<'py>(py: Python<'py>, found: &[FoundTemplate]) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for FoundTemplate {
        template,
        amplitudes,
        dims,
    } in found
    {
        let dict = PyDict::new(py);
        dict.set_item("kind", template.kind.name())?;
        dict.set_item("center", template.center.iter().take(*dims).collect::<Vec<_>>())?;
        dict.set_item("radius", template.radius)?;
        dict.set_item("from", template.from)?;
        dict.set_item("to", template.to)?;
        dict.set_item("interval", template.interval)?;
        dict.set_item("move", template.moves)?;
        dict.set_item("amplitude", amplitudes)?;
        if template.kind == TemplateKind::Noise {
            dict.set_item("size", template.size)?;
            dict.set_item("seed", template.seed)?;
        }
        list.append(dict)?;
    }
    Ok(list)
}
