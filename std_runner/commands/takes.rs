//! What is asked of commands that take a known flow further.

use super::options::{Resources, longer};
use crate::flows::{Deed, Request};
use crate::threads;
use std::path::{Path, PathBuf};

/// A request for `deed` from step `at` of the result `from` on. It writes `folder`, or beside `from` a folder of the same name with `end` at its end.
pub(super) fn request(
    resources: &Resources,
    (from, at): (&Path, usize),
    (folder, end): (Option<&Path>, &str),
    deed: Deed,
) -> Request {
    Request {
        deed,
        at,
        from: from.to_owned(),
        folder: folder.map_or_else(|| longer(from, end), PathBuf::from),
        precision: resources.precision,
        threads: resources.threads.unwrap_or_else(threads::available),
        limit: resources.memory_limit,
        mode: resources.mode(),
    }
}

/// Reads a number that is at least 0; the error says what is allowed.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok();
    number
        .filter(|number: &f64| (0.0..=1e6).contains(number))
        .ok_or_else(|| format!("found \"{text}\", allowed is a number from 0 to 1e6"))
}
