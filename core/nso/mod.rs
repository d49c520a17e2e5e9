//! NSO, the Navier-Stokes problem of the paper (section 4.2, eq. 13), by the spacetime full-approximation multigrid (STFAS).
//!
//! For targets t_k: the smallest kappa |v_k - t_k|^2 + |w_k|^2 over flows v driven by forces w.

mod closing;
mod collect;
pub mod colours;
pub mod damping;
pub mod info;
pub mod level;
pub mod local;
pub mod multigrid;
pub mod newton;
pub mod params;
mod pass;
mod pending;
mod reduced;
pub mod residual;
pub mod smoother;
pub mod solve;
pub mod surroundings;
pub mod transfer;
pub mod vcycle;
mod window;
pub mod workspace;

pub use info::{Ended, Info, MAX_CYCLES, NSO};
pub use multigrid::{Finest, Nso};
pub use params::{Norm, NsoParams, NsoSolver, Setup, SmootherMemory, Split};
pub use workspace::{Bases, Workspace};
