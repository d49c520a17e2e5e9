//! What the ranks of a solve tell each other beside what the numerics exchange: what is to be done, and their parts of fields.
//!
//! Rank 0 is given whole fields and gives whole fields, in the layout of a file; every rank keeps its own part of them. Before it does anything
//! that takes them all it tells the others its verb.

use super::layout::{FileLayout, of_rank, put_solids};
use crate::exec::Ranks;
use crate::exec::ranks::{Alone, refresh, swap, tell};
use crate::field::rows::{self, part, part_mut};
use crate::field::sums;
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::memory::part::Strips;
use crate::memory::{Held, Plain};
use crate::observe::{Event, Observer};
use crate::real::Real;
use core::ops::ControlFlow;

/// What the first rank asks the others to do with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verb {
    Solids,
    Source,
    Emitter,
    Part,
    Velocity,
    Keyframe,
    Mass,
    Prepare,
    Step,
    Finish,
    Read,
    Given,
    Emission,
    Jet,
    GoOn,
    Guess,
    Begin,
    Price,
    Save,
    Restore,
    End,
}

impl Verb {
    /// All of them, each at its number.
    pub const ALL: [Self; 21] = [
        Self::Solids,
        Self::Source,
        Self::Emitter,
        Self::Part,
        Self::Velocity,
        Self::Keyframe,
        Self::Mass,
        Self::Prepare,
        Self::Step,
        Self::Finish,
        Self::Read,
        Self::Given,
        Self::Emission,
        Self::Jet,
        Self::GoOn,
        Self::Guess,
        Self::Begin,
        Self::Price,
        Self::Save,
        Self::Restore,
        Self::End,
    ];
}

/// A verb that is not at its number would have the others do something else: it does not compile.
const _: () = {
    let mut number = 0;
    while number < Verb::ALL.len() {
        assert!(Verb::ALL[number] as usize == number);
        number += 1;
    }
};

/// The ranks of a solve, where it is shared, and room for this one's part of a component of a field.
#[derive(Debug, Default)]
pub(super) struct Shared<'m, T> {
    pub ranks: Option<&'m dyn Ranks>,
    pub piece: &'m mut [T],
    /// Which cells are solid, in the layout of a file: of the whole box in the first rank, and in the others of their own part; none where there is no
    /// room for any.
    pub solid: &'m mut [u8],
}

/// Elements of a component in the layout of a file that a rank has: the faces of `axis`, or cells.
fn piece_of(grid: &Grid, axis: Option<usize>, rank: usize) -> Strips {
    let (whole, last) = (grid.whole(), grid.dims - 1);
    let layout = FileLayout::of(&whole, axis);
    // A file has no layers outside.
    let own = |along: usize| {
        let (own, begin) = (
            of_rank(grid, axis, (along, rank)),
            whole.axis(along).inside().start,
        );
        own.start - begin..own.end - begin
    };
    match grid.part_along(last - 1) {
        Some(_) => Strips::of(
            own(last),
            [own(last - 1), 0..layout.extent(last - 1)],
            layout.extent(0),
        ),
        None => {
            let plane = (0..last).map(|axis| layout.extent(axis)).product();
            Strips::of(own(last), [0..1, 0..1], plane)
        }
    }
}

/// Elements of the largest component of this rank's part, which it needs room for where the first one has the whole.
pub(super) fn piece_len(grid: &Grid) -> usize {
    let rank = grid.parts().map_or(0, |parts| parts.share.rank);
    let axes = (0..grid.dims).map(Some).chain([None]);
    let parts = axes.map(|axis| piece_of(grid, axis, rank).total());
    if rank == 0 { 0 } else { parts.max().unwrap_or(0) }
}

/// Cells whose flags a rank keeps, where there may be solid ones.
pub(super) fn solid_len(grid: &Grid) -> usize {
    match grid.parts().map(|parts| parts.share.rank) {
        None => 0,
        Some(0) => FileLayout::of_cells(&grid.whole()).len(),
        Some(rank) => piece_of(grid, None, rank).total(),
    }
}

/// Sends a rank some strips of values, one after the other.
fn send_strips<P: Plain>(ranks: &dyn Ranks, to: usize, strips: Strips, values: &[P]) {
    strips
        .ranges()
        .for_each(|range| swap(ranks, Some(to), part(values, range), None, &mut []));
}

/// Receives what [`send_strips`] sends, which may be elsewhere here.
fn take_strips<P: Plain>(ranks: &dyn Ranks, from: usize, strips: Strips, values: &mut [P]) {
    strips
        .ranges()
        .for_each(|range| swap(ranks, None, &[], Some(from), part_mut(values, range)));
}

impl<T: Real> Shared<'_, T> {
    /// Whether a cell is solid, by its place in a file, as the first rank knows it.
    pub fn is_solid(&self, place: usize) -> bool {
        self.solid.get(place).is_some_and(|&solid| solid != 0)
    }

    /// Sets which cells are solid, of which the first rank is given the flags of all.
    pub fn put_solids(&mut self, ranks: &dyn Ranks, levels: &mut Levels<'_, T>, given: &[bool]) {
        let grid = levels.finest;
        self.solid
            .iter_mut()
            .zip(given)
            .for_each(|(solid, &given)| *solid = u8::from(given));
        let piece = |rank| piece_of(&grid, None, rank);
        if ranks.rank() == 0 {
            let solid = &*self.solid;
            (1..ranks.count()).for_each(|rank| send_strips(ranks, rank, piece(rank), solid));
        } else {
            take_strips(ranks, 0, piece(ranks.rank()).packed(), &mut *self.solid);
        }
        put_solids(ranks, levels, self.solid);
    }

    /// Whether this is the rank that is asked, or there is no other.
    pub fn is_first(&self) -> bool {
        self.ranks.is_none_or(|ranks| ranks.rank() == 0)
    }

    /// Tells the others what is to be done.
    pub fn ask(&self, verb: Verb, of: [usize; 3]) {
        if let Some(ranks) = self.ranks.filter(|ranks| ranks.rank() == 0) {
            tell(ranks, 0, &mut [verb as usize, of[0], of[1], of[2]]);
        }
    }

    /// What the first rank says.
    pub fn told<P: Plain>(&self, value: P) -> P {
        let mut value = [value];
        if let Some(ranks) = self.ranks {
            tell(ranks, 0, &mut value);
        }
        value[0]
    }

    /// The largest of all ranks' values.
    pub fn largest(&self, value: f64) -> f64 {
        self.ranks.map_or(value, |ranks| sums::largest_of(ranks, value))
    }

    /// The sum over all cells of a field.
    pub fn mass(&self, grid: &Grid, field: &[T]) -> f64 {
        let (n, mut sum) = (grid.n[0], [0.0]);
        let ranks = self.ranks.unwrap_or(&Alone);
        sums::over_rows(ranks, grid, &mut sum, |row, _| {
            rows::sum(part(field, row * n..(row + 1) * n))
        });
        sum[0]
    }

    /// A field of one time level from what the first rank is given of it in the layout of a file, times `unit`: of the faces of `axis`, or of cells.
    pub fn put(&mut self, place: (&Grid, Option<usize>), given: &[T], unit: T, field: &mut [T]) {
        self.put_slot(place, given, unit, field, [1, 0]);
        if let (Some(ranks), (grid, axis)) = (self.ranks, place) {
            refresh(ranks, Held::of(grid.parts(), grid.dims, axis), field);
        }
    }

    /// The same to time level `slot` of a trajectory of `slots`, whose copies are left to the caller.
    pub fn put_slot(
        &mut self,
        (grid, axis): (&Grid, Option<usize>),
        given: &[T],
        unit: T,
        field: &mut [T],
        slot: [usize; 2],
    ) {
        let layout = FileLayout::of(grid, axis);
        let Some(ranks) = self.ranks else {
            return layout.write_slot(given, unit, field, slot);
        };
        let piece = |rank| piece_of(grid, axis, rank);
        if ranks.rank() == 0 {
            (1..ranks.count()).for_each(|rank| send_strips(ranks, rank, piece(rank), given));
            layout.first_of_whole().write_slot(given, unit, field, slot);
        } else {
            let piece = piece(ranks.rank());
            let own = part_mut(self.piece, 0..piece.total());
            take_strips(ranks, 0, piece.packed(), own);
            layout.write_slot(own, unit, field, slot);
        }
    }

    /// Collects in `out` of the first rank what `own` writes of each rank's part, in the layout of a file; the others [send](Self::send) theirs.
    pub fn collect(
        &self,
        (grid, axis): (&Grid, Option<usize>),
        out: &mut [T],
        own: impl FnOnce(&FileLayout<'_>, &mut [T]),
    ) {
        let layout = FileLayout::of(grid, axis);
        let Some(ranks) = self.ranks else {
            return own(&layout, out);
        };
        // Beyond the last rows and planes stands what is on a wall.
        out.fill(T::ZERO);
        own(&layout.first_of_whole(), out);
        for rank in 1..ranks.count() {
            take_strips(ranks, rank, piece_of(grid, axis, rank), out);
        }
    }

    /// Sends what `own` writes of this rank's part to the first rank, which collects it.
    pub fn send(
        &mut self,
        (grid, axis): (&Grid, Option<usize>),
        own: impl FnOnce(&FileLayout<'_>, &mut [T]),
    ) {
        if let Some(ranks) = self.ranks {
            let piece = piece_of(grid, axis, ranks.rank());
            let out = part_mut(self.piece, 0..piece.total());
            own(&FileLayout::of(grid, axis), out);
            send_strips(ranks, 0, piece.packed(), out);
        }
    }
}

/// An observer whom the first rank asks for all.
pub(super) struct Heard<'a> {
    pub observer: &'a mut dyn Observer,
    pub ranks: Option<&'a dyn Ranks>,
}

impl Observer for Heard<'_> {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        let Some(ranks) = self.ranks else {
            return self.observer.on(event);
        };
        let mut stops = [usize::from(
            ranks.rank() == 0 && self.observer.on(event).is_break(),
        )];
        tell(ranks, 0, &mut stops);
        if stops == [0] {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    }
}
