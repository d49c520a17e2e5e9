//! The rows that a face flux reads, along any axis.

use crate::field::{Vector, rows};
use crate::grid::{Grid, Side};
use crate::problem::Scheme;
use crate::real::Real;
use crate::simd::{self, vectorised};
use core::ops::Range;

/// Numbers of a row's neighbours along x: two on either side, of which faces have one less before.
pub const HALO: usize = 4;
/// Rows of scratch of a task.
pub const SCRATCH_ROWS: usize = 2;
/// Neighbours before a row.
pub const BEFORE: usize = HALO / 2;
/// Rows with neighbours are so many numbers apart, or a multiple: then each begins where a vector would.
const APART: usize = 16;
/// Where such a field begins in its buffer, for the first row to begin there too.
pub const OFFSET: usize = APART - BEFORE;

/// Numbers between the beginnings of rows of `n` that have their neighbours along x.
#[inline(always)]
pub const fn stride(n: usize) -> usize {
    (n + HALO).next_multiple_of(APART)
}

/// Numbers of a field whose rows have their neighbours along x.
#[must_use]
pub fn with_halo(grid: &Grid) -> usize {
    grid.rows() * stride(grid.n[0])
}

/// The row between its neighbours.
#[inline(always)]
pub fn inner<T>(row: &mut [T], n: usize) -> &mut [T] {
    &mut row[BEFORE..][..n]
}

/// Writes the neighbours of the cells of a row: at walls the last cell stands for those beyond.
#[inline(always)]
pub fn surround_cells<T: Real>(row: &mut [T], n: usize, periodic: bool) {
    if let Some([far_below, below, inner @ .., above, far_above]) = row.get_mut(..n + HALO) {
        let cell = |around: usize, at_wall: usize| {
            inner
                .get(if periodic { around } else { at_wall })
                .copied()
                .unwrap_or(T::ZERO)
        };
        (*far_below, *below) = (cell(n - 2, 0), cell(n - 1, 0));
        (*above, *far_above) = (cell(0, n - 1), cell(1, n - 1));
    }
}

/// Writes the neighbours of the faces along x of a row: beyond a wall the face on the low wall, which nothing goes through either.
#[inline(always)]
pub fn surround_faces<T: Real>(row: &mut [T], n: usize, periodic: bool) {
    let wrap = |x: T| if periodic { x } else { T::ZERO };
    (row[1], row[n + 2], row[n + 3]) = (wrap(row[n + 1]), wrap(row[2]), wrap(row[3]));
}

/// Velocity at faces, the component along x with neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Velocity<'a, T>(pub Vector<'a, T>);

impl<'a, T: Real> Velocity<'a, T> {
    /// The low faces of a row of cells.
    #[inline(always)]
    pub fn low(&self, n: usize, axis: usize, row: usize) -> &'a [T] {
        if axis == 0 {
            &self.0[0][row * stride(n) + BEFORE..][..n]
        } else {
            &self.0[axis][row * n..][..n]
        }
    }
}

/// A field of cells.
#[derive(Clone, Copy, Debug)]
pub enum Cells<'a, T> {
    /// As it is.
    Alone(&'a [T]),
    /// With the neighbours of its rows along x.
    WithHalo(&'a [T]),
}

impl<'a, T> Cells<'a, T> {
    /// What term `k` of a series is made from: `first` or the term before, where terms have their neighbours and are `stride` apart.
    pub fn before(k: usize, first: &'a [T], terms: &'a [T], stride: usize) -> Self {
        k.checked_sub(2)
            .map_or(Self::Alone(first), |k| Self::WithHalo(&terms[k * stride..]))
    }

    /// The numbers, how far rows of `n` are apart, and where they begin.
    #[inline(always)]
    fn layout(self, n: usize) -> (&'a [T], usize, usize) {
        match self {
            Self::Alone(numbers) => (numbers, n, 0),
            Self::WithHalo(numbers) => (numbers, stride(n), BEFORE),
        }
    }
}

/// Interpolation to a face from upstream, rho_f = w[0] downstream + w[1] upstream - w[2] next upstream (Leonard 1979).
#[must_use]
pub fn weights<T: Real>(scheme: Scheme) -> [T; 3] {
    match scheme {
        Scheme::Central => [0.5, 0.5, 0.0],
        _ => [0.375, 0.75, 0.125],
    }
    .map(T::from_f64)
}

/// Rows of a run and the rows around them, told by where they begin: slices on their way through memory would be waited for.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, T> {
    /// The rows with their neighbours along x, from the first on.
    own: &'a [T],
    /// How far they are apart.
    own_stride: usize,
    /// What holds the rows beside them along y and z.
    fields: [&'a [T]; 2],
    /// Where those beside the first begin.
    beside: [[usize; 4]; 2],
    /// How far they are apart.
    stride: usize,
}

impl<'a, T> Rows<'a, T> {
    /// The first `len` numbers of a row with its neighbours along x.
    #[inline(always)]
    pub fn own(&self, row: usize, len: usize) -> &'a [T] {
        let begin = row * self.own_stride;
        &self.own[begin..begin + len]
    }

    /// The `n` numbers of each of the rows beside a row along y or z.
    #[inline(always)]
    pub fn along(&self, axis: usize, row: usize, n: usize) -> [&'a [T]; 4] {
        let (field, [a, b, c, d], further) =
            (self.fields[axis - 1], self.beside[axis - 1], row * self.stride);
        let of = |begin: usize| &field[begin + further..begin + further + n];
        [of(a), of(b), of(c), of(d)]
    }
}

/// A row and those beside it along y and z.
#[derive(Clone, Copy, Debug)]
pub struct Around<'g> {
    grid: &'g Grid,
    /// The row.
    pub row: usize,
    /// Rows from this one on around which others lie in the same way.
    alike: usize,
    /// The rows of cells at offsets -2, -1, 1, 2; at a wall the last row stands for those beyond.
    cells: [[usize; 4]; 2],
    /// The rows of low faces at offsets -1, 0, 1, 2; beyond a wall those on the low wall, which nothing goes through either.
    faces: [[usize; 4]; 2],
    /// Whether there is a wall below and above.
    walls: [[bool; 2]; 2],
}

/// Cuts `rows` into runs around which others lie in the same way and which are all empty, as `empty` says of one that so many rows follow, or all not, and
/// calls `visit` with the first row of each, how many there are, and whether they are empty. Runs are of one row where that must be `alone`.
pub fn each_run(
    grid: &Grid,
    rows: Range<usize>,
    alone: bool,
    empty: impl Fn(&Around<'_>, usize) -> bool,
    mut visit: impl FnMut(&Around<'_>, usize, bool),
) {
    let mut row = rows.start;
    while row < rows.end {
        let around = Around::new(grid, row);
        let most = if alone {
            1
        } else {
            around.alike.min(rows.end - row)
        };
        let first = empty(&around, 0);
        let mut count = 1;
        while count < most && empty(&around, count) == first {
            count += 1;
        }
        visit(&around, count, first);
        row += count;
    }
}

impl<'g> Around<'g> {
    /// Those around `row`.
    #[inline(always)]
    pub fn new(grid: &'g Grid, row: usize) -> Self {
        let at = grid.row_at(row);
        let inside = |axis: usize| axis >= grid.dims || (2..grid.n[axis] - 2).contains(&at[axis - 1]);
        if !(inside(1) && inside(2)) {
            return Self::near_end(grid, row, at);
        }
        let strides = if grid.dims > 2 { [1, grid.n[1]] } else { [1, 0] };
        let cells = strides.map(|stride| [row - 2 * stride, row - stride, row + stride, row + 2 * stride]);
        let faces = strides.map(|stride| [row - stride, row, row + stride, row + 2 * stride]);
        Self {
            grid,
            row,
            alike: grid.n[1] - 2 - at[0],
            cells,
            faces,
            walls: [[false; 2]; 2],
        }
    }

    /// Those around `row`, which is at (y, z) and some of which may lie beyond an end of the box.
    #[cold]
    fn near_end(grid: &'g Grid, row: usize, at: [usize; 2]) -> Self {
        let mut around = Self {
            grid,
            row,
            alike: 1,
            cells: [[row; 4]; 2],
            faces: [[row; 4]; 2],
            walls: [[true; 2]; 2],
        };
        for axis in 1..grid.dims {
            let (n, stride, here) = (grid.n[axis], if axis == 1 { 1 } else { grid.n[1] }, at[axis - 1]);
            let first = row - here * stride;
            let place = |offset: isize| match here.wrapping_add_signed(offset) {
                to if to < n => Some(first + to * stride),
                _ if !grid.periodic[axis] => None,
                _ if offset < 0 => Some(first + (here + n).wrapping_add_signed(offset) * stride),
                to => Some(first + (to - n) * stride),
            };
            let [before, below, above, after] = [place(-2), place(-1), place(1), place(2)];
            let last = first + (n - 1) * stride;
            around.cells[axis - 1] = [
                before.unwrap_or(first),
                below.unwrap_or(first),
                above.unwrap_or(last),
                after.unwrap_or(last),
            ];
            around.faces[axis - 1] = [
                below.unwrap_or(first),
                row,
                above.unwrap_or(first),
                after.unwrap_or(first),
            ];
            around.walls[axis - 1] = [below.is_none(), above.is_none()];
        }
        around
    }

    /// Whether there is a wall on the low or the high side along y or z.
    #[inline]
    pub fn at_wall(&self, axis: usize, side: Side) -> bool {
        self.walls[axis - 1][usize::from(side == Side::High)]
    }

    /// Whether a field is 0 in the row `after` this one and in those beside it, so that no flux comes of it: by what `is_zero` says of their
    /// sizes, or by looking.
    #[inline]
    pub fn empty<T: Real>(
        &self,
        after: usize,
        sizes: Option<&[T]>,
        is_zero: impl Fn(T) -> bool,
        field: Cells<'_, T>,
    ) -> bool {
        let beside = 4 * (self.grid.dims - 1);
        if let Some(sizes) = sizes {
            let is_zero = |&row: &usize| sizes.get(row + after).is_some_and(|&size| is_zero(size));
            return is_zero(&self.row) && self.cells.as_flattened().iter().take(beside).all(is_zero);
        }
        let n = self.grid.n[0];
        let (numbers, stride, before) = field.layout(n);
        let begin = |row: usize| (row + after) * stride + before;
        let begins = self.cells.map(|rows| rows.map(begin));
        all_zero(numbers, &[begin(self.row)], n)
            && all_zero(
                numbers,
                begins.as_flattened().get(..beside).unwrap_or_default(),
                n,
            )
    }
}

vectorised! {
    /// Whether rows of `n` numbers are there and 0, of which it is told where they begin.
    fn all_zero[T, V](numbers: &[T], begins: &[usize], n: usize) -> bool {
        let (mut sum, mut rest, mut lanes) = (V::splat(T::ZERO), T::ZERO, [T::ZERO; 16]);
        for &begin in begins {
            let Some(row) = numbers.get(begin..begin + n) else { return false };
            let vectors = row.chunks_exact(V::LANES);
            for x in vectors.remainder() {
                rest += x.abs();
            }
            for x in vectors {
                let x = V::load(x);
                sum = sum + x.max(-x);
            }
        }
        sum.store(&mut lanes);
        for x in lanes {
            rest += x;
        }
        rest == T::ZERO
    }
}

/// The cells of `field` around a run: along x offsets -2 .. 2, which `halo` receives where the field has none, along y and z offsets
/// -2, -1, 1, 2.
#[inline(always)]
pub fn cells<'a, T: Real>(around: &Around<'_>, field: Cells<'a, T>, halo: &'a mut [T]) -> Rows<'a, T> {
    let n = around.grid.n[0];
    let (numbers, stride, before) = field.layout(n);
    let own = match field {
        Cells::Alone(_) => {
            inner(halo, n).copy_from_slice(&numbers[around.row * n..][..n]);
            surround_cells(halo, n, around.grid.periodic[0]);
            &halo[..n + HALO]
        }
        Cells::WithHalo(_) => &numbers[around.row * stride..],
    };
    Rows {
        own,
        own_stride: stride,
        fields: [numbers; 2],
        beside: begins(&around.cells, stride, before),
        stride,
    }
}

/// The faces -1, 0, 1, 2 around a run, face 0 the low and face 1 the high one of its cells.
#[inline(always)]
pub fn faces<'a, T: Real>(around: &Around<'_>, v: Velocity<'a, T>) -> Rows<'a, T> {
    let n = around.grid.n[0];
    let Velocity([x, y, z]) = v;
    Rows {
        own: &x[around.row * stride(n) + 1..],
        own_stride: stride(n),
        fields: [y, z],
        beside: begins(&around.faces, n, 0),
        stride: n,
    }
}

/// Where rows of a field begin.
#[inline(always)]
fn begins([y, z]: &[[usize; 4]; 2], stride: usize, before: usize) -> [[usize; 4]; 2] {
    let begin = |row: usize| row * stride + before;
    [
        [begin(y[0]), begin(y[1]), begin(y[2]), begin(y[3])],
        [begin(z[0]), begin(z[1]), begin(z[2]), begin(z[3])],
    ]
}

vectorised! {
    /// The largest Courant number of a row of `n` cells of a box of `dims` axes, the sum of `scales` |v_f| over a cell's faces, or NaN when any
    /// number is not finite.
    pub fn largest_courant[T, V](faces: &Rows<'_, T>, n: usize, dims: usize, scales: [T; 3]) -> f64 {
        let (mut most, mut rest) = ([V::splat(T::ZERO); 2], [T::ZERO; 2]);
        let i = courant_from::<T, V>(0, n, faces, dims, scales, &mut most);
        courant_from::<T, T>(i, n, faces, dims, scales, &mut rest);
        let mut lanes = [[T::ZERO; rows::LANES]; 2];
        most[0].store(&mut lanes[0]);
        most[1].store(&mut lanes[1]);
        lanes[0][0] = rest[0].max(lanes[0][0]);
        lanes[1][0] += rest[1];
        rows::largest_lane(lanes[0], lanes[1])
    }
}

/// The kernel of [`largest_courant`] from `i` as far as whole vectors go; where it ended. The second of `most` is NaN once a number was not
/// finite.
#[inline(always)]
fn courant_from<T: Real, V: simd::Vector<Elem = T>>(
    mut i: usize,
    n: usize,
    faces: &Rows<'_, T>,
    dims: usize,
    scales: [T; 3],
    most: &mut [V; 2],
) -> usize {
    let (x, y) = (faces.own(0, n + HALO - 1), faces.along(1, 0, n));
    let z = if dims > 2 { faces.along(2, 0, n) } else { y };
    while i + V::LANES <= n {
        let mut sum = V::splat(T::ZERO);
        for side in 1..3 {
            let v = V::load(&x[i + side..]);
            sum = sum + V::splat(scales[0]) * v.max(-v);
        }
        for side in 1..3 {
            let v = V::load(&y[side][i..]);
            sum = sum + V::splat(scales[1]) * v.max(-v);
        }
        if dims > 2 {
            for side in 1..3 {
                let v = V::load(&z[side][i..]);
                sum = sum + V::splat(scales[2]) * v.max(-v);
            }
        }
        most[0] = sum.max(most[0]);
        most[1] = most[1] + sum * V::splat(T::ZERO);
        i += V::LANES;
    }
    i
}
