//! The configuration that a program begins with.

use super::{MOST_BYTES, SIZE, THURIBLE_AUTOMATIC, ThuribleBoundary, ThuribleColours, ThuribleConfig};
use super::{ThuribleMethod, ThuribleNorm, ThuribleNsoSolver, ThuriblePrecision, ThuribleScheme};
use crate::result::ThuribleResult;
use thurible_core::{Params, Problem};

impl Default for ThuribleConfig {
    fn default() -> Self {
        let Params {
            iterations,
            threads,
            admm,
            direct,
            lbfgs,
            pd,
            simulation,
            ..
        } = Params::default();
        let problem = Problem::new(&[], &[], &[]);
        Self {
            size: SIZE,
            precision: ThuriblePrecision::F32 as u32,
            dimensions: 2,
            cells: [0; 3],
            boundary: [ThuribleBoundary::Wall as u32; 3],
            method: ThuribleMethod::Direct as u32,
            length: problem.length,
            dt: problem.dt,
            steps: 0,
            keyframes: core::ptr::null(),
            keyframe_count: 0,
            force_weight: problem.force_weight,
            viscosity: problem.viscosity,
            filters: THURIBLE_AUTOMATIC,
            match_mass: problem.match_mass.into(),
            scheme: ThuribleScheme::Quick as u32,
            nso_colours: ThuribleColours::RedBlack as u32,
            advection_tolerance: problem.advection.tolerance,
            projection_tolerance: problem.projection_tolerance,
            iterations,
            threads,
            memory_ceiling: 0,
            direct_history: THURIBLE_AUTOMATIC,
            direct_nested: u32::from(direct.nested),
            direct_tolerance: direct.tolerance,
            admm_penalty: admm.penalty,
            admm_relaxation: admm.relaxation,
            admm_ao_momentum: admm.ao_momentum,
            admm_density_tolerance: admm.density_tolerance,
            admm_ao_iterations: narrow(admm.ao_iterations),
            admm_nested: u32::from(admm.nested),
            nso_solver: ThuribleNsoSolver::Stfas as u32,
            nso_cycles: narrow(admm.nso.cycles),
            nso_tolerance: admm.nso.tolerance,
            nso_norm: ThuribleNorm::Scaled as u32,
            lbfgs_history: THURIBLE_AUTOMATIC,
            lbfgs_tolerance: lbfgs.tolerance,
            lbfgs_nested: u32::from(lbfgs.nested),
            reserved: 0,
            pd_drive: pd.drive,
            pd_attenuation: pd.attenuation,
            pd_gathering: pd.gathering,
            simulation_buoyancy: simulation.buoyancy,
            simulation_tolerance: simulation.tolerance,
        }
    }
}

/// A count as C gives it.
fn narrow(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(THURIBLE_AUTOMATIC)
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
