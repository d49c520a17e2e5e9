//! The steps at which a keyframe of a scene stands: one, or several in a row where it is held.

use core::fmt::{self, Display, Formatter};
use core::ops::RangeInclusive;

/// From the first step to the last, both included; in words "step 40" or "steps 40 to 46".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stay {
    /// Where it begins.
    pub first: usize,
    /// Where it ends.
    pub last: usize,
}

impl Stay {
    /// That of a keyframe that is not held.
    pub fn at(step: usize) -> Self {
        Self {
            first: step,
            last: step,
        }
    }

    /// Whether it has more than one step.
    pub fn is_held(self) -> bool {
        self.first < self.last
    }

    /// Its steps, ascending.
    pub fn steps(self) -> RangeInclusive<usize> {
        self.first..=self.last
    }

    /// Whether `step` is one of them.
    pub fn contains(self, step: usize) -> bool {
        self.steps().contains(&step)
    }
}

impl Display for Stay {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if self.is_held() {
            write!(f, "steps {} to {}", self.first, self.last)
        } else {
            write!(f, "step {}", self.first)
        }
    }
}
