//! Binomial checkpointing: every order of moves is played, and no schedule takes fewer steps.

use thurible_core::reversal::{Move, Reversal, repeated_steps};

/// Plays the moves; the steps repeated, after every step was taken back once, from the last to the first.
fn played(steps: usize, slots: usize, stored: bool) -> usize {
    let mut kept = vec![0; slots];
    let mut states = vec![None; slots];
    if stored {
        states[0] = Some(0);
    }
    let (mut at, mut left, mut repeated) = (0, steps, 0);
    for next in Reversal::new(steps, &mut kept, stored) {
        match next {
            Move::Advance { from, to } => {
                assert_eq!(from, at);
                assert!(to > from);
                repeated += to - from;
                at = to;
            }
            Move::Store { slot } => states[slot] = Some(at),
            Move::Restore { slot, step } => {
                assert_eq!(states[slot], Some(step));
                at = step;
            }
            Move::Reverse { step } => {
                assert_eq!((step, step + 1), (at, left));
                left -= 1;
            }
        }
    }
    assert_eq!(left, 0);
    repeated
}

#[test]
fn no_order_repeats_fewer_steps_and_the_formula_counts_them() {
    let (steps, slots) = (60, 20);
    // fewest[s][l]: the best that any choice of the next kept state comes to.
    let mut fewest = vec![vec![0; steps + 1]; slots + 1];
    for l in 1..=steps {
        fewest[1][l] = l * (l - 1) / 2;
    }
    for s in 2..=slots {
        for l in 2..=steps {
            fewest[s][l] = (1..l)
                .map(|m| m + fewest[s - 1][l - m] + fewest[s][m])
                .min()
                .unwrap();
        }
    }
    for l in 1..=steps {
        for s in 1..=slots {
            assert_eq!(played(l, s, false), fewest[s][l], "{l} steps, {s} slots");
            assert_eq!(
                played(l, s, true),
                fewest[s][l],
                "{l} steps, {s} slots, the first stored"
            );
            assert_eq!(repeated_steps(l, s), fewest[s][l], "{l} steps, {s} slots");
        }
    }
}

#[test]
fn long_simulations_are_counted_without_overflow() {
    assert_eq!(repeated_steps(240, 10), 642);
    assert_eq!(repeated_steps(1000, 1), 999 * 500);
    assert!(repeated_steps(usize::MAX / 4, 64) > 0);
    assert_eq!(repeated_steps(0, 3), 0);
    assert_eq!(Reversal::new(5, &mut [], false).count(), 0);
    assert_eq!(Reversal::new(0, &mut [0; 3], false).count(), 0);
}
