//! What commands take that take a known flow further.

use crate::flows::{Deed, Request};
use crate::problem::Precision;
use crate::progress::Mode;
use crate::{bytes, threads};
use clap::Args;
use std::path::{Path, PathBuf};

/// Options of `readvect` and `remap`.
#[derive(Args, Debug)]
pub struct Takes {
    /// Threads [default: as many as the machine offers].
    #[arg(long, value_name = "N", value_parser = threads::parse)]
    pub threads: Option<usize>,
    /// Precision of all fields [default: that of the result].
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
    /// Ceiling for the one block of memory, as in 1GiB [default: the machine's memory].
    #[arg(long, value_name = "SIZE", value_parser = bytes::parse)]
    pub memory_limit: Option<usize>,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

impl Takes {
    /// A request that reads `from` and writes `folder`, or beside `from` a folder of the same name with `end` at its end.
    pub(super) fn request(&self, from: &Path, folder: Option<&Path>, end: &str) -> Request {
        let beside = || {
            let name = from.file_name().unwrap_or_default().to_string_lossy();
            from.with_file_name(format!("{name}{end}"))
        };
        Request {
            deed: Deed::Readvect { scale: 1 },
            from: from.to_owned(),
            folder: folder.map_or_else(beside, PathBuf::from),
            at: 0,
            precision: self.precision,
            threads: self.threads.unwrap_or_else(threads::available),
            limit: self.memory_limit,
            mode: match (self.quiet, self.json) {
                (true, _) => Mode::Quiet,
                (_, true) => Mode::Json,
                _ => Mode::Human,
            },
        }
    }
}
