//! Which simulator an operator has, and what is kept of it, as C gives it.

use crate::config::{ConfigError, THURIBLE_AUTOMATIC, ThuribleConfig, sized, wide};
use crate::fluids::ThuribleFluidsConfig;
use crate::result::ThuribleResult;
use thurible_core::stable_fluids::Controls;
use thurible_core::{FluidsParams, OperatorParams, Problem};

/// What simulates.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleSimulator {
    /// The implicit solver on the staggered grid, with all that a scene may have.
    Implicit = 0,
    /// Stable Fluids: everything at the centres of cells.
    StableFluids = 1,
}

/// How a simulation becomes an operator, beside its scene, a `ThuribleConfig` whose method, keyframes and prices count for nothing: begin with
/// `thurible_operator_defaults`. Later versions add fields at the end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleOperatorConfig {
    /// `sizeof(ThuribleOperatorConfig)`, as `thurible_operator_defaults` writes it.
    pub size: usize,
    /// A `ThuribleSimulator`; implicit by default.
    pub simulator: u32,
    /// States that are kept for the way back, from 1 to the steps; `THURIBLE_AUTOMATIC`, the default, for as many as `memory_ceiling` of the scene holds. Of
    /// Stable Fluids also 0, for all that the adjoint reads, and `THURIBLE_NO_WAY_BACK`. No number changes a bit.
    pub slots: u32,
    /// Implicit: what a step and its adjoint leave of their residuals; 1e-10 by default.
    pub tolerance: f64,
    /// Stable Fluids: pressure, adjoint, sweeps and diffusion; null for the defaults. Read as `keyframes` of a scene.
    pub fluids: *const ThuribleFluidsConfig,
}

// SAFETY: plain numbers and a pointer, the size first.
unsafe impl sized::Versioned for ThuribleOperatorConfig {}

impl Default for ThuribleOperatorConfig {
    fn default() -> Self {
        Self {
            size: size_of::<Self>(),
            simulator: ThuribleSimulator::Implicit as u32,
            slots: THURIBLE_AUTOMATIC,
            tolerance: OperatorParams::default().tolerance,
            fluids: core::ptr::null(),
        }
    }
}

/// What is chosen of a simulator.
#[derive(Clone, Copy, Debug)]
pub enum Chosen {
    /// Of the implicit solver.
    Implicit(OperatorParams),
    /// Of Stable Fluids, but for what is kept, and what that is to be.
    Fluids(FluidsParams, u32),
}

impl ThuribleOperatorConfig {
    /// Calls `work` with the problem and the choices that this and a scene describe.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// The lists of the scene have as many entries as it says, and `fluids` is null or points to a configuration.
    pub unsafe fn with<R>(
        &self,
        scene: &ThuribleConfig,
        work: impl FnOnce(&Problem<'_>, &Chosen) -> R,
    ) -> Result<R, ConfigError> {
        // SAFETY: the caller's promise.
        let chosen = unsafe { self.chosen(scene) }?;
        // SAFETY: the caller's promise.
        unsafe {
            scene.with(|problem, _| {
                let bare = Problem {
                    keyframes: &[],
                    keyframe_weights: &[],
                    keyframe_regions: false,
                    release: None,
                    schedule: &[],
                    mask: false,
                    smoothness: None,
                    ..*problem
                };
                work(&bare, &chosen)
            })
        }
    }

    /// # Safety
    /// As [`Self::with`].
    unsafe fn chosen(&self, scene: &ThuribleConfig) -> Result<Chosen, ConfigError> {
        match self.simulator {
            0 => Ok(Chosen::Implicit(OperatorParams {
                tolerance: self.tolerance,
                slots: (self.slots != THURIBLE_AUTOMATIC).then(|| wide(self.slots)),
                threads: scene.threads,
                ceiling: scene.ceiling(),
            })),
            1 => {
                let fluids = if self.fluids.is_null() {
                    ThuribleFluidsConfig::default()
                } else {
                    // SAFETY: the caller's promise.
                    unsafe { sized::read(self.fluids) }?
                };
                let params = FluidsParams {
                    controls: Controls::none(),
                    initial_velocity: true,
                    ..fluids.params(scene.threads)?
                };
                Ok(Chosen::Fluids(params, self.slots))
            }
            given => Err(ConfigError::Code {
                field: "simulator",
                given,
            }),
        }
    }
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleOperatorConfig)` of the program that calls, with the defaults.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_defaults(
    config: *mut ThuribleOperatorConfig,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { sized::fill(config, size, ThuribleOperatorConfig::default()) }
}
