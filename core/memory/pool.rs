//! Parts of one buffer, handed out front to back: what the phases of a solve use in turn.

/// Hands out parts of one slice of numbers, front to back: the buffers of a phase within the bytes that phases share.
#[derive(Debug)]
pub struct Pool<'a, T> {
    rest: &'a mut [T],
}

/// Numbers that `len` take in a [`Pool`], kept to whole cache lines of the narrower precision.
#[must_use]
pub const fn pooled(len: usize) -> usize {
    len.next_multiple_of(16)
}

impl<'a, T> Pool<'a, T> {
    /// A pool over `numbers`.
    pub fn new(numbers: &'a mut [T]) -> Self {
        Self { rest: numbers }
    }

    /// The next `len` numbers, with whatever they hold.
    pub fn take(&mut self, len: usize) -> &'a mut [T] {
        let (taken, rest) = core::mem::take(&mut self.rest).split_at_mut(pooled(len));
        self.rest = rest;
        &mut taken[..len]
    }

    /// What is left.
    #[must_use]
    pub fn into_rest(self) -> &'a mut [T] {
        self.rest
    }

    /// One part for each axis of a vector field, empty for the axes that a 2D field has not.
    pub fn take_vector(&mut self, dims: usize, len: usize) -> [&'a mut [T]; 3] {
        core::array::from_fn(|axis| {
            if axis < dims {
                self.take(len)
            } else {
                Default::default()
            }
        })
    }
}
