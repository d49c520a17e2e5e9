//! `[method]`, `[advection]` and `[simulation]`: how a scene is solved. The choices of each method are those of its table in the core.

use super::check::shown;
use super::document::Document;
use super::model::{FluidsSection, MethodSection};
use super::raw::{RawAdvection, RawProjection, read};
use crate::exit::Failure;
use crate::windows::Windows;
use thurible_core::choices::{self, Choices, Kind, Numbers};
use thurible_core::method::registry::steers;
use thurible_core::problem::{MAX_STEPS, Units};
use thurible_core::solver::MAX_ITERATIONS;
use thurible_core::stable_fluids::{self, Controls};
use thurible_core::words::one_of;
use thurible_core::{Advection, Method, Named, Params, Problem};
use toml::{Table, Value};

/// Numbers that parts and relative residuals may be.
const PART: Numbers = Numbers::Below(1.0);

pub(super) fn advection(document: &Document, raw: RawAdvection) -> Result<Advection, Failure> {
    let Advection { scheme, tolerance } = Advection::default();
    let word = |word: String| document.word("advection.scheme", &word);
    Ok(Advection {
        scheme: raw.scheme.map_or(Ok(scheme), word)?,
        tolerance: document.number("advection.tolerance", raw.tolerance.unwrap_or(tolerance), PART)?,
    })
}

/// The methods that steer, from which a scene chooses: it is simulated by a command of its own.
pub(crate) fn steering() -> Vec<Method> {
    let steered = |&method: &Method| {
        steers(&Params {
            method,
            ..Params::default()
        })
    };
    Method::ALL.iter().copied().filter(steered).collect()
}

/// The key of the table in which a scene makes the choices of `method`: within `[method]` where that table has the method's name.
pub(crate) fn section(method: Method) -> String {
    let group = Params::default().choices(method).group();
    if group == method.name() {
        format!("method.{group}")
    } else {
        group.into()
    }
}

/// `[method]` as `method` has it, with the choices of `[simulation]`, which concern several methods. Where it has no name a scene with
/// templates is solved by them. What is left out is that of a box and steps of length 1, in the scene's `units`.
pub(super) fn method(
    document: &Document,
    method: Option<Value>,
    mut simulation: Option<Value>,
    templates: bool,
    is_free: bool,
    units: Units,
) -> Result<MethodSection, Failure> {
    let mut table = table(document, "method", method)?;
    let sections: Vec<String> = Method::ALL.iter().map(|&method| section(method)).collect();
    let within = sections.iter().filter_map(|key| key.strip_prefix("method."));
    let known = ["name", "iterations", "window", "stride"]
        .into_iter()
        .chain(within);
    let known = known.chain(["projection", stable_fluids::NAME]);
    document.only("method", &table, &known.collect::<Vec<_>>())?;
    let (mut params, chosen) = name_and_iterations(document, &mut table, templates)?;
    params.admm.penalty = units.penalty(params.admm.penalty);
    if chosen
        && let Some(key) = ["window", "stride"]
            .into_iter()
            .find(|key| table.contains_key(*key))
    {
        let why = format!(
            "is more than the method {} can do; leave it out",
            stable_fluids::NAME
        );
        return Err(document.refuse(&format!("method.{key}"), why));
    }
    let fluids = FluidsSection {
        chosen,
        ..fluids(document, table.remove(stable_fluids::NAME), params.iterations)?
    };
    let windows = windows(document, &mut table, (!is_free).then_some(params.method))?;
    let projection = table.remove("projection");
    for (&method, key) in Method::ALL.iter().zip(&sections) {
        let given = match key.strip_prefix("method.") {
            Some(name) => table.remove(name),
            None => simulation.take(),
        };
        choose(document, key, given, params.choices_mut(method))?;
    }
    if params.guide.smoothness + params.guide.kinetic == 0.0 {
        let why =
            "is 0, and so is `kinetic`: one of them must be above 0, or a correction would have no price";
        return Err(document.refuse("method.guide.smoothness", why));
    }
    Ok(MethodSection {
        params,
        windows,
        projection_tolerance: projection_tolerance(document, projection)?,
        fluids,
    })
}

/// `[method.stable_fluids]`.
fn fluids(document: &Document, given: Option<Value>, iterations: usize) -> Result<FluidsSection, Failure> {
    let key = format!("method.{}", stable_fluids::NAME);
    let mut table = table(document, &key, given)?;
    let mut section = FluidsSection::default();
    if let Some(control) = table.remove("control") {
        let key = format!("{key}.control");
        let words: Vec<String> = read(document, &key, control)?;
        if words.is_empty() {
            let why =
                "is empty, so that there is nothing to search for; write control = [\"initial_velocity\"]";
            return Err(document.refuse(&key, why));
        }
        section.params.controls = Controls::none();
        for (index, word) in words.iter().enumerate() {
            let control = document.word(&format!("{key}[{index}]"), word)?;
            section.params.controls = section.params.controls.with(control);
        }
    }
    match table.remove("slots") {
        None => {}
        Some(Value::String(word)) if word == "auto" => {}
        Some(Value::Integer(count)) => {
            section.slots = Some(document.whole(&format!("{key}.slots"), count, 0..=MAX_STEPS)?);
        }
        Some(other) => {
            let wanted = format!("\"auto\" or a whole number from 0 to {MAX_STEPS}");
            return Err(document.outside(&format!("{key}.slots"), shown(&other), wanted));
        }
    }
    let mut known: Vec<&str> = section.params.table().iter().map(|choice| choice.name).collect();
    known.extend(["control", "slots"]);
    document.only(&key, &table, &known)?;
    let rest = Some(Value::Table(table));
    choose(document, &key, rest, &mut section.params)?;
    section.params.iterations = iterations;
    Ok(section)
}

/// The parameters with the method and the iterations of `[method]`, which are taken out of its `table`, and whether it is Stable Fluids.
fn name_and_iterations(
    document: &Document,
    table: &mut Table,
    templates: bool,
) -> Result<(Params, bool), Failure> {
    let (mut params, mut fluids) = (Params::default(), false);
    if templates {
        params.method = Method::Templates;
    }
    if let Some(word) = table.remove("name") {
        let (key, steering) = ("method.name", steering());
        let word = read::<String>(document, key, word)?;
        fluids = word == stable_fluids::NAME;
        if !fluids {
            params.method = one_of(&steering, &word).map_err(|known| {
                let allowed = format!("{known} or \"{}\"", stable_fluids::NAME);
                document.outside(key, format!("\"{word}\""), allowed)
            })?;
        }
    }
    if let Some(count) = table.remove("iterations") {
        let key = "method.iterations";
        params.iterations = document.whole(key, read(document, key, count)?, 1..=MAX_ITERATIONS)?;
    }
    Ok((params, fluids))
}

/// `window` and `stride`, which are taken out of `table`, for a flow that nothing steers, or by a method that can be left and taken up again.
fn windows(
    document: &Document,
    table: &mut Table,
    steers: Option<Method>,
) -> Result<Option<Windows>, Failure> {
    let (window, stride) = (table.remove("window"), table.remove("stride"));
    let key = "method.stride";
    let Some(window) = window else {
        let why = "stands without `window`, whose next one it would begin; write window = 40, or take it out";
        return stride.map_or(Ok(None), |_| Err(document.refuse(key, why)));
    };
    if let Some(method @ (Method::Templates | Method::Pd)) = steers {
        let why = format!(
            "is more than the method {} can do, whose {}; leave it out, or take the method {}",
            method.name(),
            match method {
                Method::Templates => "templates are searched for all steps at once",
                _ => "force looks for a keyframe however far it is",
            },
            Method::Direct.name()
        );
        return Err(document.refuse("method.window", why));
    }
    let length = document.whole_value("method.window", &window, 2..=MAX_STEPS)?;
    let stride = match stride {
        None => length / 2,
        Some(stride) => document.whole_value(key, &stride, 1..=MAX_STEPS)?,
    };
    if stride >= length {
        let why = format!(
            "is {stride}, but a window of {length} steps knows no velocity from which another could begin so late; make it {} at most",
            length - 1
        );
        return Err(document.refuse(key, why));
    }
    Ok(Some(Windows { length, stride }))
}

fn projection_tolerance(document: &Document, raw: Option<Value>) -> Result<f64, Failure> {
    let key = "method.projection";
    let raw: RawProjection = raw.map_or(Ok(RawProjection::default()), |raw| read(document, key, raw))?;
    let standard = Problem::new(&[], &[], &[]).projection_tolerance;
    document.number(
        &format!("{key}.tolerance"),
        raw.tolerance.unwrap_or(standard),
        PART,
    )
}

/// What stands at `key`, which must be a table if it is there.
fn table(document: &Document, key: &str, given: Option<Value>) -> Result<Table, Failure> {
    given.map_or(Ok(Table::new()), |given| read(document, key, given))
}

/// Says of a key that had its place here in earlier versions where it is now.
fn refuse_what_moved(document: &Document, key: &str, table: &Table) -> Result<(), Failure> {
    if key == "simulation" && table.contains_key("buoyancy") {
        let why = "is not there any more: its place is `flow.buoyancy`, where it serves every method; write it under [flow]";
        return Err(document.refuse("simulation.buoyancy", why));
    }
    Ok(())
}

/// Makes the choices of the table at `key`.
pub(crate) fn choose(
    document: &Document,
    key: &str,
    given: Option<Value>,
    choices: &mut dyn Choices,
) -> Result<(), Failure> {
    let table = table(document, key, given)?;
    refuse_what_moved(document, key, &table)?;
    let all = choices.table();
    document.only(
        key,
        &table,
        &all.iter().map(|choice| choice.name).collect::<Vec<_>>(),
    )?;
    for (index, choice) in all.iter().enumerate() {
        let key = format!("{key}.{}", choice.name);
        let Some(given) = table.get(choice.name) else {
            continue;
        };
        if !choices.set(index, chosen(document, &key, given, choice.kind)?) {
            return Err(document.outside(&key, shown(given), choice.kind));
        }
    }
    Ok(())
}

/// What `given` at `key` chooses; no word where it is one that is not allowed.
fn chosen(
    document: &Document,
    key: &str,
    given: &Value,
    kind: Kind,
) -> Result<choices::Value<'static>, Failure> {
    let copy = || given.clone();
    Ok(match (kind, given) {
        (Kind::Number(numbers), _) => {
            choices::Value::Number(document.number(key, read(document, key, copy())?, numbers)?)
        }
        (Kind::Automatic(_), Value::String(word)) if word == "auto" => choices::Value::Automatic,
        (Kind::Automatic(most), other) => {
            let count = other.as_integer().and_then(|count| usize::try_from(count).ok());
            let allowed = count.filter(|count| (1..=most).contains(count));
            choices::Value::Count(allowed.ok_or_else(|| document.outside(key, shown(other), kind))?)
        }
        (Kind::Count(most), _) => {
            choices::Value::Count(document.whole(key, read(document, key, copy())?, 1..=most)?)
        }
        (Kind::Flag, _) => choices::Value::Flag(read(document, key, copy())?),
        (Kind::Word(words), _) => {
            let given: String = read(document, key, copy())?;
            let known = words.iter().copied().find(|word| *word == given);
            choices::Value::Word(known.unwrap_or_default())
        }
    })
}
