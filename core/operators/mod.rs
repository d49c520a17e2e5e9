//! Operators on the MAC grid with their exact adjoints, written once for all axes.

pub mod blur;
pub mod curl;
pub mod divergence;
pub mod drag;
pub mod exits;
pub mod plaquette;
pub mod refine;
pub mod self_advection;
pub mod sticking;
