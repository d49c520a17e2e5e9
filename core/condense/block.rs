//! How far a block moves in a pass (condensation, section 1).

use super::basis::symmetric;
use super::hessian::Hessian;
use super::patches::Columns;
use super::settings::Update;
use super::small::{Square, identity, inverse_above, product, times, trace, transposed};
use crate::real::Real;

/// Added to H~_i, in parts of the trace of H_ii.
const GUARD: f64 = 1e-12;
/// What the eigenvalues of H_ii - S_i are raised to, in parts of the same.
const LEAST: f64 = 1e-6;

/// A pass over all blocks: what each of them reads.
#[derive(Clone, Copy)]
pub struct Pass<'a, T> {
    pub update: Update,
    pub hessian: Hessian<'a, T>,
    pub gradient: &'a [T],
    pub basis: &'a [T],
    pub columns: Columns<'a>,
    /// R_j R0_j^T of each free vertex, row by row, where the basis turns with the body.
    pub turns: &'a [T],
}

/// What the basis makes of the Hessian and the gradient of a block.
struct Reduced<const BS: usize> {
    /// H_iC U_i.
    coupling: Square<BS>,
    /// U_i^T H_CC U_i.
    inner: Square<BS>,
    /// U_i^T g_C.
    gradient: [f64; BS],
}

impl<T: Real> Pass<'_, T> {
    /// Writes the moves of the blocks of free vertex `number`, `BS` numbers each; `scratch` has twice the numbers of a column.
    pub fn vertex<const D: usize, const BS: usize>(&self, number: usize, scratch: &mut [T], out: &mut [T]) {
        for (part, out) in out.chunks_exact_mut(BS).enumerate() {
            let moved = self.block::<D, BS>(number, part, scratch);
            out.iter_mut()
                .zip(moved)
                .for_each(|(to, from)| *to = T::from_f64(from));
        }
    }

    fn block<const D: usize, const BS: usize>(
        &self,
        number: usize,
        part: usize,
        scratch: &mut [T],
    ) -> [f64; BS] {
        let own = self.own::<D, BS>(number, part);
        let size = trace(&own);
        let mut force = [0.0; BS];
        let from = self.gradient.iter().skip(number * D + part * BS);
        force
            .iter_mut()
            .zip(from)
            .for_each(|(to, from)| *to = from.to_f64());
        if self.update == Update::Plain {
            return times(&inverse_above(&own, GUARD * size), &force).map(|x| -x);
        }
        let reduced = self.reduced::<D, BS>(number, part, scratch);
        let all: [f64; BS] = core::array::from_fn(|k| force[k] + reduced.gradient[k]);
        let (matrix, force, least) = match self.update {
            Update::Jgs2Local => (sum(&own, &reduced.inner), force, GUARD),
            Update::Projected => {
                let both = sum(&reduced.coupling, &transposed(&reduced.coupling));
                (sum(&sum(&own, &reduced.inner), &both), all, GUARD)
            }
            Update::Cc => {
                let (matrix, force) = schur(&own, &reduced, force, size);
                (matrix, force, LEAST)
            }
            _ => (sum(&own, &reduced.inner), all, GUARD),
        };
        times(&inverse_above(&symmetric(&matrix), least * size), &force).map(|x| -x)
    }

    /// H_ii.
    fn own<const D: usize, const BS: usize>(&self, number: usize, part: usize) -> Square<BS> {
        let mut own = [[0.0; BS]; BS];
        let block = self.hessian.block(number, number).unwrap_or(&[]);
        let rows = block.chunks_exact(D).skip(part * BS);
        for (to, from) in own.iter_mut().zip(rows) {
            let from = from.iter().skip(part * BS);
            to.iter_mut().zip(from).for_each(|(to, from)| *to = from.to_f64());
        }
        own
    }

    fn reduced<const D: usize, const BS: usize>(
        &self,
        number: usize,
        part: usize,
        scratch: &mut [T],
    ) -> Reduced<BS> {
        let (begin, count) = self.columns.extent(number);
        let length = count * D * BS;
        let column = self.basis.get(begin * D * D + part * length..).unwrap_or(&[]);
        let column = column.get(..length).unwrap_or(&[]);
        let (moves, rest) = scratch.split_at_mut(length.min(scratch.len()));
        let forces = rest.get_mut(..length).unwrap_or(&mut []);
        self.turn::<D, BS>(number, column, moves);
        let moves = &*moves;
        for (at, forces) in forces.chunks_exact_mut(D * BS).enumerate() {
            let mut sums = [[0.0; BS]; D];
            for (other, block) in self.hessian.row(self.columns.member(number, at)) {
                if let Some(local) = self.columns.local(number, other) {
                    let rows = moves.get(local * D * BS..(local + 1) * D * BS).unwrap_or(&[]);
                    add_product(block, rows, &mut sums);
                }
            }
            for (to, from) in forces.iter_mut().zip(sums.as_flattened()) {
                *to = T::from_f64(*from);
            }
        }
        let own = self.columns.local(number, number).unwrap_or_default() * D + part * BS;
        let mut reduced = Reduced {
            coupling: [[0.0; BS]; BS],
            inner: [[0.0; BS]; BS],
            gradient: [0.0; BS],
        };
        for (to, from) in reduced.coupling.iter_mut().zip(forces.chunks_exact(BS).skip(own)) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = from.to_f64());
        }
        self.project::<D, BS>(number, (moves, forces), &mut reduced);
        reduced
    }

    /// U_i^T (H U_i) and U_i^T g; its own rows of U_i are 0.
    fn project<const D: usize, const BS: usize>(
        &self,
        number: usize,
        (moves, forces): (&[T], &[T]),
        reduced: &mut Reduced<BS>,
    ) {
        let rows = moves.chunks_exact(D * BS).zip(forces.chunks_exact(D * BS));
        for (at, (moves, forces)) in rows.enumerate() {
            let gradient = self.gradient.iter().skip(self.columns.member(number, at) * D);
            let rows = moves.chunks_exact(BS).zip(forces.chunks_exact(BS));
            for ((moves, forces), gradient) in rows.zip(gradient) {
                for ((inner, sum), value) in reduced.inner.iter_mut().zip(&mut reduced.gradient).zip(moves) {
                    *sum += value.to_f64() * gradient.to_f64();
                    for (inner, force) in inner.iter_mut().zip(forces) {
                        *inner += value.to_f64() * force.to_f64();
                    }
                }
            }
        }
    }

    /// The column, turned with the body: its rows by the rotation of their vertex, its columns by that of the block where its own move stands for
    /// that of all.
    fn turn<const D: usize, const BS: usize>(&self, number: usize, column: &[T], out: &mut [T]) {
        if self.turns.is_empty() {
            return out.copy_from_slice(column);
        }
        let across = if self.update == Update::Cc || BS != D {
            identity()
        } else {
            self.turn_of::<BS>(number)
        };
        for (at, (out, from)) in out
            .chunks_exact_mut(D * BS)
            .zip(column.chunks_exact(D * BS))
            .enumerate()
        {
            let turn = self.turn_of::<D>(self.columns.member(number, at));
            let mut turned = [[0.0; BS]; D];
            for (turned, turn) in turned.iter_mut().zip(&turn) {
                for (factor, from) in turn.iter().zip(from.chunks_exact(BS)) {
                    for (turned, from) in turned.iter_mut().zip(from) {
                        *turned += factor * from.to_f64();
                    }
                }
                *turned = times(&across, turned);
            }
            for (to, from) in out.iter_mut().zip(turned.as_flattened()) {
                *to = T::from_f64(*from);
            }
        }
    }

    /// R_j R0_j^T.
    #[inline(always)]
    fn turn_of<const D: usize>(&self, number: usize) -> Square<D> {
        turn_of(self.turns, number)
    }
}

/// Matrix `number` of a list of them.
#[inline(always)]
pub fn turn_of<T: Real, const D: usize>(turns: &[T], number: usize) -> Square<D> {
    let mut turn = [[0.0; D]; D];
    let from = turns.get(number * D * D..(number + 1) * D * D).unwrap_or(&[]);
    for (to, from) in turn.as_flattened_mut().iter_mut().zip(from) {
        *to = from.to_f64();
    }
    turn
}

/// H_ii - S_i and g~_i.
fn schur<const BS: usize>(
    own: &Square<BS>,
    reduced: &Reduced<BS>,
    force: [f64; BS],
    size: f64,
) -> (Square<BS>, [f64; BS]) {
    let mut guarded = symmetric(&reduced.inner);
    (0..BS).for_each(|k| guarded[k][k] += GUARD * size);
    let inverse = inverse_above(&guarded, GUARD * size);
    let back = product(&reduced.coupling, &inverse);
    let taken = product(&back, &transposed(&reduced.coupling));
    let less = times(&back, &reduced.gradient);
    (
        core::array::from_fn(|i| core::array::from_fn(|j| own[i][j] - taken[i][j])),
        core::array::from_fn(|k| force[k] - less[k]),
    )
}

fn sum<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    core::array::from_fn(|i| core::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// Adds a block times the rows of a column.
#[inline(always)]
fn add_product<T: Real, const D: usize, const BS: usize>(block: &[T], rows: &[T], sums: &mut [[f64; BS]; D]) {
    for (sums, block) in sums.iter_mut().zip(block.chunks_exact(D)) {
        for (factor, row) in block.iter().zip(rows.chunks_exact(BS)) {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += factor.to_f64() * value.to_f64();
            }
        }
    }
}
