//! Thurible in Python: `thurible_smoke.solve` and `thurible_smoke.plan` on NumPy's arrays.
//!
//! The arguments ([`choices`], [`effects`], [`inputs`], whose [`arrays`] are NumPy's, in [`words`] of Python's) become a [`mod@plan`]; [`mod@solve`] runs in a [`block`] on threads of its
//! own ([`watch`]), its state kept by [`mod@keep`]; what it finds is a [`solution`], whose arrays lie at certain [`place`]s of that block. [`mod@track`], [`mod@tomography`], [`mod@operator`] (whose simulator is [`mod@simulating`]) [`mod@steering`] and [`mod@condensing`] are ways of their own. The package
//! `thurible_smoke` has it all under its own name, and what `jax` and `torch` take the operator by.

pub mod arrays;
pub mod block;
mod cameras;
pub mod choices;
pub mod condensed;
pub mod condensing;
pub mod covectors;
pub mod effects;
pub mod inputs;
pub mod iterated;
pub mod iteration;
mod keep;
mod looked;
pub mod operating;
pub mod operator;
pub mod place;
pub mod plan;
mod reconstruct;
pub mod reconstructed;
pub mod simulating;
pub mod solution;
pub mod solve;
pub mod steered;
pub mod steering;
mod templates;
pub mod tomography;
pub mod track;
pub mod tracked;
pub mod tracking;
pub mod watch;
pub mod words;
pub mod worked;

use pyo3::prelude::*;

/// Steers smoke: finds the smallest force field that makes an incompressible flow of smoke pass through keyframes.
#[pymodule]
mod _thurible {
    #[pymodule_export]
    use crate::condensing::PyCondenser;
    #[pymodule_export]
    use crate::iteration::Iteration;
    #[pymodule_export]
    use crate::operator::PyOperator;
    #[pymodule_export]
    use crate::plan::{Plan, plan};
    #[pymodule_export]
    use crate::reconstructed::Tomography;
    #[pymodule_export]
    use crate::solution::{Given, Solution};
    #[pymodule_export]
    use crate::solve::solve;
    #[pymodule_export]
    use crate::steered::Found;
    #[pymodule_export]
    use crate::steering::stable_fluids;
    #[pymodule_export]
    use crate::tomography::tomography;
    #[pymodule_export]
    use crate::track::track;
    #[pymodule_export]
    use crate::tracked::Track;
    #[pymodule_export]
    use crate::worked::Gradient;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
