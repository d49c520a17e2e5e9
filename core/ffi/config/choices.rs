//! Codes of the configuration, each with what the core calls it.

use super::ConfigError;
use thurible_core::{Boundary, Colours, Method, Norm, NsoSolver, Scheme};

/// Precision of all fields: bytes of an element.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuriblePrecision {
    /// `float`, 4 bytes an element.
    F32 = 4,
    /// `double`, 8 bytes an element.
    F64 = 8,
}

/// How an axis ends.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleBoundary {
    /// Walls at both ends: no flow through them, free slip along them.
    Wall = 0,
    /// Both ends are the same place: what leaves at one enters at the other.
    Periodic = 1,
}

impl ThuribleBoundary {
    pub(super) const CODES: [(u32, Boundary); 2] = [
        (Self::Wall as u32, Boundary::Wall),
        (Self::Periodic as u32, Boundary::Periodic),
    ];
}

/// How density is carried.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleScheme {
    /// Third-order upwind interpolation to faces, mass preserving.
    Quick = 0,
    /// Central interpolation to faces: the mean of both cells, mass preserving.
    Central = 1,
    /// Back-tracing with linear interpolation.
    SemiLagrangian = 2,
}

impl ThuribleScheme {
    pub(super) const CODES: [(u32, Scheme); 3] = [
        (Self::Quick as u32, Scheme::Quick),
        (Self::Central as u32, Scheme::Central),
        (Self::SemiLagrangian as u32, Scheme::SemiLagrangian),
    ];
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

impl ThuribleMethod {
    pub(super) const CODES: [(u32, Method); 5] = [
        (Self::Direct as u32, Method::Direct),
        (Self::Admm as u32, Method::Admm),
        (Self::Lbfgs as u32, Method::Lbfgs),
        (Self::Pd as u32, Method::Pd),
        (Self::Simulate as u32, Method::Simulate),
    ];
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

impl ThuribleNsoSolver {
    pub(super) const CODES: [(u32, NsoSolver); 2] = [
        (Self::Stfas as u32, NsoSolver::Stfas),
        (Self::NewtonCg as u32, NsoSolver::NewtonCg),
    ];
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

impl ThuribleColours {
    pub(super) const CODES: [(u32, Colours); 2] = [
        (Self::RedBlack as u32, Colours::RedBlack),
        (Self::PowerOfTwo as u32, Colours::PowerOfTwo),
    ];
}

/// In which units divergences count in the residual of STFAS.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleNorm {
    /// As accelerations, in which the other equations are.
    Scaled = 0,
    /// In their own units, as in the paper.
    Plain = 1,
}

impl ThuribleNorm {
    pub(super) const CODES: [(u32, Norm); 2] = [
        (Self::Scaled as u32, Norm::Scaled),
        (Self::Plain as u32, Norm::Plain),
    ];
}

/// What the code `given` of `field` stands for in `codes`.
pub(super) fn code<V: Copy, const N: usize>(
    field: &'static str,
    given: u32,
    codes: [(u32, V); N],
) -> Result<V, ConfigError> {
    let found = codes.iter().find(|(code, _)| *code == given);
    found
        .map(|&(_, value)| value)
        .ok_or(ConfigError::Code { field, given })
}

/// A code that is 0 or 1.
pub(super) fn flag(field: &'static str, given: u32) -> Result<bool, ConfigError> {
    code(field, given, [(0, false), (1, true)])
}
