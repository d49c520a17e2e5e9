//! Which free vertices a column of a basis reaches: all, or those within a few edges.

use super::ordering::Marks;
use super::words::row;

/// Where the row of each free vertex begins, and those that it is joined to.
pub type Rows<'a> = (&'a [u32], &'a [u32]);

/// How many numbers patches take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Free vertices of all patches.
    pub total: usize,
    /// Those of the largest.
    pub largest: usize,
}

/// The members of each column, in ascending order.
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    /// Where the patch of each free vertex begins; empty where all reach all.
    pub begin: &'a [u32],
    pub members: &'a [u32],
    pub free: usize,
}

impl<'a> Columns<'a> {
    /// How many members the column of free vertex `number` has, and how many those before it have.
    #[inline(always)]
    pub fn extent(&self, number: usize) -> (usize, usize) {
        match self.begin.get(number..number + 2) {
            Some(&[from, to]) => (from as usize, (to - from) as usize),
            _ => (number * self.free, self.free),
        }
    }

    /// Member `local` of the column of free vertex `number`.
    #[inline(always)]
    pub fn member(&self, number: usize, local: usize) -> usize {
        if self.begin.is_empty() {
            return local;
        }
        let members = row(self.begin, self.members, number);
        members.get(local).copied().unwrap_or_default() as usize
    }

    /// Where free vertex `other` is among the members of the column of `number`.
    #[inline(always)]
    pub fn local(&self, number: usize, other: usize) -> Option<usize> {
        if self.begin.is_empty() {
            return Some(other);
        }
        row(self.begin, self.members, number)
            .binary_search(&(other as u32))
            .ok()
    }
}

/// Writes the free vertices within `radius` edges of `number` into `list`, from its start on, in ascending order; how many there are. Where the list is
/// full it ends.
pub fn patch(rows: Rows<'_>, number: usize, radius: usize, marks: &mut Marks<'_>, list: &mut [u32]) -> usize {
    marks.renew();
    marks.mark(number);
    let Some(first) = list.first_mut() else { return 0 };
    *first = number as u32;
    let (mut begin, mut count) = (0, 1);
    for _ in 0..radius {
        let end = count;
        for at in begin..end {
            let from = list.get(at).copied().unwrap_or_default() as usize;
            for &other in row(rows.0, rows.1, from) {
                if marks.mark(other as usize)
                    && let Some(place) = list.get_mut(count)
                {
                    *place = other;
                    count += 1;
                }
            }
        }
        if count == end {
            break;
        }
        begin = end;
    }
    list.get_mut(..count).unwrap_or(&mut []).sort_unstable();
    count
}

/// Counts the patches of `radius` edges; `marks` and `list` have a word for each free vertex.
pub fn count(rows: Rows<'_>, radius: usize, marks: &mut Marks<'_>, list: &mut [u32]) -> Counted {
    let mut counted = Counted::default();
    for number in 0..rows.0.len().saturating_sub(1) {
        let size = patch(rows, number, radius, marks, list);
        counted.total += size;
        counted.largest = counted.largest.max(size);
    }
    counted
}

/// Writes the patches of `radius` edges.
pub fn fill(rows: Rows<'_>, radius: usize, marks: &mut [u32], begin: &mut [u32], members: &mut [u32]) {
    let mut marks = Marks::new(marks);
    let mut count = 0;
    for number in 0..rows.0.len().saturating_sub(1) {
        let rest = members.get_mut(count..).unwrap_or(&mut []);
        count += patch(rows, number, radius, &mut marks, rest);
        if let Some(end) = begin.get_mut(number + 1) {
            *end = count as u32;
        }
    }
}
