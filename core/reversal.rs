//! In which order the steps of a simulation are taken back where only a few of its states are kept: binomial checkpointing
//! (A. Griewank, A. Walther, *Algorithm 799: Revolve*, 2000).
//!
//! An adjoint needs the states of a simulation from the last to the first. With `s` states kept, that at the start counted, `l` steps are
//! reversed by repeating
//!
//! ```text
//! t l - beta(s + 1, t - 1)      steps,  beta(s, t) = C(s + t, s),  t the least with beta(s, t) >= l
//! ```
//!
//! beside the `l` that are run once more to be reversed. No order takes fewer. Which states are kept does not touch the numbers: every
//! state is computed by the same operations.

use crate::exec::Exec;

/// Ways to choose: beta(slots, times) = C(slots + times, slots), the most steps that so many slots reverse with each step repeated at most
/// `times` times. What exceeds `usize` is `usize::MAX`.
fn beta(slots: usize, times: usize) -> usize {
    let (few, many) = (slots.min(times), slots.max(times));
    let mut ways = 1_u128;
    for chosen in 1..=few {
        // C(many + chosen, chosen) grows with `chosen`: once beyond, always beyond.
        ways = ways * (many + chosen) as u128 / chosen as u128;
        if ways > usize::MAX as u128 {
            return usize::MAX;
        }
    }
    ways as usize
}

/// The least number of repetitions with which `slots` states suffice for `steps` steps.
fn repetitions(steps: usize, slots: usize) -> usize {
    let mut times = 0;
    while beta(slots, times) < steps {
        times += 1;
    }
    times
}

/// Steps that are repeated to reverse `steps` steps with `slots` kept states, that at the start counted, beside the steps that are run
/// once more to be reversed. `slots` of 0 counts as 1.
#[must_use]
pub fn repeated_steps(steps: usize, slots: usize) -> usize {
    let slots = slots.max(1);
    match repetitions(steps, slots) {
        0 => 0,
        times => times
            .saturating_mul(steps)
            .saturating_sub(beta(slots + 1, times - 1)),
    }
}

/// How many of `steps` steps to advance before the next state is kept, with `slots` states to come, that at the start counted.
fn advance(steps: usize, slots: usize) -> usize {
    let times = repetitions(steps, slots);
    (steps - 1)
        .min(beta(slots, times - 1))
        .min(steps - beta(slots - 1, times - 1).min(steps - 1))
}

/// What to do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Move {
    /// Run the steps `from` up to `to`: the state at `from` is at hand, that at `to` is afterwards.
    Advance {
        /// The step of the state at hand.
        from: usize,
        /// The step of the state afterwards.
        to: usize,
    },
    /// Keep the state at hand in a slot.
    Store {
        /// The slot, from 0.
        slot: usize,
    },
    /// Fetch the state of a slot.
    Restore {
        /// The slot.
        slot: usize,
        /// The step of its state.
        step: usize,
    },
    /// Run a step from the state at hand with all that its adjoint needs, and take it back.
    Reverse {
        /// The step.
        step: usize,
    },
}

/// The moves that reverse a number of steps.
#[derive(Debug)]
pub struct Reversal<'m> {
    /// The steps of the kept states, that of slot 0 first.
    kept: &'m mut [usize],
    /// How many slots hold a state.
    used: usize,
    /// Steps that are still to be reversed.
    left: usize,
    /// The step of the state at hand, or none.
    at: Option<usize>,
}

impl<'m> Reversal<'m> {
    /// Reverses `steps` steps with a state for each element of `kept`. The state at the start is at hand, and in slot 0 already if
    /// `stored`; otherwise the first move stores it.
    ///
    /// Without an element there is no slot, and no move.
    #[must_use]
    pub fn new(steps: usize, kept: &'m mut [usize], stored: bool) -> Self {
        let used = usize::from(stored && !kept.is_empty());
        if let Some(first) = kept.first_mut() {
            *first = 0;
        }
        Self {
            left: if kept.is_empty() { 0 } else { steps },
            kept,
            used,
            at: Some(0),
        }
    }

    /// Begins anew, with as many slots: the state at the start is at hand, and in slot 0 if `stored`.
    pub fn restart(&mut self, steps: usize, stored: bool) {
        let kept = core::mem::take(&mut self.kept);
        *self = Self::new(steps, kept, stored);
    }

    fn store(&mut self, step: usize) -> Option<Move> {
        let slot = self.used;
        *self.kept.get_mut(slot)? = step;
        self.used += 1;
        Some(Move::Store { slot })
    }
}

impl Iterator for Reversal<'_> {
    type Item = Move;

    fn next(&mut self) -> Option<Move> {
        if self.left == 0 {
            return None;
        }
        if self.used == 0 {
            return self.store(0);
        }
        let slot = self.used - 1;
        let stored = *self.kept.get(slot)?;
        let Some(at) = self.at else {
            self.at = Some(stored);
            return Some(Move::Restore { slot, step: stored });
        };
        let slots = self.kept.len() - slot;
        let steps = self.left - stored;
        let to = if slots == 1 {
            self.left - 1
        } else {
            stored + if steps > 1 { advance(steps, slots) } else { 0 }
        };
        if at < to {
            self.at = Some(to);
            return Some(Move::Advance { from: at, to });
        }
        if at > stored && slots > 1 {
            return self.store(at);
        }
        // The state at hand is that of the last step.
        self.left = at;
        self.at = None;
        if at == stored {
            self.used -= 1;
        }
        Some(Move::Reverse { step: at })
    }
}

/// A simulation whose steps can be taken back, with its state at hand inside.
pub trait Reversible<T> {
    /// Why a step cannot be run.
    type Error;

    /// Runs step `step` from the state at hand, which becomes that at `step + 1`.
    ///
    /// # Errors
    /// Its own; nothing is run after one.
    fn advance(&mut self, exec: &dyn Exec, step: usize) -> Result<(), Self::Error>;

    /// Runs step `step` from the state at hand and takes it back: its adjoint of the state at `step + 1` becomes that at `step`.
    ///
    /// # Errors
    /// Its own; nothing is run after one.
    fn reverse(&mut self, exec: &dyn Exec, step: usize) -> Result<(), Self::Error>;

    /// Copies the state at hand to `slot`.
    fn store(&self, slot: &mut [T]);

    /// Makes the state in `slot` that at hand.
    fn restore(&mut self, slot: &[T]);
}

/// Takes back all `steps` steps, the last first, from the state at step 0 at hand, with a state in each of the equal parts that `slots` is
/// cut into, as many as `kept` has elements. How many steps were repeated: [`repeated_steps`].
///
/// # Errors
/// Those of the simulation.
pub fn reverse_all<T, R: Reversible<T>>(
    simulation: &mut R,
    exec: &dyn Exec,
    steps: usize,
    slots: &mut [T],
    kept: &mut [usize],
) -> Result<usize, R::Error> {
    let len = slots.len() / kept.len().max(1);
    let mut repeated = 0;
    for next in Reversal::new(steps, kept, false) {
        match next {
            Move::Advance { from, to } => {
                for step in from..to {
                    simulation.advance(exec, step)?;
                    repeated += 1;
                }
            }
            Move::Store { slot } => {
                if let Some(slot) = slots.get_mut(slot * len..(slot + 1) * len) {
                    simulation.store(slot);
                }
            }
            Move::Restore { slot, .. } => {
                if let Some(slot) = slots.get(slot * len..(slot + 1) * len) {
                    simulation.restore(slot);
                }
            }
            Move::Reverse { step } => simulation.reverse(exec, step)?,
        }
    }
    Ok(repeated)
}
