//! The equations of one slot at a cell: residuals, local Jacobian, and the block of the system in time that they make.

use super::edge::Edge;
use super::factor::triangle;
use super::gather::Gathered;
use super::reflection::{ABOVE, BELOW, Place, face};
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

/// The local Jacobian and the lower triangle of the outside-face term.
struct Jacobian<V> {
    inside: [[V; 6]; 6],
    outside: [[V; 6]; 6],
}

impl<V: Copy> Jacobian<V> {
    /// Lets the faces along y change places.
    #[inline(always)]
    fn flip<S: Space>(&mut self) {
        let Self { inside, outside } = self;
        (inside[BELOW], inside[ABOVE]) = (inside[ABOVE], inside[BELOW]);
        unroll!(e < S::FACES; 0 1 2 3 4 5; {
            (inside[e][BELOW], inside[e][ABOVE]) = (inside[e][ABOVE], inside[e][BELOW]);
            if e / 2 != BELOW / 2 {
                let (below, above) = ((BELOW.max(e), BELOW.min(e)), (ABOVE.max(e), ABOVE.min(e)));
                (outside[below.0][below.1], outside[above.0][above.1]) = (outside[above.0][above.1], outside[below.0][below.1]);
            }
        });
        (outside[BELOW][BELOW], outside[ABOVE][ABOVE]) = (outside[ABOVE][ABOVE], outside[BELOW][BELOW]);
    }
}

impl<T: Real> Group<'_, '_, T> {
    /// Residuals, Jacobian and from them a, c, M and the diagonal block of slot `k`.
    #[inline(always)]
    pub(super) fn assemble<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(&self, header: &[T], gathered: &[T], k: usize, now: &mut [T]) {
        let (lanes, zero) = (V::LANES, V::splat(T::ZERO));
        let (header, gathered) = (&header[..Header::<S>::SIZE * lanes], &gathered[..Gathered::<S>::SIZE * lanes]);
        let (residuals, mut jacobian) = self.residuals::<S, V, VISCOUS>(header, gathered);
        let mut g = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            g[f] = at(header, Place::<S>::NORMAL + f);
        });
        let inverse: V = at(header, Place::<S>::INVERSE);
        let (beta, delta) = (residuals.b * inverse, residuals.d * inverse);
        // J g and J^T g.
        let mut column = [zero; 6];
        let mut row = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let first = first_coupled(f);
            (column[f], row[f]) = (jacobian.inside[f][first] * g[first], g[first] * jacobian.inside[first][f]);
            unroll!(e < S::FACES; 1 2 3 4 5; {
                if coupled(f, e) && e > first {
                    column[f] = column[f] + jacobian.inside[f][e] * g[e];
                    row[f] = row[f] + g[e] * jacobian.inside[e][f];
                }
            });
        });
        let (mut normal_a, mut normal_c) = (zero, zero);
        let mut reduced_a = [zero; 6];
        let mut reduced_c = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            normal_a = normal_a + g[f] * residuals.a[f];
            normal_c = normal_c + g[f] * residuals.c[f];
            let free: V = at(header, Place::<S>::FREE + f);
            reduced_a[f] = free * (residuals.a[f] - row[f] * delta);
            reduced_c[f] = free * (residuals.c[f] - column[f] * beta);
            (row[f] + g[f]).store(&mut now[(Kept::<S>::ROW + f) * lanes..]);
            (column[f] + g[f]).store(&mut now[(Kept::<S>::COLUMN + f) * lanes..]);
        });
        beta.store(&mut now[Kept::<S>::NORMAL * lanes..]);
        delta.store(&mut now[(Kept::<S>::NORMAL + 1) * lanes..]);
        normal_a.store(&mut now[(Kept::<S>::NORMAL + 2) * lanes..]);
        normal_c.store(&mut now[(Kept::<S>::NORMAL + 3) * lanes..]);
        let last = k + 1 == self.system.slots;
        let diagonal = if last { self.system.kappa } else { self.system.kappa + T::ONE };
        let mut sides = [Side { of_g: row, residual: reduced_a }, Side { of_g: column, residual: reduced_c }];
        if self.above_wall {
            jacobian.flip::<S>();
            let [a, c] = &mut sides;
            a.flip();
            c.flip();
        }
        reduce::<T, S, V>(header, &jacobian, &sides, diagonal, self.system.outside, now);
    }

    /// The residuals at the group's cells and faces and the Jacobian there, edge by edge.
    ///
    /// Powers of 2 are taken out of products, which rounds nothing: plaquettes hold omega / 4, 2 abar and 2 bbar, and sigma_a and sigma_b
    /// are a quarter of the derivatives of omega by the cell's own a- and b-face.
    #[inline(always)]
    fn residuals<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(&self, header: &[T], gathered: &[T]) -> (Residuals<V>, Jacobian<V>) {
        let (zero, one) = (V::splat(T::ZERO), V::splat(T::ONE));
        // Makes up for the two quarters that it meets: of omega or sigma, and of sigma.
        let viscosity = V::splat(self.system.viscosity * T::from_f64(16.0));
        let (mut v, mut w) = ([zero; 6], [zero; 6]);
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            (v[f], w[f]) = (at(gathered, Gathered::<S>::V + f), at(gathered, Gathered::<S>::W + f));
        });
        let mut r = self.linear_residuals::<S, V>(header, gathered, &v, &w);
        let mut j = Jacobian { inside: [[zero; 6]; 6], outside: [[zero; 6]; 6] };
        unroll!(e < S::EDGES; 0 1 2 3 4 5 6 7 8 9 10 11; {
            let edge = Edge::new::<S>(e);
            let (fa, fb) = (2 * edge.a + edge.side_a, 2 * edge.b + edge.side_b);
            let (va, vb): ([V; 2], [V; 2]) = quad::<S, V>(gathered, Gathered::<S>::V, &v, e);
            let (wa, wb): ([V; 2], [V; 2]) = quad::<S, V>(gathered, Gathered::<S>::W, &w, e);
            let (inverse_a, inverse_b): (V, V) = (at(header, Header::<S>::EDGES + 2 * e), at(header, Header::<S>::EDGES + 2 * e + 1));
            let sigma_a = if edge.side_b == 1 { inverse_b } else { -inverse_b };
            let sigma_b = if edge.side_a == 1 { -inverse_a } else { inverse_a };
            let inverse = [inverse_a, inverse_b];
            let (p, m) = (Plaquette::new(va, vb, inverse, one), Plaquette::new(wa, wb, inverse, one));
            r.c[fa] = r.c[fa] + p.omega * p.bbar;
            r.c[fb] = r.c[fb] - p.omega * p.abar;
            // What omega does to w, by 4.
            let mut spin = m.bbar * p.abar - m.abar * p.bbar;
            // Rows of the Jacobian at the a- and b-faces of the edge, by the cell's own a- and b-face: what advection does, which
            // is the same at both faces of a component ..
            let (mut aa, mut ab) = (-(sigma_a * p.bbar), -(sigma_b * p.bbar + p.omega));
            let (mut ba, mut bb) = (sigma_a * p.abar + p.omega, sigma_b * p.abar);
            let (mut outside_aa, mut outside_ab, mut outside_ba, mut outside_bb) = (aa, ab, ba, bb);
            if VISCOUS {
                let drag = viscosity * p.omega;
                r.c[fa] = r.c[fa] - sigma_a * drag;
                r.c[fb] = r.c[fb] - sigma_b * drag;
                spin = spin + viscosity * m.omega;
                // .. and what viscosity does at the cell's own face, the opposite outside.
                let (drag_a, drag_b) = (viscosity * sigma_a, viscosity * sigma_b);
                let (drag_aa, drag_ab, drag_bb) = (drag_a * sigma_a, drag_a * sigma_b, drag_b * sigma_b);
                (outside_aa, outside_ab, outside_ba, outside_bb) = (aa - drag_aa, ab - drag_ab, ba - drag_ab, bb - drag_bb);
                (aa, ab, ba, bb) = (aa + drag_aa, ab + drag_ab, ba + drag_ab, bb + drag_bb);
            }
            r.a[fa] = r.a[fa] - (m.bbar * p.omega + sigma_a * spin);
            r.a[fb] = r.a[fb] + (m.abar * p.omega - sigma_b * spin);
            j.inside[fa][fa] = j.inside[fa][fa] + aa;
            j.inside[fb][fb] = j.inside[fb][fb] + bb;
            (j.inside[fa][fb], j.inside[fb][fa]) = (ab, ba);
            j.outside[fa][fa] = j.outside[fa][fa] + (outside_aa * outside_aa + outside_ba * outside_ba);
            j.outside[fb][fb] = j.outside[fb][fb] + (outside_ab * outside_ab + outside_bb * outside_bb);
            j.outside[fa.max(fb)][fa.min(fb)] = outside_aa * outside_ab + outside_ba * outside_bb;
        });
        (r, j)
    }

    /// The residuals without self-advection, from `v` and `w` at the cells' own faces.
    #[inline(always)]
    fn linear_residuals<S: Space, V: Vector<Elem = T>>(&self, header: &[T], gathered: &[T], v: &[V; 6], w: &[V; 6]) -> Residuals<V> {
        let zero = V::splat(T::ZERO);
        let (kappa, scale) = (V::splat(self.system.kappa), V::splat(self.system.rhs.scale));
        let (p, pbar): (V, V) = (at(gathered, Gathered::<S>::P), at(gathered, Gathered::<S>::PBAR));
        let mut r = Residuals { a: [zero; 6], b: at(gathered, Gathered::<S>::B), c: [zero; 6], d: at(gathered, Gathered::<S>::D) };
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
    let (own_a, own_b) = (own[2 * edge.a + edge.side_a], own[2 * edge.b + edge.side_b]);
    let (outside_a, outside_b) = (at(gathered, field + S::FACES + 2 * e), at(gathered, field + S::FACES + 2 * e + 1));
    (Edge::order(own_a, outside_a, edge.side_b), Edge::order(own_b, outside_b, edge.side_a))
}

/// Whether the local Jacobian couples faces `f` and `e`: not the two faces of one axis.
#[inline(always)]
fn coupled(f: usize, e: usize) -> bool {
    f == e || f / 2 != e / 2
}

/// The first face that face `f` is coupled with.
#[inline(always)]
fn first_coupled(f: usize) -> usize {
    usize::from(f == 1)
}

/// One of the equations a and c at the faces, and what the Jacobian, transposed for a, makes of g.
struct Side<V> {
    of_g: [V; 6],
    residual: [V; 6],
}

impl<V: Copy> Side<V> {
    /// Lets the faces along y change places.
    #[inline(always)]
    fn flip(&mut self) {
        let Self { of_g, residual } = self;
        (of_g[BELOW], of_g[ABOVE]) = (of_g[ABOVE], of_g[BELOW]);
        (residual[BELOW], residual[ABOVE]) = (residual[ABOVE], residual[BELOW]);
    }
}

/// M = 1 + B^T J B, c = B^T rc, a + M^T c, and the diagonal block (kappa + 1) + M^T M + omega B^T O B.
#[inline(always)]
fn reduce<T: Real, S: Space, V: Vector<Elem = T>>(header: &[T], jacobian: &Jacobian<V>, [a, c]: &[Side<V>; 2], diagonal: T, outside: T, now: &mut [T]) {
    let (lanes, zero) = (V::LANES, V::splat(T::ZERO));
    let mut u = [zero; 6];
    unroll!(f < S::FACES; 0 1 2 3 4 5; {
        u[f] = at(header, Place::<S>::REFLECTION + f);
    });
    let (along, across): (V, V) = (at(header, Place::<S>::ALONG), at(header, Place::<S>::ACROSS));
    // H X H = X - u (X^T u)^T - (X u - <u, X u> u) u^T, for J, whose products with u follow from those with g, and for O.
    let (mut ju, mut uj, mut ou) = ([zero; 6], [zero; 6], [zero; 6]);
    let (mut uju, mut uou, mut ua, mut uc) = (zero, zero, zero, zero);
    unroll!(f < S::FACES; 0 1 2 3 4 5; {
        (ju[f], uj[f]) = (along * c.of_g[f], along * a.of_g[f]);
        if coupled(f, BELOW) {
            ju[f] = ju[f] + across * jacobian.inside[f][BELOW];
            uj[f] = uj[f] + across * jacobian.inside[BELOW][f];
        }
        let first = first_coupled(f);
        ou[f] = jacobian.outside[f][first] * u[first];
        unroll!(e < S::FACES; 1 2 3 4 5; {
            if coupled(f, e) && e > first {
                ou[f] = ou[f] + jacobian.outside[f.max(e)][f.min(e)] * u[e];
            }
        });
        uju = uju + u[f] * ju[f];
        uou = uou + u[f] * ou[f];
        ua = ua + u[f] * a.residual[f];
        uc = uc + u[f] * c.residual[f];
    });
    let mut m = [[zero; 5]; 5];
    let mut block = [[zero; 5]; 5];
    let mut right = [zero; 5];
    let mut force = [zero; 5];
    unroll!(i < S::FREE; 0 1 2 3 4; {
        let f = face(i);
        let (of_j, of_o) = (ju[f] - uju * u[f], ou[f] - uou * u[f]);
        unroll!(j < S::FREE; 0 1 2 3 4; {
            let e = face(j);
            let change = u[f] * uj[e] + of_j * u[e];
            m[i][j] = if coupled(f, e) { jacobian.inside[f][e] - change } else { -change };
            if i >= j {
                let change = u[f] * ou[e] + of_o * u[e];
                block[i][j] = if coupled(f, e) { jacobian.outside[f][e] - change } else { -change };
            }
        });
        m[i][i] = m[i][i] + V::splat(T::ONE);
        right[i] = a.residual[f] - u[f] * ua;
        force[i] = c.residual[f] - u[f] * uc;
    });
    unroll!(row < S::FREE; 0 1 2 3 4; {
        unroll!(i < row + 1; 0 1 2 3 4; {
            let mut sum = V::splat(outside) * block[row][i];
            unroll!(l < S::FREE; 0 1 2 3 4; {
                sum = sum + m[l][row] * m[l][i];
            });
            if row == i {
                sum = sum + V::splat(diagonal);
            }
            sum.store(&mut now[(Kept::<S>::FACTOR + triangle(row, i)) * lanes..]);
        });
        unroll!(l < S::FREE; 0 1 2 3 4; {
            right[row] = right[row] + m[l][row] * force[l];
            m[row][l].store(&mut now[(Kept::<S>::MATRIX + row * S::FREE + l) * lanes..]);
        });
        right[row].store(&mut now[(Kept::<S>::RIGHT + row) * lanes..]);
        force[row].store(&mut now[(Kept::<S>::FORCE + row) * lanes..]);
    });
}
