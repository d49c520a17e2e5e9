//! The processor's time, which does not go on while others have it.
#![allow(unsafe_code, reason = "a call of the system")]

use core::time::Duration;

/// What this process has taken of it.
#[cfg(unix)]
pub fn time() -> Duration {
    let mut now = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: it writes one number of each kind into what is borrowed for it.
    let failed = unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut now) };
    assert_eq!(failed, 0, "the processor's time cannot be told");
    Duration::new(now.tv_sec as u64, now.tv_nsec as u32)
}

/// Where the system is not asked, that of a clock.
#[cfg(not(unix))]
pub fn time() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}
