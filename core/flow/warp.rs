//! W(phi, v): a density pulled back by a flow, phi*(x) = phi(x + v(x)), in cells and frames.
//!
//! ```text
//! S_s phi (x) = phi at X = x - s v(x - s/2 v(x)),  cubic, X between the outermost centres of walls
//! a = S_-1 phi,  b = S_1 a,  phi* = S_-1 (phi + (phi - b) / 2), limited to the cells around X    (BFECC: Kim, Liu, Llamas & Rossignac 2005)
//! ```
//!
//! v = 0 returns phi. With [`Warping::Quick`] it is the transport of densities with the flow -v instead.

use super::params::Warping;
use super::sample::{cubic, extremes, linear, velocity};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows;
use crate::field::{Vector, VectorMut, sums, view};
use crate::grid::Grid;
use crate::memory::{Pool, measured};
use crate::problem::Scheme;
use crate::real::Real;
use crate::transport::{Flow, Stepping, Stop, Transport};

/// The truncation error of the transport's series.
const TOLERANCE: f64 = 1e-5;

/// How densities are carried where the transport carries them, by sub-steps as results are defined.
#[must_use]
pub fn stepping() -> Stepping {
    Stepping {
        scheme: Scheme::Quick,
        tolerance: TOLERANCE,
        courant: 1.0,
    }
}

/// The workspace of a warp.
#[derive(Debug)]
pub struct Warp<'a, T> {
    grid: &'a Grid,
    way: Way<'a, T>,
}

#[derive(Debug)]
enum Way<'a, T> {
    /// Two fields of cells.
    Bfecc([&'a mut [T]; 2]),
    /// What is left of the pool, from which a transport takes its own.
    Quick { rest: &'a mut [T], threads: usize },
}

impl<'a, T: Real> Warp<'a, T> {
    /// Takes its workspace from a pool.
    pub fn carve(grid: &'a Grid, warping: Warping, threads: usize, pool: &mut Pool<'a, T>) -> Self {
        let way = match warping {
            Warping::Bfecc => Way::Bfecc(pool.line("a warp, there and back", |pool| {
                [(); 2].map(|()| pool.take("carried", grid.cells()))
            })),
            Warping::Quick => {
                let len = transport_len::<T>(grid, threads);
                Way::Quick {
                    rest: pool.take("density transport", len),
                    threads,
                }
            }
        };
        Self { grid, way }
    }

    /// `out = W(phi, v)`.
    ///
    /// # Errors
    /// [`Stop::TooFast`] of the transport.
    pub fn apply(
        self,
        exec: &dyn Exec,
        phi: &[T],
        v: Vector<'_, T>,
        out: &mut [T],
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let grid = self.grid;
        match self.way {
            Way::Bfecc([there, back]) => {
                bfecc(
                    exec,
                    grid,
                    Ride {
                        v,
                        s: -1.0,
                        own: None,
                    },
                    phi,
                    [there, back],
                    out,
                );
                Ok(())
            }
            Way::Quick { rest, threads } => {
                let largest = largest(exec, grid, phi, sums);
                let mut transport =
                    Transport::one_way(grid, stepping(), largest, threads, &mut Pool::new(rest));
                let flow = Flow {
                    initial: v,
                    v,
                    along: Some((v, T::from_f64(-2.0))),
                };
                transport
                    .load(exec, &flow, 1, 1, sums)
                    .map_err(|_| Stop::TooFast)?;
                transport.forward(exec, phi, out);
                Ok(())
            }
        }
    }
}

/// What a transport one way takes of a pool.
#[must_use]
pub fn transport_len<T: Real>(grid: &Grid, threads: usize) -> usize {
    measured::<T>(|pool| {
        let mut pool = pool;
        Transport::one_way(grid, stepping(), 1.0, threads, &mut pool);
    })
}

/// max |field|, of cells.
pub fn largest<T: Real>(exec: &dyn Exec, grid: &Grid, field: &[T], sums: &mut [f64]) -> f64 {
    let n = grid.n[0];
    sums::largest(exec, grid, sums, |row| {
        rows::max_abs(rows::part(field, row * n..(row + 1) * n))
    })
}

/// What carries a field, and how.
#[derive(Clone, Copy)]
struct Ride<'a, T> {
    v: Vector<'a, T>,
    /// Times v in cells: 1 carries along it for a frame.
    s: f64,
    /// Of a field that holds c - x of coordinates c that are carried, their axis.
    own: Option<usize>,
}

/// Coordinates c that ride on a flow for a step, S_s by BFECC: `u` holds c - x along `axis` at cells. `v` times `s` is in cells a step.
pub fn carry_coordinate<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    (v, s): (Vector<'_, T>, f64),
    (axis, u): (usize, &mut [T]),
    [there, back, out]: [&mut [T]; 3],
) {
    let own = Some(axis);
    bfecc(exec, grid, Ride { v, s, own }, u, [there, back], out);
    u.copy_from_slice(out);
}

/// `out` = S_s phi by BFECC, limited to the values of phi around X.
fn bfecc<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    ride: Ride<'_, T>,
    phi: &[T],
    [there, back]: [&mut [T]; 2],
    out: &mut [T],
) {
    trace(exec, grid, ride, phi, there, None);
    let home = Ride { s: -ride.s, ..ride };
    trace(exec, grid, home, there, back, None);
    compensate(exec, grid, phi, back);
    trace(exec, grid, ride, back, out, Some(phi));
}

/// `to` = S_s `from`; limited to the values of `limits` around X, if there are any. What holds c - x gets X - x.
fn trace<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    ride: Ride<'_, T>,
    from: &[T],
    to: &mut [T],
    limits: Option<&[T]>,
) {
    for_rows(exec, grid.rows(), RowBuffers::fields([to]), |task| {
        let [out] = task.fields;
        for (x, out) in out.iter_mut().enumerate() {
            let cell = grid.cell_at(task.row, x);
            let place = departure(grid, ride.v, ride.s, cell);
            let value = cubic(grid, from, place);
            *out = match limits {
                None => value,
                Some(limits) => {
                    let [low, high] = extremes(grid, limits, place);
                    let above = if value < low { low } else { value };
                    if above > high { high } else { above }
                }
            };
            if let Some(axis) = ride.own {
                *out += T::from_f64(place[axis] - (cell[axis] as f64 + 0.5));
            }
        }
    });
}

/// The X of the centre of a cell, between the outermost centres of walls.
#[inline(always)]
fn departure<T: Real>(grid: &Grid, v: Vector<'_, T>, s: f64, cell: [usize; 3]) -> [f64; 3] {
    let centre = centre(cell);
    let own = grid.index(cell);
    let mut middle = [0.5; 3];
    for axis in 0..grid.dims {
        let value = |index: usize| v[axis].get(index).map_or(0.0, |value| value.to_f64());
        let mut next = cell;
        let after = grid.axis(axis).open_face(cell[axis] as isize + 1);
        let after = after.map_or(0.0, |face| {
            next[axis] = face;
            value(grid.index(next))
        });
        middle[axis] = centre[axis] - 0.25 * s * (value(own) + after);
    }
    let mut place = away(centre, s, velocity(grid, v, middle));
    for (axis, place) in place.iter_mut().enumerate() {
        if !grid.axis(axis).is_ring() {
            *place = place.max(0.5).min(grid.n[axis] as f64 - 0.5);
        }
    }
    place
}

/// The centre of a cell.
#[inline(always)]
fn centre([x, y, z]: [usize; 3]) -> [f64; 3] {
    [x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5]
}

/// `place - s v`.
#[inline(always)]
fn away([x, y, z]: [f64; 3], s: f64, v: [f64; 3]) -> [f64; 3] {
    [x - s * v[0], y - s * v[1], z - s * v[2]]
}

/// `back = phi + (phi - back) / 2`.
fn compensate<T: Real>(exec: &dyn Exec, grid: &Grid, phi: &[T], back: &mut [T]) {
    let n = grid.n[0];
    for_rows(exec, grid.rows(), RowBuffers::fields([back]), |task| {
        let [back] = task.fields;
        for (back, &phi) in back
            .iter_mut()
            .zip(rows::part(phi, task.row * n..(task.row + 1) * n))
        {
            *back = phi + T::HALF * (phi - *back);
        }
    });
}

/// The flow carried by itself for a frame, BFECC without a limiter: faces are traced, their values linear. `work` and `out` are fields
/// of faces; what comes out has divergence.
pub fn carry_flow<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    v: Vector<'_, T>,
    [there, back]: [&mut VectorMut<'_, T>; 2],
    out: &mut VectorMut<'_, T>,
) {
    trace_faces(exec, grid, (v, 1.0), v, there);
    trace_faces(exec, grid, (v, -1.0), view(there), back);
    for axis in 0..grid.dims {
        compensate(exec, grid, v[axis], back[axis]);
    }
    trace_faces(exec, grid, (v, 1.0), view(back), out);
}

/// `to` = S_s `from` at faces, carried by v; 0 on walls.
fn trace_faces<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    (v, s): (Vector<'_, T>, f64),
    from: Vector<'_, T>,
    to: &mut VectorMut<'_, T>,
) {
    for (axis, to) in to.iter_mut().enumerate().take(grid.dims) {
        for_rows(exec, grid.rows(), RowBuffers::fields([&mut **to]), |task| {
            let [out] = task.fields;
            for (x, out) in out.iter_mut().enumerate() {
                let cell = grid.cell_at(task.row, x);
                if grid.axis(axis).open_face(cell[axis] as isize).is_none() {
                    *out = T::ZERO;
                    continue;
                }
                let mut place = centre(cell);
                place[axis] = cell[axis] as f64;
                let middle = away(place, 0.5 * s, velocity(grid, v, place));
                let departure = away(place, s, velocity(grid, v, middle));
                *out = T::from_f64(linear(grid, from[axis], axis, departure));
            }
        });
    }
}
