//! What is tracked, and how, as C gives it.

use crate::config::{
    ConfigError, ThuribleBoundary, ThuriblePrecision, code, dimensions, ends, first, held, is_on, precision,
    put_choices, sized, take_choices,
};
use crate::result::ThuribleResult;
use thurible_core::flow::{Minimiser, Warping};
use thurible_core::track::{FULL, Prediction};
use thurible_core::{Capture, TrackParams};

/// How the flow between two frames is found.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleMinimiser {
    /// Conjugate gradients among flows without divergence.
    Direct = 0,
    /// The alternating direction method.
    Admm = 1,
    /// Horn & Schunck: flows may have divergence, perhaps at a price.
    HornSchunck = 2,
}

/// How a frame is pulled back by a flow.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleWarping {
    /// Traced back and forth, with an error compensation that is limited.
    Bfecc = 0,
    /// The transport of densities, with the flow turned round.
    Quick = 1,
}

/// How the flow of the next pair of frames is predicted.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuriblePrediction {
    /// The implicit step of a simulation.
    Implicit = 0,
    /// The flow carried by itself, then projected.
    Bfecc = 1,
    /// The flow before, as it is.
    None = 2,
}

const _: () = {
    assert!(ThuribleMinimiser::Direct as u32 == Minimiser::Direct as u32);
    assert!(ThuribleMinimiser::Admm as u32 == Minimiser::Admm as u32);
    assert!(ThuribleMinimiser::HornSchunck as u32 == Minimiser::HornSchunck as u32);
    assert!(ThuribleWarping::Bfecc as u32 == Warping::Bfecc as u32);
    assert!(ThuribleWarping::Quick as u32 == Warping::Quick as u32);
    assert!(ThuriblePrediction::Implicit as u32 == Prediction::Implicit as u32);
    assert!(ThuriblePrediction::Bfecc as u32 == Prediction::Bfecc as u32);
    assert!(ThuriblePrediction::None as u32 == Prediction::None as u32);
};

/// Frames of smoke in a box, and how the flow behind them is found: begin with `thurible_track_defaults`. Weights are in cells and frames, for
/// densities that are scaled to 10. Later versions add fields at the end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleTrackConfig {
    /// `sizeof(ThuribleTrackConfig)`, as `thurible_track_defaults` writes it.
    pub size: usize,
    /// A `ThuriblePrecision`; `THURIBLE_PRECISION_F32` by default.
    pub precision: u32,
    /// 2 or 3; 2 by default.
    pub dimensions: u32,
    /// Cells along x, y and z, each from 4 to 4096; z is ignored in 2D. To be set.
    pub cells: [usize; 3],
    /// A `ThuribleBoundary` for each axis, wall or periodic; walls by default.
    pub boundary: [u32; 3],
    /// A `ThuribleMinimiser`; direct by default.
    pub method: u32,
    /// Longest side of the box; 1 by default.
    pub length: f64,
    /// Time between two frames; 1 by default.
    pub dt: f64,
    /// What densities are multiplied by, for the weights to mean something: 10 / the largest of all frames. 10 by default, for densities up to 1.
    pub density_scale: f64,
    /// Acceleration where the density is 1 along x, y and z, in lengths per squared time, in the prediction; z is ignored in 2D.
    pub buoyancy: [f64; 3],
    /// Threads that memory is planned for, from 1; an executor must not have more.
    pub threads: usize,
    /// Weight of smoothness.
    pub alpha: f64,
    /// Weight of the flow's kinetic energy.
    pub beta: f64,
    /// Price of divergence, of Horn-Schunck alone.
    pub gamma: f64,
    /// Step of ADMM.
    pub lambda: f64,
    /// ADMM ends early when it changes less than this part; 0 for never.
    pub tolerance: f64,
    /// Iterations of ADMM.
    pub iterations: u32,
    /// Grids of the pyramid, from 1 to 8.
    pub levels: u32,
    /// Cells of the next coarser grid along an axis, in parts.
    pub eta: f64,
    /// Blur before a coarser grid, in cells.
    pub sigma: f64,
    /// How often each grid warps and solves.
    pub warps: u32,
    /// A `ThuribleWarping`.
    pub warp: u32,
    /// What conjugate gradients leave, in parts of their right-hand side.
    pub cg_tolerance: f64,
    /// Steps of conjugate gradients at most.
    pub cg_iterations: u32,
    /// A `ThuriblePrediction`.
    pub predict: u32,
    /// Whether every pair is on its own: 0 or 1.
    pub independent: u32,
    /// Whether the first frame is carried by the flow and compared: 0 or 1.
    pub readvect: u32,
    /// Whether smoke is made between frames, and given beside them: 0 or 1.
    pub emission: u32,
    /// Whether the force from the flow of each pair to the next is computed: 0 or 1.
    pub forces: u32,
}

// SAFETY: plain numbers, the size first.
unsafe impl sized::Versioned for ThuribleTrackConfig {}

impl ThuribleTrackConfig {
    /// That of a method, with the core's defaults.
    fn of(minimiser: Minimiser) -> Self {
        let params = TrackParams::of(minimiser);
        let capture = Capture::new(&[], &[]);
        let mut config = Self {
            size: size_of::<Self>(),
            precision: ThuriblePrecision::F32 as u32,
            dimensions: 2,
            boundary: [ThuribleBoundary::Wall as u32; 3],
            length: capture.length,
            dt: capture.dt,
            density_scale: FULL,
            threads: params.threads,
            // SAFETY: every pattern of bits is a configuration.
            ..unsafe { core::mem::zeroed() }
        };
        put_choices(config.held(), &params);
        config
    }

    /// Every field that holds a choice, and what the core calls it.
    fn held(&mut self) -> [crate::config::Held<'_>; 18] {
        held! { self:
            method "method",
            alpha "alpha",
            beta "beta",
            gamma "gamma",
            lambda "lambda",
            tolerance "tolerance",
            iterations "iterations",
            levels "levels",
            eta "eta",
            sigma "sigma",
            warps "warps",
            warp "warp",
            cg_tolerance "cg_tolerance",
            cg_iterations "cg_iterations",
            predict "predict",
            independent "independent",
            readvect "readvect",
            forces "forces",
        }
    }

    /// Precision and axes.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn kind(&self) -> Result<(ThuriblePrecision, usize), ConfigError> {
        Ok((precision(self.precision)?, dimensions(self.dimensions)?))
    }

    /// Calls `work` with the capture and the choices that this describes.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn with<R>(&self, work: impl FnOnce(&Capture<'_>, &TrackParams) -> R) -> Result<R, ConfigError> {
        let (_, dims) = self.kind()?;
        let boundary = ends(&self.boundary, dims)?;
        let mut params = TrackParams {
            threads: self.threads,
            ..TrackParams::of(code("method", self.method)?)
        };
        let mut own = *self;
        take_choices(own.held(), &mut params)?;
        let [x, y, z] = self.buoyancy;
        let capture = Capture {
            cells: first(&self.cells, dims),
            boundary: first(&boundary, dims),
            length: self.length,
            dt: self.dt,
            density_scale: self.density_scale,
            buoyancy: if dims == 2 { [x, y, 0.0] } else { [x, y, z] },
            emission: is_on("emission", self.emission)?,
        };
        Ok(work(&capture, &params))
    }
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleTrackConfig)` of the program that calls, with the defaults of a `ThuribleMinimiser`.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_defaults(
    config: *mut ThuribleTrackConfig,
    size: usize,
    method: u32,
) -> ThuribleResult {
    match code("method", method) {
        // SAFETY: the caller's promise.
        Ok(minimiser) => unsafe { sized::fill(config, size, ThuribleTrackConfig::of(minimiser)) },
        Err(error) => error.result(),
    }
}
