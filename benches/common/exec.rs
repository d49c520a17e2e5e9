//! Two threads for benches whose harness may not leave the main thread: that thread is one of the two.

use std::sync::OnceLock;
use thurible::threads::relax;
use thurible_core::exec::{Seat, Team};

/// Threads that the benches use: the two of the smallest machine we care for.
pub const THREADS: usize = 2;

/// The calling thread and others that serve until the program ends.
pub fn team() -> &'static Team<'static> {
    static SEATS: OnceLock<[Seat; THREADS - 1]> = OnceLock::new();
    static TEAM: OnceLock<Team<'_>> = OnceLock::new();
    let team = TEAM.get_or_init(|| Team::new(SEATS.get_or_init(Default::default), relax));
    static SERVERS: OnceLock<()> = OnceLock::new();
    SERVERS.get_or_init(|| (1..THREADS).for_each(|_| drop(std::thread::spawn(|| team.serve()))));
    team
}
