//! Real scenes: a scene file with overrides, ready to be solved.

use super::flow::courant_of;
use std::path::Path;
use thurible::inputs::hand_over;
use thurible::problem::{OwnedProblem, params_of};
use thurible::region::Region;
use thurible::scene::Scene;
use thurible_core::{Exec, Params, Plan, Problem, Real, Solver, Space};

/// A scene with what its solve needs.
pub struct Ready {
    scene: Scene,
    problem: OwnedProblem,
    /// The parameters, to change before [`Self::with`].
    pub params: Params,
}

impl Ready {
    /// `examples/NAME.toml` by ADMM, with assignments as after `--set`.
    pub fn example(name: &str, assignments: &[String], threads: usize) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name).with_extension("toml");
        let scene = Scene::load(&path, assignments, Some("admm")).unwrap_or_else(|failure| stop(&failure.to_string()));
        let (problem, params) = (OwnedProblem::of(&scene), params_of(&scene, threads, None));
        Self { scene, problem, params }
    }

    /// The problem.
    pub fn problem(&self) -> Problem<'_> {
        self.problem.problem()
    }

    /// Hands a prepared solver to `work`.
    pub fn with<T: Real, S: Space, R>(&self, exec: &dyn Exec, work: impl FnOnce(&mut Solver<'_, T, S>) -> R) -> R {
        let problem = self.problem();
        let plan = Plan::new::<T, S>(&problem, &self.params).unwrap();
        let mut region = Region::new(plan.bytes()).unwrap();
        let mut solver = Solver::<T, S>::new(&problem, &self.params, region.carve(plan.bytes()).unwrap()).unwrap();
        hand_over(&self.scene, &mut solver).unwrap_or_else(|failure| stop(&failure.to_string()));
        solver.prepare(exec).unwrap();
        work(&mut solver)
    }

    /// The largest Courant number of the velocities as they are.
    pub fn courant<T: Real, S: Space>(&self, solver: &Solver<'_, T, S>) -> f64 {
        let problem = self.problem();
        let grid = problem.grid();
        let mut faces: [Vec<T>; 3] = core::array::from_fn(|axis| if axis < S::DIM { vec![T::ZERO; solver.faces(axis)] } else { Vec::new() });
        let unit = problem.units().velocity;
        let mut of_step = |step: usize| {
            for (axis, faces) in faces.iter_mut().enumerate().take(S::DIM) {
                solver.velocity(step, axis, faces);
            }
            courant_of(&grid, |axis, [x, y, z]| {
                let extent = |a: usize| if a == axis { grid.faces_in_file(a) } else { grid.n[a] };
                faces[axis][(z * extent(1) + y) * extent(0) + x].to_f64() / unit
            })
        };
        (0..problem.steps).map(&mut of_step).fold(0.0, f64::max)
    }
}

fn stop(message: &str) -> ! {
    eprintln!("{message}");
    std::process::exit(2)
}
