//! What is asked of an export, and what is said of it in the end.

use super::orient::Up;
use super::sink::Manner;
use super::source::Source;
use super::vdb::Codec;
use crate::progress::Mode;
use clap::ValueEnum;
use core::ops::RangeInclusive;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use thurible_core::exec::Ranks;

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Format {
    /// OpenVDB: a file a step, for Blender, Houdini and renderers.
    Vdb,
    /// The same with a USD stage beside it.
    Usd,
    /// VTK's image data with a .pvd: a file a step, for ParaView.
    Vti,
    /// A Zarr group of all arrays, for xarray.
    Zarr,
    /// Vector fields: a file a step, for game engines.
    Fga,
    /// All arrays in one archive of NumPy.
    Npz,
}

/// What is asked for.
pub(crate) struct Request {
    pub result: PathBuf,
    pub folder: PathBuf,
    pub formats: Vec<Format>,
    pub steps: Option<RangeInclusive<usize>>,
    pub up: Option<Up>,
    pub staggered: bool,
    pub half: Option<bool>,
    pub codec: Option<Codec>,
    pub fps: Option<f64>,
    /// The frame that shows step 0.
    pub first_frame: usize,
    pub mode: Mode,
    /// The programs that share the steps, where there are several.
    pub ranks: Option<&'static dyn Ranks>,
}

impl Request {
    /// Whether it writes volumes, whose precision may be half.
    pub fn writes_volumes(&self) -> bool {
        self.formats.iter().any(|format| is_volume(*format))
    }

    /// The words of its formats.
    pub fn names(&self) -> Vec<String> {
        let name = |format: &Format| {
            format
                .to_possible_value()
                .map(|value| value.get_name().to_owned())
        };
        self.formats.iter().filter_map(name).collect()
    }
}

fn is_volume(format: Format) -> bool {
    matches!(format, Format::Vdb | Format::Usd)
}

/// What the `export.json` at `path` says of exports whose files stay: those of formats that are not written now.
pub(super) fn earlier(path: &Path, request: &Request) -> Value {
    let text = fs::read_to_string(path).unwrap_or_default();
    let mut last: Value = serde_json::from_str(&text).unwrap_or_default();
    let before = last.as_object_mut().and_then(|last| last.remove("earlier"));
    let before = before
        .and_then(|before| before.as_array().cloned())
        .unwrap_or_default();
    let goes = |word: &Value| {
        let format = word.as_str().and_then(|word| Format::from_str(word, false).ok());
        format.is_none_or(|format| {
            request.formats.contains(&format) || is_volume(format) && request.writes_volumes()
        })
    };
    let all = [last].into_iter().chain(before);
    let left = all.filter_map(|mut facts| {
        let formats = facts.get_mut("formats")?.as_array_mut()?;
        formats.retain(|word| !goes(word));
        (!formats.is_empty()).then_some(facts)
    });
    Value::Array(left.collect())
}

/// What was written.
pub(super) struct Written {
    pub steps: RangeInclusive<usize>,
    /// The largest density.
    pub largest: f64,
    /// Density in a shader at which that hides what is behind it.
    pub shader: f64,
}

/// What `export.json` says.
pub(super) fn facts(request: &Request, manner: &Manner, source: &Source, written: &Written) -> Value {
    json!({
        "format": 1,
        "kind": "export",
        "version": env!("CARGO_PKG_VERSION"),
        "formats": request.names(),
        "cells": source.said.cells,
        "steps": [written.steps.start(), written.steps.end()],
        "frames": [manner.frame(*written.steps.start()), manner.frame(*written.steps.end())],
        "fps": manner.time.fps,
        "velocity_factor": manner.time.factor,
        "up": manner.up_word(),
        "length": source.said.length,
        "dt": source.said.dt,
        "precision": if manner.half { "half" } else { "float" },
        "largest_density": written.largest,
        "shader_density": written.shader,
    })
}
