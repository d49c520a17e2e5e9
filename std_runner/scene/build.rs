//! From the raw sections to a checked [`Scene`].

use super::check::{WEIGHTS, shown};
use super::document::Document;
use super::effects;
use super::method::{advection, method};
use super::model::{Control, Flow, Grid, Output, Scene, Time};
use super::raw::{RawControl, RawFlow, RawGrid, RawScene, RawTime, read};
use super::{shapes, templates};
use crate::destination::HOME;
use crate::exit::Failure;
use std::path::{Path, PathBuf};
use thurible_core::choices::Numbers;
use thurible_core::problem::{CELLS, MAX_FILTERS, MAX_SMOOTHNESS, MAX_STEPS, Units};
use thurible_core::words::UnknownWord;
use thurible_core::{Boundary, Method, Named, Problem};
use toml::Value;

/// Largest viscosity in units of dt and length: it spreads motion over the whole box in one step.
const MOST_VISCOSITY: f64 = 1.0;

/// What a scene leaves out.
fn standard() -> Problem<'static> {
    Problem::new(&[], &[], &[])
}

pub(super) fn scene(document: Document) -> Result<Scene, Failure> {
    let mut raw: RawScene = read(&document, "", Value::Table(document.table().clone()))?;
    let (keyframes, release) = (raw.keyframe.take(), raw.release.take());
    let mut scene = build(document, raw, false)?;
    let (document, steps) = (&scene.document, scene.time.steps);
    // Stable Fluids have a force before the first step too.
    let first = if scene.method.fluids.chosen { 1 } else { 2 };
    scene.keyframes = shapes::keyframes(document, keyframes, first..=steps)?;
    let last = scene.keyframes.last().map_or(0, |keyframe| keyframe.stay().last);
    scene.release = effects::release(document, release, steps, last)?;
    templates::check_release(&scene)?;
    effects::check_smoke(&scene)?;
    Ok(scene)
}

/// A scene whose flow is free: without keyframes, and all of it after a release.
pub(super) fn free(document: Document) -> Result<Scene, Failure> {
    let mut raw: RawScene = read(&document, "", Value::Table(document.table().clone()))?;
    // Where nothing steers, what prices a force says nothing.
    raw.control.schedule = None;
    let mut scene = build(document, raw, true)?;
    scene.method.params.method = Method::Simulate;
    scene.control.mask = None;
    Ok(scene)
}

/// All but the keyframes and the release.
fn build(document: Document, raw: RawScene, is_free: bool) -> Result<Scene, Failure> {
    let grid = grid(&document, raw.grid)?;
    let time = time(&document, raw.time)?;
    let flow = flow(&document, raw.flow, &grid, time)?;
    let units = Units::of(grid.length, time.dt);
    let control = control(&document, raw.control, time, units)?;
    let advection = advection(&document, raw.advection)?;
    let templates = templates::templates(&document, raw.template, &grid, time.steps)?;
    let method = method(
        &document,
        raw.method,
        raw.simulation,
        !templates.is_empty(),
        is_free,
        units,
    )?;
    check_weight(
        &document,
        "control.force_weight",
        control.force_weight,
        units.force.powi(2),
    )?;
    check_schedule(&document, &control, units.force.powi(2))?;
    check_weight(
        &document,
        "method.admm.penalty",
        method.params.admm.penalty,
        units.velocity.powi(2),
    )?;
    let emitters = effects::emitters(&document, raw.emitter, (&grid, time))?;
    let obstacles = effects::obstacles(&document, raw.obstacle)?;
    let source = shapes::source(&document, raw.source, &emitters)?;
    let folder = raw.output.folder.unwrap_or_else(|| "out".into());
    if folder.is_empty() {
        return Err(document.refuse("output.folder", "is empty; write the name of a folder"));
    }
    if Path::new(&folder).starts_with("~") {
        return Err(document.refuse("output.folder", HOME));
    }
    let output = Output {
        folder: document.folder().join(folder),
        frames: raw.output.frames.unwrap_or(true),
    };
    Ok(Scene {
        document,
        grid,
        time,
        source,
        emitters,
        obstacles,
        keyframes: Vec::new(),
        release: None,
        templates,
        flow,
        control,
        advection,
        method,
        output,
    })
}

fn grid(document: &Document, raw: Option<RawGrid>) -> Result<Grid, Failure> {
    let raw = document.required("grid", raw, "write [grid] with cells = [128, 128]")?;
    let cells = document.required(
        "grid.cells",
        raw.cells,
        "write two or three numbers, as in cells = [128, 128]",
    )?;
    if !(2..=3).contains(&cells.len()) {
        let found = format!(
            "has {} entries, but only 2 (a plane) or 3 (a box) are allowed; write cells = [nx, ny] or [nx, ny, nz]",
            cells.len()
        );
        return Err(document.refuse("grid.cells", found));
    }
    let checked = cells
        .iter()
        .enumerate()
        .map(|(axis, &count)| document.whole(&format!("grid.cells[{axis}]"), count, CELLS));
    Ok(Grid {
        cells: checked.collect::<Result<_, _>>()?,
        boundary: boundary(document, raw.boundary, cells.len())?,
        length: document.number(
            "grid.length",
            raw.length.unwrap_or(standard().length),
            Numbers::Positive,
        )?,
    })
}

fn boundary(document: &Document, raw: Option<Value>, axes: usize) -> Result<Vec<Boundary>, Failure> {
    let key = "grid.boundary";
    let known = UnknownWord {
        allowed: Boundary::ALL,
    };
    let wanted = format!("{known}, or a list of {axes} such words");
    match raw {
        None => Ok(vec![Boundary::Wall; axes]),
        Some(Value::String(word)) => Ok(vec![document.word(key, &word)?; axes]),
        Some(Value::Array(ends)) if ends.len() == axes => ends
            .iter()
            .enumerate()
            .map(|(axis, ends)| axis_ends(document, &format!("{key}[{axis}]"), ends))
            .collect(),
        Some(other) => Err(document.outside(key, shown(&other), wanted)),
    }
}

/// How one axis ends: a word, or one for each of its sides.
fn axis_ends(document: &Document, key: &str, ends: &Value) -> Result<Boundary, Failure> {
    let known = UnknownWord {
        allowed: Boundary::ALL,
    };
    let wanted = format!("{known}, or a pair of \"wall\" and \"open\" for its low and its high side");
    match ends {
        Value::String(word) => document.word(key, word),
        Value::Array(sides) => match sides
            .iter()
            .map(Value::as_str)
            .collect::<Option<Vec<_>>>()
            .as_deref()
        {
            Some(["wall", "wall"]) => Ok(Boundary::Wall),
            Some(["open", "open"]) => Ok(Boundary::Open),
            Some(["open", "wall"]) => Ok(Boundary::OpenLow),
            Some(["wall", "open"]) => Ok(Boundary::OpenHigh),
            _ => Err(document.outside(key, shown(ends), wanted)),
        },
        other => Err(document.outside(key, shown(other), wanted)),
    }
}

fn time(document: &Document, raw: Option<RawTime>) -> Result<Time, Failure> {
    let raw = document.required("time", raw, "write [time] with steps = 40")?;
    let steps = document.required(
        "time.steps",
        raw.steps,
        "write the number of steps, as in steps = 40",
    )?;
    Ok(Time {
        steps: document.whole("time.steps", steps, 2..=MAX_STEPS)?,
        dt: document.number("time.dt", raw.dt.unwrap_or(standard().dt), Numbers::Positive)?,
    })
}

fn flow(document: &Document, raw: RawFlow, grid: &Grid, time: Time) -> Result<Flow, Failure> {
    let key = "flow.viscosity";
    let viscosity = document.number(
        key,
        raw.viscosity.unwrap_or(standard().viscosity),
        Numbers::NotNegative,
    )?;
    let scaled = viscosity * time.dt / (grid.length * grid.length);
    if scaled > MOST_VISCOSITY {
        let why = format!(
            "is {viscosity:?}, which in units of dt and length is {scaled:e}, but at most {MOST_VISCOSITY} flows at all; make it smaller"
        );
        return Err(document.refuse(key, why));
    }
    let buoyancy = effects::buoyancy(document, raw.buoyancy, raw.gravity, grid)?;
    let slip = raw.slip.unwrap_or(standard().slip);
    if !slip && viscosity == 0.0 {
        let why = "is false, but a flow sticks to walls and obstacles by its viscosity, and flow.viscosity is 0; give it some, or set flow.slip = true";
        return Err(document.refuse("flow.slip", why));
    }
    Ok(Flow {
        viscosity,
        slip,
        buoyancy,
    })
}

fn control(document: &Document, raw: RawControl, time: Time, units: Units) -> Result<Control, Failure> {
    let key = "control.filters";
    let filters = match raw.filters {
        None => None,
        Some(Value::String(word)) if word == "auto" => None,
        Some(Value::Integer(count)) => Some(document.whole(key, count, 0..=MAX_FILTERS)?),
        Some(other) => {
            return Err(document.outside(
                key,
                shown(&other),
                format_args!("\"auto\" or a whole number from 0 to {MAX_FILTERS}"),
            ));
        }
    };
    Ok(Control {
        force_weight: match raw.force_weight {
            Some(weight) => document.number("control.force_weight", weight, Numbers::Positive)?,
            None => units.force_weight(standard().force_weight),
        },
        smoothness: smoothness(document, raw.smoothness)?,
        schedule: effects::schedule(document, raw.schedule, time.steps)?,
        mask: shapes::part(document, "control.mask", raw.mask)?,
        filters,
        match_mass: raw.match_mass.unwrap_or(standard().match_mass),
        initial_velocity: initial_velocity(document, raw.initial_velocity)?,
    })
}

/// Smoothness of the force in cells, or `None` for the default.
fn smoothness(document: &Document, raw: Option<Value>) -> Result<Option<f64>, Failure> {
    let key = "control.smoothness";
    let number = match &raw {
        None => return Ok(None),
        Some(Value::String(word)) if word == "auto" => return Ok(None),
        Some(Value::Float(cells)) => Some(*cells),
        Some(Value::Integer(cells)) => Some(*cells as f64),
        Some(_) => None,
    };
    match (number, raw) {
        (Some(cells), _) if (0.0..=MAX_SMOOTHNESS).contains(&cells) => Ok(Some(cells)),
        (_, raw) => {
            let wanted = format_args!("\"auto\" or a number from 0 to {MAX_SMOOTHNESS}");
            let found = match (number, raw) {
                (Some(cells), _) => format!("{cells:?}"),
                (None, raw) => raw.map_or(String::new(), |value| shown(&value)),
            };
            Err(document.outside(key, found, wanted))
        }
    }
}

fn initial_velocity(document: &Document, raw: Option<Value>) -> Result<Option<PathBuf>, Failure> {
    let key = "control.initial_velocity";
    let found = match raw {
        None => return Ok(None),
        Some(Value::String(word)) if word == "rest" => return Ok(None),
        Some(Value::Table(table)) => match (table.get("file"), table.len()) {
            (Some(Value::String(file)), 1) => return Ok(Some(document.folder().join(file))),
            _ => format!("a table with the keys {:?}", table.keys().collect::<Vec<_>>()),
        },
        Some(other) => shown(&other),
    };
    Err(document.outside(key, found, "\"rest\" or { file = \"v0.npz\" }"))
}

/// Refuses a factor of the schedule with which the weight of the force is out of range in units of dt and length.
fn check_schedule(document: &Document, control: &Control, scale: f64) -> Result<(), Failure> {
    let priced = |&(_, factor): &(usize, f64)| control.force_weight * factor * scale;
    let outside = |pair: &(usize, f64)| !WEIGHTS.contains(&priced(pair));
    let mut pairs = control.schedule.iter().enumerate();
    pairs.find(|(_, pair)| outside(pair)).map_or(Ok(()), |(index, pair)| {
        let why = format!(
            "is {:?}, with which the weight of the force in units of dt and length is {:e}, but only {:e} to {:e} is allowed there; change it \
             or `control.force_weight`",
            pair.1,
            priced(pair),
            WEIGHTS.start(),
            WEIGHTS.end()
        );
        Err(document.refuse(&format!("control.schedule[{index}][1]"), why))
    })
}

/// Refuses a weight that is out of range in units of dt and length.
fn check_weight(document: &Document, key: &str, weight: f64, scale: f64) -> Result<(), Failure> {
    let scaled = weight * scale;
    if WEIGHTS.contains(&scaled) {
        return Ok(());
    }
    let why = format!(
        "is {weight:?}, which in units of dt and length is {scaled:e}, but only {:e} to {:e} is allowed there; change it, `time.dt` or `grid.length`",
        WEIGHTS.start(),
        WEIGHTS.end()
    );
    Err(document.refuse(key, why))
}
