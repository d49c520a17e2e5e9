//! The methods behind one face: a state of any of them, and what a plan asks of each.

use super::contract::{Contract, Measure};
use super::list::for_each_method;
use super::params::{Method, Params};
use super::refusal::PlanError;
use crate::checkpoint::Mix;
use crate::grid::{D2, Share, Space};
use crate::problem::{Feature, Problem};
use crate::real::Real;

macro_rules! define {
    ($($(#[doc = $words:literal])+ $kind:ident $name:literal, $field:ident: $($choices:ident)::+, $($state:ident)::+;)+) => {
        /// The state of a method: every buffer but the keyframes.
        #[derive(Debug)]
        pub enum Engine<'m, T, S> {
            $($(#[doc = $words])+ $kind(crate::method::$($state)::+<'m, T, S>),)+
        }

        impl<'m, T: Real, S: Space> Engine<'m, T, S> {
            /// The method that `params` choose, without its buffers.
            #[must_use]
            pub fn new(problem: &Problem<'_>, params: &Params) -> Self {
                match params.method {
                    $(Method::$kind => in_its_frame(|| Self::$kind(Contract::<T, S>::new(problem, params))),)+
                }
            }

            /// The method, to read.
            #[must_use]
            pub fn get(&self) -> &dyn Contract<'m, T, S> {
                match self {
                    $(Self::$kind(method) => method,)+
                }
            }

            /// The method, to write.
            pub fn get_mut(&mut self) -> &mut dyn Contract<'m, T, S> {
                match self {
                    $(Self::$kind(method) => method,)+
                }
            }
        }

        /// The choices that `params` come to within their ceiling.
        ///
        /// # Errors
        /// [`PlanError`].
        pub fn fit<T: Real, S: Space>(
            problem: &Problem<'_>,
            params: &Params,
            measure: &Measure<'_>,
        ) -> Result<Params, PlanError> {
            match params.method {
                $(Method::$kind => <crate::method::$($state)::+<'_, T, S> as Contract<'_, T, S>>::fit(problem, params, measure),)+
            }
        }

        /// Whether the method steers to keyframes, so that there must be some.
        #[must_use]
        pub fn steers(params: &Params) -> bool {
            match params.method {
                $(Method::$kind => <crate::method::$($state)::+<'_, f32, D2> as Contract<'_, f32, D2>>::steers(params),)+
            }
        }

        /// Whether the method can do what a problem may ask for.
        #[must_use]
        pub fn takes(params: &Params, feature: Feature) -> bool {
            match params.method {
                $(Method::$kind => <crate::method::$($state)::+<'_, f32, D2> as Contract<'_, f32, D2>>::takes(params, feature),)+
            }
        }

        /// Whether the method follows a flow that must be given.
        #[must_use]
        pub fn follows(params: &Params) -> bool {
            match params.method {
                $(Method::$kind => <crate::method::$($state)::+<'_, f32, D2> as Contract<'_, f32, D2>>::follows(params),)+
            }
        }

        /// Whether the method simulates the flow forwards, so that a flow too fast to follow ends what can be known of it.
        #[must_use]
        pub fn simulates(params: &Params) -> bool {
            match params.method {
                $(Method::$kind => <crate::method::$($state)::+<'_, f32, D2> as Contract<'_, f32, D2>>::simulates(),)+
            }
        }

        /// Planes, or rows, beside its own that a rank needs copies of, or `None` where ranks cannot share the method.
        #[must_use]
        pub fn reach(params: &Params) -> Option<usize> {
            match params.method {
                $(Method::$kind => <crate::method::$($state)::+<'_, f32, D2> as Contract<'_, f32, D2>>::reach(params),)+
            }
        }

        /// Iterations of a solve at most, those on coarser grids included.
        #[must_use]
        pub fn most_iterations(problem: &Problem<'_>, params: &Params) -> usize {
            match params.method {
                $(Method::$kind => {
                    <crate::method::$($state)::+<'_, f32, D2> as Contract<'_, f32, D2>>::most_iterations(problem, params)
                })+
            }
        }

        /// Mixes in all choices of the method that its results follow from.
        pub fn mix<T: Real, S: Space>(params: &Params, mix: &mut Mix) {
            match params.method {
                $(Method::$kind => <crate::method::$($state)::+<'_, T, S> as Contract<'_, T, S>>::mix(params, mix),)+
            }
        }
    };
}

for_each_method!(define);

/// The smoothness in force, in cells: what is asked for, or that of the scheme where nothing is; 0 where the method prices no curls.
#[must_use]
pub fn smoothness(problem: &Problem<'_>, params: &Params) -> f64 {
    if takes(params, Feature::Smoothness) {
        problem
            .smoothness
            .unwrap_or(problem.advection.scheme.smoothness())
    } else {
        0.0
    }
}

/// The problem that a method solves: with the smoothness in force, and as many copies as it reads.
#[must_use]
pub fn resolved<'p>(problem: &Problem<'p>, params: &Params) -> Problem<'p> {
    Problem {
        smoothness: Some(smoothness(problem, params)),
        ..with_copies(problem, params)
    }
}

/// The problem with as many copies of neighbours' planes and rows as the method reads, where ranks share it.
#[must_use]
pub fn with_copies<'p>(problem: &Problem<'p>, params: &Params) -> Problem<'p> {
    let share = problem.share.map(|share| Share {
        reach: reach(params).unwrap_or(share.reach),
        ..share
    });
    Problem { share, ..*problem }
}

/// Calls `make` in a function of its own, so that the stack never holds what another method would need.
#[inline(never)]
fn in_its_frame<R>(make: impl FnOnce() -> R) -> R {
    make()
}
