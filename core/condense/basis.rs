//! The basis: U_i = -H0_CC^-1 H0_Ci, how the rest follows a unit move of block i.
//!
//! With B = H0^-1 all columns come from one factor: U_i = (block column i of B) (B_ii)^-1, without its own rows. A patch has a factor of its own,
//! made where that of all would be.
//!
//! Column i is stored row by row, `BS` numbers to a row of each member; the blocks of a vertex one after the other.

use super::band::{Factor, factorise, row_of};
use super::hessian::Hessian;
use super::patches::Columns;
use super::small::{Square, inverse_above};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::real::Real;
use crate::walk::Random;

/// What is built.
pub struct Build<'a, T> {
    pub hessian: Hessian<'a, T>,
    pub columns: Columns<'a>,
    pub band: usize,
}

/// What is added to a basis.
#[derive(Clone, Copy)]
pub struct Noise {
    pub sigma: f64,
    pub seed: u64,
    /// The number of the build.
    pub build: usize,
}

impl<T: Real> Build<'_, T> {
    /// Builds all columns, of blocks of `BS` numbers.
    pub fn run<const BS: usize>(&self, exec: &dyn Exec, factor: &mut [T], basis: &mut [T], noise: Noise) {
        let dims = self.hessian.dims;
        let free = self.columns.free;
        if self.columns.begin.is_empty() {
            self.factorise(factor);
            let factor = Factor {
                values: &*factor,
                band: self.band,
            };
            for_rows(exec, free, RowBuffers::fields([&mut *basis]), |task| {
                let [columns] = task.fields;
                for (part, column) in columns.chunks_exact_mut(free * dims * BS).enumerate() {
                    whole::<T, BS>(&factor, task.row * dims + part * BS, column);
                }
            });
        } else {
            // There is room for one factor.
            for number in 0..free {
                let (begin, count) = self.columns.extent(number);
                let range = begin * dims * dims..(begin + count) * dims * dims;
                let columns = basis.get_mut(range).unwrap_or(&mut []);
                for (part, column) in columns.chunks_exact_mut(count * dims * BS).enumerate() {
                    self.patch::<BS>(factor, number, part * BS, column);
                }
            }
        }
        if noise.sigma > 0.0 {
            self.spoil::<BS>(basis, noise);
        }
    }

    /// The factor of the whole Hessian.
    pub fn factorise(&self, factor: &mut [T]) {
        let size = self.columns.free * self.hessian.dims;
        factorise(factor, size, self.band, |k, row| {
            row_of(&self.hessian, self.band, k, row)
        });
    }

    /// A column of a patch: H0 restricted to it, with the rows of the block itself those of the identity.
    fn patch<const BS: usize>(&self, factor: &mut [T], number: usize, first: usize, column: &mut [T]) {
        let (dims, hessian) = (self.hessian.dims, &self.hessian);
        let count = self.columns.extent(number).1;
        let local = |other: usize| self.columns.local(number, other);
        let own = |unknown: (usize, usize)| unknown.0 == number && (first..first + BS).contains(&unknown.1);
        let distance = |at: usize| {
            let columns = hessian.row(self.columns.member(number, at));
            columns
                .filter_map(|(other, _)| local(other))
                .map(|other| at.abs_diff(other))
                .max()
        };
        let width = (0..count).filter_map(distance).max().unwrap_or(0);
        let band = (width * dims + dims - 1).min(self.band);
        factorise(factor, count * dims, band, |k, row| {
            let (member, component) = (self.columns.member(number, k / dims), k % dims);
            for (other, block) in hessian.row(member) {
                let Some(at) = local(other) else { continue };
                let from = block.get(component * dims..).unwrap_or(&[]);
                for (c, value) in from.iter().enumerate().take(dims) {
                    let j = at * dims + c;
                    let apart = own((member, component)) || own((other, c));
                    let value = if apart { T::ZERO } else { *value };
                    let value = if apart && j == k { T::ONE } else { value };
                    if j <= k
                        && let Some(to) = row.get_mut(j + band - k)
                    {
                        *to = value;
                    }
                }
            }
        });
        for (at, rows) in column.chunks_exact_mut(dims * BS).enumerate() {
            rows.fill(T::ZERO);
            let member = self.columns.member(number, at);
            let block = hessian.block(member, number).unwrap_or(&[]);
            for (c, (row, from)) in rows
                .chunks_exact_mut(BS)
                .zip(block.chunks_exact(dims))
                .enumerate()
            {
                if !own((member, c)) {
                    let from = from.iter().skip(first);
                    row.iter_mut().zip(from).for_each(|(to, from)| *to = -*from);
                }
            }
        }
        Factor {
            values: &*factor,
            band,
        }
        .solve::<BS>(column, 0);
    }

    /// Adds noise but to a block's own rows.
    fn spoil<const BS: usize>(&self, basis: &mut [T], noise: Noise) {
        let dims = self.hessian.dims;
        for number in 0..self.columns.free {
            let (begin, count) = self.columns.extent(number);
            let range = begin * dims * dims..(begin + count) * dims * dims;
            let columns = basis.get_mut(range).unwrap_or(&mut []);
            let mut random = Random::new(noise.seed, noise.build as u64, number as u64);
            for (part, column) in columns.chunks_exact_mut(count * dims * BS).enumerate() {
                for (k, row) in column.chunks_exact_mut(BS).enumerate() {
                    let own = self.columns.member(number, k / dims) == number
                        && (part * BS..(part + 1) * BS).contains(&(k % dims));
                    if !own {
                        let add = |value: &mut T| *value += T::from_f64(noise.sigma * random.normal());
                        row.iter_mut().for_each(add);
                    }
                }
            }
        }
    }
}

/// U_i of the block whose first unknown is `first`, from the factor of all.
fn whole<T: Real, const BS: usize>(factor: &Factor<'_, T>, first: usize, column: &mut [T]) {
    column.fill(T::ZERO);
    let own = first * BS..(first + BS) * BS;
    for (r, row) in column
        .get_mut(own.clone())
        .unwrap_or(&mut [])
        .chunks_exact_mut(BS)
        .enumerate()
    {
        row[r] = T::ONE;
    }
    factor.solve::<BS>(column, first);
    let mut diagonal: Square<BS> = [[0.0; BS]; BS];
    let rows = column.get(own.clone()).unwrap_or(&[]).chunks_exact(BS);
    for (to, from) in diagonal.iter_mut().zip(rows) {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = from.to_f64());
    }
    let inverse = inverse_above(&symmetric(&diagonal), f64::MIN_POSITIVE);
    for row in column.chunks_exact_mut(BS) {
        let mut product = [0.0; BS];
        for (value, factors) in row.iter().zip(&inverse) {
            for (sum, factor) in product.iter_mut().zip(factors) {
                *sum += value.to_f64() * factor;
            }
        }
        row.iter_mut()
            .zip(product)
            .for_each(|(to, from)| *to = T::from_f64(from));
    }
    column.get_mut(own).unwrap_or(&mut []).fill(T::ZERO);
}

/// (A + A^T) / 2.
pub fn symmetric<const N: usize>(a: &Square<N>) -> Square<N> {
    core::array::from_fn(|i| core::array::from_fn(|j| 0.5 * (a[i][j] + a[j][i])))
}
