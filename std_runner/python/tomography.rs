//! `tomography`: density from what cameras see of it, on NumPy's arrays.

use crate::arrays::untyped;
use crate::inputs::precision_of;
use crate::plan::Precision;
use crate::reconstruct::Job;
use crate::reconstructed::Tomography;
use crate::words::{flag, is_automatic, number, read, refused, unknown, whole_if_any, word};
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use thurible_core::Named;
use thurible_core::tomography::Settings;

/// Finds the density of smoke in `cells` = (nx, ny) or (nx, ny, nz) from one picture of each camera, or from as many frames of each.
///
/// A picture has the shape (rows, columns), in a plane (columns,), with frames as the axis before; its dtype is the precision. `cameras` and `novel`
/// are dicts as in report.json of `thurible tomography`, in cells. `options` are those of `[tomography]` in a file of views.
#[pyfunction]
#[pyo3(signature = (pictures, cameras, cells, *, novel=None, method=None, prior=None, gamma=None, options=None, memory_limit=None), text_signature = "(pictures, cameras, cells, *, novel=None, method='walk', prior='sad', gamma='auto', options=None, memory_limit=None)")]
pub fn tomography<'py>(
    pictures: Vec<Bound<'py, PyAny>>,
    cameras: Vec<Bound<'py, PyAny>>,
    cells: &Bound<'py, PyAny>,
    novel: Option<Vec<Bound<'py, PyAny>>>,
    method: Option<Bound<'py, PyAny>>,
    prior: Option<Bound<'py, PyAny>>,
    gamma: Option<Bound<'py, PyAny>>,
    options: Option<Bound<'py, PyAny>>,
    memory_limit: Option<Bound<'py, PyAny>>,
) -> PyResult<Tomography> {
    let cells: Vec<usize> = read("cells", cells, "(nx, ny) or (nx, ny, nz)")?;
    if !(2..=3).contains(&cells.len()) {
        return Err(refused(
            "cells",
            format!("is {cells:?}; give (nx, ny) or (nx, ny, nz)"),
        ));
    }
    let Some(first) = pictures.first().filter(|_| pictures.len() == cameras.len()) else {
        let why = format!(
            "has {} entries, and there are {} cameras; give an array for each, and at least one",
            pictures.len(),
            cameras.len()
        );
        return Err(refused("pictures", why));
    };
    let mut settings = Settings {
        budget: Settings::automatic_budget(
            cells.iter().copied().fold(1, usize::saturating_mul),
            cameras.len(),
        ),
        ..Settings::default()
    };
    let mut automatic = true;
    let options = options.filter(|options| !options.is_none());
    let options: Option<Bound<'py, PyMapping>> = options
        .map(|options| read("options", &options, "a dict"))
        .transpose()?;
    let given: Vec<(String, Bound<'py, PyAny>)> = match options {
        Some(options) => options.items()?.extract()?,
        None => Vec::new(),
    };
    let own = [("method", method), ("prior", prior), ("gamma", gamma)];
    let own = own
        .into_iter()
        .filter_map(|(name, value)| Some((name.to_owned(), value?)));
    let mut volume = None;
    for (name, value) in given.into_iter().chain(own) {
        match name.as_str() {
            "gamma" if is_automatic(&value) => automatic = true,
            "gamma" => (settings.gamma, automatic) = (number("gamma", &value)?, false),
            "volume" => volume = Some(flag("volume", &value)?),
            _ => set(&mut settings, &name, &value)?,
        }
    }
    if volume == Some(false) && settings.prior.on_images().is_none() {
        let prior = settings.prior.name();
        let why = format!(
            "is False, but the prior {prior} is on the volume; take image_tv or image_sad, or leave it out"
        );
        return Err(refused("volume", why));
    }
    settings.volume = volume.unwrap_or(settings.prior.on_images().is_none());
    let found = untyped("pictures[0]", first)?;
    let (axes, shape) = (found.ndim(), found.shape().to_vec());
    if axes != cells.len() && axes + 1 != cells.len() {
        let why = format!(
            "has {axes} axes; give rows and columns (in a plane columns alone), with frames before them"
        );
        return Err(refused("pictures[0]", why));
    }
    let precision = precision_of("pictures[0]", found)?;
    let job = Job {
        frames: (axes == cells.len()).then(|| shape[0]),
        pictures,
        cameras,
        novel: novel.unwrap_or_default(),
        cells,
        settings,
        automatic,
        memory_limit: whole_if_any("memory_limit", memory_limit.as_ref())?,
    };
    match (job.cells.len(), precision) {
        (2, Precision::Single) => job.run::<f32, 2>(precision),
        (2, Precision::Double) => job.run::<f64, 2>(precision),
        (_, Precision::Single) => job.run::<f32, 3>(precision),
        (_, Precision::Double) => job.run::<f64, 3>(precision),
    }
}

const NAMES: [&str; 18] = [
    "method",
    "prior",
    "gamma",
    "nonnegative",
    "volume",
    "sigma",
    "length",
    "budget",
    "eps",
    "accept",
    "tolerance",
    "walk",
    "hull_threshold",
    "seed",
    "warm",
    "warm_budget",
    "sweeps",
    "relax",
];

/// Sets one choice.
fn set(settings: &mut Settings, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    let count = || -> PyResult<u64> {
        let given = number(name, value)?;
        if (1.0..1e15).contains(&given) && given.fract() == 0.0 {
            Ok(given as u64)
        } else {
            Err(refused(
                name,
                format!("is {given}; give a whole number from 1 on"),
            ))
        }
    };
    match name {
        "method" => settings.method = word(name, value)?,
        "prior" => settings.prior = word(name, value)?,
        "nonnegative" => settings.nonnegative = flag(name, value)?,
        "sigma" => settings.sigma = number(name, value)?,
        "length" => settings.length = count()?,
        "budget" => settings.budget = count()?,
        "eps" if is_automatic(value) => settings.eps = None,
        "eps" => settings.eps = Some(number(name, value)?),
        "accept" => settings.accept = number(name, value)?,
        "tolerance" => settings.tolerance = number(name, value)?,
        "walk" => settings.rule = word(name, value)?,
        "hull_threshold" => settings.hull_threshold = number(name, value)?,
        "seed" => settings.seed = read(name, value, "a whole number from 0")?,
        "warm" => settings.warm = flag(name, value)?,
        "warm_budget" => settings.warm_budget = number(name, value)?,
        "sweeps" => settings.sweeps = count()? as usize,
        "relax" => settings.relax = number(name, value)?,
        _ => return Err(unknown("option", name, &NAMES)),
    }
    Ok(())
}
