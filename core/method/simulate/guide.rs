//! Guidance of a simulation by a given flow (Gregson 2015, Algorithm 8; mathematics section 11).
//!
//! After each implicit step, which gives u~, the flow becomes u~ + Delta with
//!
//! ```text
//! Delta = argmin 1/2 |B (R - u~ - Delta)|^2 + alpha/2 <Delta, L Delta> + beta/2 |Delta|^2    over div Delta = 0
//! ```
//!
//! R is the given flow at that step, B a Gaussian of `radius` cells, L = -Laplacian, in cells. So the large motion is that of R, and what is
//! smaller than the radius is the simulation's own; [noise](super::stir) can stir it. In a box without solid cells B, L and the projection Q have the same eigenvectors:
//! Delta = Q F (R - u~), F = B^2 / (B^2 + alpha L + beta). Among solid cells Q has others, and ADMM finds Delta:
//!
//! ```text
//! x <- (lambda (B^2 + alpha L + beta) + 1)^-1 (lambda B^2 (R - u~) + z - y)        z <- Q (x + y)        y <- y + x - z
//! ```
//!
//! Along its own axis between walls a component w has sines for eigenvectors. They are the differences of the cosines of cells:
//! F w = -grad (F / lambda) div w along that axis alone, lambda its eigenvalue of L there, so that the transforms of cells serve.

use super::stir::{Noise, Stir};
use crate::checkpoint::Mix;
use crate::exec::{Exec, RowBuffers, Serial, for_rows};
use crate::field::{VectorMut, reborrow, rows, transform, view};
use crate::grid::gaussian::{ANGLES, Gaussian};
use crate::grid::levels::Levels;
use crate::grid::spectrum::Spectrum;
use crate::grid::{Grid, Side};
use crate::memory::{Pool, Sharing};
use crate::method::choices::{Kind, Numbers, choices};
use crate::real::Real;
use crate::words::{Named, named};
use core::ops::Range;

/// How the correction of a step is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GuideSolver {
    /// In closed form, among solid cells by ADMM.
    #[default]
    Auto,
    /// In closed form, with the box's own eigenvectors even where there are solid cells: there it is rough.
    ClosedForm,
    /// By ADMM, which among solid cells is the way to the minimum.
    Admm,
}

named!(GuideSolver { Auto = "auto", ClosedForm = "closed_form", Admm = "admm" });

/// What a caller chooses for guidance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuideParams {
    /// Standard deviation of the Gaussian B, in cells.
    pub radius: f64,
    /// alpha: how smooth the correction is.
    pub smoothness: f64,
    /// beta: how dear its kinetic energy is.
    pub kinetic: f64,
    /// lambda of ADMM.
    pub penalty: f64,
    /// Iterations of ADMM for each step.
    pub iterations: usize,
    /// How the correction is found.
    pub solver: GuideSolver,
    /// What stirs the flow before it is guided.
    pub noise: Noise,
}

impl Default for GuideParams {
    fn default() -> Self {
        Self {
            radius: 2.0,
            smoothness: 1e-3,
            kinetic: 0.0,
            penalty: 1e3,
            iterations: 5,
            solver: GuideSolver::Auto,
            noise: Noise::default(),
        }
    }
}

choices!(GuideParams, "guide" {
    radius: radius, Kind::Number(Numbers::Within(64.0)),
        "what is larger than so many cells follows the given flow";
    smoothness: smoothness, Kind::Number(Numbers::NotNegative),
        "how smooth the correction of a step is; 0 where it has a price of its kinetic energy";
    kinetic: kinetic, Kind::Number(Numbers::NotNegative),
        "how dear the kinetic energy of the correction is";
    penalty: penalty, Kind::Number(Numbers::Positive),
        "of ADMM, which is used among obstacles";
    iterations: iterations, Kind::Count(1000),
        "of ADMM, for each step";
    solver: solver, Kind::Word(GuideSolver::WORDS),
        "how the correction is found; auto takes ADMM among obstacles";
    curl_noise: noise.strength, Kind::Number(Numbers::NotNegative),
        "noise without divergence that stirs each step, in cells a step; 0: none";
    noise_sigma: noise.sigma, Kind::Number(Numbers::Within(64.0)),
        "how wide the noise is blurred, in cells";
    noise_seed: noise.seed, Kind::Count(u32::MAX as usize),
        "which noise";
});

impl GuideParams {
    /// Mixes every number into the fingerprint of a checkpoint.
    pub fn mix(&self, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let Self {
            radius,
            smoothness,
            kinetic,
            penalty,
            iterations,
            solver,
            noise:
                Noise {
                    strength,
                    sigma,
                    seed,
                },
        } = *self;
        [radius, smoothness, kinetic, penalty, strength, sigma]
            .into_iter()
            .for_each(|number| mix.real(number));
        [iterations as u64, solver as u64, seed as u64]
            .into_iter()
            .for_each(|word| mix.word(word));
    }
}

/// What a coefficient is multiplied by; b is the eigenvalue of B^2, c that of B^2 + alpha L + beta.
#[derive(Clone, Copy, Debug)]
pub(super) enum Factor {
    /// b / c.
    Closed,
    /// lambda b / (lambda c + 1).
    Given,
    /// 1 / (lambda c + 1).
    Kept,
}

/// The workspace of guidance, beside that of the step.
pub struct Guide<'a, T> {
    grid: &'a Grid,
    spectrum: Spectrum<'a, T>,
    pub(super) params: GuideParams,
    /// Whether the correction has a closed form.
    pub(super) closed: bool,
    /// The eigenvalues of B along every axis, in the order of the eigenvectors.
    blurs: [&'a mut [T]; 3],
    /// A field of cells for each component.
    cells: &'a mut [T],
    scratch: &'a mut [T],
    /// What stirs the flow, if anything does.
    pub(super) stir: Option<Stir<'a, T>>,
}

impl<'a, T: Real> Guide<'a, T> {
    /// Takes its workspace from a pool, for the finest grid.
    pub fn carve(
        levels: &'a Levels<'_, T>,
        params: GuideParams,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let grid = &levels.finest;
        let obstacles = levels.solids(0).obstacles();
        pool.group("guidance", Sharing::Together, |pool| {
            let mut guide = Self {
                grid,
                spectrum: levels.spectrum(0),
                params,
                closed: match params.solver {
                    GuideSolver::Auto => !obstacles,
                    GuideSolver::ClosedForm => true,
                    GuideSolver::Admm => false,
                },
                blurs: core::array::from_fn(|axis| {
                    let count = if axis < grid.dims { grid.n[axis] } else { 0 };
                    pool.take("eigenvalues of the Gaussian", count)
                }),
                cells: pool.take("components as cells", grid.dims * grid.cells()),
                scratch: pool.take("rows and panels", threads * transform::scratch_len(grid)),
                stir: Stir::carve(grid, params.noise, threads, pool),
            };
            guide.fill_blurs();
            guide
        })
    }

    /// The eigenvalues of B along every axis, from those of L: 4 sin^2(angle / 2) / h^2.
    fn fill_blurs(&mut self) {
        let gaussian = Gaussian::of(self.params.radius);
        for (axis, blur) in self.blurs.iter_mut().enumerate().take(self.grid.dims) {
            let h = self.grid.h[axis];
            let known = self.spectrum.axes[axis].eigenvalues.chunks(ANGLES);
            for (out, eigenvalues) in blur.chunks_mut(ANGLES).zip(known) {
                let mut angles = [0.0; ANGLES];
                for (angle, eigenvalue) in angles.iter_mut().zip(eigenvalues) {
                    let half = 0.5 * h * libm::sqrt(eigenvalue.to_f64().max(0.0));
                    *angle = 2.0 * libm::asin(half.min(1.0));
                }
                for (out, response) in out.iter_mut().zip(gaussian.responses(&angles)) {
                    *out = T::from_f64(response);
                }
            }
        }
    }

    /// Multiplies the coefficients of every component of `field` by a factor.
    pub(super) fn filter(&mut self, exec: &dyn Exec, factor: Factor, field: &mut VectorMut<'_, T>) {
        let Self {
            grid,
            spectrum,
            params,
            blurs,
            cells,
            scratch,
            ..
        } = self;
        let (grid, blurs) = (*grid, &*blurs);
        let given = view(field);
        let buffers = RowBuffers::fields([&mut **cells]).with_scratch(scratch);
        for_rows(exec, grid.dims, buffers, |task| {
            let ([cells], axis) = (task.fields, task.row);
            differences(grid, axis, given[axis], cells);
            let filtered = transform::multiplied(
                spectrum,
                |row: usize, span: Range<usize>, found: &[T], out: &mut [T]| {
                    let at = grid.row_at(row);
                    let squared = |axis: usize| grid.h[axis] * grid.h[axis];
                    let eigenvalue = |axis: usize, k: usize| {
                        let known = spectrum.axes[axis].eigenvalues.get(k);
                        known.map_or(0.0, |known| known.to_f64() * squared(axis))
                    };
                    let blur = |axis: usize, k: usize| blurs[axis].get(k).map_or(0.0, |blur| blur.to_f64());
                    let (across, of_across) = (1..grid.dims).fold((0.0, 1.0), |(sum, product), axis| {
                        let k = at[axis - 1];
                        (sum + eigenvalue(axis, k), product * blur(axis, k))
                    });
                    for ((out, &found), k) in out.iter_mut().zip(found).zip(span) {
                        let (along, b) = (eigenvalue(0, k), of_across * blur(0, k));
                        let own = if axis == 0 {
                            along
                        } else {
                            eigenvalue(axis, at[axis - 1])
                        };
                        let scale = match grid.axis(axis).is_ring() {
                            true => 1.0,
                            false if own > 0.0 => 1.0 / own,
                            false => 0.0,
                        };
                        *out = found * T::from_f64(scale * factor.of(*params, b * b, along + across));
                    }
                },
            );
            transform::across(&Serial, (grid, spectrum), cells, task.scratch, filtered);
        });
        let (cells, all) = (&**cells, grid.cells());
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(field)), |task| {
            for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                let cells = rows::part(cells, axis * all..(axis + 1) * all);
                undo_differences(grid, axis, task.row, cells, out);
            }
        });
    }
}

impl Factor {
    /// The factor where B^2 has the eigenvalue `b` and L has `l`.
    fn of(self, params: GuideParams, b: f64, l: f64) -> f64 {
        let c = b + params.smoothness * l + params.kinetic;
        match self {
            Self::Closed => b / c,
            Self::Given => params.penalty * b / (params.penalty * c + 1.0),
            Self::Kept => 1.0 / (params.penalty * c + 1.0),
        }
    }
}

/// `cells` = the differences along `axis` of the faces `w` of that axis between walls; on a ring w itself.
fn differences<T: Real>(grid: &Grid, axis: usize, w: &[T], cells: &mut [T]) {
    cells.copy_from_slice(w);
    if grid.axis(axis).is_ring() {
        return;
    }
    let n = grid.n[0];
    for (row, cells) in cells.chunks_exact_mut(n).enumerate() {
        let here = rows::part(w, row * n..(row + 1) * n);
        rows::scale_in_place(cells, -T::ONE);
        if axis == 0 {
            let next = here.get(1..).unwrap_or(&[]);
            cells.iter_mut().zip(next).for_each(|(cell, &next)| *cell += next);
        } else if let Some(above) = grid.neighbour(row, axis, Side::High) {
            rows::add(cells, rows::part(w, above * n..(above + 1) * n));
        }
    }
}

/// Row `row` of the faces of `axis` between walls: minus the differences of `cells` along it, 0 on walls; on a ring the cells themselves.
fn undo_differences<T: Real>(grid: &Grid, axis: usize, row: usize, cells: &[T], out: &mut [T]) {
    let n = grid.n[0];
    let here = rows::part(cells, row * n..(row + 1) * n);
    if grid.axis(axis).is_ring() {
        return out.copy_from_slice(here);
    }
    if axis == 0 {
        out.fill(T::ZERO);
        let inner = out.get_mut(1..).unwrap_or(&mut []);
        for (out, pair) in inner.iter_mut().zip(here.windows(2)) {
            *out = pair.first().map_or(T::ZERO, |&low| low) - pair.last().map_or(T::ZERO, |&high| high);
        }
        return;
    }
    match grid.neighbour(row, axis, Side::Low) {
        Some(below) => {
            out.copy_from_slice(rows::part(cells, below * n..(below + 1) * n));
            rows::sub(out, here);
        }
        None => out.fill(T::ZERO),
    }
}
