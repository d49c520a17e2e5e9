//! From C to the core: what a configuration describes.

use super::choices::{ThuriblePrecision, code, flag, precision, wide};
use super::effects::Lists;
use super::sized;
use super::{AUTOMATIC_SMOOTHNESS, ConfigError, THURIBLE_AUTOMATIC, ThuribleConfig};
use thurible_core::{Advection, Boundary, Params, Problem};

impl ThuribleConfig {
    /// Reads a configuration of any version up to this one.
    ///
    /// # Errors
    /// [`ConfigError`]: null, misaligned, or of an unknown size.
    ///
    /// # Safety
    /// `config` is null or points to a configuration of `size` bytes.
    pub unsafe fn read(config: *const Self) -> Result<Self, ConfigError> {
        // SAFETY: the caller's promise.
        unsafe { sized::read(config) }
    }

    /// Precision and axes.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn kind(&self) -> Result<(ThuriblePrecision, usize), ConfigError> {
        Ok((precision(self.precision)?, dimensions(self.dimensions)?))
    }

    /// Calls `work` with the problem and the choices that this describes.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// The lists of the configuration have as many entries as it says.
    // Not inlined: its lists take much of a stack, which callers that describe a problem twice would have twice.
    #[inline(never)]
    pub unsafe fn with<R>(&self, work: impl FnOnce(&Problem<'_>, &Params) -> R) -> Result<R, ConfigError> {
        let dims = dimensions(self.dimensions)?;
        let boundary = ends(&self.boundary, dims)?;
        let params = self.params()?;
        let mut lists = const { Lists::new() };
        // SAFETY: the caller's promise.
        let (keyframes, keyframe_weights) = unsafe {
            lists.read(self)?;
            self.keyframe_lists()?
        };
        let [x, y, z] = self.buoyancy;
        let problem = Problem {
            cells: first(&self.cells, dims),
            boundary: first(&boundary, dims),
            length: self.length,
            dt: self.dt,
            steps: self.steps,
            keyframes,
            keyframe_weights,
            keyframe_regions: is_on("keyframe_regions", self.keyframe_regions)?,
            emitters: lists.emitters(),
            solids: is_on("solids", self.solids)?,
            buoyancy: if dims == 2 { [x, y, 0.0] } else { [x, y, z] },
            templates: lists.templates(),
            release: (self.release != 0).then_some(self.release),
            schedule: lists.schedule(),
            mask: is_on("mask", self.mask)?,
            force_weight: self.force_weight,
            viscosity: self.viscosity,
            slip: !is_on("no_slip", self.no_slip)?,
            smoothness: (self.smoothness != AUTOMATIC_SMOOTHNESS).then_some(self.smoothness),
            filters: (self.filters != THURIBLE_AUTOMATIC).then(|| wide(self.filters)),
            match_mass: is_on("match_mass", self.match_mass)?,
            advection: Advection {
                scheme: code("scheme", self.scheme)?,
                tolerance: self.advection_tolerance,
            },
            projection_tolerance: self.projection_tolerance,
            share: None,
        };
        Ok(work(&problem, &params))
    }

    /// Bytes to stay within, if there is a number.
    pub fn ceiling(&self) -> Option<usize> {
        (self.memory_ceiling != 0).then_some(self.memory_ceiling)
    }

    fn params(mut self) -> Result<Params, ConfigError> {
        let mut params = Params {
            method: code("method", self.method)?,
            iterations: self.iterations,
            threads: self.threads,
            ceiling: self.ceiling(),
            ..Params::default()
        };
        for held in self.held() {
            match params.find(held.choice) {
                Some((method, index)) => held.read(params.choices_mut(method), index)?,
                None => held.unknown()?,
            }
        }
        Ok(params)
    }
}

/// 2 or 3.
///
/// # Errors
/// [`ConfigError::Code`].
pub fn dimensions(given: u32) -> Result<usize, ConfigError> {
    match given {
        2 => Ok(2),
        3 => Ok(3),
        given => Err(ConfigError::Code {
            field: "dimensions",
            given,
        }),
    }
}

/// How the first `dims` axes end.
///
/// # Errors
/// [`ConfigError::Code`].
pub fn ends(given: &[u32; 3], dims: usize) -> Result<[Boundary; 3], ConfigError> {
    let mut ends = [Boundary::Wall; 3];
    for (end, &given) in ends.iter_mut().zip(given).take(dims) {
        *end = code("boundary", given)?;
    }
    Ok(ends)
}

/// Whether a field that is 0 or 1 is 1.
///
/// # Errors
/// [`ConfigError::Code`].
pub fn is_on(field: &'static str, given: u32) -> Result<bool, ConfigError> {
    flag(given).ok_or(ConfigError::Code { field, given })
}

/// The first `dims` of three values, where `dims` is 2 or 3.
pub fn first<V>(values: &[V; 3], dims: usize) -> &[V] {
    values.get(..dims).unwrap_or(values)
}
