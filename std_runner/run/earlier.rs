//! What a solve takes of an earlier result: where it begins, and the flow that guides it.

use super::drawn::narrowed;
use super::inputs::{Inputs, set_emitters, set_obstacles};
use crate::distance::relative_l2;
use crate::exit::Failure;
use crate::keyframes::{Earlier, ShapeError};
use crate::plan::size_in_words;
use crate::remarks::density;
use crate::report::{ARCHIVE, CENTRED, FrameRecord, Said, count, end_in_words};
use crate::scene::Scene;
use serde_json::Value;
use std::path::PathBuf;
use thurible_core::{Elsewhere, InputError, Real, Serial, Solver, Space};

/// A step of an earlier result.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    /// The option that named it, for messages.
    pub option: &'static str,
    /// The result folder.
    pub folder: PathBuf,
    /// The step; if there is none, the last one that has a flow.
    pub step: Option<usize>,
}

impl Origin {
    /// The file that it is read from.
    pub fn arrays(&self) -> PathBuf {
        self.folder.join(ARCHIVE)
    }

    /// Hands the density and the velocity of the step to `solver`; what little of the density is negative becomes 0.
    /// Emitters are the scene's, all or those `among` them, and their steps count from there. Velocities are taken `scale` times.
    pub fn begin<T: Real, S: Space>(
        &self,
        scene: &Scene,
        solver: &mut Solver<'_, T, S>,
        among: Option<&[usize]>,
        scale: f64,
    ) -> Result<Inputs, Failure> {
        set_obstacles(scene, solver, &mut Vec::new())?;
        let mut earlier = self.open(scene)?;
        if let Some(step) = self.step.filter(|&step| step >= earlier.flows()) {
            let last = earlier.flows().saturating_sub(1);
            return Err(self.refuse(format!(
                "has no flow of step {step}; --at is a step from 0 to {last}"
            )));
        }
        let mut inputs = Inputs::default();
        // The density behind it has no flow yet that carries it on.
        let step = self.step.or(earlier.flows().checked_sub(1));
        let density = earlier.density(step, &mut inputs.notes);
        let density = density.map_err(|error| self.unread(&error))?;
        // Where emitters make the smoke it may be that there is none yet.
        let is_none_yet = !scene.emitters.is_empty() && density.iter().all(|&value| value <= 0.0);
        let density: Vec<T> = narrowed(density);
        let taken = match (is_none_yet, among) {
            (false, _) => solver.set_source(&density),
            // In a window the emitters may come later.
            (true, Some(_)) => solver.go_on_from(&density),
            (true, None) => Ok(()),
        };
        taken.map_err(|error| self.unusable(&error))?;
        set_emitters(scene, solver, among, &mut None, &mut inputs.notes)?;
        for axis in 0..S::DIM {
            let faces = self.velocity::<T>(&mut earlier, step, axis, scale)?;
            solver
                .set_initial_velocity(axis, &faces)
                .map_err(|error| self.unusable(&error))?;
        }
        Ok(inputs)
    }

    /// A component of velocity `step`, or of the last one, `scale` times.
    fn velocity<T: Real>(
        &self,
        earlier: &mut Earlier,
        step: Option<usize>,
        axis: usize,
        scale: f64,
    ) -> Result<Vec<T>, Failure> {
        let faces = earlier.velocity(step, axis);
        let mut faces = faces.map_err(|error| self.unread(&error))?;
        faces.iter_mut().for_each(|face| *face *= scale);
        Ok(narrowed(faces))
    }

    /// Hands the flow from the step on to `solver`, which follows it, its velocities `scale` times.
    pub fn guide<T: Real, S: Space>(
        &self,
        scene: &Scene,
        solver: &mut Solver<'_, T, S>,
        scale: f64,
    ) -> Result<(), Failure> {
        let mut earlier = self.open(scene)?.as_it_is();
        let first = self.step.unwrap_or(0);
        let (needed, steps) = (first.saturating_add(solver.steps()), earlier.flows());
        if needed > steps {
            let remedy = if steps < first.saturating_add(2) {
                "a flow that is guided has 2 at least: give a smaller --at, or another result"
            } else {
                "take fewer steps with --steps, or another result"
            };
            return Err(self.refuse(format!(
                "has the flow of {}, where {needed} are needed, {first} before the first; {remedy}",
                count(steps, "step")
            )));
        }
        let elsewhere = elsewhere(scene, &earlier);
        if !have_one_shape(&scene.canvas().cells, &earlier.canvas().cells) {
            return Err(self.refuse(format!(
                "has a box of {} cells, and the scene one of {}, which is of another shape; give the scene as many cells along each axis, or all in one proportion",
                size_in_words(&earlier.canvas().cells),
                size_in_words(&scene.canvas().cells)
            )));
        }
        for step in 1..solver.steps() {
            let read = |axis| self.velocity(&mut earlier, Some(first + step), axis, scale);
            let faces: Vec<Vec<T>> = (0..S::DIM).map(read).collect::<Result<_, _>>()?;
            let mut all = faces.iter().map(Vec::as_slice);
            let set = match elsewhere {
                Some(from) => {
                    let faces = core::array::from_fn(|_| all.next().unwrap_or(&[]));
                    solver.set_reference_from(&Serial, step, from, faces)
                }
                None => all
                    .enumerate()
                    .try_for_each(|(axis, faces)| solver.set_reference(axis, step, faces)),
            };
            set.map_err(|error| self.unusable(&error))?;
        }
        Ok(())
    }

    /// How many times its velocities flow through as much of the scene's box in a step as through its own; once where no report says its length
    /// and time step.
    pub fn by_step(&self, scene: &Scene) -> f64 {
        Said::of(&self.folder).map_or(1.0, |said| {
            (scene.canvas().length / said.length) * (said.dt / scene.time.dt)
        })
    }

    /// How far the densities of `solver` are from those after the step, as far as there are any.
    pub fn compare<T: Real, S: Space>(
        &self,
        scene: &Scene,
        solver: &Solver<'_, T, S>,
    ) -> Result<Vec<FrameRecord>, Failure> {
        let Some(first) = self.step else {
            return Ok(Vec::new());
        };
        let mut earlier = self.open(scene)?.as_it_is();
        if earlier.canvas().cells != scene.canvas().cells {
            return Ok(Vec::new());
        }
        let there = earlier.densities().saturating_sub(first.saturating_add(1));
        let steps = 1..=solver.steps().min(there);
        steps
            .map(|step| {
                let frame = first + step;
                let truth = earlier.frame(Some(frame));
                let truth = truth.map_err(|error| self.unread(&error))?;
                let ours = density(solver, step);
                let pairs = ours.iter().zip(truth);
                Ok(FrameRecord {
                    step,
                    frame,
                    relative_l2: relative_l2(pairs.map(|(ours, truth)| [ours.to_f64(), truth])),
                })
            })
            .collect()
    }

    /// Opens its arrays, and refuses a box that ends otherwise than the scene's, and a flow that is not that of faces.
    fn open(&self, scene: &Scene) -> Result<Earlier, Failure> {
        let earlier = Earlier::open(&self.arrays(), scene.canvas()).map_err(|error| self.unread(&error));
        // Arrays may be there without a report.
        let Ok(said) = Said::of(&self.folder) else {
            return earlier;
        };
        let own: Vec<Value> = scene.grid.boundary.iter().map(end_in_words).collect();
        if said.centred {
            Err(Failure::Input(format!(
                "{} {} {CENTRED}",
                self.option,
                self.folder.display()
            )))
        } else if said.boundary != own {
            Err(self.refuse(format!(
                "has the boundary {}, and the scene {}; give the scene the same `grid.boundary`, or another result",
                Value::from(said.boundary),
                Value::from(own)
            )))
        } else {
            earlier.map(|earlier| earlier.until(said.simulated))
        }
    }

    fn refuse(&self, why: String) -> Failure {
        Failure::Input(format!("{} {}: {why}", self.option, self.folder.display()))
    }

    fn unusable(&self, error: &InputError) -> Failure {
        let which = self
            .step
            .map_or("its last step".into(), |step| format!("its step {step}"));
        self.refuse(format!("{which} cannot be used: {error}; give another result"))
    }

    fn unread(&self, error: &ShapeError) -> Failure {
        let sentence = format!("{} {}: {error}", self.option, self.folder.display());
        error.failure(sentence)
    }
}

/// The cells of a flow in the scene's box and units, where they are others than the scene's.
fn elsewhere(scene: &Scene, earlier: &Earlier) -> Option<Elsewhere> {
    let there = earlier.canvas();
    (there.cells != scene.canvas().cells).then(|| Elsewhere {
        cells: there.cells_3d(),
        unit: there.cell_size() / scene.time.dt,
    })
}

/// Whether two boxes have the same sides but for their unit, as far as whole cells can have them.
fn have_one_shape(one: &[usize], other: &[usize]) -> bool {
    let most = |cells: &[usize]| cells.iter().copied().max().unwrap_or(1) as f64;
    let by = most(one) / most(other);
    one.iter()
        .zip(other)
        .all(|(&one, &other)| (one as f64 - by * other as f64).abs() <= by.max(1.0))
}
