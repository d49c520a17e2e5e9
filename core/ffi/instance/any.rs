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

/// Evaluates `$call` by the types and the wrapper of an [`Any`] that `$kind`, a precision and a number of axes, stands for.
#[macro_export]
macro_rules! typed {
    ($kind:expr, $real:ident, $space:ident, $wrap:ident => $call:expr) => {
        match $kind {
            ($crate::config::ThuriblePrecision::F32, 2) => {
                $crate::typed!(@ f32, D2, Plane32, $real, $space, $wrap, $call)
            }
            ($crate::config::ThuriblePrecision::F64, 2) => {
                $crate::typed!(@ f64, D2, Plane64, $real, $space, $wrap, $call)
            }
            ($crate::config::ThuriblePrecision::F32, _) => {
                $crate::typed!(@ f32, D3, Space32, $real, $space, $wrap, $call)
            }
            ($crate::config::ThuriblePrecision::F64, _) => {
                $crate::typed!(@ f64, D3, Space64, $real, $space, $wrap, $call)
            }
        }
    };
    (@ $of:ty, $dim:ident, $variant:ident, $real:ident, $space:ident, $wrap:ident, $call:expr) => {{
        type $real = $of;
        type $space = thurible_core::$dim;
        #[allow(unused_imports)]
        use $crate::instance::Any::$variant as $wrap;
        $call
    }};
}
