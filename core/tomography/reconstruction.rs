//! A frame: its block of memory, its walk, and what is known of it on the way.

use super::camera::Camera;
use super::error::{Fault, TomographyError};
use super::gallery::gamma;
use super::problem::{Method, Tomography};
use crate::memory::{Arena, Layout, Ledger, TooSmall};
use crate::real::Real;
use crate::walk::prior::whole;
use crate::walk::{Course, Walked};
use core::mem::MaybeUninit;
use core::ops::Range;

/// The two parts of the objective.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// 1/2 |q - F p|^2.
    pub data: f64,
    /// gamma Gamma(p).
    pub prior: f64,
}

impl Energy {
    /// Their sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.data + self.prior
    }
}

/// The reconstruction of one frame after the other.
pub struct Reconstruction<'m, T, const D: usize> {
    pub(super) problem: Tomography<'m, D>,
    pub(super) buffers: Buffers<'m, T>,
    pub(super) frame: u64,
    pub(super) eps: f64,
    pub(super) budget: u64,
    pub(super) course: Course<[f64; D]>,
    /// Sweeps of SART so far.
    pub(super) swept: usize,
    /// E at the last tenth.
    pub(super) last: f64,
    pub(super) settled: bool,
    /// Whether there was something to be seen in the last frame that was begun.
    pub(super) lit: bool,
}

#[derive(Default)]
pub(super) struct Buffers<'m, T> {
    pub(super) measured: &'m mut [T],
    pub(super) residual: &'m mut [T],
    pub(super) density: &'m mut [T],
    /// F p of the novel views.
    pub(super) novel: &'m mut [T],
    /// Of SART: what a camera adds to the cells, and their weights.
    pub(super) change: &'m mut [T],
    pub(super) weights: &'m mut [T],
}

impl<'m, T: Real> Buffers<'m, T> {
    fn layout<const D: usize>(
        &mut self,
        layout: &mut Layout<'_, 'm, T>,
        problem: &Tomography<'_, D>,
    ) -> Result<(), TooSmall> {
        let (pixels, cells) = (problem.pixels(), problem.cells.len());
        layout.work("pictures", &mut self.measured, pixels)?;
        layout.work("residual", &mut self.residual, pixels)?;
        if problem.settings.keeps_cells() {
            layout.work("density", &mut self.density, cells)?;
        }
        if !problem.novel.is_empty() {
            layout.work("novel views", &mut self.novel, problem.novel_pixels())?;
        }
        if problem.settings.method == Method::Sart {
            layout.work("change of the density", &mut self.change, cells)?;
            layout.work("weights of the cells", &mut self.weights, cells)?;
        }
        Ok(())
    }
}

impl<'m, T: Real, const D: usize> Reconstruction<'m, T, D> {
    /// Writes what a frame takes into `ledger`.
    pub fn plan(problem: &Tomography<'_, D>, ledger: &mut Ledger) {
        let mut arena = Arena::measuring(ledger);
        // An arena that measures has room for everything.
        let _ = Buffers::<T>::default().layout(&mut Layout::carve(&mut arena), problem);
    }

    /// Bytes that a frame takes, or `None` where they cannot be counted.
    #[must_use]
    pub fn bytes(problem: &Tomography<'_, D>) -> Option<usize> {
        let mut ledger = Ledger::new();
        Self::plan(problem, &mut ledger);
        ledger.bytes()
    }

    /// A reconstruction in `memory`, which begins on a multiple of 64 and has [`Self::bytes`].
    ///
    /// # Errors
    /// What [`Tomography::check`] refuses; too little memory.
    pub fn new(
        problem: Tomography<'m, D>,
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, TomographyError> {
        problem.check()?;
        let needed = Self::bytes(&problem).ok_or(TomographyError::TooLarge)?;
        if memory.len() < needed {
            return Err(TomographyError::Memory { needed });
        }
        let mut arena = Arena::new(memory);
        let mut buffers = Buffers::default();
        buffers
            .layout(&mut Layout::carve(&mut arena), &problem)
            .map_err(|_| TomographyError::Memory { needed })?;
        let settings = problem.settings;
        Ok(Self {
            problem,
            buffers,
            frame: 0,
            eps: 0.0,
            budget: 0,
            course: Course::new(settings.seed, 0, settings.length, 0, settings.rule),
            swept: 0,
            last: 0.0,
            settled: false,
            lit: false,
        })
    }

    /// The pixels of camera `camera`, row by row.
    fn range(&self, camera: usize) -> Range<usize> {
        among(self.problem.cameras, camera)
    }

    /// Takes what camera `camera` measured in the next frame.
    ///
    /// # Errors
    /// Another number of pixels, or one that is not finite.
    pub fn measure(&mut self, camera: usize, picture: &[T]) -> Result<(), TomographyError> {
        let wrong = |fault| TomographyError::Pixels { camera, fault };
        let range = self.range(camera);
        if picture.len() != range.len() {
            return Err(wrong(Fault::Count {
                found: picture.len(),
                expected: range.len(),
            }));
        }
        if let Some(pixel) = picture.iter().position(|pixel| !Real::is_finite(*pixel)) {
            return Err(wrong(Fault::NotFinite { pixel }));
        }
        if let Some(measured) = self.buffers.measured.get_mut(range) {
            measured.copy_from_slice(picture);
        }
        Ok(())
    }

    /// The mass of the smoke: the mean over cameras of the sum of their pixels, each times the area that it covers in the middle of the box.
    #[must_use]
    pub fn total(&self) -> f64 {
        let centre = self.problem.cells.counts.map(|count| 0.5 * count as f64);
        let cameras = self.problem.cameras;
        let mass = |(number, camera): (usize, &Camera<D>)| {
            let pixels = self.buffers.measured.get(self.range(number)).unwrap_or_default();
            let sum: f64 = pixels.iter().map(|pixel| pixel.to_f64()).sum();
            let weight = camera.see(&centre).map_or(1.0, |seen| seen.weight);
            sum / weight
        };
        cameras.iter().enumerate().map(mass).sum::<f64>() / cameras.len() as f64
    }

    /// Whether the budget is spent, or the last tenth of it brought too little.
    #[must_use]
    pub fn over(&self) -> bool {
        match self.problem.settings.method {
            Method::Walk => self.settled || self.course.over(),
            Method::Sart => self.swept >= self.problem.settings.sweeps,
        }
    }

    /// Whether the frame ended since it got hardly better.
    #[must_use]
    pub fn settled(&self) -> bool {
        self.settled
    }

    /// Mutations and records of the frame; of SART its sweeps.
    #[must_use]
    pub fn walked(&self) -> Walked {
        match self.problem.settings.method {
            Method::Walk => self.course.walked(),
            Method::Sart => Walked {
                mutations: self.swept as u64,
                recorded: self.swept as u64,
            },
        }
    }

    /// Mutations, or sweeps, of the frame at most.
    #[must_use]
    pub fn budget(&self) -> u64 {
        match self.problem.settings.method {
            Method::Walk => self.budget,
            Method::Sart => self.problem.settings.sweeps as u64,
        }
    }

    /// The mass of a sample.
    #[must_use]
    pub fn eps(&self) -> f64 {
        self.eps
    }

    /// The number of the frame.
    #[must_use]
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// The objective.
    #[must_use]
    pub fn energy(&self) -> Energy {
        let settings = self.problem.settings;
        let cells = whole(settings.prior, &self.problem.cells, self.buffers.density);
        let images = gamma(settings.prior, self.problem.novel, self.buffers.novel);
        Energy {
            data: 0.5 * square(self.buffers.residual),
            prior: settings.gamma * (cells + images),
        }
    }

    /// |q - F p| / |q|.
    #[must_use]
    pub fn residual_relative(&self) -> f64 {
        Real::sqrt(square(self.buffers.residual) / square(self.buffers.measured))
    }

    /// p, x fastest; empty where it is not kept.
    #[must_use]
    pub fn density(&self) -> &[T] {
        self.buffers.density
    }

    /// What novel view `view` shows.
    #[must_use]
    pub fn novel(&self, view: usize) -> &[T] {
        let range = among(self.problem.novel, view);
        self.buffers.novel.get(range).unwrap_or_default()
    }

    /// q of a camera.
    #[must_use]
    pub fn measured(&self, camera: usize) -> &[T] {
        self.buffers.measured.get(self.range(camera)).unwrap_or_default()
    }

    /// r of a camera: what its picture has and p does not explain.
    #[must_use]
    pub fn residual(&self, camera: usize) -> &[T] {
        self.buffers.residual.get(self.range(camera)).unwrap_or_default()
    }
}

/// The pixels of one of some cameras, row by row.
fn among<const D: usize>(cameras: &[Camera<D>], camera: usize) -> Range<usize> {
    let start = cameras.iter().take(camera).map(Camera::len).sum::<usize>();
    start..start + cameras.get(camera).map_or(0, Camera::len)
}

fn square<T: Real>(values: &[T]) -> f64 {
    values.iter().map(|value| value.to_f64() * value.to_f64()).sum()
}
