//! Emitters, buoyancy, weights and regions of keyframes, and a schedule, as Python gives them.

use crate::words::{positive, read, refused, unknown, whole};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList};
use thurible_core::{Emitter, Supply};

/// A list by step, as `keyframes`: a mapping or pairs, put in ascending order.
pub fn by_step<'py>(
    name: &str,
    given: &Bound<'py, PyAny>,
    wanted: &str,
) -> PyResult<Vec<(usize, Bound<'py, PyAny>)>> {
    let pairs = if given.hasattr("items")? {
        given.call_method0("items")?
    } else {
        given.clone()
    };
    // Of anything that can be gone through, as a generator; what cannot is refused below.
    let pairs = match pairs.try_iter() {
        Ok(each) => PyList::new(given.py(), each.collect::<PyResult<Vec<_>>>()?)?.into_any(),
        Err(_) => pairs,
    };
    let mut pairs: Vec<(usize, Bound<'py, PyAny>)> = read(name, &pairs, wanted)?;
    pairs.sort_by_key(|(step, _)| *step);
    Ok(pairs)
}

/// The same of what belongs to keyframes at the steps `keyframes`: the number of the keyframe instead of its step.
pub fn by_keyframe<'py>(
    name: &str,
    given: &Bound<'py, PyAny>,
    wanted: &str,
    keyframes: &[usize],
) -> PyResult<Vec<(usize, Bound<'py, PyAny>)>> {
    let pairs = by_step(name, given, wanted)?;
    if let Some(twice) = pairs.windows(2).find(|two| two[0].0 == two[1].0) {
        let why = format!("has step {} twice; give each step once", twice[0].0);
        return Err(refused(name, why));
    }
    let numbered = |(step, value): (usize, Bound<'py, PyAny>)| {
        let index = keyframes.iter().position(|&keyframe| keyframe == step);
        let why =
            format!("has step {step}, where no keyframe stands; give a step of keyframes, or take it out");
        index
            .map(|index| (index, value))
            .ok_or_else(|| refused(name, why))
    };
    pairs.into_iter().map(numbered).collect()
}

/// What the data term of each keyframe is multiplied by: 1 where nothing is said.
pub fn weights(given: &Bound<'_, PyAny>, keyframes: &[usize]) -> PyResult<Vec<f64>> {
    let mut weights = vec![1.0; keyframes.len()];
    for (index, value) in by_keyframe("weights", given, "a dict {step: number}", keyframes)? {
        let field = format!("weights[{}]", keyframes[index]);
        weights[index] = positive(&field, &value)?;
    }
    Ok(if weights.iter().all(|&weight| weight == 1.0) {
        Vec::new()
    } else {
        weights
    })
}

const REGIONS: &str = "a dict {step: array} or a list of pairs (step, array)";

/// The regions in which keyframes at the steps `keyframes` are to be met, by the keyframes' numbers.
pub fn regions<'py>(
    given: &Bound<'py, PyAny>,
    keyframes: &[usize],
) -> PyResult<Vec<(usize, Bound<'py, PyAny>)>> {
    by_keyframe("regions", given, REGIONS, keyframes)
}

/// Whether there are any; a plan is told so by True or False too.
pub fn has_regions(given: &Bound<'_, PyAny>, keyframes: &[usize]) -> PyResult<bool> {
    match given.extract() {
        Ok(said) => Ok(said),
        Err(_) => Ok(!regions(given, keyframes)?.is_empty()),
    }
}

/// Steps, and what the price of the force is multiplied by there.
pub fn schedule(given: &Bound<'_, PyAny>) -> PyResult<Vec<(usize, f64)>> {
    let pairs = by_step(
        "schedule",
        given,
        "a dict {step: factor} or a list of pairs (step, factor)",
    )?;
    let factor = |(step, value): (usize, Bound<'_, PyAny>)| {
        Ok((step, positive(&format!("schedule[{step}]"), &value)?))
    };
    pairs.into_iter().map(factor).collect()
}

/// The acceleration where the density is 1: a number is up, along the last of `dims` axes.
pub fn buoyancy(given: &Bound<'_, PyAny>, dims: usize) -> PyResult<[f64; 3]> {
    let mut acceleration = [0.0; 3];
    if let Ok(up) = given.extract::<f64>() {
        acceleration[dims - 1] = up;
        return Ok(acceleration);
    }
    let wanted = format!("a number, or a sequence of {dims}: along x, y and so on");
    let along: Vec<f64> = read("buoyancy", given, &wanted)?;
    if along.len() != dims {
        return Err(refused(
            "buoyancy",
            format!("has {} entries, but must be {wanted}", along.len()),
        ));
    }
    acceleration
        .iter_mut()
        .zip(along)
        .for_each(|(to, from)| *to = from);
    Ok(acceleration)
}

/// An emitter as Python gives it.
pub struct Given<'py> {
    field: String,
    shape: Option<Bound<'py, PyAny>>,
    from: Option<usize>,
    to: Option<usize>,
    supply: Supply,
    velocity: Option<Vec<f64>>,
}

const KEYS: [&str; 6] = ["shape", "from", "to", "rate", "target", "velocity"];

/// An argument, where it is given and not None.
pub fn argument<'py>(given: Option<&Bound<'py, PyDict>>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    let found = given.map(|given| given.get_item(name)).transpose()?.flatten();
    Ok(found.filter(|found| !found.is_none()))
}

/// The same of one that is read more than once: an iterator, which can be gone through once, becomes a list in its place.
pub fn kept<'py>(given: Option<&Bound<'py, PyDict>>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    let Some((given, found)) = given.zip(argument(given, name)?) else {
        return Ok(None);
    };
    if found.cast::<PyIterator>().is_err() {
        return Ok(Some(found));
    }
    let list = PyList::new(given.py(), found.try_iter()?.collect::<PyResult<Vec<_>>>()?)?.into_any();
    given.set_item(name, &list)?;
    Ok(Some(list))
}

/// The emitters among the arguments `given`.
pub fn emitters<'py>(given: Option<&Bound<'py, PyDict>>) -> PyResult<Vec<Given<'py>>> {
    let Some(emitters) = argument(given, "emitters")? else {
        return Ok(Vec::new());
    };
    let dicts: Vec<Bound<'py, PyAny>> = read("emitters", &emitters, "a list of dicts")?;
    dicts
        .iter()
        .enumerate()
        .map(|(index, emitter)| Given::read(index, emitter))
        .collect()
}

impl<'py> Given<'py> {
    fn read(index: usize, given: &Bound<'py, PyAny>) -> PyResult<Self> {
        let field = format!("emitters[{index}]");
        let wanted = "a dict of shape, from, to, and rate or target";
        let given = given
            .cast::<PyDict>()
            .map_err(|_| refused(&field, format!("is no dict; give {wanted}")))?;
        let mut values = [const { None }; KEYS.len()];
        for (name, value) in given {
            let name: String = read(&format!("a name in {field}"), &name, "a string")?;
            let known = KEYS.iter().position(|key| *key == name);
            let known = known.ok_or_else(|| unknown(&format!("key of {field}"), &name, &KEYS))?;
            values[known] = (!value.is_none()).then_some(value);
        }
        let [shape, from, to, rate, target, velocity] = values;
        let at = |key: &str| format!("{field}[\"{key}\"]");
        let step = |key: &str, value: Option<Bound<'py, PyAny>>| {
            value.map(|value| whole(&at(key), &value)).transpose()
        };
        let supply = match (rate, target) {
            (Some(rate), None) => Supply::Rate(positive(&at("rate"), &rate)?),
            (None, Some(target)) => Supply::Target(positive(&at("target"), &target)?),
            (Some(_), Some(_)) => {
                let why = "has a rate and a target; it adds by a rate or fills up to a target: take one of them out";
                return Err(refused(&field, why));
            }
            (None, None) => {
                let why = "has neither a rate nor a target; give what it adds at a step as rate, or what it fills up to as target";
                return Err(refused(&field, why));
            }
        };
        Ok(Self {
            shape,
            from: step("from", from)?,
            to: step("to", to)?,
            supply,
            velocity: match velocity {
                Some(velocity) => Some(read(
                    &at("velocity"),
                    &velocity,
                    "a sequence of numbers: along x, y and so on",
                )?),
                None => None,
            },
            field,
        })
    }

    /// Where it adds smoke, under its name among the arguments.
    pub fn shape(&self) -> PyResult<(String, Bound<'py, PyAny>)> {
        let shape = self
            .shape
            .clone()
            .map(|shape| (format!("{}[\"shape\"]", self.field), shape));
        shape.ok_or_else(|| {
            refused(
                &self.field,
                "has no shape; give an array that says where it adds smoke",
            )
        })
    }

    /// What the core calls it in a scene of `steps` steps, in all of which it emits where nothing is said.
    pub fn emitter(&self, steps: usize, dims: usize) -> PyResult<Emitter> {
        let velocity = match &self.velocity {
            Some(along) if along.len() != dims => {
                let field = format!("{}[\"velocity\"]", self.field);
                let why = format!(
                    "has {} entries, but must have {dims}: along x, y and so on",
                    along.len()
                );
                return Err(refused(&field, why));
            }
            Some(along) => {
                let mut velocity = [0.0; 3];
                velocity.iter_mut().zip(along).for_each(|(to, from)| *to = *from);
                Some(velocity)
            }
            None => None,
        };
        let (from, to) = (self.from.unwrap_or(0), self.to.unwrap_or(steps));
        if from < to && to <= steps {
            return Ok(Emitter {
                from,
                to,
                supply: self.supply,
                velocity,
            });
        }
        let why = format!(
            "emits from step {from} to step {to}; it must be to a later one, at most steps = {steps}"
        );
        Err(refused(&self.field, why))
    }
}
