//! What is kept of a simulation for the way back, by number.

/// What is kept of a simulation for the way back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slots {
    /// Nothing: the flow alone, without gradients.
    #[default]
    None,
    /// All that the adjoint reads of every step.
    Tape,
    /// The states of so many steps, that at the start counted.
    States(usize),
}

impl Slots {
    /// So many states; 0 stands for all that the adjoint reads.
    #[must_use]
    pub fn of(states: usize) -> Self {
        match states {
            0 => Self::Tape,
            states => Self::States(states),
        }
    }

    /// How many states.
    #[must_use]
    pub fn states(self) -> usize {
        match self {
            Self::States(states) => states,
            Self::None | Self::Tape => 0,
        }
    }

    /// Steps that a gradient repeats beside those that it runs once more to take them back.
    #[must_use]
    pub fn repeated_steps(self, steps: usize) -> usize {
        match self {
            Self::None | Self::Tape => 0,
            Self::States(slots) => crate::reversal::repeated_steps(steps, slots),
        }
    }
}
