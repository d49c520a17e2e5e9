//! One of four types: either precision in either dimension.

/// What is of either precision in either dimension.
#[derive(Debug)]
pub enum Any<P32, P64, S32, S64> {
    /// Two dimensions, elements in `f32`.
    Plane32(P32),
    /// Two dimensions, elements in `f64`.
    Plane64(P64),
    /// Three dimensions, elements in `f32`.
    Space32(S32),
    /// Three dimensions, elements in `f64`.
    Space64(S64),
}

/// Evaluates `$call` with `$one` bound to what is inside an [`Any`], whatever its type.
#[macro_export]
macro_rules! each {
    ($any:expr, $one:ident => $call:expr) => {
        match $any {
            $crate::instance::Any::Plane32($one) => $call,
            $crate::instance::Any::Plane64($one) => $call,
            $crate::instance::Any::Space32($one) => $call,
            $crate::instance::Any::Space64($one) => $call,
        }
    };
}
