//! One pair of frames: the flow that carries the first density to the second, as optical flow without divergence.
//!
//! Given phi_1 and phi_2 at cells (mathematics section 10), the correction w of an estimate Din minimises (Gregson, Ihrke, Thuerey & Heidrich 2014)
//!
//! ```text
//! f(w) = 1/2 |phi_t + F w|^2 + alpha/2 <Din + w, L (Din + w)> + beta/2 |Din + w|^2      over div w = 0
//! ```
//!
//! with phi_t = phi_2* - phi_1, phi_2* being phi_2 pulled back by Din, F w what the flow w changes of the mean frame, and L the Laplacian of
//! each component, all in cells and frames: h = dt = 1. Large motions are found on coarser grids first.
//!
//! | file | what it holds |
//! |---|---|
//! | `params` | what is chosen |
//! | `data` | F, its adjoint, and the operator of the normal equation |
//! | `conjugate` | conjugate gradients on faces |
//! | `minimise` | the four ways to w: direct, ADMM, Horn-Schunck with and without a penalty |
//! | `warp` | a density pulled back by a flow |
//! | `resample` | fields between grids of any ratio |
//! | `level` | one grid of the pyramid: estimate, warp, w |
//! | `pyramid` | the grids and their frames |
//! | `turbulence` | what is too fine for a flow's grid, made up on a finer one |
//! | `yielding` | a flow among solid cells whose change is small where it matters, and smooth |

mod conjugate;
pub mod data;
pub mod level;
mod minimise;
pub mod params;
pub mod pyramid;
pub mod resample;
pub mod sample;
pub mod turbulence;
pub mod warp;
pub mod yielding;

pub use params::{FlowParams, Minimiser, Warping};
pub use pyramid::MAX_LEVELS;
