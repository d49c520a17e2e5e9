//! The local Jacobian J and the outside-face term O of a cell in one slot, and what the reflection H makes of
//! them.

use super::edge::Edge;
use super::group::Group;
use super::lanes::{at, unroll};
use super::reflection::{ABOVE, BELOW, Place, face, reflection};
use super::storage::Header;
use crate::grid::Space;
use crate::operators::plaquette::Plaquette;
use crate::real::Real;
use crate::simd::Vector;

/// J, by rows.
pub(super) struct Jacobian<V>([[V; 6]; 6]);

/// The lower triangle of O.
pub(super) struct Outside<V>([[V; 6]; 6]);

/// What a change of the cell's own a- and b-face does at the faces of an edge along the same axes: at the
/// cell's own, and at those outside.
struct Rows<V> {
    inside: [[V; 2]; 2],
    outside: [[V; 2]; 2],
}

impl<T: Real> Group<'_, '_, T> {
    /// J, edge by edge, 0 where `moving` is 0.
    #[inline(always)]
    pub(super) fn jacobian<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &self,
        header: &[T],
        plaquettes: &[Plaquette<V>; 12],
        moving: V,
    ) -> Jacobian<V> {
        let mut j = [[V::splat(T::ZERO); 6]; 6];
        unroll!(e < S::EDGES; 0 1 2 3 4 5 6 7 8 9 10 11; {
            let (fa, fb) = (Edge::new::<S>(e).face_a(), Edge::new::<S>(e).face_b());
            let [[aa, ab], [ba, bb]] = self.rows::<S, V, VISCOUS>(header, plaquettes, e, moving).inside;
            (j[fa][fa], j[fb][fb]) = (j[fa][fa] + aa, j[fb][fb] + bb);
            (j[fa][fb], j[fb][fa]) = (ab, ba);
        });
        Jacobian(j)
    }

    /// O, edge by edge, 0 where `moving` is 0. In one pass with J the smoother's frame with AVX-512 would be
    /// 3,200 bytes longer.
    #[inline(always)]
    pub(super) fn outside<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &self,
        header: &[T],
        plaquettes: &[Plaquette<V>; 12],
        moving: V,
    ) -> Outside<V> {
        let mut o = [[V::splat(T::ZERO); 6]; 6];
        unroll!(e < S::EDGES; 0 1 2 3 4 5 6 7 8 9 10 11; {
            let (fa, fb) = (Edge::new::<S>(e).face_a(), Edge::new::<S>(e).face_b());
            let [[aa, ab], [ba, bb]] = self.rows::<S, V, VISCOUS>(header, plaquettes, e, moving).outside;
            o[fa][fa] = o[fa][fa] + (aa * aa + ba * ba);
            o[fb][fb] = o[fb][fb] + (ab * ab + bb * bb);
            o[fa.max(fb)][fa.min(fb)] = aa * ab + ba * bb;
        });
        Outside(o)
    }

    /// What the cell's own faces do at edge `e`, 0 where `moving` is 0.
    #[inline(always)]
    fn rows<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
        &self,
        header: &[T],
        plaquettes: &[Plaquette<V>; 12],
        e: usize,
        moving: V,
    ) -> Rows<V> {
        let (_, [sigma_a, sigma_b]) = slopes::<S, V>(header, e);
        let Plaquette { omega, abar, bbar } = plaquettes[e];
        let (omega, abar, bbar) = (moving * omega, moving * abar, moving * bbar);
        // What advection does, which is the same at both faces of a component ..
        let (aa, ab) = (-(sigma_a * bbar), -(sigma_b * bbar + omega));
        let (ba, bb) = (sigma_a * abar + omega, sigma_b * abar);
        let rows = [[aa, ab], [ba, bb]];
        if !VISCOUS {
            return Rows {
                inside: rows,
                outside: rows,
            };
        }
        // .. and what viscosity does at the cell's own face, the opposite outside.
        let viscosity = moving * self.viscosity::<V>();
        let (drag_a, drag_b) = (viscosity * sigma_a, viscosity * sigma_b);
        let (drag_aa, drag_ab, drag_bb) = (drag_a * sigma_a, drag_a * sigma_b, drag_b * sigma_b);
        Rows {
            inside: [[aa + drag_aa, ab + drag_ab], [ba + drag_ab, bb + drag_bb]],
            outside: [[aa - drag_aa, ab - drag_ab], [ba - drag_ab, bb - drag_bb]],
        }
    }
}

impl<V: Vector> Jacobian<V> {
    /// J g and J^T g.
    #[inline(always)]
    pub(super) fn along<S: Space>(&self, g: &[V; 6]) -> [[V; 6]; 2] {
        let Self(j) = self;
        let [mut column, mut row] = [*g; 2];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let first = first_coupled(f);
            (column[f], row[f]) = (j[f][first] * g[first], g[first] * j[first][f]);
            unroll!(e < S::FACES; 1 2 3 4 5; {
                if coupled(f, e) && e > first {
                    column[f] = column[f] + j[f][e] * g[e];
                    row[f] = row[f] + g[e] * j[e][f];
                }
            });
        });
        [column, row]
    }

    /// Lets the faces along y change places.
    #[inline(always)]
    pub(super) fn flip<S: Space>(&mut self) {
        let Self(j) = self;
        (j[BELOW], j[ABOVE]) = (j[ABOVE], j[BELOW]);
        unroll!(e < S::FACES; 0 1 2 3 4 5; {
            (j[e][BELOW], j[e][ABOVE]) = (j[e][ABOVE], j[e][BELOW]);
        });
    }

    /// M = 1 + B^T J B from J^T g and J g.
    ///
    /// H J H = J - u (J^T u)^T - (J u - <u, J u> u) u^T, where products with u follow from those with g.
    #[inline(always)]
    pub(super) fn reduce<S: Space>(&self, header: &[V::Elem], [of_g_a, of_g_c]: [&[V; 6]; 2]) -> [[V; 5]; 5]
    where
        V::Elem: Real,
    {
        let Self(j) = self;
        let zero = V::splat(V::Elem::ZERO);
        let one = V::splat(V::Elem::ONE);
        let u = reflection::<S, V>(header);
        let (along, across): (V, V) = (at(header, Place::<S>::ALONG), at(header, Place::<S>::ACROSS));
        let mut ju = [zero; 6];
        let mut uj = [zero; 6];
        let mut uju = zero;
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            (ju[f], uj[f]) = (along * of_g_c[f], along * of_g_a[f]);
            if coupled(f, BELOW) {
                ju[f] = ju[f] + across * j[f][BELOW];
                uj[f] = uj[f] + across * j[BELOW][f];
            }
            uju = uju + u[f] * ju[f];
        });
        let mut m = [[zero; 5]; 5];
        unroll!(i < S::FREE; 0 1 2 3 4; {
            let f = face(i);
            let of_j = ju[f] - uju * u[f];
            unroll!(k < S::FREE; 0 1 2 3 4; {
                let e = face(k);
                let change = u[f] * uj[e] + of_j * u[e];
                m[i][k] = if coupled(f, e) { j[f][e] - change } else { -change };
            });
            m[i][i] = m[i][i] + one;
        });
        m
    }
}

impl<V: Vector> Outside<V> {
    /// Lets the faces along y change places.
    #[inline(always)]
    pub(super) fn flip<S: Space>(&mut self) {
        let Self(o) = self;
        unroll!(e < S::FACES; 0 1 2 3 4 5; {
            if e / 2 != BELOW / 2 {
                let (below, above) = ((BELOW.max(e), BELOW.min(e)), (ABOVE.max(e), ABOVE.min(e)));
                (o[below.0][below.1], o[above.0][above.1]) = (o[above.0][above.1], o[below.0][below.1]);
            }
        });
        (o[BELOW][BELOW], o[ABOVE][ABOVE]) = (o[ABOVE][ABOVE], o[BELOW][BELOW]);
    }

    /// The lower triangle of omega B^T O B.
    #[inline(always)]
    pub(super) fn reduce<S: Space>(&self, header: &[V::Elem], weight: V) -> [[V; 5]; 5]
    where
        V::Elem: Real,
    {
        let Self(o) = self;
        let zero = V::splat(V::Elem::ZERO);
        let u = reflection::<S, V>(header);
        let mut ou = [zero; 6];
        let mut uou = zero;
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let first = first_coupled(f);
            ou[f] = o[f][first] * u[first];
            unroll!(e < S::FACES; 1 2 3 4 5; {
                if coupled(f, e) && e > first {
                    ou[f] = ou[f] + o[f.max(e)][f.min(e)] * u[e];
                }
            });
            uou = uou + u[f] * ou[f];
        });
        let mut block = [[zero; 5]; 5];
        unroll!(i < S::FREE; 0 1 2 3 4; {
            let f = face(i);
            let of_o = ou[f] - uou * u[f];
            unroll!(k < i + 1; 0 1 2 3 4; {
                let e = face(k);
                let change = u[f] * ou[e] + of_o * u[e];
                block[i][k] = weight * (if coupled(f, e) { o[f][e] - change } else { -change });
            });
        });
        block
    }
}

/// 1 / 4h along both axes of an edge, 0 on walls, and sigma_a and sigma_b, a quarter of the derivatives of
/// omega by the cell's own a- and b-face.
#[inline(always)]
pub(super) fn slopes<S: Space, V: Vector>(header: &[V::Elem], e: usize) -> ([V; 2], [V; 2]) {
    let edge = Edge::new::<S>(e);
    let (inverse_a, inverse_b): (V, V) = (
        at(header, Header::<S>::EDGES + 2 * e),
        at(header, Header::<S>::EDGES + 2 * e + 1),
    );
    let sigma_a = if edge.side_b == 1 { inverse_b } else { -inverse_b };
    let sigma_b = if edge.side_a == 1 { -inverse_a } else { inverse_a };
    ([inverse_a, inverse_b], [sigma_a, sigma_b])
}

/// Whether the local Jacobian couples faces `f` and `e`: not the two faces of one axis.
#[inline(always)]
pub(super) fn coupled(f: usize, e: usize) -> bool {
    f == e || f / 2 != e / 2
}

/// The first face that face `f` is coupled with.
#[inline(always)]
pub(super) fn first_coupled(f: usize) -> usize {
    usize::from(f == 1)
}
