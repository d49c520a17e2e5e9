//! The layout of a component in memory and in a file.

use super::InputError;
use crate::exec::Ranks;
use crate::field::rows;
use crate::grid::levels::Levels;
use crate::grid::{Grid, Side};
use crate::real::Real;
use core::ops::Range;

/// Elements of one component in a file: z, y, x with x fastest, of faces one more along their own axis unless that is a ring. Cells outside
/// open sides are in memory alone.
pub(crate) struct FileLayout<'g> {
    grid: &'g Grid,
    inside: [Range<usize>; 3],
    /// Elements of a row of the file, and rows of a plane.
    file: [usize; 2],
    /// The axis of faces; `None` of cells.
    axis: Option<usize>,
}

/// Elements that lie side by side in memory and in a file.
pub(crate) struct Run {
    /// The row in memory.
    pub row: usize,
    /// The first of them in that row.
    pub x: usize,
    /// The first of them in the file.
    pub file: usize,
    /// How many.
    pub count: usize,
}

impl<'g> FileLayout<'g> {
    /// That of the faces of an axis.
    pub fn new(grid: &'g Grid, axis: usize) -> Self {
        Self::of(grid, Some(axis))
    }

    /// That of a field of cells.
    pub fn of_cells(grid: &'g Grid) -> Self {
        Self::of(grid, None)
    }

    /// That of the faces of an axis, or of cells. Of a box that ranks share it is the rank's own part, plane after plane.
    pub fn of(grid: &'g Grid, axis: Option<usize>) -> Self {
        let mut inside = grid.inside();
        if let Some(parts) = grid.parts() {
            for (along, inside) in inside.iter_mut().enumerate().take(grid.dims) {
                if grid.part_along(along).is_some() {
                    let (first, own) = (grid.first(along), of_rank(grid, axis, (along, parts.share.rank)));
                    *inside = (own.start as isize - first) as usize..(own.end as isize - first) as usize;
                }
            }
        }
        let mut layout = Self {
            grid,
            inside,
            file: [0; 2],
            axis,
        };
        layout.file = [0, 1].map(|axis| layout.extent(axis));
        layout
    }

    /// The same where its elements stand among those of the whole box, of which they are the first.
    pub fn first_of_whole(self) -> Self {
        let whole = self.grid.whole();
        let file = FileLayout::of(&whole, self.axis).file;
        Self { file, ..self }
    }

    /// Whether these are faces across what a rank has some of: those on the high wall are nobody's.
    fn is_across(&self, axis: usize) -> bool {
        self.grid.part_along(axis).is_some()
    }

    /// Where a cell of the box is in a file; `None` outside the box.
    pub fn place(&self, at: [usize; 3]) -> Option<usize> {
        let mut here = [0; 3];
        for ((here, inside), at) in here.iter_mut().zip(&self.inside).zip(at) {
            *here = at.checked_sub(inside.start).filter(|at| *at < inside.len())?;
        }
        Some(self.in_file(here))
    }

    /// Where an element is in a file.
    fn in_file(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.file[1] + y) * self.file[0] + x
    }

    pub fn extent(&self, axis: usize) -> usize {
        let ends = self.axis == Some(axis) && !self.grid.axis(axis).is_ring() && !self.is_across(axis);
        self.inside[axis].len() + usize::from(ends)
    }

    pub fn len(&self) -> usize {
        (0..3).map(|axis| self.extent(axis)).product()
    }

    /// Positions in a file along an axis that are in memory: all but faces on walls.
    fn stored(&self, axis: usize) -> Range<usize> {
        let extent = self.extent(axis);
        if self.axis == Some(axis) && self.is_across(axis) {
            let first = self.grid.first(axis) + self.inside[axis].start as isize;
            return usize::from(first == 0 && !self.grid.whole_axis(axis).is_ring())..extent;
        }
        if extent == self.inside[axis].len() {
            return 0..extent;
        }
        let wall = |side: Side| 1 - self.grid.layers(axis, side);
        wall(Side::Low)..extent - wall(Side::High)
    }

    /// Everything but faces on walls, where nothing flows.
    pub fn runs(&self) -> impl Iterator<Item = Run> + use<'_> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.stored(axis));
        let rows = z.flat_map(move |z| y.clone().map(move |y| [y, z]));
        rows.map(move |[y, z]| Run {
            row: self.grid.row(self.inside[1].start + y, self.inside[2].start + z),
            x: self.inside[0].start + x.start,
            file: self.in_file([x.start, y, z]),
            count: x.len(),
        })
    }

    /// `out` in the layout of a file from time level `slot` of a trajectory of `slots`, times `unit`.
    pub fn read<T: Real>(&self, field: &[T], [slots, slot]: [usize; 2], unit: T, out: &mut [T]) {
        out.fill(T::ZERO);
        let n = self.grid.n[0];
        for Run { row, x, file, count } in self.runs() {
            let begin = (row * slots + slot) * n + x;
            let from = field.get(begin..begin + count).unwrap_or(&[]);
            let out = out.get_mut(file..file + count).unwrap_or(&mut []);
            out.iter_mut().zip(from).for_each(|(out, &x)| *out = x * unit);
        }
    }

    /// [`Self::write_slot`] of a component whose length and numbers are checked.
    pub fn take<T: Real>(
        &self,
        faces: &[T],
        unit: f64,
        field: &mut [T],
        slot: [usize; 2],
    ) -> Result<(), InputError> {
        finite(faces, self.len())?;
        self.write_slot(faces, T::from_f64(unit), field, slot);
        Ok(())
    }

    /// Adds `given`, whose length and numbers are checked, times `unit` to a field of one time level; what is given of walls counts for
    /// nothing.
    pub fn add<T: Real>(&self, given: &[T], unit: f64, field: &mut [T]) -> Result<(), InputError> {
        finite(given, self.len())?;
        let n = self.grid.n[0];
        for Run { row, x, file, count } in self.runs() {
            let from = given.get(file..file + count).unwrap_or(&[]);
            let to = field.get_mut(row * n + x..row * n + x + count).unwrap_or(&mut []);
            rows::add_scaled(to, T::from_f64(unit), from);
        }
        Ok(())
    }

    /// A field of one time level in memory from one in the layout of a file, times `unit`; 0 on walls and outside the box.
    pub fn write<T: Real>(&self, given: &[T], unit: T, field: &mut [T]) {
        self.write_slot(given, unit, field, [1, 0]);
    }

    /// [`Self::write`] to time level `slot` of a trajectory of `slots`.
    pub fn write_slot<T: Real>(&self, given: &[T], unit: T, field: &mut [T], [slots, slot]: [usize; 2]) {
        let n = self.grid.n[0];
        for row in field.chunks_exact_mut(slots * n) {
            row.iter_mut().skip(slot * n).take(n).for_each(|x| *x = T::ZERO);
        }
        for Run { row, x, file, count } in self.runs() {
            let from = given.get(file..file + count).unwrap_or(&[]);
            let begin = (row * slots + slot) * n + x;
            let to = field.get_mut(begin..begin + count).unwrap_or(&mut []);
            to.iter_mut().zip(from).for_each(|(to, &x)| *to = x * unit);
        }
    }
}

/// What a rank has along an axis of a whole box of what a file holds: of faces across that axis those of the layer behind an open high end too, since its
/// exits are their low faces.
pub(super) fn of_rank(grid: &Grid, faces: Option<usize>, (along, rank): (usize, usize)) -> Range<usize> {
    let own = grid.of_rank(along, rank);
    let inside = grid.whole_axis(along).inside();
    let exits = if faces == Some(along) {
        grid.layers(along, Side::High)
    } else {
        0
    };
    let here = |place: usize| place.clamp(inside.start, inside.end + exits);
    here(own.start)..here(own.end)
}

/// Refuses a density of another length, or that is not finite somewhere.
pub(crate) fn finite<T: Real>(density: &[T], cells: usize) -> Result<(), InputError> {
    if density.len() != cells {
        return Err(InputError::Length {
            expected: cells,
            given: density.len(),
        });
    }
    match density.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(InputError::NotFinite { index }),
        None => Ok(()),
    }
}

/// A field as it lies in memory, to be read without copying. Number (x, y, z) is `numbers[x + y strides[1] + z strides[2]]` times
/// `unit` in the scene's units. Of a component of a velocity or force it is the one on the low face of cell (x, y, z) along the
/// component's axis; the last faces along an axis that ends in a wall are not stored, since nothing flows there, but those on an open side are: one
/// more along that axis.
#[derive(Clone, Copy, Debug)]
pub struct Strided<'a, T> {
    /// The numbers from the first on.
    pub numbers: &'a [T],
    /// How many there are along each axis.
    pub extent: [usize; 3],
    /// Numbers from one to the next along each axis.
    pub strides: [usize; 3],
    /// The scene's unit.
    pub unit: f64,
}

impl<'a, T> Strided<'a, T> {
    /// Slot `slot` of a trajectory of `slots`, of faces along an axis or of cells.
    pub(crate) fn slot(
        grid: &Grid,
        field: &'a [T],
        [slots, slot]: [usize; 2],
        unit: f64,
        faces: Option<usize>,
    ) -> Self {
        let (n, inside) = (grid.n, grid.inside());
        let more = |axis: usize| {
            if faces == Some(axis) {
                grid.layers(axis, Side::High)
            } else {
                0
            }
        };
        let row = grid.row(inside[1].start, inside[2].start);
        Self {
            numbers: field
                .get((row * slots + slot) * n[0] + inside[0].start..)
                .unwrap_or(&[]),
            extent: core::array::from_fn(|axis| inside[axis].len() + more(axis)),
            strides: [1, slots * n[0], slots * n[0] * n[1]],
            unit,
        }
    }
}

/// Sets which cells are solid, by a flag that is not 0 for each inside the box, x fastest; where ranks share it, for each of the rank's own in all but the
/// first rank.
pub(crate) fn put_solids<T: Real, F: Copy + Default + PartialEq>(
    ranks: &dyn Ranks,
    levels: &mut Levels<'_, T>,
    solid: &[F],
) {
    let grid = levels.finest;
    let own = FileLayout::of_cells(&grid);
    let layout = if ranks.rank() == 0 {
        own.first_of_whole()
    } else {
        own
    };
    levels.set_solids(ranks, |cell| {
        let place = layout.place(grid.cell_at(cell / grid.n[0], cell % grid.n[0]));
        place
            .and_then(|place| solid.get(place))
            .is_some_and(|&solid| solid != F::default())
    });
}
