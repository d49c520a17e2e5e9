//! One cell in all slots at once: the time-line SCGS step (mathematics section 5, paper section 4.2).
//!
//! The unknowns are the changes of the cell's 2d faces and two pressures in every slot. With g = outward sign / h of each
//! free face (0 on a wall), B an orthonormal basis of the vectors orthogonal to g, J the local Jacobian of Adv + nu C^T C:
//!
//! ```text
//! H = 1 - u u^T, H g || e_p          B = H without column p       M_k = B^T (1 + J_k) B
//! dv_k = g rb_k/|g|^2 + B y_k        dw_k = g rd_k/|g|^2 + B q_k
//! q_k = M_k y_k - y_{k-1} - c_k
//! [kappa + 1 (not in slot T) + M_k^T M_k + omega B^T O_k B] y_k - M_k^T y_{k-1} - M_{k+1} y_{k+1} = a_k + M_k^T c_k - c_{k+1}
//! ```
//!
//! a symmetric positive definite block-tridiagonal system, solved by a block L D L^T factorisation with one cell in each SIMD lane.
//! O_k is the outside-face term: the force that the cell's own change stirs up on faces that are not its own.
//! H is a Householder reflection (Golub & Van Loan, Matrix Computations, section 5.1), so B^T X B is X after two changes of rank 1;
//! p is a face along y, which is free in all cells of a row or in none. Where it is the one above, the faces along y change places
//! while the system is reduced.

use super::colours::Cells;
use super::level::System;
use crate::grid::{D2, D3, Space};
use crate::operators::plaquette::Plaquette;
use crate::real::Real;
use crate::simd::Vector;
#[cfg(target_arch = "x86_64")]
use crate::simd::{self, Level};
use core::any::TypeId;
use core::mem::ManuallyDrop;

/// Most lanes of a vector.
const MAX_LANES: usize = 16;

/// Groups that go from slot to slot side by side at most: a row's numbers in a slot are read once, and one group is worked on while
/// the other's divisions are under way.
const GROUPS: usize = 2;

/// The faces along y: p is the one below, or above where there is a wall below.
const BELOW: usize = 2;
const ABOVE: usize = 3;

/// Places in a row of the table: for each face u (with p in the place of the face below), g and 1 where it is free; then three numbers.
struct Place<S>(core::marker::PhantomData<S>);
impl<S: Space> Place<S> {
    const REFLECTION: usize = 0;
    const NORMAL: usize = S::FACES;
    const FREE: usize = 2 * S::FACES;
    /// 1 / |g|^2.
    const INVERSE: usize = 3 * S::FACES;
    /// u = ALONG g + ACROSS e_p.
    const ALONG: usize = Self::INVERSE + 1;
    const ACROSS: usize = Self::ALONG + 1;
    const SIZE: usize = Self::ACROSS + 1;
}

/// Numbers of the table of reflections: one row for each combination of walls.
#[must_use]
pub fn table_len<S: Space>() -> usize {
    Place::<S>::SIZE << (2 * S::DIM)
}

/// Fills the table for cells of size `h`.
pub fn fill_table<T: Real, S: Space>(h: [f64; 3], table: &mut [T]) {
    for (walls, row) in table.chunks_exact_mut(Place::<S>::SIZE).enumerate() {
        let mut g = [0.0; 6];
        for (f, g) in g.iter_mut().enumerate().take(S::FACES) {
            *g = if walls >> f & 1 == 1 { 0.0 } else { [-1.0, 1.0][f % 2] / h[f / 2] };
        }
        let squared: f64 = g.iter().map(|g| g * g).sum();
        let above_wall = walls >> BELOW & 1 == 1;
        let p = if above_wall { ABOVE } else { BELOW };
        if g[p] == 0.0 {
            // No grid has cells with walls on both sides along y.
            row.fill(T::ZERO);
            continue;
        }
        // u is g / |g| + sign(g_p) e_p, so long that u u^T is twice the projection on it.
        let (norm, sign) = (libm::sqrt(squared), if g[p] > 0.0 { 1.0 } else { -1.0 });
        let across = sign / libm::sqrt(1.0 + sign * g[p] / norm);
        let along = sign * across / norm;
        for (f, &g) in g.iter().enumerate().take(S::FACES) {
            row[Place::<S>::REFLECTION + f] = T::from_f64(along * g + if f == p { across } else { 0.0 });
            row[Place::<S>::NORMAL + f] = T::from_f64(g);
            row[Place::<S>::FREE + f] = T::from_f64(if g == 0.0 { 0.0 } else { 1.0 });
        }
        if above_wall {
            row.swap(Place::<S>::REFLECTION + BELOW, Place::<S>::REFLECTION + ABOVE);
        }
        row[Place::<S>::INVERSE] = T::from_f64(1.0 / squared);
        row[Place::<S>::ALONG] = T::from_f64(along);
        row[Place::<S>::ACROSS] = T::from_f64(across);
    }
}

/// The face of unknown `i`, where p is the face below.
#[inline(always)]
const fn face(i: usize) -> usize {
    if i < BELOW { i } else { i + 1 }
}

/// Changes that a cell's solution has in one slot: dv and dw at its faces, dp, dpbar.
#[must_use]
pub const fn changes<S: Space>() -> usize {
    2 * S::FACES + 2
}

/// Offsets, in vectors, of what is kept for each slot between the sweeps of the factorisation.
struct Kept<S>(core::marker::PhantomData<S>);
impl<S: Space> Kept<S> {
    const FACTOR: usize = 0;
    const RIGHT: usize = Self::FACTOR + S::FREE * (S::FREE + 1) / 2;
    const MATRIX: usize = Self::RIGHT + S::FREE;
    const FORCE: usize = Self::MATRIX + S::FREE * S::FREE;
    const ROW: usize = Self::FORCE + S::FREE;
    const COLUMN: usize = Self::ROW + S::FACES;
    const NORMAL: usize = Self::COLUMN + S::FACES;
    const SIZE: usize = Self::NORMAL + 4;
}

/// Offsets, in vectors, of what a group of cells keeps for all slots: its rows of the table, and 1 / h of every edge; and of the block
/// left of the diagonal, on its way from the elimination of one slot to that of the next.
struct Header<S>(core::marker::PhantomData<S>);
impl<S: Space> Header<S> {
    const EDGES: usize = Place::<S>::SIZE;
    const SIZE: usize = Self::EDGES + 2 * S::EDGES;
    const LOWER: usize = S::FREE * S::FREE;
}

/// Numbers of scratch for `lanes` cells side by side.
#[must_use]
pub fn scratch_len<S: Space>(slots: usize, lanes: usize) -> usize {
    per_lane::<S>(slots) * lanes
}

/// Those of one of them.
fn per_lane<S: Space>(slots: usize) -> usize {
    Header::<S>::SIZE + Header::<S>::LOWER + slots * Kept::<S>::SIZE
}

/// Where [`solve_row`] puts the changes of a row of cells.
pub struct Changes<'a, T> {
    /// [`changes`] times `slots` times `half` numbers: every quantity through all slots.
    pub out: &'a mut [T],
    /// Cells of one colour that a row has room for.
    pub half: usize,
}

/// The cells of one row that a thread solves, at most `lanes` at a time.
struct Row<'r, 'a, T> {
    system: &'r System<'a, T>,
    row: usize,
    cells: Cells,
    lanes: usize,
    scratch: &'r mut [T],
    out: Changes<'r, T>,
}

/// The longest function of the core, compiled with it once for each kind and not again in every program that solves.
macro_rules! compiled_once {
    ($($name:ident[$t:ty, $space:ty],)*) => {
        $(#[inline(never)]
        fn $name(row: Row<'_, '_, $t>) {
            row.solve::<$space>();
        })*

        /// Solves the cells `start`, `start + 2`, .. of `row`, at most `lanes` at a time, and writes their changes.
        pub fn solve_row<T: Real, S: Space>(system: &System<'_, T>, row: usize, cells: Cells, lanes: usize, scratch: &mut [T], out: Changes<'_, T>) {
            let row = ManuallyDrop::new(Row { system, row, cells, lanes, scratch, out });
            $(if TypeId::of::<(T, S)>() == TypeId::of::<($t, $space)>() {
                #[allow(unsafe_code)]
                // SAFETY: T is this number, so both are one type; the original is not used again.
                return $name(unsafe { core::mem::transmute_copy(&row) });
            })*
        }
    };
}
compiled_once! {
    solve_row_f32_2d[f32, D2],
    solve_row_f32_3d[f32, D3],
    solve_row_f64_2d[f64, D2],
    solve_row_f64_3d[f64, D3],
}

impl<T: Real> Row<'_, '_, T> {
    #[inline(always)]
    fn solve<S: Space>(self) {
        #[cfg(target_arch = "x86_64")]
        {
            if simd::level() == Level::Avx512 && T::Wide::LANES <= self.lanes {
                #[allow(unsafe_code)]
                // SAFETY: `level` says that the processor has AVX-512.
                return unsafe { avx512::<T, S>(self) };
            }
            if simd::level() >= Level::Avx2 && T::Medium::LANES <= self.lanes {
                #[allow(unsafe_code)]
                // SAFETY: `level` says that the processor has AVX2.
                return unsafe { avx2::<T, S>(self) };
            }
        }
        if T::Narrow::LANES <= self.lanes {
            groups::<T, S, T::Narrow>(self);
        } else {
            groups::<T, S, T>(self);
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
fn avx512<T: Real, S: Space>(row: Row<'_, '_, T>) {
    groups::<T, S, T::Wide>(row);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<T: Real, S: Space>(row: Row<'_, '_, T>) {
    groups::<T, S, T::Medium>(row);
}

#[inline(always)]
fn groups<T: Real, S: Space, V: Vector<Elem = T>>(Row { system, row, cells, lanes, scratch, out }: Row<'_, '_, T>) {
    let a_group = per_lane::<S>(system.slots) * V::LANES;
    let most = (lanes / V::LANES).min(GROUPS);
    for start in (0..cells.count).step_by(most * V::LANES) {
        let mut parts = (start..cells.count).step_by(V::LANES).zip(scratch.chunks_exact_mut(a_group)).take(most);
        let mut groups: [_; GROUPS] = core::array::from_fn(|_| {
            let (first, scratch) = parts.next()?;
            let group = Group::new::<S>(system, row, cells.start + 2 * first, V::LANES.min(cells.count - first));
            let (header, rest) = scratch.split_at_mut(Header::<S>::SIZE * V::LANES);
            group.fill_header::<S, V>(header);
            let (lower, kept) = rest.split_at_mut(Header::<S>::LOWER * V::LANES);
            Some((first, group, &*header, lower, kept))
        });
        for k in 0..=system.slots {
            for (_, group, header, lower, kept) in groups.iter_mut().flatten() {
                group.factorise::<S, V>(header, lower, kept, k);
            }
        }
        for (first, group, header, _, kept) in groups.iter().flatten() {
            group.back_substitute::<S, V>(header, kept, out.out, out.half, *first);
        }
    }
}

/// Vector `index` of some numbers.
#[inline(always)]
fn at<V: Vector>(numbers: &[V::Elem], index: usize) -> V {
    V::load(&numbers[index * V::LANES..])
}

/// The body once for each of the numbers below a constant, so that it is compiled with what it indexes known.
macro_rules! unroll {
    ($i:ident < $count:expr; $($number:literal)*; $body:block) => {
        $(if $number < $count {
            let $i: usize = $number;
            $body
        })*
    };
}

/// Where a slot of the cells' row is at the first of them, and of the rows around it.
#[derive(Clone, Copy)]
struct Slot<'g> {
    rows: &'g Places,
    shift: usize,
}

/// Where the first slot of a row and of those around it is; `None` behind a wall.
type Places = [Option<usize>; 9];

/// A few cells of one row, one a lane.
struct Group<'s, 'a, T> {
    system: &'s System<'a, T>,
    /// In trajectories.
    rows: Places,
    /// In a field of one slot.
    given: Places,
    row: usize,
    x: usize,
    count: usize,
    wrap_low: bool,
    wrap_high: bool,
    above_wall: bool,
}

/// An edge of the cell, where its faces `face_a` and `face_b` meet.
#[derive(Clone, Copy)]
struct Edge {
    a: usize,
    b: usize,
    side_a: usize,
    side_b: usize,
}

impl Edge {
    #[inline(always)]
    fn new<S: Space>(e: usize) -> Self {
        let (a, b) = S::PAIRS[e / 4];
        Self { a, b, side_a: e % 2, side_b: e / 2 % 2 }
    }

    /// Where, from the cell, the outside a-face is.
    #[inline(always)]
    fn outside_a(self) -> [isize; 3] {
        let mut at = [0; 3];
        at[self.a] = self.side_a as isize;
        at[self.b] = 2 * self.side_b as isize - 1;
        at
    }

    /// Where, from the cell, the outside b-face is.
    #[inline(always)]
    fn outside_b(self) -> [isize; 3] {
        let mut at = [0; 3];
        at[self.b] = self.side_b as isize;
        at[self.a] = 2 * self.side_a as isize - 1;
        at
    }

    /// (A-, A+) or (B-, B+) from the cell's own face and the outside one.
    #[inline(always)]
    fn order<V>(own: V, outside: V, own_is_low: usize) -> [V; 2] {
        if own_is_low == 1 { [own, outside] } else { [outside, own] }
    }
}

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

impl<'s, 'a, T: Real> Group<'s, 'a, T> {
    #[inline(always)]
    fn new<S: Space>(system: &'s System<'a, T>, row: usize, x: usize, count: usize) -> Self {
        use crate::grid::Side::{High, Low};
        let grid = system.grid;
        let step = |row: Option<usize>, axis: usize, offset: usize| match (row, offset) {
            (Some(row), 0) => grid.neighbour(row, axis, Low),
            (Some(row), 2) => grid.neighbour(row, axis, High),
            (row, _) => row,
        };
        let (mut rows, mut given) = ([None; 9], [None; 9]);
        for (i, (in_rows, in_given)) in rows.iter_mut().zip(&mut given).enumerate() {
            let in_y = step(Some(row), 1, i % 3);
            let row = if S::DIM == 3 { step(in_y, 2, i / 3) } else { in_y.filter(|_| i / 3 == 1) };
            (*in_rows, *in_given) = (row.map(|row| row * system.slots * grid.n[0] + x), row.map(|row| row * grid.n[0] + x));
        }
        let last = x + 2 * (count - 1);
        Self {
            system,
            rows,
            given,
            row,
            x,
            count,
            wrap_low: grid.periodic[0] && x == 0,
            wrap_high: grid.periodic[0] && last + 1 == grid.n[0],
            above_wall: grid.wall_below(row, 1),
        }
    }

    /// Slot `k`.
    #[inline(always)]
    fn slot(&self, k: usize) -> Slot<'_> {
        Slot { rows: &self.rows, shift: k * self.system.grid.n[0] }
    }

    /// Numbers of `field` in a slot, `offset` from the cells; 0 behind walls along y and z.
    #[inline(always)]
    fn gather<V: Vector<Elem = T>>(&self, field: &[T], slot: Slot<'_>, offset: [isize; 3]) -> V {
        let Some(row) = slot.rows[(offset[1] + 1 + 3 * (offset[2] + 1)) as usize] else { return V::splat(T::ZERO) };
        let first = row + slot.shift;
        let wraps = (offset[0] == -1 && self.wrap_low) || (offset[0] == 1 && self.wrap_high);
        let at = first.wrapping_add_signed(offset[0]);
        match field.get(at..at.wrapping_add(2 * V::LANES)) {
            Some(both) if !wraps => V::load_even(both),
            _ => self.gather_slowly(field, first - self.x, offset[0]),
        }
    }

    /// As [`Self::gather`], lane by lane, at the ends of the field and where x wraps around.
    #[cold]
    #[inline(never)]
    fn gather_slowly<V: Vector<Elem = T>>(&self, field: &[T], start: usize, offset: isize) -> V {
        let (nx, mut lanes) = (self.system.grid.n[0] as isize, [T::ZERO; MAX_LANES]);
        for (l, lane) in lanes.iter_mut().enumerate().take(self.count) {
            let x = (self.x + 2 * l) as isize + offset;
            if self.system.grid.periodic[0] || (0..nx).contains(&x) {
                *lane = field[start + x.rem_euclid(nx) as usize];
            }
        }
        V::load(&lanes)
    }

    /// A field at the cells' own face `f`.
    #[inline(always)]
    fn own<V: Vector<Elem = T>>(&self, field: &[&[T]; 3], slot: Slot<'_>, f: usize) -> V {
        let mut offset = [0; 3];
        offset[f / 2] = (f % 2) as isize;
        self.gather(field[f / 2], slot, offset)
    }

    /// The header of the scratch; 1/h of an edge is 0 where it is on a wall.
    #[inline(always)]
    fn fill_header<S: Space, V: Vector<Elem = T>>(&self, header: &mut [T]) {
        let (grid, lanes) = (self.system.grid, V::LANES);
        let [y, z] = grid.row_at(self.row);
        for l in 0..lanes {
            let at = [(self.x + 2 * l.min(self.count - 1)), y, z];
            let wall = |f: usize| !grid.periodic[f / 2] && at[f / 2] == [0, grid.n[f / 2] - 1][f % 2];
            let walls = (0..S::FACES).fold(0, |code, f| code | usize::from(wall(f)) << f);
            let row = &self.system.table[walls * Place::<S>::SIZE..][..Place::<S>::SIZE];
            for (q, &number) in row.iter().enumerate() {
                header[q * lanes + l] = number;
            }
            for e in 0..S::EDGES {
                let edge = Edge::new::<S>(e);
                let free = !wall(2 * edge.a + edge.side_a) && !wall(2 * edge.b + edge.side_b);
                for (i, axis) in [edge.a, edge.b].into_iter().enumerate() {
                    let inverse = if free { T::from_f64(1.0 / grid.h[axis]) } else { T::ZERO };
                    header[(Header::<S>::EDGES + 2 * e + i) * lanes + l] = inverse;
                }
            }
        }
    }

    /// Assembles slot `k` of the block-tridiagonal system, and factorises the one before.
    #[inline(always)]
    fn factorise<S: Space, V: Vector<Elem = T>>(&self, header: &[T], lower: &mut [T], kept: &mut [T], k: usize) {
        let (slots, size) = (self.system.slots, Kept::<S>::SIZE * V::LANES);
        let (before, now) = kept.split_at_mut(k * size);
        if k < slots {
            self.assemble::<S, V>(header, k, &mut now[..size]);
        }
        if k > 0 {
            let (earlier, last) = before.split_at_mut((k - 1) * size);
            let two_back = if k > 1 { &earlier[(k - 2) * size..] } else { &[] };
            eliminate::<T, S, V>(two_back, last, (k < slots).then_some(&*now), lower);
        }
    }

    /// Residuals, Jacobian and from them a, c, M and the diagonal block of slot `k`.
    #[inline(always)]
    fn assemble<S: Space, V: Vector<Elem = T>>(&self, header: &[T], k: usize, now: &mut [T]) {
        let lanes = V::LANES;
        let zero = V::splat(T::ZERO);
        let (residuals, mut jacobian) = self.residuals::<S, V>(header, k);
        let mut g = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            g[f] = at(header, Place::<S>::NORMAL + f);
        });
        let inverse: V = at(header, Place::<S>::INVERSE);
        let (beta, delta) = (residuals.b * inverse, residuals.d * inverse);
        let mut column = [zero; 6];
        let mut row = [zero; 6];
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            unroll!(e < S::FACES; 0 1 2 3 4 5; {
                if coupled(f, e) {
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
    #[inline(always)]
    fn residuals<S: Space, V: Vector<Elem = T>>(&self, header: &[T], k: usize) -> (Residuals<V>, Jacobian<V>) {
        let system = self.system;
        let (zero, half, viscosity) = (V::splat(T::ZERO), V::splat(T::HALF), V::splat(system.viscosity));
        let slot = self.slot(k);
        let (mut v, mut w) = ([zero; 6], [zero; 6]);
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            (v[f], w[f]) = (self.own(&system.v, slot, f), self.own(&system.w, slot, f));
        });
        let mut r = self.linear_residuals::<S, V>(header, k, slot, &v, &w);
        let mut j = Jacobian { inside: [[zero; 6]; 6], outside: [[zero; 6]; 6] };
        unroll!(e < S::EDGES; 0 1 2 3 4 5 6 7 8 9 10 11; {
            let edge = Edge::new::<S>(e);
            let (fa, fb) = (2 * edge.a + edge.side_a, 2 * edge.b + edge.side_b);
            let (va, vb): ([V; 2], [V; 2]) = self.quad(&system.v, slot, &v, edge);
            let (wa, wb): ([V; 2], [V; 2]) = self.quad(&system.w, slot, &w, edge);
            let (inverse_a, inverse_b): (V, V) = (at(header, Header::<S>::EDGES + 2 * e), at(header, Header::<S>::EDGES + 2 * e + 1));
            let inverse = [inverse_a, inverse_b];
            let (p, m) = (Plaquette::new(va, vb, inverse, half), Plaquette::new(wa, wb, inverse, half));
            // The derivatives of omega by the cell's own a- and b-face.
            let sigma_a = if edge.side_b == 1 { inverse_b } else { -inverse_b };
            let sigma_b = if edge.side_a == 1 { -inverse_a } else { inverse_a };
            let (half_omega, drag) = (p.omega * half, viscosity * p.omega);
            r.c[fa] = r.c[fa] + half_omega * p.bbar - sigma_a * drag;
            r.c[fb] = r.c[fb] - half_omega * p.abar - sigma_b * drag;
            let g = m.bbar * p.abar - m.abar * p.bbar + viscosity * m.omega;
            r.a[fa] = r.a[fa] - (m.bbar * half_omega + sigma_a * g);
            r.a[fb] = r.a[fb] + (m.abar * half_omega - sigma_b * g);
            let (half_sigma_a, half_sigma_b, quarter) = (half * sigma_a, half * sigma_b, half * half_omega);
            // Rows of the Jacobian at the a- and b-faces of the edge, by the cell's own a- and b-face: what advection does, which
            // is the same at both faces of a component, and what viscosity does at the cell's own face, the opposite outside.
            let (aa, ab) = (-(half_sigma_a * p.bbar), -(half_sigma_b * p.bbar + quarter));
            let (ba, bb) = (half_sigma_a * p.abar + quarter, half_sigma_b * p.abar);
            let (drag_a, drag_b) = (viscosity * sigma_a, viscosity * sigma_b);
            let (drag_aa, drag_ab, drag_bb) = (drag_a * sigma_a, drag_a * sigma_b, drag_b * sigma_b);
            j.inside[fa][fa] = j.inside[fa][fa] + (aa + drag_aa);
            j.inside[fa][fb] = j.inside[fa][fb] + (ab + drag_ab);
            j.inside[fb][fa] = j.inside[fb][fa] + (ba + drag_ab);
            j.inside[fb][fb] = j.inside[fb][fb] + (bb + drag_bb);
            let (aa, ab, ba, bb) = (aa - drag_aa, ab - drag_ab, ba - drag_ab, bb - drag_bb);
            j.outside[fa][fa] = j.outside[fa][fa] + (aa * aa + ba * ba);
            j.outside[fb][fb] = j.outside[fb][fb] + (ab * ab + bb * bb);
            let across = aa * ab + ba * bb;
            let (low, high) = (fa.min(fb), fa.max(fb));
            j.outside[high][low] = j.outside[high][low] + across;
        });
        (r, j)
    }

    /// (A-, A+) and (B-, B+) of a field at an edge, from the cells' own faces and those outside.
    #[inline(always)]
    fn quad<V: Vector<Elem = T>>(&self, field: &[&[T]; 3], slot: Slot<'_>, own: &[V; 6], edge: Edge) -> ([V; 2], [V; 2]) {
        let (own_a, own_b) = (own[2 * edge.a + edge.side_a], own[2 * edge.b + edge.side_b]);
        let outside_a = self.gather(field[edge.a], slot, edge.outside_a());
        let outside_b = self.gather(field[edge.b], slot, edge.outside_b());
        (Edge::order(own_a, outside_a, edge.side_b), Edge::order(own_b, outside_b, edge.side_a))
    }

    /// A field of cells at the cells, 0 where it is empty.
    #[inline(always)]
    fn cell<V: Vector<Elem = T>>(&self, field: &[T], slot: Slot<'_>) -> V {
        if field.is_empty() { V::splat(T::ZERO) } else { self.gather(field, slot, [0; 3]) }
    }

    /// The residuals without self-advection, from `v` and `w` at the cells' own faces in slot `k`.
    #[inline(always)]
    fn linear_residuals<S: Space, V: Vector<Elem = T>>(&self, header: &[T], k: usize, slot: Slot<'_>, v: &[V; 6], w: &[V; 6]) -> Residuals<V> {
        let system = self.system;
        let (slots, zero) = (system.slots, V::splat(T::ZERO));
        let (kappa, scale) = (V::splat(system.kappa), V::splat(system.rhs.scale));
        let (first, last) = (k == 0, k + 1 == slots);
        let slot_before = if first { Slot { rows: &self.given, shift: 0 } } else { self.slot(k - 1) };
        let slot_after = self.slot(k + 1);
        let before = if first { &system.v0 } else { &system.v };
        let (p, pbar): (V, V) = (self.cell(system.p, slot), self.cell(system.pbar, slot));
        let mut r = Residuals { a: [zero; 6], b: self.cell(system.rhs.b, slot), c: [zero; 6], d: self.cell(system.rhs.d, slot) };
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let mut beside = [0; 3];
            beside[f / 2] = [-1, 1][f % 2];
            let g: V = at(header, Place::<S>::NORMAL + f);
            let before: V = self.own(before, slot_before, f);
            let after: V = if last { zero } else { self.own(&system.w, slot_after, f) };
            let p_beside: V = self.gather(system.p, slot, beside);
            let pbar_beside: V = self.gather(system.pbar, slot, beside);
            let target: V = self.own(&system.rhs.a, slot, f);
            let source: V = if system.rhs.c[0].is_empty() { zero } else { self.own(&system.rhs.c, slot, f) };
            r.a[f] = scale * target - (kappa * v[f] - after + w[f] + g * (pbar_beside - pbar));
            r.c[f] = source - (v[f] - before - w[f] + g * (p_beside - p));
            r.b = r.b - g * v[f];
            r.d = r.d - g * w[f];
        });
        r
    }

    /// From the last slot to the first: y_{k-1}, and with it the changes of slot k.
    #[inline(always)]
    fn back_substitute<S: Space, V: Vector<Elem = T>>(&self, header: &[T], kept: &[T], out: &mut [T], half: usize, first: usize) {
        let (slots, zero) = (self.system.slots, V::splat(T::ZERO));
        // y_k and M_k y_k.
        let (mut y, mut image) = ([zero; 5], [zero; 5]);
        for k in (0..=slots).rev() {
            let mut before = [zero; 5];
            if k > 0 {
                before = solve_factor::<S, V>(&kept[(k - 1) * Kept::<S>::SIZE * V::LANES..], &image);
            }
            if k < slots {
                self.write_changes::<S, V>(header, kept, k, [&y, &image, &before], out, half, first);
            }
            if k > 0 {
                image = times_m::<S, V>(&kept[(k - 1) * Kept::<S>::SIZE * V::LANES..], &before);
            }
            y = before;
        }
    }

    /// The changes of slot k from y_k, M_k y_k and y_{k-1}: dv, then q and dw, then both pressures from the normal components of
    /// equations c and a.
    #[inline(always)]
    fn write_changes<S: Space, V: Vector<Elem = T>>(
        &self,
        header: &[T],
        kept: &[T],
        k: usize,
        [y, image, before]: [&[V; 5]; 3],
        out: &mut [T],
        half: usize,
        first: usize,
    ) {
        let (lanes, slots, zero) = (V::LANES, self.system.slots, V::splat(T::ZERO));
        let size = Kept::<S>::SIZE * lanes;
        let (inverse, kappa): (V, V) = (at(header, Place::<S>::INVERSE), V::splat(self.system.kappa));
        let now = &kept[k * size..];
        let mut q = [zero; 5];
        unroll!(i < S::FREE; 0 1 2 3 4; {
            q[i] = image[i] - before[i] - at::<V>(now, Kept::<S>::FORCE + i);
        });
        let (beta, delta): (V, V) = (at(now, Kept::<S>::NORMAL), at(now, Kept::<S>::NORMAL + 1));
        let (mut bar, mut pressure): (V, V) = (at(now, Kept::<S>::NORMAL + 2), at(now, Kept::<S>::NORMAL + 3));
        let (of_y, of_q) = (along_u::<V, S>(header, y), along_u::<V, S>(header, &q));
        let (mut dv, mut dw) = ([zero; 6], [zero; 6]);
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
        unroll!(f < S::FACES; 0 1 2 3 4 5; {
            let g: V = at(header, Place::<S>::NORMAL + f);
            (dv[f], dw[f]) = (dv[f] + g * beta, dw[f] + g * delta);
            pressure = pressure - at::<V>(now, Kept::<S>::ROW + f) * dv[f] + g * dw[f];
            bar = bar - kappa * g * dv[f] - at::<V>(now, Kept::<S>::COLUMN + f) * dw[f];
            self.put(dv[f], &mut out[(f * slots + k) * half..][first..half]);
            self.put(dw[f], &mut out[((S::FACES + f) * slots + k) * half..][first..half]);
        });
        // beta and delta are divergences over |g|^2, so times |g|^2 / |g|^2 they enter the pressures as they are.
        let before: V = if k > 0 { at(&kept[(k - 1) * size..], Kept::<S>::NORMAL) } else { zero };
        let after: V = if k + 1 < slots { at(&kept[(k + 1) * size..], Kept::<S>::NORMAL + 1) } else { zero };
        self.put(-(pressure * inverse + before), &mut out[(2 * S::FACES * slots + k) * half..][first..half]);
        self.put(-(bar * inverse + after), &mut out[((2 * S::FACES + 1) * slots + k) * half..][first..half]);
    }

    /// Stores the lanes that are cells.
    #[inline(always)]
    fn put<V: Vector<Elem = T>>(&self, v: V, to: &mut [T]) {
        if self.count == V::LANES {
            v.store(to);
        } else {
            let mut lanes = [T::ZERO; MAX_LANES];
            v.store(&mut lanes);
            to[..self.count].copy_from_slice(&lanes[..self.count]);
        }
    }
}

/// Whether the local Jacobian couples faces `f` and `e`: not the two faces of one axis.
#[inline(always)]
fn coupled(f: usize, e: usize) -> bool {
    f == e || f / 2 != e / 2
}

/// The place of (row, column), column <= row, in a packed lower triangle.
#[inline(always)]
fn triangle(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
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

/// y_k = L_k^-T (z_k + D_k^-1 L_k^-1 M_{k+1} y_{k+1}) from M_{k+1} y_{k+1}, 0 behind the last slot.
#[inline(always)]
fn solve_factor<S: Space, V: Vector>(now: &[V::Elem], image: &[V; 5]) -> [V; 5] {
    let (mut l, mut y) = ([[image[0]; 5]; 5], *image);
    unroll!(i < S::FREE; 0 1 2 3 4; {
        unroll!(j < i + 1; 0 1 2 3 4; {
            l[i][j] = at::<V>(now, Kept::<S>::FACTOR + triangle(i, j));
        });
        unroll!(j < i; 0 1 2 3; {
            y[i] = y[i] - l[i][j] * y[j];
        });
    });
    unroll!(i < S::FREE; 4 3 2 1 0; {
        y[i] = l[i][i] * y[i] + at::<V>(now, Kept::<S>::RIGHT + i);
        unroll!(j < S::FREE; 1 2 3 4; {
            if j > i {
                y[i] = y[i] - l[j][i] * y[j];
            }
        });
    });
    y
}

/// M_k y.
#[inline(always)]
fn times_m<S: Space, V: Vector>(now: &[V::Elem], y: &[V; 5]) -> [V; 5] {
    let mut image = *y;
    unroll!(i < S::FREE; 0 1 2 3 4; {
        image[i] = at::<V>(now, Kept::<S>::MATRIX + i * S::FREE) * y[0];
        unroll!(j < S::FREE; 1 2 3 4; {
            image[i] = image[i] + at::<V>(now, Kept::<S>::MATRIX + i * S::FREE + j) * y[j];
        });
    });
    image
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
        unroll!(e < S::FACES; 0 1 2 3 4 5; {
            if coupled(f, e) {
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

/// Finishes slot k once slot k + 1 (`next`) is assembled: its right-hand side, the elimination of slot k - 1 (`before`) by X_k in
/// `lower`, the factors L_k D_k L_k^T with the reciprocals of D_k on the diagonal, z_k = D_k^-1 L_k^-1 right-hand side, and
/// X_{k+1} = -L_k^-1 M_{k+1}, which takes the place of X_k.
#[inline(always)]
fn eliminate<T: Real, S: Space, V: Vector<Elem = T>>(before: &[T], now: &mut [T], next: Option<&[T]>, lower: &mut [T]) {
    let (lanes, zero) = (V::LANES, V::splat(T::ZERO));
    let mut right = [zero; 5];
    let mut l = [[zero; 5]; 5];
    unroll!(i < S::FREE; 0 1 2 3 4; {
        right[i] = at::<V>(now, Kept::<S>::RIGHT + i);
        if let Some(next) = next {
            right[i] = right[i] - at::<V>(next, Kept::<S>::FORCE + i);
        }
        unroll!(j < i + 1; 0 1 2 3 4; {
            l[i][j] = at::<V>(now, Kept::<S>::FACTOR + triangle(i, j));
        });
    });
    if !before.is_empty() {
        unroll!(m < S::FREE; 0 1 2 3 4; {
            let (z, pivot): (V, V) = (at(before, Kept::<S>::RIGHT + m), at(before, Kept::<S>::FACTOR + triangle(m, m)));
            unroll!(i < S::FREE; 0 1 2 3 4; {
                let x = at::<V>(lower, m * S::FREE + i);
                right[i] = right[i] - x * z;
                let x = x * pivot;
                unroll!(j < i + 1; 0 1 2 3 4; {
                    l[i][j] = l[i][j] - x * at::<V>(lower, m * S::FREE + j);
                });
            });
        });
    }
    // `l` becomes L D, `unit` L with the reciprocals of D.
    let mut unit = l;
    unroll!(j < S::FREE; 0 1 2 3 4; {
        unroll!(i < S::FREE; 0 1 2 3 4; {
            if i >= j {
                unroll!(k < j; 0 1 2 3; {
                    l[i][j] = l[i][j] - l[i][k] * unit[j][k];
                });
                unit[i][j] = if i == j { l[j][j].recip() } else { l[i][j] * unit[j][j] };
            }
        });
    });
    unroll!(i < S::FREE; 0 1 2 3 4; {
        unroll!(j < i; 0 1 2 3; {
            right[i] = right[i] - unit[i][j] * right[j];
        });
        (right[i] * unit[i][i]).store(&mut now[(Kept::<S>::RIGHT + i) * lanes..]);
        unroll!(j < i + 1; 0 1 2 3 4; {
            unit[i][j].store(&mut now[(Kept::<S>::FACTOR + triangle(i, j)) * lanes..]);
        });
    });
    let Some(next) = next else { return };
    unroll!(column < S::FREE; 0 1 2 3 4; {
        let mut x = [zero; 5];
        unroll!(i < S::FREE; 0 1 2 3 4; {
            x[i] = -at::<V>(next, Kept::<S>::MATRIX + i * S::FREE + column);
            unroll!(j < i; 0 1 2 3; {
                x[i] = x[i] - unit[i][j] * x[j];
            });
            x[i].store(&mut lower[(i * S::FREE + column) * lanes..]);
        });
    });
}
