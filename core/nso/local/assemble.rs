//! The block of a slot in the system in time: what residuals and Jacobian of a cell make.

use super::factor::triangle;
use super::form::Form;
use super::group::Group;
use super::lanes::{at, store_at, unroll};
use super::reflection::{ABOVE, BELOW, Place, face, reflection};
use super::residuals::Residuals;
use super::storage::{Gathered, Header, Stored, store_form};
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;

impl<T: Real> Group<'_, '_, T> {
    /// Residuals, and from them and the Jacobian a, c, M and the diagonal block of a slot; where all cells of
    /// the group are damped, M is the identity and the damping is all that is stored of the block. `diagonal`
    /// is what is added to M^T M on the diagonal.
    #[inline(always)]
    pub(super) fn assemble<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &self,
        header: &[T],
        gathered: &[T],
        diagonal: V,
        now: &mut [T],
    ) {
        let header = &header[..Header::<S>::SIZE * V::LANES];
        let gathered = &gathered[..Gathered::<S>::SIZE * V::LANES];
        let (mut residuals, plaquettes) = self.residuals::<S, V, VISCOUS>(header, gathered);
        let mobility = V::splat(self.system.surroundings.mobility);
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            (residuals.a[f], residuals.c[f]) = (mobility * residuals.a[f], mobility * residuals.c[f]);
        });
        let mut g = [V::splat(T::ZERO); 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            g[f] = at(header, Place::<S>::NORMAL + f);
        });
        let [beta, delta] = store_normal::<S, V>(header, &residuals, &g, now);
        let [moving, damping] = if VISCOUS {
            [mobility, V::splat(T::ZERO)]
        } else {
            self.local_damping::<S, V>(header, gathered)
        };
        if !moving.any_above_zero() {
            store_form::<S, V>(Form::Damped, now);
            store_at(damping, now, Stored::<S>::DAMPING);
            let [right, force] = self.reduce_sides::<S, V>(header, [residuals.a, residuals.c]);
            unroll!(i < S::FREE; 0 1 2 3 4; {
                store_at(right[i] + force[i], now, Stored::<S>::RIGHT + i);
                store_at(force[i], now, Stored::<S>::FORCE + i);
            });
            return;
        }
        store_form::<S, V>(Form::Full, now);
        let mut jacobian = self.jacobian::<S, V, VISCOUS>(header, &plaquettes, moving);
        let [mut column, mut row] = jacobian.along::<S>(&g);
        let Residuals { mut a, mut c, .. } = residuals;
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            a[f] = a[f] - row[f] * delta;
            c[f] = c[f] - column[f] * beta;
            store_at(row[f] + g[f], now, Stored::<S>::ROW + f);
            store_at(column[f] + g[f], now, Stored::<S>::COLUMN + f);
        });
        let reduced = self.reduce_sides::<S, V>(header, [a, c]);
        let mut outside = self.outside::<S, V, VISCOUS>(header, &plaquettes, moving);
        if self.above_wall {
            outside.flip::<S>();
            jacobian.flip::<S>();
            row.swap(BELOW, ABOVE);
            column.swap(BELOW, ABOVE);
        }
        let mut block = outside.reduce::<S>(header, V::splat(self.system.surroundings.outside));
        unroll!(i < S::FREE; 0 1 2 3 4; {
            block[i][i] = block[i][i] + damping;
        });
        let matrix = jacobian.reduce::<S>(header, [&row, &column]);
        self.store_block::<S, V>(&matrix, &mut block, reduced, diagonal, now);
    }

    /// a + M^T c, c, M, and the diagonal block (kappa + 1) + M^T M + omega B^T O B + damping, of which
    /// `block` holds the outside-face term and the damping.
    #[inline(always)]
    fn store_block<S: Space, V: Vector<Elem = T>>(
        &self,
        m: &[[V; 5]; 5],
        block: &mut [[V; 5]; 5],
        [mut right, force]: [[V; 5]; 2],
        diagonal: V,
        now: &mut [T],
    ) {
        unroll!(row < S::FREE; 0 1 2 3 4; {
            unroll!(i < row + 1; 0 1 2 3 4; {
                unroll!(l < S::FREE; 0 1 2 3 4; {
                    block[row][i] = block[row][i] + m[l][row] * m[l][i];
                });
                if row == i {
                    block[row][i] = block[row][i] + diagonal;
                }
                store_at(block[row][i], now, Stored::<S>::FACTOR + triangle(row, i));
            });
            unroll!(l < S::FREE; 0 1 2 3 4; {
                right[row] = right[row] + m[l][row] * force[l];
                store_at(m[row][l], now, Stored::<S>::MATRIX + row * S::FREE + l);
            });
            store_at(right[row], now, Stored::<S>::RIGHT + row);
            store_at(force[row], now, Stored::<S>::FORCE + row);
        });
    }

    /// The mobility in cells that are not damped, 0 elsewhere; and the damping of the others, the sum of (g_f v_f)^2
    /// over their faces.
    #[inline(always)]
    fn local_damping<S: Space, V: Vector<Elem = T>>(&self, header: &[T], gathered: &[T]) -> [V; 2] {
        let (zero, mobility) = (V::splat(T::ZERO), V::splat(self.system.surroundings.mobility));
        let mut squares = zero;
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let speed = at::<V>(header, Place::<S>::NORMAL + f) * at::<V>(gathered, Gathered::<S>::V + f);
            squares = squares + speed * speed;
        });
        let excess = squares - V::splat(self.system.damping.threshold);
        [excess.select(mobility, zero), excess.select(zero, squares)]
    }

    /// B^T of both sides, those of equations a and c at the cell's faces.
    #[inline(always)]
    fn reduce_sides<S: Space, V: Vector<Elem = T>>(
        &self,
        header: &[T],
        [mut a, mut c]: [[V; 6]; 2],
    ) -> [[V; 5]; 2] {
        let zero = V::splat(T::ZERO);
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let free: V = at(header, Place::<S>::FREE + f);
            (a[f], c[f]) = (free * a[f], free * c[f]);
        });
        if self.above_wall {
            a.swap(BELOW, ABOVE);
            c.swap(BELOW, ABOVE);
        }
        let u = reflection::<S, V>(header);
        let (mut ua, mut uc) = (zero, zero);
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            (ua, uc) = (ua + u[f] * a[f], uc + u[f] * c[f]);
        });
        let mut reduced = [[zero; 5]; 2];
        unroll!(i < S::FREE; 0 1 2 3 4; {
            let f = face(i);
            (reduced[0][i], reduced[1][i]) = (a[f] - u[f] * ua, c[f] - u[f] * uc);
        });
        reduced
    }
}

/// Stores the components of the residuals along g, and returns the first two: b / |g|^2 and d / |g|^2.
#[inline(always)]
fn store_normal<S: Space, V: Vector>(
    header: &[V::Elem],
    residuals: &Residuals<V>,
    g: &[V; 6],
    now: &mut [V::Elem],
) -> [V; 2]
where
    V::Elem: Real,
{
    let inverse: V = at(header, Place::<S>::INVERSE);
    let [beta, delta] = [residuals.b * inverse, residuals.d * inverse];
    let [mut a, mut c] = [V::splat(V::Elem::ZERO); 2];
    unroll!(f < S::FACES; 0 1 2 3 4 5; {
        a = a + g[f] * residuals.a[f];
        c = c + g[f] * residuals.c[f];
    });
    store_at(beta, now, Stored::<S>::NORMAL);
    store_at(delta, now, Stored::<S>::NORMAL + 1);
    store_at(a, now, Stored::<S>::NORMAL + 2);
    store_at(c, now, Stored::<S>::NORMAL + 3);
    [beta, delta]
}
