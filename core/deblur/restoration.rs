//! An image on its way: its block of memory, its walk, its objective.

use super::colours::gather;
use super::error::DeblurError;
use super::kernel::Blur;
use super::prior::{Clusters, ImagePrior, whole};
use super::settings::{Deblur, Restorer};
use super::terrain::Spot;
use crate::memory::{Arena, Layout, Ledger, TooSmall};
use crate::real::Real;
use crate::walk::{Course, Rule, Walked};
use core::mem::MaybeUninit;

/// The restoration of an image.
pub struct Restoration<'m, T> {
    pub(super) problem: Deblur<'m>,
    pub(super) buffers: Buffers<'m, T>,
    pub(super) course: Course<Spot>,
    pub(super) eps: f64,
    pub(super) clusters: Clusters,
    pub(super) iterations: usize,
}

#[derive(Default)]
pub(super) struct Buffers<'m, T> {
    pub(super) kernels: &'m mut [T],
    pub(super) which: &'m mut [u16],
    pub(super) measured: &'m mut [T],
    pub(super) residual: &'m mut [T],
    pub(super) mask: &'m mut [u16],
    pub(super) planes: &'m mut [T],
    pub(super) work: [&'m mut [T]; 4],
}

impl<'m, T: Real> Buffers<'m, T> {
    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>, problem: &Deblur<'_>) -> Result<(), TooSmall> {
        let frame = problem.frame;
        let image = frame.pixels().saturating_mul(frame.channels);
        let unknowns = frame.unknowns().saturating_mul(frame.channels);
        layout.work("kernels", &mut self.kernels, problem.kernels.values.len())?;
        layout.work(
            "kernel of each pixel",
            &mut self.which,
            problem.kernels.which.len(),
        )?;
        layout.work("image", &mut self.measured, image)?;
        layout.work("residual", &mut self.residual, image)?;
        layout.work("mask", &mut self.mask, image)?;
        layout.work("restored image", &mut self.planes, unknowns)?;
        let plane = frame.unknowns();
        let lengths: [usize; 4] = match problem.tuning.method {
            Restorer::Walk => [0; 4],
            Restorer::RichardsonLucy => [frame.pixels(), 0, 0, 0],
            Restorer::Wiener => [plane, plane, plane, frame.pixels()],
            Restorer::PrimalDual => [image, unknowns, unknowns, unknowns],
        };
        for (work, length) in self
            .work
            .iter_mut()
            .zip(lengths)
            .filter(|(_, length)| *length > 0)
        {
            layout.work("work of the baseline", work, length)?;
        }
        Ok(())
    }
}

impl<'m, T: Real> Restoration<'m, T> {
    /// Writes what an image takes into `ledger`.
    pub fn plan(problem: &Deblur<'_>, ledger: &mut Ledger) {
        let mut arena = Arena::measuring(ledger);
        // An arena that measures has room for everything.
        let _ = Buffers::<T>::default().layout(&mut Layout::carve(&mut arena), problem);
    }

    /// Bytes that an image takes, or `None` where they cannot be counted.
    #[must_use]
    pub fn bytes(problem: &Deblur<'_>) -> Option<usize> {
        let mut ledger = Ledger::new();
        Self::plan(problem, &mut ledger);
        ledger.bytes()
    }

    /// A restoration of `image`, planes of the channels one after the other, in `memory`, which begins on a multiple of 64 and has
    /// [`Self::bytes`]. It begins with the image itself, its edges replicated into the border.
    ///
    /// # Errors
    /// What [`Deblur::check`] refuses, too little memory, an image that will not do.
    pub fn new(
        problem: Deblur<'m>,
        image: &[T],
        memory: &'m mut [MaybeUninit<u8>],
    ) -> Result<Self, DeblurError> {
        problem.check()?;
        let needed = Self::bytes(&problem).ok_or(DeblurError::TooLarge)?;
        if memory.len() < needed {
            return Err(DeblurError::Memory { needed });
        }
        let frame = problem.frame;
        if image.len() != frame.pixels() * frame.channels {
            return Err(DeblurError::Image { at: None });
        }
        if let Some(at) = image.iter().position(|value| !Real::is_finite(*value)) {
            return Err(DeblurError::Image { at: Some(at) });
        }
        let mut arena = Arena::new(memory);
        let mut buffers = Buffers::<T>::default();
        buffers
            .layout(&mut Layout::carve(&mut arena), &problem)
            .map_err(|_| DeblurError::Memory { needed })?;
        let tuning = problem.tuning;
        let unknowns = (frame.unknowns() * frame.channels) as u64;
        let pixels = (frame.pixels() * frame.channels) as u64;
        let mut restoration = Self {
            course: Course::new(
                tuning.seed,
                0,
                pixels,
                ((tuning.budget * unknowns as f64) as u64).max(1),
                Rule::Eager,
            ),
            problem,
            buffers,
            eps: tuning.eps,
            clusters: Clusters::default(),
            iterations: 0,
        };
        restoration.fill(image)?;
        Ok(restoration)
    }

    fn fill(&mut self, image: &[T]) -> Result<(), DeblurError> {
        let frame = self.problem.frame;
        let buffers = &mut self.buffers;
        for (to, &from) in buffers.kernels.iter_mut().zip(self.problem.kernels.values) {
            *to = T::from_f64(from);
        }
        buffers.which.copy_from_slice(self.problem.kernels.which);
        buffers.measured.copy_from_slice(image);
        let bright = self.problem.tuning.saturation.unwrap_or(f64::INFINITY);
        for (mask, value) in buffers.mask.iter_mut().zip(image) {
            *mask = u16::from(value.to_f64() < bright);
        }
        if buffers.mask.iter().all(|&mask| mask == 0) {
            return Err(DeblurError::Saturated);
        }
        for (plane, image) in buffers
            .planes
            .chunks_exact_mut(frame.unknowns())
            .zip(image.chunks_exact(frame.pixels()))
        {
            for (place, value) in plane.iter_mut().enumerate() {
                *value = image.get(frame.nearest(place)).copied().unwrap_or_default();
            }
        }
        self.renew();
        if self.problem.tuning.prior == ImagePrior::Clusters {
            let tuning = self.problem.tuning;
            (self.clusters.count, self.clusters.mu) = (tuning.colours, tuning.mu);
            gather(&mut self.clusters, &frame, self.buffers.planes, true);
        }
        Ok(())
    }

    /// r = q - f * p.
    pub(super) fn renew(&mut self) {
        let frame = self.problem.frame;
        let buffers = &mut self.buffers;
        let blur = Blur {
            frame,
            values: &*buffers.kernels,
            which: &*buffers.which,
        };
        let planes = buffers.planes.chunks_exact(frame.unknowns());
        let images = buffers.residual.chunks_exact_mut(frame.pixels());
        for ((plane, residual), measured) in planes
            .zip(images)
            .zip(buffers.measured.chunks_exact(frame.pixels()))
        {
            blur.apply(plane, residual);
            for (residual, &measured) in residual.iter_mut().zip(measured) {
                *residual = measured - *residual;
            }
        }
    }

    /// Whether the budget is spent.
    #[must_use]
    pub fn over(&self) -> bool {
        match self.problem.tuning.method {
            Restorer::Walk => self.course.over(),
            // All its iterations are one solve.
            Restorer::Wiener => self.iterations > 0,
            _ => self.iterations >= self.problem.tuning.iterations,
        }
    }

    /// Mutations of a chain.
    #[must_use]
    pub fn length(&self) -> u64 {
        (self.problem.frame.pixels() * self.problem.frame.channels) as u64
    }

    /// Chains of the walk, or iterations of a baseline, in all.
    #[must_use]
    pub fn pieces(&self) -> usize {
        match self.problem.tuning.method {
            Restorer::Walk => {
                let all = self.problem.tuning.budget
                    * (self.problem.frame.unknowns() * self.problem.frame.channels) as f64;
                (all as u64).max(1).div_ceil(self.length()) as usize
            }
            Restorer::Wiener => 1,
            _ => self.problem.tuning.iterations,
        }
    }

    /// Mutations and records so far; iterations of a baseline.
    #[must_use]
    pub fn walked(&self) -> Walked {
        match self.problem.tuning.method {
            Restorer::Walk => self.course.walked(),
            _ => Walked {
                mutations: self.iterations as u64,
                recorded: self.iterations as u64,
            },
        }
    }

    /// The step of the next chain.
    #[must_use]
    pub fn eps(&self) -> f64 {
        self.eps
    }

    /// 1/2 |M (q - f * p)|^2 and gamma Gamma(p).
    #[must_use]
    pub fn objective(&self) -> [f64; 2] {
        let frame = self.problem.frame;
        let pixels = self.buffers.residual.iter().zip(&*self.buffers.mask);
        let data: f64 = pixels
            .map(|(residual, &mask)| f64::from(mask) * residual.to_f64() * residual.to_f64())
            .sum();
        let tuning = self.problem.tuning;
        let gamma = whole(tuning.prior, &self.clusters, &frame, self.buffers.planes);
        [0.5 * data, tuning.gamma * gamma]
    }

    /// The restored image with its border, planes of the channels one after the other.
    #[must_use]
    pub fn planes(&self) -> &[T] {
        self.buffers.planes
    }

    /// q - f * p.
    #[must_use]
    pub fn residual(&self) -> &[T] {
        self.buffers.residual
    }

    /// The colours of the prior `clusters`.
    #[must_use]
    pub fn clusters(&self) -> &Clusters {
        &self.clusters
    }
}
