//! The transforms of [`transform`](super::transform) in a box that ranks share: fields are turned from slabs of planes to bundles of columns
//! along the last axis and back, so that every transform has its axis as a whole and gives the bits that it gives in one program.
//!
//! ```text
//! slabs -> columns, along the last axis -> planes, along the others, the symbol, back -> columns, back along the last -> slabs
//! ```
//!
//! Columns and planes are dealt out anew for that: along an axis with a [fast transform](is_fast), 32 of what is transformed together stay together.

use super::borders;
use super::transform::{Direction, along_columns, multiply_along};
use crate::exec::ranks::{Ranks, swap};
use crate::exec::{Exec, RowBuffers, Serial, for_rows};
use crate::field::rows::{part, part_mut};
use crate::grid::Grid;
use crate::grid::spectrum::{COLUMNS, Spectrum, is_fast};
use crate::memory::Pool;
use crate::memory::part::cut;
use crate::real::Real;
use core::ops::Range;

/// The workspace of so many fields of cells; none in a box that is not shared.
#[derive(Debug, Default)]
pub struct Turned<'a, T> {
    columns: &'a mut [T],
    planes: &'a mut [T],
    message: &'a mut [T],
}

/// How a box is dealt out.
#[derive(Clone, Copy)]
struct Deal {
    grid: Grid,
    whole: Grid,
    rank: usize,
    ranks: usize,
}

/// Which planes a rank has of a field.
#[derive(Clone, Copy)]
enum Held {
    /// Its slab, with copies of its neighbours' planes.
    Slabs,
    /// Those that it transforms along all axes but the last.
    Planes,
}

impl Deal {
    fn new(grid: &Grid, rank: usize, ranks: usize) -> Self {
        Self {
            grid: *grid,
            whole: grid.whole(),
            rank,
            ranks,
        }
    }

    /// Values of a plane.
    fn width(&self) -> usize {
        self.whole.n.iter().take(self.whole.dims - 1).product()
    }

    /// Whether an axis has a fast transform.
    fn is_fast(&self, axis: usize) -> bool {
        is_fast(self.whole.axis(axis))
    }

    /// The columns of a rank along the last axis.
    fn columns(&self, rank: usize) -> Range<usize> {
        let unit = if self.is_fast(self.whole.dims - 1) {
            COLUMNS
        } else {
            1
        };
        cut(self.width(), unit, rank, self.ranks)
    }

    /// The planes of a rank while it transforms along the other axes.
    fn planes(&self, rank: usize) -> Range<usize> {
        let rows = self.whole.rows_per_plane();
        let unit = if self.is_fast(0) {
            (1..=COLUMNS)
                .find(|planes| (planes * rows).is_multiple_of(COLUMNS))
                .unwrap_or(COLUMNS)
        } else {
            1
        };
        cut(self.whole.planes(), unit, rank, self.ranks)
    }

    /// Whom to send to and from whom to receive, one after the other.
    fn partners(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let Self { rank, ranks, .. } = *self;
        (0..ranks).map(move |shift| [(rank + shift) % ranks, (rank + ranks - shift) % ranks])
    }
}

impl<'a, T: Real> Turned<'a, T> {
    /// Takes its workspace for `fields` fields of cells of `grid` from a pool.
    pub fn carve(grid: &Grid, fields: usize, pool: &mut Pool<'a, T>) -> Self {
        let Some(share) = grid.part().map(|part| part.share) else {
            return Self::default();
        };
        let deal = Deal::new(grid, share.rank, share.ranks);
        let columns = (0..share.ranks).map(|rank| deal.columns(rank).len()).max();
        let (columns, planes) = (columns.unwrap_or(0), deal.planes(share.rank).len());
        let most = planes.max(grid.own_planes().len());
        let own = deal.columns(share.rank).len();
        pool.line("turned for transforms: columns, planes, a message", |pool| Self {
            columns: pool.take("columns", fields * deal.whole.planes() * own),
            planes: pool.take("planes", fields * planes * deal.width()),
            message: pool.take("message", most * columns),
        })
    }

    /// As [`multiply`](super::transform::multiply) for each of `fields`, on the threads of `work`, each with a chunk of `scratch`; the copies
    /// of what other ranks have are right then.
    pub fn multiply(
        &mut self,
        (exec, work): (&dyn Exec, &dyn Exec),
        (grid, spectrum): (&Grid, &Spectrum<'_, T>),
        fields: &mut [T],
        scratch: &mut [T],
        symbol: impl Fn(usize, Range<usize>, &[T], &mut [T]) + Sync,
    ) {
        let ranks = exec.ranks();
        let deal = Deal::new(grid, ranks.rank(), ranks.count());
        let count = fields.len() / grid.cells().max(1);
        let own = deal.columns(deal.rank).len();
        let held = deal.planes(deal.rank);
        let last = &spectrum.axes[grid.dims - 1];
        let columns = part_mut(self.columns, 0..count * deal.whole.planes() * own);
        let planes = part_mut(self.planes, 0..count * held.len() * deal.width());
        let along_last = |direction, columns: &mut [T], scratch: &mut [T]| {
            each(work, count, columns, scratch, |field, scratch| {
                along_columns(&Serial, (last, own), direction, field, scratch);
            });
        };
        deal.turn_to_columns(ranks, count, (Held::Slabs, fields), columns, self.message);
        along_last(Direction::Analysis, columns, scratch);
        deal.turn_to_planes(ranks, count, columns, (Held::Planes, planes), self.message);
        let first = held.start * grid.rows_per_plane();
        each(work, count, planes, scratch, |field, scratch| {
            let symbol = |row: usize, span: Range<usize>, old: &[T], new: &mut [T]| {
                symbol(first + row, span, old, new)
            };
            multiply_along(&Serial, grid.dims - 1, (grid, spectrum), field, scratch, symbol);
        });
        deal.turn_to_columns(ranks, count, (Held::Planes, planes), columns, self.message);
        along_last(Direction::Synthesis, columns, scratch);
        deal.turn_to_planes(ranks, count, columns, (Held::Slabs, fields), self.message);
        for field in fields.chunks_exact_mut(grid.cells().max(1)) {
            borders::refresh(exec, grid, field);
        }
    }
}

impl<T: Real> Turned<'_, T> {
    /// Calls `work` with the rank's columns of `from` along the last axis, of so many values across, and with room for what they become in `to`;
    /// the copies of what other ranks have are right then. It is to have been carved for two fields.
    pub fn along_last(
        &mut self,
        exec: &dyn Exec,
        grid: &Grid,
        from: &[T],
        to: &mut [T],
        work: impl FnOnce(usize, &[T], &mut [T]),
    ) {
        let ranks = exec.ranks();
        let deal = Deal::new(grid, ranks.rank(), ranks.count());
        let own = deal.columns(deal.rank).len();
        let len = deal.whole.planes() * own;
        let (before, after) = self.columns.split_at_mut_checked(len).unwrap_or_default();
        deal.turn_to_columns(ranks, 1, (Held::Slabs, from), before, self.message);
        let after = part_mut(after, 0..len);
        work(own, before, after);
        deal.turn_to_planes(ranks, 1, after, (Held::Slabs, &mut *to), self.message);
        borders::refresh(exec, grid, to);
    }
}

/// Calls `transform` for each of `count` fields.
fn each<T: Real>(
    work: &dyn Exec,
    count: usize,
    fields: &mut [T],
    scratch: &mut [T],
    transform: impl Fn(&mut [T], &mut [T]) + Sync,
) {
    let buffers = RowBuffers::fields([fields]).with_scratch(scratch);
    for_rows(work, count, buffers, |task| {
        let [field] = task.fields;
        transform(field, task.scratch);
    });
}

/// Copies some columns of rows of `width` values to rows that have no others.
fn gather<T: Real>(rows: &[T], width: usize, columns: Range<usize>, out: &mut [T]) {
    for (row, out) in rows
        .chunks_exact(width)
        .zip(out.chunks_exact_mut(columns.len().max(1)))
    {
        out.copy_from_slice(part(row, columns.clone()));
    }
}

/// The inverse of [`gather`].
fn scatter<T: Real>(from: &[T], width: usize, columns: Range<usize>, rows: &mut [T]) {
    for (row, from) in rows
        .chunks_exact_mut(width)
        .zip(from.chunks_exact(columns.len().max(1)))
    {
        part_mut(row, columns.clone()).copy_from_slice(from);
    }
}

/// Elements of whole rows.
fn of_rows(rows: Range<usize>, width: usize) -> Range<usize> {
    rows.start * width..rows.end * width
}

impl Deal {
    /// The planes of the whole box that a rank has of fields that are held so.
    fn held(&self, held: Held, rank: usize) -> Range<usize> {
        match held {
            Held::Slabs => self.grid.planes_of(rank),
            Held::Planes => self.planes(rank),
        }
    }

    /// The length of such a field.
    fn len(&self, held: Held) -> usize {
        match held {
            Held::Slabs => self.grid.cells(),
            Held::Planes => self.planes(self.rank).len() * self.width(),
        }
    }

    /// Where they lie in a field.
    fn inside(&self, held: Held) -> Range<usize> {
        let planes = match held {
            Held::Slabs => self.grid.own_planes(),
            Held::Planes => 0..self.planes(self.rank).len(),
        };
        of_rows(planes, self.width())
    }

    /// From planes to columns.
    fn turn_to_columns<T: Real>(
        &self,
        ranks: &dyn Ranks,
        count: usize,
        (held, fields): (Held, &[T]),
        columns: &mut [T],
        message: &mut [T],
    ) {
        let (mine, inside) = (self.columns(self.rank).len(), self.inside(held));
        let [of_planes, of_columns] = [self.len(held), self.whole.planes() * mine];
        for field in 0..count {
            let begin = field * of_planes;
            let planes = part(fields, begin + inside.start..begin + inside.end);
            let columns = part_mut(columns, field * of_columns..(field + 1) * of_columns);
            for [to, from] in self.partners() {
                let theirs = self.columns(to);
                let place = part_mut(columns, of_rows(self.held(held, from), mine));
                if to == self.rank {
                    gather(planes, self.width(), theirs, place);
                    continue;
                }
                let packed = part_mut(message, 0..self.held(held, self.rank).len() * theirs.len());
                gather(planes, self.width(), theirs, packed);
                swap(ranks, Some(to), packed, Some(from), place);
            }
        }
    }

    /// The inverse of [`Self::turn_to_columns`].
    fn turn_to_planes<T: Real>(
        &self,
        ranks: &dyn Ranks,
        count: usize,
        columns: &[T],
        (held, fields): (Held, &mut [T]),
        message: &mut [T],
    ) {
        let (mine, inside) = (self.columns(self.rank).len(), self.inside(held));
        let [of_planes, of_columns] = [self.len(held), self.whole.planes() * mine];
        for field in 0..count {
            let begin = field * of_planes;
            let planes = part_mut(fields, begin + inside.start..begin + inside.end);
            let columns = part(columns, field * of_columns..(field + 1) * of_columns);
            for [to, from] in self.partners() {
                let theirs = self.columns(from);
                let sent = part(columns, of_rows(self.held(held, to), mine));
                if to == self.rank {
                    scatter(sent, self.width(), theirs, planes);
                    continue;
                }
                let packed = part_mut(message, 0..self.held(held, self.rank).len() * theirs.len());
                swap(ranks, Some(to), sent, Some(from), packed);
                scatter(packed, self.width(), theirs, planes);
            }
        }
    }
}
