//! Ctrl-C: the first one asks the solve to stop, the second one ends the program at once.

use crate::console;
use crate::exit::{Failure, INTERRUPTED};
use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

/// Set once the user has asked to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    asked: Arc<AtomicBool>,
}

impl Interrupt {
    /// Listens for Ctrl-C (and SIGTERM, SIGHUP where there are such).
    pub fn listen(quiet: bool) -> Result<Self, Failure> {
        let interrupt = Interrupt::default();
        let asked = Arc::clone(&interrupt.asked);
        let handler = move || {
            if asked.swap(true, Ordering::Relaxed) {
                std::process::exit(INTERRUPTED.into());
            }
            if !quiet {
                console::error("thurible: stopping, the result so far will be written; press Ctrl-C again to end at once without it");
            }
        };
        ctrlc::set_handler(handler).map_err(|error| Failure::Input(format!("cannot listen for Ctrl-C: {error}; start the program from another shell")))?;
        Ok(interrupt)
    }

    /// Whether the user has asked to stop.
    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}
