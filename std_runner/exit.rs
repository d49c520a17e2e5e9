//! How the program ends: exit codes, and the one-sentence failures behind them.

use thiserror::Error;
use thurible_core::Status;

/// The solve converged, or ran all its iterations.
pub const DONE: u8 = 0;
/// A value was no longer finite.
pub const NOT_FINITE: u8 = 1;
/// The input or the command line is wrong.
pub const INPUT: u8 = 2;
/// The solve does not fit in memory.
pub const MEMORY: u8 = 3;
/// A file could not be read or written.
pub const FILE: u8 = 4;
/// The solve stalled before its tolerance; the result is written.
pub const STALLED: u8 = 5;
/// The solve was interrupted; the result so far is written.
pub const INTERRUPTED: u8 = 130;

/// Why a command could not do what it was asked: one sentence that ends with the remedy.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Failure {
    /// The scene or the command line is wrong.
    #[error("{0}")]
    Input(String),
    /// The plan does not fit.
    #[error("{0}")]
    Memory(String),
    /// A file could not be read or written.
    #[error("{0}")]
    File(String),
    /// A value was no longer finite.
    #[error("{0}")]
    NotFinite(String),
}

impl Failure {
    /// The exit code of this failure.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Input(_) => INPUT,
            Failure::Memory(_) => MEMORY,
            Failure::File(_) => FILE,
            Failure::NotFinite(_) => NOT_FINITE,
        }
    }
}

/// The exit code of a solve that ended with `status`.
pub fn code_of(status: Status) -> u8 {
    match status {
        Status::Converged | Status::MaxIterations => DONE,
        Status::Stalled => STALLED,
        Status::NotFinite | Status::NotReady => NOT_FINITE,
        Status::Cancelled => INTERRUPTED,
    }
}

/// The code that several runs end with: that of one that failed before that of one that stalled, and either before one that is done.
pub fn worse(one: u8, other: u8) -> u8 {
    let rank = |code| match code {
        DONE => 0,
        STALLED => 1,
        NOT_FINITE => 2,
        _ => 3,
    };
    if rank(other) > rank(one) { other } else { one }
}

/// The exit code of a run that ended with `status`, its result where it should be or `diverted` elsewhere.
pub fn code_of_result(status: Status, diverted: bool) -> u8 {
    if diverted { FILE } else { code_of(status) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The code of several runs does not depend on their order.
    #[test]
    fn of_several_runs_the_worst_one_says_how_it_ended() {
        let best_first = [DONE, STALLED, NOT_FINITE, INPUT];
        for (at, &one) in best_first.iter().enumerate() {
            for &other in &best_first[at..] {
                assert_eq!(worse(one, other), other);
                assert_eq!(worse(other, one), other);
            }
        }
        // Of two failures the first is kept.
        assert_eq!(worse(MEMORY, FILE), MEMORY);
    }
}
