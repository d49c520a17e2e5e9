//! The taps between two grids, computed once, and their use along x.

use super::Grid;
use super::taps::{TRANSFERS, Transfer, taps};
use crate::real::Real;
use crate::simd::multiversion;
use core::ops::Range;

/// The taps of all transfers between two neighbouring grids, by axis, transfer, index of the tap and position.
#[derive(Debug, Default)]
pub struct Tables<'m, T> {
    source: &'m mut [u16],
    weight: &'m mut [T],
    lines: [[Line; TRANSFERS.len()]; 3],
    /// Whether x halves between walls: then the sources of a value lie side by side, and tap 0 is the first of them.
    halves: bool,
}

/// Where the taps of one transfer along one axis begin, and how many values it makes there.
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    start: usize,
    length: usize,
}

impl Line {
    /// Where the taps of all values stand that have the same index.
    fn of_tap(self, tap: usize) -> Range<usize> {
        let start = self.start + tap * self.length;
        start..start + self.length
    }
}

impl<'m, T: Real> Tables<'m, T> {
    /// The taps of all transfers between `fine` and `coarse`.
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

    /// Fills `source` and `weight`, of [`Self::len`] values each.
    #[must_use]
    pub fn new(fine: &Grid, coarse: &Grid, source: &'m mut [u16], weight: &'m mut [T]) -> Self {
        let mut tables = Self {
            source,
            weight,
            lines: Default::default(),
            halves: fine.n[0] == 2 * coarse.n[0] && !fine.axis(0).is_ring() && !fine.is_open(),
        };
        let mut start = 0;
        for axis in 0..fine.dims {
            for transfer in TRANSFERS {
                let length = transfer.length(fine.n[axis], coarse.n[axis]);
                tables.lines[axis][transfer as usize] = Line { start, length };
                tables.fill(axis, transfer, fine, coarse);
                start += transfer.taps() * length;
            }
        }
        tables
    }

    fn fill(&mut self, axis: usize, transfer: Transfer, fine: &Grid, coarse: &Grid) {
        let line = self.lines[axis][transfer as usize];
        let (from, to) = if transfer.to_finer() {
            (coarse, fine)
        } else {
            (fine, coarse)
        };
        for i in 0..line.length {
            let of_whole = to.in_whole(axis, i);
            let list = taps(transfer, of_whole, fine.whole_axis(axis), coarse.whole_axis(axis));
            for (tap, &(source, weight)) in list.iter().enumerate() {
                // Of what only copies are made of not all is here: they are overwritten by what their owner has.
                let Some(source) = from.here(axis, source) else {
                    continue;
                };
                let tap = if axis == 0 && self.halves {
                    source.wrapping_sub(first_source(transfer, i))
                } else {
                    tap
                };
                let place = line.of_tap(tap).start + i;
                self.source[place] = source as u16;
                self.weight[place] = T::from_f64(weight);
            }
        }
    }

    /// The sources of value `i` along `axis` and their weights, those of weight 0 left out.
    pub fn taps(&self, axis: usize, transfer: Transfer, i: usize) -> impl Iterator<Item = (usize, T)> {
        let line = self.lines[axis][transfer as usize];
        (0..transfer.taps())
            .map(move |tap| line.of_tap(tap).start + i)
            .map(|place| (self.source[place] as usize, self.weight[place]))
            .filter(|&(_, weight)| weight != T::ZERO)
    }

    /// Along x in every row of `from`, of `from_n` values each, to the rows of `out`, of `out_n` values each: `out[i] +=` the weighted
    /// sum of its sources.
    pub fn add_along_x(&self, transfer: Transfer, from: &[T], from_n: usize, out: &mut [T], out_n: usize) {
        if self.halves && transfer.to_finer() {
            return self.add_between(transfer, from, from_n, out, out_n);
        }
        let rows = out.chunks_exact_mut(out_n).zip(from.chunks_exact(from_n));
        for (row, (out, own)) in rows.enumerate() {
            for tap in 0..transfer.taps() {
                // Reaches into the rows beside it, where weights are 0.
                let first = (row * from_n + tap).wrapping_add_signed(transfer.first());
                match from.get(first..first.wrapping_add(from_n)) {
                    Some(from) if self.halves => add_every_other(out, self.along_x(transfer, tap).1, from),
                    _ => self.add_by_source(transfer, tap, own, 0..out_n, out),
                }
            }
        }
    }

    /// [`Self::add_along_x`] to a grid with twice as many cells: the sources of a pair of values are the one at its place and the two
    /// beside that.
    fn add_between(&self, transfer: Transfer, from: &[T], from_n: usize, out: &mut [T], out_n: usize) {
        let [first, second] = [0, 1].map(|tap| self.along_x(transfer, tap).1);
        let count = out.len() / out_n;
        let rows = out.chunks_exact_mut(out_n).zip(from.chunks_exact(from_n));
        for (row, (out, own)) in rows.enumerate() {
            // The ends of a row reach into the rows beside it, where weights are 0; the first and the last row have no such row.
            let (start, end) = (usize::from(row == 0), from_n - usize::from(row + 1 == count));
            let inside = 2 * start..2 * end;
            let weights = (first.get(inside.clone()), second.get(inside.clone()));
            let sources = from.get((row * from_n + start).wrapping_sub(1)..);
            if let (Some(pairs), (Some(first), Some(second)), Some(sources)) =
                (out.get_mut(inside.clone()), weights, sources)
            {
                add_to_pairs(pairs, first, second, sources);
            }
            for tap in 0..2 {
                for ends in [0..inside.start, inside.end..out_n] {
                    self.add_by_source(transfer, tap, own, ends, out);
                }
            }
        }
    }

    /// Adds one tap of each of some values of a row that is made from the row `from`.
    fn add_by_source(&self, transfer: Transfer, tap: usize, from: &[T], values: Range<usize>, out: &mut [T]) {
        let (source, weight) = self.along_x(transfer, tap);
        let taps = (source.get(values.clone()), weight.get(values.clone()));
        let (Some(out), (Some(source), Some(weight))) = (out.get_mut(values), taps) else {
            debug_assert!(false, "no such values");
            return;
        };
        for ((out, &source), &weight) in out.iter_mut().zip(source).zip(weight) {
            *out += weight * from[source as usize];
        }
    }

    /// The sources and weights of the taps of all values along x that have the same index.
    fn along_x(&self, transfer: Transfer, tap: usize) -> (&[u16], &[T]) {
        let places = self.lines[0][transfer as usize].of_tap(tap);
        (&self.source[places.clone()], &self.weight[places])
    }
}

/// The first source of value `i` along an axis that halves.
fn first_source(transfer: Transfer, i: usize) -> usize {
    let middle = if transfer.to_finer() { i.div_ceil(2) } else { 2 * i };
    middle.wrapping_add_signed(transfer.first())
}

multiversion! {
    /// Adds values i and i + 1 of `from` to the first value of pair i, values i + 1 and i + 2 to the second, weighted by their own values of `first`
    /// and of `second`.
    fn add_to_pairs[T: Real](out: &mut [T], first: &[T], second: &[T], from: &[T]) {
        let (Some(here), Some(above)) = (from.get(1..), from.get(2..)) else { return };
        let weights = first.chunks_exact(2).zip(second.chunks_exact(2));
        for ((((pair, (first, second)), &below), &here), &above) in out.chunks_exact_mut(2).zip(weights).zip(from).zip(here).zip(above) {
            pair[0] = (pair[0] + first[0] * below) + second[0] * here;
            pair[1] = (pair[1] + first[1] * here) + second[1] * above;
        }
    }
}

multiversion! {
    /// Adds the first value of pair i of `from`, weighted, to value i.
    fn add_every_other[T: Real](out: &mut [T], weight: &[T], from: &[T]) {
        for ((o, &w), pair) in out.iter_mut().zip(weight).zip(from.chunks_exact(2)) {
            *o += w * pair[0];
        }
    }
}
