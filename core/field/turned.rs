//! The transforms of [`transform`](super::transform) in a box that ranks share: fields are dealt out anew, so that every transform has its axis as a whole
//! and gives the bits that it gives in one program.
//!
//! ```text
//! slabs    some planes -> some rows of all planes, along the last axis -> some planes, along the others, the symbol, and back
//! blocks   some rows of some planes -> columns along z -> columns along y -> rows along x, the symbol, and back
//! ```
//!
//! What a rank has of a field is a [`Brick`] each time. In blocks each turn is among the ranks of a [line](crate::memory::part::Line) alone, where it can be: a
//! [fast transform](is_fast) takes 32 columns or rows of the box together, x fastest, and bricks end where such groups do.

use super::borders;
use super::transform::{Direction, along_columns, along_rows};
use crate::exec::ranks::{Ranks, swap};
use crate::exec::{Exec, RowBuffers, Serial, for_rows};
use crate::field::rows::{part, part_mut};
use crate::grid::Grid;
use crate::grid::spectrum::{COLUMNS, Spectrum, is_fast};
use crate::memory::Pool;
use crate::memory::part::{Parts, cut};
use crate::real::Real;
use core::ops::Range;

/// The workspace of so many fields of cells; none in a box that is not shared.
#[derive(Debug, Default)]
pub struct Turned<'a, T> {
    /// What fields become in turn.
    fields: [&'a mut [T]; 2],
    /// What is sent and what is received.
    messages: [&'a mut [T]; 2],
    /// Whether they are dealt out anew between an axis and the one before.
    turns: [bool; 3],
}

/// Cells of the whole box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Brick {
    low: [usize; 3],
    high: [usize; 3],
}

impl Brick {
    fn of(ranges: [Range<usize>; 3]) -> Self {
        Self {
            low: ranges.each_ref().map(|range| range.start),
            high: ranges.each_ref().map(|range| range.end),
        }
    }

    /// Cells along each axis.
    fn extent(&self) -> [usize; 3] {
        core::array::from_fn(|axis| self.high[axis].saturating_sub(self.low[axis]))
    }

    fn len(&self) -> usize {
        self.extent().iter().product()
    }

    /// The cells that are in both.
    fn meet(&self, other: &Self) -> Self {
        Self {
            low: core::array::from_fn(|axis| self.low[axis].max(other.low[axis])),
            high: core::array::from_fn(|axis| self.high[axis].min(other.high[axis])),
        }
    }
}

/// Where a field has the cells of a brick.
#[derive(Clone, Copy)]
struct Placed {
    brick: Brick,
    /// Where its first cell is in the field, of so many cells along each axis.
    first: [usize; 3],
    n: [usize; 3],
}

impl Placed {
    /// Where rows of some of its cells lie, one after the other.
    fn rows(&self, some: Brick) -> impl Iterator<Item = Range<usize>> + use<> {
        let Self { brick, first, n } = *self;
        let [nx, ny, nz] = some.extent();
        let [x, y, z] = core::array::from_fn(|axis| first[axis] + some.low[axis] - brick.low[axis]);
        let rows = (z..z + nz).flat_map(move |z| (y..y + ny).map(move |y| (z * n[1] + y) * n[0] + x));
        rows.map(move |begin| begin..begin + nx)
    }
}

/// How a field is dealt out.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// As the box is shared, with copies of what neighbours have.
    Held,
    /// Every rank has an axis as a whole, on the way to all transforms.
    Along(usize),
    /// Every rank has the rows of its planes as a whole, on the way to no other axis.
    Rows,
}

/// How a box is dealt out.
#[derive(Clone, Copy)]
struct Deal {
    grid: Grid,
    whole: Grid,
    parts: Parts,
}

impl Deal {
    fn new(grid: &Grid) -> Option<Self> {
        Some(Self {
            grid: *grid,
            whole: grid.whole(),
            parts: grid.parts()?,
        })
    }

    /// The axis along which the box is cut into planes.
    fn last(&self) -> usize {
        self.whole.dims - 1
    }

    /// The cells of a rank.
    fn brick(&self, stage: Stage, rank: usize) -> Brick {
        let (n, share) = (self.whole.n, self.parts.share);
        let fast = |axis: usize| is_fast(self.whole.axis(axis));
        let unit = |fast: bool| if fast { COLUMNS } else { 1 };
        // Rows, or planes, with which groups of columns, or of rows, end where their number in each is this one.
        let whole = |fast: bool, each: usize| match fast {
            true => (1..COLUMNS)
                .find(|count| (count * each).is_multiple_of(COLUMNS))
                .unwrap_or(COLUMNS),
            false => 1,
        };
        let among = |axis: usize, unit: usize| cut(n[axis], unit, rank, share.ranks);
        let beside = share.beside.max(1);
        let along_rows = |axis: usize| cut(n[axis], 1, rank % beside, beside);
        // Groups of an axis for the ranks along the planes, and a part of another range for each of those that have the same ones: there may be more ranks.
        let along_planes = |axis: usize, unit: usize, other: Range<usize>| {
            let (place, count) = (rank / beside, share.ranks / beside);
            let most = count.min(n[axis].div_ceil(unit));
            let across = (1..=most).rev().find(|&across| count.is_multiple_of(across));
            let across = across.unwrap_or(1);
            let part = cut(other.len(), 1, place / across, count / across);
            let groups = cut(n[axis], unit, place % across, across);
            [groups, other.start + part.start..other.start + part.end]
        };
        let held = |axis: usize| self.grid.of_rank(axis, rank);
        let [x, y, z] = n.map(|n| 0..n);
        let blocks = self.parts.rows.is_some();
        let in_groups = |axis: usize, other: usize| !fast(axis) || n[other].is_multiple_of(COLUMNS);
        Brick::of(match (stage, self.whole.dims) {
            (Stage::Held, _) => [0, 1, 2].map(held),
            (Stage::Rows, _) => [along_rows(0), y, held(2)],
            (Stage::Along(1), 2) => [among(0, unit(fast(1))), y, z],
            (Stage::Along(_), 2) => [x, among(1, unit(fast(0))), z],
            (Stage::Along(2), _) if blocks && in_groups(2, 0) => {
                let [x, y] = along_planes(0, unit(fast(1) || fast(2)), held(1));
                [x, y, z]
            }
            (Stage::Along(2), _) => [x, among(1, whole(fast(2), n[0])), z],
            (Stage::Along(1), _) if blocks => {
                let [x, z] = along_planes(0, unit(fast(1) || fast(2)), along_rows(2));
                [x, y, z]
            }
            (Stage::Along(0), _) if blocks && in_groups(0, 1) => {
                let [y, z] = along_planes(1, unit(fast(0)), along_rows(2));
                [x, y, z]
            }
            (Stage::Along(_), _) => [x, y, among(2, whole(fast(0), n[1]))],
        })
    }

    /// The cells of this rank, and where they are in a field.
    fn placed(&self, stage: Stage) -> Placed {
        let brick = self.brick(stage, self.parts.share.rank);
        match stage {
            Stage::Held => Placed {
                brick,
                first: [0, 1, 2].map(|axis| self.grid.own(axis).start),
                n: self.grid.n,
            },
            _ => Placed {
                brick,
                first: [0; 3],
                n: brick.extent(),
            },
        }
    }

    /// Whether a field is dealt out anew between an axis and the one before.
    fn turns(&self, axis: usize) -> bool {
        let ranks = 0..self.parts.share.ranks;
        let of = |axis| {
            ranks
                .clone()
                .map(move |rank| self.brick(Stage::Along(axis), rank))
        };
        axis.checked_sub(1).is_some_and(|before| !of(axis).eq(of(before)))
    }

    /// All turns, and in which of two fields each ends; those on the way back are these from their end.
    fn each_turn(&self, mut each: impl FnMut([Stage; 2], usize)) {
        let last = self.last();
        each([Stage::Held, Stage::Along(last)], 0);
        let mut at = 0;
        for axis in (1..=last).rev().filter(|&axis| self.turns(axis)) {
            at = 1 - at;
            each([Stage::Along(axis), Stage::Along(axis - 1)], at);
        }
        if self.parts.rows.is_some() {
            each([Stage::Held, Stage::Rows], 0);
        }
    }

    /// Elements of both fields and of both messages.
    fn lens(&self) -> [[usize; 2]; 2] {
        let Self { parts, .. } = self;
        let (mut fields, mut messages) = ([0; 2], [0; 2]);
        self.each_turn(|[from, to], at| {
            let own = [from, to].map(|stage| self.brick(stage, parts.share.rank));
            fields[at] = own[1].len().max(fields[at]);
            for rank in 0..parts.share.ranks {
                // On the way back they are received.
                let theirs = [from, to].map(|stage| self.brick(stage, rank));
                let most = own[0].meet(&theirs[1]).len().max(own[1].meet(&theirs[0]).len());
                messages = messages.map(|len: usize| len.max(most));
            }
        });
        [fields, messages]
    }

    /// Deals `count` fields out anew.
    fn turn<T: Real>(
        &self,
        (ranks, count): (&dyn Ranks, usize),
        (before, from): (Stage, &[T]),
        (after, to): (Stage, &mut [T]),
        [sent, received]: &mut [&mut [T]; 2],
    ) {
        let (rank, all) = (self.parts.share.rank, self.parts.share.ranks);
        let (source, target) = (self.placed(before), self.placed(after));
        let lens = [source, target].map(|placed| placed.n.iter().product::<usize>());
        for shift in 0..all {
            let (whom, whose) = ((rank + shift) % all, (rank + all - shift) % all);
            let theirs = source.brick.meet(&self.brick(after, whom));
            let mine = target.brick.meet(&self.brick(before, whose));
            if theirs.len() + mine.len() == 0 {
                continue;
            }
            for field in 0..count {
                let from = part(from, field * lens[0]..(field + 1) * lens[0]);
                let to = part_mut(to, field * lens[1]..(field + 1) * lens[1]);
                if shift == 0 {
                    let rows = source.rows(theirs).zip(target.rows(mine));
                    rows.for_each(|(theirs, mine)| part_mut(to, mine).copy_from_slice(part(from, theirs)));
                    continue;
                }
                let sent = part_mut(sent, 0..theirs.len());
                let rows = sent.chunks_exact_mut(theirs.extent()[0].max(1));
                rows.zip(source.rows(theirs))
                    .for_each(|(sent, row)| sent.copy_from_slice(part(from, row)));
                let received = part_mut(received, 0..mine.len());
                swap(ranks, Some(whom), sent, Some(whose), received);
                let rows = received.chunks_exact(mine.extent()[0].max(1));
                rows.zip(target.rows(mine))
                    .for_each(|(received, row)| part_mut(to, row).copy_from_slice(received));
            }
        }
    }
}

impl<'a, T: Real> Turned<'a, T> {
    /// Takes its workspace for `fields` fields of cells of `grid` from a pool.
    pub fn carve(grid: &Grid, fields: usize, pool: &mut Pool<'a, T>) -> Self {
        let Some(deal) = Deal::new(grid) else {
            return Self::default();
        };
        let [of_fields, of_messages] = deal.lens();
        pool.line("turned for transforms: fields twice, messages", |pool| Self {
            fields: of_fields.map(|len| pool.take("fields", fields * len)),
            messages: of_messages.map(|len| pool.take("message", len)),
            turns: core::array::from_fn(|axis| deal.turns(axis)),
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
        let Some(deal) = Deal::new(grid) else {
            return;
        };
        let (ranks, count) = (exec.ranks(), fields.len() / grid.cells().max(1));
        let (last, messages) = (deal.last(), &mut self.messages);
        let [mut now, mut next] = self.fields.each_mut().map(|field| &mut **field);
        let brick = |axis: usize| deal.brick(Stage::Along(axis), deal.parts.share.rank);
        let along = |axis: usize, direction: Direction, fields: &mut [T], scratch: &mut [T]| {
            let n = brick(axis).extent();
            let of_axis = (&spectrum.axes[axis], n.iter().take(axis).product());
            each(work, (count, n), fields, scratch, |field, scratch| {
                along_columns(&Serial, of_axis, direction, field, scratch);
            });
        };
        deal.turn(
            (ranks, count),
            (Stage::Held, &*fields),
            (Stage::Along(last), &mut *now),
            messages,
        );
        for axis in (1..=last).rev() {
            along(axis, Direction::Analysis, now, scratch);
            if self.turns[axis] {
                let stages = [axis, axis - 1].map(Stage::Along);
                deal.turn(
                    (ranks, count),
                    (stages[0], &*now),
                    (stages[1], &mut *next),
                    messages,
                );
                core::mem::swap(&mut now, &mut next);
            }
        }
        let rows = brick(0);
        let n = rows.extent();
        each(work, (count, n), now, scratch, |field, scratch| {
            let symbol = |row: usize, span: Range<usize>, old: &[T], new: &mut [T]| {
                let [y, z] = [rows.low[1] + row % n[1].max(1), rows.low[2] + row / n[1].max(1)];
                symbol(deal.whole.row(y, z), span, old, new);
            };
            along_rows(&Serial, &spectrum.axes[0], field, scratch, symbol);
        });
        for axis in 1..=last {
            if self.turns[axis] {
                let stages = [axis - 1, axis].map(Stage::Along);
                deal.turn(
                    (ranks, count),
                    (stages[0], &*now),
                    (stages[1], &mut *next),
                    messages,
                );
                core::mem::swap(&mut now, &mut next);
            }
            along(axis, Direction::Synthesis, now, scratch);
        }
        deal.turn(
            (ranks, count),
            (Stage::Along(last), &*now),
            (Stage::Held, &mut *fields),
            messages,
        );
        for field in fields.chunks_exact_mut(grid.cells().max(1)) {
            borders::refresh(exec, grid, field);
        }
    }

    /// Calls `work` with the rank's columns of `from` along an axis that ranks share, so many side by side and slab after slab, and with room for what they
    /// become in `to`; the copies of what other ranks have are right then. It is to have been carved for two fields.
    pub fn along(
        &mut self,
        exec: &dyn Exec,
        (grid, axis): (&Grid, usize),
        from: &[T],
        to: &mut [T],
        mut work: impl FnMut(usize, &[T], &mut [T]),
    ) {
        let Some(deal) = Deal::new(grid) else {
            return;
        };
        let stage = if axis == deal.last() {
            Stage::Along(axis)
        } else {
            Stage::Rows
        };
        let n = deal.placed(stage).n;
        let (len, width) = (n.iter().product(), n.iter().take(axis).product::<usize>());
        let messages = &mut self.messages;
        let (before, after) = self.fields[0].split_at_mut_checked(len).unwrap_or_default();
        deal.turn(
            (exec.ranks(), 1),
            (Stage::Held, from),
            (stage, &mut *before),
            messages,
        );
        let after = part_mut(after, 0..len);
        let slab = (width * n[axis]).max(1);
        for (before, after) in before.chunks_exact(slab).zip(after.chunks_exact_mut(slab)) {
            work(width, before, after);
        }
        deal.turn(
            (exec.ranks(), 1),
            (stage, &*after),
            (Stage::Held, &mut *to),
            messages,
        );
        borders::refresh(exec, grid, to);
    }
}

/// Calls `transform` for each of `count` fields, of so many cells.
fn each<T: Real>(
    work: &dyn Exec,
    (count, n): (usize, [usize; 3]),
    fields: &mut [T],
    scratch: &mut [T],
    transform: impl Fn(&mut [T], &mut [T]) + Sync,
) {
    let fields = part_mut(fields, 0..count * n.iter().product::<usize>());
    let buffers = RowBuffers::fields([fields]).with_scratch(scratch);
    for_rows(work, count, buffers, |task| {
        let [field] = task.fields;
        transform(field, task.scratch);
    });
}
