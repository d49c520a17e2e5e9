//! The cells of one row: the choice of vectors, and the way through the slots and back.

use super::gather::Gather;
use super::group::Group;
use super::line::Line;
use super::storage::{Changes, GROUPS, Gathered, Header, Stored, group_len, lower_len};
use crate::grid::{D2, D3, Space};
use crate::memory::{Pool, pooled};
use crate::nso::colours::Cells;
use crate::nso::level::System;
use crate::real::Real;
use crate::simd::{Vector, avx2, avx512, compiled_for, compiled_once};

/// Scratch for `lanes` cells side by side, in values.
#[must_use]
pub fn scratch_len<S: Space>(slots: usize, lanes: usize) -> usize {
    (Gathered::<S>::SIZE + group_len::<S>(slots)) * lanes
}

/// Solves the cells `start`, `start + 2`, .. of `row`, at most `lanes` of them at the same time, and writes
/// their changes.
pub fn solve_row<T: Real, S: Space>(
    system: &System<'_, T>,
    row: usize,
    cells: Cells,
    lanes: usize,
    scratch: &mut [T],
    out: Changes<'_, T>,
) {
    solve_once::<T, S>(Row {
        system,
        row,
        cells,
        lanes,
        scratch,
        out,
    });
}

compiled_once! {
    /// The longest function of the core.
    fn solve_once[T: Real, S: Space](row: Row<'_, '_, T>) for [f32, D2] [f32, D3] [f64, D2] [f64, D3] {
        if row.system.viscosity == T::ZERO {
            row.solve::<S, false>();
        } else {
            row.solve::<S, true>();
        }
    }
}

// Functions of their own, so that the stack holds the frame of one of them at a time.
compiled_for! {
    fn groups_by_avx512[T: Real, S: Space; VISCOUS](Avx512; row: Row<'_, '_, T>) {
        row.solve_groups::<S, T::Wide, VISCOUS>();
    }
    fn groups_by_avx2[T: Real, S: Space; VISCOUS](Avx2; row: Row<'_, '_, T>) {
        row.solve_groups::<S, T::Medium, VISCOUS>();
    }
    fn slots_by_avx512[T: Real, S: Space; VISCOUS](Avx512; row: Row<'_, '_, T>) {
        row.solve_slots::<S, T::Wide, T::Narrow, VISCOUS>();
    }
    fn slots_by_avx2[T: Real, S: Space; VISCOUS](Avx2; row: Row<'_, '_, T>) {
        row.solve_slots::<S, T::Medium, T::Narrow, VISCOUS>();
    }
}

#[inline(never)]
fn groups_by<T: Real, S: Space, V: Vector<Elem = T>, const VISCOUS: bool>(row: Row<'_, '_, T>) {
    row.solve_groups::<S, V, VISCOUS>();
}

/// The cells of one row that a thread solves, at most `lanes` at the same time.
struct Row<'r, 'a, T> {
    system: &'r System<'a, T>,
    row: usize,
    cells: Cells,
    lanes: usize,
    scratch: &'r mut [T],
    out: Changes<'r, T>,
}

impl<T: Real> Row<'_, '_, T> {
    /// By the longest vectors that the processor has and `lanes` allows. Where a row has at most as many
    /// cells as the shortest vectors have lanes, longer ones hold a few slots side by side.
    #[inline(always)]
    fn solve<S: Space, const VISCOUS: bool>(self) {
        let half = self.out.half;
        if let Some(avx512) = avx512().filter(|_| T::Wide::LANES <= self.lanes) {
            // Not in 3D: AVX2 is as fast there, and this frame would be too long for the C library's stack.
            if S::DIM == 2 && half <= T::Narrow::LANES && self.has_room_for_slots::<S, T::Wide, T::Narrow>() {
                return slots_by_avx512::<T, S, VISCOUS>(avx512, self);
            }
            if T::Medium::LANES < self.cells.count {
                return groups_by_avx512::<T, S, VISCOUS>(avx512, self);
            }
        }
        if let Some(avx2) = avx2().filter(|_| T::Medium::LANES <= self.lanes) {
            if half <= T::Narrow::LANES && self.has_room_for_slots::<S, T::Medium, T::Narrow>() {
                return slots_by_avx2::<T, S, VISCOUS>(avx2, self);
            }
            return groups_by_avx2::<T, S, VISCOUS>(avx2, self);
        }
        if T::Narrow::LANES <= self.lanes {
            groups_by::<T, S, T::Narrow, VISCOUS>(self);
        } else {
            groups_by::<T, S, T, VISCOUS>(self);
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
        let slots = system.slots;
        let most = (lanes / V::LANES).min(GROUPS);
        let above_wall = pivots_above(system, row);
        let (gathered, scratch) = scratch.split_at_mut(most * Gathered::<S>::SIZE * V::LANES);
        for start in (0..cells.count).step_by(most * V::LANES) {
            let part = Cells {
                start: cells.start + 2 * start,
                count: (most * V::LANES).min(cells.count - start),
            };
            let gathered = &mut gathered[..part.count.div_ceil(V::LANES) * Gathered::<S>::SIZE * V::LANES];
            let gather = Gather::new::<S>(system, row, part);
            gathered.fill(T::ZERO);
            let mut rest = scratch.chunks_exact_mut(group_len::<S>(slots) * V::LANES);
            let mut lines: [_; GROUPS] = core::array::from_fn(|index| {
                let first = start + index * V::LANES;
                if first >= cells.count {
                    return None;
                }
                let group = Group {
                    system,
                    row,
                    x: cells.start + 2 * first,
                    first,
                    count: V::LANES.min(cells.count - first),
                    above_wall,
                    in_order: false,
                };
                Some(Line::new::<S, V>(group, rest.next()?))
            });
            for k in 0..=slots {
                if k < slots {
                    gather.fill::<S, V>(k, gathered);
                    let gathered = gathered.chunks_exact(Gathered::<S>::SIZE * V::LANES);
                    for (line, gathered) in lines.iter_mut().flatten().zip(gathered) {
                        line.assemble::<S, V, VISCOUS>(gathered, k);
                    }
                }
                if k > 0 {
                    for line in lines.iter_mut().flatten() {
                        line.eliminate::<S, V>(k - 1);
                    }
                }
            }
            for line in lines.iter().flatten() {
                line.back_substitute::<S, V>(&mut out);
            }
        }
    }

    /// Whether scratch has room for [`Self::solve_slots`].
    fn has_room_for_slots<S: Space, V: Vector<Elem = T>, P: Vector<Elem = T>>(&self) -> bool {
        let parts = parts_for_slots::<S, V, P>(self.system.slots);
        P::LANES < V::LANES && parts.into_iter().map(pooled).sum::<usize>() <= self.scratch.len()
    }

    /// One group, of a row too short for vectors `V`: a few slots side by side are gathered and assembled,
    /// then cut up into vectors `P` of one slot each.
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
        let each = slot_lanes::<P>(system.grid.n[0]);
        let side_by_side = (V::LANES / each).max(1);
        let mut pool = Pool::new(scratch);
        let [gathered, long_header, long, header, lower, stored] =
            parts_for_slots::<S, V, P>(system.slots).map(|len| pool.take("lines", len));
        let group = Group {
            system,
            row,
            x: cells.start,
            first: 0,
            count: cells.count,
            above_wall: pivots_above(system, row),
            in_order: true,
        };
        group.fill_header::<S, V>(each, long_header);
        group.fill_header::<S, P>(P::LANES, header);
        let mut gather = Gather::new::<S>(system, row, cells);
        gather.add_before::<S>(system, row, cells);
        gathered.fill(T::ZERO);
        let mut line = Line {
            group,
            header,
            lower,
            stored,
        };
        for k in 0..system.slots {
            let place = k % side_by_side;
            if place == 0 {
                gather.fill_slots::<S, V, P>(k, each, gathered);
                line.assemble_side_by_side::<S, V, VISCOUS>(long_header, gathered, [k, each], long);
            }
            line.take_slot::<S, V, P>(k, long, place * each);
            if k > 0 {
                line.eliminate::<S, P>(k - 1);
            }
        }
        line.eliminate::<S, P>(system.slots - 1);
        line.back_substitute::<S, P>(&mut out);
    }
}

/// Whether p is the face above in this row: where there is a wall below. Among solids p is the face below everywhere, open or not.
fn pivots_above<T>(system: &System<'_, T>, row: usize) -> bool {
    !system.solids.there() && system.grid.wall_below(row, 1)
}

/// Values of the parts of scratch of [`Row::solve_slots`]: what is gathered, the header and what is stored of
/// slots side by side, of which vectors `P` are read from any lane on; header, lower block and what is stored
/// of each slot.
fn parts_for_slots<S: Space, V: Vector, P: Vector>(slots: usize) -> [usize; 6] {
    [
        Gathered::<S>::SIZE * V::LANES,
        Header::<S>::SIZE * V::LANES,
        Stored::<S>::SIZE * V::LANES + P::LANES,
        Header::<S>::SIZE * P::LANES,
        lower_len::<S>() * P::LANES,
        slots * Stored::<S>::SIZE * P::LANES,
    ]
}

/// Lanes of each slot where a few are side by side, in rows of `nx` cells: half as many where that divides
/// every vector, else those of `P`.
fn slot_lanes<P: Vector>(nx: usize) -> usize {
    if nx.is_multiple_of(2) && (nx / 2).is_power_of_two() {
        nx / 2
    } else {
        P::LANES
    }
}
