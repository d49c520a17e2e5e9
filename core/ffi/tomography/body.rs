//! A reconstruction in the caller's memory: place, cameras, and the core's block.

use super::camera::THURIBLE_MOST_CAMERAS;
use super::config::ThuribleTomographyConfig;
use crate::config::{ConfigError, ThuriblePrecision};
use crate::instance::{self, ALIGN, Any, Handle, keep, with_place};
use crate::result::ThuribleResult;
use core::mem::MaybeUninit;
use thurible_core::Real;
use thurible_core::tomography::{Camera, Reconstruction, Tomography};

/// A box that is reconstructed frame by frame, in memory of the caller: a handle, whose inside is the library's.
pub struct ThuribleTomography {
    _inside: (),
}

impl Handle for ThuribleTomography {
    type Body = Body;
    const MARK: usize = 0x546f_6d6f;
}

/// A reconstruction of either precision in either dimension.
pub type AnyReconstruction = Any<
    Reconstruction<'static, f32, 2>,
    Reconstruction<'static, f64, 2>,
    Reconstruction<'static, f32, 3>,
    Reconstruction<'static, f64, 3>,
>;

/// What is behind the handle.
pub struct Body {
    /// The reconstruction, in the block behind the place.
    pub reconstruction: AnyReconstruction,
    /// How many cameras there are,
    pub cameras: usize,
    /// and novel views.
    pub novel: usize,
    /// A bit for each camera whose picture of the next frame was given.
    pub measured: u64,
    /// Whether a frame was begun.
    pub begun: bool,
    /// Whether the density is kept.
    pub volume: bool,
}

const _: () = assert!(THURIBLE_MOST_CAMERAS <= 64);

/// Bytes of the reconstruction with its place.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// The lists of `config` have as many entries as it says.
pub unsafe fn plan(config: &ThuribleTomographyConfig) -> Result<usize, ConfigError> {
    // SAFETY: the caller's promise.
    let planned = unsafe {
        match config.kind()? {
            (ThuriblePrecision::F32, 2) => config.with(bytes_of::<f32, 2>),
            (ThuriblePrecision::F64, 2) => config.with(bytes_of::<f64, 2>),
            (ThuriblePrecision::F32, _) => config.with(bytes_of::<f32, 3>),
            (ThuriblePrecision::F64, _) => config.with(bytes_of::<f64, 3>),
        }
    };
    Ok(planned?.ok_or(ThuribleResult::TooLarge)?)
}

/// Bytes of the cameras of a problem, which the reconstruction points to.
fn held<const D: usize>(problem: &Tomography<'_, D>) -> usize {
    let count = problem.cameras.len() + problem.novel.len();
    (count * size_of::<Camera<D>>()).next_multiple_of(ALIGN)
}

#[inline(never)]
fn bytes_of<T: Real, const D: usize>(problem: &Tomography<'_, D>) -> Option<usize> {
    let bytes = Reconstruction::<T, D>::bytes(problem)?.checked_add(held(problem))?;
    with_place::<ThuribleTomography>(bytes).ok()
}

/// Makes a reconstruction in the first bytes of `memory`.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while the reconstruction lives; the lists of `config` have as many
/// entries as it says.
pub unsafe fn make(
    memory: *mut u8,
    bytes: usize,
    config: &ThuribleTomographyConfig,
) -> Result<*mut ThuribleTomography, ThuribleResult> {
    // SAFETY: the caller's promises.
    let body = unsafe {
        let needed = plan(config).map_err(ConfigError::result)?;
        let block = instance::behind::<ThuribleTomography>(memory, bytes, needed)?;
        match config.kind().map_err(ConfigError::result)? {
            (ThuriblePrecision::F32, 2) => config.with(|problem| made(problem, block, Any::Plane32)),
            (ThuriblePrecision::F64, 2) => config.with(|problem| made(problem, block, Any::Plane64)),
            (ThuriblePrecision::F32, _) => config.with(|problem| made(problem, block, Any::Space32)),
            (ThuriblePrecision::F64, _) => config.with(|problem| made(problem, block, Any::Space64)),
        }
    };
    let body = body.map_err(ConfigError::result)??;
    let handle: *mut ThuribleTomography = memory.cast();
    // SAFETY: the caller's promise; the bytes before the block are the place's.
    unsafe { instance::settle(handle, body) };
    Ok(handle)
}

#[inline(never)]
fn made<T: Real, const D: usize>(
    problem: &Tomography<'_, D>,
    block: &'static mut [MaybeUninit<u8>],
    wrap: fn(Reconstruction<'static, T, D>) -> AnyReconstruction,
) -> Result<Body, ThuribleResult> {
    let few = ThuribleResult::TooSmall;
    let (mut own, block) = block.split_at_mut_checked(held(problem)).ok_or(few)?;
    let cameras = keep(&mut own, problem.cameras.len(), problem.cameras.iter().copied()).ok_or(few)?;
    let novel = keep(&mut own, problem.novel.len(), problem.novel.iter().copied()).ok_or(few)?;
    let whole = Tomography {
        cells: problem.cells,
        cameras,
        novel,
        settings: problem.settings,
    };
    Ok(Body {
        reconstruction: wrap(Reconstruction::new(whole, block)?),
        cameras: cameras.len(),
        novel: novel.len(),
        measured: 0,
        begun: false,
        volume: problem.settings.keeps_cells(),
    })
}
