//! A random walk that puts small samples where they lower an objective: what tomography and deconvolution share.
//!
//! The unknown is a sum of samples, each of mass +eps or -eps at a place. A chain walks over places; a proposed place is worth the
//! gain dE by which a sample there would lower
//!
//! ```text
//! E = 1/2 |q - F p|^2 + gamma Gamma(p)
//! ```
//!
//! and samples of positive gain are kept (Gregson 2015, Algorithms 2 and 4). No gradient, no matrix: only the few numbers that a
//! sample touches are read and written, and a prior costs what its own terms cost.
//!
//! | file | what it holds |
//! |---|---|
//! | `random` | a stream of random numbers for each chain, the same on every machine |
//! | `chain` | the chain over places: proposals, acceptance, a budget of mutations |
//! | `cells` | samples on a grid: d-linear weights, the cells around them |
//! | `prior` | priors on cells, and how exactly a sample changes them |

mod cells;
mod chain;
pub mod prior;
mod random;

pub use cells::{Cells, Footprint};
pub use chain::{Chain, Course, Gain, Rule, Terrain, Walked};
pub use prior::Prior;
pub use random::Random;
