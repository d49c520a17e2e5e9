//! The steps of a known flow in turn: what becomes of it where it is taken to, and the smoke that it carries there.

use super::importance::{distances, importance};
use super::known::{Known, refuse};
use super::measure::changes;
use super::page::StepRecord;
use super::place::Job;
use super::request::Deed;
use crate::distance::relative_l2;
use crate::exit::Failure;
use crate::output::Store;
use crate::threads;
use core::fmt::Display;
use core::mem::MaybeUninit;
use thurible_core::{Boundary, Real, Refined, Serial, Silent};

const AXES: [&str; 3] = ["x", "y", "z"];

/// A flow on its way.
pub(super) struct Walk<'a, 'm, T> {
    job: &'a Job<'a>,
    known: &'a mut Known,
    refined: Refined<'m, T>,
    store: &'a mut Store,
    /// The numbers of the arrays in the store.
    density: usize,
    velocity: Vec<usize>,
    /// Squared distances from solid cells, where the flow beside the smoke is to give way.
    squared: Option<Vec<f64>>,
    /// The density of the earlier result at the step that comes next.
    smoke: Option<Vec<f64>>,
    /// The density on the earlier result's cells.
    means: Vec<T>,
}

impl<'a, 'm, T: Real> Walk<'a, 'm, T> {
    /// At the step to begin at, in the bytes of `block`.
    pub fn begin(
        job: &'a Job<'a>,
        known: &'a mut Known,
        block: &'m mut [MaybeUninit<u8>],
        store: &'a mut Store,
    ) -> Result<Self, Failure> {
        let unusable = |error: &dyn Display| unusable(job, error);
        let refined = Refined::<T>::carve(&job.problem.problem(), job.refinement, block);
        let mut refined = refined.map_err(|error| unusable(&error))?;
        if let Some(solid) = &job.solid {
            refined.set_solids(solid).map_err(|error| unusable(&error))?;
        }
        let smoke = known
            .smoke(job.request.at)?
            .ok_or_else(|| no_density(job, job.request.at))?;
        refined
            .set_density_of_result(&Serial, &narrowed(&smoke))
            .map_err(|error| unusable(&error))?;
        let (density, velocity) = arrays::<T>(job, store)?;
        store.push(density, refined.density())?;
        let weighted = matches!(job.request.deed, Deed::Remap { weighted: true, .. });
        if job.refinement.weighted.is_some() && !weighted {
            let alike = vec![T::ONE; refined.cells()];
            refined.set_importance(&alike).map_err(|error| unusable(&error))?;
        }
        let near = job.solid.as_ref().filter(|_| weighted);
        Ok(Self {
            squared: near.map(|solid| distances(&job.problem.cells, &job.problem.boundary, solid)),
            means: vec![T::ZERO; known.cells.iter().product()],
            smoke: Some(smoke),
            job,
            known,
            refined,
            store,
            density,
            velocity,
        })
    }

    /// Takes step `step`, counted from where it began; nothing where the flow is too fast to follow.
    pub fn step(&mut self, step: usize) -> Result<Option<StepRecord>, Failure> {
        let (job, begun) = (self.job, self.job.clock.total());
        let now = job.request.at + step;
        let smoke = self.smoke.take();
        if let Some(squared) = &self.squared {
            let smoke = smoke.as_ref().ok_or_else(|| no_density(job, now))?;
            let importance = narrowed(&importance(smoke, squared));
            let set = self.refined.set_importance(&importance);
            set.map_err(|error| unusable(job, &error))?;
        }
        let mut given: Vec<Vec<T>> = Vec::new();
        for axis in 0..self.known.cells.len() {
            let faces = narrowed(&self.known.flow(axis, now)?);
            let set = self.refined.set_velocity(axis, &faces);
            set.map_err(|error| unusable(job, &error))?;
            given.push(faces);
        }
        let refined = &mut self.refined;
        let went = threads::together(job.refinement.threads, |exec| refined.advance(exec, &mut Silent));
        if went.is_err() {
            return Ok(None);
        }
        if let Some(emission) = self.known.emission(now)? {
            let emission = narrowed(&emission);
            let added = threads::together(job.refinement.threads, |exec| {
                self.refined.add_of_result(exec, &emission)
            });
            added.map_err(|error| unusable(job, &error))?;
        }
        let flow = self.keep()?;
        let changed = match (&job.request.deed, &smoke) {
            (Deed::Remap { .. }, Some(smoke)) => Some(changes(&job.problem, &given, &flow, smoke)),
            _ => None,
        };
        self.smoke = self.known.smoke(now + 1)?;
        let effort = self.refined.effort();
        Ok(Some(StepRecord {
            step: step + 1,
            frame: now + 1,
            seconds: job.clock.total() - begun,
            relative_l2: self.apart(),
            changed,
            iterations: effort.iterations,
            energy: job.refinement.turbulence.map(|_| effort.energy),
        }))
    }

    /// Writes the flow of the step and the density after it; the flow.
    fn keep(&mut self) -> Result<Vec<Vec<T>>, Failure> {
        let mut flow = Vec::new();
        for (axis, &array) in self.velocity.iter().enumerate() {
            let mut faces = vec![T::ZERO; self.refined.faces(axis)];
            let read = self.refined.velocity(axis, &mut faces);
            read.map_err(|error| unusable(self.job, &error))?;
            self.store.push(array, &faces)?;
            flow.push(faces);
        }
        self.store.push(self.density, self.refined.density())?;
        Ok(flow)
    }

    /// How far the density is from that of the earlier result, if that has one.
    fn apart(&mut self) -> Option<f64> {
        let truth = self.smoke.as_ref()?;
        let (refined, means) = (&self.refined, &mut self.means);
        threads::together(self.job.refinement.threads, |exec| refined.means(exec, means));
        let pairs = self.means.iter().zip(truth);
        Some(relative_l2(pairs.map(|(ours, &truth)| [ours.to_f64(), truth])))
    }
}

/// Begins the arrays of density and velocity, and writes that of the solid cells.
fn arrays<T: Real>(job: &Job<'_>, store: &mut Store) -> Result<(usize, Vec<usize>), Failure> {
    let problem = &job.problem;
    let shape = |faces: Option<usize>| {
        let sides = problem.cells.iter().zip(&problem.boundary).enumerate();
        let side =
            |(axis, (&cells, &end))| cells + usize::from(faces == Some(axis) && end != Boundary::Periodic);
        sides.map(side).rev().collect::<Vec<usize>>()
    };
    if let Some(solid) = &job.solid {
        let plane = shape(None).split_off(1);
        let array = store.begin("solid", plane)?;
        let solid = solid.iter().map(|&solid| f64::from(u8::from(solid)));
        store.push(array, &narrowed::<T>(&solid.collect::<Vec<_>>()))?;
    }
    let density = store.begin("density", shape(None))?;
    let axes = AXES.iter().take(problem.cells.len()).enumerate();
    let velocity = axes.map(|(axis, name)| store.begin(&format!("velocity_{name}"), shape(Some(axis))));
    Ok((density, velocity.collect::<Result<_, _>>()?))
}

/// `values` in the precision of the result.
fn narrowed<T: Real>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&value| T::from_f64(value)).collect()
}

fn unusable(job: &Job<'_>, error: &dyn Display) -> Failure {
    refuse(
        &job.request.from,
        &format!("has a step that cannot be used: {error}; make it again"),
    )
}

fn no_density(job: &Job<'_>, step: usize) -> Failure {
    let why = format!("has the flow of step {step}, but no density there; make it again");
    refuse(&job.request.from, &why)
}
