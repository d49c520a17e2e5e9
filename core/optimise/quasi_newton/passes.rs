//! The two passes over the fields of L-BFGS that it takes: one forms the direction, one takes the inner products.
//!
//! Both take one component at a time, for fewer streams from memory, and read every field once.

use super::fields::{Fields, Initial};
use super::history::{Kept, MAX_PAIRS};
use super::recursion::{Borrowed, Combination, GradientProducts, Products, QuasiNewton};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::trajectory::Shape;
use crate::field::{VectorMut, rows, sums};
use crate::real::Real;
use crate::simd::{Cache, prefetch};
use core::ops::Range;

/// Inner products with the gradient at most: with s and z of every pair, with P times itself, with the step and with P g before.
const MAX_PRODUCTS: usize = 2 * MAX_PAIRS + 3;

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
        let [mut image, mut gradient] =
            [borrowed.work, borrowed.gradient].map(|field| core::mem::take(&mut fields[field]));
        let [mut s, mut z] = match step {
            Some(_) => [self.direction, self.preconditioned].map(|field| core::mem::take(&mut fields[field])),
            None => Default::default(),
        };
        let pass = Pass {
            newton: self,
            shape,
            fields,
            step,
            initial,
        };
        let products = pass.run(exec, [&mut image, &mut gradient, &mut s, &mut z], sums);
        (fields[borrowed.work], fields[borrowed.gradient]) = (image, gradient);
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
                for &(kept, factors) in &combination.pairs {
                    let factors = factors.map(T::from_f64);
                    match kept {
                        Kept::Full(fields) => fields
                            .into_iter()
                            .zip(factors)
                            .for_each(|(field, factor)| rows::add_scaled(out, factor, of(field))),
                        Kept::Halves(field) => rows::add_halves(out, factors, of(field)),
                    }
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
    step: Option<f64>,
    initial: &'p Initial<'p>,
}

impl<T: Real> Pass<'_, '_, T> {
    /// Goes over all components of P times the gradient, of the step and of the change.
    fn run(
        &self,
        exec: &dyn Exec,
        [image, gradient, s, z]: [&mut VectorMut<'_, T>; 4],
        sums: &mut [f64],
    ) -> GradientProducts {
        let grid = self.shape.grid;
        let pairs = self.newton.count();
        let count = 2 * pairs + 3;
        let sums = &mut sums[..count * grid.rows()];
        sums.fill(0.0);
        let components = image.iter_mut().zip(gradient).zip(s).zip(z).enumerate();
        for (axis, (((image, gradient), s), z)) in components.take(grid.dims) {
            self.add_products(exec, axis, [image, gradient, s, z], sums);
        }
        let mut totals = [0.0; MAX_PRODUCTS];
        sums::add_up_each(exec, grid, sums, rows::part_mut(&mut totals, 0..count));
        let of = |which: usize| totals.get(which).copied().unwrap_or(0.0);
        let products_of = |which: usize| Products {
            s: of(which),
            z: of(which + 1),
        };
        let mut step = products_of(count - 2);
        if self.newton.halves() {
            // The field is still that of the direction.
            step.s *= self.step.unwrap_or(0.0);
        }
        GradientProducts {
            pairs: (0..pairs).map(|pair| products_of(2 * pair)).collect(),
            norm: of(count - 3),
            step,
        }
    }

    /// Writes P times one component of the gradient into `image`, makes a step of the direction `s` and a change of the image before,
    /// `z`, and adds the component's inner products to `sums`, those of a row together. In halves step and change take the place of the
    /// gradient, and `s` and `z` are left as they are.
    fn add_products(
        &self,
        exec: &dyn Exec,
        axis: usize,
        [image, gradient, s, z]: [&mut &mut [T]; 4],
        sums: &mut [f64],
    ) {
        let Shape { grid, slots } = self.shape;
        let step = T::from_f64(self.step.unwrap_or(0.0));
        let buffers = RowBuffers::fields([image, gradient, s, z]).with_sums(sums);
        for_rows(exec, grid.rows(), buffers, |task| {
            let row = |field: usize| sums::row(grid, slots, &*self.fields[field][axis], task.row);
            let [image, gradient, s, z] = task.fields;
            let scale = T::from_f64(self.initial.scale);
            if self.initial.prepared {
                rows::scale_in_place(image, scale);
            } else {
                rows::scale(image, scale, gradient);
            }
            if let Some(line) = &self.initial.line {
                line.solve(image, grid.n[0]);
            }
            let mut lanes = [[0.0; rows::LANES]; MAX_PRODUCTS];
            let (of_pairs, own) = lanes.split_at_mut(2 * self.newton.count());
            let (of_pairs, _) = of_pairs.as_chunks_mut::<2>();
            for piece in rows::pieces(image.len()) {
                let image = rows::part(image, piece.clone());
                let [gradient, s, z] = [&mut *gradient, &mut *s, &mut *z].map(|row| {
                    prefetch(Cache::Second, row, piece.end, rows::PIECE);
                    rows::part_mut(row, piece.clone())
                });
                for (lanes, kept) in of_pairs.iter_mut().zip(self.newton.kept()) {
                    match kept {
                        Kept::Full(fields) => lanes.iter_mut().zip(fields).for_each(|(lanes, field)| {
                            rows::add_products(lanes, piece_of(row(field), &piece), gradient);
                        }),
                        Kept::Halves(field) => {
                            rows::add_products_of_halves(lanes, piece_of(row(field), &piece), gradient);
                        }
                    }
                }
                if !self.newton.halves() {
                    rows::scale_in_place(s, step);
                }
                for (lanes, factor) in own.iter_mut().zip([image, &*s, &*z]) {
                    rows::add_products(lanes, factor, gradient);
                }
                if self.newton.halves() {
                    rows::keep_halves(gradient, step, s, image, z);
                } else {
                    rows::combine(z, -T::ONE, image);
                }
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
