//! Codes of the configuration, which number the core's values.

use super::ConfigError;
use thurible_core::Named;

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
    /// Walls at both ends: no flow through them, free slip along them unless the flow sticks.
    Wall = 0,
    /// Both ends are the same place: what leaves at one enters at the other.
    Periodic = 1,
    /// Both ends are open: the pressure outside is 0, smoke leaves, and none comes in.
    Open = 2,
    /// The low end is open, the high one a wall.
    OpenLow = 3,
    /// The high end is open, the low one a wall.
    OpenHigh = 4,
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
    /// Third-order upwind with a limiter: no density outside 0 .. max, mass preserving.
    Limited = 3,
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

/// How the correction of a guided step is found.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleGuideSolver {
    /// In closed form, among solid cells by ADMM.
    Auto = 0,
    /// In closed form, which among solid cells is rough.
    ClosedForm = 1,
    /// By ADMM.
    Admm = 2,
}

/// In how many bytes the numbers of the pairs of L-BFGS are kept.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleHistoryPrecision {
    /// In those of an element.
    Full = 0,
    /// In half of them: bfloat16 for `float`, `float` for `double`.
    Half = 1,
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
    /// As accelerations, in which the other equations are.
    Scaled = 0,
    /// In their own units, as in the paper.
    Plain = 1,
}

/// Codes are the places of the core's values: a difference does not compile. What the core has beyond them is chosen by its number.
macro_rules! codes {
    ($codes:ident of $($core:ident)::+: $($value:ident),+) => {
        const _: () = {
            use thurible_core::$($core)::+ as Core;
            $(assert!($codes::$value as u32 == Core::$value as u32);)+
        };
    };
}

pub(crate) use codes;

codes!(ThuribleBoundary of Boundary: Wall, Periodic, Open, OpenLow, OpenHigh);
codes!(ThuribleScheme of Scheme: Quick, Central, SemiLagrangian, Limited);
codes!(ThuribleNsoSolver of NsoSolver: Stfas, NewtonCg);
codes!(ThuribleHistoryPrecision of HistoryPrecision: Full, Half);
codes!(ThuribleColours of Colours: RedBlack, PowerOfTwo);
codes!(ThuribleNorm of Norm: Scaled, Plain);
codes!(ThuribleGuideSolver of GuideSolver: Auto, ClosedForm, Admm);

/// What the code `given` of `field` stands for.
///
/// # Errors
/// [`ConfigError::Code`].
pub fn code<V: Named>(field: &'static str, given: u32) -> Result<V, ConfigError> {
    let value = V::ALL.get(wide(given)).copied();
    value.ok_or(ConfigError::Code { field, given })
}

/// A code that is 0 or 1.
pub(super) fn flag(given: u32) -> Option<bool> {
    match given {
        0 => Some(false),
        1 => Some(true),
        _ => None,
    }
}

/// The precision that a code stands for.
///
/// # Errors
/// [`ConfigError::Code`].
pub fn precision(given: u32) -> Result<ThuriblePrecision, ConfigError> {
    match given {
        4 => Ok(ThuriblePrecision::F32),
        8 => Ok(ThuriblePrecision::F64),
        given => Err(ConfigError::Code {
            field: "precision",
            given,
        }),
    }
}

/// A count that fits the core's counts on every machine.
#[must_use]
pub fn wide(count: u32) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}
