//! From the raw sections to a checked [`Scene`].

use crate::exit::Failure;
use crate::scene::check::shown;
use crate::scene::document::Document;
use crate::scene::raw::{
    RawAdmm, RawAdvection, RawControl, RawDirect, RawFlow, RawGrid, RawLbfgs, RawMethod, RawPd, RawScene,
    RawSimulation, RawTime, read,
};
use crate::scene::{Control, Flow, Grid, MethodSection, Output, Scene, Time, shapes};
use core::ops::RangeInclusive;
use std::path::PathBuf;
use thurible_core::problem::{MAX_FILTERS, MAX_STEPS};
use thurible_core::words::UnknownWord;
use thurible_core::{
    AdmmParams, Advection, Boundary, DirectParams, LbfgsParams, Method, Named, NsoParams, Params, PdParams,
    Problem, SimulationParams,
};
use toml::Value;

/// More than any run needs.
const MOST_ITERATIONS: i64 = 1_000_000;
/// In scaled numbers: it spreads motion over the whole box in a step.
const MOST_VISCOSITY: f64 = 1.0;
/// Weights in scaled numbers (dt = length = 1) within which single precision keeps its digits.
const WEIGHTS: RangeInclusive<f64> = 1e-15..=1e15;

/// What a scene leaves out.
fn standard() -> Problem<'static> {
    Problem::new(&[], &[], &[])
}

pub(super) fn scene(document: Document) -> Result<Scene, Failure> {
    let mut raw: RawScene = read(&document, "", Value::Table(document.table().clone()))?;
    let tables = raw.keyframe.take();
    let mut scene = build(document, raw)?;
    scene.keyframes = shapes::keyframes(&scene.document, tables, scene.time.steps)?;
    Ok(scene)
}

/// A scene whose flow is free: without keyframes.
pub(super) fn free(document: Document) -> Result<Scene, Failure> {
    let raw: RawScene = read(&document, "", Value::Table(document.table().clone()))?;
    let mut scene = build(document, raw)?;
    scene.method.name = Method::Simulate;
    Ok(scene)
}

/// All but the keyframes.
fn build(document: Document, raw: RawScene) -> Result<Scene, Failure> {
    let grid = grid(&document, raw.grid)?;
    let time = time(&document, raw.time)?;
    let flow = flow(&document, raw.flow, &grid, time)?;
    let control = control(&document, raw.control)?;
    let advection = advection(&document, raw.advection)?;
    let method = method(&document, raw.method)?;
    let unit = grid.length / time.dt;
    check_weight(
        &document,
        "control.force_weight",
        control.force_weight,
        (unit / time.dt).powi(2),
    )?;
    check_weight(
        &document,
        "method.admm.penalty",
        method.admm.penalty,
        unit.powi(2),
    )?;
    let source = shapes::source(&document, raw.source)?;
    let simulation = simulation(&document, raw.simulation)?;
    let folder = raw.output.folder.unwrap_or_else(|| "out".into());
    if folder.is_empty() {
        return Err(document.refuse("output.folder", "is empty; write the name of a folder"));
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
        keyframes: Vec::new(),
        flow,
        control,
        advection,
        method,
        simulation,
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
        .map(|(axis, &count)| document.whole(&format!("grid.cells[{axis}]"), count, 4..=4096));
    Ok(Grid {
        cells: checked.collect::<Result<_, _>>()?,
        boundary: boundary(document, raw.boundary, cells.len())?,
        length: document.positive("grid.length", raw.length.unwrap_or(standard().length))?,
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
        Some(Value::Array(words)) if words.len() == axes => words
            .iter()
            .enumerate()
            .map(|(axis, word)| match word {
                Value::String(word) => document.word(&format!("{key}[{axis}]"), word),
                other => Err(document.outside(&format!("{key}[{axis}]"), shown(other), &known.to_string())),
            })
            .collect(),
        Some(other) => Err(document.outside(key, shown(&other), &wanted)),
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
        steps: document.whole("time.steps", steps, 2..=MAX_STEPS as i64)?,
        dt: document.positive("time.dt", raw.dt.unwrap_or(standard().dt))?,
    })
}

fn flow(document: &Document, raw: RawFlow, grid: &Grid, time: Time) -> Result<Flow, Failure> {
    let key = "flow.viscosity";
    let viscosity = document.not_negative(key, raw.viscosity.unwrap_or(standard().viscosity))?;
    let scaled = viscosity * time.dt / (grid.length * grid.length);
    if scaled > MOST_VISCOSITY {
        let why = format!(
            "is {viscosity:?}, which in units of dt and length is {scaled:e}, but at most {MOST_VISCOSITY} flows at all; make it smaller"
        );
        return Err(document.refuse(key, why));
    }
    Ok(Flow { viscosity })
}

fn control(document: &Document, raw: RawControl) -> Result<Control, Failure> {
    let key = "control.filters";
    let filters = match raw.filters {
        None => None,
        Some(Value::String(word)) if word == "auto" => None,
        Some(Value::Integer(count)) => Some(document.whole(key, count, 0..=MAX_FILTERS as i64)?),
        Some(other) => {
            return Err(document.outside(
                key,
                shown(&other),
                &format!("\"auto\" or a whole number from 0 to {MAX_FILTERS}"),
            ));
        }
    };
    Ok(Control {
        force_weight: document.positive(
            "control.force_weight",
            raw.force_weight.unwrap_or(standard().force_weight),
        )?,
        filters,
        match_mass: raw.match_mass.unwrap_or(standard().match_mass),
        initial_velocity: initial_velocity(document, raw.initial_velocity)?,
    })
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

fn advection(document: &Document, raw: RawAdvection) -> Result<Advection, Failure> {
    let Advection { scheme, tolerance } = Advection::default();
    Ok(Advection {
        scheme: word(document, "advection.scheme", raw.scheme, scheme)?,
        tolerance: document.between("advection.tolerance", raw.tolerance.unwrap_or(tolerance), 1.0)?,
    })
}

/// A count, or the one that is meant where there is none.
fn whole(
    document: &Document,
    key: &str,
    count: Option<i64>,
    allowed: RangeInclusive<i64>,
    standard: usize,
) -> Result<usize, Failure> {
    count.map_or(Ok(standard), |count| document.whole(key, count, allowed))
}

/// The choice that a word stands for, or the one that is made where there is none.
fn word<T: Named>(document: &Document, key: &str, word: Option<String>, standard: T) -> Result<T, Failure> {
    word.map_or(Ok(standard), |word| document.word(key, &word))
}

/// A method that steers: a scene is simulated by a command of its own.
fn method_name(document: &Document, word: Option<String>) -> Result<Method, Failure> {
    let steers: Vec<Method> = Method::ALL
        .iter()
        .copied()
        .filter(|&method| method != Method::Simulate)
        .collect();
    word.map_or_else(
        || Ok(Method::default()),
        |word| document.one_of("method.name", &word, &steers),
    )
}

fn method(document: &Document, raw: RawMethod) -> Result<MethodSection, Failure> {
    let projection = raw
        .projection
        .tolerance
        .unwrap_or(standard().projection_tolerance);
    Ok(MethodSection {
        name: method_name(document, raw.name)?,
        iterations: whole(
            document,
            "method.iterations",
            raw.iterations,
            1..=MOST_ITERATIONS,
            Params::default().iterations,
        )?,
        direct: direct(document, raw.direct)?,
        admm: admm(document, raw.admm)?,
        lbfgs: lbfgs(document, raw.lbfgs)?,
        pd: pd(document, raw.pd)?,
        projection_tolerance: document.between("method.projection.tolerance", projection, 1.0)?,
    })
}

/// A weight must be of reasonable size in scaled numbers, whatever the scene's units.
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

fn lbfgs(document: &Document, raw: RawLbfgs) -> Result<LbfgsParams, Failure> {
    let standard = LbfgsParams::default();
    Ok(LbfgsParams {
        history: whole(
            document,
            "method.lbfgs.history",
            raw.history,
            1..=LbfgsParams::MOST as i64,
            standard.history,
        )?,
        tolerance: document.between(
            "method.lbfgs.tolerance",
            raw.tolerance.unwrap_or(standard.tolerance),
            1.0,
        )?,
        nested: raw.nested.unwrap_or(standard.nested),
    })
}

fn pd(document: &Document, raw: RawPd) -> Result<PdParams, Failure> {
    let standard = PdParams::default();
    Ok(PdParams {
        drive: document.not_negative("method.pd.drive", raw.drive.unwrap_or(standard.drive))?,
        attenuation: document.not_negative(
            "method.pd.attenuation",
            raw.attenuation.unwrap_or(standard.attenuation),
        )?,
        gathering: document
            .not_negative("method.pd.gathering", raw.gathering.unwrap_or(standard.gathering))?,
    })
}

fn simulation(document: &Document, raw: RawSimulation) -> Result<SimulationParams, Failure> {
    let standard = SimulationParams::default();
    Ok(SimulationParams {
        buoyancy: document.finite("simulation.buoyancy", raw.buoyancy.unwrap_or(standard.buoyancy))?,
        tolerance: document.between(
            "simulation.tolerance",
            raw.tolerance.unwrap_or(standard.tolerance),
            1.0,
        )?,
    })
}

fn direct(document: &Document, raw: RawDirect) -> Result<DirectParams, Failure> {
    let key = "method.direct.history";
    let history = match raw.history {
        None => None,
        Some(Value::String(word)) if word == "auto" => None,
        Some(Value::Integer(count)) => Some(document.whole(key, count, 1..=DirectParams::MOST as i64)?),
        Some(other) => {
            return Err(document.outside(
                key,
                shown(&other),
                &format!("\"auto\" or a whole number from 1 to {}", DirectParams::MOST),
            ));
        }
    };
    let standard = DirectParams::default();
    Ok(DirectParams {
        history,
        tolerance: document.between(
            "method.direct.tolerance",
            raw.tolerance.unwrap_or(standard.tolerance),
            1.0,
        )?,
        nested: raw.nested.unwrap_or(standard.nested),
    })
}

fn admm(document: &Document, raw: RawAdmm) -> Result<AdmmParams, Failure> {
    let key = |name: &str| format!("method.admm.{name}");
    let standard = AdmmParams::default();
    let nso = NsoParams {
        solver: word(document, &key("nso"), raw.nso, standard.nso.solver)?,
        tolerance: document.between(
            &key("nso_tolerance"),
            raw.nso_tolerance.unwrap_or(standard.nso.tolerance),
            1.0,
        )?,
        norm: word(document, &key("nso_norm"), raw.nso_norm, standard.nso.norm)?,
        colours: word(
            document,
            &key("smoother_colours"),
            raw.smoother_colours,
            standard.nso.colours,
        )?,
        ..standard.nso
    };
    Ok(AdmmParams {
        penalty: document.positive(&key("penalty"), raw.penalty.unwrap_or(standard.penalty))?,
        relaxation: document.between(
            &key("relaxation"),
            raw.relaxation.unwrap_or(standard.relaxation),
            2.0,
        )?,
        ao_iterations: whole(
            document,
            &key("ao_iterations"),
            raw.ao_iterations,
            1..=100,
            standard.ao_iterations,
        )?,
        ao_momentum: document.fraction(
            &key("ao_momentum"),
            raw.ao_momentum.unwrap_or(standard.ao_momentum),
        )?,
        density_tolerance: document.between(
            &key("density_tolerance"),
            raw.density_tolerance.unwrap_or(standard.density_tolerance),
            1.0,
        )?,
        nested: raw.nested.unwrap_or(standard.nested),
        nso,
    })
}
