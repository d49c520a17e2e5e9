//! What windows are told of the scene beyond them: the mass of smoke that nothing steers, and the way to the next keyframe.

use super::left::Left;
use crate::destination::Destination;
use crate::exit::Failure;
use crate::output::{Frames, Sample, Samples};
use crate::progress::Watch;
use crate::remarks::mass;
use crate::run::drawn::drawn;
use crate::run::drawn::solid_cells;
use crate::run::frames::SolverFrames;
use crate::run::inputs::set_mask;
use crate::run::job::Job;
use crate::run::reach::Reach;
use crate::run::stages::Stage;
use crate::run::targets::{Which, check_reach, set_keyframes};
use crate::scene::Scene;
use crate::windows::Window;
use core::mem::MaybeUninit;
use thurible_core::method::registry::steers;
use thurible_core::output::DENSITY;
use thurible_core::{Exec, Real, Silent, Space, Status};

/// Looks at the whole scene before the first window: whether it can be read, whether smoke can come to every keyframe, and which mass it has there.
///
/// # Errors
/// It cannot, or the flow becomes too fast.
pub(super) fn look<T: Real + Sample, S: Space>(
    job: &Job,
    exec: &dyn Exec,
    block: &mut [MaybeUninit<u8>],
    (destination, windows): (&Destination, &[Window]),
) -> Result<Option<Vec<f64>>, Failure> {
    let steers = steers(&job.planned.params);
    if let Some(first) = windows.first() {
        check_start::<T, S>(job, block, destination, first)?;
    }
    if !steers {
        return Ok(None);
    }
    check_targets(&job.request.scene)?;
    free_masses::<T, S>(job, exec, block, destination)
}

/// Reads once what the `first` window begins with, and what emitters draw in later ones, before the states of an earlier solve make way.
fn check_start<T: Real + Sample, S: Space>(
    job: &Job,
    block: &mut [MaybeUninit<u8>],
    destination: &Destination,
    first: &Window,
) -> Result<(), Failure> {
    let (scene, mut unheard) = (&job.request.scene, Vec::new());
    for emitter in &scene.emitters {
        drawn::<f64>(scene, &emitter.key, &emitter.shape, &mut unheard)?;
    }
    let (scratch, samples) = (destination.aside()?, Samples::new(T::PRECISION));
    let mut left = Left::new(&scratch, "start", S::DIM, samples)?;
    let (mut solver, _) = job.lead::<T, S>(Stage::Window(0, false), block)?;
    left.begin(scene, job.request.from.as_ref(), first, &mut solver, &mut unheard)
}

/// Draws the mask and every keyframe once, so that nothing is found wrong in the middle of a solve, and sees whether smoke can come there.
fn check_targets(scene: &Scene) -> Result<(), Failure> {
    let mut unheard = Vec::new();
    if let Some(mask) = &scene.control.mask {
        drawn::<f64>(scene, "control.mask", mask, &mut unheard)?;
    }
    for keyframe in &scene.keyframes {
        drawn::<f64>(scene, &keyframe.key, &keyframe.shape, &mut unheard)?;
        if let Some(region) = &keyframe.region {
            drawn::<f64>(scene, &format!("{}.region", keyframe.key), region, &mut unheard)?;
        }
    }
    let Some(solid) = solid_cells(scene, &mut unheard)? else {
        return Ok(());
    };
    let mut reach = Reach::new(&scene.canvas(), &solid);
    let source = scene.source.iter().map(|source| ("source", source));
    let emitters = scene
        .emitters
        .iter()
        .map(|emitter| (emitter.key.as_str(), &emitter.shape));
    for (key, shape) in source.chain(emitters) {
        reach.fill(drawn::<f64>(scene, key, shape, &mut unheard)?.into_iter());
    }
    check_reach(scene, Some(reach))
}

/// The mass at every step of a flow that nothing steers, simulated in pieces; `None` where no keyframe asks.
///
/// # Errors
/// The flow becomes too fast.
fn free_masses<T: Real + Sample, S: Space>(
    job: &Job,
    exec: &dyn Exec,
    block: &mut [MaybeUninit<u8>],
    destination: &Destination,
) -> Result<Option<Vec<f64>>, Failure> {
    let scene = &job.request.scene;
    let (Some(windows), true) = (job.planned.windows, scene.asks_a_free_flow()) else {
        return Ok(None);
    };
    let (scratch, samples) = (destination.aside()?, Samples::new(T::PRECISION));
    let mut left = Left::new(&scratch, "free", S::DIM, samples)?;
    let whole = job.planned.problem.unsteered();
    let mut masses = Vec::new();
    for (number, window) in windows.of(&whole).into_iter().enumerate() {
        let (mut solver, problem) = job.lead::<T, S>(Stage::FreeWindow(number), block)?;
        left.begin(scene, None, &window, &mut solver, &mut Vec::new())?;
        solver.solve(exec, &mut Silent, &mut |_| {});
        if !solver.is_finished() {
            let why = "cannot be true here: the mass is that of a free flow, which becomes too fast to follow; set it to false, or let the \
                       emitters add by a rate";
            return Err(scene.document.refuse("control.match_mass", why));
        }
        let kept = 0..window.keeps + usize::from(window.is_last);
        masses.extend(kept.map(|step| mass(&solver, step)));
        if !window.is_last {
            left.take(&SolverFrames::new(&mut solver, exec, &problem), &window)?;
        }
    }
    Ok(Some(masses))
}

/// Where a window is to come to on its way to a keyframe beyond it.
pub(super) enum Aim {
    /// To this density.
    At(Samples),
    /// It is told nothing.
    Nowhere,
    /// The user has asked to stop.
    Cancelled,
}

/// Looks along the way.
pub(super) struct Look<'a> {
    pub job: &'a Job,
    pub exec: &'a dyn Exec,
    /// The mass at every step, where keyframes take that of a free flow.
    pub masses: Option<&'a [f64]>,
}

impl Look<'_> {
    /// Solves the way ahead of window `number` in the memory that the window is going to have, from what was `left` before it.
    pub fn along<T: Real + Sample, S: Space>(
        &self,
        left: &mut Left,
        block: &mut [MaybeUninit<u8>],
        watch: &mut Watch,
        (number, window): (usize, &Window),
    ) -> Result<Aim, Failure> {
        let (planned, request) = (&self.job.planned, &self.job.request);
        let Some(ahead) = &window.ahead else {
            return Ok(Aim::Nowhere);
        };
        let scene = &request.scene;
        let (mut solver, way) = self.job.lead::<T, S>(Stage::Way(number), block)?;
        let seen = Window {
            emitters: window.emitters_on_way(&planned.problem),
            ..window.clone()
        };
        let mut unheard = Vec::new();
        left.begin(scene, request.from.as_ref(), &seen, &mut solver, &mut unheard)?;
        set_mask(scene, &mut solver, &mut unheard)?;
        let among: Vec<usize> = ahead.keyframes.iter().map(|(number, _)| *number).collect();
        let which = Which {
            masses: self.masses,
            among: Some(&among),
        };
        set_keyframes(scene, &mut solver, which, &mut unheard)?;
        let ended = solver.solve(self.exec, watch, &mut |_| {});
        if ended == Status::Cancelled || !solver.is_finished() {
            return Ok(if ended == Status::Cancelled {
                Aim::Cancelled
            } else {
                Aim::Nowhere
            });
        }
        let mut density = Samples::new(T::PRECISION);
        SolverFrames::new(&mut solver, self.exec, &way).read(&DENSITY, ahead.within, 0, &mut density);
        let numbers = T::list(&mut density);
        numbers.iter_mut().for_each(|x| *x = x.max(T::from_f64(0.0)));
        let is_empty = numbers.iter().all(|x| x.to_f64() <= 0.0);
        Ok(if is_empty { Aim::Nowhere } else { Aim::At(density) })
    }
}
