//! Ctrl-C: the first one asks the solve to stop, the second one ends the program at once. No thread listens.

use crate::exit::{Failure, INTERRUPTED};
use core::ffi::c_int;
use core::sync::atomic::{AtomicBool, Ordering};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;

#[cfg(unix)]
const SIGNALS: [c_int; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [c_int; 2] = [SIGINT, SIGTERM];

/// Set once the user has asked to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    asked: Arc<AtomicBool>,
}

impl Interrupt {
    /// Listens for Ctrl-C (and SIGTERM, SIGHUP where there are such).
    pub fn listen() -> Result<Self, Failure> {
        let interrupt = Interrupt::default();
        let flag = || Arc::clone(&interrupt.asked);
        for signal in SIGNALS {
            // The order matters: the first signal finds the flag down and raises it, the second one finds it up.
            let listening = flag::register_conditional_shutdown(signal, INTERRUPTED.into(), flag())
                .and_then(|_| flag::register(signal, flag()));
            listening.map_err(|error| {
                Failure::Input(format!(
                    "cannot listen for Ctrl-C: {error}; start the program from another shell"
                ))
            })?;
        }
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
