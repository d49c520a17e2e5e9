//! The threads of a measurement.

use thurible::exit::Failure;
use thurible::{address_space, threads};
use thurible_core::Exec;

/// Calls `work` with `count` threads.
pub(crate) fn with_threads<R: Send>(
    count: usize,
    work: impl FnOnce(&dyn Exec) -> Result<R, Failure> + Send,
) -> Result<R, Failure> {
    address_space::check(count)?;
    threads::with(count, || threads::together(count, work))?
}
