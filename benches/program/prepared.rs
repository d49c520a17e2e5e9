//! Real scenes with overrides, ready to be solved.

use super::flow::courant_of;
use core::mem::MaybeUninit;
use std::path::Path;
use thurible::bytes::{grouped, rounded};
use thurible::exit::Failure;
use thurible::problem::{OwnedProblem, Precision, params_of, refusal};
use thurible::region::Region;
use thurible::run::inputs::{set_inputs, solver_refusal};
use thurible::scene::{Document, Scene};
use thurible_core::{Exec, Params, Plan, Problem, Real, Solver, Space};

/// A scene with what its solve needs.
pub struct PreparedScene {
    scene: Scene,
    problem: OwnedProblem,
    /// The parameters, to change before [`Self::with`].
    pub params: Params,
}

impl PreparedScene {
    /// The scene `text` by `method`, with assignments as after `--set`.
    ///
    /// # Errors
    /// [`Failure`]: the scene is wrong.
    pub fn new(
        name: &str,
        text: &str,
        assignments: &[String],
        method: &str,
        threads: usize,
    ) -> Result<Self, Failure> {
        let mut document = Document::parse(Path::new(name), text.to_owned())?;
        // Targets, floors and the pages of other days are those of the paper's transport and price.
        document.set("advection.scheme=quick")?;
        document.set("control.smoothness=0")?;
        assignments
            .iter()
            .try_for_each(|assignment| document.set(assignment))?;
        document.set(&format!("method.name={method}"))?;
        let scene = Scene::of(document)?;
        let params = params_of(&scene, threads, None);
        let problem = OwnedProblem::of(&scene);
        Ok(Self {
            scene,
            problem,
            params,
        })
    }

    /// Its plan in `precision`.
    ///
    /// # Errors
    /// [`Failure`]: there is none.
    pub fn plan(&self, precision: Precision) -> Result<Plan, Failure> {
        self.problem
            .plan(&self.params, precision)
            .map_err(|error| refusal(&self.scene, error))
    }

    /// The problem.
    pub fn problem(&self) -> Problem<'_> {
        self.problem.problem()
    }

    /// Hands a prepared solver to `work`.
    ///
    /// # Errors
    /// [`Failure`]: there is no plan or no memory for it.
    pub fn with<T: Real, S: Space, R>(
        &self,
        exec: &dyn Exec,
        work: impl FnOnce(&mut Solver<'_, T, S>) -> R,
    ) -> Result<R, Failure> {
        let problem = self.problem();
        let bytes = self.plan(Precision::of::<T>())?.bytes();
        in_block(bytes, |block| {
            let mut solver =
                Solver::<T, S>::new(&problem, &self.params, block).map_err(|error| solver_refusal(&error))?;
            set_inputs(&self.scene, &mut solver, None)?;
            solver.prepare(exec).map_err(|error| {
                self.scene.document.refuse(
                    "source",
                    format!("or a keyframe cannot be used: {error}; change it"),
                )
            })?;
            Ok(work(&mut solver))
        })
    }

    /// The largest Courant number of the velocities as they are.
    pub fn courant<T: Real, S: Space>(&self, solver: &Solver<'_, T, S>) -> f64 {
        let problem = self.problem();
        let grid = problem.grid();
        let mut faces: [Vec<T>; 3] = core::array::from_fn(|axis| {
            if axis < S::DIM {
                vec![T::ZERO; solver.faces(axis)]
            } else {
                Vec::new()
            }
        });
        let unit = problem.units().velocity;
        let mut of_step = |step: usize| {
            for (axis, faces) in faces.iter_mut().enumerate().take(S::DIM) {
                solver.velocity(step, axis, faces);
            }
            courant_of(&grid, |axis, [x, y, z]| {
                let extent = |a: usize| {
                    if a == axis {
                        grid.axis(a).faces()
                    } else {
                        grid.n[a]
                    }
                };
                faces[axis][(z * extent(1) + y) * extent(0) + x].to_f64() / unit
            })
        };
        (0..problem.steps).map(&mut of_step).fold(0.0, f64::max)
    }
}

/// Hands a block of its own to `work`, as a solve has one.
///
/// # Errors
/// [`Failure`]: there is no memory for it, or that of `work`.
pub(super) fn in_block<R>(
    bytes: usize,
    work: impl FnOnce(&mut [MaybeUninit<u8>]) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let mut region = Region::new(bytes).ok_or_else(|| no_memory(bytes))?;
    work(region.carve(bytes).ok_or_else(|| no_memory(bytes))?)
}

/// The sentence for a block that the system does not give.
pub(super) fn no_memory(bytes: usize) -> Failure {
    Failure::Memory(format!(
        "the system has not {} ({} bytes); use --quick",
        rounded(bytes),
        grouped(bytes)
    ))
}
