//! `track`: the flow behind frames of smoke, on NumPy's arrays.

use crate::arrays::untyped;
use crate::choices;
use crate::inputs::precision_of;
use crate::plan::Precision;
use crate::tracked::Track;
use crate::tracking::Job;
use crate::words::{number, read, refused, whole_if_any, word};
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use thurible::channels::has_channels;
use thurible::owned::UNITS;
use thurible_core::flow::Minimiser;
use thurible_core::{Boundary, D2, D3, TrackParams};

/// Finds the flow behind frames of smoke, an array of shape (frames, ny, nx) or (frames, nz, ny, nx).
///
/// Its dtype, float32 or float64, is the precision. `emission` (frames - 1, ..) is what was made between a frame and the next. `options` are those of `[track]` in a capture file. Raises ValueError or TypeError for
/// what cannot be used, MemoryError for what does not fit in memory_limit bytes, FloatingPointError when a flow is too fast or not finite.
#[pyfunction]
#[pyo3(signature = (frames, *, boundary=None, length=None, dt=None, density_scale=None, buoyancy=None, initial_velocity=None, emission=None, method=None, options=None, threads=None, memory_limit=None), text_signature = "(frames, *, boundary='wall', length=1.0, dt=1.0, density_scale=None, buoyancy=0.0, initial_velocity=None, emission=None, method='direct', options=None, threads=None, memory_limit=None)")]
pub fn track<'py>(
    frames: &Bound<'py, PyAny>,
    boundary: Option<Bound<'py, PyAny>>,
    length: Option<Bound<'py, PyAny>>,
    dt: Option<Bound<'py, PyAny>>,
    density_scale: Option<Bound<'py, PyAny>>,
    buoyancy: Option<Bound<'py, PyAny>>,
    initial_velocity: Option<Bound<'py, PyAny>>,
    emission: Option<Bound<'py, PyAny>>,
    method: Option<Bound<'py, PyAny>>,
    options: Option<Bound<'py, PyAny>>,
    threads: Option<Bound<'py, PyAny>>,
    memory_limit: Option<Bound<'py, PyAny>>,
) -> PyResult<Track> {
    let found = untyped("frames", frames)?;
    let (shape, dims) = (found.shape().to_vec(), found.ndim().saturating_sub(1));
    if !(2..=3).contains(&dims) {
        let why = format!(
            "has {} axes; give an array of shape (frames, ny, nx) or (frames, nz, ny, nx)",
            dims + 1
        );
        return Err(refused("frames", why));
    }
    let cells: Vec<usize> = shape.iter().skip(1).rev().copied().collect();
    if has_channels(&cells) {
        let why = format!(
            "has {} values along its last axis, which looks like colour; give one channel, as frames[..., 0]",
            shape[3]
        );
        return Err(refused("frames", why));
    }
    if shape[0] < 2 {
        return Err(refused(
            "frames",
            "holds a single one; a flow needs two frames at least",
        ));
    }
    let precision = precision_of("frames", found)?;
    let minimiser = method.map_or(Ok(Minimiser::default()), |method| word("method", &method))?;
    let mut params = TrackParams::of(minimiser);
    if let Some(options) = options.filter(|options| !options.is_none()) {
        // What the method is decides what the other options are where they are not given.
        if options.contains("method").unwrap_or(false) {
            let why = "is an argument of its own here; give method=.. beside the options";
            return Err(refused("options[\"method\"]", why));
        }
        choices::set_options(&mut params, &options)?;
    }
    let number_of = |field: &str, value: Option<Bound<'py, PyAny>>, otherwise: f64| {
        value.map_or(Ok(otherwise), |value| number(field, &value))
    };
    let wanted = "a tuple of arrays by axis";
    let initial_velocity = initial_velocity.map(|given| read("initial_velocity", &given, wanted));
    let job = Job {
        boundary: boundary.map_or(Ok(vec![Boundary::Wall; dims]), |ends| {
            choices::boundary(&ends, dims)
        })?,
        cells,
        shape,
        length: unit("length", number_of("length", length, 1.0)?)?,
        dt: unit("dt", number_of("dt", dt, 1.0)?)?,
        density_scale: density_scale
            .map(|scale| number("density_scale", &scale))
            .transpose()?,
        buoyancy: number_of("buoyancy", buoyancy, 0.0)?,
        initial_velocity: initial_velocity.transpose()?.unwrap_or_default(),
        emission: emission.filter(|emission| !emission.is_none()),
        params,
        threads: whole_if_any("threads", threads.as_ref())?,
        memory_limit: whole_if_any("memory_limit", memory_limit.as_ref())?,
    };
    match (dims, precision) {
        (2, Precision::Single) => job.run::<f32, D2>(frames, precision),
        (2, Precision::Double) => job.run::<f64, D2>(frames, precision),
        (_, Precision::Single) => job.run::<f32, D3>(frames, precision),
        (_, Precision::Double) => job.run::<f64, D3>(frames, precision),
    }
}

/// A length or a time, refused where single precision would not hold the flow.
fn unit(field: &str, given: f64) -> PyResult<f64> {
    if given > 0.0 && !UNITS.contains(&given) {
        let why = format!(
            "is {given:e}; it must be from {:e} to {:e}",
            UNITS.start(),
            UNITS.end()
        );
        return Err(refused(field, why));
    }
    Ok(given)
}
