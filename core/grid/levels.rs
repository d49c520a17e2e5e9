//! Coarser grids and how fields pass between two of them, axis by axis.
//!
//! An axis of n > 2 cells coarsens to n / 2, and where n is odd to the even one of the two numbers beside it, so that the next
//! grid halves exactly (5 coarsens to 3: two cells would be too few). Where n is odd, coarse cells do not end where fine ones
//! do; the weights below then come from the same piecewise linear functions as for even n, for which they are the textbook
//! ones: mean of two; injection and mean of two along a face's own axis; 3/4 and 1/4 across it.

use super::Grid;
use super::spectrum::Spectrum;
use crate::memory::Ledger;
use crate::memory::{Arena, TooSmall};
use crate::real::Real;
use crate::simd::multiversion;
use core::ops::Range;

/// Most levels: 4096 cells halve eleven times.
pub const MAX_LEVELS: usize = 12;

/// The next coarser grid, or `None` when no axis has more than two cells.
#[must_use]
pub fn coarsen(grid: &Grid) -> Option<Grid> {
    let n = grid.n.map(|n| {
        if n > 2 {
            n.div_ceil(2) - usize::from(n % 4 == 1 && n > 5)
        } else {
            n
        }
    });
    let h = core::array::from_fn(|a| grid.h[a] * grid.n[a] as f64 / n[a] as f64);
    (n != grid.n).then_some(Grid { n, h, ..*grid })
}

/// The grids of a hierarchy, finest first.
#[must_use]
pub fn hierarchy(finest: &Grid) -> heapless::Vec<Grid, MAX_LEVELS> {
    core::iter::successors(Some(*finest), coarsen)
        .take(MAX_LEVELS)
        .collect()
}

/// Where a number of one axis comes from.
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

/// All transfers, in the order of [`Tables`].
pub const TRANSFERS: [Transfer; 6] = [
    Transfer::RestrictCell,
    Transfer::RestrictFace,
    Transfer::ProlongCell,
    Transfer::ProlongFace,
    Transfer::CollectCell,
    Transfer::CollectFace,
];

/// Most sources of one number.
pub const TAPS: usize = 5;

impl Transfer {
    /// Most sources of one number of this transfer.
    #[must_use]
    pub const fn taps(self) -> usize {
        match self {
            Self::RestrictCell => 3,
            Self::CollectCell | Self::CollectFace => TAPS,
            _ => 2,
        }
    }

    /// Whether it makes fine numbers from coarse ones.
    const fn to_finer(self) -> bool {
        matches!(self, Self::ProlongCell | Self::ProlongFace)
    }

    /// Where, from 2i (or, from coarse to fine, from i / 2 rounded up), the first source of number `i` is on an axis that halves.
    const fn first(self) -> isize {
        if matches!(self, Self::RestrictCell | Self::RestrictFace) {
            0
        } else {
            -1
        }
    }

    /// Numbers along an axis of what it makes.
    const fn length(self, fine: usize, coarse: usize) -> usize {
        if self.to_finer() { fine } else { coarse }
    }
}

/// The sources of one number: positions and weights.
pub type Taps = heapless::Vec<(usize, f64), TAPS>;

/// The sources of number `i` of an axis that has `fine` cells on the finer grid and `coarse` on the coarser.
#[must_use]
pub fn taps(transfer: Transfer, i: usize, fine: usize, coarse: usize, periodic: bool) -> Taps {
    let ratio = fine as f64 / coarse as f64;
    let mut list = Taps::new();
    let mut put = |at: isize, weight: f64, n: usize, wall_face: bool| {
        let outside = at < 0 || at >= n as isize;
        if weight.abs() < 1e-12 || (wall_face && !periodic && (outside || at == 0)) {
            return;
        }
        let at = if periodic {
            at.rem_euclid(n as isize)
        } else {
            at.clamp(0, n as isize - 1)
        } as usize;
        match list.iter_mut().find(|(have, _)| *have == at) {
            Some((_, have)) => *have += weight,
            None => {
                let pushed = list.push((at, weight));
                debug_assert!(pushed.is_ok());
            }
        }
    };
    match transfer {
        Transfer::RestrictCell => {
            let (start, end) = (i as f64 * ratio, (i + 1) as f64 * ratio);
            for f in libm::floor(start + 1e-9) as usize..fine.min(libm::ceil(end - 1e-9) as usize) {
                put(
                    f as isize,
                    (end.min(f as f64 + 1.0) - start.max(f as f64)) / ratio,
                    fine,
                    false,
                );
            }
        }
        Transfer::RestrictFace => linear(i as f64 * ratio, |at, w| put(at, w, fine, true)),
        Transfer::ProlongCell => linear((i as f64 + 0.5) / ratio - 0.5, |at, w| put(at, w, coarse, false)),
        Transfer::ProlongFace => linear(i as f64 / ratio, |at, w| put(at, w, coarse, true)),
        Transfer::CollectCell => collect(Transfer::ProlongCell, i, fine, coarse, periodic, &mut list),
        Transfer::CollectFace => collect(Transfer::ProlongFace, i, fine, coarse, periodic, &mut list),
    }
    list
}

/// The two neighbours of a place and their weights.
fn linear(place: f64, mut put: impl FnMut(isize, f64)) {
    let low = libm::floor(place + 1e-9);
    let t = (place - low).max(0.0);
    put(low as isize, 1.0 - t);
    put(low as isize + 1, t);
}

/// Row `i` of the transpose of `transfer`, times coarse / fine.
fn collect(transfer: Transfer, i: usize, fine: usize, coarse: usize, periodic: bool, list: &mut Taps) {
    let centre = i * fine / coarse;
    let mut seen: heapless::Vec<usize, 16> = heapless::Vec::new();
    for offset in -4..=5isize {
        let at = centre as isize + offset;
        let f = if periodic {
            at.rem_euclid(fine as isize)
        } else {
            at
        } as usize;
        if (!periodic && (at < 0 || at >= fine as isize)) || seen.contains(&f) {
            continue;
        }
        let _ = seen.push(f);
        let weight: f64 = taps(transfer, f, fine, coarse, periodic)
            .iter()
            .filter(|(c, _)| *c == i)
            .map(|(_, w)| w)
            .sum();
        if weight != 0.0 {
            let pushed = list.push((f, weight * coarse as f64 / fine as f64));
            debug_assert!(pushed.is_ok());
        }
    }
}

/// The taps of all transfers between two grids, looked up by axis, transfer and position.
#[derive(Debug)]
pub struct Tables<'m, T> {
    index: &'m mut [u16],
    weight: &'m mut [T],
    start: [[usize; TRANSFERS.len()]; 3],
    length: [[usize; TRANSFERS.len()]; 3],
    /// Whether x has walls and half as many coarse cells: then the sources of a number are side by side, in the order of their taps.
    halves: bool,
}

impl<'m, T: Real> Tables<'m, T> {
    /// Taps that the tables between `fine` and `coarse` hold.
    #[must_use]
    pub fn len(fine: &Grid, coarse: &Grid) -> usize {
        let along = |a: usize| {
            TRANSFERS
                .iter()
                .map(|transfer| transfer.taps() * transfer.length(fine.n[a], coarse.n[a]))
                .sum::<usize>()
        };
        (0..fine.dims).map(along).sum()
    }

    /// Fills `index` and `weight`, of [`Self::len`] each.
    #[must_use]
    pub fn new(fine: &Grid, coarse: &Grid, index: &'m mut [u16], weight: &'m mut [T]) -> Self {
        let halves = fine.n[0] == 2 * coarse.n[0] && !fine.periodic[0];
        let mut tables = Self {
            index,
            weight,
            start: Default::default(),
            length: Default::default(),
            halves,
        };
        let mut next = 0;
        for a in 0..fine.dims {
            for (t, &transfer) in TRANSFERS.iter().enumerate() {
                let length = transfer.length(fine.n[a], coarse.n[a]);
                tables.start[a][t] = next;
                tables.length[a][t] = length;
                for i in 0..length {
                    let list = taps(transfer, i, fine.n[a], coarse.n[a], fine.periodic[a]);
                    for (slot, &(at, weight)) in list.iter().enumerate() {
                        let slot = if a == 0 && halves {
                            at.wrapping_sub(side_by_side(transfer, i))
                        } else {
                            slot
                        };
                        tables.index[next + slot * length + i] = at as u16;
                        tables.weight[next + slot * length + i] = T::from_f64(weight);
                    }
                }
                next += transfer.taps() * length;
            }
        }
        tables
    }

    /// The sources of number `i` along `axis`, those of weight 0 left out.
    pub fn taps(&self, axis: usize, transfer: Transfer, i: usize) -> impl Iterator<Item = (usize, T)> {
        let (start, length) = (
            self.start[axis][transfer as usize],
            self.length[axis][transfer as usize],
        );
        (0..transfer.taps())
            .map(move |slot| start + slot * length + i)
            .map(|at| (self.index[at] as usize, self.weight[at]))
            .filter(|&(_, w)| w != T::ZERO)
    }

    /// Passes every row of `from` along x: `out[i] +=` the weighted sum of its sources.
    pub fn add_along_x(&self, transfer: Transfer, from: &[T], from_n: usize, out: &mut [T], out_n: usize) {
        if self.halves && transfer.to_finer() {
            return self.add_between(transfer, from, from_n, out, out_n);
        }
        for (row, out) in out.chunks_exact_mut(out_n).enumerate() {
            let own = from.get(row * from_n..).unwrap_or_default();
            for slot in 0..transfer.taps() {
                // Reaches into the rows beside it, where weights are 0.
                let first = (row * from_n + slot).wrapping_add_signed(transfer.first());
                match from.get(first..first.wrapping_add(from_n)) {
                    Some(from) if self.halves => add_every_other(out, self.along_x(transfer, slot).1, from),
                    _ => self.add_by_position(transfer, slot, own, 0..out_n, out),
                }
            }
        }
    }

    /// [`Self::add_along_x`] to numbers of which each pair has its sources beside its place and the two next to it.
    fn add_between(&self, transfer: Transfer, from: &[T], from_n: usize, out: &mut [T], out_n: usize) {
        let weights = [0, 1].map(|slot| self.along_x(transfer, slot).1);
        let rows = out.chunks_exact_mut(out_n);
        let count = rows.len();
        for (row, out) in rows.enumerate() {
            let own = from.get(row * from_n..).unwrap_or_default();
            // The ends of a row reach into the rows beside it, where weights are 0; only the first and the last have none there.
            let (start, end) = (usize::from(row == 0), from_n - usize::from(row + 1 == count));
            let [first, second] = weights.map(|weights| weights.get(2 * start..).unwrap_or_default());
            let sources = from.get(row * from_n + start - 1..).unwrap_or_default();
            add_to_pairs(
                out.get_mut(2 * start..2 * end).unwrap_or_default(),
                first,
                second,
                sources,
            );
            for slot in 0..2 {
                for ends in [0..2 * start, 2 * end..out_n] {
                    self.add_by_position(transfer, slot, own, ends, out);
                }
            }
        }
    }

    /// Adds tap `slot` of some numbers of a row, whose sources `from` begins with.
    fn add_by_position(
        &self,
        transfer: Transfer,
        slot: usize,
        from: &[T],
        span: Range<usize>,
        out: &mut [T],
    ) {
        let (index, weight) = self.along_x(transfer, slot);
        let (index, weight) = (
            index.get(span.clone()).unwrap_or_default(),
            weight.get(span.clone()).unwrap_or_default(),
        );
        for ((o, &i), &w) in out
            .get_mut(span)
            .unwrap_or_default()
            .iter_mut()
            .zip(index)
            .zip(weight)
        {
            *o += w * from[i as usize];
        }
    }

    /// The positions and weights of tap `slot` of all numbers along x.
    fn along_x(&self, transfer: Transfer, slot: usize) -> (&[u16], &[T]) {
        let (start, length) = (
            self.start[0][transfer as usize],
            self.length[0][transfer as usize],
        );
        let at = start + slot * length;
        (&self.index[at..at + length], &self.weight[at..at + length])
    }
}

/// The place of the first source of number `i` along an axis that halves.
fn side_by_side(transfer: Transfer, i: usize) -> usize {
    let middle = if transfer.to_finer() { i.div_ceil(2) } else { 2 * i };
    middle.wrapping_add_signed(transfer.first())
}

multiversion! {
    /// Adds numbers i and i + 1 of `from` to the first of pair i, numbers i + 1 and i + 2 to the second: `first` and `second` are their weights.
    fn add_to_pairs[T: Real](out: &mut [T], first: &[T], second: &[T], from: &[T]) {
        let [here, above] = [1, 2].map(|ahead| from.get(ahead..).unwrap_or_default());
        let weights = first.chunks_exact(2).zip(second.chunks_exact(2));
        for ((((pair, (first, second)), &below), &here), &above) in out.chunks_exact_mut(2).zip(weights).zip(from).zip(here).zip(above) {
            pair[0] = (pair[0] + first[0] * below) + second[0] * here;
            pair[1] = (pair[1] + first[1] * here) + second[1] * above;
        }
    }
}

multiversion! {
    /// Adds the first of pair i of `from`, weighted, to number i.
    fn add_every_other[T: Real](out: &mut [T], weight: &[T], from: &[T]) {
        for ((o, &w), pair) in out.iter_mut().zip(weight).zip(from.chunks_exact(2)) {
            *o += w * pair[0];
        }
    }
}

/// The grids of a hierarchy, finest first, with the weights between neighbours.
#[derive(Debug)]
pub struct Levels<'m, T> {
    /// The first of them.
    pub finest: Grid,
    /// The grids.
    pub grids: heapless::Vec<Grid, MAX_LEVELS>,
    /// The weights between grid l and grid l + 1.
    pub tables: heapless::Vec<Tables<'m, T>, MAX_LEVELS>,
    /// The eigenvectors of every grid that has them, see [`Self::spectrum`].
    pub eigenvectors: &'m [T],
    /// Gaussians that are known in their terms.
    filters: usize,
}

impl<'m, T: Real> Levels<'m, T> {
    /// Writes the ledger lines of [`Self::carve`].
    pub fn requirement(ledger: &mut Ledger, finest: &Grid, filters: usize) {
        let taps = Self::taps(&hierarchy(finest));
        ledger.line("transfer positions", taps, 2);
        ledger.line("transfer weights", taps, T::BYTES);
        ledger.line(
            "eigenvectors",
            hierarchy(finest)
                .iter()
                .map(|grid| Spectrum::<T>::len(grid, filters))
                .sum(),
            T::BYTES,
        );
    }

    fn taps(grids: &[Grid]) -> usize {
        grids
            .windows(2)
            .map(|pair| Tables::<T>::len(&pair[0], &pair[1]))
            .sum()
    }

    /// Takes its buffers and fills them; `filters` is that of the finest metric.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn carve(arena: &mut Arena<'m>, finest: &Grid, filters: usize) -> Result<Self, TooSmall> {
        let grids = hierarchy(finest);
        let taps = Self::taps(&grids);
        let (mut index, mut weight) = (arena.take::<u16>(taps)?, arena.take::<T>(taps)?);
        let mut tables = heapless::Vec::new();
        for pair in grids.windows(2) {
            let len = Tables::<T>::len(&pair[0], &pair[1]);
            let (these_index, rest_index) = core::mem::take(&mut index).split_at_mut(len);
            let (these_weight, rest_weight) = core::mem::take(&mut weight).split_at_mut(len);
            (index, weight) = (rest_index, rest_weight);
            let pushed = tables.push(Tables::new(&pair[0], &pair[1], these_index, these_weight));
            debug_assert!(pushed.is_ok());
        }
        let eigenvectors =
            arena.take::<T>(grids.iter().map(|grid| Spectrum::<T>::len(grid, filters)).sum())?;
        let mut rest = &mut *eigenvectors;
        for grid in &grids {
            let (these, after) = rest.split_at_mut(Spectrum::<T>::len(grid, filters));
            Spectrum::fill(grid, filters, these);
            rest = after;
        }
        Ok(Self {
            finest: *finest,
            grids,
            tables,
            eigenvectors,
            filters,
        })
    }

    /// The eigenvectors of grid `level`, if it has any.
    #[must_use]
    pub fn spectrum(&self, level: usize) -> Option<Spectrum<'_, T>> {
        let start = self.grids[..level]
            .iter()
            .map(|grid| Spectrum::<T>::len(grid, self.filters))
            .sum();
        let numbers = self
            .eigenvectors
            .get(start..)
            .filter(|numbers| !numbers.is_empty())?;
        Spectrum::<T>::exists(&self.grids[level])
            .then(|| Spectrum::view(&self.grids[level], self.filters, numbers))
    }
}
