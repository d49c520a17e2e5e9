//! What is asked of a restoration.

use super::light::Light;
use crate::problem::Precision;
use crate::progress::Mode;
use std::path::PathBuf;
use thurible_core::deblur::Tuning;

/// What is asked for.
pub(crate) struct Request {
    pub image: PathBuf,
    pub psf: String,
    pub light: Option<Light>,
    pub truth: Option<PathBuf>,
    pub folder: PathBuf,
    pub tuning: Tuning,
    pub precision: Precision,
    pub limit: Option<usize>,
    /// Whether the plan is all that is wanted.
    pub plan: bool,
    pub mode: Mode,
}
