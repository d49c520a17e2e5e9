//! Lists of whole numbers in one slice, handed out front to back.

/// Hands out parts of a slice of words.
pub struct Words<'a>(pub &'a mut [u32]);

impl<'a> Words<'a> {
    /// The next `count` words, all zero, or nothing where there are too few.
    pub fn take(&mut self, count: usize) -> Option<&'a mut [u32]> {
        let (taken, rest) = core::mem::take(&mut self.0).split_at_mut_checked(count)?;
        self.0 = rest;
        taken.fill(0);
        Some(taken)
    }
}

/// The part of `list` that belongs to row `row`, of rows that begin where `begin` says.
#[inline(always)]
pub fn row<'a, T>(begin: &[u32], list: &'a [T], row: usize) -> &'a [T] {
    match begin.get(row..row + 2) {
        Some(&[from, to]) => list.get(from as usize..to as usize).unwrap_or(&[]),
        _ => &[],
    }
}

/// Turns counts in `begin[1..]` into where rows begin.
pub fn begin_rows(begin: &mut [u32]) {
    let mut sum = 0;
    for begin in begin {
        sum += *begin;
        *begin = sum;
    }
}

/// Puts `(row, value)` in the lists of their rows; `begin` says where those begin, and does so again afterwards.
pub fn fill_rows(begin: &mut [u32], list: &mut [u32], entries: impl Iterator<Item = (usize, u32)>) {
    for (row, value) in entries {
        if let Some(next) = begin.get_mut(row) {
            if let Some(place) = list.get_mut(*next as usize) {
                *place = value;
            }
            *next += 1;
        }
    }
    begin.rotate_right(1);
    if let Some(first) = begin.first_mut() {
        *first = 0;
    }
}
