//! The padded fields: cells 1 .. n along each axis and a layer of ghosts around them, what ghosts hold, and the adjoint of that.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::grid::{Boundary, Grid};
use crate::real::Real;
use core::ops::Range;

/// A box of cells, of all of which every field has values at the centres.
#[derive(Clone, Copy, Debug)]
pub struct Cells {
    /// 2 or 3.
    pub dims: usize,
    /// Cells along x, y, z; 1 along z in 2D.
    pub n: [usize; 3],
    /// Whether an axis is periodic.
    pub ring: [bool; 3],
    /// How far apart neighbours along each axis lie in a padded field; 0 along z in 2D.
    pub stride: [usize; 3],
    /// Numbers of a padded field.
    pub padded: usize,
    /// M, cells along the longest axis.
    pub longest: usize,
}

/// What the sign of a ghost depends on: nothing for a scalar, the axis for a component of the velocity.
pub type Component = Option<usize>;

/// Ghosts that are told by the same formula.
struct Patch {
    /// The first of them.
    first: usize,
    /// How many there are along each axis.
    count: [usize; 3],
    /// Where each is from, and the factor: three at most.
    from: [(isize, f64); 3],
    sources: usize,
}

impl Cells {
    /// Those of a problem.
    #[must_use]
    pub fn new(cells: &[usize], boundary: &[Boundary]) -> Self {
        let n: [usize; 3] = core::array::from_fn(|axis| cells.get(axis).copied().unwrap_or(1));
        let dims = cells.len();
        let (row, plane) = (n[0] + 2, (n[0] + 2) * (n[1] + 2));
        Self {
            dims,
            n,
            ring: core::array::from_fn(|axis| boundary.get(axis) == Some(&Boundary::Periodic)),
            stride: [1, row, if dims == 3 { plane } else { 0 }],
            padded: plane * if dims == 3 { n[2] + 2 } else { 1 },
            longest: n.into_iter().max().unwrap_or(1),
        }
    }

    /// The number of cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.n.iter().product()
    }

    /// The same cells without ghosts, as a grid of rows.
    #[must_use]
    pub fn grid(&self) -> Grid {
        let ends = self
            .ring
            .map(|ring| if ring { Boundary::Periodic } else { Boundary::Wall });
        let (n, dims) = (&self.n, self.dims);
        Grid::new(n.get(..dims).unwrap_or(n), ends.get(..dims).unwrap_or(&ends))
    }

    /// The number of rows along x.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.n[1] * self.n[2]
    }

    /// The number of padded rows.
    #[must_use]
    pub fn padded_rows(&self) -> usize {
        self.padded / self.stride[1].max(1)
    }

    /// Where the cells of row `row` without ghosts are in a padded field.
    #[must_use]
    pub fn row(&self, row: usize) -> Range<usize> {
        let [y, z] = self.row_at(row);
        let first = 1
            + (y + 1) * self.stride[1]
            + if self.dims == 3 {
                (z + 1) * self.stride[2]
            } else {
                0
            };
        first..first + self.n[0]
    }

    /// The (y, z) of row `row`, from 0.
    #[must_use]
    pub fn row_at(&self, row: usize) -> [usize; 2] {
        let n = self.n[1].max(1);
        [row % n, row / n]
    }

    /// The row without ghosts that is the inside of padded row `padded`, if that is no row of ghosts.
    #[must_use]
    pub fn inner(&self, padded: usize) -> Option<usize> {
        let rows = self.n[1] + 2;
        let y = (padded % rows).checked_sub(1).filter(|&y| y < self.n[1])?;
        if self.dims == 2 {
            return Some(y);
        }
        let z = (padded / rows).checked_sub(1).filter(|&z| z < self.n[2])?;
        Some(z * self.n[1] + y)
    }

    /// Calls `visit` for every patch of ghosts: those outside along one axis, then those outside along two, then along three; the other way
    /// round if `backwards`.
    fn ghosts(&self, component: Component, backwards: bool, mut visit: impl FnMut(&Patch)) {
        let kinds = if self.dims == 3 { 27 } else { 9 };
        for turn in 1..=self.dims {
            let order = if backwards { self.dims + 1 - turn } else { turn };
            for kind in 0..kinds {
                // 0: before the first cell, 1: inside, 2: behind the last.
                let at = [kind % 3, kind / 3 % 3, if self.dims == 3 { kind / 9 } else { 1 }];
                if at.iter().filter(|&&at| at != 1).count() == order {
                    visit(&self.patch(component, at, order));
                }
            }
        }
    }

    fn patch(&self, component: Component, at: [usize; 3], order: usize) -> Patch {
        let mut patch = Patch {
            first: 0,
            count: [1; 3],
            from: [(0, 0.0); 3],
            sources: 0,
        };
        let mut image = None;
        for axis in 0..self.dims {
            let (stride, n) = (self.stride[axis], self.n[axis]);
            match at[axis] {
                1 => {
                    patch.first += stride;
                    patch.count[axis] = n;
                    continue;
                }
                2 => patch.first += (n + 1) * stride,
                _ => {}
            }
            let inwards = if at[axis] == 0 {
                stride as isize
            } else {
                -(stride as isize)
            };
            if self.ring[axis] && image.is_none() {
                image = Some(n as isize * inwards);
            }
            let sign = if order == 1 && component == Some(axis) {
                -1.0
            } else {
                1.0
            };
            if let Some(source) = patch.from.get_mut(patch.sources) {
                *source = (inwards, sign / order as f64);
            }
            patch.sources += 1;
        }
        if let Some(offset) = image {
            (patch.from, patch.sources) = ([(offset, 1.0); 3], 1);
        }
        patch
    }

    /// The places of a patch.
    fn places(&self, patch: &Patch) -> impl Iterator<Item = usize> + use<> {
        let ([x, y, z], stride, first) = (patch.count, self.stride, patch.first);
        (0..z).flat_map(move |k| {
            (0..y).flat_map(move |j| (0..x).map(move |i| first + i + j * stride[1] + k * stride[2]))
        })
    }

    /// Fills the ghosts of `x`.
    pub fn set_bnd<T: Real>(&self, component: Component, x: &mut [T]) {
        self.ghosts(component, false, |patch| {
            let from = patch.from.map(|(offset, factor)| (offset, T::from_f64(factor)));
            let from = from.get(..patch.sources).unwrap_or_default();
            for place in self.places(patch) {
                let value = from.iter().fold(T::ZERO, |sum, &(offset, factor)| {
                    sum + factor * at(x, place, offset)
                });
                if let Some(ghost) = x.get_mut(place) {
                    *ghost = value;
                }
            }
        });
    }

    /// The adjoint of [`Self::set_bnd`]: what ghosts hold goes to where they are from, and they become 0.
    pub fn set_bnd_adjoint<T: Real>(&self, component: Component, x: &mut [T]) {
        self.ghosts(component, true, |patch| {
            for place in self.places(patch) {
                let Some(held) = x.get_mut(place).map(|ghost| core::mem::replace(ghost, T::ZERO)) else {
                    continue;
                };
                for &(offset, factor) in patch.from.iter().take(patch.sources) {
                    if let Some(source) = x.get_mut(place.wrapping_add_signed(offset)) {
                        *source += T::from_f64(factor) * held;
                    }
                }
            }
        });
    }

    /// Calls `visit` for each ghost before and behind the cells of an axis, with the place of the ghost, of the cell beside it and whether it
    /// is behind the last.
    pub fn faces(&self, axis: usize, mut visit: impl FnMut(usize, usize, bool)) {
        for behind in [false, true] {
            let mut at = [1; 3];
            at[axis] = if behind { 2 } else { 0 };
            let patch = self.patch(None, at, 1);
            let stride = self.stride[axis];
            for place in self.places(&patch) {
                let beside = if behind { place - stride } else { place + stride };
                visit(place, beside, behind);
            }
        }
    }

    /// Calls `task` for every row of cells with the row of each of `fields`, without its ghosts, and the row's number.
    pub fn for_rows<T: Real, const K: usize>(
        &self,
        exec: &dyn Exec,
        fields: [&mut [T]; K],
        task: impl Fn(usize, [&mut [T]; K]) + Sync,
    ) {
        let fields = fields.map(|field| field.get_mut(..self.padded).unwrap_or_default());
        for_rows(exec, self.padded_rows(), RowBuffers::fields(fields), |padded| {
            if let Some(row) = self.inner(padded.row) {
                let end = self.n[0] + 1;
                task(
                    row,
                    padded
                        .fields
                        .map(|field| field.get_mut(1..end).unwrap_or_default()),
                );
            }
        });
    }

    /// The rows beside the one at `cells` of a padded field: before and behind it along `axis`.
    #[must_use]
    pub fn beside<'f, T>(&self, field: &'f [T], cells: &Range<usize>, axis: usize) -> [&'f [T]; 2] {
        let stride = self.stride[axis];
        [
            field
                .get(cells.start - stride..cells.end - stride)
                .unwrap_or_default(),
            field
                .get(cells.start + stride..cells.end + stride)
                .unwrap_or_default(),
        ]
    }
}

fn at<T: Real>(x: &[T], place: usize, offset: isize) -> T {
    x.get(place.wrapping_add_signed(offset))
        .copied()
        .unwrap_or(T::ZERO)
}
