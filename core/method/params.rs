//! What a caller chooses besides the problem.

use super::choices::Choices;
use super::list::for_each_method;
use super::refusal::{PlanError, count};
use crate::problem::positive;
use crate::words::{Named, named};

/// Most threads that a plan serves.
pub const MAX_THREADS: usize = 1024;
/// Most outer iterations.
pub const MAX_ITERATIONS: usize = 1_000_000;

macro_rules! define {
    ($($(#[doc = $words:literal])+ $kind:ident $name:literal, $field:ident: $($choices:ident)::+, $($state:ident)::+;)+) => {
        /// How a problem is solved.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum Method {
            #[default]
            $($(#[doc = $words])+ $kind,)+
        }

        named!(Method { $($kind = $name,)+ });

        impl Method {
            /// What it is, in a sentence.
            #[must_use]
            pub const fn words(self) -> &'static str {
                match self {
                    $(Self::$kind => concat!($($words),+).trim_ascii(),)+
                }
            }
        }

        /// The choices of each method.
        pub mod each {
            $(pub use crate::method::$($choices)::+;)+
        }

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
            /// The choices of `method`.
            #[must_use]
            pub fn choices(&self, method: Method) -> &dyn Choices {
                match method {
                    $(Method::$kind => &self.$field,)+
                }
            }

            /// The same, to be chosen.
            pub fn choices_mut(&mut self, method: Method) -> &mut dyn Choices {
                match method {
                    $(Method::$kind => &mut self.$field,)+
                }
            }
        }
    };
}

for_each_method!(define);

impl Params {
    /// Of which method the choice `field` is, as in `direct.history`, and its place in that method's table.
    #[must_use]
    pub fn find(&self, field: &str) -> Option<(Method, usize)> {
        Method::ALL.iter().find_map(|&method| {
            let mut table = self.choices(method).table().iter();
            let index = table.position(|choice| choice.field == field)?;
            Some((method, index))
        })
    }

    /// Checks every choice, those of other methods included.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self) -> Result<(), PlanError> {
        for &method in Method::ALL {
            self.choices(method).check()?;
        }
        // Else nothing would bound what the Gaussian does not see.
        positive("guide.smoothness", self.guide.smoothness + self.guide.kinetic)?;
        count("iterations", self.iterations, MAX_ITERATIONS)?;
        count("threads", self.threads, MAX_THREADS)
    }
}
