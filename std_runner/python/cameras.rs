//! Cameras in Python: dicts with the numbers that `report.json` of `thurible tomography` has of them.

use crate::words::{one_of, positive, read, refused, unknown};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use thurible_core::tomography::{Camera, Lens};

/// What a dict may have.
const NAMES: [&str; 8] = [
    "kind", "pixels", "across", "down", "forward", "at", "eye", "pitch",
];
/// What reports say beside it.
const BESIDE: [&str; 2] = ["name", "relative_error"];

/// How far a length may be from what it must be, as a part of it: numbers are copied from files.
const ROUNDED: f64 = 1e-3;

/// Camera `field`, whose picture has `pixels` across and down where that is known from it.
pub fn camera<const D: usize>(
    field: &str,
    given: &Bound<'_, PyAny>,
    pixels: Option<[usize; 2]>,
) -> PyResult<Camera<D>> {
    let given: Bound<'_, PyDict> = read(field, given, "a dict, as in the cameras of a report.json")?;
    for name in given.keys() {
        let name: String = name.extract()?;
        if !NAMES.contains(&name.as_str()) && !BESIDE.contains(&name.as_str()) {
            return Err(unknown(&format!("entry of {field} named"), &name, &NAMES));
        }
    }
    let get = |name: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
        Ok(given.get_item(name)?.filter(|value| !value.is_none()))
    };
    let required = |name: &str| {
        get(name)?.ok_or_else(|| refused(&format!("{field}[\"{name}\"]"), "is missing; give it"))
    };
    let numbers = |name: &str, count: usize| -> PyResult<Vec<f64>> {
        let full = format!("{field}[\"{name}\"]");
        let list: Vec<f64> = read(&full, &required(name)?, &format!("a list of {count} numbers"))?;
        if list.len() != count || list.iter().any(|x| !x.is_finite()) {
            return Err(refused(
                &full,
                format!("is {list:?}; give {count} finite numbers"),
            ));
        }
        Ok(list)
    };
    let vector = |name: &str| -> PyResult<[f64; D]> {
        let list = numbers(name, D)?;
        Ok(core::array::from_fn(|axis| list[axis]))
    };
    // In a plane v is not used, and may be left out.
    let at = if D > 2 || numbers("at", 1).is_err() {
        numbers("at", 2)?
    } else {
        numbers("at", 1)?
    };
    let at = [at[0], at.get(1).copied().unwrap_or(0.5)];
    let (across, forward) = (vector("across")?, vector("forward")?);
    let down = if D > 2 { vector("down")? } else { [0.0; D] };
    let long = |name: &str, vector: &[f64; D], wanted: f64| {
        let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length / wanted - 1.0).abs() <= ROUNDED {
            return Ok(());
        }
        let why = format!("is {length:.6} long, and must be {wanted:.6} long; scale it");
        Err(refused(&format!("{field}[\"{name}\"]"), why))
    };
    long("forward", &forward, 1.0)?;
    let kind = one_of(
        &format!("{field}[\"kind\"]"),
        &required("kind")?,
        &["orthographic", "pinhole", "matrix"],
    )?;
    let lens = if kind == "orthographic" {
        let pitch = positive(&format!("{field}[\"pitch\"]"), &required("pitch")?)?;
        // Unit vectors over the pitch.
        long("across", &across, 1.0 / pitch)?;
        if D > 2 {
            long("down", &down, 1.0 / pitch)?;
        }
        Lens::Orthographic {
            across,
            down,
            at,
            forward,
            pitch,
        }
    } else {
        for (name, vector) in [("across", across), ("down", down)].into_iter().take(D - 1) {
            if vector.iter().all(|&x| x == 0.0) {
                let why = "is 0; give the focal length in pixels times the way that it goes";
                return Err(refused(&format!("{field}[\"{name}\"]"), why));
            }
        }
        Lens::Pinhole {
            eye: vector("eye")?,
            across,
            down,
            at,
            forward,
        }
    };
    let own = get("pixels")?;
    let own: Option<Vec<usize>> = own
        .map(|own| read(&format!("{field}[\"pixels\"]"), &own, "[across, down]"))
        .transpose()?;
    let own = own.map(|own| {
        [
            own.first().copied().unwrap_or(0),
            own.get(1).copied().unwrap_or(1),
        ]
    });
    let pixels = match (pixels, own) {
        (Some(seen), Some(own)) if seen != own => {
            let why = format!("is {own:?}, and its picture has {seen:?}; give pictures of that size");
            return Err(refused(&format!("{field}[\"pixels\"]"), why));
        }
        (Some(seen), _) => seen,
        (None, Some(own)) => own,
        (None, None) => {
            let why =
                "is missing: a novel view has no picture that says how large it is; give [across, down]";
            return Err(refused(&format!("{field}[\"pixels\"]"), why));
        }
    };
    Ok(Camera { lens, pixels })
}
