//! A result on finer cells: the scene is drawn again, and the flow of the result carries its density, step by step.

mod again;

use crate::bytes;
use crate::distance::relative_l2;
use crate::exit::Failure;
use crate::keyframes::Note;
use crate::output::{Body, Reel, Still};
use crate::problem::OwnedProblem;
use crate::region::MARGIN;
use crate::run::drawn::solid_cells;
use crate::run::drawn::{drawn, refuse};
use crate::scene::Scene;
use crate::threads;
use again::{Origin, located};
use core::mem::MaybeUninit;
use std::path::Path;
use thurible_core::{Refined, Refinement, Scheme, Serial, Silent};

/// Bytes a finer cell while shapes are drawn, in double precision.
const SHAPES: usize = 28;
/// The density that a result begins with is that of its scene's source if it differs by no more than this part of its size.
const SAME: f64 = 1e-3;

/// What is going to be done, and what it takes.
pub(crate) struct Plan {
    scale: usize,
    scene: Scene,
    coarse: Scene,
    problem: OwnedProblem,
    threads: usize,
    /// Bytes of the block.
    pub block: usize,
    /// Bytes that it takes from the system.
    pub bytes: usize,
    /// Bytes beside it.
    pub beside: usize,
}

impl Plan {
    /// Plans the result in `folder` on cells `scale` times as fine; files of its scene are looked for beside `file`, if that is given. `drawing` says
    /// how many bytes a picture of so many cells takes.
    pub fn new(
        (folder, scale): (&Path, usize),
        file: Option<&Path>,
        threads: usize,
        drawing: &dyn Fn(&[usize]) -> usize,
    ) -> Result<Self, Failure> {
        let [scene, coarse] = Origin::of(folder)?.scenes(scale, file)?;
        let mut problem = OwnedProblem::of(&scene);
        problem.advection.scheme = Scheme::Limited;
        let refinement = refinement(scale, threads);
        let block = Refined::<f32>::bytes(&problem.problem(), refinement);
        let block = block.map_err(|error| {
            Failure::Input(format!(
                "--scale {scale}: {error}; ask for a smaller scale, or leave it out"
            ))
        })?;
        Ok(Self {
            block,
            bytes: block.saturating_add(MARGIN),
            beside: drawing(&problem.cells).max(SHAPES.saturating_mul(problem.cells.iter().product())),
            scale,
            scene,
            coarse,
            problem,
            threads,
        })
    }

    /// The finer cells.
    pub fn cells(&self) -> &[usize] {
        &self.problem.cells
    }

    /// Refuses what does not fit under `limit` bytes, or is not there.
    pub fn check_memory(&self, limit: Option<usize>) -> Result<(), Failure> {
        let all = self.bytes.saturating_add(self.beside);
        let limit = limit.or_else(bytes::of_machine).unwrap_or(usize::MAX);
        if all <= limit && bytes::are_free(all) {
            return Ok(());
        }
        Err(self.no_memory(limit))
    }

    /// The failure of what does not fit into `limit` bytes.
    pub fn no_memory(&self, limit: usize) -> Failure {
        Failure::Memory(format!(
            "--scale {}: {} cells take {} for one step, whatever the number of steps, and some {} to draw it, more than the system gives or the limit of {}; ask for a smaller scale",
            self.scale,
            in_words(self.cells()),
            bytes::rounded(self.bytes),
            bytes::rounded(self.beside),
            bytes::rounded(limit),
        ))
    }
}

/// What makes cells `scale` times as fine.
fn refinement(scale: usize, threads: usize) -> Refinement {
    Refinement {
        doublings: scale.checked_ilog2().map_or(0, |doublings| doublings as usize),
        threads,
        ..Refinement::default()
    }
}

/// Counts in words, "128 x 128".
pub(crate) fn in_words(cells: &[usize]) -> String {
    let counts: Vec<String> = cells.iter().map(usize::to_string).collect();
    counts.join(" x ")
}

/// How far what is drawn is from the result at a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apart {
    /// The step, that of a keyframe.
    pub step: usize,
    /// Euclidean distance of the means over the result's cells from its density, in parts of the size of that.
    pub relative_l2: f64,
}

/// The density of a result on finer cells, carried by its flow.
pub(crate) struct Finer<'m> {
    refined: Refined<'m, f32>,
    cells: Vec<usize>,
    body: Option<Body>,
    threads: usize,
    scale: usize,
    /// Bytes of its block.
    pub bytes: usize,
    /// What the user should hear of the files that were read.
    pub notes: Vec<Note>,
}

impl<'m> Finer<'m> {
    /// Draws the scene of `plan` in `block`, which has the bytes that it says.
    pub fn begin(plan: &Plan, block: &'m mut [MaybeUninit<u8>], reel: &mut Reel) -> Result<Self, Failure> {
        let path = plan.scene.document.path();
        Self::draw(plan, block, reel).map_err(|failure| located(path, failure))
    }

    fn draw(plan: &Plan, block: &'m mut [MaybeUninit<u8>], reel: &mut Reel) -> Result<Self, Failure> {
        let (scene, problem) = (&plan.scene, plan.problem.problem());
        let refined = Refined::carve(&problem, refinement(plan.scale, plan.threads), block);
        let refined = refined.map_err(|error| {
            Failure::Memory(format!(
                "the finer grid refused its block of memory: {error}; this is a fault of thurible, please report it"
            ))
        })?;
        let mut finer = Self {
            refined,
            cells: plan.cells().to_vec(),
            body: None,
            threads: plan.threads,
            scale: plan.scale,
            bytes: plan.bytes,
            notes: Vec::new(),
        };
        if let Some(solid) = solid_cells(scene, &mut finer.notes)? {
            finer
                .refined
                .set_solids(&solid)
                .map_err(refuse(scene, "obstacle[0]"))?;
            let solid: Vec<f32> = solid
                .into_iter()
                .map(|solid| f32::from(u8::from(solid)))
                .collect();
            finer.body = Body::new(&finer.cells, &solid);
        }
        finer.draw_source(plan, reel)?;
        for (index, emitter) in scene.emitters.iter().enumerate() {
            let shape: Vec<f32> = drawn(scene, &emitter.key, &emitter.shape, &mut finer.notes)?;
            let set = finer.refined.set_emitter(index, &shape);
            set.map_err(refuse(scene, &emitter.key))?;
        }
        Ok(finer)
    }

    /// Draws the source, if that is what the result begins with, or else what that is.
    fn draw_source(&mut self, plan: &Plan, reel: &mut Reel) -> Result<(), Failure> {
        let begins = reel.density(0)?;
        let drawn_once: Option<Vec<f32>> = match &plan.coarse.source {
            Some(source) => Some(drawn(&plan.coarse, "source", source, &mut self.notes)?),
            None => None,
        };
        let solid = reel.solid()?;
        let is_drawn = drawn_once.is_some_and(|mut once| {
            once.iter_mut()
                .zip(solid.iter().flatten())
                .for_each(|(once, &solid)| *once *= 1.0 - solid);
            apart(&once, &begins) <= SAME
        });
        self.notes.clear();
        let set = match &plan.scene.source {
            Some(source) if is_drawn => {
                let source: Vec<f32> = drawn(&plan.scene, "source", source, &mut self.notes)?;
                self.refined.set_density(&source)
            }
            _ => {
                if begins.iter().any(|&x| x != 0.0) {
                    let text = "the result does not begin with the source of its scene: its first density is taken, as smooth as it is";
                    self.notes.push(Note::remark(text.into()));
                }
                let begins: Vec<f32> = begins.into_iter().map(|x| x.max(0.0)).collect();
                self.refined.set_density_of_result(&Serial, &begins)
            }
        };
        set.map_err(refuse(&plan.scene, "source"))
    }

    /// Cells along x, y (and z).
    pub fn cells(&self) -> &[usize] {
        &self.cells
    }

    /// The step of the density.
    pub fn step(&self) -> usize {
        self.refined.step()
    }

    /// Carries the density to the next step by the flow of the result.
    pub fn follow(&mut self, reel: &mut Reel) -> Result<(), Failure> {
        let step = self.step();
        for axis in 0..self.cells.len() {
            let faces = reel.faces(axis, step)?;
            self.refined.set_velocity(axis, &faces).map_err(|error| {
                Failure::Input(format!(
                    "--scale {}: the flow of step {step} cannot be used: {error}; solve it again",
                    self.scale
                ))
            })?;
        }
        let refined = &mut self.refined;
        let went = threads::together(self.threads, |exec| refined.advance(exec, &mut Silent));
        went.map_err(|_| {
            Failure::NotFinite(format!(
                "--scale {}: the flow of step {step} goes through more than 64 of the finer cells, too fast to follow; ask for a smaller scale, or solve it in more steps",
                self.scale
            ))
        })
    }

    /// How far it is from the result, in the result's cells.
    pub fn apart(&self, reel: &mut Reel) -> Result<Apart, Failure> {
        let step = self.step();
        let density = reel.density(step)?;
        let mut means = vec![0.0; density.len()];
        threads::together(self.threads, |exec| self.refined.means(exec, &mut means));
        Ok(Apart {
            step,
            relative_l2: apart(&means, &density),
        })
    }

    /// What is drawn of the step.
    pub fn still(&self) -> Still {
        let mut density = vec![0.0; self.refined.cells()];
        self.refined.read_density(&mut density);
        Still {
            cells: self.cells.clone(),
            density,
            body: self.body.clone(),
        }
    }
}

/// How far a density is from another.
fn apart(one: &[f32], other: &[f32]) -> f64 {
    let pairs = one.iter().zip(other);
    relative_l2(pairs.map(|(&one, &other)| [one, other].map(f64::from)))
}
