//! C^T C, minus the Laplacian of a field without divergence: what viscosity does, and what makes fine forces dear. C is the vorticity at the
//! [plaquettes](super::plaquette), which every face gathers from those around it; rules that are not linear in one field hand it out to the faces instead.

use super::plaquette::Plaquette;
use super::self_advection::Fluid;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows::{part, part_mut};
use crate::field::{Block, Vector, VectorMut, borders, reborrow};
use crate::grid::solids::{Solids, dead};
use crate::grid::{Side, Space};
use crate::real::Real;
use crate::simd::multiversion;

/// `out = a x + b nu C^T C x + c y` in every slot, nu the fluid's viscosity. Shapes: trajectories of faces. `scratch` is
/// [so much](super::self_advection::scratch_per_thread) for each thread.
pub fn combine<T: Real, S: Space>(
    exec: &dyn Exec,
    fluid: Fluid<'_>,
    [a, b, c]: [f64; 3],
    x: Vector<'_, T>,
    y: Vector<'_, T>,
    mut out: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let (grid, nu) = (fluid.grid, T::from_f64(b * fluid.viscosity));
    let factors = [a, c].map(T::from_f64);
    let buffers = RowBuffers::fields(reborrow(&mut out)).with_scratch(scratch);
    for_rows(exec, grid.rows(), buffers, |task| {
        let mut fields = task.fields;
        for block in Block::all(grid, fluid.slots) {
            let around = Around::new::<S>((&block, task.row, fluid.solids), nu, x, task.scratch);
            for (axis, field) in fields.iter_mut().enumerate().take(S::DIM) {
                let out = part_mut(field, block.span_in_row());
                let [x, y] = [x, y].map(|field| block.of(at(&field, axis), task.row));
                around.gather::<S>(axis, factors, [x, y], out);
            }
        }
    });
    borders::refresh_faces(exec, grid, &mut out);
}

/// nu C x around the faces of a row of a block.
struct Around<'b, T> {
    block: &'b Block<'b>,
    /// By the pair of axes: at the row's own plaquettes, at those of the row above along the first axis, and along the second one; empty where that is x.
    rows: [[&'b [T]; 3]; 3],
}

impl<'b, T: Real> Around<'b, T> {
    fn new<S: Space>(
        (block, row, solids): (&'b Block<'b>, usize, Solids<'_>),
        nu: T,
        x: Vector<'_, T>,
        scratch: &'b mut [T],
    ) -> Self {
        let mut parts = scratch.chunks_exact_mut(block.len().max(1));
        let mut rows: [[&[T]; 3]; 3] = [[&[]; 3]; 3];
        for ((pair, &(a, b)), around) in S::PAIRS.iter().enumerate().zip(&mut rows) {
            let places = [None, Some(a), Some(b)];
            for (above, values) in places.into_iter().zip(around) {
                // Along x the next plaquette stands beside it.
                if above == Some(0) {
                    continue;
                }
                let out = parts.next().unwrap_or(&mut []);
                match above.map_or(Some(row), |axis| block.grid.neighbour(row, axis, Side::High)) {
                    Some(row) => vorticity((block, row, solids), (pair, (a, b)), nu, x, out),
                    None => out.fill(T::ZERO),
                }
                *values = out;
            }
        }
        Self { block, rows }
    }

    /// `out` = a x + C^T of what is around + c y at the faces along `axis`.
    fn gather<S: Space>(&self, axis: usize, factors: [T; 2], of: [&[T]; 2], out: &mut [T]) {
        let grid = self.block.grid;
        let mut terms = [Term::default(); 2];
        let with_axis = S::PAIRS.iter().zip(&self.rows);
        let with_axis = with_axis.filter(|((a, b), _)| axis == *a || axis == *b);
        for (term, (&(a, b), &[own, above_a, above_b])) in terms.iter_mut().zip(with_axis) {
            let (other, above, sign) = if axis == a {
                (b, above_b, -1.0)
            } else {
                (a, above_a, 1.0)
            };
            *term = Term {
                factor: T::from_f64(sign / at(&grid.h, other)),
                own,
                next: if other == 0 {
                    part(own, 1..own.len())
                } else {
                    above
                },
            };
        }
        let [first, second] = terms;
        if S::DIM == 2 {
            gather_one(first, factors, of, out);
        } else {
            gather_two(first, second, factors, of, out);
        }
        if axis > 0 {
            // Behind the last face of a slot stands another one than beside it.
            let nx = grid.n[0].max(1);
            let behind = grid.axis(0).cell(nx as isize);
            for (slot, out) in out.chunks_exact_mut(nx).enumerate() {
                let last = slot * nx + nx - 1;
                let [first, second] = terms.map(|term| {
                    let next = if term.next.len() < term.own.len() {
                        behind.map_or(T::ZERO, |cell| at(term.own, slot * nx + cell))
                    } else {
                        at(term.next, last)
                    };
                    [term.factor, at(term.own, last), next]
                });
                let of = of.map(|of| at(of, last));
                if let Some(out) = out.last_mut() {
                    *out = if S::DIM == 2 {
                        at_face(&[first], factors, of)
                    } else {
                        at_face(&[first, second], factors, of)
                    };
                }
            }
        }
    }
}

/// Two plaquettes beside a face.
#[derive(Clone, Copy)]
struct Term<'b, T> {
    /// 1 / h, with the sign of the first one.
    factor: T,
    own: &'b [T],
    /// That above; may be shorter by the last.
    next: &'b [T],
}

impl<T: Real> Default for Term<'_, T> {
    fn default() -> Self {
        Self {
            factor: T::ZERO,
            own: &[],
            next: &[],
        }
    }
}

/// The value at a place, or of an axis; nothing where there is none.
#[inline(always)]
fn at<T: Copy + Default>(values: &[T], place: usize) -> T {
    values.get(place).copied().unwrap_or_default()
}

/// What a face gets from pairs of plaquettes: 1 / h, at its own, at the next one.
#[inline(always)]
fn at_face<T: Real>(pairs: &[[T; 3]], [a, c]: [T; 2], [x, y]: [T; 2]) -> T {
    let mut sum = T::ZERO;
    for &[factor, own, next] in pairs {
        sum = sum + factor * own - factor * next;
    }
    sum + a * x + c * y
}

multiversion! {
    /// [`at_face`] at the faces of a row, but for those at its end that have no next plaquette, in 2D.
    fn gather_one[T: Real](term: Term<'_, T>, factors: [T; 2], of: [&[T]; 2], out: &mut [T]) {
        let beside = term.own.iter().zip(term.next);
        for ((out, (&x, &y)), (&own, &next)) in out.iter_mut().zip(of[0].iter().zip(of[1])).zip(beside) {
            *out = at_face(&[[term.factor, own, next]], factors, [x, y]);
        }
    }
}

multiversion! {
    /// The same in 3D.
    fn gather_two[T: Real](first: Term<'_, T>, second: Term<'_, T>, factors: [T; 2], of: [&[T]; 2], out: &mut [T]) {
        let beside = first.own.iter().zip(first.next).zip(second.own.iter().zip(second.next));
        for ((out, (&x, &y)), ((&own, &next), (&other, &other_next))) in out.iter_mut().zip(of[0].iter().zip(of[1])).zip(beside) {
            *out = at_face(&[[first.factor, own, next], [second.factor, other, other_next]], factors, [x, y]);
        }
    }
}

/// `out` = nu C x at the plaquettes of `row` for a pair of axes, 0 on walls and at closed faces.
fn vorticity<T: Real>(
    (block, row, solids): (&Block<'_>, usize, Solids<'_>),
    (pair, (a, b)): (usize, (usize, usize)),
    nu: T,
    x: Vector<'_, T>,
    out: &mut [T],
) {
    let (grid, nx, len) = (block.grid, block.grid.n[0].max(1), out.len());
    if [a, b].iter().any(|&axis| axis > 0 && grid.wall_below(row, axis)) {
        return out.fill(T::ZERO);
    }
    let inverse = [a, b].map(|axis| T::from_f64(1.0 / at(&grid.h, axis)));
    let [of_a, of_b] = [a, b].map(|axis| block.of(at(&x, axis), row));
    let below = |axis: usize, of: usize| {
        let low = grid.neighbour(row, axis, Side::Low).unwrap_or(row);
        block.of(at(&x, of), low)
    };
    if a > 0 && b > 0 {
        curl(nu, [below(b, a), of_a], [below(a, b), of_b], inverse, out);
    } else {
        // A row one back along x and the other as it is, from the second face on.
        let [low_a, low_b] = [(b, a, of_a), (a, b, of_b)].map(|(axis, of, own)| {
            if axis == 0 {
                part(own, 0..len.saturating_sub(1))
            } else {
                part(below(axis, of), 1..len)
            }
        });
        let [high_a, high_b] = [of_a, of_b].map(|own| part(own, 1..len));
        curl(
            nu,
            [low_a, high_a],
            [low_b, high_b],
            inverse,
            part_mut(out, 1..len),
        );
        // The first of each slot has another one before it, where there is any.
        for (slot, out) in out.chunks_exact_mut(nx).enumerate() {
            let first = slot * nx;
            let [low_a, low_b] = [(b, a, of_a), (a, b, of_b)].map(|(axis, of, own)| {
                if axis == 0 {
                    grid.axis(0)
                        .cell(-1)
                        .map_or(T::ZERO, |cell| at(own, first + cell))
                } else {
                    at(below(axis, of), first)
                }
            });
            if let Some(out) = out.first_mut() {
                let (a, b) = ([low_a, at(of_a, first)], [low_b, at(of_b, first)]);
                *out = nu * Plaquette::new(a, b, inverse, T::HALF).omega;
            }
        }
        block.clear_closed(0, row, out);
    }
    if solids.there() {
        solids.clear(nx, row, dead(pair), out);
    }
}

multiversion! {
    /// `out` = nu times the vorticity at a row of plaquettes, from the faces [A-, A+] and [B-, B+].
    fn curl[T: Real](nu: T, a: [&[T]; 2], b: [&[T]; 2], inverse: [T; 2], out: &mut [T]) {
        let faces = a[0].iter().zip(a[1]).zip(b[0].iter().zip(b[1]));
        for (out, ((&am, &ap), (&bm, &bp))) in out.iter_mut().zip(faces) {
            *out = nu * Plaquette::new([am, ap], [bm, bp], inverse, T::HALF).omega;
        }
    }
}
