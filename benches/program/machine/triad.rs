//! The bandwidth of the machine's memory, by a triad a = b + s c (McCalpin's STREAM).

use crate::prepared::{in_block, no_memory};
use crate::timing::best;
use core::hint::black_box;
use thurible::exit::Failure;
use thurible_core::exec::{RowBuffers, for_rows};
use thurible_core::memory::{Arena, TooSmall};
use thurible_core::{Exec, Serial};

/// Elements of each array of the triad: 64 MiB, more than a core's share of any cache.
const ELEMENTS: usize = 1 << 24;
/// The same where a few seconds must do.
const FEW_ELEMENTS: usize = 1 << 20;
/// Repeats; enough that other programs disturb not all of them.
const REPEATS: usize = 40;
/// Chunks that the threads take.
const CHUNKS: usize = 1 << 8;

/// Elements of each array of the triad.
const fn elements(quick: bool) -> usize {
    if quick { FEW_ELEMENTS } else { ELEMENTS }
}

/// Bytes a second of a = b + s c in f32 on the threads of `exec`, counting two reads and a write, in a block like a solve's.
pub(super) fn triad(exec: &dyn Exec, quick: bool) -> Result<f64, Failure> {
    triad_of(exec, CHUNKS, elements(quick) / CHUNKS)
}

/// As [`triad`], over `rows` rows of `a_row` elements, repeated until a timing has covered [`FEW_ELEMENTS`].
fn triad_of(exec: &dyn Exec, rows: usize, a_row: usize) -> Result<f64, Failure> {
    let elements = rows * a_row;
    let (bytes, passes) = (3 * elements * size_of::<f32>(), FEW_ELEMENTS.div_ceil(elements));
    in_block(bytes, |block| {
        let mut arena = Arena::new(block);
        let mut array = || {
            arena
                .take::<f32>("array", elements)
                .map_err(|TooSmall { .. }| no_memory(bytes))
        };
        let (a, b, c) = (array()?, array()?, array()?);
        b.fill(1.0);
        c.fill(2.0);
        let seconds = best(REPEATS, || {
            for _ in 0..passes {
                for_rows(exec, rows, RowBuffers::fields([&mut *a]), |task| {
                    let [a] = task.fields;
                    let span = task.row * a.len()..(task.row + 1) * a.len();
                    a.iter_mut()
                        .zip(&b[span.clone()])
                        .zip(&c[span])
                        .for_each(|((a, &b), &c)| *a = b + 3.0 * c);
                });
                black_box(&mut *a);
            }
        });
        Ok((passes * bytes) as f64 / seconds)
    })
}

/// How many times as fast all threads of `exec` are as one where they meet after every triad over `rows` rows of `a_row` elements.
///
/// # Errors
/// [`Failure`]: there is no memory for it.
pub fn gain(exec: &dyn Exec, rows: usize, a_row: usize) -> Result<f64, Failure> {
    Ok(triad_of(exec, rows, a_row)? / triad_of(&Serial, rows, a_row)?)
}
