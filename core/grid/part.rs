//! A box that several ranks share: each has a slab of it, planes normal to the last axis, and copies of the planes beside.
//!
//! ```text
//! rank 0     wall | 0 1 2 3 4 5 | 6 7
//! rank 1            4 5 | 6 7 8 9 10 | 11 12
//! rank 2                  9 10 | 11 12 13 14 15 | wall
//! ```
//!
//! The grid of a rank has the copies among its cells and ends there as at a wall: rows of copies are computed as all others, with what is wrong
//! where they would read further, and [`borders`](crate::field::borders) overwrites them by what their owner has. Nothing that is the rank's own
//! reads further than the copies reach.

use super::{Axis, Boundary, Grid, Part, Share};
use core::ops::Range;

/// Planes on either side that a rank has copies of: as far as transport reads.
pub const REACH: usize = 2;
/// The fewest planes of a rank: its neighbours' copies are of nobody else.
pub const THINNEST: usize = REACH;

/// `total` cut into pieces of `unit`, of which a rank has about as many as another.
pub fn cut(total: usize, unit: usize, rank: usize, ranks: usize) -> Range<usize> {
    let pieces = total.div_ceil(unit.max(1));
    let begin = |rank: usize| (pieces * rank / ranks.max(1) * unit).min(total);
    begin(rank)..begin(rank + 1)
}

impl Part {
    /// The planes of the whole box that a rank has.
    fn of(self, rank: usize) -> Range<usize> {
        cut(self.planes, 1, rank, self.share.ranks)
    }

    /// Whether another rank's planes lie below and above those of this one.
    fn beside(self) -> [bool; 2] {
        let Share { rank, ranks } = self.share;
        let ring = Axis::new(self.planes, self.ends).is_ring();
        [ring || rank > 0, ring || rank + 1 < ranks]
    }
}

impl Grid {
    /// The part of a box that one of several ranks has; all of it where there is but one.
    #[must_use]
    pub fn shared(self, share: Option<Share>) -> Self {
        let Some(share) = share.filter(|share| share.ranks > 1) else {
            return self;
        };
        let last = self.dims - 1;
        let part = Part {
            share,
            planes: self.n[last],
            ends: self.ends[last],
        };
        let mut own = Self {
            part: Some(part),
            ..self
        };
        let copies = part.beside().map(|beside| REACH * usize::from(beside));
        own.n[last] = part.of(share.rank).len() + copies[0] + copies[1];
        own.ends[last] = Boundary::Wall;
        own
    }

    /// Whether other ranks have other parts of the box.
    #[inline]
    #[must_use]
    pub fn is_part(&self) -> bool {
        self.part.is_some()
    }

    /// Which part this is, where other ranks have others.
    #[must_use]
    pub fn share(&self) -> Option<Share> {
        self.part.map(|part| part.share)
    }

    /// The whole box.
    #[must_use]
    pub fn whole(&self) -> Self {
        let Some(part) = self.part else { return *self };
        let mut whole = Self { part: None, ..*self };
        (whole.n[self.dims - 1], whole.ends[self.dims - 1]) = (part.planes, part.ends);
        whole
    }

    /// Axis 0, 1 or 2 of the whole box.
    #[inline]
    #[must_use]
    pub fn whole_axis(&self, axis: usize) -> Axis {
        match self.part {
            Some(part) if axis == self.dims - 1 => Axis::new(part.planes, part.ends),
            _ => self.axis(axis),
        }
    }

    /// The planes of the whole box that a rank has.
    #[must_use]
    pub fn planes_of(&self, rank: usize) -> Range<usize> {
        match self.part {
            Some(part) => part.of(rank),
            None => 0..self.planes(),
        }
    }

    /// The planes of this grid that are no copies.
    #[must_use]
    pub fn own_planes(&self) -> Range<usize> {
        let Some(part) = self.part else {
            return 0..self.planes();
        };
        let begin = REACH * usize::from(part.beside()[0]);
        begin..begin + part.of(part.share.rank).len()
    }

    /// The rows of this grid that are no copies.
    #[must_use]
    pub fn own_rows(&self) -> Range<usize> {
        if self.part.is_none() {
            return 0..self.rows();
        }
        let (planes, rows) = (self.own_planes(), self.rows_per_plane());
        planes.start * rows..planes.end * rows
    }

    /// Where the first plane of this grid lies in the whole box, if that is an axis' own: 0 along others. Below 0 on a ring.
    #[inline]
    #[must_use]
    pub fn first_plane(&self, axis: usize) -> isize {
        let Some(part) = self.part.filter(|_| axis == self.dims - 1) else {
            return 0;
        };
        part.of(part.share.rank).start as isize - self.own_planes().start as isize
    }

    /// The rank that has the planes below those of this one, and the rank that has those above.
    #[must_use]
    pub fn neighbours(&self) -> [Option<usize>; 2] {
        let Some(part) = self.part else { return [None; 2] };
        let Share { rank, ranks } = part.share;
        let [below, above] = part.beside();
        [
            below.then(|| (rank + ranks - 1) % ranks),
            above.then(|| (rank + 1) % ranks),
        ]
    }
}
