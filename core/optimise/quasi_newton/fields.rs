//! The fields of L-BFGS by number, and what they are taken from.

use super::history::{History, MAX_FIELDS};
use super::recursion::Borrowed;
use crate::field::{Vector, VectorMut};
use crate::force::time_line::TimeLine;
use crate::grid::Grid;
use crate::memory::{Pool, pooled};
use crate::real::Real;

/// The fields by number.
pub type Fields<'a, T> = heapless::Vec<VectorMut<'a, T>, MAX_FIELDS>;

/// Takes the fields from a pool.
pub fn take<'a, T: Real>(
    grid: &Grid,
    slots: usize,
    history: History,
    pool: &mut Pool<'a, T>,
) -> Fields<'a, T> {
    pool.line("gradients, directions and pairs", |pool| {
        (0..history.fields())
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
pub fn behind<'a, T>(grid: &Grid, slots: usize, history: History, elements: &'a mut [T]) -> &'a mut [T] {
    let taken = history.fields() * grid.dims * pooled(grid.cells() * slots);
    elements.get_mut(taken..).unwrap_or_default()
}

/// Field `which` of those that [`take`] took from the front of `elements`, and what lies behind all of them.
pub fn view_and_behind<'a, T>(
    grid: &Grid,
    slots: usize,
    (history, which): (History, usize),
    elements: &'a mut [T],
) -> (Vector<'a, T>, &'a mut [T]) {
    let taken = history.fields() * grid.dims * pooled(grid.cells() * slots);
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
