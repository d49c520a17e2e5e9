//! Whether discs have room for what a solve is going to write.

use super::{SLOTS, is_state_or_lock};
use crate::destination::Destination;
use crate::exit::Failure;
use crate::{bytes, room};
use std::path::Path;

/// Bytes that a solve is going to write.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Needs {
    /// The result.
    pub result: u64,
    /// What grows of a scene in windows until the result is written from it: beside the states, or where there are none beside the result.
    pub growing: u64,
    /// A state.
    pub state: u64,
}

/// What a solve is going to write on the disc of its result, and on that of its states: what grows, and the states themselves.
#[derive(Clone, Copy, Debug)]
struct Writes {
    result: u64,
    growing: u64,
    states: u64,
}

/// Bytes that are free on the disc of the result, and on that of the states.
#[derive(Clone, Copy, Debug)]
struct Free {
    result: u64,
    states: u64,
    /// Whether it is the same.
    is_one: bool,
}

/// What there is no room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lack {
    /// So many bytes where the result goes.
    Result(u64),
    /// What grows, where the states are.
    Growing,
    /// The states.
    States,
}

impl Writes {
    /// The first of them that finds no room.
    fn lack(self, free: Free) -> Option<Lack> {
        let Self {
            result,
            growing,
            states,
        } = self;
        let (here, there) = if free.is_one {
            let both = result.saturating_add(growing);
            (both, both)
        } else {
            (result, growing)
        };
        if free.result < here {
            Some(Lack::Result(here))
        } else if free.states < there {
            Some(Lack::Growing)
        } else if free.states < there.saturating_add(states) {
            Some(Lack::States)
        } else {
            None
        }
    }
}

impl Needs {
    /// The same where no states are kept.
    pub(super) fn without_states(self, goes_on: bool) -> Self {
        let beside = if goes_on { 0 } else { self.growing };
        Self {
            result: self.result.saturating_add(beside),
            growing: self.growing - beside,
            state: 0,
        }
    }

    /// Whether there is room for the states at `place`, which were `asked` for or not; those that are gone on from stay there.
    ///
    /// # Errors
    /// There is none for the result, or for states that were asked for.
    pub(super) fn have_room(
        self,
        destination: &Destination,
        place: &Path,
        (asked, goes_on): (bool, bool),
    ) -> Result<bool, Failure> {
        let Some(result) = room::free_at(destination.folder()) else {
            return Ok(true);
        };
        let free = Free {
            result,
            states: room::free_at(place).unwrap_or(result),
            is_one: room::are_on_one_disc(destination.folder(), place),
        };
        // Two are kept while the third is written; those that are there already have their room, and so has what has grown.
        let there = SLOTS.iter().filter(|slot| place.join(slot).is_file()).count() as u64;
        let grown = if goes_on {
            room::taken(place, &|name| !is_state_or_lock(name))
        } else {
            0
        };
        let writes = Writes {
            result: self.result,
            growing: self.growing.saturating_sub(grown),
            states: self.state.saturating_mul(3 - there),
        };
        let lack = match writes.lack(free) {
            None => return Ok(true),
            Some(Lack::States) if !asked => return Ok(false),
            // Without states it grows beside the result.
            Some(Lack::Growing) if !asked && !goes_on => {
                let writes = Writes {
                    result: writes.result.saturating_add(writes.growing),
                    growing: 0,
                    states: 0,
                };
                match writes.lack(free) {
                    None => return Ok(false),
                    Some(lack) => lack,
                }
            }
            Some(lack) => lack,
        };
        Err(Failure::File(writes.refuse(
            lack,
            free,
            [destination.shown(), place],
        )))
    }
}

impl Writes {
    /// The sentence about what is lacking on the discs of two folders.
    fn refuse(self, lack: Lack, free: Free, [result, place]: [&Path; 2]) -> String {
        let in_words = |count: u64| bytes::rounded(usize::try_from(count).unwrap_or(usize::MAX));
        let (result, place) = (result.display(), place.display());
        match lack {
            Lack::Result(bytes) => {
                let also = if bytes > self.result {
                    ", with what it is written from,"
                } else {
                    ""
                };
                format!(
                    "the result{also} takes about {}, but the disc of {result} has room for {} only; free some space, or choose a folder on another disc with -o DIR",
                    in_words(bytes),
                    in_words(free.result)
                )
            }
            Lack::States if free.is_one => format!(
                "the result takes about {} and its checkpoints {}, but the disc of {result} has room for {} only; free some space, choose a folder on another disc with -o DIR, or do without by --checkpoint off",
                in_words(self.result.saturating_add(self.growing)),
                in_words(self.states),
                in_words(free.result)
            ),
            Lack::States => format!(
                "the checkpoints take about {}, but the disc of {place} has room for {} only; free some space there, or do without by --checkpoint off",
                in_words(self.growing.saturating_add(self.states)),
                in_words(free.states)
            ),
            Lack::Growing => format!(
                "what the result is written from takes about {}, but the disc of {place} has room for {} only; free some space there",
                in_words(self.growing),
                in_words(free.states)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WRITES: Writes = Writes {
        result: 10,
        growing: 8,
        states: 6,
    };

    /// One disc has to hold the result twice, in windows, and the states.
    #[test]
    fn on_one_disc_all_of_it_finds_room() {
        let free = |bytes| Free {
            result: bytes,
            states: bytes,
            is_one: true,
        };
        assert_eq!(WRITES.lack(free(17)), Some(Lack::Result(18)));
        assert_eq!(WRITES.lack(free(18)), Some(Lack::States));
        assert_eq!(WRITES.lack(free(23)), Some(Lack::States));
        assert_eq!(WRITES.lack(free(24)), None);
    }

    /// Each of two discs is asked for its own, and the sentence names its number.
    #[test]
    fn of_two_discs_each_is_asked_for_its_own() {
        let free = |result, states| Free {
            result,
            states,
            is_one: false,
        };
        assert_eq!(WRITES.lack(free(10, 14)), None);
        for (free, lack, words) in [
            (
                free(9, 99),
                Lack::Result(10),
                [
                    "the disc of out has room for 9 bytes",
                    "the result takes about 10 bytes",
                ],
            ),
            (
                free(99, 7),
                Lack::Growing,
                ["the disc of kept has room for 7 bytes", "about 8 bytes"],
            ),
            (
                free(99, 13),
                Lack::States,
                ["the disc of kept has room for 13 bytes", "about 14 bytes"],
            ),
        ] {
            assert_eq!(WRITES.lack(free), Some(lack));
            let sentence = WRITES.refuse(lack, free, ["out", "kept"].map(Path::new));
            assert!(words.iter().all(|word| sentence.contains(word)), "{sentence}");
        }
    }
}
