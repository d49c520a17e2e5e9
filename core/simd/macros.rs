//! Functions compiled for several instruction sets, and generic ones compiled once for the types that they
//! are used with.
//!
//! All that is unsafe about them is here: the functions that these macros write are safe to call.

/// Compiles a kernel once for every [`Level`](super::Level) and calls the one in force.
///
/// The body must be plain loops over slices; what it calls must be `#[inline(always)]`.
macro_rules! multiversion {
    (
        $(#[$meta:meta])*
        $vis:vis fn $name:ident[$($gen:tt)*]($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? $body:block
    ) => {
        $(#[$meta])*
        #[allow(unsafe_code)]
        $vis fn $name<$($gen)*>($($arg: $ty),*) $(-> $ret)? {
            #[inline(always)]
            fn body<$($gen)*>($($arg: $ty),*) $(-> $ret)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
                unsafe fn avx512<$($gen)*>($($arg: $ty),*) $(-> $ret)? {
                    body($($arg),*)
                }
                #[target_feature(enable = "avx2")]
                unsafe fn avx2<$($gen)*>($($arg: $ty),*) $(-> $ret)? {
                    body($($arg),*)
                }
                match $crate::simd::level() {
                    // SAFETY: `level` returns only what the processor has.
                    $crate::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    $crate::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::simd::Level::Baseline => {}
                }
            }
            body($($arg),*)
        }
    };
}
pub(crate) use multiversion;

/// Compiles a kernel once for every [`Level`](super::Level), with the vectors of that level as its type
/// parameter `V`.
///
/// `fn name[T, V](..)`: the body may use `V: Vector<Elem = T>`; what it calls must be `#[inline(always)]`.
macro_rules! vectorised {
    (
        $(#[$meta:meta])*
        $vis:vis fn $name:ident[$t:ident, $v:ident]($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? $body:block
    ) => {
        $(#[$meta])*
        #[allow(unsafe_code)]
        $vis fn $name<$t: $crate::real::Real>($($arg: $ty),*) $(-> $ret)? {
            #[inline(always)]
            fn body<$t: $crate::real::Real, $v: $crate::simd::Vector<Elem = $t>>($($arg: $ty),*) $(-> $ret)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
                unsafe fn avx512<$t: $crate::real::Real>($($arg: $ty),*) $(-> $ret)? {
                    body::<$t, $t::Wide>($($arg),*)
                }
                #[target_feature(enable = "avx2")]
                unsafe fn avx2<$t: $crate::real::Real>($($arg: $ty),*) $(-> $ret)? {
                    body::<$t, $t::Medium>($($arg),*)
                }
                match $crate::simd::level() {
                    // SAFETY: `level` returns only what the processor has.
                    $crate::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    $crate::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::simd::Level::Baseline => {}
                }
            }
            body::<$t, $t::Narrow>($($arg),*)
        }
    };
}
pub(crate) use vectorised;

/// Compiles functions each for one instruction set alone, and with a stack frame of its own. A caller shows
/// that the processor has it by a proof: [`avx512`](super::avx512) or [`avx2`](super::avx2).
///
/// `fn name[T: Real, S: Space; FLAG](Avx2; arg: Type) { .. }`: type parameters with their bounds, then flags,
/// which are constants of type `bool`. What the body calls must be `#[inline(always)]`.
macro_rules! compiled_for {
    (@with Avx512 $($function:tt)*) => {
        #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
        $($function)*
    };
    (@with Avx2 $($function:tt)*) => {
        #[target_feature(enable = "avx2")]
        $($function)*
    };
    ($(
        $(#[$meta:meta])*
        fn $name:ident[$($t:ident: $bound:path),*; $($flag:ident),*]($set:ident; $arg:ident: $ty:ty) $body:block
    )*) => {$(
        $(#[$meta])*
        #[allow(unsafe_code)]
        #[inline(always)]
        fn $name<$($t: $bound,)* $(const $flag: bool),*>(proof: $crate::simd::$set, $arg: $ty) {
            #[cfg(target_arch = "x86_64")]
            {
                $crate::simd::compiled_for! {
                    @with $set
                    unsafe fn framed<$($t: $bound,)* $(const $flag: bool),*>($arg: $ty) $body
                }
                let _ = proof;
                // SAFETY: there is a proof only where the processor has the instruction set.
                unsafe { framed::<$($t,)* $($flag),*>($arg) }
            }
            #[cfg(not(target_arch = "x86_64"))]
            {
                let _ = $arg;
                proof.absurd()
            }
        }
    )*};
}
pub(crate) use compiled_for;

/// Compiles a generic function in this crate for a list of types, and not again in every program that calls
/// it. With other types it does nothing.
///
/// `fn name[T: Real, S: Space](arg: Type) for [f32, D2] [f64, D2] { .. }`
macro_rules! compiled_once {
    (
        $(#[$meta:meta])*
        fn $name:ident[$t:ident: $t_bound:path, $s:ident: $s_bound:path]($arg:ident: $ty:ty)
            for $([$t_is:ty, $s_is:ty])* $body:block
    ) => {
        $(#[$meta])*
        fn $name<$t: $t_bound, $s: $s_bound>($arg: $ty) {
            #[inline(always)]
            fn body<$t: $t_bound, $s: $s_bound>($arg: $ty) $body

            let moved = core::mem::ManuallyDrop::new($arg);
            $(if core::any::TypeId::of::<($t, $s)>() == core::any::TypeId::of::<($t_is, $s_is)>() {
                #[allow(dead_code)]
                type $t = $t_is;
                #[allow(dead_code)]
                type $s = $s_is;
                #[inline(never)]
                fn compiled($arg: $ty) {
                    body::<$t, $s>($arg)
                }
                #[allow(unsafe_code)]
                // SAFETY: the type parameters are these types, so both arguments have one type; the original
                // is not used again.
                return compiled(unsafe { core::mem::transmute_copy(&moved) });
            })*
        }
    };
}
pub(crate) use compiled_once;
