//! The scene and the choices, as C gives them.

use crate::result::ThuribleResult;
use core::ffi::c_char;
use core::fmt;
use core::mem::size_of;
use thurible_core::problem::MAX_STEPS;
use thurible_core::{
    Advection, Boundary, Colours, Method, Norm, NsoSolver, Params, PlanError, Problem, Scheme,
};

/// What a number of the configuration holds to leave the choice to the library.
pub const THURIBLE_AUTOMATIC: u32 = u32::MAX;

/// Precision of all numbers: their bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuriblePrecision {
    /// `float`.
    F32 = 4,
    /// `double`.
    F64 = 8,
}

/// How an axis ends.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleBoundary {
    /// Closed, free slip.
    Wall = 0,
    /// Wraps around.
    Periodic = 1,
}

/// How density is carried.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleScheme {
    /// Third-order upwind interpolation to faces, mass preserving.
    Quick = 0,
    /// Central interpolation.
    Central = 1,
    /// Back-tracing with linear interpolation.
    SemiLagrangian = 2,
}

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
}

/// How ADMM solves its Navier-Stokes problems.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleNsoSolver {
    /// Multigrid in space and time.
    Stfas = 0,
    /// Newton's method with conjugate gradients.
    NewtonCg = 1,
}

/// The colours of the smoother of STFAS.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleColours {
    /// Two, by the parity of x + y (+ z).
    RedBlack = 0,
    /// 2^d, by the parity of each coordinate.
    PowerOfTwo = 1,
}

/// In which units divergences count in the residual of STFAS.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleNorm {
    /// As accelerations.
    Scaled = 0,
    /// As they are.
    Plain = 1,
}

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
    /// Time step.
    pub dt: f64,
    /// Steps N, at least 2. To be set.
    pub steps: usize,
    /// Steps of the keyframes, ascending, from 2 to N; read only while a call that takes the configuration lasts.
    pub keyframes: *const usize,
    /// How many.
    pub keyframe_count: usize,
    /// Weight r of the force.
    pub force_weight: f64,
    /// Kinematic viscosity, in squared lengths per time; 0 for none.
    pub viscosity: f64,
    /// Filters of the metric, at most 12, or `THURIBLE_AUTOMATIC`.
    pub filters: u32,
    /// Whether keyframes are scaled to the mass of the source: 0 or 1.
    pub match_mass: u32,
    /// A `ThuribleScheme`; quick by default.
    pub scheme: u32,
    /// The smoother's colours, of ADMM: a `ThuribleColours`.
    pub nso_colours: u32,
    /// The series of a transport step is cut at the first term below this times the largest density.
    pub advection_tolerance: f64,
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
    /// Iterations at most.
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
    /// ADMM: penalty K.
    pub admm_penalty: f64,
    /// ADMM: relaxation beta.
    pub admm_relaxation: f64,
    /// ADMM: momentum of the advection problem, at least 0 and below 1.
    pub admm_ao_momentum: f64,
    /// ADMM: stop when densities change less than this times the largest.
    pub admm_density_tolerance: f64,
    /// ADMM: iterations of the advection problem in each iteration.
    pub admm_ao_iterations: u32,
    /// ADMM: whether to begin on coarser grids: 0 or 1.
    pub admm_nested: u32,
    /// ADMM: a `ThuribleNsoSolver`.
    pub nso_solver: u32,
    /// ADMM: V-cycles or Newton steps of a Navier-Stokes problem at most, from 1 to 63.
    pub nso_cycles: u32,
    /// ADMM: stop a Navier-Stokes problem at a residual below this.
    pub nso_tolerance: f64,
    /// ADMM: a `ThuribleNorm`.
    pub nso_norm: u32,
    /// L-BFGS over forces: pairs from 1 to 8.
    pub lbfgs_history: u32,
    /// L-BFGS over forces: stop as `direct_tolerance`.
    pub lbfgs_tolerance: f64,
    /// L-BFGS over forces: whether to begin on a coarser grid: 0 or 1.
    pub lbfgs_nested: u32,
    /// Nothing: 0.
    pub reserved: u32,
    /// Target-driven smoke: weight of the driving force.
    pub pd_drive: f64,
    /// Target-driven smoke: rate at which momentum is lost.
    pub pd_attenuation: f64,
    /// Target-driven smoke: weight of the gathering term.
    pub pd_gathering: f64,
    /// Simulations: upward acceleration where the density is 1.
    pub simulation_buoyancy: f64,
    /// Simulations, L-BFGS over forces and target-driven smoke: relative residual of an implicit step.
    pub simulation_tolerance: f64,
}

/// Bytes of this version, which is the first.
const SIZE: usize = size_of::<ThuribleConfig>();
/// No version will have more.
const MOST_BYTES: usize = 1 << 16;

/// Why a configuration is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// As a call says it.
    Result(ThuribleResult),
    /// A code that stands for nothing.
    Code {
        /// The field.
        field: &'static str,
        /// The code.
        given: u32,
    },
    /// There are more keyframes than steps.
    Keyframes {
        /// How many.
        given: usize,
    },
    /// `keyframes` is null or misaligned.
    KeyframePointer,
    /// The core refuses it.
    Plan(PlanError),
}

impl ConfigError {
    /// What a call returns.
    #[must_use]
    pub fn result(self) -> ThuribleResult {
        match self {
            Self::Result(result) => result,
            Self::Plan(error) => error.into(),
            _ => ThuribleResult::Config,
        }
    }
}

impl From<PlanError> for ConfigError {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Result(ThuribleResult::Null) => write!(f, "the pointer to the configuration is null"),
            Self::Result(ThuribleResult::Misaligned) => write!(f, "the configuration is misaligned"),
            Self::Result(_) => write!(
                f,
                "the size of the configuration is that of no known version; call thurible_defaults first"
            ),
            Self::Code { field, given } => write!(f, "{field} is {given}, which stands for nothing"),
            Self::Keyframes { given } => {
                write!(f, "keyframe_count is {given}; it must be at most {MAX_STEPS}")
            }
            Self::KeyframePointer => {
                write!(f, "keyframes is null or misaligned, but keyframe_count is not 0")
            }
            Self::Plan(error) => error.fmt(f),
        }
    }
}

/// A count that fits the core's counts on every machine.
fn wide(count: u32) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

fn narrow(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(THURIBLE_AUTOMATIC)
}

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
            lbfgs_history: narrow(lbfgs.history),
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

impl ThuribleConfig {
    /// Reads a configuration of any version up to this one.
    ///
    /// # Errors
    /// [`ConfigError`]: null, misaligned, or of an unknown size.
    ///
    /// # Safety
    /// `config` is null or points to a configuration of `size` bytes.
    pub unsafe fn read(config: *const Self) -> Result<Self, ConfigError> {
        if config.is_null() {
            return Err(ConfigError::Result(ThuribleResult::Null));
        }
        if !config.is_aligned() {
            return Err(ConfigError::Result(ThuribleResult::Misaligned));
        }
        // SAFETY: not null and aligned; `size` is the first field of every version.
        let size = unsafe { config.cast::<usize>().read() };
        if !(SIZE..=MOST_BYTES).contains(&size) {
            return Err(ConfigError::Result(ThuribleResult::ConfigSize));
        }
        // SAFETY: the caller promises `size` bytes.
        let later = unsafe { core::slice::from_raw_parts(config.cast::<u8>().add(SIZE), size - SIZE) };
        // What a later version added is known only as far as it is left at nothing.
        if later.iter().any(|&byte| byte != 0) {
            return Err(ConfigError::Result(ThuribleResult::ConfigSize));
        }
        // SAFETY: as above, and every pattern of bits is a configuration.
        Ok(unsafe { config.read() })
    }

    /// Calls `work` with the problem and the choices that this describes.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// `keyframes` points to `keyframe_count` numbers.
    pub unsafe fn with<R>(&self, work: impl FnOnce(&Problem<'_>, &Params) -> R) -> Result<R, ConfigError> {
        let boundary = self.boundary.map(|end| {
            if end == ThuribleBoundary::Periodic as u32 {
                Boundary::Periodic
            } else {
                Boundary::Wall
            }
        });
        let dims = match self.dimensions {
            2 => 2,
            3 => 3,
            given => {
                return Err(ConfigError::Code {
                    field: "dimensions",
                    given,
                });
            }
        };
        for &given in self.boundary.iter().take(dims) {
            let [wall, periodic] = [ThuribleBoundary::Wall, ThuribleBoundary::Periodic].map(|end| end as u32);
            code("boundary", given, [(wall, ()), (periodic, ())])?;
        }
        let params = self.params()?;
        let [scheme, filters] = [self.scheme, self.filters];
        let problem = Problem {
            cells: self.cells.get(..dims).unwrap_or_default(),
            boundary: boundary.get(..dims).unwrap_or_default(),
            length: self.length,
            dt: self.dt,
            steps: self.steps,
            // SAFETY: the caller's promise.
            keyframes: unsafe { self.keyframe_steps() }?,
            force_weight: self.force_weight,
            viscosity: self.viscosity,
            filters: (filters != THURIBLE_AUTOMATIC).then(|| wide(filters)),
            match_mass: flag("match_mass", self.match_mass)?,
            advection: Advection {
                scheme: code(
                    "scheme",
                    scheme,
                    [
                        (ThuribleScheme::Quick as u32, Scheme::Quick),
                        (ThuribleScheme::Central as u32, Scheme::Central),
                        (ThuribleScheme::SemiLagrangian as u32, Scheme::SemiLagrangian),
                    ],
                )?,
                tolerance: self.advection_tolerance,
            },
            projection_tolerance: self.projection_tolerance,
        };
        Ok(work(&problem, &params))
    }

    /// # Safety
    /// `keyframes` points to `keyframe_count` numbers.
    unsafe fn keyframe_steps(&self) -> Result<&[usize], ConfigError> {
        match self.keyframe_count {
            0 => Ok(&[]),
            given if given > MAX_STEPS => Err(ConfigError::Keyframes { given }),
            _ if self.keyframes.is_null() || !self.keyframes.is_aligned() => {
                Err(ConfigError::KeyframePointer)
            }
            // SAFETY: not null, aligned, and the caller promises the numbers.
            count => Ok(unsafe { core::slice::from_raw_parts(self.keyframes, count) }),
        }
    }

    fn params(&self) -> Result<Params, ConfigError> {
        let mut params = Params {
            method: code(
                "method",
                self.method,
                [
                    (ThuribleMethod::Direct as u32, Method::Direct),
                    (ThuribleMethod::Admm as u32, Method::Admm),
                    (ThuribleMethod::Lbfgs as u32, Method::Lbfgs),
                    (ThuribleMethod::Pd as u32, Method::Pd),
                    (ThuribleMethod::Simulate as u32, Method::Simulate),
                ],
            )?,
            iterations: self.iterations,
            threads: self.threads,
            ceiling: (self.memory_ceiling != 0).then_some(self.memory_ceiling),
            ..Params::default()
        };
        let Params {
            admm,
            direct,
            lbfgs,
            pd,
            simulation,
            ..
        } = &mut params;
        direct.history = (self.direct_history != THURIBLE_AUTOMATIC).then(|| wide(self.direct_history));
        direct.nested = flag("direct_nested", self.direct_nested)?;
        direct.tolerance = self.direct_tolerance;
        admm.penalty = self.admm_penalty;
        admm.relaxation = self.admm_relaxation;
        admm.ao_momentum = self.admm_ao_momentum;
        admm.density_tolerance = self.admm_density_tolerance;
        admm.ao_iterations = wide(self.admm_ao_iterations);
        admm.nested = flag("admm_nested", self.admm_nested)?;
        let solvers = [
            (ThuribleNsoSolver::Stfas as u32, NsoSolver::Stfas),
            (ThuribleNsoSolver::NewtonCg as u32, NsoSolver::NewtonCg),
        ];
        admm.nso.solver = code("nso_solver", self.nso_solver, solvers)?;
        let colours = [
            (ThuribleColours::RedBlack as u32, Colours::RedBlack),
            (ThuribleColours::PowerOfTwo as u32, Colours::PowerOfTwo),
        ];
        admm.nso.colours = code("nso_colours", self.nso_colours, colours)?;
        let norms = [
            (ThuribleNorm::Scaled as u32, Norm::Scaled),
            (ThuribleNorm::Plain as u32, Norm::Plain),
        ];
        admm.nso.norm = code("nso_norm", self.nso_norm, norms)?;
        admm.nso.cycles = wide(self.nso_cycles);
        admm.nso.tolerance = self.nso_tolerance;
        lbfgs.history = wide(self.lbfgs_history);
        lbfgs.tolerance = self.lbfgs_tolerance;
        lbfgs.nested = flag("lbfgs_nested", self.lbfgs_nested)?;
        (pd.drive, pd.attenuation, pd.gathering) = (self.pd_drive, self.pd_attenuation, self.pd_gathering);
        (simulation.buoyancy, simulation.tolerance) = (self.simulation_buoyancy, self.simulation_tolerance);
        code("reserved", self.reserved, [(0, params)])
    }
}

/// What a code stands for.
fn code<V: Copy, const N: usize>(
    field: &'static str,
    given: u32,
    codes: [(u32, V); N],
) -> Result<V, ConfigError> {
    let found = codes.iter().find(|(code, _)| *code == given);
    found
        .map(|&(_, value)| value)
        .ok_or(ConfigError::Code { field, given })
}

fn flag(field: &'static str, given: u32) -> Result<bool, ConfigError> {
    code(field, given, [(0, false), (1, true)])
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleConfig)` of the program that calls, with the defaults.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_defaults(config: *mut ThuribleConfig, size: usize) -> ThuribleResult {
    match () {
        () if config.is_null() => ThuribleResult::Null,
        () if !config.is_aligned() => ThuribleResult::Misaligned,
        () if !(SIZE..=MOST_BYTES).contains(&size) => ThuribleResult::ConfigSize,
        () => {
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
    }
}

/// Writes why a configuration is refused, or nothing where it is not, into `buffer` of `size` bytes, cut where it does not fit and
/// always ended by a zero byte; bytes of the whole text. A null `buffer` only counts.
///
/// # Safety
/// `config` is null or points to a configuration whose `keyframes` are there; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_explain(
    config: *const ThuribleConfig,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    let planned = unsafe { ThuribleConfig::read(config).and_then(|config| crate::instance::plan(&config)) };
    match planned {
        // SAFETY: as above.
        Ok(_) => unsafe { crate::text::write(buffer, size, &"") },
        // SAFETY: as above.
        Err(error) => unsafe { crate::text::write(buffer, size, &error) },
    }
}
