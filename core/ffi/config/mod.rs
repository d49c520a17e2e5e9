//! The scene and the choices of a solve, as C gives them.

mod choices;
mod default;
mod effects;
mod error;
mod read;
pub mod sized;
mod slot;
mod templates;

pub(crate) use choices::codes;
pub use choices::{
    ThuribleBoundary, ThuribleColours, ThuribleGuideSolver, ThuribleHistoryPrecision, ThuribleNorm,
    ThuribleNsoSolver,
};
pub use choices::{ThuriblePrecision, ThuribleScheme, code, precision, wide};
pub use default::thurible_defaults;
pub use effects::{
    THURIBLE_MOST_EMITTERS, THURIBLE_MOST_FACTORS, ThuribleEmitter, ThuribleFactor, entries, names,
};
pub use error::{ConfigError, ListNames};
pub use read::{dimensions, ends, first, is_on};
pub use slot::{Held, Slot, THURIBLE_AUTOMATIC, put_choices, take_choices};
pub use templates::{THURIBLE_MOST_TEMPLATES, ThuribleTemplate, ThuribleTemplateKind};

/// How a scene is solved.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleMethod {
    /// Force elimination and quasi-Newton.
    Direct = 0,
    /// ADMM over an advection and a Navier-Stokes problem.
    Admm = 1,
    /// L-BFGS over the forces by the adjoint of a simulation.
    Lbfgs = 2,
    /// Smoke driven to the next keyframe while it is simulated.
    Pd = 3,
    /// No control: the flow alone. There may be no keyframes.
    Simulate = 4,
    /// L-BFGS over the amplitudes, middles and radii of templates. There must be some.
    Templates = 5,
    /// A simulation that is guided by the flow that `thurible_set_reference` gives. There may be no keyframes.
    Guide = 6,
}

codes!(ThuribleMethod of Method: Direct, Admm, Lbfgs, Pd, Simulate, Templates, Guide);

/// A scene without its densities, and the choices of the solve: begin with `thurible_defaults`, then set what is to differ. Fields
/// that hold one of several codes are `uint32_t`, so that any number may arrive and be refused.
///
/// Later versions add fields at the end; `size` tells which version a program was compiled for.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleConfig {
    /// `sizeof(ThuribleConfig)`, as `thurible_defaults` writes it.
    pub size: usize,
    /// A `ThuriblePrecision`; `THURIBLE_PRECISION_F32` by default.
    pub precision: u32,
    /// 2 or 3; 2 by default.
    pub dimensions: u32,
    /// Cells along x, y and z, each from 4 to 4096; z is ignored in 2D. To be set.
    pub cells: [usize; 3],
    /// A `ThuribleBoundary` for each axis; walls by default.
    pub boundary: [u32; 3],
    /// A `ThuribleMethod`; direct by default.
    pub method: u32,
    /// Longest side of the box.
    pub length: f64,
    /// Time between two steps.
    pub dt: f64,
    /// Steps N, at least 2. To be set.
    pub steps: usize,
    /// Steps of the keyframes, ascending, from 2 to N; read only while a call that takes the configuration lasts.
    pub keyframes: *const usize,
    /// How many steps `keyframes` points to.
    pub keyframe_count: usize,
    /// What the data term of each keyframe is multiplied by, above 0: `keyframe_count` numbers, or null where all are 1. Read as `keyframes`.
    pub keyframe_weights: *const f64,
    /// Smoke that is made on the way, where `thurible_set_emitter` says. Read as `keyframes`.
    pub emitters: *const ThuribleEmitter,
    /// How many emitters `emitters` points to, at most `THURIBLE_MOST_EMITTERS`.
    pub emitter_count: usize,
    /// What the price of the force is multiplied by at some steps, ascending: linear in its logarithm between them, as the nearest before the
    /// first and after the last. Read as `keyframes`.
    pub schedule: *const ThuribleFactor,
    /// How many factors `schedule` points to, at most `THURIBLE_MOST_FACTORS`.
    pub schedule_count: usize,
    /// Simple fields that the force is made of, for the method of templates; a simulation adds them as they are. Read as `keyframes`.
    pub templates: *const ThuribleTemplate,
    /// How many templates `templates` points to, at most `THURIBLE_MOST_TEMPLATES`.
    pub template_count: usize,
    /// Step from which no force acts, from 2 to N - 1 and not before the last keyframe; 0, the default, for none.
    pub release: usize,
    /// Acceleration of the flow where the density is 1, along x, y and z, in lengths per squared time; z is ignored in 2D. None by default.
    pub buoyancy: [f64; 3],
    /// Weight r of the force, an acceleration, so that the same weight in other units is r' dt^4 / length^2: 1000 by default, whatever `dt` and `length` are, where scenes and
    /// Python take 1000 dt^4 / length^2.
    pub force_weight: f64,
    /// Kinematic viscosity, in squared lengths per time; 0 for none.
    pub viscosity: f64,
    /// Smoothness of the force, in cells from 0 to 64: forces finer than that are dear. 0 is the paper's price; -1, the default, stands for 2.5 with limited
    /// transport and 0 with the others. ADMM prices no curls, and takes 0 or -1 alone.
    pub smoothness: f64,
    /// Filters of the metric, at most 12, or `THURIBLE_AUTOMATIC`.
    pub filters: u32,
    /// Whether keyframes are scaled to the mass of the smoke at their steps: 0 or 1.
    pub match_mass: u32,
    /// A `ThuribleScheme`; limited by default.
    pub scheme: u32,
    /// Whether each keyframe has a region that `thurible_set_region` sets: 0, the default, or 1.
    pub keyframe_regions: u32,
    /// Whether there are solid cells, which `thurible_set_solids` sets: 0, the default, or 1. They need limited transport.
    pub solids: u32,
    /// Whether force may act only where `thurible_set_mask` says: 0, the default, or 1. ADMM knows no mask.
    pub mask: u32,
    /// The series of a transport step is cut at the first term below this times the largest density.
    pub advection_tolerance: f64,
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
    /// Iterations of the method, at most; of the direct method those on the finest grid.
    pub iterations: usize,
    /// Threads that memory is planned for, from 1 to 1024; an executor must not have more.
    pub threads: usize,
    /// Bytes that the plan should stay within if it can; 0 for none.
    pub memory_ceiling: usize,
    /// Direct: pairs of L-BFGS from 1 to 8, or `THURIBLE_AUTOMATIC`.
    pub direct_history: u32,
    /// Direct: whether to begin on coarser grids: 0 or 1.
    pub direct_nested: u32,
    /// Direct: stop when the objective falls by less than this times itself, twice in a row.
    pub direct_tolerance: f64,
    /// ADMM: penalty K, above 0, in the units of the scene: 1000 by default, where scenes and Python take 1000 dt^2 / length^2.
    pub admm_penalty: f64,
    /// ADMM: relaxation beta of the multipliers.
    pub admm_relaxation: f64,
    /// ADMM: momentum of the advection problem, at least 0 and below 1.
    pub admm_ao_momentum: f64,
    /// ADMM: stop when densities change less than this times the largest.
    pub admm_density_tolerance: f64,
    /// ADMM: iterations of the advection problem in each iteration.
    pub admm_ao_iterations: u32,
    /// ADMM: whether to begin on coarser grids: 0 or 1.
    pub admm_nested: u32,
    /// ADMM: a `ThuribleNsoSolver`; multigrid by default.
    pub nso_solver: u32,
    /// ADMM: V-cycles or Newton steps of a Navier-Stokes problem at most, from 1 to 63.
    pub nso_cycles: u32,
    /// ADMM: stop a Navier-Stokes problem at a residual below this.
    pub nso_tolerance: f64,
    /// ADMM: a `ThuribleNorm`; scaled by default.
    pub nso_norm: u32,
    /// ADMM: the smoother's colours: a `ThuribleColours`.
    pub nso_colours: u32,
    /// L-BFGS over forces: stop as `direct_tolerance`.
    pub lbfgs_tolerance: f64,
    /// L-BFGS over forces: pairs from 1 to 8, or `THURIBLE_AUTOMATIC`.
    pub lbfgs_history: u32,
    /// L-BFGS over forces: whether to begin on a coarser grid: 0 or 1.
    pub lbfgs_nested: u32,
    /// Target-driven smoke: weight of the driving force.
    pub pd_drive: f64,
    /// Target-driven smoke: rate at which momentum is lost.
    pub pd_attenuation: f64,
    /// Target-driven smoke: weight of the gathering term.
    pub pd_gathering: f64,
    /// Simulations, L-BFGS over forces and target-driven smoke: relative residual of an implicit step.
    pub simulation_tolerance: f64,
    /// Templates: pairs of L-BFGS from 1 to 8.
    pub templates_history: u32,
    /// Direct: iterations at most on each coarser grid, from 1 to 100000, or `THURIBLE_AUTOMATIC`.
    pub direct_coarse_iterations: u32,
    /// Templates: stop as `direct_tolerance`.
    pub templates_tolerance: f64,
    /// Guidance: what is larger than so many cells follows the given flow.
    pub guide_radius: f64,
    /// Guidance: how smooth the correction of a step is.
    pub guide_smoothness: f64,
    /// Guidance: how dear the kinetic energy of the correction is.
    pub guide_kinetic: f64,
    /// Guidance by ADMM: its penalty.
    pub guide_penalty: f64,
    /// Guidance by ADMM: its iterations for each step, from 1 to 1000.
    pub guide_iterations: u32,
    /// Guidance: a `ThuribleGuideSolver`; automatic by default.
    pub guide_solver: u32,
    /// Direct: a `ThuribleHistoryPrecision`; full by default.
    pub direct_history_precision: u32,
    /// L-BFGS over forces: a `ThuribleHistoryPrecision`; full by default.
    pub lbfgs_history_precision: u32,
    /// Guidance: noise without divergence that stirs each step, its root mean square in cells a step; 0 by default, for none.
    pub guide_curl_noise: f64,
    /// Guidance: how wide the noise is blurred, in cells.
    pub guide_noise_sigma: f64,
    /// Guidance: which noise, from 1.
    pub guide_noise_seed: u32,
    /// Whether the flow sticks to walls and solid cells, by its viscosity, which is above 0 then, and does not slip along them: 0, the default,
    /// or 1. ADMM's multigrid and Stable Fluids refuse it.
    pub no_slip: u32,
    /// Direct: what the force's weight is multiplied by from each grid to the next coarser one, above 0 and below 100; 1 by default.
    pub direct_coarse_force_weight: f64,
}

// SAFETY: plain numbers and pointers, the size first.
unsafe impl sized::Versioned for ThuribleConfig {}

/// Fields of a configuration, and what the core calls the choices that they hold.
macro_rules! held {
    ($config:ident: $($field:ident $choice:literal,)+) => {
        [$($crate::config::Held {
            field: stringify!($field),
            choice: $choice,
            slot: $crate::config::Slot::from(&mut $config.$field),
        }),+]
    };
}

pub(crate) use held;

impl ThuribleConfig {
    /// Every field that holds a choice of a method, and what the core calls it.
    fn held(&mut self) -> [Held<'_>; 36] {
        held! { self:
            direct_history "direct.history",
            direct_history_precision "direct.history_precision",
            direct_nested "direct.nested",
            direct_coarse_iterations "direct.coarse_iterations",
            direct_coarse_force_weight "direct.coarse_force_weight",
            direct_tolerance "direct.tolerance",
            admm_penalty "admm.penalty",
            admm_relaxation "admm.relaxation",
            admm_ao_momentum "admm.ao_momentum",
            admm_density_tolerance "admm.density_tolerance",
            admm_ao_iterations "admm.ao_iterations",
            admm_nested "admm.nested",
            nso_solver "admm.nso",
            nso_cycles "admm.nso_cycles",
            nso_tolerance "admm.nso_tolerance",
            nso_norm "admm.nso_norm",
            nso_colours "admm.smoother_colours",
            lbfgs_history "lbfgs.history",
            lbfgs_history_precision "lbfgs.history_precision",
            lbfgs_tolerance "lbfgs.tolerance",
            lbfgs_nested "lbfgs.nested",
            pd_drive "pd.drive",
            pd_attenuation "pd.attenuation",
            pd_gathering "pd.gathering",
            simulation_tolerance "simulation.tolerance",
            templates_history "templates.history",
            templates_tolerance "templates.tolerance",
            guide_radius "guide.radius",
            guide_smoothness "guide.smoothness",
            guide_kinetic "guide.kinetic",
            guide_penalty "guide.penalty",
            guide_iterations "guide.iterations",
            guide_solver "guide.solver",
            guide_curl_noise "guide.curl_noise",
            guide_noise_sigma "guide.noise_sigma",
            guide_noise_seed "guide.noise_seed",
        }
    }
}

/// The smoothness that stands for the default.
const AUTOMATIC_SMOOTHNESS: f64 = -1.0;
