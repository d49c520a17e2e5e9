//! The configuration that a program begins with.

use super::sized;
use super::{AUTOMATIC_SMOOTHNESS, THURIBLE_AUTOMATIC};
use super::{ThuribleBoundary, ThuribleConfig, ThuriblePrecision};
use crate::result::ThuribleResult;
use thurible_core::{Params, Problem};

impl Default for ThuribleConfig {
    fn default() -> Self {
        let params = Params::default();
        let problem = Problem::new(&[], &[], &[]);
        let mut config = Self {
            size: size_of::<Self>(),
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
            no_slip: u32::from(!problem.slip),
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
        for held in config.held() {
            if let Some((method, index)) = params.find(held.choice) {
                held.write(params.choices(method), index);
            }
        }
        config
    }
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleConfig)` of the program that calls, with the defaults.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_defaults(config: *mut ThuribleConfig, size: usize) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { sized::fill(config, size, ThuribleConfig::default()) }
}
