//! L-BFGS over trajectories of faces (Nocedal & Wright, Numerical Optimization, 2nd ed., algorithm 7.4), its fields by number.
//!
//! With the first inverse Hessian P, what is kept of a pair is s and z = P y, so no gradient is kept at all but P g; the two loops
//! need inner products alone. Fields change their parts instead of their numbers: the direction that was taken becomes s of the
//! newest pair, P g before becomes z, and the oldest pair's fields are free for what a trial needs. m pairs ask for 2 m + 2 fields.
//! In halves s and z take the place of the gradient where they end, both in one field, and m pairs ask for m + 3.
//!
//! [`history`] says how much is remembered and where. [`recursion`] has all that follows from inner products: which field plays which part,
//! and how much of each field makes the direction. [`fields`] has the fields, and [`passes`] one pass over them that forms the direction,
//! and one that takes the inner products.

pub mod fields;
pub mod history;
pub mod passes;
pub mod recursion;
