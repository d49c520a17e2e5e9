//! Fields of which several programs, the ranks, have a part each: planes that lie one after the other, and copies of the planes beside.
//!
//! ```text
//! rank 0     wall | 0 1 2 3 4 5 | 6 7
//! rank 1            4 5 | 6 7 8 9 10 | 11 12
//! rank 2                  9 10 | 11 12 13 14 15 | wall
//! ```
//!
//! Layers outside of open ends are planes of the first and the last rank beside the share that each has of those inside, so that a coarser grid, which has
//! as many layers, is cut where the finer one is.

use core::ops::Range;

/// Planes on either side that a rank has copies of, where its method reads no further than transport does.
pub const REACH: usize = 2;

/// `total` cut into pieces of `unit`, of which a rank has about as many as another.
#[must_use]
pub fn cut(total: usize, unit: usize, rank: usize, ranks: usize) -> Range<usize> {
    let pieces = total.div_ceil(unit.max(1));
    let begin = |rank: usize| (pieces * rank / ranks.max(1) * unit).min(total);
    begin(rank)..begin(rank + 1)
}

/// The planes of a rank, of `planes` among which are so many `layers` outside at either end.
#[must_use]
pub fn slab(planes: usize, layers: [usize; 2], rank: usize, ranks: usize) -> Range<usize> {
    let [below, above] = layers;
    let inside = cut(planes.saturating_sub(below + above), 1, rank, ranks);
    let start = if rank == 0 { 0 } else { below + inside.start };
    let end = below + inside.end + if rank + 1 == ranks { above } else { 0 };
    start..end
}

/// Which of the ranks that share a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// The rank, from 0.
    pub rank: usize,
    /// How many there are.
    pub ranks: usize,
    /// Planes on either side that a rank has copies of: as far as the method reads, which a plan knows. It is also the fewest planes that a rank may
    /// have, so that its neighbours' copies are of nobody else.
    pub reach: usize,
}

impl Share {
    /// Rank `rank` of `ranks`, with copies of [`REACH`] planes.
    #[must_use]
    pub fn new(rank: usize, ranks: usize) -> Self {
        Self {
            rank,
            ranks,
            reach: REACH,
        }
    }
}

/// Which planes of a field a rank has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The rank.
    pub share: Share,
    /// Planes of the whole field.
    pub planes: usize,
    /// Whether the last of them is beside the first.
    pub ring: bool,
    /// How many of them lie outside the box, before its low end and behind its high one.
    pub layers: [usize; 2],
}

impl Part {
    /// The planes of the whole field that a rank has.
    #[must_use]
    pub fn of(self, rank: usize) -> Range<usize> {
        slab(self.planes, self.layers, rank, self.share.ranks)
    }

    /// Copies below and above this rank's planes.
    #[must_use]
    pub fn copies(self) -> [usize; 2] {
        self.neighbours()
            .map(|neighbour| self.share.reach * usize::from(neighbour.is_some()))
    }

    /// The planes that are no copies, among those that this rank has in memory.
    #[must_use]
    pub fn own(self) -> Range<usize> {
        let [below, _] = self.copies();
        below..below + self.of(self.share.rank).len()
    }

    /// The planes that this rank has in memory.
    #[must_use]
    pub fn held(self) -> usize {
        let [below, above] = self.copies();
        self.of(self.share.rank).len() + below + above
    }

    /// Elements of the whole field where those in memory are `held`.
    #[must_use]
    pub fn whole(self, held: usize) -> usize {
        held / self.held().max(1) * self.planes
    }

    /// The rank that has the planes below those of this one, and the rank that has those above.
    #[must_use]
    pub fn neighbours(self) -> [Option<usize>; 2] {
        let Share { rank, ranks, .. } = self.share;
        [
            (self.ring || rank > 0).then(|| (rank + ranks - 1) % ranks),
            (self.ring || rank + 1 < ranks).then(|| (rank + 1) % ranks),
        ]
    }
}

/// How much of a field a program has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// All of it, and so have the other ranks, if there are any.
    All,
    /// Some planes of cells, or of faces along them.
    Planes(Part),
    /// Some planes of faces between them.
    Between(Part),
}

impl Held {
    /// That of component `axis` of a field of `dims` components, or of cells.
    #[must_use]
    pub fn of(part: Option<Part>, dims: usize, axis: Option<usize>) -> Self {
        match (part, axis) {
            (None, _) => Self::All,
            (Some(part), Some(axis)) if axis + 1 == dims => Self::Between(part),
            (Some(part), _) => Self::Planes(part),
        }
    }

    /// Elements of the whole field where those in memory are `held`.
    #[must_use]
    pub fn whole(self, held: usize) -> usize {
        match self {
            Self::All => held,
            Self::Planes(part) | Self::Between(part) => part.whole(held),
        }
    }
}
