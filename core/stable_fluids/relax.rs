//! Gauss-Seidel sweeps: c x_i - a (sum of the neighbours of i) = b_i, cell after cell, as often as it is asked for.
//!
//! A cell reads what its lower neighbours are after this sweep, and its upper ones and all ghosts as they were before it. So cells of a
//! diagonal x + y = const do not know of each other: fields are laid out with the cells of a diagonal side by side, and each diagonal is
//! one loop over vectors. Sweep s + 1 may follow two diagonals (in 3D, planes) behind sweep s, which is how threads take part, and why a
//! field passes through the caches once for many sweeps. All of this gives the numbers of the plain order, x fastest, ascending.
//!
//! The adjoint needs no kernel of its own. Backwards, with G_s what reaches the right-hand side from sweep s, Y_s = sum over s' >= s of G_s'
//! obeys c Y_s - a (upper neighbours of Y_s, lower ones and ghosts of Y_{s+1}) = x': the same sweeps from 0 on x', in the opposite order.

use super::cells::{Cells, Component};
use super::diagonal::{Kernel, relax_diagonal, tail};
use super::skew::Skew;
use crate::exec::{Exec, for_every_other};
use crate::real::Real;
use crate::simd::multiversion;

/// Bytes of fields that sweeps which follow one another are at: they fit a cache near to a processor.
const CACHE: usize = 1 << 18;
/// c x_i - a (sum of the neighbours) = b_i.
#[derive(Clone, Copy, Debug)]
pub struct System {
    /// Factor of the neighbours.
    pub a: f64,
    /// The diagonal.
    pub c: f64,
    /// What ghosts depend on.
    pub component: Component,
    /// Sweeps.
    pub sweeps: usize,
    /// Whether cells are taken from the last to the first.
    pub backwards: bool,
}

/// Relaxes `x`, by diagonals, as `system` says, where `b` holds b_i / c by diagonals. Ghosts of walls are never read; those of periodic axes
/// are written here.
pub fn relax<T: Real>(exec: &dyn Exec, cells: &Cells, system: &System, x: &mut [T], b: &[T]) {
    let skew = Skew::new(cells);
    let k = system.a / system.c;
    let own = |axis: usize| match system.component {
        _ if cells.ring[axis] => 0.0,
        Some(component) if component == axis => -k,
        _ => k,
    };
    let [short, long] = if skew.along_x { [0, 1] } else { [1, 0] };
    let kernel = Kernel {
        skew,
        k: T::from_f64(k),
        own: [own(short), own(long), if cells.dims == 3 { own(2) } else { 0.0 }].map(T::from_f64),
        backwards: system.backwards,
    };
    // Along the axis of a wave a ghost of a ring is the far end as it was before the sweep: then no sweep may follow before the end.
    let apart = if cells.dims == 3 {
        cells.ring[2]
    } else {
        cells.ring[0] || cells.ring[1]
    };
    let task = if cells.dims == 3 {
        skew.plane()
    } else {
        skew.group * skew.width
    };
    let at_once = if apart {
        1
    } else {
        // A sweep keeps two tasks of both fields in a cache.
        (CACHE / (4 * task * T::BYTES).max(1)).max(2 * exec.threads())
    };
    rings(cells, &skew, x);
    let mut done = 0;
    while done < system.sweeps {
        let together = at_once.min(system.sweeps - done);
        wave(exec, cells, &kernel, together, x, b);
        if apart {
            rings(cells, &skew, x);
        }
        done += together;
    }
}

/// `together` sweeps, each two tasks behind the one before.
fn wave<T: Real>(exec: &dyn Exec, cells: &Cells, kernel: &Kernel<T>, together: usize, x: &mut [T], b: &[T]) {
    let skew = kernel.skew;
    let size = skew.group * skew.width;
    let three = cells.dims == 3;
    // In 3D a task is a plane of cells, and the first and the last are ghosts.
    let (first, tasks) = if three {
        (1, cells.n[2])
    } else {
        (0, skew.diagonals / skew.group)
    };
    let run = |chunk: usize, x: &mut [T], beside: [&[T]; 2]| {
        let b = b.get(chunk * size..(chunk + 1) * size).unwrap_or_default();
        if three {
            let walls = [chunk == 1, chunk == cells.n[2]].map(|wall| wall && !cells.ring[2]);
            relax_plane(kernel, x, b, beside, walls);
            if cells.ring[0] || cells.ring[1] {
                rings_of_plane(cells, &skew, x);
            }
        } else {
            relax_diagonals(kernel, x, b, beside, chunk * skew.group);
        }
    };
    for tick in 0..tasks + 2 * (together - 1) {
        // Sweep s is at task tick - 2 s.
        let newest = (tick / 2).min(together - 1);
        let oldest = (tick + 1).saturating_sub(tasks).div_ceil(2);
        if oldest > newest {
            continue;
        }
        let [low, high] = [tick - 2 * newest, tick - 2 * oldest];
        let lowest = if kernel.backwards { tasks - 1 - high } else { low };
        for_every_other(exec, x, size, first + lowest, newest - oldest + 1, run);
    }
}

multiversion! {
    /// Some diagonals of 2D; those before and behind are in `beside`.
    fn relax_diagonals[T: Real](
        kernel: &Kernel<T>,
        x: &mut [T],
        b: &[T],
        beside: [&[T]; 2],
        first: usize,
    ) {
        let (width, group) = (kernel.skew.width, kernel.skew.group);
        for turn in 0..group {
            let local = if kernel.backwards { group - 1 - turn } else { turn };
            let Some((before, rest)) = x.split_at_mut_checked(local * width) else { return };
            let Some((diagonal, behind)) = rest.split_at_mut_checked(width) else { return };
            let before = if local == 0 { tail(beside[0], width) } else { tail(before, width) };
            let behind = if local + 1 == group { beside[1] } else { &*behind };
            let b = b.get(local * width..(local + 1) * width).unwrap_or_default();
            relax_diagonal(kernel, first + local, diagonal, [before, behind], b, None);
        }
    }
}

multiversion! {
    /// A plane of 3D; the planes before and behind are in `beside`, and `walls` says whether they are walls.
    fn relax_plane[T: Real](
        kernel: &Kernel<T>,
        x: &mut [T],
        b: &[T],
        beside: [&[T]; 2],
        walls: [bool; 2],
    ) {
        let (width, diagonals) = (kernel.skew.width, kernel.skew.diagonals);
        let own = walls.iter().fold(T::ZERO, |own, &wall| if wall { own + kernel.own[2] } else { own });
        for turn in 0..diagonals {
            let local = if kernel.backwards { diagonals - 1 - turn } else { turn };
            let Some((before, rest)) = x.split_at_mut_checked(local * width) else { return };
            let Some((diagonal, behind)) = rest.split_at_mut_checked(width) else { return };
            let span = local * width..(local + 1) * width;
            let b = b.get(span.clone()).unwrap_or_default();
            let beside = beside.map(|plane| plane.get(span.clone()).unwrap_or_default());
            relax_diagonal(kernel, local, diagonal, [tail(before, width), behind], b, Some((beside, own)));
        }
    }
}

/// Fills the ghosts of periodic axes that sweeps read.
fn rings<T: Real>(cells: &Cells, skew: &Skew, x: &mut [T]) {
    let plane = skew.plane();
    if cells.dims == 2 {
        return rings_of_plane(cells, skew, x);
    }
    if cells.ring[0] || cells.ring[1] {
        x.chunks_exact_mut(plane)
            .for_each(|plane| rings_of_plane(cells, skew, plane));
    }
    if cells.ring[2] {
        let n = cells.n[2];
        x.copy_within(n * plane..(n + 1) * plane, 0);
        x.copy_within(plane..2 * plane, (n + 1) * plane);
    }
}

fn rings_of_plane<T: Real>(cells: &Cells, skew: &Skew, x: &mut [T]) {
    let strides = skew.strides();
    for axis in [0, 1] {
        if !cells.ring[axis] {
            continue;
        }
        let (n, along, across) = (cells.n[axis], strides[axis], strides[1 - axis]);
        for other in 1..=cells.n[1 - axis] {
            let place = other * across;
            for (ghost, image) in [(0, n), (n + 1, 1)] {
                let value = x.get(place + image * along).copied();
                if let (Some(ghost), Some(value)) = (x.get_mut(place + ghost * along), value) {
                    *ghost = value;
                }
            }
        }
    }
}
