//! What the name of a file ends with.

use std::path::Path;

/// Whether the name of `path` ends so, in capitals or not.
pub(crate) fn ends_with(path: &Path, ending: &str) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(ending))
}
