//! Ranks: programs that share one solve, each with a slab of the box, and what they send each other.
//!
//! One verb, [`Ranks::swap`], is all that somebody has to bring, by MPI or in any other way; what else is needed is made of it here: a
//! [value told](tell) to all, the [largest](joined) of all, and a [sum that goes on from rank to rank](in_order), which has the bits of the sum of one
//! program. A program alone has no other to ask: [`Alone`].

use crate::memory::{Held, Plain};
use core::fmt::Debug;

/// The programs that share a solve, as one of them sees them. All of them call the same functions in the same order.
pub trait Ranks: Sync + Debug {
    /// Number of this one, from 0.
    fn rank(&self) -> usize;
    /// How many there are.
    fn count(&self) -> usize;
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

/// Sums that every rank goes on with by `own`, one after the other from rank 0; then all have the sums that the last one leaves.
pub fn in_order(ranks: &dyn Ranks, sums: &mut [f64], own: impl FnOnce(&mut [f64])) {
    let (rank, count) = (ranks.rank(), ranks.count());
    swap(ranks, None, &[], rank.checked_sub(1), sums);
    own(sums);
    let next = (rank + 1 < count).then_some(rank + 1);
    swap(ranks, next, sums, None, &mut []);
    tell(ranks, count - 1, sums);
}

/// Brings the copies up to date that a rank has of its neighbours' planes in a field, which has as many values in each of them.
pub fn refresh<P: Plain + Default>(ranks: &dyn Ranks, held: Held, field: &mut [P]) {
    let (Held::Planes(part) | Held::Between(part)) = held else {
        return;
    };
    let plane = field.len() / part.held().max(1);
    let (own, reach) = (part.own(), part.share.reach * plane);
    let [below, above] = part.neighbours();
    let (rest, high) = field.split_at_mut(own.end * plane);
    let (low, rest) = rest.split_at_mut(own.start * plane);
    let copied = |neighbour: Option<usize>| if neighbour.is_some() { reach } else { 0 };
    let first = rest.get(..copied(below)).unwrap_or(&[]);
    swap(ranks, below, first, above, high);
    let last = rest
        .get(rest.len().saturating_sub(copied(above))..)
        .unwrap_or(&[]);
    swap(ranks, above, last, below, low);
    if let (Held::Between(_), Some(lowest)) = (held, low.get_mut(..plane)) {
        lowest.fill(P::default());
    }
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
