//! What a caller chooses besides the problem.

use super::list::for_each_method;
use super::refusal::{PlanError, count};
use crate::words::named;

/// Most threads that a plan serves.
pub const MAX_THREADS: usize = 1024;
/// Most outer iterations.
pub const MAX_ITERATIONS: usize = 1_000_000;

macro_rules! define {
    ($($(#[$doc:meta])* $kind:ident $name:literal, $field:ident: $($choices:ident)::+, $($state:ident)::+;)+) => {
        /// How a problem is solved.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum Method {
            #[default]
            $($(#[$doc])* $kind,)+
        }

        named!(Method { $($kind = $name,)+ });

        /// What a caller chooses besides the problem.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Params {
            /// The method.
            pub method: Method,
            /// Outer iterations at most; of methods that begin on coarser grids, those on the finest grid.
            pub iterations: usize,
            /// Threads that scratch is planned for; the [`Exec`](crate::Exec) of a step must not have more.
            pub threads: usize,
            /// Bytes that the plan should stay within if it can.
            pub ceiling: Option<usize>,
            $(
                #[doc = concat!("Choices of the method `", $name, "`.")]
                pub $field: crate::method::$($choices)::+,
            )+
        }

        impl Default for Params {
            fn default() -> Self {
                Self {
                    method: Method::default(),
                    iterations: 60,
                    threads: 1,
                    ceiling: None,
                    $($field: Default::default(),)+
                }
            }
        }

        impl Params {
            /// Checks every choice, those of other methods included.
            ///
            /// # Errors
            /// [`PlanError`] names the first that is wrong.
            pub fn check(&self) -> Result<(), PlanError> {
                $(self.$field.check()?;)+
                count("iterations", self.iterations, MAX_ITERATIONS)?;
                count("threads", self.threads, MAX_THREADS)
            }
        }
    };
}

for_each_method!(define);
