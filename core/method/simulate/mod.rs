//! The baselines (mathematics section 7): the flow simulated forwards, step by step, where the other methods never do.
//!
//! [`step`] solves one implicit step of equations (1) and (2) and its adjoint; [`forward`] marches with it, free, driven
//! towards the next keyframe (Fattal & Lischinski 2004), or guided by a given flow ([`guide`]) that noise can stir ([`stir`]). Adjoint control searches for forces by the adjoint of the whole
//! march.

pub mod drive;
pub mod forward;
pub mod guide;
pub mod krylov;
mod march;
pub mod params;
mod setup;
pub mod step;
pub mod stir;

pub use forward::Simulation;

use crate::observe::Phase;

/// Steps of the flow that are simulated one after the other; after step k the velocities up to v_k are known, and so are the densities up to k + 1.
pub const MARCH: Phase = Phase {
    name: "march",
    words: "simulated step",
    measure: "of",
};
