//! L-BFGS over trajectories of faces (Nocedal & Wright, Numerical Optimization, 2nd ed., algorithm 7.4), its fields by number.
//!
//! With the first inverse Hessian P, what is kept of a pair is s and z = P y, so no gradient is kept at all but P g; the two loops
//! need inner products alone. Fields change their parts instead of their numbers: the direction that was taken becomes s of the
//! newest pair, P g before becomes z, and the oldest pair's fields are free for what a trial needs. m pairs ask for 2 m + 2 fields.

use crate::checkpoint::{Damaged, Record};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::trajectory::Shape;
use crate::field::{Vector, VectorMut, rows, sums};
use crate::force::time_line::TimeLine;
use crate::grid::Grid;
use crate::memory::{Pool, pooled};
use crate::real::Real;
use crate::simd::{Cache, prefetch};
use core::cmp::Ordering;
use core::ops::Range;

/// Most pairs.
pub const MAX_PAIRS: usize = 8;
/// Most fields.
const MAX_FIELDS: usize = 2 * MAX_PAIRS + 2;

/// Fields that `pairs` pairs ask for.
#[must_use]
pub const fn fields(pairs: usize) -> usize {
    2 * pairs + 2
}

/// Sums for each row of the grid.
#[must_use]
pub const fn sums_per_row(pairs: usize) -> usize {
    2 * pairs + 1
}

/// The fields by number.
pub type Fields<'a, T> = heapless::Vec<VectorMut<'a, T>, MAX_FIELDS>;

/// Takes the fields from a pool.
pub fn take<'a, T: Real>(grid: &Grid, slots: usize, pairs: usize, pool: &mut Pool<'a, T>) -> Fields<'a, T> {
    pool.line("gradients, directions and pairs", |pool| {
        (0..fields(pairs))
            .map(|_| pool.take_vector("field", grid.dims, grid.cells() * slots))
            .collect()
    })
}

/// Field `which` of those that [`take`] took from the front of `elements`.
#[must_use]
pub fn view<'a, T>(grid: &Grid, slots: usize, which: usize, elements: &'a [T]) -> Vector<'a, T> {
    let len = grid.cells() * slots;
    core::array::from_fn(|axis| {
        if axis < grid.dims {
            &elements[(which * grid.dims + axis) * pooled(len)..][..len]
        } else {
            &[]
        }
    })
}

/// Inner products of a pair's s and z = P y with some covector.
#[derive(Clone, Copy, Debug, Default)]
struct Products {
    s: f64,
    z: f64,
}

/// A step s and z = P y, y the change of the gradient along it.
#[derive(Clone, Debug, Default)]
struct Pair {
    s: usize,
    z: usize,
    /// With its own y: <s, y> > 0 and <z, y>.
    own: Products,
    /// With the gradient at the current point.
    gradient: Products,
    /// Those of all older pairs, oldest first, with this one's y.
    older: heapless::Vec<Products, MAX_PAIRS>,
}

/// Which field plays which part.
#[derive(Clone, Debug)]
pub struct QuasiNewton {
    /// Oldest first.
    pairs: heapless::Vec<Pair, MAX_PAIRS>,
    /// Factor of the first inverse Hessian P: <s, y> / <y, P y> of the newest pair (Nocedal & Wright eq. 7.20, in the norm of P).
    scale: f64,
    /// <g, P g> of the current gradient g.
    norm: f64,
    /// <g, d> of the newest direction d.
    slope: f64,
    most: usize,
    free: heapless::Vec<usize, MAX_FIELDS>,
    /// The direction, to be written by [`Self::descend`].
    pub direction: usize,
    /// P g at the current point.
    pub preconditioned: usize,
}

/// Two fields for a trial: one for the caller's use, one for the gradient at the new point.
#[derive(Clone, Copy, Debug)]
pub struct Borrowed {
    /// The caller's, until P times the gradient goes there.
    pub work: usize,
    /// The next gradient.
    pub gradient: usize,
}

/// The inverse Hessian to begin with: (K + r S)^-1, as a factored kappa + S with kappa = K / r, or 1 / r alone.
#[derive(Clone, Copy, Debug)]
pub struct Initial<'a> {
    /// kappa + S.
    pub line: Option<TimeLine<'a>>,
    /// 1 / r.
    pub scale: f64,
}

impl QuasiNewton {
    /// No pairs yet, `most` at most (from 1 to [`MAX_PAIRS`]).
    #[must_use]
    pub fn new(most: usize) -> Self {
        let most = most.clamp(1, MAX_PAIRS);
        let free = (2..fields(most)).collect();
        Self {
            pairs: heapless::Vec::new(),
            scale: 1.0,
            norm: 0.0,
            slope: 0.0,
            most,
            free,
            direction: 0,
            preconditioned: 1,
        }
    }

    /// Whether there are pairs.
    #[must_use]
    pub fn has_pairs(&self) -> bool {
        !self.pairs.is_empty()
    }

    /// Drops all pairs.
    pub fn forget(&mut self) {
        self.scale = 1.0;
        while self.drop_oldest() {}
    }

    fn drop_oldest(&mut self) -> bool {
        if self.pairs.is_empty() {
            return false;
        }
        let Pair { s, z, .. } = self.pairs.remove(0);
        let _ = (self.free.push(s), self.free.push(z));
        for pair in &mut self.pairs {
            pair.older.remove(0);
        }
        true
    }

    /// direction = -H g; <g, direction>.
    ///
    /// The two loops of algorithm 7.4 run over the inner products alone, so that all fields are read once: with q = g - sum a_j y_j
    /// and z = P y, H g = scale (P g - sum a_j z_j) + sum (a_i - b_i) s_i. One component at a time, for fewer streams from memory.
    pub fn descend<T: Real>(&mut self, exec: &dyn Exec, shape: Shape<'_>, fields: &mut Fields<'_, T>) -> f64 {
        let (pairs, scale) = (&self.pairs, self.scale);
        let mut away = [0.0; MAX_PAIRS];
        for (i, pair) in pairs.iter().enumerate().rev() {
            let newer: f64 = pairs[i + 1..]
                .iter()
                .zip(&away[i + 1..])
                .map(|(newer, a)| a * newer.older[i].s)
                .sum();
            away[i] = (pair.gradient.s - newer) / pair.own.s;
        }
        let mut along = [0.0; MAX_PAIRS];
        for (i, pair) in pairs.iter().enumerate() {
            let image = |j: usize| match j.cmp(&i) {
                Ordering::Less => pair.older[j].z,
                Ordering::Equal => pair.own.z,
                Ordering::Greater => pairs[j].older[i].z,
            };
            let images: f64 = (0..pairs.len()).map(|j| away[j] * image(j)).sum();
            let older: f64 = pair.older.iter().zip(&along).map(|(older, c)| c * older.s).sum();
            along[i] = away[i] - (scale * (pair.gradient.z - images) + older) / pair.own.s;
        }
        let weights: heapless::Vec<_, MAX_PAIRS> = pairs
            .iter()
            .zip(away.iter().zip(&along))
            .map(|(pair, (a, c))| (pair, -c, scale * a))
            .collect();
        self.slope = weights.iter().fold(-scale * self.norm, |sum, (pair, s, z)| {
            sum + s * pair.gradient.s + z * pair.gradient.z
        });
        let mut direction = core::mem::take(&mut fields[self.direction]);
        let Shape { grid, slots } = shape;
        for (axis, out) in direction.iter_mut().enumerate().take(grid.dims) {
            for_rows(exec, grid.rows(), RowBuffers::fields([out]), |task| {
                let [out] = task.fields;
                for (out, piece) in out.chunks_mut(rows::PIECE).zip(rows::pieces(slots * grid.n[0])) {
                    let of = |field: usize| {
                        piece_of(sums::row(grid, slots, &*fields[field][axis], task.row), &piece)
                    };
                    rows::scale(out, T::from_f64(-scale), of(self.preconditioned));
                    for &(pair, s, z) in &weights {
                        rows::add_scaled(out, T::from_f64(s), of(pair.s));
                        rows::add_scaled(out, T::from_f64(z), of(pair.z));
                    }
                }
            });
        }
        fields[self.direction] = direction;
        self.slope
    }

    /// The fields of the first evaluation: those of the preconditioned gradient and of the direction.
    #[must_use]
    pub fn first(&self) -> Borrowed {
        Borrowed {
            work: self.preconditioned,
            gradient: self.direction,
        }
    }

    /// Two free fields; the oldest pair is dropped for them where there are as many pairs as there may be.
    pub fn borrow(&mut self) -> Option<Borrowed> {
        if self.free.len() < 2 {
            self.drop_oldest();
        }
        Some(Borrowed {
            work: self.free.pop()?,
            gradient: self.free.pop()?,
        })
    }

    /// Gives them back.
    pub fn give_back(&mut self, borrowed: Borrowed) {
        let _ = (self.free.push(borrowed.work), self.free.push(borrowed.gradient));
    }

    /// Moves to a point with the gradient in `borrowed.gradient`, which is overwritten later: P times it goes to `borrowed.work`.
    /// `step` is how many times the direction leads there, or `None` for the first point. The pair is left out where it has no
    /// positive curvature.
    pub fn arrive<T: Real>(
        &mut self,
        exec: &dyn Exec,
        shape: Shape<'_>,
        fields: &mut Fields<'_, T>,
        borrowed: Borrowed,
        step: Option<f64>,
        initial: &Initial<'_>,
        sums: &mut [f64],
    ) {
        let (s, z) = (self.direction, self.preconditioned);
        let old = self.pairs.len();
        let products = self.products(exec, shape, fields, borrowed, step, initial, sums);
        let [norm, with_s, with_z] = core::array::from_fn(|which| products[2 * old + which]);
        let mut older = heapless::Vec::new();
        for (pair, now) in self.pairs.iter_mut().zip(products.chunks_exact(2)) {
            let now = Products { s: now[0], z: now[1] };
            let _ = older.push(Products {
                s: now.s - pair.gradient.s,
                z: now.z - pair.gradient.z,
            });
            pair.gradient = now;
        }
        let Some(length) = step else {
            self.norm = norm;
            return;
        };
        let own = Products {
            s: with_s - length * self.slope,
            z: norm - 2.0 * with_z + self.norm,
        };
        (self.norm, self.direction, self.preconditioned) = (norm, borrowed.gradient, borrowed.work);
        let pair = Pair {
            s,
            z,
            own,
            gradient: Products {
                s: with_s,
                z: norm - with_z,
            },
            older,
        };
        if own.s > 0.0 && own.z > 0.0 && self.pairs.push(pair).is_ok() {
            self.scale = own.s / own.z;
        } else {
            let _ = (self.free.push(s), self.free.push(z));
        }
        debug_assert!(self.pairs.len() <= self.most);
    }

    /// The new gradient's inner products with s and z of every pair, with P times itself, with the step, which becomes s, and with the
    /// preconditioned gradient before, which becomes z; the last two only with a step. One component at a time, as in [`Self::descend`].
    fn products<T: Real>(
        &self,
        exec: &dyn Exec,
        shape: Shape<'_>,
        fields: &mut Fields<'_, T>,
        borrowed: Borrowed,
        step: Option<f64>,
        initial: &Initial<'_>,
        sums: &mut [f64],
    ) -> heapless::Vec<f64, { 2 * MAX_PAIRS + 3 }> {
        let Shape { grid, slots } = shape;
        let (rows, count) = (grid.rows(), 2 * self.pairs.len() + 3);
        let sums = &mut sums[..count * rows];
        let mut image = core::mem::take(&mut fields[borrowed.work]);
        let [mut s, mut z] = match step {
            Some(_) => [self.direction, self.preconditioned].map(|field| core::mem::take(&mut fields[field])),
            None => Default::default(),
        };
        sums.fill(0.0);
        for (axis, ((image, s), z)) in image
            .iter_mut()
            .zip(&mut s)
            .zip(&mut z)
            .enumerate()
            .take(grid.dims)
        {
            for_rows(
                exec,
                rows,
                RowBuffers::fields([image, s, z]).with_sums(&mut *sums),
                |task| {
                    let row = |field: usize| sums::row(grid, slots, &*fields[field][axis], task.row);
                    let [image, s, z] = task.fields;
                    rows::scale(image, T::from_f64(initial.scale), row(borrowed.gradient));
                    if let Some(line) = &initial.line {
                        line.solve(image, grid.n[0]);
                    }
                    let mut lanes = [[0.0; rows::LANES]; 2 * MAX_PAIRS + 3];
                    for piece in rows::pieces(image.len()) {
                        let [image, gradient] = [&*image, row(borrowed.gradient)]
                            .map(|row| row.get(piece.clone()).unwrap_or_default());
                        let [s, z] = [&mut *s, &mut *z].map(|row| {
                            prefetch(Cache::Second, row, piece.end, rows::PIECE);
                            row.get_mut(piece.clone()).unwrap_or_default()
                        });
                        rows::scale_in_place(s, T::from_f64(step.unwrap_or_default()));
                        let of_pairs = self
                            .pairs
                            .iter()
                            .flat_map(|pair| [pair.s, pair.z])
                            .map(|field| piece_of(row(field), &piece));
                        for (lanes, factor) in lanes.iter_mut().zip(of_pairs.chain([image, s, z])) {
                            rows::add_products(lanes, factor, gradient);
                        }
                        rows::combine(z, -T::ONE, image);
                    }
                    task.sums
                        .iter_mut()
                        .zip(&lanes)
                        .for_each(|(sum, lanes)| *sum += lanes.iter().sum::<f64>());
                },
            );
        }
        fields[borrowed.work] = image;
        if step.is_some() {
            (fields[self.direction], fields[self.preconditioned]) = (s, z);
        }
        (0..count)
            .map(|which| sums.iter().skip(which).step_by(count).sum())
            .collect()
    }

    /// Its state in a checkpoint, the fields' numbers aside.
    ///
    /// # Errors
    /// [`Damaged`] where not every field plays one part.
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut read, last) = (self.clone(), fields(self.most) - 1);
        [&mut read.scale, &mut read.norm, &mut read.slope]
            .into_iter()
            .try_for_each(|number| record.real(number))?;
        record.count(&mut read.direction, last)?;
        record.count(&mut read.preconditioned, last)?;
        let (mut pairs, mut free) = (read.pairs.len(), read.free.len());
        record.count(&mut pairs, self.most)?;
        record.count(&mut free, MAX_FIELDS)?;
        read.pairs.resize(pairs, Pair::default()).map_err(|_| Damaged)?;
        read.free.resize(free, 0).map_err(|_| Damaged)?;
        for (index, pair) in read.pairs.iter_mut().enumerate() {
            record.count(&mut pair.s, last)?;
            record.count(&mut pair.z, last)?;
            pair.older
                .resize(index, Products::default())
                .map_err(|_| Damaged)?;
            for products in [&mut pair.own, &mut pair.gradient]
                .into_iter()
                .chain(&mut pair.older)
            {
                record.real(&mut products.s)?;
                record.real(&mut products.z)?;
            }
        }
        read.free
            .iter_mut()
            .try_for_each(|field| record.count(field, last))?;
        let parts = read
            .pairs
            .iter()
            .flat_map(|pair| [pair.s, pair.z])
            .chain(read.free.iter().copied())
            .chain([read.direction, read.preconditioned]);
        let (count, seen) = parts.fold((0, 0u32), |(count, seen), field| (count + 1, seen | 1 << field));
        if (count, seen.count_ones() as usize) != (last + 1, last + 1) {
            return Err(Damaged);
        }
        *self = read;
        Ok(())
    }
}

/// A piece of a row; asks for the next one, since every field is left for all the others after each piece, and what a processor asks for
/// ahead by itself begins anew with the next.
fn piece_of<'r, T>(row: &'r [T], piece: &Range<usize>) -> &'r [T] {
    prefetch(Cache::Second, row, piece.end, rows::PIECE);
    row.get(piece.clone()).unwrap_or_default()
}
