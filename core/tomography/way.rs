//! The way through a frame: where it begins, and how it goes on.

use super::error::TomographyError;
use super::gallery::{self, Gallery};
use super::pixels::project;
use super::problem::Method;
use super::reconstruction::{Buffers, Reconstruction};
use super::sart;
use super::terrain::{Ground, walk};
use crate::real::Real;
use crate::walk::Course;

/// Parts of a budget, after each of which the tolerance is asked, and chains in each of them at least: a few that found nothing are no end.
const PARTS: u64 = 10;
const CHAINS: u64 = 10;

impl<T: Real, const D: usize> Reconstruction<'_, T, D> {
    /// Begins frame `frame` with the pictures that were measured: from nothing, or, `warm`, from the density of the frame before, unless that
    /// was dark or there was none.
    ///
    /// # Errors
    /// [`TomographyError::Dark`] where there is nothing to be seen; the density is empty then.
    pub fn begin(&mut self, frame: u64, warm: bool) -> Result<(), TomographyError> {
        let settings = self.problem.settings;
        let total = self.total();
        // After a dark frame there is nothing to go on from, and a part of the budget would not do.
        let warm = core::mem::replace(&mut self.lit, total > 0.0) && warm;
        if !self.lit {
            self.buffers.density.fill(T::ZERO);
            self.buffers.novel.fill(T::ZERO);
            return Err(TomographyError::Dark);
        }
        self.frame = frame;
        self.eps = settings
            .eps
            .unwrap_or(total / (settings.accept * settings.budget as f64));
        self.budget = if warm {
            ((settings.budget as f64 * settings.warm_budget) as u64).max(1)
        } else {
            settings.budget
        };
        self.course = Course::new(settings.seed, frame, settings.length, self.budget, settings.rule);
        (self.swept, self.settled) = (0, false);
        let Buffers {
            measured,
            residual,
            density,
            ..
        } = &mut self.buffers;
        residual.copy_from_slice(measured);
        if warm {
            self.keep_hull();
            self.subtract();
        } else {
            density.fill(T::ZERO);
        }
        self.look_again();
        self.last = self.energy().total();
        Ok(())
    }

    fn ground(&mut self) -> Ground<'_, T, D> {
        let settings = self.problem.settings;
        let cells = self.problem.cells;
        let diagonal: f64 = cells.counts.iter().map(|&count| (count * count) as f64).sum();
        Ground {
            cells,
            cameras: self.problem.cameras,
            measured: self.buffers.measured,
            residual: self.buffers.residual,
            density: self.buffers.density,
            prior: settings.prior,
            gamma: settings.gamma,
            nonnegative: settings.nonnegative,
            sigma: settings.sigma * Real::sqrt(diagonal),
            eps: self.eps,
            dark: settings.hull_threshold,
        }
    }

    /// Empties the cells outside of the visual hull.
    fn keep_hull(&mut self) {
        let ground = self.ground();
        for index in 0..ground.cells.len() {
            let centre = ground.cells.cell(index).map(|at| at as f64 + 0.5);
            if !ground.in_hull(&centre)
                && let Some(cell) = ground.density.get_mut(index)
            {
                *cell = T::ZERO;
            }
        }
    }

    /// r = q - F p, every cell a sample at its centre.
    fn subtract(&mut self) {
        let cells = self.problem.cells;
        let mut rest = &mut *self.buffers.residual;
        for camera in self.problem.cameras {
            let (picture, after) = rest.split_at_mut(camera.len());
            rest = after;
            project(&cells, camera, self.buffers.density, -1.0, picture);
        }
    }

    /// F p of the novel views, every cell a sample at its centre.
    fn look_again(&mut self) {
        let cells = self.problem.cells;
        let Buffers { density, novel, .. } = &mut self.buffers;
        novel.fill(T::ZERO);
        let mut rest = &mut **novel;
        for camera in self.problem.novel {
            let Some((image, after)) = rest.split_at_mut_checked(camera.len()) else {
                return;
            };
            rest = after;
            project(&cells, camera, density, 1.0, image);
        }
    }

    /// Goes on by about a tenth of the budget at most; whether the frame is done.
    pub fn advance(&mut self, most: u64) -> bool {
        if self.over() {
            return true;
        }
        match self.problem.settings.method {
            Method::Walk => self.walk(most),
            Method::Sart => self.sweep(),
        }
        self.over()
    }

    fn walk(&mut self, most: u64) {
        let mut left = most;
        while left > 0 && !self.over() {
            let mut course = self.course;
            let before = course.walked().mutations;
            let part = self
                .budget
                .div_ceil(PARTS)
                .max(CHAINS.saturating_mul(self.problem.settings.length));
            let end = (before / part + 1).saturating_mul(part);
            self.stroll(&mut course, left.min(end - before));
            self.course = course;
            let went = course.walked().mutations - before;
            left -= went.min(left);
            if course.walked().mutations == end {
                let now = self.energy().total();
                self.settled = self.last - now < self.problem.settings.tolerance * now;
                self.last = now;
            }
        }
    }

    /// Up to `most` mutations more.
    fn stroll(&mut self, course: &mut Course<[f64; D]>, most: u64) {
        if self.problem.novel.is_empty() {
            return walk(&mut self.ground(), course, most);
        }
        let images = core::mem::take(&mut self.buffers.novel);
        let mut gallery = Gallery {
            cameras: self.problem.novel,
            images: &mut *images,
            ground: self.ground(),
        };
        gallery::walk(&mut gallery, course, most);
        self.buffers.novel = images;
    }

    fn sweep(&mut self) {
        let problem = self.problem;
        sart::sweep(&problem, &mut self.buffers, problem.settings.relax);
        self.keep_hull();
        sart::look(&problem, &mut self.buffers);
        self.look_again();
        self.swept += 1;
    }
}
