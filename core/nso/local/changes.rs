//! Substitution back, from the last slot to the first: the changes of the cells.

use super::factor::{solve_factor, times_m};
use super::group::Group;
use super::lanes::{MAX_LANES, at, unroll};
use super::reflection::{ABOVE, BELOW, Place, face};
use super::storage::{Changes, Header, Stored, changes, form, slot};
use crate::grid::{D3, Space};
use crate::real::Real;
use crate::simd::{Cache, Vector, prefetch};

/// Slots between the one that is written and the one that is prefetched.
const AHEAD: usize = 2;

impl<T: Real> Group<'_, '_, T> {
    /// Writes the changes of all slots to `out`.
    #[inline(always)]
    pub(super) fn back_substitute<S: Space, V: Vector<Elem = T>>(
        &self,
        header: &[T],
        stored: &[T],
        out: &mut Changes<'_, T>,
    ) {
        let slots = self.system.slots;
        let zero = V::splat(T::ZERO);
        // y_k and M_k y_k.
        let (mut y, mut image) = ([zero; 5], [zero; 5]);
        for k in (0..=slots).rev() {
            let mut before = [zero; 5];
            if k > 0 {
                before = solve_factor::<T, S, V>(slot::<S, V>(stored, k - 1), &image);
            }
            if k < slots {
                self.write_changes::<S, V>(header, stored, k, [&y, &image, &before], out);
            }
            if k > 0 {
                image = times_m::<T, S, V>(slot::<S, V>(stored, k - 1), &before);
            }
            y = before;
        }
    }

    /// The changes of slot k from y_k, M_k y_k and y_{k-1}: dv, then q and dw, then both pressures from the
    /// normal components of equations c and a.
    #[inline(always)]
    fn write_changes<S: Space, V: Vector<Elem = T>>(
        &self,
        header: &[T],
        stored: &[T],
        k: usize,
        [y, image, before]: [&[V; 5]; 3],
        out: &mut Changes<'_, T>,
    ) {
        let slots = self.system.slots;
        let zero = V::splat(T::ZERO);
        let header = &header[..Header::<S>::SIZE * V::LANES];
        let now = slot::<S, V>(stored, k);
        let inverse: V = at(header, Place::<S>::INVERSE);
        let kappa = V::splat(self.system.kappa);
        let mass = V::splat(self.system.surroundings.mass);
        let mut q = [zero; 5];
        unroll!(i < S::FREE; 0 1 2 3 4; {
            q[i] = image[i] - before[i] - at::<V>(now, Stored::<S>::FORCE + i);
        });
        let (beta, delta): (V, V) = (at(now, Stored::<S>::NORMAL), at(now, Stored::<S>::NORMAL + 1));
        let (mut bar, mut pressure): (V, V) =
            (at(now, Stored::<S>::NORMAL + 2), at(now, Stored::<S>::NORMAL + 3));
        let (of_y, of_q) = (along_u::<V, S>(header, y), along_u::<V, S>(header, &q));
        let mut dv = [zero; 6];
        let mut dw = [zero; 6];
        let mut all = [zero; changes::<D3>()];
        unroll!(i < S::FREE; 0 1 2 3 4; {
            (dv[face(i)], dw[face(i)]) = (y[i], q[i]);
        });
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let u: V = at(header, Place::<S>::REFLECTION + f);
            (dv[f], dw[f]) = (dv[f] - u * of_y, dw[f] - u * of_q);
        });
        if self.above_wall {
            dv.swap(BELOW, ABOVE);
            dw.swap(BELOW, ABOVE);
        }
        let full = form::<S, V>(now).is_full();
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let g: V = at(header, Place::<S>::NORMAL + f);
            (dv[f], dw[f]) = (dv[f] + g * beta, dw[f] + g * delta);
            let row = if full { at(now, Stored::<S>::ROW + f) } else { g };
            let column = if full { at(now, Stored::<S>::COLUMN + f) } else { g };
            pressure = pressure - row * dv[f] + g * dw[f];
            bar = bar - kappa * g * dv[f] - column * dw[f];
            (all[f], all[S::FACES + f]) = (dv[f], dw[f]);
        });
        // beta and delta are divergences over |g|^2, so times |g|^2 / |g|^2 they enter the pressures as they
        // are.
        let before: V = if k > 0 {
            at(slot::<S, V>(stored, k - 1), Stored::<S>::NORMAL)
        } else {
            zero
        };
        let after: V = if k + 1 < slots {
            at(slot::<S, V>(stored, k + 1), Stored::<S>::NORMAL + 1)
        } else {
            zero
        };
        (all[2 * S::FACES], all[2 * S::FACES + 1]) = (
            -(mass * (pressure * inverse + before)),
            -(mass * (bar * inverse + after)),
        );
        self.put(&all[..changes::<S>()], k, out);
    }

    /// Stores the lanes that are cells as the changes of all quantities in slot `k`, and prefetches where
    /// those of a later slot go.
    #[inline(always)]
    fn put<V: Vector<Elem = T>>(&self, changes: &[V], k: usize, Changes { out, half }: &mut Changes<'_, T>) {
        let mut from = k * *half + self.first;
        for &change in changes {
            // The sign of a 0 may depend on whether the other cells of the group are damped; after this it is
            // +0.
            let change = change + V::splat(T::ZERO);
            let change = if self.in_order { change } else { change.unpaired() };
            prefetch(Cache::First, out, from.wrapping_sub(AHEAD * *half), V::LANES);
            if self.count == V::LANES {
                change.store(&mut out[from..from + V::LANES]);
            } else {
                let mut lanes = [T::ZERO; MAX_LANES];
                change.store(&mut lanes);
                out[from..from + self.count].copy_from_slice(&lanes[..self.count]);
            }
            from += self.system.slots * *half;
        }
    }
}

/// <u, x> of the unknowns x.
#[inline(always)]
fn along_u<V: Vector, S: Space>(header: &[V::Elem], x: &[V; 5]) -> V {
    let u = |i: usize| at::<V>(header, Place::<S>::REFLECTION + face(i));
    let mut sum = u(0) * x[0];
    for i in 1..S::FREE {
        sum = sum + u(i) * x[i];
    }
    sum
}
