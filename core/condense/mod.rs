//! Coordinate condensation: the energy of an elastic body, minimised block by block, each with the response of all others (Trusty 2025, and JGS2,
//! Lan et al. 2025).
//!
//! ```text
//! dx_i = -(H_ii - S_i)^-1 g~_i,   S_i = H_iC U_i H~_i^-1 U_i^T H_Ci,   g~_i = g_i - H_iC U_i H~_i^-1 U_i^T g_C,   H~_i = U_i^T H_CC U_i
//! U_i = -H0_CC^-1 H0_Ci
//! ```
//!
//! Block descent is parallel and cheap a pass, but creeps where coupling is stiff. A basis U_i, built once from a Hessian H0, says how the rest
//! follows a move of block i; that the rest may follow more or less (alpha_i, eliminated) leaves a Schur complement.
//!
//! | file | what it holds |
//! |---|---|
//! | `small` | eigenvectors, inverses, rotations of small matrices |
//! | `material`, `element`, `mesh`, `shapes` | a simplex and its energy; vertices, simplices and springs; rods, rectangles and boxes |
//! | `words`, `ordering`, `colouring`, `patches`, `topology` | who is joined to whom, in which order unknowns stand |
//! | `settings`, `error` | what is chosen, and what is refused |
//! | `body`, `hessian` | energy, gradient and Hessian of a state |
//! | `band`, `basis`, `block` | Cholesky's factor, the basis, the move of a block |
//! | `layout`, `plan` | the buffers, and how many bytes they take |
//! | `condenser`, `passes`, `stepping`, `inspect` | the run: its state, the pieces of an iteration, steps, what can be seen |

mod band;
mod basis;
mod block;
mod body;
mod colouring;
mod condenser;
mod element;
mod error;
mod hessian;
mod inspect;
mod layout;
mod material;
mod mesh;
mod ordering;
mod passes;
mod patches;
mod plan;
mod settings;
mod shapes;
mod small;
mod stepping;
mod topology;
mod words;

pub use condenser::Condenser;
pub use error::CondenseError;
pub use material::Material;
pub use mesh::{Mesh, Spring};
pub use plan::CondensePlan;
pub use settings::{Basis, Block, CondenseParams, Order, Update};
pub use shapes::Regular;
pub use stepping::{BUILD, DIRECTION, Iteration, SEARCH, Step, Stepped};
pub use topology::Topology;
