//! Ctrl-C: the first one asks the solve to stop, the second one ends the program at once. No thread listens.

use crate::exit::{Failure, INTERRUPTED};
use core::ffi::c_int;
use core::sync::atomic::{AtomicBool, Ordering};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::{Arc, Mutex, PoisonError};

#[cfg(unix)]
const SIGNALS: [c_int; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [c_int; 2] = [SIGINT, SIGTERM];

/// The last one that listened, and how often its flag is held when nobody else holds it: here, and twice for each signal that is heard.
static LAST: Mutex<Option<(Interrupt, usize)>> = Mutex::new(None);

/// Set once the user has asked to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    asked: Arc<AtomicBool>,
}

impl Interrupt {
    /// Listens for Ctrl-C (and SIGTERM, SIGHUP where there are such). Who listens again when nobody was asked takes the ears of the one
    /// before: a process that solves often would have ever more of them, and each signal calls all.
    pub fn listen() -> Result<Self, Failure> {
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((last, unused)) = last.as_ref()
            && !last.asked()
            && Arc::strong_count(&last.asked) == *unused
        {
            return Ok(last.clone());
        }
        let interrupt = Interrupt::default();
        let flag = || Arc::clone(&interrupt.asked);
        for signal in SIGNALS.into_iter().filter(|&signal| !is_ignored(signal)) {
            // The order matters: the first signal finds the flag down and raises it, the second one finds it up.
            let listening = flag::register_conditional_shutdown(signal, INTERRUPTED.into(), flag())
                .and_then(|_| flag::register(signal, flag()));
            listening.map_err(|error| {
                Failure::Input(format!(
                    "cannot listen for Ctrl-C: {error}; start the program from another shell"
                ))
            })?;
        }
        let unused = Arc::strong_count(&interrupt.asked);
        *last = Some((interrupt.clone(), unused));
        Ok(interrupt)
    }

    /// Asks the solve to stop, as Ctrl-C does.
    pub fn ask(&self) {
        self.asked.store(true, Ordering::Relaxed);
    }

    /// Whether the user has asked to stop.
    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}

/// Has a file that grows beyond what `ulimit -f` allows fail as a file on a full disc does, where the system would end the program.
pub(crate) fn let_long_files_fail() {
    #[cfg(unix)]
    {
        // Where nobody can listen the program is ended, as others are.
        let _ = flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    }
}

/// Whether whoever started the program had it ignore that its terminal goes away, as `nohup` does. Linux tells; elsewhere the signal is heard.
#[cfg(unix)]
fn is_ignored(signal: c_int) -> bool {
    if signal != signal_hook::consts::SIGHUP {
        return false;
    }
    let told = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = told.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn is_ignored(_: c_int) -> bool {
    false
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn who_listens_again_takes_the_ears_of_the_one_before() {
        let first = Interrupt::listen().unwrap();
        let beside = Interrupt::listen().unwrap();
        assert!(!Arc::ptr_eq(&first.asked, &beside.asked), "two at once are two");
        let ears = Arc::as_ptr(&beside.asked);
        drop(first);
        drop(beside);
        let again = Interrupt::listen().unwrap();
        assert_eq!(Arc::as_ptr(&again.asked), ears);
        again.ask();
        drop(again);
        let fresh = Interrupt::listen().unwrap();
        assert!(!fresh.asked());
    }
}
