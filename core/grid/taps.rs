//! How fields pass between two neighbouring grids of a hierarchy, axis by axis: which values of one make a value of the other,
//! and with which weights.
//!
//! Where an axis halves the weights are the textbook ones (Trottenberg, Oosterlee & Schueller, Multigrid, section 2.3): the mean
//! of two cells; injection and the mean of two along a face's own axis; 3/4 and 1/4 across it. Where n is odd, coarse cells do
//! not end where fine ones do, and the weights come from the same piecewise linear functions. Behind a wall stands the last
//! cell before it. Faces on walls, where nothing flows, have no taps and are no sources.

use super::{Axis, Boundary};
use core::ops::Range;

/// Which values of one grid make a value of the other along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// Coarse cell from fine cells: the mean over its extent.
    RestrictCell,
    /// Coarse face from the fine faces around its place along its own axis.
    RestrictFace,
    /// Fine cell from coarse cells: linear; constant at walls.
    ProlongCell,
    /// Fine face from coarse faces along its own axis: linear.
    ProlongFace,
    /// The transpose of [`Transfer::ProlongCell`], times the ratio of the cell counts.
    CollectCell,
    /// The transpose of [`Transfer::ProlongFace`], times the ratio of the cell counts.
    CollectFace,
}

/// All transfers, in their order.
pub const TRANSFERS: [Transfer; 6] = [
    Transfer::RestrictCell,
    Transfer::RestrictFace,
    Transfer::ProlongCell,
    Transfer::ProlongFace,
    Transfer::CollectCell,
    Transfer::CollectFace,
];

/// The most taps that a value has.
pub const TAPS: usize = 5;

impl Transfer {
    /// The most taps that a value has in this transfer.
    #[must_use]
    pub const fn taps(self) -> usize {
        match self {
            Self::RestrictCell => 3,
            Self::CollectCell | Self::CollectFace => TAPS,
            _ => 2,
        }
    }

    /// Whether it makes values of the finer grid.
    pub(super) const fn to_finer(self) -> bool {
        matches!(self, Self::ProlongCell | Self::ProlongFace)
    }

    /// The offset of the first source of value `i` along an axis that halves, from 2 i, or from i / 2 rounded up in a transfer to the
    /// finer grid.
    pub(super) const fn first(self) -> isize {
        if matches!(self, Self::RestrictCell | Self::RestrictFace) {
            0
        } else {
            -1
        }
    }

    /// The values along an axis that it makes.
    pub(super) const fn length(self, fine: usize, coarse: usize) -> usize {
        if self.to_finer() { fine } else { coarse }
    }
}

/// The taps of one value: positions of sources and their weights.
pub type Taps = heapless::Vec<(usize, f64), TAPS>;

/// The part of an axis inside the box, between walls or as a ring, and which of its ends are faces that belong to the flow.
#[derive(Clone, Copy)]
struct Line {
    axis: Axis,
    /// Number of its first cell on the axis.
    first: usize,
    open: [bool; 2],
}

impl Line {
    fn new(axis: Axis) -> Self {
        let Range { start, end } = axis.inside();
        let ends = if axis.is_ring() {
            Boundary::Periodic
        } else {
            Boundary::Wall
        };
        Self {
            axis: Axis::new(end - start, ends),
            first: start,
            open: [start > 0, end < axis.cells()],
        }
    }

    fn cells(self) -> usize {
        self.axis.cells()
    }

    /// The face at index `i`, or `None` where nothing flows.
    fn face(self, i: isize) -> Option<usize> {
        let [low, high] = self.open;
        match usize::try_from(i) {
            Ok(0) if low => Some(0),
            Ok(end) if high && end == self.cells() => Some(end),
            _ => self.axis.open_face(i),
        }
    }
}

/// The taps of value `i` that `transfer` makes between an axis of the finer grid and that of the coarser. A cell outside an open side
/// becomes the one outside the coarser grid, and nothing else comes of it.
#[must_use]
pub fn taps(transfer: Transfer, i: usize, fine: Axis, coarse: Axis) -> Taps {
    let (from, to) = if transfer.to_finer() {
        (coarse, fine)
    } else {
        (fine, coarse)
    };
    let [of_fine, of_coarse] = [fine, coarse].map(Line::new);
    let [source, target] = [from, to].map(Line::new);
    let is_face = matches!(
        transfer,
        Transfer::RestrictFace | Transfer::ProlongFace | Transfer::CollectFace
    );
    let ends = target.first + target.cells() + usize::from(is_face && target.open[1]);
    let mut list = Taps::new();
    if (target.first..ends).contains(&i) {
        inside(transfer, i - target.first, of_fine, of_coarse, &mut list);
        list.iter_mut().for_each(|(at, _)| *at += source.first);
    } else if transfer == Transfer::RestrictCell {
        put(&mut list, Some(if i == 0 { 0 } else { from.cells() - 1 }), 1.0);
    }
    list
}

/// [`taps`] in numbers of cells and faces inside.
fn inside(transfer: Transfer, i: usize, fine: Line, coarse: Line, list: &mut Taps) {
    let ratio = fine.cells() as f64 / coarse.cells() as f64;
    let cell = |line: Line| move |at: isize| Some(line.axis.nearest(at));
    let face = |line: Line| move |at: isize| line.face(at);
    match transfer {
        Transfer::RestrictCell => mean(i, fine.axis, ratio, list),
        Transfer::RestrictFace => linear(i as f64 * ratio, face(fine), list),
        Transfer::ProlongCell => linear((i as f64 + 0.5) / ratio - 0.5, cell(coarse), list),
        Transfer::ProlongFace => linear(i as f64 / ratio, face(coarse), list),
        Transfer::CollectCell => collect(Transfer::ProlongCell, i, fine, coarse, list),
        Transfer::CollectFace => collect(Transfer::ProlongFace, i, fine, coarse, list),
    }
}

/// Adds a tap, unless its weight is rounding error; taps of one source are joined.
fn put(list: &mut Taps, source: Option<usize>, weight: f64) {
    let Some(at) = source.filter(|_| weight.abs() >= 1e-12) else {
        return;
    };
    match list.iter_mut().find(|(have, _)| *have == at) {
        Some((_, have)) => *have += weight,
        None => {
            let pushed = list.push((at, weight));
            debug_assert!(pushed.is_ok());
        }
    }
}

/// The fine cells that lie in coarse cell `i`, which is as long as `ratio` of them, and the parts of it that they fill.
fn mean(i: usize, fine: Axis, ratio: f64, list: &mut Taps) {
    let (start, end) = (i as f64 * ratio, (i + 1) as f64 * ratio);
    for cell in libm::floor(start + 1e-9) as usize..fine.cells().min(libm::ceil(end - 1e-9) as usize) {
        let filled = end.min(cell as f64 + 1.0) - start.max(cell as f64);
        put(list, Some(cell), filled / ratio);
    }
}

/// The two values around `place` and their weights.
fn linear(place: f64, source: impl Fn(isize) -> Option<usize>, list: &mut Taps) {
    let low = libm::floor(place + 1e-9);
    let t = (place - low).max(0.0);
    put(list, source(low as isize), 1.0 - t);
    put(list, source(low as isize + 1), t);
}

/// Row `i` of the transpose of `transfer`, times coarse / fine.
fn collect(transfer: Transfer, i: usize, fine: Line, coarse: Line, list: &mut Taps) {
    let centre = i * fine.cells() / coarse.cells();
    let mut seen: heapless::Vec<usize, 16> = heapless::Vec::new();
    for offset in -4..=5isize {
        let Some(f) = fine
            .axis
            .cell(centre as isize + offset)
            .filter(|f| !seen.contains(f))
        else {
            continue;
        };
        let _ = seen.push(f);
        let mut taps = Taps::new();
        inside(transfer, f, fine, coarse, &mut taps);
        let weight: f64 = taps.iter().filter(|(c, _)| *c == i).map(|(_, w)| w).sum();
        if weight != 0.0 {
            let pushed = list.push((f, weight * coarse.cells() as f64 / fine.cells() as f64));
            debug_assert!(pushed.is_ok());
        }
    }
}
