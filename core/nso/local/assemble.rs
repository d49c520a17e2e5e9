//! The equations of one slot at a cell: residuals, and the block of the system in time that they and the Jacobian make.

use super::edge::Edge;
use super::factor::triangle;
use super::gather::Gathered;
use super::jacobian::{coupled, first_coupled, slopes};
use super::pace::Pace;
use super::reflection::{ABOVE, BELOW, Place, face, reflection};
use super::{Group, Header, Kept, at, unroll};
use crate::grid::Space;
use crate::operators::plaquette::Plaquette;
use crate::real::Real;
use crate::simd::Vector;

/// The momentum and divergence residuals of a group in one slot.
struct Residuals<V> {
    a: [V; 6],
    b: V,
    c: [V; 6],
    d: V,
}

impl<T: Real> Group<'_, '_, T> {
    /// Residuals, and from them and the Jacobian a, c, M and the diagonal block of a slot; where the whole group is slow M is 1,
    /// and of the block what it is damped by is kept. `diagonal` is what there is on the diagonal beside M^T M.
    #[inline(always)]
    pub(super) fn assemble<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &self,
        header: &[T],
        gathered: &[T],
        diagonal: V,
        now: &mut [T],
    ) {
        let (lanes, zero, one) = (V::LANES, V::splat(T::ZERO), V::splat(T::ONE));
        let (header, gathered) = (
            &header[..Header::<S>::SIZE * lanes],
            &gathered[..Gathered::<S>::SIZE * lanes],
        );
        let (residuals, plaquettes) = self.residuals::<S, V, VISCOUS>(header, gathered);
        let mut g = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            g[f] = at(header, Place::<S>::NORMAL + f);
        });
        let inverse: V = at(header, Place::<S>::INVERSE);
        let (beta, delta) = (residuals.b * inverse, residuals.d * inverse);
        let (mut normal_a, mut normal_c) = (zero, zero);
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            normal_a = normal_a + g[f] * residuals.a[f];
            normal_c = normal_c + g[f] * residuals.c[f];
        });
        beta.store(&mut now[Kept::<S>::NORMAL * lanes..]);
        delta.store(&mut now[(Kept::<S>::NORMAL + 1) * lanes..]);
        normal_a.store(&mut now[(Kept::<S>::NORMAL + 2) * lanes..]);
        normal_c.store(&mut now[(Kept::<S>::NORMAL + 3) * lanes..]);
        let [fast, damping] = if VISCOUS {
            [one, zero]
        } else {
            self.pace::<S, V>(header, gathered)
        };
        if !fast.any_above_zero() {
            Pace::<V>::Slow.keep::<S>(now);
            damping.store(&mut now[Kept::<S>::DAMPING * lanes..]);
            let [right, force] = self.reduce_sides::<S, V>(header, [residuals.a, residuals.c]);
            unroll!(i < S::FREE; 0 1 2 3 4; {
                (right[i] + force[i]).store(&mut now[(Kept::<S>::RIGHT + i) * lanes..]);
                force[i].store(&mut now[(Kept::<S>::FORCE + i) * lanes..]);
            });
            return;
        }
        Pace::<V>::Fast.keep::<S>(now);
        let mut jacobian = self.jacobian::<S, V, VISCOUS>(header, &plaquettes, fast);
        // J g and J^T g.
        let mut column = [zero; 6];
        let mut row = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let first = first_coupled(f);
            (column[f], row[f]) = (jacobian.0[f][first] * g[first], g[first] * jacobian.0[first][f]);
            unroll!(e < S::FACES; 1 2 3 4 5; {
                if coupled(f, e) && e > first {
                    column[f] = column[f] + jacobian.0[f][e] * g[e];
                    row[f] = row[f] + g[e] * jacobian.0[e][f];
                }
            });
        });
        let mut rest_a = [zero; 6];
        let mut rest_c = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            rest_a[f] = residuals.a[f] - row[f] * delta;
            rest_c[f] = residuals.c[f] - column[f] * beta;
            (row[f] + g[f]).store(&mut now[(Kept::<S>::ROW + f) * lanes..]);
            (column[f] + g[f]).store(&mut now[(Kept::<S>::COLUMN + f) * lanes..]);
        });
        let reduced = self.reduce_sides::<S, V>(header, [rest_a, rest_c]);
        let mut outside = self.outside::<S, V, VISCOUS>(header, &plaquettes, fast);
        if self.above_wall {
            outside.flip::<S>();
            jacobian.flip::<S>();
            row.swap(BELOW, ABOVE);
            column.swap(BELOW, ABOVE);
        }
        let mut block = outside.reduce::<S>(header, V::splat(self.system.outside));
        unroll!(i < S::FREE; 0 1 2 3 4; {
            block[i][i] = block[i][i] + damping;
        });
        let matrix = jacobian.reduce::<S>(header, [&row, &column]);
        self.keep_block::<S, V>(&matrix, &mut block, reduced, diagonal, now);
    }

    /// a + M^T c, c, M, and the diagonal block (kappa + 1) + M^T M + omega B^T O B + damping, of which `block` is the last two parts.
    #[inline(always)]
    fn keep_block<S: Space, V: Vector<Elem = T>>(
        &self,
        m: &[[V; 5]; 5],
        block: &mut [[V; 5]; 5],
        [mut right, force]: [[V; 5]; 2],
        diagonal: V,
        now: &mut [T],
    ) {
        let lanes = V::LANES;
        unroll!(row < S::FREE; 0 1 2 3 4; {
            unroll!(i < row + 1; 0 1 2 3 4; {
                unroll!(l < S::FREE; 0 1 2 3 4; {
                    block[row][i] = block[row][i] + m[l][row] * m[l][i];
                });
                if row == i {
                    block[row][i] = block[row][i] + diagonal;
                }
                block[row][i].store(&mut now[(Kept::<S>::FACTOR + triangle(row, i)) * lanes..]);
            });
            unroll!(l < S::FREE; 0 1 2 3 4; {
                right[row] = right[row] + m[l][row] * force[l];
                m[row][l].store(&mut now[(Kept::<S>::MATRIX + row * S::FREE + l) * lanes..]);
            });
            right[row].store(&mut now[(Kept::<S>::RIGHT + row) * lanes..]);
            force[row].store(&mut now[(Kept::<S>::FORCE + row) * lanes..]);
        });
    }

    /// 1 in cells that are fast in the slot, 0 elsewhere; and what slow ones are damped by, the sum of (g_f v_f)^2 over their faces.
    #[inline(always)]
    fn pace<S: Space, V: Vector<Elem = T>>(&self, header: &[T], gathered: &[T]) -> [V; 2] {
        let (zero, one) = (V::splat(T::ZERO), V::splat(T::ONE));
        let mut squares = zero;
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let speed = at::<V>(header, Place::<S>::NORMAL + f) * at::<V>(gathered, Gathered::<S>::V + f);
            squares = squares + speed * speed;
        });
        let fast = squares - V::splat(self.system.slow.squares);
        [fast.select(one, zero), fast.select(zero, squares)]
    }

    /// What kappa and the changes' own derivatives in time add to M^T M on the diagonal in slot `k`.
    #[inline(always)]
    pub(super) fn diagonal(&self, k: usize) -> T {
        if k + 1 == self.system.slots {
            self.system.kappa
        } else {
            self.system.kappa + T::ONE
        }
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

    /// The residuals at the group's cells and faces, and the plaquettes of v at the edges.
    ///
    /// Powers of 2 are taken out of products, which rounds nothing: plaquettes hold omega / 4, 2 abar and 2 bbar, and sigma_a and sigma_b
    /// are a quarter of the derivatives of omega by the cell's own a- and b-face.
    #[inline(always)]
    fn residuals<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &self,
        header: &[T],
        gathered: &[T],
    ) -> (Residuals<V>, [Plaquette<V>; 12]) {
        let (zero, one) = (V::splat(T::ZERO), V::splat(T::ONE));
        let viscosity = self.viscosity::<V>();
        let (mut v, mut w) = ([zero; 6], [zero; 6]);
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            (v[f], w[f]) = (at(gathered, Gathered::<S>::V + f), at(gathered, Gathered::<S>::W + f));
        });
        let mut r = self.linear_residuals::<S, V>(header, gathered, &v, &w);
        let mut plaquettes = [Plaquette {
            omega: zero,
            abar: zero,
            bbar: zero,
        }; 12];
        unroll!(e < S::EDGES; 0 1 2 3 4 5 6 7 8 9 10 11; {
            let edge = Edge::new::<S>(e);
            let (fa, fb) = (edge.face_a(), edge.face_b());
            let (va, vb): ([V; 2], [V; 2]) = quad::<S, V>(gathered, Gathered::<S>::V, &v, e);
            let (wa, wb): ([V; 2], [V; 2]) = quad::<S, V>(gathered, Gathered::<S>::W, &w, e);
            let (inverse, [sigma_a, sigma_b]) = slopes::<S, V>(header, e);
            let (p, m) = (Plaquette::new(va, vb, inverse, one), Plaquette::new(wa, wb, inverse, one));
            r.c[fa] = r.c[fa] + p.omega * p.bbar;
            r.c[fb] = r.c[fb] - p.omega * p.abar;
            // What omega does to w, by 4.
            let mut spin = m.bbar * p.abar - m.abar * p.bbar;
            if VISCOUS {
                let drag = viscosity * p.omega;
                r.c[fa] = r.c[fa] - sigma_a * drag;
                r.c[fb] = r.c[fb] - sigma_b * drag;
                spin = spin + viscosity * m.omega;
            }
            r.a[fa] = r.a[fa] - (m.bbar * p.omega + sigma_a * spin);
            r.a[fb] = r.a[fb] + (m.abar * p.omega - sigma_b * spin);
            plaquettes[e] = p;
        });
        (r, plaquettes)
    }

    /// Makes up for the two quarters that viscosity meets: of omega or sigma, and of sigma.
    #[inline(always)]
    pub(super) fn viscosity<V: Vector<Elem = T>>(&self) -> V {
        V::splat(self.system.viscosity * T::from_f64(16.0))
    }

    /// The residuals without self-advection, from `v` and `w` at the cells' own faces.
    #[inline(always)]
    fn linear_residuals<S: Space, V: Vector<Elem = T>>(
        &self,
        header: &[T],
        gathered: &[T],
        v: &[V; 6],
        w: &[V; 6],
    ) -> Residuals<V> {
        let zero = V::splat(T::ZERO);
        let (kappa, scale) = (V::splat(self.system.kappa), V::splat(self.system.rhs.scale));
        let (p, pbar): (V, V) = (at(gathered, Gathered::<S>::P), at(gathered, Gathered::<S>::PBAR));
        let mut r = Residuals {
            a: [zero; 6],
            b: at(gathered, Gathered::<S>::B),
            c: [zero; 6],
            d: at(gathered, Gathered::<S>::D),
        };
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let g: V = at(header, Place::<S>::NORMAL + f);
            let before: V = at(gathered, Gathered::<S>::BEFORE + f);
            let after: V = at(gathered, Gathered::<S>::AFTER + f);
            let p_beside: V = at(gathered, Gathered::<S>::P + 1 + f);
            let pbar_beside: V = at(gathered, Gathered::<S>::PBAR + 1 + f);
            let target: V = at(gathered, Gathered::<S>::TARGET + f);
            let source: V = at(gathered, Gathered::<S>::SOURCE + f);
            r.a[f] = scale * target - (kappa * v[f] - after + w[f] + g * (pbar_beside - pbar));
            r.c[f] = source - (v[f] - before - w[f] + g * (p_beside - p));
            r.b = r.b - g * v[f];
            r.d = r.d - g * w[f];
        });
        r
    }
}

/// (A-, A+) and (B-, B+) of a field at an edge, from the cells' own faces and those outside.
#[inline(always)]
fn quad<S: Space, V: Vector>(gathered: &[V::Elem], field: usize, own: &[V; 6], e: usize) -> ([V; 2], [V; 2]) {
    let edge = Edge::new::<S>(e);
    let (own_a, own_b) = (own[edge.face_a()], own[edge.face_b()]);
    let (outside_a, outside_b) = (
        at(gathered, field + S::FACES + 2 * e),
        at(gathered, field + S::FACES + 2 * e + 1),
    );
    (
        Edge::order(own_a, outside_a, edge.side_b),
        Edge::order(own_b, outside_b, edge.side_a),
    )
}
