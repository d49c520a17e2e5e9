//! A box that several ranks share: each has a slab of it, planes normal to the last axis, or a block, some rows of some planes, and copies of the planes and
//! the rows beside ([`Parts`]).
//!
//! The grid of a rank has the copies among its cells and ends there as at a wall: rows of copies are computed as all others, with what is wrong
//! where they would read further, and [`borders`](crate::field::borders) overwrites them by what their owner has. Nothing that is the rank's own
//! reads further than the copies reach. Layers outside of open ends are among the planes, or rows, of the first and the last rank.

use super::{Axis, Boundary, Grid, Parts, Share, Side};
use crate::exec::ranks::{Along, Ranks, refresh, tell};
use crate::memory::part::{Cut, Line, Part, Strips, Whole, slab};
use crate::memory::{Held, Plain};
use core::ops::Range;

impl Grid {
    /// The part of a box that one of several ranks has; all of it where there is but one.
    #[must_use]
    pub fn shared(self, share: Option<Share>) -> Self {
        let Some(share) = share.filter(|share| share.ranks > 1) else {
            return self;
        };
        let whole = |before: usize| {
            let axis = self.dims - before.min(self.dims);
            let line = self.axis(axis);
            Whole::new(line.cells(), line.is_ring(), self.layers_at_ends(axis))
        };
        let mut own = Self {
            cut: Some(Cut::new(share, [whole(1), whole(2)])),
            ..self
        };
        for axis in 0..self.dims {
            if let Some(part) = own.part_along(axis) {
                (own.n[axis], own.ends[axis]) = (part.held(), Boundary::Wall);
            }
        }
        own
    }

    /// Layers outside the box at the ends of an axis.
    fn layers_at_ends(&self, axis: usize) -> [usize; 2] {
        [Side::Low, Side::High].map(|side| self.layers(axis, side))
    }

    /// Whether other ranks have other parts of the box.
    #[inline]
    #[must_use]
    pub fn is_part(&self) -> bool {
        self.cut.is_some()
    }

    /// Which parts this one has, where other ranks have others.
    #[inline]
    #[must_use]
    pub fn parts(&self) -> Option<Parts> {
        self.cut.map(Cut::parts)
    }

    /// Which part of an axis this is, where other ranks have others.
    #[inline]
    #[must_use]
    pub fn part_along(&self, axis: usize) -> Option<Part> {
        let cut = self.cut?;
        match self.dims - axis.min(self.dims) {
            1 => Some(cut.planes()),
            2 => cut.rows(),
            _ => None,
        }
    }

    /// The whole box.
    #[must_use]
    pub fn whole(&self) -> Self {
        if self.cut.is_none() {
            return *self;
        }
        let mut whole = Self { cut: None, ..*self };
        for axis in 0..self.dims {
            let line = self.whole_axis(axis);
            (whole.n[axis], whole.ends[axis]) = (line.cells(), line.ends());
        }
        whole
    }

    /// Axis 0, 1 or 2 of the whole box.
    #[inline]
    #[must_use]
    pub fn whole_axis(&self, axis: usize) -> Axis {
        match self.part_along(axis) {
            Some(part) => Axis::new(part.planes, ends(part)),
            None => self.axis(axis),
        }
    }

    /// What a rank has along an axis of the whole box.
    #[must_use]
    pub fn of_rank(&self, axis: usize, rank: usize) -> Range<usize> {
        match self.part_along(axis) {
            Some(part) => part.of(rank / part.line.apart % part.line.count.max(1)),
            None => 0..self.n[axis],
        }
    }

    /// What this grid has along an axis that are no copies.
    #[must_use]
    pub fn own(&self, axis: usize) -> Range<usize> {
        self.part_along(axis).map_or(0..self.n[axis], Part::own)
    }

    /// The planes of this grid that are no copies.
    #[must_use]
    pub fn own_planes(&self) -> Range<usize> {
        self.own(self.dims - 1)
    }

    /// The rows of a plane of this grid that are no copies within it.
    #[inline]
    #[must_use]
    pub fn own_rows(&self, plane: usize) -> Range<usize> {
        let rows = self.rows_per_plane();
        let own = if self.dims == 3 { self.own(1) } else { 0..rows };
        plane * rows + own.start..plane * rows + own.end
    }

    /// Whether a row of this grid is no copy.
    #[must_use]
    pub fn is_own(&self, row: usize) -> bool {
        let [plane, _] = self.plane_of(row);
        self.own_planes().contains(&plane) && self.own_rows(plane).contains(&row)
    }

    /// Where a range along an axis of the whole box would be in this grid, as far as it is, copies among it.
    pub(super) fn range_here(&self, axis: usize, range: Range<usize>) -> Range<usize> {
        let first = self.first(axis);
        let here = |place: usize| (place as isize - first).clamp(0, self.n[axis] as isize) as usize;
        here(range.start)..here(range.end)
    }

    /// Where this grid begins along an axis of the whole box. Below 0 on a ring.
    #[inline]
    #[must_use]
    pub fn first(&self, axis: usize) -> isize {
        let Some(part) = self.part_along(axis) else {
            return 0;
        };
        part.of(part.line.place).start as isize - part.own().start as isize
    }

    /// Which value along an axis of the whole box value `i` of this grid is.
    #[inline]
    #[must_use]
    pub fn in_whole(&self, axis: usize, i: usize) -> usize {
        if self.cut.is_none() {
            return i;
        }
        let cells = self.whole_axis(axis).cells().max(1) as isize;
        (self.first(axis) + i as isize).rem_euclid(cells) as usize
    }

    /// Where value `i` along an axis of the whole box is in this grid, if it is: on a ring the copy that is nearest to the rank's own, since a rank
    /// may have two of one plane.
    #[must_use]
    pub fn here(&self, axis: usize, i: usize) -> Option<usize> {
        let Some(part) = self.part_along(axis) else {
            return Some(i);
        };
        let (own, planes) = (part.own(), part.planes as isize);
        let mut at = i as isize - self.first(axis);
        if part.ring {
            let above = (at - own.start as isize).rem_euclid(planes.max(1));
            let is_nearer_below = planes - above < above + 1 - own.len() as isize;
            at = own.start as isize + above - if is_nearer_below { planes } else { 0 };
        }
        usize::try_from(at).ok().filter(|&at| at < self.n[axis])
    }
}

/// Brings a field up to date that was passed from grid `source` to grid `target`, of the faces of `axis` or of cells: the copies of what its neighbours have;
/// or where a rank has all of the coarser grid and a part of the finer one, what the others have [made](made_here).
pub fn settle<P: Plain + Default>(
    ranks: &dyn Ranks,
    [source, target]: [&Grid; 2],
    axis: Option<usize>,
    field: &mut [P],
) {
    let (Some(parts), None) = (source.parts(), target.parts()) else {
        return refresh(ranks, Held::of(target.parts(), target.dims, axis), field);
    };
    let plane = field.len() / target.planes().max(1);
    // First the rows of the planes that this rank and those beside it made, then the planes.
    if parts.rows.is_some() {
        let rows = target.rows_per_plane();
        let (line, made) = (parts.share.along_rows(), made_here(source, target));
        for place in 0..line.count {
            let theirs = made_by(target, target.dims - 2, place, line);
            for strip in Strips::of(made.clone(), [theirs, 0..rows], plane / rows.max(1)).ranges() {
                if let Some(made) = field.get_mut(strip) {
                    tell(&Along::new(ranks, line), place, made);
                }
            }
        }
    }
    let line = parts.share.along_planes();
    for place in 0..line.count {
        let planes = made_by(target, target.dims - 1, place, line);
        if let Some(made) = field.get_mut(planes.start * plane..planes.end * plane) {
            tell(&Along::new(ranks, line), place, made);
        }
    }
}

/// The planes of `target` that this rank makes of what it has of `source`, or those of which it makes some rows.
#[must_use]
pub fn made_here(source: &Grid, target: &Grid) -> Range<usize> {
    match (source.parts(), target.parts()) {
        (Some(parts), None) => {
            let line = parts.share.along_planes();
            made_by(target, target.dims - 1, line.place, line)
        }
        _ => target.own_planes(),
    }
}

/// What one rank of a line makes along an axis of a grid that all ranks have, of its part of a finer one.
fn made_by(whole: &Grid, axis: usize, place: usize, line: Line) -> Range<usize> {
    slab(whole.n[axis], whole.layers_at_ends(axis), place, line.count)
}

/// How an axis ends that ranks share.
fn ends(part: Part) -> Boundary {
    match part.layers {
        _ if part.ring => Boundary::Periodic,
        [0, 0] => Boundary::Wall,
        [_, 0] => Boundary::OpenLow,
        [0, _] => Boundary::OpenHigh,
        _ => Boundary::Open,
    }
}
