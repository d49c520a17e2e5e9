//! `[source]` and `[[keyframe]]`: steps are checked here, the shape by [`ShapeSpec`].

use crate::exit::Failure;
use crate::keyframes::ShapeSpec;
use crate::scene::check::shown;
use crate::scene::document::Document;
use crate::scene::model::{Emission, Keyframe};
use crate::scene::raw::read;
use crate::scene::sequence::Sequence;
use core::ops::RangeInclusive;
use toml::{Table, Value};

/// The source, without which something must emit.
pub(super) fn source(
    document: &Document,
    raw: Option<Table>,
    emitters: &[Emission],
) -> Result<Option<ShapeSpec>, Failure> {
    let remedy = "write [source] with a shape, as in circle = { center = [0.5, 0.5], radius = 0.2 }, or an [[emitter]]";
    match raw {
        None if !emitters.is_empty() => Ok(None),
        raw => shape(document, "source", document.required("source", raw, remedy)?).map(Some),
    }
}

pub(super) fn keyframes(
    document: &Document,
    raw: Option<Vec<Table>>,
    steps: RangeInclusive<usize>,
) -> Result<Vec<Keyframe>, Failure> {
    let remedy = "write [[keyframe]] with a step and a shape, as in step = 40 and text = \"F\"";
    let tables = document.required("keyframe", raw.filter(|tables| !tables.is_empty()), remedy)?;
    let mut keyframes = tables
        .into_iter()
        .enumerate()
        .map(|(index, table)| keyframe(document, index, table, &steps))
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    refuse_overlaps(document, &keyframes)?;
    keyframes.sort_by_key(|keyframe| keyframe.step);
    Ok(keyframes)
}

/// Number `index` in the file, at one of the steps that are allowed: one keyframe, or those of a sequence.
fn keyframe(
    document: &Document,
    index: usize,
    mut table: Table,
    allowed: &RangeInclusive<usize>,
) -> Result<Vec<Keyframe>, Failure> {
    let steps = *allowed.end();
    let key = format!("keyframe[{index}]");
    document.only(
        &key,
        &table,
        &[&["step", "steps", "files", "hold", "region"], ShapeSpec::KEYS].concat(),
    )?;
    let at = format!("{key}.step");
    let sequence = Sequence::taken(document, &key, &mut table, (&["step"], allowed))?;
    let remedy = "write the step it stands at, as in step = 40";
    let step = match sequence {
        Some(_) => 0,
        None => {
            let found = document.required(&at, table.remove("step"), remedy)?;
            document.step_of_keyframe(&at, &found, allowed)?
        }
    };
    let held = table.remove("hold");
    // Beside a text, `weight` is that of its strokes.
    let weight = match table.remove("weight") {
        Some(found) if table.contains_key("text") => {
            table.insert("weight".into(), found);
            1.0
        }
        Some(found) => document.weight_value(&format!("{key}.weight"), &found)?,
        None => 1.0,
    };
    let region = part(document, &format!("{key}.region"), table.remove("region"))?;
    let shapes = match sequence {
        None => vec![(step, shape(document, &key, table)?)],
        Some(sequence) => sequence.shapes(document, &key, table, steps)?,
    };
    let keyframe = |(step, shape)| {
        let hold = match &held {
            None => 0,
            Some(found) => hold(document, &format!("{key}.hold"), found, [step, steps])?,
        };
        Ok(Keyframe {
            step,
            hold,
            shape,
            weight,
            region: region.clone(),
            key: key.clone(),
        })
    };
    shapes.into_iter().map(keyframe).collect()
}

/// A shape that says of which cells something holds, if there is one.
pub(super) fn part(document: &Document, key: &str, raw: Option<Value>) -> Result<Option<ShapeSpec>, Failure> {
    match raw {
        None => Ok(None),
        Some(Value::Table(part)) => shape(document, key, part).map(Some),
        Some(other) => {
            let wanted = "a shape, as in { box = { min = [0, 0], max = [1, 0.5] } },";
            Err(document.outside(key, shown(&other), wanted))
        }
    }
}

/// How long a keyframe at `step` is held, at most to the last of all `steps`.
fn hold(document: &Document, key: &str, found: &Value, [step, steps]: [usize; 2]) -> Result<usize, Failure> {
    let most = steps - step;
    match *found {
        Value::Integer(hold) if usize::try_from(hold).is_ok_and(|hold| hold > most) => {
            let why = format!(
                "is {hold} and reaches from step {step} beyond the end, but the scene ends at step {steps}; raise `time.steps`, or lower \
                 it to at most {most}"
            );
            Err(document.refuse(key, why))
        }
        _ => document.whole_value(key, found, 0..=most),
    }
}

/// Refuses two keyframes, in the order of the file, that stand at the same step; it is the later one in the file that is to give way.
fn refuse_overlaps(document: &Document, keyframes: &[Keyframe]) -> Result<(), Failure> {
    let mut order: Vec<usize> = (0..keyframes.len()).collect();
    order.sort_by_key(|&index| keyframes[index].step);
    // Stays in a row overlap if any do.
    for pair in order.windows(2) {
        let [early, late] = [&keyframes[pair[0]], &keyframes[pair[1]]];
        if !early.stay().contains(late.step) {
            continue;
        }
        return Err(if pair[0] < pair[1] {
            document.refuse(&format!("{}.step", late.key), taken(late.step, early))
        } else {
            document.refuse(&format!("{}.hold", early.key), in_the_way(early, late))
        });
    }
    Ok(())
}

/// Why no keyframe can stand at `step`, where `twin` does.
fn taken(step: usize, twin: &Keyframe) -> String {
    let (key, last) = (&twin.key, twin.stay().last);
    let there = if twin.stay().is_held() {
        format!(
            "`{key}.hold` keeps `{key}` there, from step {} to step {last}",
            twin.step
        )
    } else {
        format!("`{key}` stands at that step already")
    };
    format!("is {step}, but {there}; give each keyframe steps of its own")
}

/// Why `keyframe` cannot be held over `other`, which stands later.
fn in_the_way(keyframe: &Keyframe, other: &Keyframe) -> String {
    format!(
        "is {} and reaches from step {} to step {}, but `{}` stands at step {}; lower it to at most {}",
        keyframe.hold,
        keyframe.step,
        keyframe.stay().last,
        other.key,
        other.step,
        other.step - keyframe.step - 1
    )
}

pub(super) fn shape(document: &Document, key: &str, table: Table) -> Result<ShapeSpec, Failure> {
    read(document, key, Value::Table(table))
}
