//! Coordinate condensation: pieces against differences and solves, runs against the counts of a second program.

mod bench;
#[allow(dead_code, reason = "tests of the program use all of it")]
#[path = "../../program/support/npz.rs"]
mod npz;
mod pieces;
mod reference;
mod refusals;
mod runs;
