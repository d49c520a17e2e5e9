//! The one block of memory of a solve, held by bumpalo; the core is handed all of it as a slice.

use bumpalo::Bump;
use core::alloc::Layout;
use core::mem::MaybeUninit;
use rayon::prelude::*;
use thurible_core::Plan;

/// What the block may take beyond the planned bytes: alignment, bumpalo's footer and its rounding to pages.
pub const MARGIN: usize = 8192;

/// What one thread asks the system for at a time, and the least that a system gives.
const SHARE: usize = 1 << 21;
const PAGE: usize = 4096;

/// Owns the block; nothing else is ever allocated through it.
pub struct Region {
    bump: Bump,
}

impl Region {
    /// Takes room for `bytes` bytes aligned for the core, or `None` if the system has not that much.
    pub fn new(bytes: usize) -> Option<Self> {
        let bump = Bump::try_with_capacity(bytes.checked_add(Plan::ALIGN)?).ok()?;
        // A limit below what is allocated already would be ignored; exactly that much means "never grow".
        bump.set_allocation_limit(Some(bump.allocated_bytes()));
        Some(Region { bump })
    }

    /// What the block really takes, bumpalo's own bytes included.
    pub fn footprint(&self) -> usize {
        self.bump.allocated_bytes_including_metadata()
    }

    /// Exactly `bytes` bytes at the core's alignment; `None` if the block has not that many left.
    #[expect(unsafe_code, reason = "bumpalo hands out a raw pointer for a layout with an alignment above 16")]
    pub fn carve(&mut self, bytes: usize) -> Option<&mut [MaybeUninit<u8>]> {
        let layout = Layout::from_size_align(bytes, Plan::ALIGN).ok()?;
        let start = self.bump.try_alloc_layout(layout).ok()?;
        // SAFETY: bumpalo returned a block of `bytes` bytes that overlaps no other and lives as long as the arena is
        // borrowed, which is here the lifetime of `&mut self`. `MaybeUninit<u8>` needs neither initialisation nor alignment.
        Some(unsafe { core::slice::from_raw_parts_mut(start.cast::<MaybeUninit<u8>>().as_ptr(), bytes) })
    }
}

/// Writes to every page, so that the system clears them on all threads instead of on the one that clears the block.
pub fn touch(block: &mut [MaybeUninit<u8>]) {
    block.par_chunks_mut(SHARE).for_each(|share| share.iter_mut().step_by(PAGE).for_each(|byte| *byte = MaybeUninit::new(0)));
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    #[test]
    fn block_is_aligned_exact_and_does_not_grow() {
        for bytes in [0, 1, 64, 1000, 1 << 20, (1 << 20) + 1] {
            let mut region = Region::new(bytes).unwrap();
            assert!(region.footprint() <= bytes + MARGIN);
            let block = region.carve(bytes).unwrap();
            assert_eq!(block.len(), bytes);
            assert_eq!(block.as_ptr().addr() % Plan::ALIGN, 0);
            let before = region.footprint();
            assert!(region.carve(MARGIN).is_none());
            assert_eq!(region.footprint(), before);
        }
    }
}
