//! L-BFGS over trajectories of faces (Nocedal & Wright, Numerical Optimization, 2nd ed., algorithm 7.4), its fields by number.
//!
//! Fields change their parts instead of their numbers: the direction that was taken becomes s of the newest pair, the gradient
//! before becomes y, and the oldest pair's fields are free for what a trial needs. m pairs ask for 2 m + 2 fields.

use crate::checkpoint::{Damaged, Record};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::force::time_line::TimeLine;
use crate::grid::Grid;
use crate::plan::{Pool, pooled};
use crate::real::Real;

/// Most pairs.
pub const MAX_PAIRS: usize = 8;
/// Most fields.
const MAX_FIELDS: usize = 2 * MAX_PAIRS + 2;

/// Fields that `pairs` pairs ask for.
#[must_use]
pub const fn fields(pairs: usize) -> usize {
    2 * pairs + 2
}

/// Numbers of them in a [`Pool`].
#[must_use]
pub fn numbers(grid: &Grid, slots: usize, pairs: usize) -> usize {
    fields(pairs) * grid.dims * pooled(grid.cells() * slots)
}

/// The fields by number.
pub type Fields<'a, T> = heapless::Vec<VectorMut<'a, T>, MAX_FIELDS>;

/// Takes the fields from a pool.
pub fn take<'a, T: Real>(grid: &Grid, slots: usize, pairs: usize, pool: &mut Pool<'a, T>) -> Fields<'a, T> {
    (0..fields(pairs)).map(|_| pool.take_vector(grid.dims, grid.cells() * slots)).collect()
}

/// A step s and the change y of the gradient along it.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    s: usize,
    y: usize,
    /// <s, y> > 0.
    curvature: f64,
}

/// Which field plays which part.
#[derive(Clone, Debug)]
pub struct QuasiNewton {
    pairs: heapless::Vec<Pair, MAX_PAIRS>,
    /// Factor of the first inverse Hessian P: <s, y> / <y, P y> of the newest pair (Nocedal & Wright eq. 7.20, in the norm of P).
    scale: f64,
    most: usize,
    free: heapless::Vec<usize, MAX_FIELDS>,
    /// The direction, to be written by [`Self::descend`].
    pub direction: usize,
    /// The gradient at the current point.
    pub gradient: usize,
}

/// Two fields for a trial: one for the caller's use, one for the gradient at the new point.
#[derive(Clone, Copy, Debug)]
pub struct Borrowed {
    /// The caller's.
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

/// Where the trajectories live.
#[derive(Clone, Copy, Debug)]
pub struct Shape<'g> {
    /// The grid.
    pub grid: &'g Grid,
    /// Slots of a trajectory.
    pub slots: usize,
}

impl QuasiNewton {
    /// No pairs yet, `most` at most (from 1 to [`MAX_PAIRS`]).
    #[must_use]
    pub fn new(most: usize) -> Self {
        let most = most.clamp(1, MAX_PAIRS);
        Self { pairs: heapless::Vec::new(), scale: 1.0, most, free: (2..fields(most)).collect(), direction: 0, gradient: 1 }
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
        let Pair { s, y, .. } = self.pairs.remove(0);
        let _ = (self.free.push(s), self.free.push(y));
        true
    }

    /// direction = -H gradient; <gradient, direction>.
    pub fn descend<T: Real>(&self, exec: &dyn Exec, shape: Shape<'_>, fields: &mut Fields<'_, T>, initial: &Initial<'_>, sums: &mut [f64]) -> f64 {
        let mut direction = core::mem::take(&mut fields[self.direction]);
        let gradient = view(&fields[self.gradient]);
        add(exec, shape, &mut direction, 0.0, 1.0, gradient);
        let mut weights: heapless::Vec<f64, MAX_PAIRS> = heapless::Vec::new();
        for pair in self.pairs.iter().rev() {
            let weight = dot(exec, shape, view(&fields[pair.s]), view(&direction), sums) / pair.curvature;
            add(exec, shape, &mut direction, 1.0, -weight, view(&fields[pair.y]));
            let _ = weights.push(weight);
        }
        precondition(exec, shape, &mut direction, self.scale, initial);
        for (pair, weight) in self.pairs.iter().zip(weights.iter().rev()) {
            let other = dot(exec, shape, view(&fields[pair.y]), view(&direction), sums) / pair.curvature;
            add(exec, shape, &mut direction, 1.0, weight - other, view(&fields[pair.s]));
        }
        let slope = -dot(exec, shape, gradient, view(&direction), sums);
        scale(exec, shape, &mut direction, -1.0);
        fields[self.direction] = direction;
        slope
    }

    /// Two free fields; the oldest pair is dropped for them where there are as many pairs as there may be.
    pub fn borrow(&mut self) -> Option<Borrowed> {
        if self.free.len() < 2 {
            self.drop_oldest();
        }
        Some(Borrowed { work: self.free.pop()?, gradient: self.free.pop()? })
    }

    /// Gives them back.
    pub fn give_back(&mut self, borrowed: Borrowed) {
        let _ = (self.free.push(borrowed.work), self.free.push(borrowed.gradient));
    }

    /// Remembers the step `length` times the direction to a point with the gradient in `borrowed.gradient`, which becomes the
    /// current one. Pairs without positive curvature are left out.
    pub fn remember<T: Real>(
        &mut self,
        exec: &dyn Exec,
        shape: Shape<'_>,
        fields: &mut Fields<'_, T>,
        borrowed: Borrowed,
        length: f64,
        initial: &Initial<'_>,
        sums: &mut [f64],
    ) {
        let (s, y) = (self.direction, self.gradient);
        let mut step = core::mem::take(&mut fields[s]);
        let mut change = core::mem::take(&mut fields[y]);
        let mut work = core::mem::take(&mut fields[borrowed.work]);
        scale(exec, shape, &mut step, length);
        add(exec, shape, &mut change, -1.0, 1.0, view(&fields[borrowed.gradient]));
        let curvature = dot(exec, shape, view(&step), view(&change), sums);
        add(exec, shape, &mut work, 0.0, 1.0, view(&change));
        precondition(exec, shape, &mut work, 1.0, initial);
        let norm = dot(exec, shape, view(&work), view(&change), sums);
        (fields[s], fields[y], fields[borrowed.work]) = (step, change, work);
        (self.direction, self.gradient) = (borrowed.work, borrowed.gradient);
        if curvature > 0.0 && self.pairs.push(Pair { s, y, curvature }).is_ok() {
            self.scale = curvature / norm;
        } else {
            let _ = (self.free.push(s), self.free.push(y));
        }
        debug_assert!(self.pairs.len() <= self.most);
    }

    /// Its state in a checkpoint, the fields' numbers aside.
    ///
    /// # Errors
    /// [`Damaged`] where not every field plays one part.
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut read, last) = (self.clone(), fields(self.most) - 1);
        record.real(&mut read.scale)?;
        record.count(&mut read.direction, last)?;
        record.count(&mut read.gradient, last)?;
        let (mut pairs, mut free) = (read.pairs.len(), read.free.len());
        record.count(&mut pairs, self.most)?;
        record.count(&mut free, MAX_FIELDS)?;
        read.pairs.resize(pairs, Pair::default()).map_err(|_| Damaged)?;
        read.free.resize(free, 0).map_err(|_| Damaged)?;
        for pair in &mut read.pairs {
            record.count(&mut pair.s, last)?;
            record.count(&mut pair.y, last)?;
            record.real(&mut pair.curvature)?;
        }
        read.free.iter_mut().try_for_each(|field| record.count(field, last))?;
        let parts = read.pairs.iter().flat_map(|pair| [pair.s, pair.y]).chain(read.free.iter().copied()).chain([read.direction, read.gradient]);
        let (count, seen) = parts.fold((0, 0u32), |(count, seen), field| (count + 1, seen | 1 << field));
        if (count, seen.count_ones() as usize) != (last + 1, last + 1) {
            return Err(Damaged);
        }
        *self = read;
        Ok(())
    }
}

/// <x, y> over all faces and slots.
pub fn dot<T: Real>(exec: &dyn Exec, shape: Shape<'_>, x: Vector<'_, T>, y: Vector<'_, T>, sums: &mut [f64]) -> f64 {
    let Shape { grid, slots } = shape;
    sums::total(exec, grid, sums, |row| (0..grid.dims).map(|a| rows::dot(sums::row(grid, slots, x[a], row), sums::row(grid, slots, y[a], row))).sum())
}

/// `out = s out + t x`; with s = 0 `out` may hold anything.
pub fn add<T: Real>(exec: &dyn Exec, shape: Shape<'_>, out: &mut VectorMut<'_, T>, s: f64, t: f64, x: Vector<'_, T>) {
    let Shape { grid, slots } = shape;
    let (own, other) = (T::from_f64(s), T::from_f64(t));
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: reborrow(out), sums: &mut [], scratch: &mut [] }, |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            let x = sums::row(grid, slots, x[axis], task.row);
            match () {
                () if s == 0.0 => rows::scale(out, other, x),
                () if s == 1.0 => rows::add_scaled(out, other, x),
                () => {
                    rows::scale_in_place(out, own);
                    rows::add_scaled(out, other, x);
                }
            }
        }
    });
}

/// `out = s out`.
pub fn scale<T: Real>(exec: &dyn Exec, shape: Shape<'_>, out: &mut VectorMut<'_, T>, s: f64) {
    if s == 1.0 {
        return;
    }
    let grid = shape.grid;
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: reborrow(out), sums: &mut [], scratch: &mut [] }, |task| {
        task.fields.into_iter().take(grid.dims).for_each(|out| rows::scale_in_place(out, T::from_f64(s)));
    });
}

/// `out = s P out`, P the first inverse Hessian.
fn precondition<T: Real>(exec: &dyn Exec, shape: Shape<'_>, out: &mut VectorMut<'_, T>, s: f64, initial: &Initial<'_>) {
    let grid = shape.grid;
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: reborrow(out), sums: &mut [], scratch: &mut [] }, |task| {
        for out in task.fields.into_iter().take(grid.dims) {
            rows::scale_in_place(out, T::from_f64(s * initial.scale));
            if let Some(line) = &initial.line {
                line.solve(out, grid.n[0]);
            }
        }
    });
}
