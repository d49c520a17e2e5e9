//! The baselines (mathematics section 7): the flow simulated forwards, step by step, where the other methods never do.
//!
//! [`step`] solves one implicit step of equations (1) and (2) and its adjoint; [`forward`] marches with it, free or driven
//! towards the next keyframe (Fattal & Lischinski 2004); [`lbfgs`] searches for the forces by the adjoint of the whole march
//! (Treuille et al. 2003, McNamara et al. 2004).

pub mod drive;
pub mod forward;
pub mod krylov;
pub mod step;
