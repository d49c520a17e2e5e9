//! The one block of memory of a solve, held by bumpalo; the core gets all of it as a slice.

use bumpalo::Bump;
use core::alloc::Layout;
use core::mem::MaybeUninit;
use rayon::prelude::*;
use thurible_core::Plan;

/// What the block may take beyond the planned bytes: alignment, bumpalo's footer and its rounding to pages.
pub const MARGIN: usize = 8192;

/// Bytes that one thread touches at a time, and bytes of a page.
const SHARE: usize = 1 << 21;
const PAGE: usize = 4096;

/// Bytes of a huge page. Neighbouring rows of different planes lie megabytes apart: in small pages nearly each of them needs an
/// address translation of its own.
#[cfg(target_os = "linux")]
const HUGE_PAGE: usize = 1 << 21;

/// Owns the block; nothing else is ever allocated through it.
pub struct Region {
    bump: Bump,
}

impl Region {
    /// Allocates `bytes` bytes with the core's alignment; `None` if the system does not have them.
    pub fn new(bytes: usize) -> Option<Self> {
        let bump = Bump::try_with_capacity(bytes.checked_add(Plan::ALIGN)?).ok()?;
        // A limit equal to what is allocated means that the arena never grows; a smaller one would be ignored.
        bump.set_allocation_limit(Some(bump.allocated_bytes()));
        Some(Region { bump })
    }

    /// Bytes of the block with bumpalo's own.
    pub fn footprint(&self) -> usize {
        self.bump.allocated_bytes_including_metadata()
    }

    /// Exactly `bytes` bytes at the core's alignment, in huge pages where the system has them; `None` if the block has not that many left.
    #[expect(
        unsafe_code,
        reason = "bumpalo hands out a raw pointer for a layout with an alignment above 16"
    )]
    pub fn carve(&mut self, bytes: usize) -> Option<&mut [MaybeUninit<u8>]> {
        let layout = Layout::from_size_align(bytes, Plan::ALIGN).ok()?;
        let start = self.bump.try_alloc_layout(layout).ok()?;
        // SAFETY: bumpalo returned a block of `bytes` bytes that overlaps no other and lives as long as the arena is
        // borrowed, which is here the lifetime of `&mut self`. `MaybeUninit<u8>` needs neither initialisation nor alignment.
        let block =
            unsafe { core::slice::from_raw_parts_mut(start.cast::<MaybeUninit<u8>>().as_ptr(), bytes) };
        #[cfg(target_os = "linux")]
        ask_for_huge_pages(block);
        Some(block)
    }
}

/// Advises the system to give `block` huge pages, but for its ends: what it takes stays within the block, and a refusal changes nothing but speed.
#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "madvise is a call of the system")]
fn ask_for_huge_pages(block: &mut [MaybeUninit<u8>]) {
    let ends = block.as_mut_ptr_range();
    let (before, after) = (ends.start.align_offset(HUGE_PAGE), ends.end.addr() % HUGE_PAGE);
    if let Some(inner) = block
        .len()
        .checked_sub(after)
        .and_then(|end| block.get_mut(before..end))
    {
        // SAFETY: the range lies within a block that is borrowed for writing, and this advice does not change what it holds.
        unsafe { libc::madvise(inner.as_mut_ptr().cast(), inner.len(), libc::MADV_HUGEPAGE) };
    }
}

/// Writes to every page, so that the system provides and clears the pages on all threads.
pub fn touch(block: &mut [MaybeUninit<u8>]) {
    block.par_chunks_mut(SHARE).for_each(|share| {
        share
            .iter_mut()
            .step_by(PAGE)
            .for_each(|byte| *byte = MaybeUninit::new(0))
    });
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

    /// The system notes the advice for the pages in the middle of a block; without its support for it there is nothing to see.
    #[test]
    #[cfg(target_os = "linux")]
    fn block_asks_for_huge_pages() {
        if !std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists() {
            return;
        }
        let mut region = Region::new(8 * HUGE_PAGE).unwrap();
        let middle = region.carve(8 * HUGE_PAGE).unwrap().as_ptr().addr() + 4 * HUGE_PAGE;
        let pages = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut within = false;
        let flags = pages.lines().find(|line| {
            let ends = line
                .split_whitespace()
                .next()
                .and_then(|range| range.split_once('-'));
            if let Some((Ok(start), Ok(end))) =
                ends.map(|(start, end)| (usize::from_str_radix(start, 16), usize::from_str_radix(end, 16)))
            {
                within = (start..end).contains(&middle);
            }
            within && line.starts_with("VmFlags:")
        });
        assert!(
            flags.unwrap().split_whitespace().any(|flag| flag == "hg"),
            "{flags:?}"
        );
    }
}
