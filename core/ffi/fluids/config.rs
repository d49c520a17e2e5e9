//! What is chosen for Stable Fluids, as C gives it.

use crate::config::{ConfigError, THURIBLE_AUTOMATIC, held, is_on, put_choices, sized, take_choices, wide};
use crate::result::ThuribleResult;
use thurible_core::stable_fluids::{Adjoint, Control, Controls, Pressure, Slots};
use thurible_core::{FluidsParams, FluidsPlan, Named, PlanError, Problem, Real, Space};

/// How Stable Fluids finds the pressure.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuriblePressure {
    /// By Gauss-Seidel sweeps.
    GaussSeidel = 0,
    /// By conjugate gradients.
    Cg = 1,
}

/// What the adjoint of conjugate gradients is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleAdjoint {
    /// That of the iterations that were done.
    Exact = 0,
    /// One more solve: right in the limit, in less memory.
    SecondSolve = 1,
}

/// What Stable Fluids searches for: `controls` is a sum of these.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleControl {
    /// The velocity at the start.
    InitialVelocity = 1,
    /// A force in every cell and step.
    Forces = 2,
    /// Amplitudes of templates, and middles and radii of those that move.
    Templates = 4,
}

/// `slots` of a configuration where nothing is kept for a way back: the flow alone, without gradients.
pub const THURIBLE_NO_WAY_BACK: u32 = u32::MAX - 1;

const _: () = {
    assert!(ThuriblePressure::GaussSeidel as u32 == Pressure::GaussSeidel as u32);
    assert!(ThuriblePressure::Cg as u32 == Pressure::Conjugate as u32);
    assert!(ThuribleAdjoint::Exact as u32 == Adjoint::Exact as u32);
    assert!(ThuribleAdjoint::SecondSolve as u32 == Adjoint::SecondSolve as u32);
    assert!(ThuribleControl::InitialVelocity as u32 == 1 << Control::InitialVelocity as u32);
    assert!(ThuribleControl::Forces as u32 == 1 << Control::Forces as u32);
    assert!(ThuribleControl::Templates as u32 == 1 << Control::Templates as u32);
};

/// What is chosen for Stable Fluids beside the scene, a `ThuribleConfig` whose precision, box, times, keyframes, `templates` (winds and vortices),
/// `buoyancy`, `viscosity`, `force_weight`, `filters`, `match_mass`, `threads` and `memory_ceiling` it takes: begin with `thurible_fluids_defaults`. Later
/// versions add fields at the end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleFluidsConfig {
    /// `sizeof(ThuribleFluidsConfig)`, as `thurible_fluids_defaults` writes it.
    pub size: usize,
    /// A sum of `ThuribleControl`; the velocity at the start by default.
    pub controls: u32,
    /// States that are kept for the way back, from 1 to the steps; 0 for all that the adjoint reads; `THURIBLE_AUTOMATIC`, the default, for the most that
    /// `memory_ceiling` of the scene holds, and `THURIBLE_NO_WAY_BACK`. No number changes a bit.
    pub slots: u32,
    /// A `ThuriblePressure`; by sweeps by default.
    pub pressure: u32,
    /// A `ThuribleAdjoint`; exact by default.
    pub adjoint: u32,
    /// Gauss-Seidel sweeps, of pressure and diffusion.
    pub sweeps: u32,
    /// Iterations of conjugate gradients at most.
    pub cg_iterations: u32,
    /// What they leave, in parts of their right-hand side.
    pub cg_tolerance: f64,
    /// Diffusion of the density, in squared lengths per time.
    pub diffusion: f64,
    /// Price of the initial velocity.
    pub initial_weight: f64,
    /// Stop when the objective falls by less than this times itself, twice in a row.
    pub tolerance: f64,
    /// Pairs of L-BFGS.
    pub history: u32,
    /// Iterations at most.
    pub iterations: u32,
    /// Whether `thurible_fluids_set_initial_velocity` gives a velocity at the start: 0, the default, or 1.
    pub initial_velocity: u32,
    /// For later versions; must be 0.
    pub reserved: u32,
}

// SAFETY: plain numbers, the size first.
unsafe impl sized::Versioned for ThuribleFluidsConfig {}

impl Default for ThuribleFluidsConfig {
    fn default() -> Self {
        let params = FluidsParams::default();
        let mut config = Self {
            size: size_of::<Self>(),
            controls: ThuribleControl::InitialVelocity as u32,
            slots: THURIBLE_AUTOMATIC,
            iterations: u32::try_from(params.iterations).unwrap_or(u32::MAX),
            // SAFETY: every pattern of bits is a configuration.
            ..unsafe { core::mem::zeroed() }
        };
        put_choices(config.held(), &params);
        config
    }
}

impl ThuribleFluidsConfig {
    /// Every field that holds a choice, and what the core calls it.
    fn held(&mut self) -> [crate::config::Held<'_>; 9] {
        held! { self:
            pressure "pressure",
            sweeps "sweeps",
            cg_iterations "cg_iterations",
            cg_tolerance "cg_tolerance",
            adjoint "adjoint",
            diffusion "diffusion",
            initial_weight "initial_weight",
            history "history",
            tolerance "tolerance",
        }
    }

    /// The choices, but for what is kept.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn params(mut self, threads: usize) -> Result<FluidsParams, ConfigError> {
        if self.reserved != 0 {
            let (field, given) = ("reserved", self.reserved);
            return Err(ConfigError::Code { field, given });
        }
        let mut params = FluidsParams {
            controls: self.searched()?,
            iterations: wide(self.iterations),
            threads,
            initial_velocity: is_on("initial_velocity", self.initial_velocity)?,
            ..FluidsParams::default()
        };
        take_choices(self.held(), &mut params)?;
        Ok(params)
    }

    fn searched(&self) -> Result<Controls, ConfigError> {
        if self.controls >= 8 {
            let (field, given) = ("controls", self.controls);
            return Err(ConfigError::Code { field, given });
        }
        let all = Control::ALL.iter().copied();
        let chosen = all.filter(|&control| self.controls >> control as u32 & 1 == 1);
        Ok(chosen.fold(Controls::none(), Controls::with))
    }
}

/// Choices with what is kept for the way back, within a ceiling, and their plan.
///
/// # Errors
/// [`PlanError`].
pub fn fitted<T: Real, S: Space>(
    problem: &Problem<'_>,
    params: &FluidsParams,
    slots: u32,
    ceiling: Option<usize>,
) -> Result<(FluidsParams, FluidsPlan), PlanError> {
    let slots = match slots {
        THURIBLE_AUTOMATIC => None,
        THURIBLE_NO_WAY_BACK => Some(Slots::None),
        states => Some(Slots::of(wide(states))),
    };
    FluidsPlan::within::<T, S>(problem, params, slots, ceiling)
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleFluidsConfig)` of the program that calls, with the defaults.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_defaults(
    config: *mut ThuribleFluidsConfig,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { sized::fill(config, size, ThuribleFluidsConfig::default()) }
}
