//! A tracker in the caller's memory.

use super::config::ThuribleTrackConfig;
use crate::config::ConfigError;
use crate::instance::{self, Any, Handle, with_place};
use crate::result::{ThuribleResult, ThuribleStatus};
use crate::typed;
use core::mem::MaybeUninit;
use thurible_core::flow::MAX_LEVELS;
use thurible_core::track::Pair;
use thurible_core::{Capture, D2, D3, Real, Space, TrackParams, TrackPlan, Tracker};

/// Frames that are being tracked, in memory of the caller: a handle, whose inside is the library's.
pub struct ThuribleTracker {
    _inside: (),
}

impl Handle for ThuribleTracker {
    type Body = Body;
    const MARK: usize = 0x5472_6163;
}

/// A tracker of either precision in either dimension.
pub type AnyTracker = Any<
    Tracker<'static, f32, D2>,
    Tracker<'static, f64, D2>,
    Tracker<'static, f32, D3>,
    Tracker<'static, f64, D3>,
>;

/// What is behind the handle.
#[derive(Debug)]
pub struct Body {
    /// The tracker, in the block behind the place.
    pub tracker: AnyTracker,
    /// Axes of the box.
    pub dims: usize,
    /// Bytes of a number.
    pub number: usize,
    /// Threads that memory was planned for.
    pub threads: usize,
    /// Whether the first frame is carried along.
    pub readvect: bool,
    /// Whether forces are computed.
    pub forces: bool,
    /// Frames that were given.
    pub frames: usize,
    /// How the last pair ended: nothing is found after one that was stopped.
    pub status: ThuribleStatus,
}

/// Grids of a pyramid at most.
pub const THURIBLE_MOST_LEVELS: usize = 8;

const _: () = assert!(THURIBLE_MOST_LEVELS == MAX_LEVELS);

/// What is said of a pair of frames.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuriblePair {
    /// `THURIBLE_STATUS_CONVERGED`, or how it was stopped: `THURIBLE_STATUS_CANCELLED`, or `THURIBLE_STATUS_NOT_FINITE` where a flow was too fast or not
    /// finite. Then the pair has no flow, nor has any later one.
    pub status: ThuribleStatus,
    /// k of the pair of frames k and k + 1.
    pub frame: usize,
    /// 1/2 |phi_t + F w|^2 on the finest grid.
    pub data: f64,
    /// alpha/2 <v, L v> of the correction.
    pub smoothness: f64,
    /// beta/2 |v|^2 of the correction.
    pub kinetic: f64,
    /// The gradient that is left, in parts of the first.
    pub optimality: f64,
    /// Squared distance of frame k + 1, pulled back by the prediction, from frame k.
    pub misfit_predicted: f64,
    /// The same, pulled back by the flow.
    pub misfit: f64,
    /// The largest velocity, in cells a frame.
    pub fastest: f64,
    /// How far the first frame, carried by the flow, is from frame k + 1, in parts of that; 0 without `readvect`.
    pub readvection: f64,
    /// How many grids there are.
    pub levels: usize,
    /// Products by the operator on each of them, finest first.
    pub products: [usize; THURIBLE_MOST_LEVELS],
}

impl ThuriblePair {
    /// What is said of pair `frame`, which is done.
    pub fn of(frame: usize, pair: &Pair) -> Self {
        let mut said = Self {
            status: ThuribleStatus::Converged,
            frame,
            data: pair.terms.data,
            smoothness: pair.terms.smoothness,
            kinetic: pair.terms.kinetic,
            optimality: pair.terms.optimality,
            misfit_predicted: pair.misfit[0],
            misfit: pair.misfit[1],
            fastest: pair.fastest,
            readvection: pair.readvection,
            levels: pair.efforts.len(),
            products: [0; _],
        };
        let places = said.products.iter_mut().zip(&pair.efforts);
        places.for_each(|(place, &products)| *place = products);
        said
    }
}

/// Bytes of the tracker with its place.
///
/// # Errors
/// [`ConfigError`].
pub fn plan(config: &ThuribleTrackConfig) -> Result<usize, ConfigError> {
    let kind = config.kind()?;
    let planned = config.with(|capture, params| typed!(kind, T, S, _W => bytes_of::<T, S>(capture, params)));
    planned.flatten()
}

#[inline(never)]
fn bytes_of<T: Real, S: Space>(capture: &Capture<'_>, params: &TrackParams) -> Result<usize, ConfigError> {
    let plan = TrackPlan::new::<T, S>(capture, params)?;
    Ok(with_place::<ThuribleTracker>(plan.bytes())?)
}

/// Makes a tracker in the first bytes of `memory`.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while the tracker lives.
pub unsafe fn make(
    memory: *mut u8,
    bytes: usize,
    config: &ThuribleTrackConfig,
) -> Result<*mut ThuribleTracker, ThuribleResult> {
    let needed = plan(config).map_err(ConfigError::result)?;
    let kind = config.kind().map_err(ConfigError::result)?;
    // SAFETY: the caller's promise.
    let block = unsafe { instance::behind::<ThuribleTracker>(memory, bytes, needed) }?;
    let tracker = config
        .with(|capture, params| typed!(kind, _T, _S, Wrap => made(capture, params, block, Wrap)))
        .map_err(ConfigError::result)??;
    let (precision, dims) = kind;
    let body = Body {
        tracker,
        dims,
        number: precision as usize,
        threads: config.threads,
        readvect: config.readvect == 1,
        forces: config.forces == 1,
        frames: 0,
        status: ThuribleStatus::Goes,
    };
    let handle: *mut ThuribleTracker = memory.cast();
    // SAFETY: the caller's promise; the bytes before the tracker's block are its place's.
    unsafe { instance::settle(handle, body) };
    Ok(handle)
}

#[inline(never)]
fn made<T: Real, S: Space>(
    capture: &Capture<'_>,
    params: &TrackParams,
    block: &'static mut [MaybeUninit<u8>],
    wrap: fn(Tracker<'static, T, S>) -> AnyTracker,
) -> Result<AnyTracker, ThuribleResult> {
    Ok(wrap(Tracker::new(capture, params, block)?))
}
