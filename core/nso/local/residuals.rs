//! The residuals of the equations of one slot, at a cell and its faces.

use super::edge::Edge;
use super::group::Group;
use super::jacobian::slopes;
use super::lanes::{at, unroll};
use super::reflection::Place;
use super::storage::Gathered;
use crate::grid::Space;
use crate::operators::plaquette::Plaquette;
use crate::real::Real;
use crate::simd::Vector;

/// The momentum and divergence residuals of a group in one slot.
pub(super) struct Residuals<V> {
    pub(super) a: [V; 6],
    pub(super) b: V,
    pub(super) c: [V; 6],
    pub(super) d: V,
}

impl<T: Real> Group<'_, '_, T> {
    /// The residuals at the group's cells and faces, and the plaquettes of v at the edges.
    ///
    /// Powers of 2 are taken out of products, which rounds nothing: plaquettes hold omega / 4, 2 abar and 2
    /// bbar, and sigma_a and sigma_b are a quarter of the derivatives of omega by the cell's own a- and
    /// b-face.
    #[inline(always)]
    pub(super) fn residuals<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(
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
        let kappa = V::splat(self.system.kappa);
        let scale = V::splat(self.system.rhs.scale);
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
