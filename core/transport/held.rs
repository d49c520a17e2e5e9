//! The terms of sub-steps that are kept between the way forward and the way back.

use super::series::MAX_TERMS;

/// The most states of sub-steps that are kept; others are computed again.
pub const STATES: usize = 8;

/// Where the terms of the latest sub-steps are kept, as far as there is room.
#[derive(Debug, Default)]
pub struct Held {
    /// The terms of each sub-step of a block, in order.
    terms: heapless::Vec<Place, STATES>,
    /// The first sub-step whose terms were not overwritten.
    oldest: usize,
}

/// The terms of a sub-step.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The field of the first of them.
    pub begin: usize,
    /// How many there are.
    pub count: usize,
}

impl Held {
    /// Runs the next sub-step. It is told where its terms begin and returns how many there are, or `None` if they find no room
    /// behind those before: then it runs again and overwrites them.
    pub fn push(&mut self, mut substep: impl FnMut(usize) -> Option<usize>) {
        let last = self.terms.last();
        let (begin, as_many) = last.map_or((0, 0), |place| (place.begin + place.count, place.count));
        let count = if begin + as_many <= MAX_TERMS {
            substep(begin)
        } else {
            None
        };
        let place = match count {
            Some(count) => Place { begin, count },
            None => {
                self.oldest = self.terms.len();
                let count = substep(0).unwrap_or(0);
                Place { begin: 0, count }
            }
        };
        let _ = self.terms.push(place);
    }

    /// The terms of a sub-step, if they are still there.
    pub fn get(&self, substep: usize) -> Option<Place> {
        self.terms
            .get(substep)
            .copied()
            .filter(|_| substep >= self.oldest)
    }
}
