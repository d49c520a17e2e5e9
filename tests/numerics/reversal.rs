//! Binomial checkpointing: every order of moves is played, and no schedule takes fewer steps.

use thurible_core::reversal::{Move, Reversal, Reversible, repeated_steps, reverse_all};
use thurible_core::{Exec, Serial};

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

/// x_{k+1} = x_k + x_k^2 / (k + 4): a simulation of one number.
#[derive(Clone, Copy)]
struct Growth {
    x: f64,
    adjoint: f64,
}

impl Reversible<f64> for Growth {
    type Error = usize;

    fn advance(&mut self, _: &dyn Exec, step: usize) -> Result<(), usize> {
        self.x += self.x * self.x / (step + 4) as f64;
        if self.x < 100.0 { Ok(()) } else { Err(step) }
    }

    fn reverse(&mut self, _: &dyn Exec, step: usize) -> Result<(), usize> {
        self.adjoint *= 1.0 + 2.0 * self.x / (step + 4) as f64;
        Ok(())
    }

    fn store(&self, slot: &mut [f64]) {
        slot[0] = self.x;
    }

    fn restore(&mut self, slot: &[f64]) {
        self.x = slot[0];
    }
}

#[test]
fn a_simulation_is_taken_back_with_the_same_bits_for_any_number_of_slots() {
    let steps = 12;
    let end = |x: f64| {
        let mut run = Growth { x, adjoint: 0.0 };
        (0..steps).for_each(|step| run.advance(&Serial, step).unwrap());
        run.x
    };
    let (start, tiny) = (0.7, 1e-6);
    let difference = (end(start + tiny) - end(start - tiny)) / (2.0 * tiny);
    let mut first = None;
    for slots in [1, 2, 3, 5, 12, 30] {
        let mut run = Growth {
            x: start,
            adjoint: 1.0,
        };
        let repeated = reverse_all(
            &mut run,
            &Serial,
            steps,
            &mut vec![0.0; slots],
            &mut vec![0; slots],
        );
        assert_eq!(repeated, Ok(repeated_steps(steps, slots)));
        assert!(
            (run.adjoint - difference).abs() < 1e-8 * difference,
            "{} {difference}",
            run.adjoint
        );
        assert_eq!(
            run.adjoint.to_bits(),
            *first.get_or_insert(run.adjoint.to_bits()),
            "{slots} slots"
        );
    }
    let mut fast = Growth {
        x: 50.0,
        adjoint: 1.0,
    };
    assert_eq!(
        reverse_all(&mut fast, &Serial, steps, &mut [0.0; 2], &mut [0; 2]),
        Err(0)
    );
}
