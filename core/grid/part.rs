//! A box that several ranks share: each has a slab of it, planes normal to the last axis, and copies of the planes beside ([`Part`]).
//!
//! The grid of a rank has the copies among its cells and ends there as at a wall: rows of copies are computed as all others, with what is wrong
//! where they would read further, and [`borders`](crate::field::borders) overwrites them by what their owner has. Nothing that is the rank's own
//! reads further than the copies reach. Layers outside of open ends are among the planes of the first and the last rank.

use super::{Axis, Boundary, Grid, Part, Share, Side};
use crate::exec::ranks::{Ranks, refresh, tell};
use crate::memory::part::slab;
use crate::memory::{Held, Plain};
use core::ops::Range;

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
            ring: self.axis(last).is_ring(),
            layers: self.layers_at_ends(),
        };
        let mut own = Self {
            part: Some(part),
            ..self
        };
        own.n[last] = part.held();
        own.ends[last] = Boundary::Wall;
        own
    }

    /// Layers outside the box at the ends of the last axis.
    fn layers_at_ends(&self) -> [usize; 2] {
        [Side::Low, Side::High].map(|side| self.layers(self.dims - 1, side))
    }

    /// Whether other ranks have other parts of the box.
    #[inline]
    #[must_use]
    pub fn is_part(&self) -> bool {
        self.part.is_some()
    }

    /// Which part this is, where other ranks have others.
    #[must_use]
    pub fn part(&self) -> Option<Part> {
        self.part
    }

    /// The whole box.
    #[must_use]
    pub fn whole(&self) -> Self {
        let Some(part) = self.part else { return *self };
        let mut whole = Self { part: None, ..*self };
        (whole.n[self.dims - 1], whole.ends[self.dims - 1]) = (part.planes, ends(part));
        whole
    }

    /// Axis 0, 1 or 2 of the whole box.
    #[inline]
    #[must_use]
    pub fn whole_axis(&self, axis: usize) -> Axis {
        match self.part {
            Some(part) if axis == self.dims - 1 => Axis::new(part.planes, ends(part)),
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
        self.part.map_or(0..self.planes(), Part::own)
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

    /// Where planes of the whole box would be in this grid, as far as they are, copies among them.
    pub(super) fn planes_here(&self, planes: Range<usize>) -> Range<usize> {
        let last = self.dims - 1;
        let here =
            |plane: usize| (plane as isize - self.first_plane(last)).clamp(0, self.n[last] as isize) as usize;
        here(planes.start)..here(planes.end)
    }

    /// Where the first plane of this grid lies in the whole box, if that is an axis' own: 0 along others. Below 0 on a ring.
    #[inline]
    #[must_use]
    pub fn first_plane(&self, axis: usize) -> isize {
        let Some(part) = self.part.filter(|_| axis == self.dims - 1) else {
            return 0;
        };
        part.of(part.share.rank).start as isize - part.own().start as isize
    }

    /// Which value along an axis of the whole box value `i` of this grid is.
    #[inline]
    #[must_use]
    pub fn in_whole(&self, axis: usize, i: usize) -> usize {
        if self.part.is_none() {
            return i;
        }
        let cells = self.whole_axis(axis).cells().max(1) as isize;
        (self.first_plane(axis) + i as isize).rem_euclid(cells) as usize
    }

    /// Where value `i` along an axis of the whole box is in this grid, if it is: on a ring the copy that is nearest to the rank's own planes, since a rank
    /// may have two of one plane.
    #[must_use]
    pub fn here(&self, axis: usize, i: usize) -> Option<usize> {
        let Some(part) = self.part.filter(|_| axis == self.dims - 1) else {
            return Some(i);
        };
        let (own, planes) = (part.own(), part.planes as isize);
        let mut at = i as isize - self.first_plane(axis);
        if part.ring {
            let above = (at - own.start as isize).rem_euclid(planes.max(1));
            let is_nearer_below = planes - above < above + 1 - own.len() as isize;
            at = own.start as isize + above - if is_nearer_below { planes } else { 0 };
        }
        usize::try_from(at).ok().filter(|&at| at < self.n[axis])
    }
}

/// Brings a field up to date that was passed from grid `source` to grid `target`, of the faces of `axis` or of cells: the copies of its neighbours' planes; or
/// where a rank has all of the coarser grid and a part of the finer one, what the others have [made](made_here).
pub fn settle<P: Plain + Default>(
    ranks: &dyn Ranks,
    [source, target]: [&Grid; 2],
    axis: Option<usize>,
    field: &mut [P],
) {
    let (Some(part), None) = (source.part(), target.part()) else {
        return refresh(ranks, Held::of(target.part(), target.dims, axis), field);
    };
    let plane = field.len() / target.planes().max(1);
    for rank in 0..part.share.ranks {
        let planes = made_by(target, rank, part.share.ranks);
        if let Some(made) = field.get_mut(planes.start * plane..planes.end * plane) {
            tell(ranks, rank, made);
        }
    }
}

/// The planes of `target` that this rank makes of what it has of `source`.
#[must_use]
pub fn made_here(source: &Grid, target: &Grid) -> Range<usize> {
    match (source.part(), target.part()) {
        (Some(part), None) => made_by(target, part.share.rank, part.share.ranks),
        _ => target.own_planes(),
    }
}

/// The planes of a grid that all ranks have which one of them makes of its part of a finer grid.
fn made_by(whole: &Grid, rank: usize, ranks: usize) -> Range<usize> {
    slab(whole.planes(), whole.layers_at_ends(), rank, ranks)
}

/// How the last axis of a box that ranks share ends.
fn ends(part: Part) -> Boundary {
    match part.layers {
        _ if part.ring => Boundary::Periodic,
        [0, 0] => Boundary::Wall,
        [_, 0] => Boundary::OpenLow,
        [0, _] => Boundary::OpenHigh,
        _ => Boundary::Open,
    }
}
