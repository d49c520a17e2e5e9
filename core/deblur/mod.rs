//! Stochastic deconvolution: a sharp image from a blurred one and its kernel (Gregson 2015, chapter 4).
//!
//! ```text
//! minimise    E(p) = 1/2 |M (q - f * p)|^2 + gamma Gamma(p)
//! ```
//!
//! with q the image, f its kernel, and M a mask that leaves out saturated pixels. The walk of [`walk`](crate::walk) changes one pixel at a
//! time by +eps or -eps; f may differ from pixel to pixel, and Gamma may be anything whose terms read few pixels.
//!
//! p has a border of R pixels about the image, from which light comes into it; images are planes of one channel each, row by row.
//!
//! | file | what it holds |
//! |---|---|
//! | `kernel` | the kernels, and which one a pixel has |
//! | `plane` | an image with its border |
//! | `prior` | priors on images, and how exactly a pixel changes them |
//! | `patch` | rectangles of pixels that change at once |
//! | `terrain` | what the walk walks on |
//! | `restoration` | its memory, its objective |
//! | `way` | chains of the walk, iterations of a baseline |
//! | `colours` | the colours that pixels gather at |
//! | `baselines` | Richardson-Lucy, Wiener, Chambolle-Pock |

mod baselines;
mod colours;
mod error;
mod kernel;
mod patch;
mod plane;
mod prior;
mod restoration;
mod settings;
mod terrain;
mod way;

pub use error::DeblurError;
pub use kernel::{Blur, Kernels};
pub use patch::{Patch, change_patch};
pub use plane::Frame;
pub use prior::{Clusters, ImagePrior, MOST_COLOURS, change, whole};
pub use restoration::Restoration;
pub use settings::{Deblur, Moves, Restorer, Tuning};
