//! One cell in all slots at once: the time-line SCGS step (mathematics section 5, paper section 4.2).
//!
//! The unknowns are the changes of the cell's 2d faces and two pressures in every slot. With g = outward sign
//! / h of each free face (0 on a wall), B an orthonormal basis of the vectors orthogonal to g, J the local
//! Jacobian of Adv + nu C^T C:
//!
//! ```text
//! H = 1 - u u^T, H g || e_p          B = H without column p       M_k = B^T (1 + J_k) B
//! dv_k = g rb_k/|g|^2 + B y_k        dw_k = g rd_k/|g|^2 + B q_k
//! q_k = M_k y_k - y_{k-1} - c_k
//! [kappa + 1 (not in slot T) + M_k^T M_k + omega B^T O_k B] y_k - M_k^T y_{k-1} - M_{k+1} y_{k+1}
//!     = a_k + M_k^T c_k - c_{k+1}
//! ```
//!
//! a symmetric positive definite block-tridiagonal system, solved by a block L D L^T factorisation with one
//! cell in each SIMD lane. O_k is the outside-face term: the force that the cell's own change stirs up on
//! faces that are not its own. With a mass that is not 1 the block is divided by it: J, a and c are times
//! 1 / mass, and the pressures times the mass (see `surroundings`(super::surroundings)). H is a Householder
//! reflection, so B^T X B is X after two changes of rank 1.
//!
//! The cells of a `row` are solved in groups, a vector of cells each. In every slot `gather` reads what
//! the equations of a group need (the `stencil` says which faces and cells, `streams` how they lie in
//! memory), `assemble` makes its block of the system, `factor` eliminates the block before; on the way
//! back `changes` writes the solution. Where the flow is slow, a damping takes the place of J and O (see
//! `damping`(super::damping)).

mod assemble;
mod changes;
mod edge;
mod factor;
mod form;
mod gather;
mod group;
mod jacobian;
mod lanes;
mod line;
mod reflection;
mod residuals;
mod row;
mod stencil;
mod storage;
mod streams;

pub use reflection::{fill_table, table_len};
pub use row::{scratch_len, solve_row};
pub use storage::{Changes, changes};
