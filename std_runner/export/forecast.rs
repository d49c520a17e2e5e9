//! Whether the disc has room for the steps that are still to be written, by what those before them took.

use crate::exit::Failure;
use crate::{bytes, room};
use std::path::Path;

/// What is known of an export on its way.
pub(super) struct Forecast {
    /// Steps that are asked for.
    steps: usize,
    /// Bytes that are written behind the last step.
    later: u64,
    /// Steps and bytes when it was last looked.
    last: [u64; 2],
    /// The number of steps from which on it is looked again. A walk over the files each time that their number has doubled costs nothing.
    next: usize,
}

impl Forecast {
    /// That of `steps`, with so many bytes behind the last one.
    pub fn new(steps: usize, later: u64) -> Self {
        Self {
            steps,
            later,
            last: [0; 2],
            next: 0,
        }
    }

    /// Looks whether the rest finds room beside the `done` steps in `folder`, which the user calls `shown`.
    pub fn check(&mut self, folder: &Path, shown: &Path, done: usize) -> Result<(), Failure> {
        if done < self.next {
            return Ok(());
        }
        self.next = (2 * done).max(1);
        let rest = self.rest(done, room::taken(folder, &|_| true));
        match room::free_at(folder) {
            Some(free) if free < rest => Err(Failure::File(self.refuse(shown, done, [rest, free]))),
            _ => Ok(()),
        }
    }

    /// Bytes that are still to be written after `done` steps of so many bytes, where each takes as much as the newest ones: the first
    /// may be of smoke that does not move, and packed flows of nothing take nothing.
    fn rest(&mut self, done: usize, bytes: u64) -> u64 {
        let [last_done, last_bytes] = self.last;
        let new = (done as u64).saturating_sub(last_done);
        self.last = [done as u64, bytes];
        let of_one = bytes.saturating_sub(last_bytes).checked_div(new).unwrap_or(0);
        let steps = self.steps.saturating_sub(done) as u64;
        of_one.saturating_mul(steps).saturating_add(self.later)
    }

    fn refuse(&self, shown: &Path, done: usize, bytes: [u64; 2]) -> String {
        let [rest, free] = bytes.map(|count| bytes::rounded(usize::try_from(count).unwrap_or(usize::MAX)));
        let what = if done == 0 {
            "the export".to_owned()
        } else {
            format!("what is left of the export after {done} of {} steps", self.steps)
        };
        format!(
            "{what} takes at least {rest}, but the disc of {} has room for {free} only; free some space, choose a folder on another disc with -o DIR, or write fewer steps with --steps FROM..TO",
            shown.display()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second step tells what a step with a flow takes; what is written in the end counts from the start.
    #[test]
    fn the_rest_is_as_large_as_the_newest_steps() {
        let mut forecast = Forecast::new(10, 1000);
        assert_eq!(forecast.rest(0, 0), 1000);
        assert_eq!(forecast.rest(1, 20), 9 * 20 + 1000);
        assert_eq!(forecast.rest(2, 120), 8 * 100 + 1000);
        assert_eq!(forecast.rest(4, 340), 6 * 110 + 1000);
        assert_eq!(forecast.rest(10, 1000), 1000);
    }

    #[test]
    fn the_sentence_says_what_is_left_and_what_to_do() {
        let forecast = Forecast::new(10, 0);
        let sentence = forecast.refuse(Path::new("out/export"), 2, [2000, 1000]);
        assert!(
            sentence.starts_with(
                "what is left of the export after 2 of 10 steps takes at least 1.95 KiB, but the disc of out/export has room for"
            ),
            "{sentence}"
        );
    }
}
