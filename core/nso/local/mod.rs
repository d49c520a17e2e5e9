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
//! H is a Householder reflection, so B^T X B is X after two changes of rank 1.
//!
//! A slot is worked on in four steps, each for a few groups of cells: `gather` what its equations read, `assemble` its block, `factor`
//! the block before; and on the way back its `changes`. Where the flow is slow a damping takes the place of J and O (`pace`).

mod assemble;
mod changes;
mod edge;
mod factor;
mod gather;
mod jacobian;
mod pace;
mod reflection;

pub use pace::Slow;
pub use reflection::{fill_table, table_len};

use super::colours::Cells;
use super::level::System;
use crate::grid::{D2, D3, Space};
#[cfg(target_arch = "x86_64")]
use crate::memory::{Pool, pooled};
use crate::real::Real;
use crate::simd::Vector;
#[cfg(target_arch = "x86_64")]
use crate::simd::{self, Level};
use core::any::TypeId;
use core::mem::ManuallyDrop;
use edge::Edge;
use gather::{Gather, Gathered};
use reflection::Place;

/// Most lanes of a vector.
const MAX_LANES: usize = 16;

/// Groups that go from slot to slot side by side at most, each step of one after that of the other: a row's numbers in a slot, of as many
/// cells as a whole row of 64 has of one colour, are read once, whether they fill two vectors or four.
const GROUPS: usize = 4;

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
    const PACE: usize = Self::NORMAL + 4;
    /// Of a slow slot, until it has factors.
    const DAMPING: usize = Self::FACTOR;
    const SIZE: usize = Self::PACE + 1;
}

/// Offsets, in vectors, of what a group of cells keeps for all slots: its rows of the table, and 1 / 4h of every edge.
struct Header<S>(core::marker::PhantomData<S>);
impl<S: Space> Header<S> {
    const EDGES: usize = Place::<S>::SIZE;
    const SIZE: usize = Self::EDGES + 2 * S::EDGES;
}

/// Vectors of the block left of the diagonal, on its way from the elimination of one slot to that of the next.
const fn lower<S: Space>() -> usize {
    S::FREE * S::FREE
}

/// Numbers of scratch for `lanes` cells side by side.
#[must_use]
pub fn scratch_len<S: Space>(slots: usize, lanes: usize) -> usize {
    (Gathered::<S>::SIZE + per_group::<S>(slots)) * lanes
}

/// Lanes of a slot where a few are side by side in rows of `nx` cells: half as many, where that divides every vector, else those of `P`.
#[cfg(target_arch = "x86_64")]
fn slot_lanes<P: Vector>(nx: usize) -> usize {
    if nx.is_multiple_of(2) && (nx / 2).is_power_of_two() {
        nx / 2
    } else {
        P::LANES
    }
}

/// Vectors of scratch of a group, besides what is gathered.
fn per_group<S: Space>(slots: usize) -> usize {
    Header::<S>::SIZE + lower::<S>() + slots * Kept::<S>::SIZE
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
        if self.system.viscosity == T::ZERO {
            self.solve_at_level::<S, false>()
        } else {
            self.solve_at_level::<S, true>()
        }
    }

    /// With the longest vectors that the processor has and `lanes` allows; where a row has no more cells than the shortest have lanes, with a few slots in each.
    #[inline(always)]
    fn solve_at_level<S: Space, const VISCOUS: bool>(self) {
        #[cfg(target_arch = "x86_64")]
        {
            let half = self.out.half;
            if simd::level() == Level::Avx512 && T::Wide::LANES <= self.lanes {
                // In 3D those of AVX2 do as well, and this frame would be too long for the C library's stack.
                if S::DIM == 2
                    && half <= T::Narrow::LANES
                    && self.has_room_for_slots::<S, T::Wide, T::Narrow>()
                {
                    #[allow(unsafe_code)]
                    // SAFETY: `level` says that the processor has AVX-512.
                    return unsafe { avx512_slots::<T, S, T::Narrow, VISCOUS>(self) };
                }
                if T::Medium::LANES < self.cells.count {
                    #[allow(unsafe_code)]
                    // SAFETY: as above.
                    return unsafe { avx512::<T, S, VISCOUS>(self) };
                }
            }
            if simd::level() >= Level::Avx2 && T::Medium::LANES <= self.lanes {
                if half <= T::Narrow::LANES && self.has_room_for_slots::<S, T::Medium, T::Narrow>() {
                    #[allow(unsafe_code)]
                    // SAFETY: `level` says that the processor has AVX2.
                    return unsafe { avx2_slots::<T, S, T::Narrow, VISCOUS>(self) };
                }
                #[allow(unsafe_code)]
                // SAFETY: as above.
                return unsafe { avx2::<T, S, VISCOUS>(self) };
            }
        }
        if T::Narrow::LANES <= self.lanes {
            baseline::<T, S, T::Narrow, VISCOUS>(self);
        } else {
            baseline::<T, S, T, VISCOUS>(self);
        }
    }

    /// A few groups at a time, slot after slot, and back.
    #[inline(always)]
    fn solve_groups<S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(self) {
        let Row {
            system,
            row,
            cells,
            lanes,
            scratch,
            mut out,
        } = self;
        let (slots, most, above_wall) = (
            system.slots,
            (lanes / V::LANES).min(GROUPS),
            system.grid.wall_below(row, 1),
        );
        let (gathered, scratch) = scratch.split_at_mut(most * Gathered::<S>::SIZE * V::LANES);
        for start in (0..cells.count).step_by(most * V::LANES) {
            let part = Cells {
                start: cells.start + 2 * start,
                count: (most * V::LANES).min(cells.count - start),
            };
            let gathered = &mut gathered[..part.count.div_ceil(V::LANES) * Gathered::<S>::SIZE * V::LANES];
            let gather = Gather::new::<S>(system, row, part);
            gathered.fill(T::ZERO);
            let mut rest = scratch.chunks_exact_mut(per_group::<S>(slots) * V::LANES);
            let mut groups: [_; GROUPS] = core::array::from_fn(|index| {
                let first = start + index * V::LANES;
                let scratch = if first < cells.count {
                    rest.next()?
                } else {
                    return None;
                };
                let count = V::LANES.min(cells.count - first);
                let group = Group {
                    system,
                    row,
                    x: cells.start + 2 * first,
                    first,
                    count,
                    above_wall,
                    in_order: false,
                };
                let (header, scratch) = scratch.split_at_mut(Header::<S>::SIZE * V::LANES);
                group.fill_header::<S, V>(V::LANES, header);
                let (lower, kept) = scratch.split_at_mut(lower::<S>() * V::LANES);
                Some((group, header, lower, kept))
            });
            for k in 0..=slots {
                if k < slots {
                    gather.fill::<S, V>(k, gathered);
                    let gathered = gathered.chunks_exact(Gathered::<S>::SIZE * V::LANES);
                    for ((group, header, _, kept), gathered) in groups.iter_mut().flatten().zip(gathered) {
                        group.assemble::<S, V, VISCOUS>(
                            header,
                            gathered,
                            V::splat(group.diagonal(k)),
                            slot_mut::<S, V>(kept, k),
                        );
                    }
                }
                if k > 0 {
                    for (group, _, lower, kept) in groups.iter_mut().flatten() {
                        factor::eliminate::<T, S, V>(kept, lower, k - 1, slots, group.diagonal(k - 1));
                    }
                }
            }
            for (group, header, _, kept) in groups.iter().flatten() {
                group.back_substitute::<S, V>(header, kept, &mut out);
            }
        }
    }

    /// Whether scratch has room for [`Self::solve_slots`].
    #[cfg(target_arch = "x86_64")]
    fn has_room_for_slots<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>>(&self) -> bool {
        P::LANES < V::LANES
            && parts_for_slots::<S, V, P>(self.system.slots)
                .into_iter()
                .map(pooled)
                .sum::<usize>()
                <= self.scratch.len()
    }

    /// One group, of a row too short for vectors `V`: a few slots side by side are gathered and assembled, then cut up into vectors `P` of a slot each.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn solve_slots<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>, const VISCOUS: bool>(self) {
        let Row {
            system,
            row,
            cells,
            scratch,
            mut out,
            ..
        } = self;
        let (slots, above_wall) = (system.slots, system.grid.wall_below(row, 1));
        let each = slot_lanes::<P>(system.grid.n[0]);
        let (side_by_side, mut pool) = ((V::LANES / each).max(1), Pool::new(scratch));
        let [gathered, long_header, long, header, lower, kept] =
            parts_for_slots::<S, V, P>(slots).map(|len| pool.take(len));
        let group = Group {
            system,
            row,
            x: cells.start,
            first: 0,
            count: cells.count,
            above_wall,
            in_order: true,
        };
        group.fill_header::<S, V>(each, long_header);
        group.fill_header::<S, P>(P::LANES, header);
        let mut gather = Gather::new::<S>(system, row, cells);
        gather.add_before::<S>(system, row, cells);
        gathered.fill(T::ZERO);
        for k in 0..slots {
            let place = k % side_by_side;
            if place == 0 {
                gather.fill_slots::<S, V, P>(k, each, gathered);
                let mut diagonal = [T::ZERO; MAX_LANES];
                for (lane, diagonal) in diagonal.iter_mut().enumerate() {
                    *diagonal = group.diagonal(k + lane / each);
                }
                group.assemble::<S, V, VISCOUS>(
                    long_header,
                    gathered,
                    V::load(&diagonal),
                    slot_mut::<S, V>(long, 0),
                );
            }
            let numbers = long.get(place * each..).unwrap_or_default().chunks(V::LANES);
            for (numbers, now) in numbers.zip(slot_mut::<S, P>(kept, k).chunks_exact_mut(P::LANES)) {
                P::load(numbers).store(now);
            }
            if k > 0 {
                factor::eliminate::<T, S, P>(kept, lower, k - 1, slots, group.diagonal(k - 1));
            }
        }
        factor::eliminate::<T, S, P>(kept, lower, slots - 1, slots, group.diagonal(slots - 1));
        group.back_substitute::<S, P>(header, kept, &mut out);
    }
}

/// Numbers of the parts of scratch of [`Row::solve_slots`]: what is gathered, the header and what is kept of slots side by side, which are read by
/// vectors `P` from any lane on; header, lower block and what is kept of each slot.
#[cfg(target_arch = "x86_64")]
fn parts_for_slots<S: Space, V: Vector, P: Vector>(slots: usize) -> [usize; 6] {
    let long = [
        Gathered::<S>::SIZE * V::LANES,
        Header::<S>::SIZE * V::LANES,
        Kept::<S>::SIZE * V::LANES + P::LANES,
    ];
    let short = [Header::<S>::SIZE, lower::<S>(), slots * Kept::<S>::SIZE].map(|vectors| vectors * P::LANES);
    [long[0], long[1], long[2], short[0], short[1], short[2]]
}

// Functions of their own, so that the stack holds the frame of one of them at a time.

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
fn avx512<T: Real, S: Space, const VISCOUS: bool>(row: Row<'_, '_, T>) {
    row.solve_groups::<S, T::Wide, VISCOUS>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<T: Real, S: Space, const VISCOUS: bool>(row: Row<'_, '_, T>) {
    row.solve_groups::<S, T::Medium, VISCOUS>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
fn avx512_slots<T: Real, S: Space, P: Vector<Elem = T>, const VISCOUS: bool>(row: Row<'_, '_, T>) {
    row.solve_slots::<S, T::Wide, P, VISCOUS>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2_slots<T: Real, S: Space, P: Vector<Elem = T>, const VISCOUS: bool>(row: Row<'_, '_, T>) {
    row.solve_slots::<S, T::Medium, P, VISCOUS>();
}

#[inline(never)]
fn baseline<T: Real, S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(row: Row<'_, '_, T>) {
    row.solve_groups::<S, V, VISCOUS>();
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
use unroll;

/// What is kept for slot `k`.
#[inline(always)]
fn slot<S: Space, V: Vector>(kept: &[V::Elem], k: usize) -> &[V::Elem] {
    &kept[k * Kept::<S>::SIZE * V::LANES..][..Kept::<S>::SIZE * V::LANES]
}

#[inline(always)]
fn slot_mut<S: Space, V: Vector>(kept: &mut [V::Elem], k: usize) -> &mut [V::Elem] {
    &mut kept[k * Kept::<S>::SIZE * V::LANES..][..Kept::<S>::SIZE * V::LANES]
}

/// A few cells of one row, one a lane.
struct Group<'s, 'a, T> {
    system: &'s System<'a, T>,
    row: usize,
    /// Where the first one is.
    x: usize,
    /// Which of its colour's cells in the row that is.
    first: usize,
    count: usize,
    /// Whether there is a wall below along y: then p is the face above, and the faces along y change places in the system.
    above_wall: bool,
    /// Whether lanes are in the order of the cells, or in that of [`Vector::load_pairs`].
    in_order: bool,
}

impl<T: Real> Group<'_, '_, T> {
    /// The header of the scratch, the same for every `each` lanes; 1 / 4h of an edge is 0 where it is on a wall.
    #[inline(always)]
    fn fill_header<S: Space, V: Vector<Elem = T>>(&self, each: usize, header: &mut [T]) {
        let (grid, lanes) = (self.system.grid, V::LANES);
        let [y, z] = grid.row_at(self.row);
        for l in 0..lanes {
            let cell = if self.in_order { l % each } else { V::PAIRED[l] };
            let at = [(self.x + 2 * cell.min(self.count - 1)), y, z];
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
                    let inverse = if free {
                        T::from_f64(0.25 / grid.h[axis])
                    } else {
                        T::ZERO
                    };
                    header[(Header::<S>::EDGES + 2 * e + i) * lanes + l] = inverse;
                }
            }
        }
    }
}
