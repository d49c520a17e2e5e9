//! The metric of the objective (paper eq. 5, mathematics section 4): C e = identity e + sum over j of G_j (G_j e).
//!
//! G_j is a separable Gaussian of sigma = 2^(j-1) cells, its taps cut at ceil(3 sigma) and normalised, mirrored at walls
//! (half-sample) and wrapped around rings. It is symmetric, so C is its own adjoint. Such a Gaussian has the eigenvectors of the
//! Poisson problem (Strang 1999, The Discrete Cosine Transform), so the sum over j is one multiplication of coefficients. Among
//! solid cells every tap is added: with F leaving them out, C = identity F + sum over j of F G_j F G_j F.

use crate::exec::{Exec, RowBuffers, Serial, for_rows};
use crate::field::transform::multiplied;
use crate::field::turned::Turned;
use crate::field::{rows, transform};
use crate::grid::gaussian::Gaussian;
use crate::grid::levels::Levels;
use crate::grid::solids::Solids;
use crate::grid::spectrum::Spectrum;
use crate::grid::{Boundary, Grid};
use crate::memory::{Pool, pooled};
use crate::real::Real;
use core::ops::Range;

/// What a metric is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// Filters m.
    pub filters: usize,
    /// Weight of e itself: 1 in the objective.
    pub identity: f64,
}

/// A metric on a grid, with its workspace.
#[derive(Debug)]
pub struct Blur<'a, T> {
    grid: &'a Grid,
    metric: Metric,
    /// Solid cells, which have no part in it.
    solids: Solids<'a>,
    /// The grid's eigenvectors, if there are no solid cells.
    spectrum: Option<Spectrum<'a, T>>,
    /// Two fields of cells if there are.
    work: [&'a mut [T]; 2],
    /// Where ranks share the box.
    turned: Turned<'a, T>,
    scratch: &'a mut [T],
}

impl<'a, T: Real> Blur<'a, T> {
    fn scratch_len(grid: &Grid, solids: Solids<'_>, filters: usize, threads: usize) -> usize {
        if !solids.there() {
            return pooled(transform::scratch_len(grid));
        }
        pooled(along_len(grid, widest(filters), threads))
    }

    fn work_len(grid: &Grid, solids: Solids<'_>) -> usize {
        if solids.there() { grid.cells() } else { 0 }
    }

    /// Takes its workspace from a pool. The grid is number `level` of the hierarchy.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        level: usize,
        metric: Metric,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let (grid, solids) = (&hierarchy.grids[level], hierarchy.solids(level));
        pool.line("blurs: panels, or fields and rows", |pool| Self {
            grid,
            metric,
            solids,
            spectrum: (!solids.there()).then(|| hierarchy.spectrum(level)),
            work: [(); 2].map(|()| pool.take("field", Self::work_len(grid, solids))),
            // Among solid cells a Gaussian goes from columns to other ones.
            turned: if solids.there() {
                Turned::carve_along(grid, pool)
            } else {
                Turned::carve(grid, 1, pool)
            },
            scratch: pool.take("rows", Self::scratch_len(grid, solids, metric.filters, threads)),
        })
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &'a Grid {
        self.grid
    }

    /// `out = C e`, fields of cells.
    pub fn apply(&mut self, exec: &dyn Exec, e: &[T], out: &mut [T]) {
        let Self {
            grid,
            metric: Metric { filters, identity },
            solids,
            spectrum,
            work,
            turned,
            scratch,
        } = self;
        let identity = T::from_f64(*identity);
        match spectrum {
            _ if *filters == 0 => {
                rows::scale(out, identity, e);
                solids.clear_cells(grid.n[0], out);
            }
            Some(spectrum) => {
                out.copy_from_slice(e);
                let whole = grid.whole();
                let symbol = squares(&whole, spectrum, *filters);
                let rows = multiplied(spectrum, symbol);
                if grid.is_part() {
                    turned.across((exec, &Serial), (grid, spectrum), out, scratch, rows);
                } else {
                    transform::across(&Serial, (grid, spectrum), out, scratch, rows);
                }
                rows::add_scaled(out, identity, e);
            }
            None => {
                rows::scale(out, identity, e);
                solids.clear_cells(grid.n[0], out);
                let work = work.each_mut().map(|field| &mut **field);
                add_by_rows(exec, (grid, *solids), *filters, e, out, work, (turned, scratch));
            }
        }
    }
}

/// `out +=` the sum over j of G_j G_j e, along one axis after the other; solid cells have no part in it. `scratch` is that of
/// [`along`]; where ranks share the box, they turn it in `turned`.
pub fn add_by_rows<T: Real>(
    exec: &dyn Exec,
    (grid, solids): (&Grid, Solids<'_>),
    filters: usize,
    e: &[T],
    out: &mut [T],
    [mut blurred, mut next]: [&mut [T]; 2],
    (turned, scratch): (&mut Turned<'_, T>, &mut [T]),
) {
    for j in 1..=filters {
        let gaussian = Gaussian::new(j);
        blurred.copy_from_slice(e);
        for _ in 0..2 {
            solids.clear_cells(grid.n[0], blurred);
            for axis in 0..grid.dims {
                if grid.part_along(axis).is_some() {
                    turned.along(exec, (grid, axis), blurred, next, |columns, blurred, next| {
                        if let Some(grid) = across((grid, axis), columns) {
                            along(exec, (&grid, 1), gaussian, blurred, next, scratch);
                        }
                    });
                } else {
                    along(exec, (grid, axis), gaussian, blurred, next, scratch);
                }
                core::mem::swap(&mut blurred, &mut next);
            }
        }
        solids.clear_cells(grid.n[0], blurred);
        rows::add(out, blurred);
    }
}

/// Some columns of a box along an axis, side by side; `None` where there are none.
fn across((grid, axis): (&Grid, usize), columns: usize) -> Option<Grid> {
    let line = grid.whole_axis(axis);
    let ends = [Boundary::Wall, line.ends()];
    (columns > 0).then(|| Grid::new(&[columns, line.inside().len()], &ends))
}

/// Taps on one side of the widest of some Gaussians.
#[must_use]
pub fn widest(filters: usize) -> usize {
    if filters == 0 {
        0
    } else {
        Gaussian::new(filters).radius
    }
}

/// The sum over j of G_j G_j: coefficients times the sum over j of a product of one factor an axis.
fn squares<T: Real>(
    grid: &Grid,
    spectrum: &Spectrum<'_, T>,
    filters: usize,
) -> impl Fn(usize, Range<usize>, &[T], &mut [T]) + Sync {
    move |row, span, coefficients, out| {
        let at = grid.row_at(row);
        out.fill(T::ZERO);
        for j in 1..=filters {
            let across = (1..grid.dims).fold(T::ONE, |product, axis| {
                product * spectrum.axes[axis].blur(j)[at[axis - 1]]
            });
            rows::add_scaled(out, across, &spectrum.axes[0].blur(j)[span.clone()]);
        }
        rows::multiply(out, coefficients);
    }
}

/// The scratch of [`along`] for Gaussians of at most so many taps on one side, in elements.
#[must_use]
pub fn along_len(grid: &Grid, radius: usize, threads: usize) -> usize {
    threads * (grid.n[0] + 3 * radius + 1)
}

/// A Gaussian along one axis of a field of cells. `scratch` holds [`along_len`] elements: its taps, and for every thread a row with as
/// many values around it as the Gaussian reaches.
pub fn along<T: Real>(
    exec: &dyn Exec,
    (grid, axis): (&Grid, usize),
    gaussian: Gaussian,
    from: &[T],
    to: &mut [T],
    scratch: &mut [T],
) {
    let n = grid.n[0];
    let radius = gaussian.radius as isize;
    let (taps, scratch) = scratch.split_at_mut(gaussian.radius + 1);
    for (slot, (_, tap)) in taps.iter_mut().zip(gaussian.taps()) {
        *slot = T::from_f64(tap);
    }
    let tap = |offset: isize| taps[offset.unsigned_abs()];
    let row = |row: usize| &from[row * n..(row + 1) * n];
    let buffers = RowBuffers::fields([to]).with_scratch(scratch);
    for_rows(exec, grid.rows(), buffers, |task| {
        let [out] = task.fields;
        out.fill(T::ZERO);
        if axis == 0 {
            let here = row(task.row);
            for (at, value) in (-radius..n as isize + radius).zip(task.scratch.iter_mut()) {
                *value = here[grid.axis(0).mirrored(at)];
            }
            for offset in -radius..=radius {
                rows::add_scaled(out, tap(offset), &task.scratch[(offset + radius) as usize..][..n]);
            }
        } else {
            let at = grid.row_at(task.row);
            for offset in -radius..=radius {
                let mut source = at;
                source[axis - 1] = grid.axis(axis).mirrored(at[axis - 1] as isize + offset);
                rows::add_scaled(out, tap(offset), row(grid.row(source[0], source[1])));
            }
        }
    });
}
