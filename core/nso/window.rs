//! Which fine planes some coarse planes collect residuals from, and with which weights.

use crate::exec::Planes;
use crate::grid::Grid;
use crate::grid::tables::Tables;
use crate::grid::taps::Transfer;
use crate::real::Real;
use core::ops::Range;

/// The most fine planes that a coarse plane collects from, and whose residuals are stored at the same time.
pub(super) const NEAR: usize = 8;

/// The fine planes that some coarse planes collect from, stored in a ring of places. Planes before 0 and
/// behind the last are those on the other side of a periodic axis.
pub(super) struct Window {
    /// Behind the last coarse plane.
    pub(super) end: usize,
    pub(super) fine: Range<isize>,
    /// Fine planes in all.
    planes: usize,
    /// Places of the ring.
    pub(super) room: usize,
}

impl Window {
    /// As many of these coarse planes, from the first on, as need at most `room` fine ones, but at least one.
    pub(super) fn new<T: Real>(
        tables: &Tables<'_, T>,
        fine: &Grid,
        coarse: &Grid,
        coarse_planes: Range<usize>,
        room: usize,
    ) -> Self {
        let planes = fine.planes();
        let start = coarse_planes.start;
        let is_ring = fine.axis(fine.dims - 1).is_ring();
        let centre = |plane: usize| {
            if is_ring {
                plane * planes / coarse.planes()
            } else {
                0
            }
        };
        let mut window = Self {
            end: start,
            fine: 0..0,
            planes,
            room,
        };
        let (mut low, mut high) = (isize::MAX, isize::MIN);
        while window.end < coarse_planes.end {
            for (plane, _) in near(tables, fine.dims - 1, window.end) {
                // On a ring the steps from the middle of its coarse plane, the shorter way around.
                let steps = if is_ring {
                    ((plane + planes + planes / 2 - centre(window.end)) % planes) as isize
                        - (planes / 2) as isize
                } else {
                    plane as isize
                };
                let from_start = steps + (centre(window.end) - centre(start)) as isize;
                (low, high) = (low.min(from_start), high.max(from_start));
            }
            let count = planes.min((high - low + 1) as usize);
            if !window.fine.is_empty() && count > room {
                break;
            }
            let first = centre(start) as isize + low;
            window = Self {
                end: window.end + 1,
                fine: first..first + count as isize,
                ..window
            };
        }
        debug_assert!(window.fine.len() <= room);
        window
    }

    /// The fine planes that are not in the ring yet, which holds the last ones before `known`.
    pub(super) fn fresh(&self, known: isize) -> Range<isize> {
        known.max(self.fine.start).min(self.fine.end)..self.fine.end
    }

    /// The places of some of the fine planes.
    pub(super) fn places(&self, fine: &Range<isize>) -> Planes {
        Planes {
            count: fine.len(),
            first: around(fine.start, self.room),
            size: self.room,
            offset: 0,
        }
    }

    /// Which of some fine planes is at a place.
    pub(super) fn plane_at(&self, fine: &Range<isize>, place: usize) -> usize {
        around(
            fine.start + around(place as isize - fine.start, self.room) as isize,
            self.planes,
        )
    }

    /// The place of a fine plane.
    pub(super) fn place(&self, plane: usize) -> usize {
        around(
            self.fine.start + around(plane as isize - self.fine.start, self.planes) as isize,
            self.room,
        )
    }
}

/// `i` modulo `count`.
fn around(i: isize, count: usize) -> usize {
    i.rem_euclid(count as isize) as usize
}

/// A fine row near a coarse one along one axis, with the weights of cells, of faces across and of faces along
/// the axis.
pub(super) type Near<T> = heapless::Vec<(usize, [T; 3]), NEAR>;

/// The weights of a [`Near`], in order.
const KINDS: [Transfer; 3] = [
    Transfer::RestrictCell,
    Transfer::CollectCell,
    Transfer::CollectFace,
];

/// The fine rows near coarse row `i` along an axis.
pub(super) fn near<T: Real>(tables: &Tables<'_, T>, axis: usize, i: usize) -> Near<T> {
    let mut list: Near<T> = heapless::Vec::new();
    for (kind, &transfer) in KINDS.iter().enumerate() {
        for (at, weight) in tables.taps(axis, transfer, i) {
            match list.iter_mut().find(|(have, _)| *have == at) {
                Some((_, weights)) => weights[kind] = weight,
                None => {
                    let mut weights = [T::ZERO; 3];
                    weights[kind] = weight;
                    let pushed = list.push((at, weights));
                    debug_assert!(pushed.is_ok());
                }
            }
        }
    }
    list
}
