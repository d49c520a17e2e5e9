//! Coordinate condensation: pieces against differences and solves, runs against the counts of a second program.

mod bench;
mod pieces;
mod reference;
mod refusals;
mod runs;
