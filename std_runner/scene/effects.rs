//! `[[emitter]]`, `[[obstacle]]`, `[[release]]`, `control.schedule`, and the buoyancy of `[flow]`.

use super::check::shown;
use super::document::Document;
use super::model::{Emission, Grid, Scene, Time};
use super::sequence::Sequence;
use super::shapes;
use crate::exit::Failure;
use crate::keyframes::{DENSEST, ShapeSpec};
use thurible_core::choices::Numbers;
use thurible_core::problem::MAX_STEPS;
use thurible_core::{Emitter, Supply};
use toml::{Table, Value};

/// The emitters of a scene on this grid with these steps.
pub(super) fn emitters(
    document: &Document,
    raw: Option<Vec<Table>>,
    place: (&Grid, Time),
) -> Result<Vec<Emission>, Failure> {
    let tables = raw.unwrap_or_default().into_iter().enumerate();
    let all = tables.map(|(index, table)| emitter(document, index, table, place));
    Ok(all.collect::<Result<Vec<_>, _>>()?.concat())
}

/// Number `index` in the file: one emitter, or of a sequence one for each of its shapes, from its step to that of the next.
fn emitter(
    document: &Document,
    index: usize,
    mut table: Table,
    (grid, time): (&Grid, Time),
) -> Result<Vec<Emission>, Failure> {
    let steps = time.steps;
    let key = format!("emitter[{index}]");
    document.only(
        &key,
        &table,
        &[
            &[
                "from",
                "to",
                "steps",
                ShapeSpec::PATTERN,
                "rate",
                "target",
                "velocity",
            ],
            ShapeSpec::KEYS,
        ]
        .concat(),
    )?;
    let begins = (&["from", "to"][..], &(0..=steps - 1));
    let sequence = Sequence::taken(document, &key, &mut table, begins)?;
    let at = |name: &str| format!("{key}.{name}");
    let mut step = |name: &str, otherwise: usize, allowed| match table.remove(name) {
        None => Ok(otherwise),
        Some(found) => document.whole_value(&at(name), &found, allowed),
    };
    let from = step("from", 0, 0..=steps - 1)?;
    let to = step("to", steps, 1..=steps)?;
    if from >= to {
        let why =
            format!("is {to}, but the emitter begins at step {from}; let it end later, or begin sooner");
        return Err(document.refuse(&at("to"), why));
    }
    let supply = supply(document, &key, table.remove("rate"), table.remove("target"))?;
    let velocity = velocity(document, &key, table.remove("velocity"), (grid, time))?;
    let shapes = match &sequence {
        None => vec![(from, shapes::shape(document, &key, table)?)],
        Some(sequence) => sequence.shapes(document, &key, table, steps)?,
    };
    let ends = |begins: usize| match &sequence {
        None => to,
        Some(sequence) => begins.saturating_add(sequence.every).min(steps),
    };
    let emission = |(from, shape)| Emission {
        emits: Emitter {
            from,
            to: ends(from),
            supply,
            velocity,
        },
        shape,
        key: key.clone(),
    };
    Ok(shapes.into_iter().map(emission).collect())
}

/// Less is nothing in single precision.
const FAINTEST: f64 = 1e-30;

/// How much an emitter makes: the one that is given of `rate` and `target`.
fn supply(
    document: &Document,
    key: &str,
    rate: Option<Value>,
    target: Option<Value>,
) -> Result<Supply, Failure> {
    let read = |name: &str, found: &Value| {
        let key = format!("{key}.{name}");
        let supply = document.positive_value(&key, found)?;
        if !(FAINTEST..=DENSEST).contains(&supply) {
            let wanted = format_args!("a number from {FAINTEST:e} to {DENSEST}");
            return Err(document.outside(&key, format_args!("{supply:?}"), wanted));
        }
        Ok(supply)
    };
    match (rate, target) {
        (Some(rate), None) => Ok(Supply::Rate(read("rate", &rate)?)),
        (None, Some(target)) => Ok(Supply::Target(read("target", &target)?)),
        (Some(_), Some(_)) => {
            let why = "stands beside `rate`; an emitter adds by a rate or fills up to a target: take one of them out";
            Err(document.refuse(&format!("{key}.target"), why))
        }
        (None, None) => {
            let remedy = "write the density that a step adds, as in rate = 0.2, or what it is filled up to, as in target = 1.0";
            document.required(&format!("{key}.rate"), None, remedy)
        }
    }
}

/// The velocity that an emitter's smoke comes with, if it has one of its own.
fn velocity(
    document: &Document,
    key: &str,
    given: Option<Value>,
    (grid, time): (&Grid, Time),
) -> Result<Option<[f64; 3]>, Failure> {
    let Some(given) = given else {
        return Ok(None);
    };
    let (key, dims) = (format!("{key}.velocity"), grid.cells.len());
    let example = if dims == 2 {
        "[0.0, 0.01]"
    } else {
        "[0.0, 0.0, 0.01]"
    };
    let along = document.numbers(&key, &given, dims, example)?;
    let speed = along.iter().map(|v| v * v).sum::<f64>().sqrt() * time.dt / grid.length;
    if speed > 1.0 {
        let why = format!(
            "is {speed:?} boxes a step, which nothing can follow; at most 1 is allowed: make it slower, or `time.dt` smaller"
        );
        return Err(document.refuse(&key, why));
    }
    let mut velocity = [0.0; 3];
    velocity.iter_mut().zip(along).for_each(|(to, from)| *to = from);
    Ok(Some(velocity))
}

/// The shapes of all obstacles, each with its key.
pub(super) fn obstacles(
    document: &Document,
    raw: Option<Vec<Table>>,
) -> Result<Vec<(String, ShapeSpec)>, Failure> {
    let tables = raw.unwrap_or_default().into_iter().enumerate();
    let obstacle = |(index, table): (usize, Table)| {
        let key = format!("obstacle[{index}]");
        document.only(&key, &table, ShapeSpec::KEYS)?;
        Ok((key.clone(), shapes::shape(document, &key, table)?))
    };
    tables.map(obstacle).collect()
}

/// Refuses keyframes before there is any smoke.
pub(super) fn check_smoke(scene: &Scene) -> Result<(), Failure> {
    let (document, emitters) = (&scene.document, &scene.emitters);
    let begins = emitters.iter().map(|emitter| emitter.emits.from).min();
    if let (None, Some(begins)) = (&scene.source, begins)
        && let Some(early) = scene.keyframes.iter().find(|keyframe| keyframe.step <= begins)
    {
        let why = format!(
            "is {}, but there is no [source], and the first emitter begins at step {begins}, so there is no smoke yet; let it begin sooner, move \
             the keyframe later, or write a [source]",
            early.step
        );
        return Err(document.refuse(&format!("{}.step", early.key), why));
    }
    Ok(())
}

/// The step of `[[release]]`, of which there is one at most; `last` is that of the last keyframe.
pub(super) fn release(
    document: &Document,
    raw: Option<Vec<Table>>,
    steps: usize,
    last: usize,
) -> Result<Option<usize>, Failure> {
    let mut tables = raw.unwrap_or_default().into_iter();
    let Some(mut table) = tables.next() else {
        return Ok(None);
    };
    if tables.next().is_some() {
        let why = "is a second release, but a flow that is free is not steered again; write one, and the keyframes before it";
        return Err(document.refuse("release[1]", why));
    }
    document.only("release[0]", &table, &["from"])?;
    let key = "release[0].from";
    let remedy = "write the step from which no force acts, as in from = 40";
    let from = document.required(key, table.remove("from"), remedy)?;
    // Beyond the end there is more to say than which numbers are allowed.
    let from = document.whole_value(key, &from, 2..=MAX_STEPS)?;
    if from >= steps {
        let why = format!(
            "is {from}, but the scene ends at step {steps}, and nothing would be left to blow away; raise `time.steps`, or release the smoke \
             sooner"
        );
        return Err(document.refuse(key, why));
    }
    if from < last {
        let why = format!(
            "is {from}, but a keyframe stands at step {last}, to which no force would lead; release the smoke there or later"
        );
        return Err(document.refuse(key, why));
    }
    Ok(Some(from))
}

/// Pairs of step and factor, by ascending steps.
pub(super) fn schedule(
    document: &Document,
    raw: Option<Value>,
    steps: usize,
) -> Result<Vec<(usize, f64)>, Failure> {
    let key = "control.schedule";
    let wanted = "a list of pairs, as in [[0, 1.0], [40, 0.1]],";
    let items = match raw {
        None => return Ok(Vec::new()),
        Some(Value::Array(items)) if !items.is_empty() => items,
        Some(other) => return Err(document.outside(key, shown(&other), wanted)),
    };
    let mut pairs: Vec<(usize, f64)> = Vec::new();
    for (index, item) in items.iter().enumerate() {
        let key = format!("{key}[{index}]");
        let Some([step, factor]) = item.as_array().map(Vec::as_slice) else {
            return Err(document.outside(&key, shown(item), "a pair of step and factor, as in [40, 0.1],"));
        };
        let step = document.whole_value(&format!("{key}[0]"), step, 0..=steps)?;
        let factor = document.positive_value(&format!("{key}[1]"), factor)?;
        if let Some(&(before, _)) = pairs.last()
            && step <= before
        {
            let why =
                format!("is step {step} after step {before}; write the steps in their order, each once");
            return Err(document.refuse(&key, why));
        }
        pairs.push((step, factor));
    }
    Ok(pairs)
}

/// The acceleration where the density is 1: `buoyancy` times the direction against gravity, which is the last axis where nothing is said.
pub(super) fn buoyancy(
    document: &Document,
    buoyancy: Option<f64>,
    gravity: Option<Vec<f64>>,
    grid: &Grid,
) -> Result<[f64; 3], Failure> {
    let dims = grid.cells.len();
    let strength = document.number("flow.buoyancy", buoyancy.unwrap_or(0.0), Numbers::Finite)?;
    let mut up = [0.0; 3];
    match gravity {
        None => up[dims - 1] = 1.0,
        Some(gravity) => {
            let key = "flow.gravity";
            let length = gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
            if gravity.len() != dims || !(length > 0.0 && length.is_finite()) {
                let wanted = format!(
                    "a direction of {dims} numbers, not all 0, as in {},",
                    if dims == 2 { "[0, -1]" } else { "[0, 0, -1]" }
                );
                return Err(document.outside(key, format_args!("{gravity:?}"), wanted));
            }
            up.iter_mut().zip(&gravity).for_each(|(up, x)| *up = -x / length);
        }
    }
    // The sum is 0, not -0, along the other axes.
    Ok(up.map(|part| strength * part + 0.0))
}
