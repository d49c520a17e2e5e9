//! What frames of smoke say of each other before anything is tracked: a frame beside the one before it.

use thurible_core::Real;

/// A frame whose smoke is this many times that of the one before, or less than one so many-th, is worth a remark.
const JUMP: f64 = 3.0;
/// Frames in which the smoke overlaps less than this part with the one before: it has moved farther than itself.
const OVERLAP: f64 = 0.05;

/// What no flow, or hardly one, makes of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// All smoke is gone.
    Lost,
    /// There is smoke where there was none at all.
    Begun,
    /// There is so many times as much smoke.
    Times(f64),
    /// Hardly any of the smoke is where it was.
    Jumped,
}

/// How `now` differs from `before`, where that is worth a word.
pub fn between<T: Real>(before: &[T], now: &[T]) -> Option<Change> {
    let amount = |value: &T| value.to_f64().max(0.0);
    let [was, is]: [f64; 2] = [before, now].map(|values| values.iter().map(amount).sum());
    let shared = || -> f64 {
        before
            .iter()
            .map(amount)
            .zip(now.iter().map(amount))
            .map(|(a, b)| a.min(b))
            .sum()
    };
    match (was > 0.0, is > 0.0) {
        (true, false) => Some(Change::Lost),
        (false, true) => Some(Change::Begun),
        (false, false) => None,
        _ if is > JUMP * was || was > JUMP * is => Some(Change::Times(is / was)),
        _ => (shared() < OVERLAP * was.min(is)).then_some(Change::Jumped),
    }
}

impl Change {
    /// What is found of the frame `to` behind the frame `from`, and the remedy; the caller's names of what begins later, and of how many grids
    /// there are, stand in it.
    #[must_use]
    pub fn sentence(self, [from, to]: [usize; 2], [begin, levels]: [&str; 2]) -> String {
        match self {
            Self::Lost => format!("frame {to} has no smoke anywhere, and the frame before has some"),
            Self::Begun => format!(
                "from frame {from} to {to} smoke appears where there was none at all, which no flow does: its flow means nothing; begin at frame {to} by {begin}"
            ),
            Self::Times(times) => format!(
                "from frame {from} to {to} the smoke becomes {times:.1} times as much, which no flow does: its flow means little"
            ),
            Self::Jumped => format!(
                "from frame {from} to {to} the smoke jumps: hardly any of it is where it was, so its flow means little; give more frames a second, or raise {levels}"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_compared() {
        let [none, some, more, elsewhere] = [[0.0, 0.0], [1.0, 0.0], [3.5, 0.0], [0.0, 1.0]];
        assert_eq!(between(&none, &none), None);
        assert_eq!(between(&some, &some), None);
        assert_eq!(between(&some, &none), Some(Change::Lost));
        assert_eq!(between(&none, &some), Some(Change::Begun));
        assert_eq!(between(&some, &more), Some(Change::Times(3.5)));
        assert_eq!(between(&some, &elsewhere), Some(Change::Jumped));
        // What is below 0 is nothing.
        assert_eq!(between(&[-1.0, -2.0], &some), Some(Change::Begun));
        assert!(
            Change::Jumped
                .sentence([4, 5], ["first", "levels"])
                .contains("from frame 4 to 5")
        );
    }
}
