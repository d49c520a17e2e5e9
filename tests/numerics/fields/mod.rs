//! What the tests of the core share: memory, threads, random numbers, fields and a plain second implementation.

pub mod carry;
pub mod cases;
pub mod channels;
pub mod control;
pub mod cubic;
pub mod effects;
pub mod feasible;
pub mod flow;
pub mod local;
pub mod naive;
mod plaquettes;
pub mod random;
pub mod spacetime;

use core::mem::MaybeUninit;
use thurible::threads;
use thurible_core::grid::Grid;
use thurible_core::{Boundary, Exec, Plan, Real};

/// A block of bytes for the core, aligned as it asks.
pub struct Memory {
    bytes: Vec<MaybeUninit<u8>>,
    start: usize,
    len: usize,
}

impl Memory {
    /// `len` bytes, all `fill`.
    pub fn filled(len: usize, fill: u8) -> Self {
        let bytes = vec![MaybeUninit::new(fill); len + 2 * Plan::ALIGN];
        let start = bytes.as_ptr().align_offset(Plan::ALIGN);
        Memory { bytes, start, len }
    }

    /// `len` bytes of rubbish.
    pub fn new(len: usize) -> Self {
        Self::filled(len, 0xA5)
    }

    pub fn block(&mut self) -> &mut [MaybeUninit<u8>] {
        self.shifted(0)
    }

    /// A block that begins `by` bytes after the alignment.
    pub fn shifted(&mut self, by: usize) -> &mut [MaybeUninit<u8>] {
        &mut self.bytes[self.start + by..][..self.len]
    }
}

/// Calls `work` with an [`Exec`] of `threads` real threads.
pub fn with_threads<R: Send>(threads: usize, work: impl FnOnce(&dyn Exec) -> R + Send) -> R {
    threads::with(threads, || threads::together(threads, work)).unwrap()
}

/// Gives the head of a checkpoint the checksum that belongs to it: a second implementation of it.
pub fn seal(bytes: &mut [u8]) {
    let step = |lane: u64, word: u64| (lane ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
    let mut lanes = [1, 2, 3, 4];
    for part in [&bytes[..32], &bytes[40..thurible_core::checkpoint::HEAD]] {
        let mut words: Vec<u64> = Vec::new();
        let mut padded = part.to_vec();
        padded.resize(part.len() / 32 * 32 + 32, 0);
        words.extend(
            padded
                .chunks_exact(8)
                .map(|word| u64::from_le_bytes(word.try_into().unwrap())),
        );
        words.push(part.len() as u64);
        for word in words {
            let [a, b, c, d] = lanes;
            lanes = [b, c, d, step(a, word)];
        }
    }
    let all = lanes.into_iter().fold(0, step);
    bytes[32..40].copy_from_slice(&(all ^ all >> 32).to_le_bytes());
}

/// A grid from cells and, axis by axis, `w` for walls or `p` for periodic.
pub fn grid(cells: &[usize], ends: &str) -> Grid {
    Grid::new(cells, &boundaries(ends))
}

/// `w` for walls, `p` for periodic, `o`, `l` and `h` for open on both sides, the low and the high one.
pub fn boundaries(ends: &str) -> Vec<Boundary> {
    ends.chars()
        .map(|end| match end {
            'p' => Boundary::Periodic,
            'o' => Boundary::Open,
            'l' => Boundary::OpenLow,
            'h' => Boundary::OpenHigh,
            _ => Boundary::Wall,
        })
        .collect()
}

/// The components of a vector field; the third is empty in 2D.
pub type Components<T> = [Vec<T>; 3];

/// The components as slices to read.
pub fn view<T>(v: &Components<T>) -> [&[T]; 3] {
    v.each_ref().map(|component| &component[..])
}

/// The components as slices to write.
pub fn view_mut<T>(v: &mut Components<T>) -> [&mut [T]; 3] {
    v.each_mut().map(|component| &mut component[..])
}

/// A component as a file has it: with the high wall face.
pub fn to_file(grid: &Grid, axis: usize, v: &[f64]) -> Vec<f64> {
    let extent = |a: usize| grid.n[a] + usize::from(a == axis && !grid.axis(a).is_ring());
    let count: usize = (0..3).map(extent).product();
    let number = |i: usize| {
        let at = [
            i % extent(0),
            i / extent(0) % extent(1),
            i / extent(0) / extent(1),
        ];
        if at[axis] == grid.n[axis] {
            0.0
        } else {
            v[(at[2] * grid.n[1] + at[1]) * grid.n[0] + at[0]]
        }
    };
    (0..count).map(number).collect()
}

/// Zeros in as many components as the grid has axes.
pub fn zeros<T: Real>(grid: &Grid, slots: usize) -> Components<T> {
    core::array::from_fn(|a| {
        if a < grid.dims {
            vec![T::ZERO; grid.cells() * slots]
        } else {
            Vec::new()
        }
    })
}

/// In the other precision.
pub fn cast<A: Real, B: Real>(x: &[A]) -> Vec<B> {
    x.iter().map(|&x| B::from_f64(x.to_f64())).collect()
}

/// All components in the other precision.
pub fn cast_all<A: Real, B: Real>(v: &Components<A>) -> Components<B> {
    v.each_ref().map(|component| cast(component))
}

/// Cells of a grid, x fastest.
pub fn places(grid: &Grid) -> impl Iterator<Item = [usize; 3]> + use<> {
    let n = grid.n;
    (0..grid.cells()).map(move |i| [i % n[0], i / n[0] % n[1], i / n[0] / n[1]])
}

/// Where number `at` of slot `k` of a trajectory is.
pub fn index(grid: &Grid, slots: usize, k: usize, at: [usize; 3]) -> usize {
    ((at[2] * grid.n[1] + at[1]) * slots + k) * grid.n[0] + at[0]
}

/// Slot `k` of a trajectory, in double precision.
pub fn slot<T: Real>(grid: &Grid, slots: usize, k: usize, field: &[T]) -> Vec<f64> {
    if field.is_empty() {
        Vec::new()
    } else {
        places(grid)
            .map(|at| field[index(grid, slots, k, at)].to_f64())
            .collect()
    }
}

/// Slot `k` of all components.
pub fn slot_of_all<T: Real>(grid: &Grid, slots: usize, k: usize, v: &Components<T>) -> Components<f64> {
    v.each_ref().map(|component| slot(grid, slots, k, component))
}

/// max |x|, NaN when any is.
pub fn largest(x: impl IntoIterator<Item = f64>) -> f64 {
    x.into_iter().fold(0.0, |all: f64, x| {
        if x.is_nan() || all.is_nan() {
            f64::NAN
        } else {
            all.max(x.abs())
        }
    })
}

/// max |x| over all components.
pub fn largest_of<T: Real>(v: &Components<T>) -> f64 {
    largest(v.iter().flatten().map(|x| x.to_f64()))
}

/// max |x - y|.
pub fn gap(x: &[f64], y: &[f64]) -> f64 {
    assert_eq!(x.len(), y.len());
    largest(x.iter().zip(y).map(|(x, y)| x - y))
}

/// The inner product <x, y>, summed in f64.
pub fn dot<T: Real>(x: &[T], y: &[T]) -> f64 {
    assert_eq!(x.len(), y.len());
    x.iter().zip(y).map(|(x, y)| x.to_f64() * y.to_f64()).sum()
}

/// <x, y> over all components.
pub fn dot_all<T: Real>(x: &Components<T>, y: &Components<T>) -> f64 {
    x.iter().zip(y).map(|(x, y)| dot(x, y)).sum()
}

/// x + s y.
pub fn add_scaled<T: Real>(x: &[T], s: f64, y: &[T]) -> Vec<T> {
    x.iter()
        .zip(y)
        .map(|(x, y)| T::from_f64(x.to_f64() + s * y.to_f64()))
        .collect()
}

/// x + s y in all components.
pub fn add_scaled_all<T: Real>(x: &Components<T>, s: f64, y: &Components<T>) -> Components<T> {
    core::array::from_fn(|a| add_scaled(&x[a], s, &y[a]))
}

/// Fails unless |x - y| is at most `tolerance` times `scale`, NaN included.
#[track_caller]
pub fn assert_close(what: &str, x: f64, y: f64, scale: f64, tolerance: f64) {
    assert!(
        (x - y).abs() <= tolerance * scale,
        "{what}: {x:e} against {y:e}, {:e} apart where {:e} is allowed",
        (x - y).abs(),
        tolerance * scale
    );
}
