//! Lists of the caller, copied into the block behind a handle.

use core::mem::MaybeUninit;

/// What every list begins on.
const GRAIN: usize = align_of::<f64>();

/// Bytes that a list of `count` entries takes there, if they can be counted.
#[must_use]
pub fn kept_bytes<V: Copy>(count: usize) -> Option<usize> {
    count.checked_mul(size_of::<V>())?.checked_next_multiple_of(GRAIN)
}

/// Puts the first `count` of `values` to the front of `memory`, whatever of that is left; nothing where there is no room, or are fewer values.
pub fn keep<V: Copy>(
    memory: &mut &'static mut [MaybeUninit<u8>],
    count: usize,
    values: impl IntoIterator<Item = V>,
) -> Option<&'static mut [V]> {
    let (own, rest) = core::mem::take(memory).split_at_mut_checked(kept_bytes::<V>(count)?)?;
    *memory = rest;
    let place: *mut MaybeUninit<V> = own.as_mut_ptr().cast();
    if !place.is_aligned() {
        return None;
    }
    // SAFETY: aligned, as many bytes as the entries take, and nobody else's; nothing is read of what may hold anything.
    let room = unsafe { core::slice::from_raw_parts_mut(place, count) };
    let written = room.iter_mut().zip(values).map(|(to, value)| to.write(value));
    if written.count() < count {
        return None;
    }
    // SAFETY: every entry was written.
    Some(unsafe { core::slice::from_raw_parts_mut(place.cast(), count) })
}
