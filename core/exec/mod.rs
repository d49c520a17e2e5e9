//! Threads as a value: the caller passes an [`Exec`], and the core cuts its loops into tasks that write disjoint chunks.
//!
//! | file | what it holds |
//! |---|---|
//! | `rows` | loops over the rows of fields: [`for_rows`], [`for_runs`], [`for_rows_across`]; rows of different lengths: [`for_uneven`] |
//! | `slabs` | loops over slabs of rows that stay with a worker, and two different tasks at once: [`for_slabs`], [`join`] |
//! | `panels` | loops over panels of columns: [`for_panels`] |
//! | `schedule` | which worker takes which rows, and when |
//! | `waves` | every other chunk of a field at once, of which each reads those beside it: [`for_every_other`] |
//! | `chunks` | a slice that tasks take apart |
//! | `capped` | fewer threads than there are: [`Capped`] |
//! | `pool` | threads that stay awake: [`WorkerPool`] |
//! | `ranks` | programs that share one solve: [`Ranks`] |
//! | `device` | a machine with a memory of its own: [`Device`] |
//! | `together` | threads with ranks or a device beside them: [`Together`] |
#![allow(unsafe_code)]

mod capped;
mod chunks;
pub mod device;
mod panels;
// Machines without 64-bit atomics hardly have threads to lend.
#[cfg(target_has_atomic = "64")]
mod pool;
pub mod ranks;
mod rows;
mod schedule;
mod slabs;
mod together;
mod waves;

pub use capped::Capped;
pub use device::Device;
pub use panels::{Panel, for_panels};
#[cfg(target_has_atomic = "64")]
pub use pool::{Worker, WorkerPool};
pub use ranks::{Alone, Ranks};
pub use rows::{Planes, RowBuffers, RowTask, RunTask, for_rows, for_rows_across, for_runs, for_uneven};
pub use slabs::{Slabs, for_slabs, join};
pub use together::Together;
pub use waves::for_every_other;

/// Runs independent tasks, in any order and on any threads.
///
/// The core's results do not depend on the number of threads or on the order of the tasks.
pub trait Exec: Sync {
    /// How many tasks may run at the same time; thread-local scratch is planned for this many.
    fn threads(&self) -> usize;
    /// Calls `task(i)` once for every `i < tasks` and returns when all are done.
    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync));
    /// The programs that share the solve; by default there is no other.
    fn ranks(&self) -> &dyn Ranks {
        &Alone
    }
    /// The device on which a search by the direct method goes; by default there is none.
    fn device(&self) -> Option<&dyn Device> {
        None
    }
}

/// Runs every task on the calling thread, in order.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Exec for Serial {
    fn threads(&self) -> usize {
        1
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..tasks).for_each(task);
    }
}

/// A value that shares its cache lines with no other, so that threads which write different ones do not wait for each other.
///
/// Two lines of 64 bytes, since processors fetch them in pairs.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Padded<T>(T);
