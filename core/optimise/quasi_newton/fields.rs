//! The fields of L-BFGS by number, and the two passes over them that it takes.
//!
//! Both passes take one component at a time, for fewer streams from memory, and read every field once.

use super::recursion::{
    Borrowed, Combination, GradientProducts, MAX_FIELDS, MAX_PAIRS, Products, QuasiNewton, fields_of,
};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::trajectory::Shape;
use crate::field::{Vector, VectorMut, rows, sums};
use crate::force::time_line::TimeLine;
use crate::grid::Grid;
use crate::memory::{Pool, pooled};
use crate::real::Real;
use crate::simd::{Cache, prefetch};
use core::ops::Range;

/// Inner products with the gradient at most: with s and z of every pair, with P times itself, with the step and with P g before.
const MAX_PRODUCTS: usize = 2 * MAX_PAIRS + 3;

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
        (0..fields_of(pairs))
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

/// What lies behind the fields that [`take`] took from the front of `elements`.
#[must_use]
pub fn behind<'a, T>(grid: &Grid, slots: usize, pairs: usize, elements: &'a mut [T]) -> &'a mut [T] {
    let taken = fields_of(pairs) * grid.dims * pooled(grid.cells() * slots);
    elements.get_mut(taken..).unwrap_or_default()
}

/// Field `which` of those that [`take`] took from the front of `elements`, and what lies behind all of them.
pub fn view_and_behind<'a, T>(
    grid: &Grid,
    slots: usize,
    [pairs, which]: [usize; 2],
    elements: &'a mut [T],
) -> (Vector<'a, T>, &'a mut [T]) {
    let taken = fields_of(pairs) * grid.dims * pooled(grid.cells() * slots);
    match elements.split_at_mut_checked(taken) {
        Some((fields, behind)) => (view(grid, slots, which, fields), behind),
        None => ([&[]; 3], &mut []),
    }
}

/// Lets `map` write the field of the image from that of the gradient, and passes on whether it did.
pub fn prepare<'a, T>(
    fields: &mut Fields<'a, T>,
    borrowed: Borrowed,
    map: impl FnOnce(Vector<'_, T>, &mut VectorMut<'a, T>) -> bool,
) -> bool {
    let Some(mut image) = fields.get_mut(borrowed.work).map(core::mem::take) else {
        return false;
    };
    let gradient = fields.get(borrowed.gradient);
    let done = gradient.is_some_and(|gradient| map(crate::field::view(gradient), &mut image));
    if let Some(field) = fields.get_mut(borrowed.work) {
        *field = image;
    }
    done
}

/// The inverse Hessian to begin with: (K + r S)^-1, as a factored kappa + S with kappa = K / r, or 1 / r alone; after a map of the gradient
/// that commutes with it, where there is one.
#[derive(Clone, Copy, Debug)]
pub struct Initial<'a> {
    /// kappa + S.
    pub line: Option<TimeLine<'a>>,
    /// 1 / r.
    pub scale: f64,
    /// Whether the image's field holds what these are applied to already, instead of the gradient.
    pub prepared: bool,
}

impl QuasiNewton {
    /// direction = -H g; <g, direction>.
    pub fn descend<T: Real>(&mut self, exec: &dyn Exec, shape: Shape<'_>, fields: &mut Fields<'_, T>) -> f64 {
        let (combination, slope) = self.combine();
        let mut direction = core::mem::take(&mut fields[self.direction]);
        form(
            exec,
            shape,
            fields,
            self.preconditioned,
            &combination,
            &mut direction,
        );
        fields[self.direction] = direction;
        slope
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
        let products = self.products(exec, shape, fields, borrowed, step, initial, sums);
        self.move_to(borrowed, step, &products);
    }

    /// The new gradient's inner products with s and z of every pair, with P times itself, with the step, which becomes s, and with the
    /// preconditioned gradient before, which becomes z; the last two only with a step.
    fn products<T: Real>(
        &self,
        exec: &dyn Exec,
        shape: Shape<'_>,
        fields: &mut Fields<'_, T>,
        borrowed: Borrowed,
        step: Option<f64>,
        initial: &Initial<'_>,
        sums: &mut [f64],
    ) -> GradientProducts {
        let mut image = core::mem::take(&mut fields[borrowed.work]);
        let [mut s, mut z] = match step {
            Some(_) => [self.direction, self.preconditioned].map(|field| core::mem::take(&mut fields[field])),
            None => Default::default(),
        };
        let pass = Pass {
            newton: self,
            shape,
            fields,
            gradient: borrowed.gradient,
            step,
            initial,
        };
        let products = pass.run(exec, [&mut image, &mut s, &mut z], sums);
        fields[borrowed.work] = image;
        if step.is_some() {
            (fields[self.direction], fields[self.preconditioned]) = (s, z);
        }
        products
    }
}

/// `direction` as the combination of `fields`, of which `preconditioned` comes first.
fn form<T: Real>(
    exec: &dyn Exec,
    shape: Shape<'_>,
    fields: &Fields<'_, T>,
    preconditioned: usize,
    combination: &Combination,
    direction: &mut VectorMut<'_, T>,
) {
    let Shape { grid, slots } = shape;
    for (axis, out) in direction.iter_mut().enumerate().take(grid.dims) {
        for_rows(exec, grid.rows(), RowBuffers::fields([out]), |task| {
            let [out] = task.fields;
            for (out, piece) in out.chunks_mut(rows::PIECE).zip(rows::pieces(slots * grid.n[0])) {
                let of =
                    |field: usize| piece_of(sums::row(grid, slots, &*fields[field][axis], task.row), &piece);
                rows::scale(out, T::from_f64(combination.preconditioned), of(preconditioned));
                for &(field, factor) in &combination.pairs {
                    rows::add_scaled(out, T::from_f64(factor), of(field));
                }
            }
        });
    }
}

/// The pass that takes inner products with the gradient at a new point.
struct Pass<'p, 'f, T> {
    newton: &'p QuasiNewton,
    shape: Shape<'p>,
    fields: &'p Fields<'f, T>,
    /// The gradient's field.
    gradient: usize,
    step: Option<f64>,
    initial: &'p Initial<'p>,
}

impl<T: Real> Pass<'_, '_, T> {
    /// Goes over all components of P times the gradient, of the step and of the change.
    fn run(
        &self,
        exec: &dyn Exec,
        [image, s, z]: [&mut VectorMut<'_, T>; 3],
        sums: &mut [f64],
    ) -> GradientProducts {
        let grid = self.shape.grid;
        let pairs = self.newton.count();
        let count = 2 * pairs + 3;
        let sums = &mut sums[..count * grid.rows()];
        sums.fill(0.0);
        let components = image.iter_mut().zip(s).zip(z).enumerate();
        for (axis, ((image, s), z)) in components.take(grid.dims) {
            self.add_products(exec, axis, [image, s, z], sums);
        }
        let of = |which: usize| sums.iter().skip(which).step_by(count).sum();
        let products_of = |which: usize| Products {
            s: of(which),
            z: of(which + 1),
        };
        GradientProducts {
            pairs: (0..pairs).map(|pair| products_of(2 * pair)).collect(),
            norm: of(count - 3),
            step: products_of(count - 2),
        }
    }

    /// Writes P times one component of the gradient into `image`, makes a step of the direction `s` and a change of the image before,
    /// `z`, and adds the component's inner products to `sums`, those of a row together.
    fn add_products(
        &self,
        exec: &dyn Exec,
        axis: usize,
        [image, s, z]: [&mut &mut [T]; 3],
        sums: &mut [f64],
    ) {
        let Shape { grid, slots } = self.shape;
        let buffers = RowBuffers::fields([image, s, z]).with_sums(sums);
        for_rows(exec, grid.rows(), buffers, |task| {
            let row = |field: usize| sums::row(grid, slots, &*self.fields[field][axis], task.row);
            let [image, s, z] = task.fields;
            let scale = T::from_f64(self.initial.scale);
            if self.initial.prepared {
                rows::scale_in_place(image, scale);
            } else {
                rows::scale(image, scale, row(self.gradient));
            }
            if let Some(line) = &self.initial.line {
                line.solve(image, grid.n[0]);
            }
            let mut lanes = [[0.0; rows::LANES]; MAX_PRODUCTS];
            for piece in rows::pieces(image.len()) {
                let [image, gradient] =
                    [&*image, row(self.gradient)].map(|row| rows::part(row, piece.clone()));
                let [s, z] = [&mut *s, &mut *z].map(|row| {
                    prefetch(Cache::Second, row, piece.end, rows::PIECE);
                    rows::part_mut(row, piece.clone())
                });
                rows::scale_in_place(s, T::from_f64(self.step.unwrap_or(0.0)));
                let of_pairs = self
                    .newton
                    .pair_fields()
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
        });
    }
}

/// A piece of a row; asks for the next one, since every field is left for all the others after each piece, and what a processor asks for
/// ahead by itself begins anew with the next.
fn piece_of<'r, T>(row: &'r [T], piece: &Range<usize>) -> &'r [T] {
    prefetch(Cache::Second, row, piece.end, rows::PIECE);
    rows::part(row, piece.clone())
}
