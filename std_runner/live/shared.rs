//! What the solve and the threads that answer have in common.

use super::state::State;
use crate::interrupt::Interrupt;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What the solve shares with the threads that answer.
pub(super) struct Shared {
    pub state: Mutex<State>,
    pub interrupt: Interrupt,
    pub token: String,
    pub port: u16,
}

impl Shared {
    /// The state; a thread that panicked while it held it left it whole, since nothing in it is changed in two steps.
    pub fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
