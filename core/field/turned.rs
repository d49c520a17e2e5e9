//! The transforms of [`transform`](super::transform) in a box that ranks share: fields are dealt out anew, so that every transform has its axis as a whole
//! and gives the bits that it gives in one program.
//!
//! ```text
//! slabs    some planes -> some rows of all planes, along the last axis -> some planes, along the others, what is done to rows, and back
//! blocks   some rows of some planes -> columns along z -> columns along y -> rows along x, what is done to them, and back
//! ```
//!
//! What a rank has of a field is a `Brick` each time. In blocks each turn is among the ranks of a [line](crate::memory::part::Line) alone, where it can be: a
//! [fast transform](is_fast) takes 32 columns or rows of the box together, x fastest, and bricks end where such groups do.

use super::borders;
use super::transform::{Direction, RowOf, along_columns, whole_groups};
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
    /// Cells of the whole box; in slabs of planes x and y are one axis, along which columns are dealt out.
    n: [usize; 3],
    /// Columns, or rows, of an axis that stay together.
    units: [usize; 3],
    /// Of the ranks along the planes, in blocks, how many have groups of x for themselves on the way along z and y, and of y on the way along x; the others
    /// have the same groups of other rows or planes.
    across: [usize; 2],
}

impl Deal {
    fn new(grid: &Grid) -> Option<Self> {
        let (whole, parts) = (grid.whole(), grid.parts()?);
        let is_flat = whole.dims == 3 && parts.rows.is_none();
        let [x, y, z] = whole.n;
        let fast = [0, 1, 2].map(|axis| axis < whole.dims && is_fast(whole.axis(axis)));
        let unit = |fast: bool| if fast { COLUMNS } else { 1 };
        let units = match (whole.dims, is_flat) {
            (2, _) => [unit(fast[1]), unit(fast[0]), 1],
            (_, true) => [unit(fast[2]), 1, whole_groups(fast[0], y)],
            _ => [unit(fast[1] || fast[2]), unit(fast[0]), 1],
        };
        let planes = parts.share.along_planes().count;
        let across = [(x, units[0]), (y, units[1])].map(|(cells, unit)| {
            let most = planes.min(cells.div_ceil(unit.max(1)));
            (1..=most)
                .rev()
                .find(|&across| planes.is_multiple_of(across))
                .unwrap_or(1)
        });
        Some(Self {
            grid: *grid,
            whole,
            parts,
            n: if is_flat { [x * y, 1, z] } else { [x, y, z] },
            units,
            across,
        })
    }

    /// The axis along which the box is cut into planes.
    fn last(&self) -> usize {
        self.whole.dims - 1
    }

    /// Whether each rank has whole planes of a box of three axes.
    fn is_flat(&self) -> bool {
        self.whole.dims == 3 && self.parts.rows.is_none()
    }

    /// Whether groups of what is transformed together along an axis end with each row of another one.
    fn in_groups(&self, axis: usize, other: usize) -> bool {
        !is_fast(self.whole.axis(axis)) || self.whole.n[other].is_multiple_of(COLUMNS)
    }

    /// The cells of a rank; where none is named, a brick from the begin on that is as large as any of theirs along each axis.
    fn brick(&self, stage: Stage, rank: Option<usize>) -> Brick {
        let (n, share) = (self.n, self.parts.share);
        let piece = |total: usize, unit: usize, place: Option<usize>, count: usize| match place {
            Some(place) => cut(total, unit, place, count),
            None => 0..(total.div_ceil(unit.max(1)).div_ceil(count.max(1)) * unit).min(total),
        };
        let among = |axis: usize, unit: usize| piece(n[axis], unit, rank, share.ranks);
        let (beside, planes) = (share.beside.max(1), share.along_planes().count);
        let row = rank.map(|rank| rank % beside);
        // Groups of an axis, and a part of another range for each of those who have the same ones.
        let groups = |axis: usize, across: usize, other: Range<usize>| {
            let across = across.max(1);
            let place = rank.map(|rank| rank / beside);
            let part = place.map(|place| place / across);
            let part = piece(other.len(), 1, part, planes / across);
            let groups = piece(
                n[axis],
                self.units[axis],
                place.map(|place| place % across),
                across,
            );
            [groups, other.start + part.start..other.start + part.end]
        };
        let held = |axis: usize| self.held(axis, rank);
        let of_planes = || piece(n[2], 1, row, beside);
        let [x, y, z] = n.map(|n| 0..n);
        let [of_x, of_y] = self.across;
        Brick::of(match (stage, self.whole.dims) {
            (Stage::Held, _) => [0, 1, 2].map(held),
            (Stage::Rows, _) => [piece(n[0], 1, row, beside), y, held(2)],
            (Stage::Along(1), 2) => [among(0, self.units[0]), y, z],
            (Stage::Along(_), 2) => [x, among(1, self.units[1]), z],
            (Stage::Along(2), _) if self.is_flat() => [among(0, self.units[0]), y, z],
            (Stage::Along(_), _) if self.is_flat() => [x, y, among(2, self.units[2])],
            (Stage::Along(2), _) if self.in_groups(2, 0) => {
                let [x, y] = groups(0, of_x, held(1));
                [x, y, z]
            }
            (Stage::Along(2), _) => [x, among(1, whole_groups(true, n[0])), z],
            (Stage::Along(1), _) => {
                let [x, z] = groups(0, of_x, of_planes());
                [x, y, z]
            }
            (Stage::Along(_), _) if self.in_groups(0, 1) => {
                let [y, z] = groups(1, of_y, of_planes());
                [x, y, z]
            }
            (Stage::Along(_), _) => [x, y, among(2, whole_groups(true, n[1]))],
        })
    }

    /// What a rank has of an axis of the box, or as much as any of them.
    fn held(&self, axis: usize, rank: Option<usize>) -> Range<usize> {
        let part = self.grid.part_along(axis);
        match (part, rank) {
            (Some(_), Some(rank)) => self.grid.of_rank(axis, rank),
            (Some(part), None) => 0..part.planes.div_ceil(part.line.count) + part.layers[0] + part.layers[1],
            (None, _) => 0..self.n[axis],
        }
    }

    /// The cells of this rank, and where they are in a field.
    fn placed(&self, stage: Stage) -> Placed {
        let brick = self.brick(stage, Some(self.parts.share.rank));
        let own = [0, 1, 2].map(|axis| self.grid.own(axis).start);
        let [x, y, z] = self.grid.n;
        match (stage, self.is_flat()) {
            (Stage::Held, true) => Placed {
                brick,
                first: [0, 0, own[2]],
                n: [x * y, 1, z],
            },
            (Stage::Held, false) => Placed {
                brick,
                first: own,
                n: [x, y, z],
            },
            _ => Placed {
                brick,
                first: [0; 3],
                n: brick.extent(),
            },
        }
    }

    /// This rank's cells along each axis of the box on the way along one of them.
    fn along(&self, axis: usize) -> [usize; 3] {
        let n = self.placed(Stage::Along(axis)).n;
        if self.is_flat() && axis < 2 {
            [self.whole.n[0], self.whole.n[1], n[2]]
        } else {
            n
        }
    }

    /// Whether a field is dealt out anew between an axis and the one before.
    fn turns(&self, axis: usize) -> bool {
        axis > 0 && (axis == self.last() || !self.is_flat())
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
    }

    /// Elements of both fields, and of a message, for all turns or those to an axis alone.
    fn lens(&self, is_alone: bool) -> ([usize; 2], usize) {
        let (mut fields, mut message) = ([0; 2], 0);
        let mut add = |[from, to]: [Stage; 2], at: usize| {
            let own = [from, to].map(|stage| self.brick(stage, Some(self.parts.share.rank)));
            fields[at] = own[1].len().max(fields[at]);
            // On the way back they are received.
            for (own, theirs) in [(own[0], to), (own[1], from)] {
                let most = self.brick(theirs, None).extent();
                let meet = own
                    .extent()
                    .into_iter()
                    .zip(most)
                    .map(|(own, most)| own.min(most));
                message = meet.product::<usize>().max(message);
            }
        };
        if is_alone {
            add([Stage::Held, Stage::Along(self.last())], 0);
            if self.parts.rows.is_some() {
                add([Stage::Held, Stage::Rows], 0);
            }
        } else {
            self.each_turn(add);
        }
        (fields, message)
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
            let theirs = source.brick.meet(&self.brick(after, Some(whom)));
            let mine = target.brick.meet(&self.brick(before, Some(whose)));
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

    /// Deals fields out anew where they go on from one axis to another, and exchanges those of now with the next ones then.
    fn go_on<T: Real>(
        &self,
        of: (&dyn Ranks, usize),
        axes: [usize; 2],
        [now, next]: [&mut &mut [T]; 2],
        messages: &mut [&mut [T]; 2],
    ) {
        if self.turns(axes[0].max(axes[1])) {
            let [from, to] = axes.map(Stage::Along);
            self.turn(of, (from, &**now), (to, &mut **next), messages);
            core::mem::swap(now, next);
        }
    }
}

impl<'a, T: Real> Turned<'a, T> {
    /// Takes its workspace for [`Self::across`] of `fields` fields of cells of `grid` from a pool.
    pub fn carve(grid: &Grid, fields: usize, pool: &mut Pool<'a, T>) -> Self {
        let of_deal = Deal::new(grid).map(|deal| deal.lens(false));
        Self::of_lens(of_deal, fields, pool)
    }

    /// Takes that for [`Self::along`].
    pub fn carve_along(grid: &Grid, pool: &mut Pool<'a, T>) -> Self {
        let of_deal = Deal::new(grid).map(|deal| deal.lens(true));
        Self::of_lens(of_deal, 2, pool)
    }

    fn of_lens(lens: Option<([usize; 2], usize)>, fields: usize, pool: &mut Pool<'a, T>) -> Self {
        let Some((of_fields, message)) = lens else {
            return Self::default();
        };
        pool.line("turned for transforms: fields twice, messages", |pool| Self {
            fields: of_fields.map(|len| pool.take("fields", fields * len)),
            messages: [(); 2].map(|()| pool.take("message", message)),
        })
    }

    /// As [`across`](super::transform::across) for each of `fields`, on the threads of `work`, each with a chunk of `scratch`; the copies
    /// of what other ranks have are right then.
    pub fn across(
        &mut self,
        (exec, work): (&dyn Exec, &dyn Exec),
        (grid, spectrum): (&Grid, &Spectrum<'_, T>),
        fields: &mut [T],
        scratch: &mut [T],
        rows: impl Fn(&dyn Exec, RowOf<'_>, &mut [T], &mut [T]) + Sync,
    ) {
        let Some(deal) = Deal::new(grid) else {
            return;
        };
        let (ranks, count) = (exec.ranks(), fields.len() / grid.cells().max(1));
        let (last, messages) = (deal.last(), &mut self.messages);
        let [mut now, mut next] = self.fields.each_mut().map(|field| &mut **field);
        let along = |axis: usize, direction: Direction, fields: &mut [T], scratch: &mut [T]| {
            let n = deal.along(axis);
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
            deal.go_on((ranks, count), [axis, axis - 1], [&mut now, &mut next], messages);
        }
        let (brick, n) = (deal.placed(Stage::Along(0)).brick, deal.along(0));
        let of = |row: usize| {
            let [y, z] = [brick.low[1] + row % n[1].max(1), brick.low[2] + row / n[1].max(1)];
            deal.whole.row(y, z)
        };
        each(work, (count, n), now, scratch, |field, scratch| {
            rows(&Serial, &of, field, scratch);
        });
        for axis in 1..=last {
            deal.go_on((ranks, count), [axis - 1, axis], [&mut now, &mut next], messages);
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
    /// become in `to`; the copies of what other ranks have are right then. It is to have been [carved for that](Self::carve_along).
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
