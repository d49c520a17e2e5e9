//! A Zarr group, version 3: every array of the result, a chunk for each step, with coordinates and units. xarray opens it as it is.

use super::arrays::{Counts, Held, arrays, encoded, number_bytes};
use super::sink::{SMOKE, Sink};
use super::source::{Frame, Source};
use crate::exit::Failure;
use crate::output::{OutputError, create_folder, write_bytes};
use core::ops::RangeInclusive;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The group.
pub(super) struct Group {
    arrays: Vec<Held>,
    /// The first step.
    first: usize,
}

impl Group {
    /// That of `source` from step `first` on.
    pub fn of(source: &Source, first: usize) -> Result<Self, Failure> {
        let arrays = arrays(source)?;
        Ok(Self { arrays, first })
    }
}

fn name() -> PathBuf {
    format!("{SMOKE}.zarr").into()
}

impl Sink for Group {
    fn parts(&self) -> Vec<PathBuf> {
        vec![name()]
    }

    fn step(&mut self, folder: &Path, source: &mut Source, frame: &Frame) -> Result<(), OutputError> {
        for held in &mut self.arrays {
            let grows =
                !matches!(held.counts, Counts::Keyframe | Counts::Nothing) && !held.shape().is_empty();
            if grows && held.entries(&(frame.step..=frame.step)).contains(&frame.step) {
                let path = folder.join(name()).join(&held.name);
                put_entry(&path, held, source, [frame.step, frame.step - self.first])?;
            }
        }
        Ok(())
    }

    fn finish(
        &mut self,
        folder: &Path,
        source: &mut Source,
        steps: RangeInclusive<usize>,
    ) -> Result<(), OutputError> {
        let group = folder.join(name());
        let mut lengths = BTreeMap::new();
        for held in &mut self.arrays {
            let path = group.join(&held.name);
            let entries = held.entries(&steps);
            let stays = matches!(held.counts, Counts::Keyframe | Counts::Nothing);
            if entries.is_empty() {
                continue;
            }
            let shape = held.whole(entries.len());
            let names = held.dimensions.iter().cloned();
            lengths.extend(names.zip(shape.iter().copied()));
            let mut chunk = shape.clone();
            if held.shape().is_empty() {
                // A list of numbers is one chunk, and so is a number.
                let mut all = Vec::new();
                for entry in entries {
                    all.extend(held.bytes(source, entry).map_err(OutputError::Source)?);
                }
                let place: &[usize] = if held.is_number() { &[] } else { &[0] };
                put_chunk(&path, place, &all)?;
            } else {
                if let Some(first) = chunk.first_mut() {
                    *first = 1;
                }
                for entry in entries.filter(|_| stays) {
                    put_entry(&path, held, source, [entry, entry])?;
                }
            }
            let (unit, said) = about(&held.name, source);
            put_array(
                &path,
                &held.kind,
                [&shape, &chunk],
                &held.dimensions,
                json!({ "units": unit, "long_name": said }),
            )?;
        }
        coordinates(&group, source, &lengths, *steps.start())?;
        let about = json!({
            "title": "smoke",
            "source": concat!("thurible ", env!("CARGO_PKG_VERSION")),
            "length": source.said.length,
            "dt": source.said.dt,
        });
        let text = json!({ "zarr_format": 3, "node_type": "group", "attributes": about });
        write_bytes(&group.join("zarr.json"), format!("{text:#}\n").as_bytes())
    }
}

/// Writes entry `from` of an array as number `to`.
fn put_entry(
    path: &Path,
    held: &mut Held,
    source: &Source,
    [from, to]: [usize; 2],
) -> Result<(), OutputError> {
    let bytes = held.bytes(source, from).map_err(OutputError::Source)?;
    let mut place = vec![0; held.shape().len() + 1];
    if let Some(first) = place.first_mut() {
        *first = to;
    }
    put_chunk(path, &place, &bytes)
}

fn put_chunk(array: &Path, place: &[usize], bytes: &[u8]) -> Result<(), OutputError> {
    let below = place.iter().map(usize::to_string);
    let path = below.fold(array.join("c"), |path, part| path.join(part));
    create_folder(path.parent().unwrap_or(array))?;
    write_bytes(&path, bytes)
}

/// Writes what an array is.
fn put_array(
    path: &Path,
    kind: &str,
    [shape, chunk]: [&[usize]; 2],
    dimensions: &[String],
    attributes: Value,
) -> Result<(), OutputError> {
    let letter = kind.chars().next().unwrap_or('f');
    let bits = 8 * number_bytes(kind);
    let (kind, fill) = match letter {
        'f' => (format!("float{bits}"), json!(0.0)),
        'b' => ("bool".to_owned(), json!(false)),
        'u' => (format!("uint{bits}"), json!(0)),
        _ => (format!("int{bits}"), json!(0)),
    };
    let text = json!({
        "zarr_format": 3,
        "node_type": "array",
        "shape": shape,
        "data_type": kind,
        "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": chunk } },
        "chunk_key_encoding": { "name": "default", "configuration": { "separator": "/" } },
        "fill_value": fill,
        "codecs": [{ "name": "bytes", "configuration": { "endian": "little" } }],
        "attributes": attributes,
        "dimension_names": dimensions,
    });
    create_folder(path)?;
    write_bytes(&path.join("zarr.json"), format!("{text:#}\n").as_bytes())
}

/// Writes where cells and faces are, and when steps.
fn coordinates(
    group: &Path,
    source: &Source,
    lengths: &BTreeMap<String, usize>,
    first: usize,
) -> Result<(), OutputError> {
    let (side, dt) = (source.said.side(), source.said.dt);
    for (name, &count) in lengths {
        let at = |offset: f64, size: f64| (0..count).map(|k| (k as f64 + offset) * size).collect::<Vec<_>>();
        let (values, unit, said) = match name.as_str() {
            "x" | "y" | "z" => (at(0.5, side), "m", "middle of a cell"),
            "x_face" | "y_face" | "z_face" => (at(0.0, side), "m", "face between two cells"),
            "time" => (at(first as f64, dt), "s", "time of a density"),
            "flow_time" => (
                at(first as f64, dt),
                "s",
                "time from which a flow carries a step on",
            ),
            "force_time" => (at(first as f64, dt), "s", "time of the flow that a force changes"),
            _ => continue,
        };
        let path = group.join(name);
        put_chunk(&path, &[0], &encoded("f8", &values))?;
        let shape: &[usize] = &[count];
        let attributes = json!({ "units": unit, "long_name": said });
        put_array(
            &path,
            "f8",
            [shape, shape],
            core::slice::from_ref(name),
            attributes,
        )?;
    }
    Ok(())
}

/// The unit of an array, with lengths in metres and times in seconds, and what it is.
fn about(name: &str, source: &Source) -> (&'static str, &'static str) {
    let of = |base: &str| name.strip_prefix(base).is_some_and(|end| end.starts_with('_'));
    match name {
        "density" => ("1", "density of smoke"),
        "captured" => ("1", "density that was given"),
        "emission" => ("1", "density that emitters added after a step"),
        "solid" => ("1", "solid cells"),
        "mask" => ("1", "where force may act"),
        "keyframe_density" => ("1", "target of a keyframe"),
        "keyframe_step" => ("1", "step of a keyframe"),
        _ if of("velocity") && source.said.centred => ("m s-1", "component of the velocity in cells"),
        _ if of("velocity") => ("m s-1", "component of the velocity on faces"),
        _ if of("force") && source.said.centred => ("m s-2", "component of the force in cells"),
        _ if of("force") => ("m s-2", "component of the force on faces"),
        _ if of("predicted") || of("correction") || of("truth") => {
            ("m s-1", "component of a velocity on faces")
        }
        _ => ("1", ""),
    }
}
