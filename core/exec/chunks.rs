use core::marker::PhantomData;
use core::ops::Range;

/// A slice cut into equal chunks, which tasks take by index.
pub(super) struct Chunks<'a, T> {
    start: *mut T,
    count: usize,
    /// Elements of a chunk.
    size: usize,
    slice: PhantomData<&'a mut [T]>,
}

// SAFETY: `get` hands every chunk to one task only (its caller promises that), so sharing the table is sending `T`s.
unsafe impl<T: Send> Sync for Chunks<'_, T> {}

impl<'a, T> Chunks<'a, T> {
    pub(super) fn new(slice: &'a mut [T], count: usize) -> Self {
        let size = slice.len().checked_div(count).unwrap_or(0);
        Self {
            start: slice.as_mut_ptr(),
            count,
            size,
            slice: PhantomData,
        }
    }

    /// The consecutive chunks of `chunks`, as one slice.
    ///
    /// # Safety
    /// No chunk may be taken again while a slice that holds it lives.
    #[inline(always)]
    pub(super) unsafe fn get(&self, chunks: Range<usize>) -> &'a mut [T] {
        assert!(chunks.start <= chunks.end && chunks.end <= self.count);
        // SAFETY: `end <= count`, so the chunks lie in the slice; the caller keeps chunks disjoint.
        unsafe {
            core::slice::from_raw_parts_mut(
                self.start.add(chunks.start * self.size),
                chunks.len() * self.size,
            )
        }
    }

    /// Where a chunk begins.
    ///
    /// # Safety
    /// Whoever writes there or reads keeps to the chunk, and to what no slice or other task has.
    #[inline(always)]
    pub(super) unsafe fn start(&self, chunk: usize) -> *mut T {
        assert!(chunk < self.count);
        // SAFETY: the chunk lies in the slice.
        unsafe { self.start.add(chunk * self.size) }
    }

    /// One chunk, to be read.
    ///
    /// # Safety
    /// Nobody may write to the chunk while the slice lives.
    #[inline(always)]
    pub(super) unsafe fn peek(&self, chunk: usize) -> &'a [T] {
        assert!(chunk < self.count);
        // SAFETY: the chunk lies in the slice; the caller keeps writers away.
        unsafe { core::slice::from_raw_parts(self.start.add(chunk * self.size), self.size) }
    }
}
