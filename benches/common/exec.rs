//! Two threads for benches whose harness may not leave the main thread: that thread is one of the two.

use std::sync::OnceLock;
use thurible::threads::relax;
use thurible_core::exec::Team;

/// Threads that the benches use: the two of the smallest machine we care for.
pub const THREADS: usize = 2;

/// The calling thread and others that serve until the program ends.
pub fn team() -> &'static Team {
    static TEAM: OnceLock<Team> = OnceLock::new();
    let team = TEAM.get_or_init(|| Team::new(THREADS, relax));
    static SERVERS: OnceLock<()> = OnceLock::new();
    SERVERS.get_or_init(|| (1..THREADS).for_each(|_| drop(std::thread::spawn(|| team.serve()))));
    team
}
