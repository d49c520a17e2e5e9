//! What is asked of a reconstruction.

use crate::commands::options::Options;
use std::path::{Path, PathBuf};

/// What is asked for.
pub(crate) struct Request<'a> {
    /// The file of views, or its folder.
    pub views: &'a Path,
    /// Where the result goes.
    pub folder: PathBuf,
    /// Whether the plan is all that is wanted.
    pub plan: bool,
    /// The common options.
    pub options: &'a Options,
}
