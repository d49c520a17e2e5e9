//! Fields of which several programs, the ranks, have a part each: planes that lie one after the other, and copies of the planes beside.
//!
//! ```text
//! rank 0     wall | 0 1 2 3 4 5 | 6 7
//! rank 1            4 5 | 6 7 8 9 10 | 11 12
//! rank 2                  9 10 | 11 12 13 14 15 | wall
//! ```
//!
//! In blocks the ranks are cut along two axes: of its planes a rank has some rows, and copies of the rows beside. Each axis is cut as above, by the ranks of
//! a [`Line`] along it.
//!
//! ```text
//! z
//! | rank 4 | rank 5 |
//! | rank 2 | rank 3 |
//! | rank 0 | rank 1 |
//! +------------------ y
//! ```
//!
//! Layers outside of open ends are planes of the first and the last rank beside the share that each has of those inside, so that a coarser grid, which has
//! as many layers, is cut where the finer one is.

use core::ops::Range;

/// Planes, and in blocks rows, on either side that a rank has copies of, where its method reads no further than transport does.
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
    /// How many of them share the rows of the same planes, side by side along the axis before the last: 1 where each has whole planes. It divides their
    /// number.
    pub beside: usize,
    /// Planes, and in blocks rows, on either side that a rank has copies of: as far as the method reads, which a plan knows. It is also the fewest that a
    /// rank may have, so that its neighbours' copies are of nobody else.
    pub reach: usize,
}

impl Share {
    /// Rank `rank` of `ranks`, each with whole planes, with copies of [`REACH`] planes.
    #[must_use]
    pub fn new(rank: usize, ranks: usize) -> Self {
        Self {
            rank,
            ranks,
            beside: 1,
            reach: REACH,
        }
    }

    /// The same in blocks, so many of them beside each other.
    #[must_use]
    pub fn in_blocks(self, beside: usize) -> Self {
        Self { beside, ..self }
    }

    /// The ranks along the last axis which have the same rows as this one.
    #[must_use]
    pub fn along_planes(self) -> Line {
        let beside = self.beside.max(1);
        Line {
            first: self.rank % beside,
            place: self.rank / beside,
            count: (self.ranks / beside).max(1),
            apart: beside,
        }
    }

    /// The ranks which have the same planes as this one.
    #[must_use]
    pub fn along_rows(self) -> Line {
        let count = self.beside.max(1);
        Line {
            first: self.rank / count * count,
            place: self.rank % count,
            count,
            apart: 1,
        }
    }
}

/// Ranks one behind the other along an axis, as one of them sees them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// The rank at its begin.
    pub first: usize,
    /// Its place among them, from 0.
    pub place: usize,
    /// How many there are.
    pub count: usize,
    /// From the number of a rank to that of the next.
    pub apart: usize,
}

/// Which planes of a field a rank has, or which rows of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The ranks that share them.
    pub line: Line,
    /// Copies on either side: see [`Share::reach`].
    pub reach: usize,
    /// Planes of the whole field.
    pub planes: usize,
    /// Whether the last of them is beside the first.
    pub ring: bool,
    /// How many of them lie outside the box, before its low end and behind its high one.
    pub layers: [usize; 2],
}

impl Part {
    /// The planes of the whole field that the rank at a place of the line has.
    #[must_use]
    pub fn of(self, place: usize) -> Range<usize> {
        slab(self.planes, self.layers, place, self.line.count)
    }

    /// Copies below and above this rank's planes.
    #[must_use]
    pub fn copies(self) -> [usize; 2] {
        self.neighbours()
            .map(|neighbour| self.reach * usize::from(neighbour.is_some()))
    }

    /// The planes that are no copies, among those that this rank has in memory.
    #[must_use]
    pub fn own(self) -> Range<usize> {
        let [below, _] = self.copies();
        below..below + self.of(self.line.place).len()
    }

    /// The planes that this rank has in memory.
    #[must_use]
    pub fn held(self) -> usize {
        let [below, above] = self.copies();
        self.of(self.line.place).len() + below + above
    }

    /// The most that any rank has.
    fn most(self) -> usize {
        let lens = (0..self.line.count).map(|place| self.of(place).len());
        lens.max().unwrap_or(0)
    }

    /// The place of the rank that has a plane of the whole field.
    fn whose(self, plane: usize) -> usize {
        let (mut low, mut high) = (0, self.line.count.saturating_sub(1));
        while low < high {
            let middle = low.midpoint(high);
            if self.of(middle).end <= plane {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }

    /// The places of the rank that has the planes below those of this one, and of the rank that has those above.
    #[must_use]
    pub fn neighbours(self) -> [Option<usize>; 2] {
        let Line { place, count, .. } = self.line;
        [
            (self.ring || place > 0).then(|| (place + count - 1) % count),
            (self.ring || place + 1 < count).then(|| (place + 1) % count),
        ]
    }
}

/// Which planes of a field a rank has, and which rows of each where the box is cut into blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Which of the ranks.
    pub share: Share,
    /// Its planes, normal to the last axis.
    pub planes: Part,
    /// Its rows of them, along the axis before; `None` where it has whole planes.
    pub rows: Option<Part>,
}

impl Parts {
    /// Values of a row in memory, of a field that has so many, or of a plane where a rank has all of each.
    fn width(self, held: usize) -> usize {
        held / (self.planes.held() * self.rows.map_or(1, Part::held)).max(1)
    }

    /// Where what is no copy lies in a field of `held` values.
    #[must_use]
    pub fn own(self, held: usize) -> Strips {
        let rows = self.rows.map_or(1, Part::held);
        let own = self.rows.map_or(0..1, Part::own);
        Strips::of(self.planes.own(), [own, 0..rows], self.width(held))
    }

    /// Elements of the whole field where those in memory are `held`.
    #[must_use]
    pub fn whole(self, held: usize) -> usize {
        self.width(held) * self.planes.planes * self.rows.map_or(1, |rows| rows.planes)
    }

    /// Where those of [`Self::own`] lie in the whole field.
    #[must_use]
    pub fn own_of_whole(self, held: usize) -> Strips {
        let rows = self.rows.map_or(0..1, |rows| rows.of(rows.line.place));
        let all = 0..self.rows.map_or(1, |rows| rows.planes);
        let planes = self.planes.of(self.planes.line.place);
        Strips::of(planes, [rows, all], self.width(held))
    }

    /// Values of the largest part that a rank has of a whole field.
    #[must_use]
    pub fn most(self, whole: usize) -> usize {
        self.planes.most() * self.rows.map_or(1, Part::most) * self.width_of(whole)
    }

    /// Values of a row, or of a plane where a rank has all of each, of a whole field.
    fn width_of(self, whole: usize) -> usize {
        whole / (self.planes.planes * self.rows.map_or(1, |rows| rows.planes)).max(1)
    }

    /// Which rank has a value of a whole field, its place among what that one has, and how many follow it in both.
    #[must_use]
    pub fn whose(self, whole: usize, index: usize) -> (usize, usize, usize) {
        let width = self.width_of(whole).max(1);
        let (row, beside) = (index / width, index % width);
        let Some(rows) = self.rows else {
            let place = self.planes.whose(row);
            let own = self.planes.of(place);
            let before = row.saturating_sub(own.start) * width + beside;
            return (place, before, (own.len() * width).saturating_sub(before));
        };
        let (plane, row) = (row / rows.planes.max(1), row % rows.planes.max(1));
        let places = [self.planes.whose(plane), rows.whose(row)];
        let [planes, own] = [self.planes.of(places[0]), rows.of(places[1])];
        let before = row.saturating_sub(own.start) * width + beside;
        let (len, above) = (own.len() * width, plane.saturating_sub(planes.start));
        let rank = places[0] * rows.line.count + places[1];
        (rank, above * len + before, len.saturating_sub(before))
    }

    /// The numbers by which a file of parts knows how a field is cut.
    #[must_use]
    pub fn words(self) -> [u64; 3] {
        let rows = self.rows.map_or(0, |rows| rows.planes);
        let layers = [Some(self.planes), self.rows].map(|part| part.map_or([0; 2], |part| part.layers));
        let bits = layers.as_flattened().iter().rev();
        let layers = bits.fold(0, |bits, &layers| bits << 1 | u64::from(layers > 0));
        [self.planes.planes as u64, rows as u64, layers]
    }

    /// Whether a whole field of so many values has rows and planes as these.
    #[must_use]
    pub fn are_of(self, whole: usize) -> bool {
        let rows = self.rows.map_or(1, |rows| rows.planes);
        let count = self.planes.planes.checked_mul(rows);
        count.is_some_and(|count| count > 0 && whole.is_multiple_of(count))
    }

    /// How `share` cuts a field with these numbers, of which nobody has copies.
    #[must_use]
    pub fn of_words(share: Share, [planes, rows, layers]: [u64; 3]) -> Self {
        let cells = |word: u64| usize::try_from(word).unwrap_or(usize::MAX);
        let layer = |bit: u32| (layers >> bit & 1) as usize;
        let axis = |word, bit| Whole::new(cells(word), false, [layer(bit), layer(bit + 1)]);
        Cut::new(Share { reach: 0, ..share }, [axis(planes, 0), axis(rows, 2)]).parts()
    }
}

/// How a box is cut, of which a grid is a part, in few bytes: there are many grids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    rank: u32,
    ranks: u32,
    beside: u32,
    reach: u32,
    planes: Whole,
    rows: Whole,
}

/// An axis of a whole box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole {
    cells: u32,
    ring: bool,
    layers: [bool; 2],
}

/// A number of cells or ranks; one that is larger is refused before anything is made of it.
fn short(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

impl Whole {
    /// One of so many cells, a ring or with a layer outside before its low end or behind its high one.
    #[must_use]
    pub fn new(cells: usize, ring: bool, layers: [usize; 2]) -> Self {
        Self {
            cells: short(cells),
            ring,
            layers: layers.map(|layers| layers > 0),
        }
    }

    fn part(self, line: Line, reach: u32) -> Part {
        Part {
            line,
            reach: reach as usize,
            planes: self.cells as usize,
            ring: self.ring,
            layers: self.layers.map(usize::from),
        }
    }
}

impl Cut {
    /// That of a rank of a box with this last axis and this one before it.
    #[must_use]
    pub fn new(share: Share, [planes, rows]: [Whole; 2]) -> Self {
        Self {
            rank: short(share.rank),
            ranks: short(share.ranks),
            beside: short(share.beside),
            reach: short(share.reach),
            planes,
            rows,
        }
    }

    fn share(self) -> Share {
        Share {
            rank: self.rank as usize,
            ranks: self.ranks as usize,
            beside: self.beside as usize,
            reach: self.reach as usize,
        }
    }

    /// The planes of the rank.
    #[must_use]
    pub fn planes(self) -> Part {
        self.planes.part(self.share().along_planes(), self.reach)
    }

    /// Its rows of them; `None` where it has whole planes.
    #[must_use]
    pub fn rows(self) -> Option<Part> {
        (self.beside > 1).then(|| self.rows.part(self.share().along_rows(), self.reach))
    }

    /// Both.
    #[must_use]
    pub fn parts(self) -> Parts {
        Parts {
            share: self.share(),
            planes: self.planes(),
            rows: self.rows(),
        }
    }
}

/// Values of a field that lie side by side in each of several planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strips {
    /// Where the first of them begin.
    pub first: usize,
    /// How many lie side by side.
    pub len: usize,
    /// From where some begin to where those of the next plane do.
    pub apart: usize,
    /// Planes.
    pub count: usize,
}

impl Strips {
    /// So many values, one after the other from the first place on.
    #[must_use]
    pub fn all(len: usize) -> Self {
        Self {
            first: 0,
            len,
            apart: len,
            count: 1,
        }
    }

    /// Some `planes`, and of each the first of two ranges of rows, of `width` values, where it has the second one; all in one where these are the same.
    #[must_use]
    pub fn of(planes: Range<usize>, [rows, all]: [Range<usize>; 2], width: usize) -> Self {
        let apart = all.len() * width;
        let first = planes.start * apart + (rows.start - all.start) * width;
        let (len, count) = (rows.len() * width, planes.len());
        if rows == all {
            Self {
                first,
                len: len * count,
                apart: len * count,
                count: 1,
            }
        } else {
            Self {
                first,
                len,
                apart,
                count,
            }
        }
    }

    /// As many values, where they lie one after the other from the first place on.
    #[must_use]
    pub fn packed(self) -> Self {
        Self {
            first: 0,
            apart: self.len,
            ..self
        }
    }

    /// How many values they are.
    #[must_use]
    pub fn total(self) -> usize {
        self.len * self.count
    }

    /// Where those of each plane lie.
    pub fn ranges(self) -> impl Iterator<Item = Range<usize>> {
        (0..self.count).map(move |plane| {
            let begin = self.first + plane * self.apart;
            begin..begin + self.len
        })
    }

    /// Where those lie which come after `from` others, plane after plane, `count` of them at most: as many as lie side by side, and how many that is.
    fn next(self, from: usize, count: usize) -> Range<usize> {
        let (plane, within) = (from / self.len.max(1), from % self.len.max(1));
        let begin = self.first + plane * self.apart + within;
        begin..begin + count.min(self.len - within.min(self.len))
    }

    /// Calls `each` with where values of the field and of a message lie, for those from number `from` on that fill `count` of it.
    pub fn pieces(self, from: usize, count: usize, mut each: impl FnMut(Range<usize>, Range<usize>)) {
        let count = count.min(self.total().saturating_sub(from));
        let mut done = 0;
        while done < count {
            let next = self.next(from + done, count - done);
            let len = next.len();
            each(next, done..done + len);
            done += len;
        }
    }
}

/// How much of a field a program has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// All of it, and so have the other ranks, if there are any.
    All,
    /// A part of it.
    Part {
        /// Which.
        parts: Parts,
        /// Whether they are faces between planes, or between rows that are shared too.
        between: [bool; 2],
    },
}

impl Held {
    /// That of component `axis` of a field of `dims` components, or of cells.
    #[must_use]
    pub fn of(parts: Option<Parts>, dims: usize, axis: Option<usize>) -> Self {
        match parts {
            None => Self::All,
            Some(parts) => Self::Part {
                parts,
                between: [1, 2].map(|before| axis.is_some_and(|axis| axis + before == dims)),
            },
        }
    }

    /// Elements of the whole field where those in memory are `held`.
    #[must_use]
    pub fn whole(self, held: usize) -> usize {
        match self {
            Self::All => held,
            Self::Part { parts, .. } => parts.whole(held),
        }
    }
}
