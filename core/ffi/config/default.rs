//! The configuration that a program begins with.

use super::{AUTOMATIC_SMOOTHNESS, MOST_BYTES, SIZE, THURIBLE_AUTOMATIC};
use super::{ThuribleBoundary, ThuribleConfig, ThuriblePrecision};
use crate::result::ThuribleResult;
use thurible_core::{Params, Problem};

impl Default for ThuribleConfig {
    fn default() -> Self {
        let params = Params::default();
        let problem = Problem::new(&[], &[], &[]);
        let mut config = Self {
            size: SIZE,
            precision: ThuriblePrecision::F32 as u32,
            dimensions: 2,
            cells: [0; 3],
            boundary: [ThuribleBoundary::Wall as u32; 3],
            method: params.method as u32,
            length: problem.length,
            dt: problem.dt,
            steps: 0,
            keyframes: core::ptr::null(),
            keyframe_count: 0,
            force_weight: problem.force_weight,
            viscosity: problem.viscosity,
            smoothness: AUTOMATIC_SMOOTHNESS,
            filters: THURIBLE_AUTOMATIC,
            match_mass: problem.match_mass.into(),
            scheme: problem.advection.scheme as u32,
            advection_tolerance: problem.advection.tolerance,
            projection_tolerance: problem.projection_tolerance,
            iterations: params.iterations,
            threads: params.threads,
            memory_ceiling: 0,
            // SAFETY: every pattern of bits is a configuration.
            ..unsafe { core::mem::zeroed() }
        };
        config.held().into_iter().for_each(|held| held.write(&params));
        config
    }
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleConfig)` of the program that calls, with the defaults.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_defaults(config: *mut ThuribleConfig, size: usize) -> ThuribleResult {
    if config.is_null() {
        return ThuribleResult::Null;
    }
    if !config.is_aligned() {
        return ThuribleResult::Misaligned;
    }
    if !(SIZE..=MOST_BYTES).contains(&size) {
        return ThuribleResult::ConfigSize;
    }
    // SAFETY: not null, aligned, and the caller promises `size` bytes, which are no fewer than this version's.
    unsafe {
        config.cast::<u8>().add(SIZE).write_bytes(0, size - SIZE);
        config.write(ThuribleConfig {
            size,
            ..ThuribleConfig::default()
        });
    }
    ThuribleResult::Ok
}
