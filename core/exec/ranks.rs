//! Ranks: programs that share one solve, each with a slab or a block of the box, and what they send each other.
//!
//! One verb, [`Ranks::swap`], is all that somebody has to bring, by MPI or in any other way; what else is needed is made of it here: a
//! [value told](tell) to all, the [largest](joined) of all, and a [sum that goes on from rank to rank](in_order), which has the bits of the sum of one
//! program. A program alone has no other to ask: [`Alone`].

use crate::memory::part::{Line, Part, Strips};
use crate::memory::{Held, Plain};
use core::fmt::Debug;
use core::ops::Range;

/// The programs that share a solve, as one of them sees them. All of them call the same functions in the same order.
pub trait Ranks: Sync + Debug {
    /// Number of this one, from 0.
    fn rank(&self) -> usize;
    /// How many there are.
    fn count(&self) -> usize;
    /// How many of them share the memory of this one's machine, itself among them, where that is known.
    fn on_this_machine(&self) -> usize {
        1
    }
    /// Sends `send` to the rank `to`, and fills `receive` with what the rank `from` sends, which has as many bytes; both at once, so that two may
    /// call it for each other. Where there is no such rank nothing is sent, or nothing received. Between two ranks messages arrive in the order in
    /// which they were sent.
    ///
    /// It does not return where a rank was lost: whoever implements it ends the run.
    fn swap(&self, to: Option<usize>, send: &[u8], from: Option<usize>, receive: &mut [u8]);
}

/// One program, which has the whole box.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Ranks for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn count(&self) -> usize {
        1
    }

    fn swap(&self, _: Option<usize>, _: &[u8], _: Option<usize>, _: &mut [u8]) {}
}

/// The ranks of a line, among whom each is known by its place.
#[derive(Debug)]
pub struct Along<'a> {
    ranks: &'a dyn Ranks,
    line: Line,
}

impl<'a> Along<'a> {
    /// Those of this line among all.
    #[must_use]
    pub fn new(ranks: &'a dyn Ranks, line: Line) -> Self {
        Self { ranks, line }
    }
}

impl Ranks for Along<'_> {
    fn rank(&self) -> usize {
        self.line.place
    }

    fn count(&self) -> usize {
        self.line.count
    }

    fn swap(&self, to: Option<usize>, send: &[u8], from: Option<usize>, receive: &mut [u8]) {
        let Line { first, apart, .. } = self.line;
        let [to, from] = [to, from].map(|place| place.map(|place| first + place * apart));
        self.ranks.swap(to, send, from, receive);
    }
}

/// [`Ranks::swap`] of numbers; what is empty is not sent.
pub fn swap<P: Plain>(
    ranks: &dyn Ranks,
    to: Option<usize>,
    send: &[P],
    from: Option<usize>,
    receive: &mut [P],
) {
    let (to, from) = (
        to.filter(|_| !send.is_empty()),
        from.filter(|_| !receive.is_empty()),
    );
    if to.is_some() || from.is_some() {
        ranks.swap(to, bytes(send), from, bytes_mut(receive));
    }
}

/// Everyone's `values` become those of the rank `root`.
pub fn tell<P: Plain>(ranks: &dyn Ranks, root: usize, values: &mut [P]) {
    let count = ranks.count();
    let place = (ranks.rank() + count - root) % count;
    let at = |place: usize| (place + root) % count;
    let mut told = 1;
    while told < count {
        if place < told && place + told < count {
            swap(ranks, Some(at(place + told)), values, None, &mut []);
        } else if (told..2 * told).contains(&place) {
            swap(ranks, None, &[], Some(at(place - told)), values);
        }
        told *= 2;
    }
}

/// All ranks' `value` joined by `join`, in no order that matters.
pub fn joined(ranks: &dyn Ranks, value: f64, join: impl Fn(f64, f64) -> f64) -> f64 {
    let (rank, count) = (ranks.rank(), ranks.count());
    let (mut value, mut apart) = ([value], 1);
    while apart < count {
        if rank % (2 * apart) == apart {
            swap(ranks, Some(rank - apart), &value, None, &mut []);
            break;
        } else if rank + apart < count {
            let mut other = [0.0];
            swap(ranks, None, &[], Some(rank + apart), &mut other);
            value = [join(value[0], other[0])];
        }
        apart *= 2;
    }
    tell(ranks, 0, &mut value);
    value[0]
}

/// Sums that every rank of a line goes on with by `own`, one after the other from the first on; they are those of all in the last one then.
pub fn in_order<P: Plain>(ranks: &dyn Ranks, sums: &mut [P], own: impl FnOnce(&mut [P])) {
    let (rank, count) = (ranks.rank(), ranks.count());
    swap(ranks, None, &[], rank.checked_sub(1), sums);
    own(sums);
    let next = (rank + 1 < count).then_some(rank + 1);
    swap(ranks, next, sums, None, &mut []);
}

/// Brings the copies up to date that a rank has of its neighbours' rows and planes in a field, which has as many values in each of its rows.
pub fn refresh<P: Plain + Default>(ranks: &dyn Ranks, held: Held, field: &mut [P]) {
    let Held::Part { parts, between } = held else {
        return;
    };
    let planes = parts.planes;
    let plane = field.len() / planes.held().max(1);
    // Copies of planes have copies of rows too: they come with them, in the corners.
    if let Some(rows) = parts.rows {
        let width = plane / rows.held().max(1);
        let of = |strip: Range<usize>| Strips::of(planes.own(), [strip, 0..rows.held()], width);
        refresh_along(&Along::new(ranks, rows.line), rows, of, between[1], field);
    }
    let of = |strip: Range<usize>| Strips::of(strip, [0..1, 0..1], plane);
    refresh_along(&Along::new(ranks, planes.line), planes, of, between[0], field);
}

/// The same along one axis, where `of` tells where some rows or planes are.
fn refresh_along<P: Plain + Default>(
    line: &dyn Ranks,
    part: Part,
    of: impl Fn(Range<usize>) -> Strips,
    between: bool,
    field: &mut [P],
) {
    let (own, reach, held) = (part.own(), part.reach, part.held());
    let [below, above] = part.neighbours();
    let [low, high] = [of(0..own.start), of(own.end..held)];
    let [first, last] = [
        of(own.start..own.start + reach),
        of(own.end.saturating_sub(reach)..own.end),
    ];
    swap_strips(line, (below, first), (above, high), field);
    swap_strips(line, (above, last), (below, low), field);
    if between && own.start > 0 {
        of(0..1)
            .ranges()
            .for_each(|range| some_mut(field, range).fill(P::default()));
    }
}

/// Values of strips that are put together for a message; those that are longer are sent as they are, one in each.
const MESSAGE: usize = 1 << 10;

/// [`swap`] of some strips of a field for as many others of it, as long as they.
fn swap_strips<P: Plain + Default>(
    line: &dyn Ranks,
    (to, sent): (Option<usize>, Strips),
    (from, received): (Option<usize>, Strips),
    field: &mut [P],
) {
    if sent.len.max(received.len) >= MESSAGE || sent.count == 1 {
        for (sent, received) in sent.ranges().zip(received.ranges()) {
            let (send, receive) = apart(field, sent, received);
            swap(line, to, send, from, receive);
        }
        return;
    }
    let [sends, receives] =
        [(to, sent), (from, received)].map(|(whom, strips)| if whom.is_some() { strips.total() } else { 0 });
    let mut packed = [[P::default(); MESSAGE]; 2];
    for begin in (0..sends.max(receives)).step_by(MESSAGE) {
        let [send, receive] = &mut packed;
        let [of_send, of_receive] = [sends, receives].map(|total| total.saturating_sub(begin).min(MESSAGE));
        sent.pieces(begin, of_send, |inside, place| {
            copy(some(field, inside), some_mut(send, place));
        });
        let receive = some_mut(receive, 0..of_receive);
        swap(line, to, some(send, 0..of_send), from, receive);
        received.pieces(begin, of_receive, |inside, place| {
            copy(some(receive, place), some_mut(field, inside));
        });
    }
}

/// Two ranges of a field that do not overlap, one to read and one to write.
fn apart<P>(field: &mut [P], read: Range<usize>, write: Range<usize>) -> (&[P], &mut [P]) {
    let (low, high) = field
        .split_at_mut_checked(read.start.max(write.start))
        .unwrap_or_default();
    if read.start < write.start {
        (some(low, read), some_mut(high, 0..write.len()))
    } else {
        (some(high, 0..read.len()), some_mut(low, write))
    }
}

/// Some values of a field; none where it does not reach so far.
fn some<P>(field: &[P], range: Range<usize>) -> &[P] {
    field.get(range).unwrap_or(&[])
}

/// As [`some`], to write.
fn some_mut<P>(field: &mut [P], range: Range<usize>) -> &mut [P] {
    field.get_mut(range).unwrap_or(&mut [])
}

fn copy<P: Copy>(from: &[P], to: &mut [P]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
}

fn bytes<P: Plain>(values: &[P]) -> &[u8] {
    // SAFETY: a `Plain` number has no bytes but its own, all of them initialised.
    unsafe { core::slice::from_raw_parts(values.as_ptr().cast::<u8>(), size_of_val(values)) }
}

fn bytes_mut<P: Plain>(values: &mut [P]) -> &mut [u8] {
    let len = size_of_val(values);
    // SAFETY: as in `bytes`, and any bytes are a number of a `Plain` type.
    unsafe { core::slice::from_raw_parts_mut(values.as_mut_ptr().cast::<u8>(), len) }
}
