//! How long a search still takes.

use super::display::iterations_on_the_finest_grid;
use std::collections::VecDeque;
use thurible_core::{Falls, Progress, Rule};

/// The fewest iterations by which the end of a search is foretold, and the most.
const FEWEST: usize = 4;
const MOST: usize = 64;
/// Seconds on its finest grid before which nothing is foretold.
const SOON: f64 = 0.5;
/// The middle.
const HALF: f64 = 0.5;
/// Of the iterations so far, how many more are expected at least where the number of the rule does not fall.
const SHORTLY: f64 = 0.05;
/// A limit that is so many times as far away as the search has come does not tell when it ends.
const FAR: f64 = 8.0;
/// A descent ends by the first two of its scattered gains that are below the bound, so by the lower ones.
const EARLY: f64 = 0.3;
/// How much is believed that its gains fall as a power (measured: docs/watching.md).
const POWER: f64 = 0.75;

/// The pace of a search on its finest grid.
///
/// Iterations there take the same time on average. There are as many as the limit leaves, or fewer where the number that the rule of convergence looks at
/// falls so fast that it is below its bound before: its logarithm over the last 64 iterations, as a line whose slope is the median of those between any
/// two of them (Theil 1950, Sen 1968). ADMM's number leaps where its step doubles, which a line of least squares follows. What a descent gains falls ever
/// more slowly, so that it is looked at by the logarithm of the number of iterations too.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    /// Iterations on the finest grid at most.
    limit: usize,
    /// Those so far.
    done: usize,
    /// When the first one that was heard of began.
    begun: f64,
    /// How many there were when it ended, and when that was.
    first: Option<(usize, f64)>,
    /// When the last iteration ended, of whatever grid.
    last: f64,
    /// Logarithms of the latest values of the rule, and of its bound.
    values: VecDeque<f64>,
    bound: f64,
    /// Whether it falls as a power of the number of iterations.
    is_power: bool,
    /// After how many iterations it was last foretold to hold, and whether that was the last time that it was looked at.
    end: Option<f64>,
    falls: bool,
}

impl Pace {
    /// That of a search of at most `limit` iterations on the finest grid.
    pub fn new(limit: usize) -> Self {
        Self {
            limit,
            values: VecDeque::with_capacity(MOST),
            ..Self::default()
        }
    }

    /// Hears of an iteration that ended `seconds` after the start.
    pub fn note(&mut self, progress: &Progress, seconds: f64) {
        let done = iterations_on_the_finest_grid(progress);
        let before = self.last;
        if done <= self.done {
            // A coarser grid, or another search.
            *self = Self::new(self.limit);
        }
        (self.done, self.last) = (done, seconds);
        if done == 0 {
            return;
        }
        if self.first.is_none() {
            (self.begun, self.first) = (before, Some((done, seconds)));
        }
        if let Some(Rule { value, bound, falls }) = progress.rule {
            if self.values.len() == MOST {
                self.values.pop_front();
            }
            self.values.push_back(value.max(f64::MIN_POSITIVE).ln());
            (self.bound, self.is_power) = (bound.ln(), falls == Falls::AsPower);
            let count = self.foretold_to_hold();
            self.falls = count.is_some();
            self.end = count.map(|count| done as f64 + count).or(self.end);
        }
    }

    /// Iterations on the finest grid so far.
    pub fn done(&self) -> usize {
        self.done
    }

    /// Seconds that the search still takes after its last iteration, about; `None` where nothing tells yet.
    pub fn left(&self) -> Option<f64> {
        let (first, ended) = self.first?;
        let values = self.values.len();
        if values < FEWEST && (values > 0 || self.done == first) {
            // Where a rule may end it, and no first iteration has one yet, the limit alone would tell of several times as long.
            return None;
        }
        if self.last - self.begun < SOON {
            return None;
        }
        let (count, seconds) = match self.done - first {
            // The first one may have made the start as well, so it counts only as long as it is alone.
            0 if first == 1 => (1, self.last - self.begun),
            // A search that goes on from a saved state: when its first iteration here began is not known.
            0 => return None,
            count => (count, self.last - ended),
        };
        Some(seconds / count as f64 * self.iterations_left())
    }

    fn at_most(&self) -> f64 {
        self.limit.saturating_sub(self.done) as f64
    }

    fn iterations_left(&self) -> f64 {
        let (at_most, done) = (self.at_most(), self.done as f64);
        // Where nothing falls just now the end is where it was expected, or soon; the limit of a search that is to converge is far away.
        let soon = if self.falls { 0.0 } else { SHORTLY * done };
        let count = self.end.map(|end| (end - done).max(soon));
        // Where the limit says nothing a guess that is far away would ever put off the end: from the middle on there is no more than as much again.
        let believed = |count: f64| {
            let is_guess = self.done >= MOST && at_most > FAR * done && count > 2.0 * done;
            if is_guess { done } else { count }
        };
        count.map_or(at_most, |count| believed(count).clamp(0.0, at_most))
    }

    /// Iterations until the rule holds, up to the limit, where its number falls.
    fn foretold_to_hold(&self) -> Option<f64> {
        let left = |is_power: bool, part: f64| {
            let foretold = self.foretold(is_power, part)?;
            Some(foretold.clamp(0.0, self.at_most()))
        };
        if !self.is_power {
            return left(false, HALF);
        }
        // Between what a line says and what a power does, nearer to this.
        let (line, power) = (left(false, EARLY)?, left(true, EARLY)?);
        Some(line.powf(1.0 - POWER) * power.powf(POWER))
    }

    /// Iterations until the rule holds, if its number goes on to fall as in the latest ones, this part of which were lower: by the same factor
    /// each, or as a power of their number.
    fn foretold(&self, is_power: bool, part: f64) -> Option<f64> {
        let at = |number: f64| if is_power { number.ln() } else { number };
        let numbers = (0..).map(|back| at(self.done.saturating_sub(back).max(1) as f64));
        let latest: Vec<(f64, f64)> = numbers.zip(self.values.iter().rev().copied()).collect();
        let slopes = latest.iter().enumerate().flat_map(|(index, &(near, late))| {
            let before = latest.get(index + 1..).unwrap_or(&[]);
            before
                .iter()
                .map(move |&(far, early)| (early - late) / (near - far))
        });
        let fall = quantile(slopes.collect(), HALF)?;
        let begin = quantile(latest.iter().map(|(x, y)| y + fall * x).collect(), part)?;
        let end = (begin - self.bound) / fall;
        let end = if is_power { end.exp() } else { end };
        (fall > 0.0).then(|| (end - self.done as f64).ceil().max(0.0) + 1.0)
    }
}

/// The number above this part of some; none of none.
fn quantile(mut numbers: Vec<f64>, part: f64) -> Option<f64> {
    let place = (part * numbers.len() as f64) as usize;
    (!numbers.is_empty()).then(|| *numbers.select_nth_unstable_by(place, f64::total_cmp).1)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn iteration(number: usize, value: f64) -> Progress {
        Progress {
            iteration: number,
            rule: Some(Rule {
                value,
                bound: 1e-4,
                falls: Falls::Geometrically,
            }),
            ..Progress::default()
        }
    }

    #[test]
    fn the_limit_ends_what_does_not_converge_before() {
        let mut pace = Pace::new(60);
        assert_eq!(pace.left(), None);
        // No rule looks at the first one.
        let first = Progress {
            iteration: 1,
            ..Progress::default()
        };
        pace.note(&first, 2.0);
        assert_eq!(pace.left(), None);
        for number in 2..=20 {
            pace.note(&iteration(number, 1e-2), 2.0 * number as f64);
            assert_eq!(pace.left().is_some(), number > 4);
        }
        assert!((pace.left().unwrap() - 80.0).abs() < 1e-9);
    }

    #[test]
    fn convergence_is_foretold() {
        let mut pace = Pace::new(1000);
        for number in 1..=30 {
            // It is below the bound after 80 iterations.
            let value = 1e-4 * ((80 - number) as f64 * 0.1).exp();
            pace.note(&iteration(number, value), 3.0 * number as f64);
        }
        let left = pace.left().unwrap();
        assert!((left - 150.0).abs() < 7.0, "{left}");
    }

    #[test]
    fn a_gain_that_falls_as_a_power_is_foretold() {
        let mut pace = Pace::new(1000);
        for number in 1..=30 {
            // It is below the bound after 80 iterations.
            let falls = Falls::AsPower;
            let value = 1e-4 * (80.0 / f64::from(number)).powf(1.7);
            let mut progress = iteration(number as usize, value);
            progress.rule = progress.rule.map(|rule| Rule { falls, ..rule });
            pace.note(&progress, 3.0 * f64::from(number));
        }
        // A line alone would say 33.
        let left = pace.left().unwrap();
        assert!((90.0..=150.0).contains(&left), "{left}");
    }

    /// Gains that hardly fall foretell nothing, nor does a limit that nobody expects to be reached; where they rest, the end stays.
    #[test]
    fn a_limit_that_is_far_away_does_not_put_off_the_end() {
        let mut pace = Pace::new(100_000);
        for number in 1..=200 {
            // It would be below the bound after 10,000 iterations.
            let value = 1e-4 * ((10_000 - number) as f64 * 1e-3).exp();
            pace.note(&iteration(number, value), 0.1 * number as f64);
        }
        assert!((pace.left().unwrap() - 20.0).abs() < 1e-9);
        let mut pace = Pace::new(100_000);
        for number in 1..=80 {
            let value = 1e-4 * ((100 - number.min(60)) as f64 * 0.1).exp();
            pace.note(&iteration(number, value), number as f64);
        }
        let left = pace.left().unwrap();
        assert!((4.0..60.0).contains(&left), "{left}");
    }

    /// ADMM's change of the density leaps now and then, where its step doubles.
    #[test]
    fn a_leap_changes_nothing() {
        let mut pace = Pace::new(1000);
        for number in 1..=30 {
            let value = 1e-4 * ((80 - number) as f64 * 0.1).exp();
            let leap = if number % 9 == 0 { 8.0 } else { 1.0 };
            pace.note(&iteration(number, leap * value), 3.0 * number as f64);
        }
        let left = pace.left().unwrap();
        assert!((left - 150.0).abs() < 7.0, "{left}");
    }

    #[test]
    fn a_coarser_grid_and_a_new_search_begin_anew() {
        let mut pace = Pace::new(10);
        (1..=4).for_each(|number| pace.note(&iteration(number, 1.0), number as f64));
        assert!(pace.left().is_some() && pace.done() == 4);
        let coarse = Progress {
            iteration: 5,
            level: 1,
            level_iteration: 1,
            ..Progress::default()
        };
        pace.note(&coarse, 5.0);
        assert_eq!((pace.left(), pace.done()), (None, 0));
        (1..=4).for_each(|number| pace.note(&iteration(number, 1.0), 5.0 + 3.0 * number as f64));
        assert_eq!((pace.left(), pace.done()), (Some(18.0), 4));
        pace.note(&iteration(1, 1.0), 18.0);
        assert_eq!((pace.left(), pace.done()), (None, 1));
    }

    #[test]
    fn a_tenth_of_a_second_tells_nothing() {
        let mut pace = Pace::new(100);
        for number in 1..=9 {
            pace.note(&iteration(number, 1.0), 0.06 * number as f64);
            assert_eq!(pace.left().is_some(), number > 8);
        }
    }
}
