//! `track`: the flow behind frames of smoke, on NumPy's arrays.

use crate::arrays::untyped;
use crate::choices;
use crate::inputs::precision_of;
use crate::plan::Precision;
use crate::tracked::Track;
use crate::tracking::Job;
use crate::words::{refused, word};
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use thurible_core::flow::Minimiser;
use thurible_core::{Boundary, D2, D3, TrackParams};

/// Finds the flow behind frames of smoke, an array of shape (frames, ny, nx) or (frames, nz, ny, nx).
///
/// Its dtype, float32 or float64, is the precision. `emission` (frames - 1, ..) is what was made between a frame and the next. `options` are those of `[track]` in a capture file. Raises ValueError or TypeError for
/// what cannot be used, MemoryError for what does not fit in memory_limit bytes, FloatingPointError when a flow is too fast or not finite.
#[pyfunction]
#[pyo3(signature = (frames, *, boundary=None, length=1.0, dt=1.0, density_scale=None, buoyancy=0.0, initial_velocity=None, emission=None, method=None, options=None, threads=None, memory_limit=None), text_signature = "(frames, *, boundary='wall', length=1.0, dt=1.0, density_scale=None, buoyancy=0.0, initial_velocity=None, emission=None, method='direct', options=None, threads=None, memory_limit=None)")]
pub fn track<'py>(
    frames: &Bound<'py, PyAny>,
    boundary: Option<Bound<'py, PyAny>>,
    length: f64,
    dt: f64,
    density_scale: Option<f64>,
    buoyancy: f64,
    initial_velocity: Option<Vec<Bound<'py, PyAny>>>,
    emission: Option<Bound<'py, PyAny>>,
    method: Option<Bound<'py, PyAny>>,
    options: Option<Bound<'py, PyAny>>,
    threads: Option<usize>,
    memory_limit: Option<usize>,
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
        choices::set_options(&mut params, &options)?;
    }
    let job = Job {
        boundary: boundary.map_or(Ok(vec![Boundary::Wall; dims]), |ends| {
            choices::boundary(&ends, dims)
        })?,
        cells: shape.iter().skip(1).rev().copied().collect(),
        shape,
        length,
        dt,
        density_scale,
        buoyancy,
        initial_velocity: initial_velocity.unwrap_or_default(),
        emission: emission.filter(|emission| !emission.is_none()),
        params,
        threads,
        memory_limit,
    };
    match (dims, precision) {
        (2, Precision::Single) => job.run::<f32, D2>(frames, precision),
        (2, Precision::Double) => job.run::<f64, D2>(frames, precision),
        (_, Precision::Single) => job.run::<f32, D3>(frames, precision),
        (_, Precision::Double) => job.run::<f64, D3>(frames, precision),
    }
}
