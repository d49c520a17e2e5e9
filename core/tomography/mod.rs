//! Stochastic tomography: the density of smoke from what several cameras see of it (Gregson 2015, chapter 3).
//!
//! ```text
//! minimise    E(p) = 1/2 |q - F p|^2 + gamma Gamma(p)
//! ```
//!
//! with q the pixels of all cameras, each the integral of the density along its ray in cells, F the projection of a density onto them,
//! and Gamma a prior. p is a sum of samples that a random walk ([`walk`](crate::walk)) places one by one. Places that some camera sees
//! dark, the outside of the visual hull, hold none.
//!
//! | file | what it holds |
//! |---|---|
//! | `camera` | orthographic and pinhole cameras in a plane and in a box |
//! | `pixels` | the pixels that a place touches, with their weights; F of a density |
//! | `terrain` | what the walk walks on: gains, records, the hull |
//! | `gallery` | the same with novel views, and priors on them |
//! | `problem` | what is asked for, and what is refused |
//! | `reconstruction` | a frame: its memory, its energy |
//! | `way` | a frame from its begin to its end |
//! | `rays` | integrals along rays |
//! | `sart` | SART, the baseline |

mod camera;
mod error;
mod gallery;
mod pixels;
mod problem;
mod rays;
mod reconstruction;
mod sart;
mod terrain;
mod way;

pub use camera::{Camera, Lens, Seen};
pub use error::{Fault, TomographyError};
pub use pixels::project;
pub use problem::{Method, Settings, Tomography};
pub use rays::{integral, photograph};
pub use reconstruction::{Energy, Reconstruction};
