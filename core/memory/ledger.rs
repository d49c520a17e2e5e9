//! The ledger: every buffer of a solve by name, together (sum) or in turn (max), to the byte.

use super::footprint::footprint;
use heapless::Vec;

/// Bytes of the checksum that a checkpoint puts after each field.
pub const CHECK: usize = 8;

/// Most lines of a [`Ledger`].
pub const MAX_LINES: usize = 128;

/// How the children of a line share its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharing {
    /// A buffer: no children.
    Buffer,
    /// The children live together; their bytes add up.
    Together,
    /// The children live one after the other; the largest counts.
    InTurn,
}

/// One line of the ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// What it holds.
    pub name: &'static str,
    /// Bytes, children included.
    pub bytes: usize,
    /// Depth in the tree, 0 at the top.
    pub depth: usize,
    /// Buffer or group.
    pub sharing: Sharing,
}

/// A tree of buffers with their sizes. Sizes that do not fit `usize` saturate, and [`Ledger::bytes`] is then `None`.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    entries: Vec<Entry, MAX_LINES>,
    open: Vec<usize, 10>,
    /// Bytes of buffers that a checkpoint keeps.
    kept: usize,
    overflow: bool,
}

impl Ledger {
    /// An empty ledger.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A buffer of `len` values of `size` bytes.
    pub fn line(&mut self, name: &'static str, len: usize, size: usize) {
        let bytes = footprint(len, size).unwrap_or_else(|| {
            self.overflow = true;
            usize::MAX
        });
        self.push(name, bytes, Sharing::Buffer);
        self.count(bytes);
    }

    /// A group of lines that `fill` writes. Of a group that is itself a buffer, the parts are counted but not listed.
    pub fn group(&mut self, name: &'static str, sharing: Sharing, fill: impl FnOnce(&mut Self)) {
        self.open(name, sharing);
        fill(self);
        self.close();
    }

    /// Begins a group.
    pub(super) fn open(&mut self, name: &'static str, sharing: Sharing) {
        // Parts of a line are added up in the line.
        let index = match self.open.last() {
            Some(&line) if self.in_one_line() => line,
            _ => {
                self.push(name, 0, sharing);
                self.entries.len().saturating_sub(1)
            }
        };
        self.overflow |= self.open.push(index).is_err();
    }

    /// Ends the group that was begun last.
    pub(super) fn close(&mut self) {
        let Some(index) = self.open.pop() else { return };
        if self.open.last() != Some(&index) {
            let bytes = self.entries.get(index).map_or(0, |entry| entry.bytes);
            self.count(bytes);
        }
    }

    /// A vector field, `len` elements of `size` bytes for each of `dims` axes.
    pub fn vector(&mut self, name: &'static str, dims: usize, len: usize, size: usize) {
        self.group(name, Sharing::Together, |ledger| {
            for axis in ["along x", "along y", "along z"].into_iter().take(dims) {
                ledger.line(axis, len, size);
            }
        });
    }

    /// A buffer of `len` values of `size` bytes that a checkpoint keeps.
    pub fn keep(&mut self, name: &'static str, len: usize, size: usize) {
        self.line(name, len, size);
        self.count_kept(len, size);
    }

    /// Counts a field of `len` values of `size` bytes, with its checksum, among those that a checkpoint keeps.
    pub fn count_kept(&mut self, len: usize, size: usize) {
        let check = if len > 0 { CHECK } else { 0 };
        match len
            .checked_mul(size)
            .and_then(|bytes| self.kept.checked_add(bytes)?.checked_add(check))
        {
            Some(kept) => self.kept = kept,
            None => self.overflow = true,
        }
    }

    /// Whether what is counted now are parts of one line.
    fn in_one_line(&self) -> bool {
        let open = self.open.last().and_then(|&index| self.entries.get(index));
        open.is_some_and(|entry| entry.sharing == Sharing::Buffer)
    }

    fn push(&mut self, name: &'static str, bytes: usize, sharing: Sharing) {
        if self.in_one_line() {
            return;
        }
        let depth = self.open.len();
        let entry = Entry {
            name,
            bytes,
            depth,
            sharing,
        };
        self.overflow |= self.entries.push(entry).is_err();
    }

    /// Counts `bytes` in the group that is open.
    fn count(&mut self, bytes: usize) {
        if let Some(group) = self.open.last().and_then(|&index| self.entries.get_mut(index)) {
            match group.sharing {
                Sharing::InTurn => group.bytes = group.bytes.max(bytes),
                _ => match group.bytes.checked_add(bytes) {
                    Some(sum) => group.bytes = sum,
                    None => self.overflow = true,
                },
            }
        }
    }

    /// Bytes of the buffers that a checkpoint keeps, or `None` when they do not fit `usize`.
    #[must_use]
    pub fn kept(&self) -> Option<usize> {
        (!self.overflow).then_some(self.kept)
    }

    /// [`Self::bytes`] in elements of `size` bytes; what no memory holds where they do not fit `usize`.
    #[must_use]
    pub fn elements(&self, size: usize) -> usize {
        self.bytes().map_or(usize::MAX / 16, |bytes| bytes / size)
    }

    /// The lines in order, groups before their children.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The sum of the top lines, or `None` when it does not fit `usize`.
    #[must_use]
    pub fn bytes(&self) -> Option<usize> {
        if self.overflow {
            return None;
        }
        self.entries
            .iter()
            .filter(|entry| entry.depth == 0)
            .try_fold(0usize, |sum, entry| sum.checked_add(entry.bytes))
            // No slice is longer.
            .filter(|&bytes| isize::try_from(bytes).is_ok())
    }
}
